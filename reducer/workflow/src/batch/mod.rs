//! `reduce batch`: many parts, or one in many ways, each in a process of its own.
//!
//! ```text
//! FOLDER/NAME.dcb.h5        the superelements
//! FOLDER/results.jsonl      one line for each part that was made or failed; the last one of a name counts
//! FOLDER/.locks/NAME        held by who makes NAME; empty; stays
//! ```
//!
//! Any number of processes, on any number of machines, may share a folder: each makes the parts that nobody else is at. What is there
//! already, from the same files with the same options, is left alone, so that a batch which was interrupted goes on where it ended.

pub mod child;
pub(crate) mod command;
pub mod manifest;
pub(crate) mod memory_share;
pub(crate) mod part;
pub mod results;
pub mod table;

use std::collections::VecDeque;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use self::child::Processes;
use self::manifest::Part;
use self::memory_share::MemoryShare;
use self::part::Making;
use self::results::{BatchRow, Results, Status};
use crate::cache::Cache;
use crate::lock_file;
use crate::workers::{lock, on_threads};
use dcb_reducer::error::Error;

/// Tasks, place and resources of a batch.
#[derive(Clone, Debug)]
pub struct Batch {
    /// Parts.
    pub parts: Vec<Part>,
    /// Folder of the superelements.
    pub folder: PathBuf,
    /// Processes at a time.
    pub jobs: usize,
    /// Memory that they may take together, bytes.
    pub memory: Option<u64>,
    /// Threads of each.
    pub threads: usize,
    /// Folder of a factor on disk.
    pub scratch: Option<PathBuf>,
    /// Cache that they use.
    pub cache: Option<Cache>,
    /// Treatment of earlier results.
    pub earlier: Earlier,
    /// The processes, which somebody else may end.
    pub processes: &'static Processes,
}

/// Treatment of earlier rows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Earlier {
    /// Leave alone what is complete and unchanged.
    Keep,
    /// Make everything again.
    MakeAgain,
}

/// Outcome of a component.
#[derive(Clone, Debug, PartialEq)]
pub enum Fate {
    /// Made, or failed, now.
    Settled(Box<BatchRow>),
    /// Complete and unchanged.
    Unchanged(Box<BatchRow>),
    /// Another process is at it.
    Elsewhere,
}

/// Runs a batch; `told` hears of each part as it is done. The fates are in the order of the parts.
///
/// # Errors
/// The folder or its results can't be used. A part that fails is no error.
pub fn run(batch: &Batch, told: &(dyn Fn(&Part, &Fate) + Sync)) -> Result<Vec<Fate>, Error> {
    let locks = batch.folder.join(".locks");
    std::fs::create_dir_all(&locks).map_err(|source| io_error(&locks, "cannot make", source))?;
    let shared = Shared {
        batch,
        results: Mutex::new(Results::open(&batch.folder)?),
        queue: Mutex::new((0..batch.parts.len()).collect()),
        memory: batch.memory.map(MemoryShare::of),
        planning: Mutex::new(()),
    };
    let fates = Mutex::new(vec![None; batch.parts.len()]);
    let count = batch.jobs.clamp(1, batch.parts.len().max(1));
    on_threads(count, || -> Result<(), Error> {
        while let Some(index) = shared.next() {
            let part = &batch.parts[index];
            let fate = shared.settle(part)?;
            told(part, &fate);
            lock(&fates)[index] = Some(fate);
        }
        Ok(())
    })?;
    let fates = fates.into_inner().unwrap_or_else(PoisonError::into_inner);
    Ok(fates.into_iter().flatten().collect())
}

/// State that the workers share.
struct Shared<'a> {
    batch: &'a Batch,
    results: Mutex<Results>,
    queue: Mutex<VecDeque<usize>>,
    memory: Option<MemoryShare>,
    /// Held while a forecast is made, of which there is one at a time.
    planning: Mutex<()>,
}

impl Shared<'_> {
    fn next(&self) -> Option<usize> {
        lock(&self.queue).pop_front()
    }

    /// Makes a part, unless that was done or is being done.
    fn settle(&self, part: &Part) -> Result<Fate, Error> {
        let path = self.batch.folder.join(".locks").join(&part.name);
        let failed = |source| io_error(&path, "cannot lock", source);
        let Some(claim) = lock_file::claimed(&path).map_err(failed)? else {
            return Ok(Fate::Elsewhere);
        };
        let making = Making::prepare(self.batch, part);
        let known = {
            let mut results = lock(&self.results);
            results.refresh()?;
            results.row(&part.name).cloned()
        };
        if let Some((row, age)) = known
            && making.is_settled_by(&row, age)
        {
            return Ok(Fate::Unchanged(Box::new(row)));
        }
        making.remove_leftovers();
        let lent = claim.try_clone().map_err(failed)?;
        let row = making.make(lent, self.memory.as_ref(), &self.planning)?;
        // The claim ends when others can see the row.
        lock(&self.results).add(row.clone())?;
        drop(claim);
        Ok(Fate::Settled(Box::new(row)))
    }
}

impl Fate {
    /// Whether the part failed, and why.
    pub fn failure(&self) -> Option<&str> {
        match self {
            Self::Settled(row) | Self::Unchanged(row) if row.status == Status::Failed => {
                Some(row.error.as_deref().unwrap_or("failed"))
            }
            _ => None,
        }
    }
}

/// A file that the system refused.
pub fn io_error(path: &Path, action: &'static str, source: std::io::Error) -> Error {
    dcb_formats::Error::io(path, action, source).into()
}
