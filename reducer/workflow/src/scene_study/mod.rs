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
use std::sync::{Mutex, mpsc};

use dcb_report::{Candidate, cheapest_within, pareto_front};

use dcb_runtime::error::Error;
use grid::{Grid, Trace};
use monitor::Monitor;
use motion::Course;
pub use reference::SceneReference;
pub use row::SceneRow;
pub use setting::{ModeCount, Setting};
pub use store::Store;
pub use subject::Subject;
pub use sweep::{Combination, Lists};

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

/// A run that was made.
enum JobResult {
    Reference(SceneReference, Trace),
    Row(Setting, Course, Trace),
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
        let Some((reference, reference_trace)) = store.reference(&subject) else {
            return Ok(None);
        };
        let (mut rows, mut traces) = (Vec::new(), Vec::new());
        for setting in settings {
            let Some((course, trace)) = store.course(&subject, setting) else {
                return Ok(None);
            };
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
        rows.map(|row| row.candidate(&self.subject, &self.reference))
            .collect()
    }

    /// Rows that no other beats, by rising cost.
    pub fn front(&self) -> Vec<usize> {
        pareto_front(&self.candidates())
    }

    /// The fastest row of which no quantity is further off than this part of its range.
    pub fn best(&self, tolerance: f64) -> Option<usize> {
        cheapest_within(&self.candidates(), tolerance)
    }
}

/// Makes the jobs in parallel, and keeps what comes of them.
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
    let jobs = Mutex::new(jobs);
    let next = || jobs.lock().ok().and_then(|mut jobs| jobs.pop_front());
    let work = |job: Job| match job {
        Job::Reference => SceneReference::find(subject, first, grid, monitor)
            .map(|found| found.map(|(reference, trace)| JobResult::Reference(reference, trace))),
        Job::Row(setting) => setting
            .applied_to(subject)
            .and_then(|scene| motion::follow(subject, &scene.into(), grid, monitor, &mut |_| {}))
            .map(|made| made.map(|(course, trace)| JobResult::Row(setting, course, trace))),
    };
    let all = |sender: mpsc::Sender<_>| {
        while let Some(job) = next().filter(|_| !monitor.is_stopped()) {
            if sender.send(work(job)).is_err() {
                break;
            }
        }
    };
    std::thread::scope(|scope| {
        let (sender, receiver) = mpsc::channel();
        for started in 0..threads {
            let (own, all) = (sender.clone(), &all);
            let worker = std::thread::Builder::new().spawn_scoped(scope, move || all(own));
            if worker.is_err() {
                if started == 0 {
                    // The system allows no thread: what is made here waits in the channel.
                    all(sender.clone());
                }
                break;
            }
        }
        drop(sender);
        let mut result = Ok(());
        for made in receiver {
            let kept = made.and_then(|made| match made {
                None => Ok(()),
                Some(JobResult::Reference(reference, trace)) => {
                    store.keep_reference(subject, &reference, &trace)
                }
                Some(JobResult::Row(setting, course, trace)) => {
                    store.keep_course(subject, &setting, &course, &trace)
                }
            });
            if kept.is_err() && result.is_ok() {
                monitor.abandon();
                result = kept;
            }
        }
        result
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
