//! The options `--eigen-solver`, `--ranks` and `--mpirun` of a reduction.

use clap::{Args, ValueEnum};

use dcb_reducer::EigenSolver;
use dcb_reducer::error::{CommandRefusal, EigenSolverRefusal, Error};

/// Solver for the modes.
#[derive(Debug, Args)]
pub struct EigenSolverArguments {
    /// Solver for the modes.
    #[arg(long, value_name = "NAME", value_enum, default_value_t)]
    eigen_solver: SolverName,
    /// MPI processes of --eigen-solver slepc.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    ranks: Option<u32>,
    /// Command that starts them; `-n N PROGRAM` is added to it [default: mpirun].
    #[arg(long, value_name = "COMMAND")]
    mpirun: Option<String>,
}

/// Solver for the modes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum SolverName {
    /// Block Lanczos, built in.
    #[default]
    BlockLanczos,
    /// SLEPc with MUMPS under mpirun (docs/slepc.md; only in builds with the feature slepc).
    Slepc,
}

impl EigenSolverArguments {
    /// The eigensolver asked for.
    pub(crate) fn chosen(&self) -> Result<EigenSolver, Error> {
        match self.eigen_solver {
            SolverName::Slepc => slepc(self),
            SolverName::BlockLanczos if self.ranks.is_some() || self.mpirun.is_some() => {
                Err(CommandRefusal::from(EigenSolverRefusal::NotSlepc).into())
            }
            SolverName::BlockLanczos => Ok(EigenSolver::BlockLanczos),
        }
    }
}

#[cfg(not(feature = "slepc"))]
fn slepc(_: &EigenSolverArguments) -> Result<EigenSolver, Error> {
    Err(CommandRefusal::from(EigenSolverRefusal::NotBuilt).into())
}

#[cfg(feature = "slepc")]
fn slepc(arguments: &EigenSolverArguments) -> Result<EigenSolver, Error> {
    let ranks =
        (arguments.ranks).ok_or_else(|| CommandRefusal::from(EigenSolverRefusal::NoRanks))?;
    let mut run = dcb_reducer::modes::slepc::SlepcRun::with_ranks(ranks);
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
