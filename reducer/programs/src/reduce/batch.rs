//! The `reduce batch MANIFEST.json` command: many parts, or one in many ways.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::program::print_to_stderr;
use clap::Args;
use dcb_formats::output::is_same_file;

use crate::outcome::Outcome;
use crate::program::CommonArguments;
use crate::reduce::cache::CacheArguments;
use crate::reduce::when_interrupted;
use dcb_reducer::error::{CommandRefusal, Error, Occupied};
use dcb_reducer::resources::memory_limit::{available, size};
use dcb_workflow::batch::child::Processes;
use dcb_workflow::batch::manifest::{Part, read_manifest};
use dcb_workflow::batch::results::RESULTS;
use dcb_workflow::batch::table::{table, word};
use dcb_workflow::batch::{Batch, Earlier, Fate, io_error, run as make};
use dcb_workflow::progress_bar::Display;
use dcb_workflow::shard::Shard;

/// Outputs.
#[derive(Debug, Args)]
pub struct BatchArguments {
    /// Parts and their options (docs/batch.md; `reduce schema batch`).
    #[arg(value_name = "MANIFEST.json")]
    pub manifest: PathBuf,
    /// Folder of the superelements and of results.jsonl [default: MANIFEST.batch].
    #[arg(long, short, value_name = "FOLDER")]
    pub output: Option<PathBuf>,
    /// Parts at a time.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub jobs: u16,
    /// Memory for all of them, for example 64G [default: what the machine has available].
    #[arg(long, value_name = "SIZE", allow_hyphen_values = true, value_parser = size)]
    pub memory: Option<u64>,
    /// Folder of factors on disk [default: the output].
    #[arg(long, value_name = "FOLDER")]
    pub scratch: Option<PathBuf>,
    /// Only every Nth part, beginning with the Ith: array task I of N.
    #[arg(long, value_name = "I/N", allow_hyphen_values = true)]
    pub shard: Option<Shard>,
    /// Make again what is complete and unchanged.
    #[arg(long)]
    pub force: bool,
    #[command(flatten)]
    pub cache: CacheArguments,
    /// Use no cache.
    #[arg(long, conflicts_with_all = ["cache", "cache_limit"])]
    pub no_cache: bool,
}

/// Processes of the batch, which an interruption ends.
static PROCESSES: Processes = Processes::none();
/// Parts that are complete, and how many there are, for the last words of an interrupted batch.
static COMPLETE: AtomicUsize = AtomicUsize::new(0);

pub fn run(arguments: &BatchArguments, common: &CommonArguments) -> Result<Outcome, Error> {
    let mut parts = read_manifest(&arguments.manifest)?;
    if let Some(shard) = arguments.shard {
        parts = shard.of(parts).collect();
    }
    let folder = match &arguments.output {
        Some(folder) => folder.clone(),
        None => arguments.manifest.with_extension("batch"),
    };
    std::fs::create_dir_all(&folder).map_err(|source| {
        io_error(
            &folder,
            "cannot make the folder of the superelements",
            source,
        )
    })?;
    refuse_inputs_as_outputs(&parts, &folder)?;
    let cache = match arguments.no_cache {
        true => None,
        false => arguments.cache.open(common.told())?,
    };
    let jobs = usize::from(arguments.jobs);
    let processors = std::thread::available_parallelism().map_or(1, usize::from);
    let threads = common.threads.map_or(processors, usize::from);
    let batch = Batch {
        parts,
        folder,
        jobs,
        memory: arguments.memory.or_else(available),
        threads: (threads / jobs).max(1),
        scratch: arguments.scratch.clone(),
        cache,
        earlier: if arguments.force {
            Earlier::MakeAgain
        } else {
            Earlier::Keep
        },
        processes: &PROCESSES,
    };
    let count = batch.parts.len();
    when_interrupted(move || {
        PROCESSES.end_all();
        let complete = COMPLETE.load(Ordering::SeqCst);
        format!("{complete} of {count} parts are complete; the same command goes on from there")
    });
    let shows = common.told().display() == Display::Bars;
    let told = |part: &Part, fate: &Fate| {
        if fate.failure().is_none() && *fate != Fate::Elsewhere {
            COMPLETE.fetch_add(1, Ordering::SeqCst);
        }
        if shows {
            print_to_stderr(word(fate), &part.name);
        }
    };
    let fates = make(&batch, &told)?;
    Ok(outcome(&batch, &fates))
}

fn outcome(batch: &Batch, fates: &[Fate]) -> Outcome {
    let failures: Vec<String> = (batch.parts.iter().zip(fates))
        .filter_map(|(part, fate)| Some(format!("{}: {}", part.name, fate.failure()?)))
        .collect();
    let elsewhere = fates
        .iter()
        .filter(|fate| **fate == Fate::Elsewhere)
        .count();
    let mut output = table(&batch.parts, fates);
    if elsewhere > 0 {
        output += &format!("{elsewhere} of them by other processes, which are still at it\n");
    }
    let results = batch.folder.join(RESULTS);
    output += &format!("wrote {}\n", results.display());
    let what = format!("{} of {} parts failed", failures.len(), fates.len());
    Outcome::unless(output, &what, &failures)
}

/// A superelement in the place of a part's own file would destroy it.
fn refuse_inputs_as_outputs(parts: &[Part], folder: &Path) -> Result<(), Error> {
    let is_input = |target: &Path| {
        let mut inputs = parts.iter().flat_map(|part| {
            let entry = &part.entry;
            [
                Some(&entry.part),
                entry.siblings.mass.as_ref(),
                entry.siblings.mesh.as_ref(),
                entry.siblings.boundary.as_ref(),
            ]
        });
        inputs.any(|input| input.is_some_and(|input| is_same_file(input, target)))
    };
    for part in parts {
        let target = folder.join(format!("{}.dcb.h5", part.name));
        if is_input(&target) {
            return Err(CommandRefusal::WouldDestroy {
                path: target,
                role: Occupied::Batch,
            }
            .into());
        }
    }
    Ok(())
}
