//! The options `--ranks` and `--mpirun`.

use clap::Args;

use crate::reduce::memory::MemoryArguments;
use dcb_reducer::error::{CommandRefusal, Error, RanksRefusal};
use dcb_reducer::resources::memory_limit::{FactorChoice, MemoryLimit};

/// Processes that hold the factor.
#[derive(Debug, Args)]
pub struct RanksArguments {
    /// Keep the factor in the memory of N MPI processes (docs/ranks.md; feature ranks).
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    ranks: Option<u32>,
    /// Command that starts them; `-n N PROGRAM FOLDER` is added to it [default: mpirun].
    #[arg(long, value_name = "COMMAND")]
    mpirun: Option<String>,
}

impl RanksArguments {
    /// Has the factor kept by the processes asked for.
    pub(crate) fn enter(
        &self,
        memory: &MemoryArguments,
        limit: &mut MemoryLimit,
    ) -> Result<(), Error> {
        let refused = |why: RanksRefusal| Err(CommandRefusal::from(why).into());
        match (self.ranks, &self.mpirun) {
            (None, None) => Ok(()),
            (None, Some(_)) => refused(RanksRefusal::NoRanks),
            (Some(_), _) if memory.factor != FactorChoice::Auto => {
                refused(RanksRefusal::OtherPlace)
            }
            (Some(ranks), mpirun) => match keep_on(ranks, mpirun.as_deref(), memory, limit) {
                Ok(()) => Ok(()),
                Err(why) => refused(why),
            },
        }
    }

    /// How many are asked for.
    pub(crate) fn count(&self) -> Option<u32> {
        self.ranks
    }
}

#[cfg(not(feature = "ranks"))]
fn keep_on(
    _: u32,
    _: Option<&str>,
    _: &MemoryArguments,
    _: &mut MemoryLimit,
) -> Result<(), RanksRefusal> {
    Err(RanksRefusal::NotBuilt)
}

#[cfg(feature = "ranks")]
fn keep_on(
    ranks: u32,
    mpirun: Option<&str>,
    memory: &MemoryArguments,
    limit: &mut MemoryLimit,
) -> Result<(), RanksRefusal> {
    let mut run = dcb_sparse::ranks::RanksRun::with_ranks(ranks);
    if let Some(command) = mpirun {
        run.launcher = words(command).ok_or(RanksRefusal::NoLauncher)?;
    }
    if let Some(folder) = &memory.scratch {
        run.scratch = folder.clone();
    }
    limit.ranks = Some(run);
    Ok(())
}

/// The words of a command, as blanks separate them; single and double quotes keep blanks in a word. `None` if there is
/// no word or a quote is left open.
#[cfg(feature = "ranks")]
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

#[cfg(all(test, feature = "ranks"))]
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
