//! The options `--eigen-solver`, `--ranks` and `--mpirun` of a reduction.

use crate::EigenSolver;
use crate::cli::{ReduceArguments, SolverName};
use crate::error::{CommandRefusal, EigenSolverRefusal, Error};

/// The eigensolver asked for.
///
/// # Errors
/// [`Error::Command`] for options that don't go together, or that this build doesn't have.
pub fn eigen_solver(arguments: &ReduceArguments) -> Result<EigenSolver, Error> {
    match arguments.eigen_solver {
        SolverName::Slepc => slepc(arguments),
        SolverName::BlockLanczos if arguments.ranks.is_some() || arguments.mpirun.is_some() => {
            Err(CommandRefusal::from(EigenSolverRefusal::NotSlepc).into())
        }
        SolverName::BlockLanczos => Ok(EigenSolver::BlockLanczos),
    }
}

#[cfg(not(feature = "slepc"))]
fn slepc(_: &ReduceArguments) -> Result<EigenSolver, Error> {
    Err(CommandRefusal::from(EigenSolverRefusal::NotBuilt).into())
}

#[cfg(feature = "slepc")]
fn slepc(arguments: &ReduceArguments) -> Result<EigenSolver, Error> {
    let ranks =
        (arguments.ranks).ok_or_else(|| CommandRefusal::from(EigenSolverRefusal::NoRanks))?;
    let mut run = crate::slepc::SlepcRun::with_ranks(ranks);
    if let Some(command) = &arguments.mpirun {
        run.launcher =
            words(command).ok_or_else(|| CommandRefusal::from(EigenSolverRefusal::NoLauncher))?;
    }
    Ok(EigenSolver::Slepc(run))
}

/// The words of a command, as blanks separate them; single and double quotes keep blanks in a word. `None` if there is
/// no word or a quote is left open.
#[cfg(feature = "slepc")]
fn words(command: &str) -> Option<Vec<String>> {
    let mut words: Vec<String> = Vec::new();
    let (mut in_word, mut quote) = (false, None);
    for letter in command.chars() {
        match quote {
            Some(end) if letter == end => quote = None,
            None if letter.is_whitespace() => in_word = false,
            _ => {
                if !in_word {
                    words.push(String::new());
                    in_word = true;
                }
                if quote.is_none() && matches!(letter, '"' | '\'') {
                    quote = Some(letter);
                } else {
                    words.last_mut()?.push(letter);
                }
            }
        }
    }
    (quote.is_none() && !words.is_empty()).then_some(words)
}

#[cfg(all(test, feature = "slepc"))]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::words;

    #[test]
    fn a_command_is_cut_at_blanks_outside_quotes() {
        for (command, expected) in [
            ("mpirun", &["mpirun"][..]),
            ("  srun  --mpi=pmix ", &["srun", "--mpi=pmix"]),
            (
                "mpirun --hostfile 'my hosts' -x A=\"b 'c'\"",
                &["mpirun", "--hostfile", "my hosts", "-x", "A=b 'c'"],
            ),
            ("mpirun ''", &["mpirun", ""]),
        ] {
            assert_eq!(words(command).unwrap(), expected, "{command}");
        }
        for command in ["", "  ", "mpirun 'hosts"] {
            assert_eq!(words(command), None, "{command}");
        }
    }
}
