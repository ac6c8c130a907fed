//! From the text of a formula to its program.

use pest::Parser;
use pest::error::{ErrorVariant, InputLocation};
use pest::iterators::Pairs;
use pest::pratt_parser::{Assoc, Op as Operator, PrattParser};

use super::elementary::{CALLABLE, Callable, Pair};
use super::formula::{Constants, Formula, PI_AND_E, Step};
use super::output_formula::Outside;
use crate::Error;
use crate::description::{listed, suggestion};

#[derive(pest_derive::Parser)]
#[grammar = "function/formula.pest"]
struct Grammar;

/// The program of a formula that may name constants.
///
/// # Errors
/// [`Error::Description`] with the formula, the position (from 1, in characters) and what would be right there.
pub(super) fn program_of(
    text: &str,
    constants: &Constants,
    outside: Option<&Outside>,
) -> Result<Vec<Step>, Error> {
    let mut tokens = Grammar::parse(Rule::formula, text).map_err(|error| {
        let start = start_of(&error.location);
        let before = text.get(..start).unwrap_or_default().trim_end();
        let is_power = before.ends_with('*') && text[start..].starts_with('*');
        let what = match is_power {
            true => "powers are written with ^: t^2 instead of t**2".to_owned(),
            false => expectation(&error.variant),
        };
        at(text, start, &what)
    })?;
    let Some(whole) = tokens.next() else {
        return Err(at(text, 0, "is empty"));
    };
    let reader = FormulaReader {
        text,
        constants,
        outside,
        precedence: precedence(),
    };
    reader.expression(whole.into_inner())
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

/// Turns parsed formulas into programs; a subexpression without `t` becomes one number.
struct FormulaReader<'a> {
    text: &'a str,
    constants: &'a Constants,
    outside: Option<&'a Outside>,
    precedence: PrattParser<Rule>,
}

impl FormulaReader<'_> {
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
            Callable::If | Callable::SmoothStep => {
                first.extend(rest.drain(..).flatten());
                let step = match callable {
                    Callable::If => Step::Choose,
                    _ => Step::Rise,
                };
                folded(first, step)
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
        if let Some(index) = self.outside.and_then(|outside| outside.find(name)) {
            return Ok(vec![Step::Variable(index)]);
        }
        if let Some((.., form)) = CALLABLE.iter().find(|(known, ..)| *known == name) {
            let what = format!("the function `{name}` needs brackets: `{form}`");
            return Err(at(self.text, start, &what));
        }
        if let Some(outside) = self.outside {
            return Err(at(self.text, start, &outside.unknown(name, self.constants)));
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
            names().collect::<Vec<_>>().join(", ")
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

/// The parser's expectation where it stopped, in words.
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
            Rule::expression | Rule::number | Rule::name | Rule::quoted | Rule::call => {
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
