//! Studies: one scene with many options, what each costs and how far it is off.
//!
//! A [`Subject`] is a scene and what its runs are compared by; [`Lists`] say which options are tried. [`SceneStudy::conduct`] makes the
//! [`SceneReference`], one run for the values of each row, and one or several for its time. Runs for values go in parallel, those for times
//! one after the other with nothing beside them. A [`Store`] keeps every result as it comes; [`report`] makes tables, pictures and a
//! page of them.

pub(crate) mod comparison;
pub(crate) mod fineness;
pub mod grid;
pub mod monitor;
pub(crate) mod motion;
mod pictures;
pub(crate) mod reference;
pub mod report;
pub(crate) mod row;
pub(crate) mod setting;
pub(crate) mod store;
pub(crate) mod subject;
pub(crate) mod sweep;
mod verdict;

use std::collections::VecDeque;
use std::num::NonZeroUsize;
use std::sync::Mutex;

use dcb_report::{Candidate, cheapest_within, pareto_front};

use crate::shard::Shard;
use crate::workers::{lock, on_threads};
use dcb_runtime::error::Error;
pub use fineness::Fineness;
use grid::{Grid, Trace};
use monitor::Monitor;
pub use reference::SceneReference;
pub use row::SceneRow;
pub use setting::{ModeCount, Setting};
pub use store::Store;
pub use subject::Subject;
pub use sweep::{Combination, Lists, by_command_line, no_radius};

/// A study that is done.
pub struct SceneStudy {
    /// Subject of the study.
    pub subject: Subject,
    /// The times of comparison.
    pub grid: Grid,
    /// Reference of the rows.
    pub reference: SceneReference,
    /// Its values.
    pub reference_trace: Trace,
    /// The rows, in the order of the settings.
    pub rows: Vec<SceneRow>,
    /// Their values.
    pub traces: Vec<Trace>,
    /// How many runs for values went beside each other.
    pub threads: usize,
}

/// What is run.
#[derive(Clone, Copy, Debug)]
pub struct Plan<'a> {
    /// The rows of the study.
    pub settings: &'a [Setting],
    /// The share of them that is made here.
    pub shard: Shard,
    /// The options with which the reference begins.
    pub first: Setting,
    /// The times of comparison.
    pub grid: Grid,
}

/// How far a study came.
pub enum Conducted {
    /// To its end.
    Complete(Box<SceneStudy>),
    /// As far as this share goes: so many rows of all are there.
    Shared {
        /// Rows that are there.
        made: usize,
        /// Rows of all shares.
        of: usize,
    },
    /// Until the user stopped it: what was made until then is in the store.
    Stopped,
}

/// A run to be made for its values.
enum Job {
    Reference,
    Row(Setting),
}

impl SceneStudy {
    /// Makes what isn't in the store yet of a share of the rows; the first share makes the reference too.
    ///
    /// # Errors
    /// The error that stopped the reference; files that can't be read or written. A row that fails is told in the row.
    pub fn conduct(
        subject: Subject,
        plan: Plan<'_>,
        store: &mut Store,
        threads: NonZeroUsize,
        monitor: &Monitor,
    ) -> Result<Conducted, Error> {
        let Plan {
            settings,
            shard,
            first,
            grid,
        } = plan;
        let mut jobs = VecDeque::new();
        if shard.is_first() && store.reference(&subject).is_none() {
            jobs.push_back(Job::Reference);
        }
        for setting in shard.of(settings) {
            if store.course(&subject, setting).is_none() {
                monitor.expect(motion::steps_of(&setting.applied_to(&subject)?)?);
                jobs.push_back(Job::Row(*setting));
            }
        }
        let threads = threads.get().min(jobs.len().max(1));
        make(&subject, first, grid, jobs, store, threads, monitor)?;
        if monitor.is_stopped() || !measure(&subject, shard.of(settings), store, monitor)? {
            return Ok(Conducted::Stopped);
        }
        store.refresh()?;
        Ok(
            match Self::composed(subject, settings, grid, store, threads) {
                Ok(study) => Conducted::Complete(Box::new(study)),
                Err(made) => Conducted::Shared {
                    made,
                    of: settings.len(),
                },
            },
        )
    }

    /// The study of what is in the store, or how many rows are there if some or the reference are missing.
    fn composed(
        subject: Subject,
        settings: &[Setting],
        grid: Grid,
        store: &Store,
        threads: usize,
    ) -> Result<Self, usize> {
        let mut made = Vec::new();
        for setting in settings {
            if let Some((course, trace)) = store.course(&subject, setting)
                && (course.stopped.is_some() || store.timing(setting).is_some())
            {
                made.push((*setting, course, trace));
            }
        }
        let complete = made.len() == settings.len();
        let reference = store.reference(&subject).filter(|_| complete);
        let (reference, reference_trace) = reference.ok_or(made.len())?;
        let (mut rows, mut traces) = (Vec::new(), Vec::new());
        for (setting, course, trace) in made {
            let timing = store.timing(&setting);
            let compared = (&reference, &reference_trace);
            rows.push(SceneRow::of(
                &subject,
                setting,
                (course, &trace),
                timing,
                compared,
            ));
            traces.push(trace);
        }
        Ok(Self {
            subject,
            grid,
            reference,
            reference_trace,
            rows,
            traces,
            threads,
        })
    }

    /// The rows as candidates of the Pareto front: wall time for a unit of simulated time, and largest relative error.
    pub fn candidates(&self) -> Vec<Candidate> {
        let rows = self.rows.iter();
        rows.map(|row| row.candidate(self.label(row), &self.subject, &self.reference))
            .collect()
    }

    /// Rows of the Pareto front, by rising cost.
    pub fn front(&self) -> Vec<usize> {
        pareto_front(&self.candidates())
    }

    /// The fastest row of which no quantity is further off than this part of its range.
    pub fn best(&self, tolerance: f64) -> Option<usize> {
        cheapest_within(&self.candidates(), tolerance)
    }
}

/// Makes the jobs in parallel, and keeps what comes of them; the first failure ends all.
fn make(
    subject: &Subject,
    first: Setting,
    grid: Grid,
    jobs: VecDeque<Job>,
    store: &mut Store,
    threads: usize,
    monitor: &Monitor,
) -> Result<(), Error> {
    monitor.tell("values");
    let (jobs, store) = (Mutex::new(jobs), Mutex::new(store));
    let work = |job: Job| match job {
        Job::Reference => match SceneReference::find(subject, first, grid, monitor)? {
            Some((reference, trace)) => lock(&store).keep_reference(subject, &reference, &trace),
            None => Ok(()),
        },
        Job::Row(setting) => {
            let scene = setting.applied_to(subject)?.into();
            match motion::follow(subject, &scene, grid, monitor, &mut |_| {})? {
                Some((course, trace)) => {
                    lock(&store).keep_course(subject, &setting, &course, &trace)
                }
                None => Ok(()),
            }
        }
    };
    on_threads(threads, || {
        while !monitor.is_stopped() {
            let Some(job) = lock(&jobs).pop_front() else {
                break;
            };
            work(job).inspect_err(|_| monitor.abandon())?;
        }
        Ok(())
    })
}

/// Times the rows that came to their end, one after the other; whether all were.
fn measure<'a>(
    subject: &Subject,
    settings: impl Iterator<Item = &'a Setting>,
    store: &mut Store,
    monitor: &Monitor,
) -> Result<bool, Error> {
    let mut left = Vec::new();
    for setting in settings {
        let course = store.course(subject, setting);
        let is_stable = course.is_some_and(|(course, _)| course.stopped.is_none());
        if is_stable && store.timing(setting).is_none() {
            let scene = setting.applied_to(subject)?;
            let steps = motion::steps_of(&scene)?;
            monitor.expect(steps);
            left.push((setting, scene, steps));
        }
    }
    monitor.tell("times");
    for (setting, scene, steps) in left {
        match motion::time(&scene, monitor)? {
            Some(timing) => store.keep_timing(setting, timing)?,
            None => return Ok(false),
        }
        monitor.advance(steps);
    }
    Ok(true)
}
