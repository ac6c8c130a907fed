//! One part of a batch: whether it was made before, what it needs, and its process.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Mutex;
use std::time::{Instant, SystemTime, UNIX_EPOCH};

use dcb_formats::component_files::ComponentFiles;
use dcb_formats::dcb::SuperelementFile;
use dcb_formats::output::remove_leftovers;
use serde_json::Value;

use super::child::Ended;
use super::command;
use super::manifest::Part;
use super::memory_share::MemoryShare;
use super::results::{Age, BatchRow, BatchSuperelement, Status};
use super::{Batch, Earlier, io_error};
use crate::cache::request::digest_of;
use crate::cache::{Key, Request};
use crate::workers::lock;
use dcb_reducer::error::Error;

/// A part about to be made.
pub struct Making<'a> {
    batch: &'a Batch,
    part: &'a Part,
    /// Options that decide the result, and options that decide the file; or why the part's files can't be read.
    request: Result<(Request, Key), Error>,
}

impl<'a> Making<'a> {
    /// Hashes the part's files.
    pub fn prepare(batch: &'a Batch, part: &'a Part) -> Self {
        let request = || {
            let entry = &part.entry;
            let files = ComponentFiles::beside(&entry.part, &entry.siblings.overrides())?;
            let request = Request::new(&files.sources()?, entry.modes.request(), &entry.reduction);
            let key = digest_of(&(&request, entry.form));
            Ok((request, key))
        };
        Self {
            batch,
            part,
            request: request(),
        }
    }

    fn key(&self) -> Option<&Key> {
        self.request.as_ref().ok().map(|(_, key)| key)
    }

    fn file_name(&self) -> PathBuf {
        PathBuf::from(format!("{}.dcb.h5", self.part.name))
    }

    fn target(&self) -> PathBuf {
        self.batch.folder.join(self.file_name())
    }

    /// Where the process says what it took.
    fn timings(&self) -> PathBuf {
        self.batch
            .folder
            .join(format!(".{}.timings", self.part.name))
    }

    /// Whether a row says what there is to say: it came since this batch began, or is of the superelement that is there, made of the same.
    pub fn is_settled_by(&self, row: &BatchRow, age: Age) -> bool {
        let is_unchanged = || {
            let made = row.superelement.as_ref();
            row.status == Status::Done
                && row.key.as_ref() == self.key()
                && made.is_some_and(|made| {
                    let file = SuperelementFile::open(self.batch.folder.join(&made.file));
                    file.is_ok_and(|file| file.digest() == made.digest)
                })
        };
        match (age, self.batch.earlier) {
            (Age::Since, _) => row.status == Status::Failed || is_unchanged(),
            (Age::Before, Earlier::Keep) => is_unchanged(),
            (Age::Before, Earlier::MakeAgain) => false,
        }
    }

    /// Removes what a killed process left of this part; who calls holds its lock.
    pub fn remove_leftovers(&self) {
        remove_leftovers(&self.target());
        remove_leftovers(&self.timings());
        let _ = std::fs::remove_file(self.timings());
    }

    /// Makes the part in a process of its own, which keeps the claim even if this one is killed.
    pub fn make(
        &self,
        claim: File,
        memory: Option<&MemoryShare>,
        planning: &Mutex<()>,
    ) -> Result<BatchRow, Error> {
        if let Err(error) = &self.request {
            return Ok(self.failed(error.to_string(), Some(2)));
        }
        let needed = match memory {
            Some(_) if self.batch.jobs > 1 && !self.is_cached() => {
                let _one_at_a_time = lock(planning);
                self.needed_memory()?
            }
            _ => Ok(0),
        };
        let needed = match needed {
            Ok(bytes) => bytes,
            Err(refusal) => return Ok(self.failed(refusal, Some(2))),
        };
        let _share = memory.map(|memory| memory.take(needed));
        let start = Instant::now();
        let timings = self.timings();
        let command = command::reduce(self.batch, self.part, &self.target(), &timings);
        let ended = self.run(command, claim.into())?;
        let costs: Option<Value> = std::fs::read(&timings)
            .ok()
            .and_then(|text| serde_json::from_slice(&text).ok());
        let _ = std::fs::remove_file(&timings);
        let mut row = self.row_of(&ended, costs.as_ref());
        row.seconds = start.elapsed().as_secs_f64();
        Ok(row)
    }

    fn run(&self, command: std::io::Result<Command>, stdin: Stdio) -> Result<Ended, Error> {
        let run = |mut command: Command| self.batch.processes.run(command.stdin(stdin));
        let cannot_start = |source| io_error(Path::new("reduce"), "cannot start", source);
        command.and_then(run).map_err(cannot_start)
    }

    /// Whether it only needs to be copied.
    fn is_cached(&self) -> bool {
        match (&self.batch.cache, &self.request) {
            (Some(cache), Ok((request, _))) => cache.has(&request.key()),
            _ => false,
        }
    }

    /// Memory that the part is forecast to need, bytes, or why it can't be reduced with what there is. What can't be forecast is left to
    /// fail by itself.
    fn needed_memory(&self) -> Result<Result<u64, String>, Error> {
        let command = command::plan(self.batch, self.part);
        let ended = self.run(command, Stdio::null())?;
        let Ok(plan) = serde_json::from_str::<Value>(&ended.stdout) else {
            return Ok(Ok(0));
        };
        if let Some(refusal) = plan["refusal"].as_str() {
            return Ok(Err(refusal.to_owned()));
        }
        let chosen = plan["choices"]
            .as_array()
            .into_iter()
            .flatten()
            .find(|choice| choice["factor"] == plan["chosen"]);
        Ok(Ok(chosen
            .and_then(|choice| choice["peak_bytes"].as_u64())
            .unwrap_or(0)))
    }

    fn failed(&self, error: String, exit_status: Option<i32>) -> BatchRow {
        BatchRow {
            name: self.part.name.clone(),
            part: self.part.entry.part.clone(),
            status: Status::Failed,
            error: Some(error),
            exit_status,
            key: self.key().cloned(),
            superelement: None,
            seconds: 0.0,
            peak_megabytes: None,
            warnings: Vec::new(),
            ended: SystemTime::now()
                .duration_since(UNIX_EPOCH)
                .map_or(0, |duration| duration.as_secs()),
        }
    }

    fn row_of(&self, ended: &Ended, costs: Option<&Value>) -> BatchRow {
        let said = |kind: &str| -> Vec<String> {
            let lines = ended.stderr.lines();
            lines
                .filter_map(|line| line.strip_prefix(kind).map(str::to_owned))
                .collect()
        };
        let made = match ended.status.success() {
            true => self.made(costs),
            false => Err(match said("error: ").pop() {
                Some(error) => error,
                None => format!("the reduction ended with {}", ended.status),
            }),
        };
        let stages = costs.and_then(|costs| costs["stages"].as_array());
        let peak = stages.into_iter().flatten();
        let peak_megabytes = peak
            .filter_map(|stage| stage["peak_megabytes"].as_f64())
            .reduce(f64::max);
        let row = match made {
            Ok(made) => BatchRow {
                status: Status::Done,
                superelement: Some(made),
                ..self.failed(String::new(), Some(0))
            },
            Err(error) => self.failed(error, ended.status.code()),
        };
        BatchRow {
            error: row.error.filter(|error| !error.is_empty()),
            peak_megabytes,
            warnings: said("warning: "),
            ..row
        }
    }

    fn made(&self, costs: Option<&Value>) -> Result<BatchSuperelement, String> {
        let read = || -> Result<_, dcb_formats::Error> {
            let file = SuperelementFile::open(self.target())?;
            let element = file.superelement()?;
            Ok((file, element))
        };
        let (file, element) = read().map_err(|error| error.to_string())?;
        Ok(BatchSuperelement {
            file: self.file_name(),
            digest: file.digest().to_owned(),
            modes: element.mode_count(),
            rows: element.boundary_row_count(),
            rank: element.residual.sigma_squared.len(),
            from_cache: costs.is_some_and(|costs| costs["work"].is_null()),
        })
    }
}
