//! Studies: one scene with many options, what each costs and how far it is off.
//!
//! A [`Subject`] is a scene and what its runs are compared by; [`Lists`] say which options are tried. [`SceneStudy::conduct`] makes the
//! [`SceneReference`], one run for the values of each row, and one or several for its time. Runs for values go in parallel, those for times
//! one after the other with nothing beside them. A [`Store`] keeps every result as it comes; [`report`] makes tables, pictures and a
//! page of them.

pub(crate) mod comparison;
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

use crate::workers::{lock, on_threads};
use dcb_runtime::error::Error;
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

/// A run to be made for its values.
enum Job {
    Reference,
    Row(Setting),
}

impl SceneStudy {
    /// Makes what isn't in the store yet; `None` if the user stopped it: what was made until then is in the store.
    ///
    /// # Errors
    /// The error that stopped the reference; files that can't be read or written. A row that fails is told in the row.
    pub fn conduct(
        subject: Subject,
        settings: &[Setting],
        first: Setting,
        grid: Grid,
        store: &mut Store,
        threads: NonZeroUsize,
        monitor: &Monitor,
    ) -> Result<Option<Self>, Error> {
        let mut jobs = VecDeque::new();
        if store.reference(&subject).is_none() {
            jobs.push_back(Job::Reference);
        }
        for setting in settings {
            if store.course(&subject, setting).is_none() {
                monitor.expect(motion::steps_of(&setting.applied_to(&subject)?)?);
                jobs.push_back(Job::Row(*setting));
            }
        }
        let threads = threads.get().min(jobs.len().max(1));
        make(&subject, first, grid, jobs, store, threads, monitor)?;
        if monitor.is_stopped() || !measure(&subject, settings, store, monitor)? {
            return Ok(None);
        }
        let (reference, reference_trace) = unless_stopped!(store.reference(&subject));
        let (mut rows, mut traces) = (Vec::new(), Vec::new());
        for setting in settings {
            let (course, trace) = unless_stopped!(store.course(&subject, setting));
            let timing = store.timing(setting);
            let compared = (&reference, &reference_trace);
            rows.push(SceneRow::of(
                &subject,
                *setting,
                (course, &trace),
                timing,
                compared,
            ));
            traces.push(trace);
        }
        Ok(Some(Self {
            subject,
            grid,
            reference,
            reference_trace,
            rows,
            traces,
            threads,
        }))
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
fn measure(
    subject: &Subject,
    settings: &[Setting],
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
