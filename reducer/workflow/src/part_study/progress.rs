//! How far a study is, on a terminal, with the time that is left.

use std::time::Instant;

use dcb_formats::terminal::printable;
use indicatif::ProgressBar;

use crate::progress_bar::{Display, bar, tick};
use dcb_reducer::observer::{Observer, Stage};

/// The fixed part of a reduction's time, in modes.
const FIXED_MODES: usize = 10;

/// A line on standard error. Reductions are expected to take as long as those before, in proportion to their modes.
pub struct Progress {
    bar: ProgressBar,
    start: Instant,
    /// Modes of all reductions that are to be made, each with [`FIXED_MODES`].
    planned: usize,
    done: usize,
}

impl Progress {
    /// For reductions with these numbers of modes.
    pub fn new(display: Display, modes: impl Iterator<Item = usize>) -> Self {
        let planned = modes.map(|modes| modes + FIXED_MODES).sum();
        let bar = bar(display, planned as u64, "{bar:30} {elapsed}  {msg}");
        tick(&bar);
        Self {
            bar,
            start: Instant::now(),
            planned,
            done: 0,
        }
    }

    /// The reference is done; what comes now is timed.
    pub fn begin_rows(&mut self) {
        self.start = Instant::now();
    }

    /// A reduction begins.
    pub fn row(&self, name: &str) {
        let left = match self.time_left() {
            Some(seconds) => format!(", about {} left", readable(seconds)),
            None => String::new(),
        };
        self.bar.set_message(format!("{}{left}", printable(name)));
    }

    /// A reduction with this number of modes is over.
    pub fn row_done(&mut self, modes: usize) {
        self.done += modes + FIXED_MODES;
        self.bar.set_position(self.done as u64);
    }

    fn time_left(&self) -> Option<f64> {
        let rate = self.start.elapsed().as_secs_f64() / self.done as f64;
        (self.done > 0).then(|| rate * self.planned.saturating_sub(self.done) as f64)
    }

    /// Removes the line.
    pub fn clear(&self) {
        self.bar.finish_and_clear();
    }
}

impl Observer for Progress {
    fn begin(&mut self, stage: Stage) {
        self.bar.set_message(format!("reference: {}", stage.name()));
    }

    fn progress(&mut self, _: f64) {}
}

/// `40 s`, `3 min`, `2.5 h`.
fn readable(seconds: f64) -> String {
    match seconds {
        s if s < 90.0 => format!("{s:.0} s"),
        s if s < 5400.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.1} h", s / 3600.0),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_rounded_to_what_a_reader_needs() {
        assert_eq!(readable(41.7), "42 s");
        assert_eq!(readable(200.0), "3 min");
        assert_eq!(readable(9000.0), "2.5 h");
    }
}
