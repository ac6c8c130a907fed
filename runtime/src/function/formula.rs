//! A formula in the time `t`, with its first and second derivative.
//!
//! The text is parsed once into a short program in postfix order. Running the program on second-order dual numbers gives the
//! value and both derivatives exactly and at once, on a stack of fixed size.
//!
//! Powers bind tighter than a sign and group from the right, as on paper: `-t^2` is -(t²), `2^3^2` is 2⁹.

use dcb_formats::description::{listed, suggestion};
use num_dual::{Dual2_64, DualNum};
use pest::Parser;
use pest::error::{ErrorVariant, InputLocation};
use pest::iterators::Pairs;
use pest::pratt_parser::{Assoc, Op as Operator, PrattParser};

use super::FunctionValue;
use crate::Error;

/// Longest formula, bytes: bounds the depth of the parser's recursion.
const LONGEST: usize = 1000;

/// Intermediate results that a formula may need at a time.
const STACK_SIZE: usize = 32;

#[derive(pest_derive::Parser)]
#[grammar = "function/formula.pest"]
struct Grammar;

/// A checked formula, ready to be evaluated.
#[derive(Clone, Debug, PartialEq)]
pub struct Formula {
    program: Vec<Step>,
}

/// One step of the program; operands are taken from the top of the stack.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Step {
    Number(f64),
    Time,
    Add,
    Subtract,
    Multiply,
    Divide,
    Negate,
    /// Both base and exponent are on the stack.
    Power,
    /// The exponent is a number: the base may be zero or negative.
    PowerOf(f64),
    Call(Elementary),
}

/// The functions that a formula may call.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Elementary {
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
}

const ELEMENTARY: [(&str, Elementary); 14] = [
    ("sin", Elementary::Sin),
    ("cos", Elementary::Cos),
    ("tan", Elementary::Tan),
    ("asin", Elementary::Asin),
    ("acos", Elementary::Acos),
    ("atan", Elementary::Atan),
    ("sinh", Elementary::Sinh),
    ("cosh", Elementary::Cosh),
    ("tanh", Elementary::Tanh),
    ("exp", Elementary::Exp),
    ("ln", Elementary::Ln),
    ("log10", Elementary::Log10),
    ("sqrt", Elementary::Sqrt),
    ("abs", Elementary::Abs),
];

impl Formula {
    /// Parses a formula.
    ///
    /// # Errors
    /// [`Error::Description`] with the formula, the position (from 1, in characters) and what would be right there.
    pub fn parse(text: &str) -> Result<Self, Error> {
        if text.len() > LONGEST {
            return Err(Error::described(
                "formula",
                format!(
                    "has {} bytes, more than {LONGEST}; a table holds longer functions",
                    text.len()
                ),
            ));
        }
        let mut tokens = Grammar::parse(Rule::formula, text).map_err(|error| {
            at(
                text,
                start_of(&error.location),
                &expectation(&error.variant),
            )
        })?;
        let Some(whole) = tokens.next() else {
            return Err(at(text, 0, "is empty"));
        };
        let program = compiled(text, whole.into_inner())?;
        let needed = stack_needed(&program);
        if needed > STACK_SIZE {
            return Err(Error::described(
                "formula",
                format!(
                    "{text:?} needs {needed} intermediate results at a time, more than {STACK_SIZE}; \
                     put the deep brackets first"
                ),
            ));
        }
        Ok(Self { program })
    }

    /// Value and derivatives; not finite where the formula is not. Does not allocate.
    pub fn evaluate(&self, time: f64) -> FunctionValue {
        self.evaluate_with_rounding(time).0
    }

    /// Value and derivatives, and about how much rounding there may be in the value.
    pub fn evaluate_with_rounding(&self, time: f64) -> (FunctionValue, f64) {
        let mut largest = 0.0_f64;
        let mut stack = [Dual2_64::from_re(0.0); STACK_SIZE];
        let mut height = 0;
        let time = Dual2_64::from_re(time).derivative();
        for step in &self.program {
            let (top, below) = (height.max(1) - 1, height.max(2) - 2);
            match step {
                Step::Number(number) => {
                    stack[height] = Dual2_64::from_re(*number);
                    height += 1;
                }
                Step::Time => {
                    stack[height] = time;
                    height += 1;
                }
                Step::Negate => stack[top] = -stack[top],
                Step::PowerOf(exponent) => stack[top] = raised(stack[top], *exponent),
                Step::Call(function) => stack[top] = function.of(stack[top]),
                Step::Add | Step::Subtract | Step::Multiply | Step::Divide | Step::Power => {
                    let (left, right) = (stack[below], stack[top]);
                    stack[below] = match step {
                        Step::Add => left + right,
                        Step::Subtract => left - right,
                        Step::Multiply => left * right,
                        Step::Divide => left / right,
                        _ => Dual2_64 {
                            re: left.re.powf(right.re),
                            ..(left.ln() * right).exp()
                        },
                    };
                    height -= 1;
                }
            }
            largest = largest.max(stack[height - 1].re.abs());
        }
        let result = FunctionValue {
            value: stack[0].re,
            rate: stack[0].v1,
            second_rate: stack[0].v2,
        };
        let sensitivity = (time.re * result.rate).abs();
        (result, 4.0 * f64::EPSILON * largest.max(sensitivity))
    }
}

/// The chain rule: f(x(t)) from f, f' and f'' at x.
fn chain(x: Dual2_64, f: f64, slope: f64, curvature: f64) -> Dual2_64 {
    Dual2_64::new(f, slope * x.v1, slope * x.v2 + curvature * x.v1 * x.v1)
}

/// x^p for a number p, finite also at x = 0 where the derivatives are.
fn raised(x: Dual2_64, exponent: f64) -> Dual2_64 {
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

impl Elementary {
    fn of(self, x: Dual2_64) -> Dual2_64 {
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
        }
    }
}

/// The program of a parsed formula; a part without `t` becomes one number.
fn compiled(text: &str, tokens: Pairs<Rule>) -> Result<Vec<Step>, Error> {
    let precedence = PrattParser::new()
        .op(Operator::infix(Rule::add, Assoc::Left) | Operator::infix(Rule::subtract, Assoc::Left))
        .op(Operator::infix(Rule::multiply, Assoc::Left)
            | Operator::infix(Rule::divide, Assoc::Left))
        .op(Operator::prefix(Rule::minus) | Operator::prefix(Rule::plus))
        .op(Operator::infix(Rule::power, Assoc::Right));
    expression(text, tokens, &precedence)
}

fn expression(
    text: &str,
    tokens: Pairs<Rule>,
    precedence: &PrattParser<Rule>,
) -> Result<Vec<Step>, Error> {
    precedence
        .map_primary(|token| match token.as_rule() {
            Rule::expression => expression(text, token.into_inner(), precedence),
            Rule::number => number(text, token.as_span().start(), token.as_str()),
            Rule::call => {
                let mut inner = token.into_inner();
                match (inner.next(), inner.next()) {
                    (Some(name), Some(argument)) => {
                        let function = elementary(text, name.as_span().start(), name.as_str())?;
                        let argument = expression(text, argument.into_inner(), precedence)?;
                        Ok(folded(argument, Step::Call(function)))
                    }
                    _ => Err(at(text, 0, "a function needs one argument")),
                }
            }
            _ => named(text, token.as_span().start(), token.as_str()),
        })
        .map_prefix(|sign, operand| {
            Ok(match sign.as_rule() {
                Rule::minus => folded(operand?, Step::Negate),
                _ => operand?,
            })
        })
        .map_infix(|left, operator, right| {
            let (mut left, right) = (left?, right?);
            let step = match (operator.as_rule(), &right[..]) {
                (Rule::power, [Step::Number(exponent)]) => {
                    return Ok(folded(left, Step::PowerOf(*exponent)));
                }
                (Rule::add, _) => Step::Add,
                (Rule::subtract, _) => Step::Subtract,
                (Rule::multiply, _) => Step::Multiply,
                (Rule::divide, _) => Step::Divide,
                _ => Step::Power,
            };
            left.extend(right);
            Ok(folded(left, step))
        })
        .parse(tokens)
}

/// The operands followed by the step; evaluated now if no operand depends on the time.
fn folded(mut operands: Vec<Step>, step: Step) -> Vec<Step> {
    let constant = operands
        .iter()
        .all(|operand| matches!(operand, Step::Number(_)));
    operands.push(step);
    if constant {
        let value = Formula { program: operands }.evaluate(0.0).value;
        operands = vec![Step::Number(value)];
    }
    operands
}

fn number(text: &str, start: usize, digits: &str) -> Result<Vec<Step>, Error> {
    match digits.parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(vec![Step::Number(number)]),
        _ => Err(at(text, start, &format!("{digits} is too large a number"))),
    }
}

fn named(text: &str, start: usize, name: &str) -> Result<Vec<Step>, Error> {
    match name {
        "t" => Ok(vec![Step::Time]),
        "pi" => Ok(vec![Step::Number(std::f64::consts::PI)]),
        "e" => Ok(vec![Step::Number(std::f64::consts::E)]),
        _ if ELEMENTARY.iter().any(|(known, _)| *known == name) => Err(at(
            text,
            start,
            &format!("the function `{name}` needs brackets: `{name}(t)`"),
        )),
        _ => Err(at(
            text,
            start,
            &format!("`{name}` is not known; the only variable is t, the constants are pi and e"),
        )),
    }
}

fn elementary(text: &str, start: usize, name: &str) -> Result<Elementary, Error> {
    match ELEMENTARY.iter().find(|(known, _)| *known == name) {
        Some((_, function)) => Ok(*function),
        None => {
            let names = || ELEMENTARY.iter().map(|(known, _)| *known);
            let hint = match name {
                "log" => "; write ln or log10".to_owned(),
                _ => suggestion(name, names()),
            };
            Err(at(
                text,
                start,
                &format!(
                    "`{name}` is not a known function{hint} (known: {})",
                    listed(names())
                ),
            ))
        }
    }
}

/// The largest number of intermediate results that the program holds.
fn stack_needed(program: &[Step]) -> usize {
    let mut height = 0_usize;
    let mut needed = 0;
    for step in program {
        match step {
            Step::Number(_) | Step::Time => height += 1,
            Step::Negate | Step::PowerOf(_) | Step::Call(_) => {}
            Step::Add | Step::Subtract | Step::Multiply | Step::Divide | Step::Power => height -= 1,
        }
        needed = needed.max(height);
    }
    needed
}

/// A fault at a byte of the formula.
fn at(text: &str, byte: usize, what: &str) -> Error {
    let position = text
        .char_indices()
        .take_while(|(start, _)| *start < byte)
        .count()
        + 1;
    Error::described("formula", format!("{text:?}, position {position}: {what}"))
}

fn start_of(location: &InputLocation) -> usize {
    match location {
        InputLocation::Pos(start) | InputLocation::Span((start, _)) => *start,
    }
}

/// What the parser wanted where it stopped, in words.
fn expectation(variant: &ErrorVariant<Rule>) -> String {
    let ErrorVariant::ParsingError { positives, .. } = variant else {
        return "is not a formula".into();
    };
    let mut wanted: Vec<&str> = Vec::new();
    for rule in positives {
        let word = match rule {
            Rule::EOI => "the end",
            Rule::add | Rule::subtract | Rule::multiply | Rule::divide | Rule::power => {
                "one of + - * / ^"
            }
            Rule::expression | Rule::number | Rule::name | Rule::call => {
                "a number, t, a function or a bracket"
            }
            _ => continue,
        };
        if !wanted.contains(&word) {
            wanted.push(word);
        }
    }
    if wanted.is_empty() {
        wanted.push("a closing bracket");
    }
    format!("expected {}", wanted.join(" or "))
}
