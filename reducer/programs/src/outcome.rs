//! How a command ended, and how the program ends with it.

use std::fmt::Display;

use crate::program::{Told, print_to_stderr, print_to_stdout};
use crate::stop_signal::{StopSignal, received};

/// Reasons named in a failure.
const NAMED_REASONS: usize = 5;

/// Output of a command.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Outcome {
    /// For standard output.
    pub output: String,
    /// Whether all was done.
    pub ending: Ending,
}

/// Whether all was done.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Ending {
    /// It was.
    Complete,
    /// A check did not hold: the reasons, for standard error.
    Failed(String),
    /// The user stopped it.
    Interrupted,
}

impl Outcome {
    /// All is well.
    pub fn done(output: String) -> Self {
        let ending = Ending::Complete;
        Self { output, ending }
    }

    /// The user stopped it.
    pub fn interrupted(output: String) -> Self {
        let ending = Ending::Interrupted;
        Self { output, ending }
    }

    /// All is well if there is no reason why not.
    pub fn unless(output: String, what: &str, reasons: &[String]) -> Self {
        if reasons.is_empty() {
            return Self::done(output);
        }
        let named = reasons[..reasons.len().min(NAMED_REASONS)].join("; ");
        let more = match reasons.len().saturating_sub(NAMED_REASONS) {
            0 => String::new(),
            more => format!("; and {more} more"),
        };
        let ending = Ending::Failed(format!("{what}: {named}{more}"));
        Self { output, ending }
    }
}

/// Prints what a command said, if the user is told; the exit status. What comes before the last words is called in any case.
pub(crate) fn ended<E: Display + From<dcb_formats::Error>>(
    outcome: Result<Outcome, E>,
    told: Told,
    is_unusable_input: fn(&E) -> bool,
    before_last_words: fn(),
) -> u8 {
    let ending = outcome.and_then(|outcome| {
        if told == Told::Everything {
            print_to_stdout(&outcome.output)?;
        }
        Ok(outcome.ending)
    });
    before_last_words();
    let (status, error) = match ending {
        Ok(Ending::Complete) => return 0,
        Ok(Ending::Interrupted) => {
            let signal = received().unwrap_or(StopSignal::Interrupt);
            return signal.exit_status();
        }
        Ok(Ending::Failed(why)) => (1, why),
        Err(error) => (
            if is_unusable_input(&error) { 2 } else { 1 },
            error.to_string(),
        ),
    };
    print_to_stderr("error", &error);
    status
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failure_is_one_message_however_many_the_reasons() {
        let reasons: Vec<String> = (1..=7).map(|number| format!("reason {number}")).collect();
        let failed = Outcome::unless(String::new(), "part.mtx: refused", &reasons).ending;
        let expected =
            "part.mtx: refused: reason 1; reason 2; reason 3; reason 4; reason 5; and 2 more";
        assert_eq!(failed, Ending::Failed(expected.into()));
        let well = Outcome::unless("well".into(), "part.mtx: refused", &[]);
        assert_eq!(well, Outcome::done("well".into()));
    }
}
