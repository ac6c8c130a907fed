//! Functions that a formula may call, of second-order dual numbers, which carry first and second derivatives.

use num_dual::{Dual2_64, DualNum};

/// Functions of one number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Elementary {
    Sin,
    Cos,
    Tan,
    Asin,
    Acos,
    Atan,
    Sinh,
    Cosh,
    Tanh,
    Exp,
    Ln,
    Log10,
    Sqrt,
    Abs,
    /// -1, 0 or 1.
    Sign,
    /// 0 below zero, 1 from zero on.
    Step,
    Not,
}

/// Functions of two numbers; of a comparison 1 where it is true and 0 where not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pair {
    Add,
    Subtract,
    Multiply,
    Divide,
    /// Both base and exponent vary.
    Power,
    Min,
    Max,
    Atan2,
    Below,
    AtMost,
    Above,
    AtLeast,
    And,
    Or,
}

/// Meaning of a name before a bracket.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Callable {
    One(Elementary),
    /// Exactly two arguments.
    Two(Pair),
    /// Two or more: the pairs from left to right.
    Many(Pair),
    /// A condition and what holds where it is true and where not.
    If,
    /// A number, and where the rise from 0 to 1 over it begins and ends.
    SmoothStep,
}

/// Names, what they call, and how a call is written.
pub const CALLABLE: [(&str, Callable, &str); 24] = [
    ("sin", Callable::One(Elementary::Sin), "sin(x)"),
    ("cos", Callable::One(Elementary::Cos), "cos(x)"),
    ("tan", Callable::One(Elementary::Tan), "tan(x)"),
    ("asin", Callable::One(Elementary::Asin), "asin(x)"),
    ("acos", Callable::One(Elementary::Acos), "acos(x)"),
    ("atan", Callable::One(Elementary::Atan), "atan(x)"),
    ("sinh", Callable::One(Elementary::Sinh), "sinh(x)"),
    ("cosh", Callable::One(Elementary::Cosh), "cosh(x)"),
    ("tanh", Callable::One(Elementary::Tanh), "tanh(x)"),
    ("exp", Callable::One(Elementary::Exp), "exp(x)"),
    ("ln", Callable::One(Elementary::Ln), "ln(x)"),
    ("log10", Callable::One(Elementary::Log10), "log10(x)"),
    ("sqrt", Callable::One(Elementary::Sqrt), "sqrt(x)"),
    ("abs", Callable::One(Elementary::Abs), "abs(x)"),
    ("sign", Callable::One(Elementary::Sign), "sign(x)"),
    ("step", Callable::One(Elementary::Step), "step(x)"),
    (
        "smooth_step",
        Callable::SmoothStep,
        "smooth_step(t, start, end)",
    ),
    ("not", Callable::One(Elementary::Not), "not(condition)"),
    ("atan2", Callable::Two(Pair::Atan2), "atan2(y, x)"),
    ("min", Callable::Many(Pair::Min), "min(x, y, ...)"),
    ("max", Callable::Many(Pair::Max), "max(x, y, ...)"),
    (
        "and",
        Callable::Many(Pair::And),
        "and(condition, condition, ...)",
    ),
    (
        "or",
        Callable::Many(Pair::Or),
        "or(condition, condition, ...)",
    ),
    ("if", Callable::If, "if(condition, value, otherwise)"),
];

impl Callable {
    /// Whether it takes so many arguments.
    pub fn takes(self, count: usize) -> bool {
        match self {
            Self::One(_) => count == 1,
            Self::Two(_) => count == 2,
            Self::Many(_) => count >= 2,
            Self::If | Self::SmoothStep => count == 3,
        }
    }
}

/// The chain rule: f(x(t)) from f, f' and f'' at x.
fn chain(x: Dual2_64, f: f64, slope: f64, curvature: f64) -> Dual2_64 {
    Dual2_64::new(f, slope * x.v1, slope * x.v2 + curvature * x.v1 * x.v1)
}

/// x^p for a number p, finite also at x = 0 where the derivatives are.
pub fn raised(x: Dual2_64, exponent: f64) -> Dual2_64 {
    let term = |factor: f64, power: f64| {
        if factor == 0.0 {
            0.0
        } else {
            factor * x.re.powf(power)
        }
    };
    chain(
        x,
        x.re.powf(exponent),
        term(exponent, exponent - 1.0),
        term(exponent * (exponent - 1.0), exponent - 2.0),
    )
}

fn truth(is_true: bool) -> Dual2_64 {
    Dual2_64::from_re(if is_true { 1.0 } else { 0.0 })
}

impl Elementary {
    /// Its value and derivatives.
    pub fn of(self, x: Dual2_64) -> Dual2_64 {
        match self {
            Self::Sin => x.sin(),
            Self::Cos => x.cos(),
            Self::Tan => x.tan(),
            Self::Asin => x.asin(),
            Self::Acos => x.acos(),
            Self::Atan => x.atan(),
            Self::Sinh => x.sinh(),
            Self::Cosh => x.cosh(),
            Self::Tanh => x.tanh(),
            Self::Exp => x.exp(),
            Self::Ln => x.ln(),
            Self::Log10 => x.log10(),
            Self::Sqrt => raised(x, 0.5),
            Self::Abs => chain(x, x.re.abs(), x.re.signum(), 0.0),
            _ if x.re.is_nan() => Dual2_64::from_re(f64::NAN),
            Self::Sign if x.re == 0.0 => Dual2_64::from_re(0.0),
            Self::Sign => Dual2_64::from_re(x.re.signum()),
            Self::Step => truth(x.re >= 0.0),
            Self::Not => truth(x.re == 0.0),
        }
    }
}

impl Elementary {
    /// On which side of its kink or jump it is, where it has one.
    pub fn decision(self, x: f64) -> Option<bool> {
        match self {
            Self::Abs | Self::Sign | Self::Step => Some(x >= 0.0),
            Self::Not => Some(x == 0.0),
            _ => None,
        }
    }
}

impl Pair {
    /// On which side of its kink or jump it is, where it has one.
    pub fn decision(self, x: f64, y: f64) -> Option<bool> {
        match self {
            Self::Min | Self::Below | Self::AtLeast => Some(x < y),
            Self::Max | Self::Above | Self::AtMost => Some(x > y),
            Self::And | Self::Or => {
                Some(self.of(Dual2_64::from_re(x), Dual2_64::from_re(y)).re != 0.0)
            }
            _ => None,
        }
    }

    /// Its value and derivatives.
    pub fn of(self, left: Dual2_64, right: Dual2_64) -> Dual2_64 {
        let (x, y) = (left.re, right.re);
        match self {
            Self::Add => left + right,
            Self::Subtract => left - right,
            Self::Multiply => left * right,
            Self::Divide => left / right,
            Self::Power => Dual2_64 {
                re: x.powf(y),
                ..(left.ln() * right).exp()
            },
            Self::Atan2 => angle(left, right),
            // What isn't a number stays so.
            _ if x.is_nan() || y.is_nan() => Dual2_64::from_re(f64::NAN),
            Self::Min => {
                if y < x {
                    right
                } else {
                    left
                }
            }
            Self::Max => {
                if y > x {
                    right
                } else {
                    left
                }
            }
            Self::Below => truth(x < y),
            Self::AtMost => truth(x <= y),
            Self::Above => truth(x > y),
            Self::AtLeast => truth(x >= y),
            Self::And => truth(x != 0.0 && y != 0.0),
            Self::Or => truth(x != 0.0 || y != 0.0),
        }
    }

    /// Whether it compares two numbers.
    pub fn is_comparison(self) -> bool {
        matches!(
            self,
            Self::Below | Self::AtMost | Self::Above | Self::AtLeast
        )
    }
}

/// The rise from 0 at the start to 1 at the end, 10 s³ - 15 s⁴ + 6 s⁵: its rate and second rate vanish at both. With the end before the start it is a fall.
pub fn risen(x: Dual2_64, start: Dual2_64, end: Dual2_64) -> Dual2_64 {
    let x = (x - start) / (end - start);
    let s = x.re;
    match s {
        ..=0.0 => Dual2_64::from_re(0.0),
        1.0.. => Dual2_64::from_re(1.0),
        _ => chain(
            x,
            s * s * s * (10.0 + s * (-15.0 + 6.0 * s)),
            30.0 * (s * (1.0 - s)).powi(2),
            60.0 * s * (1.0 - s) * (1.0 - 2.0 * s),
        ),
    }
}

/// The value where a condition holds, or the other.
pub fn chosen(condition: Dual2_64, value: Dual2_64, otherwise: Dual2_64) -> Dual2_64 {
    if condition.re.is_nan() {
        condition
    } else if condition.re != 0.0 {
        value
    } else {
        otherwise
    }
}

/// The angle of the point (x, y), from -π to π: its rate is (x y' - y x')/r².
fn angle(y: Dual2_64, x: Dual2_64) -> Dual2_64 {
    let square = x.re * x.re + y.re * y.re;
    let swept = x.re * y.v1 - y.re * x.v1;
    let rate = swept / square;
    let receding = x.re * x.v1 + y.re * y.v1;
    let second = (x.re * y.v2 - y.re * x.v2) / square - 2.0 * rate * receding / square;
    Dual2_64::new(y.re.atan2(x.re), rate, second)
}
