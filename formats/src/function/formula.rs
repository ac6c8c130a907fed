//! A formula in the time `t`, with its first and second derivative.
//!
//! The text is parsed once into a short program in postfix order. Running the program on second-order dual numbers gives the
//! value and both derivatives exactly and at once, on a stack of fixed size.
//!
//! Powers bind tighter than a sign and group from the right, as on paper: `-t^2` is -(t²), `2^3^2` is 2⁹.

use num_dual::Dual2_64;

use super::FunctionValue;
use super::elementary::{CALLABLE, Elementary, Pair, chosen, raised, risen};
use super::formula_parser::program_of;
use super::output_formula::Outside;
use crate::Error;

/// Longest formula, bytes: bounds the depth of the parser's recursion.
const LONGEST: usize = 1000;

/// Intermediate results that a formula may need at a time.
const STACK_SIZE: usize = 32;

/// Times at which changes of branches are looked for, and how many are told at most.
const SAMPLES: usize = 4096;
const MOST_BREAKS: usize = 1 << 12;

/// A checked formula, ready to be evaluated.
#[derive(Clone, Debug, PartialEq)]
pub struct Formula {
    pub(super) program: Vec<Step>,
}

/// One step of the program; operands are taken from the top of the stack.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Step {
    Number(f64),
    Time,
    /// A value from outside, by its index.
    Variable(usize),
    Negate,
    /// The exponent is a number: the base may be zero or negative.
    PowerOf(f64),
    Call(Elementary),
    Pair(Pair),
    /// Of a condition and two values, the one that holds.
    Choose,
    /// Of a number, and where a rise from 0 to 1 over it begins and ends, the height of the rise.
    Rise,
}

/// Names for numbers, beside the names of functions.
pub(super) type Constants = [(String, f64)];

pub(super) const PI_AND_E: [(&str, f64); 2] =
    [("pi", std::f64::consts::PI), ("e", std::f64::consts::E)];

/// Refuses a constant that a formula couldn't name.
///
/// # Errors
/// [`Error::Description`] that says why.
pub fn check_constant(name: &str, value: f64) -> Result<(), Error> {
    let refused = |message: String| Err(Error::described(name, message));
    let mut letters = name.chars();
    let is_name = letters
        .next()
        .is_some_and(|first| first.is_ascii_alphabetic() || first == '_')
        && letters.all(|letter| letter.is_ascii_alphanumeric() || letter == '_');
    if !is_name {
        return refused("is no name: expected letters a to z, digits and _, a letter first".into());
    }
    if name == "t" {
        return refused("is the time; expected another name".into());
    }
    if PI_AND_E.iter().any(|(known, _)| *known == name) {
        return refused("is a constant already; expected another name".into());
    }
    if CALLABLE.iter().any(|(known, ..)| *known == name) {
        return refused("is a function of formulas; expected another name".into());
    }
    match value.is_finite() {
        true => Ok(()),
        false => refused(format!("is {value}, expected a finite number")),
    }
}

impl Formula {
    /// Parses a formula that may name constants.
    ///
    /// # Errors
    /// [`Error::Description`] with the formula, the position (from 1, in characters) and what would be right there.
    pub fn parse(text: &str, constants: &Constants) -> Result<Self, Error> {
        if text.len() > LONGEST {
            return Err(too_long(text));
        }
        Self::checked(text, program_of(text, constants, None)?)
    }

    /// The same with a list of names that formulas don't know by themselves.
    ///
    /// # Errors
    /// As [`Formula::parse`].
    pub(super) fn parse_with(
        text: &str,
        constants: &Constants,
        outside: &Outside,
    ) -> Result<Self, Error> {
        if text.len() > LONGEST {
            return Err(too_long(text));
        }
        Self::checked(text, program_of(text, constants, Some(outside))?)
    }

    fn checked(text: &str, program: Vec<Step>) -> Result<Self, Error> {
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
        self.run(time, |_| {})
    }

    /// Times from zero to `end` at which a branch changes: where the formula may jump or bend. Of changes closer to each other than a
    /// 4096th of the end some may be overlooked.
    pub fn breaks(&self, end: f64) -> Vec<f64> {
        let branches = |step: &Step| match step {
            Step::Call(function) => function.decision(0.0).is_some(),
            Step::Pair(pair) => pair.decision(0.0, 0.0).is_some(),
            _ => false,
        };
        let mut breaks = Vec::new();
        if !self.program.iter().any(branches) {
            return breaks;
        }
        let time = |sample: usize| end * sample as f64 / SAMPLES as f64;
        for sample in 0..SAMPLES {
            let (mut low, high) = (time(sample), time(sample + 1));
            let after = self.decisions(high);
            let mut before = self.decisions(low);
            while before != after && breaks.len() < MOST_BREAKS {
                // The first change that halving meets.
                let mut beyond = high;
                loop {
                    let middle = 0.5 * (low + beyond);
                    if middle <= low || middle >= beyond {
                        break;
                    }
                    match self.decisions(middle) == before {
                        true => low = middle,
                        false => beyond = middle,
                    }
                }
                breaks.push(beyond);
                (low, before) = (beyond, self.decisions(beyond));
            }
        }
        breaks
    }

    /// Which way all branches go, as one number.
    fn decisions(&self, time: f64) -> u64 {
        let mut all: u64 = 1;
        self.run(time, |decision| {
            all = all.wrapping_mul(3).wrapping_add(u64::from(decision));
        });
        all
    }

    /// Value and derivative by the time, with values from outside as dual numbers. Does not allocate.
    pub(super) fn evaluate_with(
        &self,
        time: f64,
        variable: impl Fn(usize) -> Dual2_64,
    ) -> Dual2_64 {
        self.steps(Dual2_64::from_re(time), variable, |_| {}).0
    }

    /// Value, rounding, and what is decided on the way.
    fn run(&self, time: f64, decide: impl FnMut(bool)) -> (FunctionValue, f64) {
        let time = Dual2_64::from_re(time).derivative();
        let (found, largest) = self.steps(time, |_| Dual2_64::from_re(f64::NAN), decide);
        let result = FunctionValue {
            value: found.re,
            rate: found.v1,
            second_rate: found.v2,
        };
        let sensitivity = (time.re * result.rate).abs();
        (result, 4.0 * f64::EPSILON * largest.max(sensitivity))
    }

    /// The result, and the largest number on the way to it.
    fn steps(
        &self,
        time: Dual2_64,
        variable: impl Fn(usize) -> Dual2_64,
        mut decide: impl FnMut(bool),
    ) -> (Dual2_64, f64) {
        let mut largest = 0.0_f64;
        let mut stack = [Dual2_64::from_re(0.0); STACK_SIZE];
        let mut height = 0;
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
                Step::Variable(index) => {
                    stack[height] = variable(*index);
                    height += 1;
                }
                Step::Negate => stack[top] = -stack[top],
                Step::PowerOf(exponent) => stack[top] = raised(stack[top], *exponent),
                Step::Call(function) => {
                    if let Some(decision) = function.decision(stack[top].re) {
                        decide(decision);
                    }
                    stack[top] = function.of(stack[top]);
                }
                Step::Pair(pair) => {
                    if let Some(decision) = pair.decision(stack[below].re, stack[top].re) {
                        decide(decision);
                    }
                    stack[below] = pair.of(stack[below], stack[top]);
                    height -= 1;
                }
                Step::Choose | Step::Rise => {
                    let first = height.max(3) - 3;
                    let of = match step {
                        Step::Rise => risen,
                        _ => chosen,
                    };
                    stack[first] = of(stack[first], stack[below], stack[top]);
                    height -= 2;
                }
            }
            largest = largest.max(stack[height - 1].re.abs());
        }
        (stack[0], largest)
    }
}

fn too_long(text: &str) -> Error {
    Error::described(
        "formula",
        format!(
            "has {} bytes, more than {LONGEST}; a table holds longer functions",
            text.len()
        ),
    )
}

/// The largest number of intermediate results that the program holds.
fn stack_needed(program: &[Step]) -> usize {
    let mut height = 0_usize;
    let mut needed = 0;
    for step in program {
        match step {
            Step::Number(_) | Step::Time | Step::Variable(_) => height += 1,
            Step::Negate | Step::PowerOf(_) | Step::Call(_) => {}
            Step::Pair(_) => height -= 1,
            Step::Choose | Step::Rise => height -= 2,
        }
        needed = needed.max(height);
    }
    needed
}
