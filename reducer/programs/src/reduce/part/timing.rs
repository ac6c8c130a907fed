//! Wall time, processor time and peak memory of each stage, and the progress bars of a terminal.

use std::time::Instant;

use crate::program::print_to_stderr;
use dcb_formats::out_of_memory::at_stage;
use dcb_workflow::progress_bar::{Display, bar, tick};
use indicatif::ProgressBar;
use serde::Serialize;

use crate::reduce::plan;
use dcb_reducer::observer::{Observer, Stage};
use dcb_reducer::resources::forecast::Forecast;
use dcb_reducer::resources::machine_speed::MachineSpeed;
use dcb_reducer::resources::memory_limit::MemoryLimit;

/// Time of one stage.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StageTime {
    /// Name of the stage.
    pub stage: String,
    /// Wall time, s.
    pub seconds: f64,
    /// Processor time of all threads, s; absent where the system doesn't tell.
    pub processor_seconds: Option<f64>,
    /// Largest resident memory of the process up to its end, MB; absent where the system doesn't tell.
    pub peak_megabytes: Option<f64>,
}

struct Running {
    stage: String,
    start: Instant,
    processor_start: Option<f64>,
}

/// Times the stages of a reduction and of the reading and writing around it.
pub struct StageClock {
    finished: Vec<StageTime>,
    running: Option<Running>,
    bar: ProgressBar,
    announces: bool,
}

/// Steps of a bar.
const BAR_STEPS: u64 = 1000;

impl StageClock {
    /// A clock with nothing running.
    pub fn new(display: Display) -> Self {
        let bar = bar(
            display,
            BAR_STEPS,
            "{msg:12} {bar:40} {percent:>3} %  {elapsed}",
        );
        Self {
            finished: Vec::new(),
            running: None,
            bar,
            announces: false,
        }
    }

    /// Prints the forecast before work starts.
    pub fn announce_forecast(&mut self) {
        self.announces = true;
    }

    /// Ends the running stage and starts one by name.
    pub fn start(&mut self, name: &str) {
        self.stop();
        at_stage(name);
        self.bar.reset();
        self.bar.set_message(name.to_owned());
        tick(&self.bar);
        self.running = Some(Running {
            stage: name.to_owned(),
            start: Instant::now(),
            processor_start: processor_seconds(),
        });
    }

    /// Ends the running stage.
    pub fn stop(&mut self) {
        if let Some(running) = self.running.take() {
            let time = StageTime {
                stage: running.stage,
                seconds: running.start.elapsed().as_secs_f64(),
                processor_seconds: processor_seconds()
                    .zip(running.processor_start)
                    .map(|(now, start)| now - start),
                peak_megabytes: peak_memory_megabytes(),
            };
            // A stage that runs again (a second factorization) adds to its row.
            match self
                .finished
                .iter_mut()
                .find(|known| known.stage == time.stage)
            {
                Some(known) => {
                    known.seconds += time.seconds;
                    known.processor_seconds = known
                        .processor_seconds
                        .zip(time.processor_seconds)
                        .map(|(before, more)| before + more);
                    known.peak_megabytes = time.peak_megabytes;
                }
                None => self.finished.push(time),
            }
        }
    }

    /// The stages so far.
    pub fn stages(&self) -> &[StageTime] {
        &self.finished
    }

    /// Removes the bar.
    pub fn clear(&mut self) {
        self.stop();
        self.bar.finish_and_clear();
    }
}

impl Observer for StageClock {
    fn begin(&mut self, stage: Stage) {
        self.start(stage.name());
    }

    fn progress(&mut self, share: f64) {
        self.bar
            .set_position((share.clamp(0.0, 1.0) * BAR_STEPS as f64) as u64);
    }

    fn forecast(&mut self, forecast: &Forecast, limit: &MemoryLimit) {
        if self.announces {
            let text = plan::text(forecast, limit, MachineSpeed::measure());
            self.bar
                .suspend(|| print_to_stderr("forecast", &format!("\n{}", text.trim_end())));
        }
    }
}

/// Processor time of the process so far, all threads, s.
#[cfg(unix)]
fn processor_seconds() -> Option<f64> {
    let mut time = libc::timespec {
        tv_sec: 0,
        tv_nsec: 0,
    };
    // SAFETY: the clock is written to a time that lives on.
    let failed = unsafe { libc::clock_gettime(libc::CLOCK_PROCESS_CPUTIME_ID, &raw mut time) } != 0;
    (!failed).then_some(time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64)
}

#[cfg(not(unix))]
fn processor_seconds() -> Option<f64> {
    None
}

/// Largest resident memory of the process so far, MB (Linux).
fn peak_memory_megabytes() -> Option<f64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status
        .lines()
        .find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kilobytes: f64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kilobytes / 1024.0)
}
