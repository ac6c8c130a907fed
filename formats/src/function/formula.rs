//! A formula in the time `t`, with its first and second derivative.
//!
//! The text is parsed once into a short program in postfix order. Running the program on second-order dual numbers gives the
//! value and both derivatives exactly and at once, on a stack of fixed size.
//!
//! Powers bind tighter than a sign and group from the right, as on paper: `-t^2` is -(t²), `2^3^2` is 2⁹.

use crate::description::{listed, suggestion};
use num_dual::Dual2_64;
use pest::Parser;
use pest::error::{ErrorVariant, InputLocation};
use pest::iterators::Pairs;
use pest::pratt_parser::{Assoc, Op as Operator, PrattParser};

use super::FunctionValue;
use super::elementary::{CALLABLE, Callable, Elementary, Pair, chosen, raised};
use crate::Error;

/// Longest formula, bytes: bounds the depth of the parser's recursion.
const LONGEST: usize = 1000;

/// Intermediate results that a formula may need at a time.
const STACK_SIZE: usize = 32;

/// Times at which changes of branches are looked for, and how many are told at most.
const SAMPLES: usize = 4096;
const MOST_BREAKS: usize = 1 << 12;

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
    Negate,
    /// The exponent is a number: the base may be zero or negative.
    PowerOf(f64),
    Call(Elementary),
    Pair(Pair),
    /// Of a condition and two values, the one that holds.
    Choose,
}

/// What names stand for beside functions.
type Constants = [(String, f64)];

const PI_AND_E: [(&str, f64); 2] = [("pi", std::f64::consts::PI), ("e", std::f64::consts::E)];

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
        let reader = Reader {
            text,
            constants,
            precedence: precedence(),
        };
        let program = reader.expression(whole.into_inner())?;
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

    /// Value, rounding, and what is decided on the way.
    fn run(&self, time: f64, mut decide: impl FnMut(bool)) -> (FunctionValue, f64) {
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
                Step::Choose => {
                    let condition = height.max(3) - 3;
                    stack[condition] = chosen(stack[condition], stack[below], stack[top]);
                    height -= 2;
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

fn precedence() -> PrattParser<Rule> {
    let left = |rule| Operator::infix(rule, Assoc::Left);
    PrattParser::new()
        .op(left(Rule::below) | left(Rule::above) | left(Rule::at_most) | left(Rule::at_least))
        .op(left(Rule::add) | left(Rule::subtract))
        .op(left(Rule::multiply) | left(Rule::divide))
        .op(Operator::prefix(Rule::minus) | Operator::prefix(Rule::plus))
        .op(Operator::infix(Rule::power, Assoc::Right))
}

/// Turns parsed formulas into programs; a part without `t` becomes one number.
struct Reader<'a> {
    text: &'a str,
    constants: &'a Constants,
    precedence: PrattParser<Rule>,
}

impl Reader<'_> {
    fn expression(&self, tokens: Pairs<Rule>) -> Result<Vec<Step>, Error> {
        self.precedence
            .map_primary(|token| match token.as_rule() {
                Rule::expression => self.expression(token.into_inner()),
                Rule::number => number(self.text, token.as_span().start(), token.as_str()),
                Rule::call => self.call(token.into_inner()),
                _ => self.named(token.as_span().start(), token.as_str()),
            })
            .map_prefix(|sign, operand| {
                Ok(match sign.as_rule() {
                    Rule::minus => folded(operand?, Step::Negate),
                    _ => operand?,
                })
            })
            .map_infix(|left, operator, right| {
                let (mut left, right) = (left?, right?);
                let pair = match (operator.as_rule(), &right[..]) {
                    (Rule::power, [Step::Number(exponent)]) => {
                        return Ok(folded(left, Step::PowerOf(*exponent)));
                    }
                    (Rule::add, _) => Pair::Add,
                    (Rule::subtract, _) => Pair::Subtract,
                    (Rule::multiply, _) => Pair::Multiply,
                    (Rule::divide, _) => Pair::Divide,
                    (Rule::below, _) => Pair::Below,
                    (Rule::above, _) => Pair::Above,
                    (Rule::at_most, _) => Pair::AtMost,
                    (Rule::at_least, _) => Pair::AtLeast,
                    _ => Pair::Power,
                };
                let compares = |side: &[Step]| matches!(side.last(), Some(Step::Pair(last)) if last.is_comparison());
                if pair.is_comparison() && (compares(&left) || compares(&right)) {
                    let start = operator.as_span().start();
                    let what = "a comparison of a comparison; write and(0 < t, t < 1) for 0 < t < 1";
                    return Err(at(self.text, start, what));
                }
                left.extend(right);
                Ok(folded(left, Step::Pair(pair)))
            })
            .parse(tokens)
    }

    fn call(&self, mut tokens: Pairs<Rule>) -> Result<Vec<Step>, Error> {
        let Some(name) = tokens.next() else {
            return Err(at(self.text, 0, "a function needs a name"));
        };
        let (start, name) = (name.as_span().start(), name.as_str());
        let (callable, form) = self.callable(start, name)?;
        let arguments: Result<Vec<_>, _> = tokens
            .map(|token| self.expression(token.into_inner()))
            .collect();
        let mut arguments = arguments?;
        let count = arguments.len();
        if !callable.takes(count) {
            let s = if count == 1 { "" } else { "s" };
            let what = format!("`{name}` is given {count} argument{s}; write {form}");
            return Err(at(self.text, start, &what));
        }
        let mut rest = arguments.split_off(1);
        let mut first = arguments.pop().unwrap_or_default();
        Ok(match callable {
            Callable::One(function) => folded(first, Step::Call(function)),
            Callable::Two(pair) | Callable::Many(pair) => {
                rest.into_iter().fold(first, |mut left, right| {
                    left.extend(right);
                    folded(left, Step::Pair(pair))
                })
            }
            Callable::If => {
                first.extend(rest.drain(..).flatten());
                folded(first, Step::Choose)
            }
        })
    }

    fn named(&self, start: usize, name: &str) -> Result<Vec<Step>, Error> {
        if name == "t" {
            return Ok(vec![Step::Time]);
        }
        let own = self
            .constants
            .iter()
            .map(|(name, value)| (&name[..], *value));
        let known = || PI_AND_E.into_iter().chain(own.clone());
        if let Some((_, value)) = known().find(|(known, _)| *known == name) {
            return Ok(vec![Step::Number(value)]);
        }
        if let Some((.., form)) = CALLABLE.iter().find(|(known, ..)| *known == name) {
            let what = format!("the function `{name}` needs brackets: `{form}`");
            return Err(at(self.text, start, &what));
        }
        let hint = suggestion(name, self.constants.iter().map(|(name, _)| &name[..]));
        let what = format!(
            "`{name}` is not known{hint}; the only variable is t, the constants are {} and those under \"constants\" of the scene",
            listed(known().map(|(name, _)| name))
        );
        Err(at(self.text, start, &what))
    }

    fn callable(&self, start: usize, name: &str) -> Result<(Callable, &'static str), Error> {
        let found = CALLABLE.iter().find(|(known, ..)| *known == name);
        if let Some((_, callable, form)) = found {
            return Ok((*callable, form));
        }
        let names = || CALLABLE.iter().map(|(known, ..)| *known);
        let hint = match name {
            "log" => "; write ln or log10".to_owned(),
            _ => suggestion(name, names()),
        };
        let what = format!(
            "`{name}` is not a known function{hint} (known: {})",
            listed(names())
        );
        Err(at(self.text, start, &what))
    }
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

/// The largest number of intermediate results that the program holds.
fn stack_needed(program: &[Step]) -> usize {
    let mut height = 0_usize;
    let mut needed = 0;
    for step in program {
        match step {
            Step::Number(_) | Step::Time => height += 1,
            Step::Negate | Step::PowerOf(_) | Step::Call(_) => {}
            Step::Pair(_) => height -= 1,
            Step::Choose => height -= 2,
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
            Rule::add
            | Rule::subtract
            | Rule::multiply
            | Rule::divide
            | Rule::power
            | Rule::below
            | Rule::above
            | Rule::at_most
            | Rule::at_least => "one of + - * / ^ < <= > >=",
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
