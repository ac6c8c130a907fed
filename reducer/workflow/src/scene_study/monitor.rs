//! Progress of a study, seen by every thread that works on it.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use dcb_formats::terminal::printable;
use indicatif::ProgressBar;

/// Where progress is shown, and who asks for an end.
#[derive(Clone)]
pub struct Monitor {
    bar: ProgressBar,
    is_interrupted: fn() -> bool,
    is_abandoned: Arc<AtomicBool>,
}

impl Monitor {
    /// The bar counts steps; `is_interrupted` says whether the user wants an end.
    pub fn new(bar: ProgressBar, is_interrupted: fn() -> bool) -> Self {
        Self {
            bar,
            is_interrupted,
            is_abandoned: Arc::default(),
        }
    }

    /// More steps are to be made than was known.
    pub fn expect(&self, steps: u64) {
        self.bar.inc_length(steps);
    }

    /// Steps were made, or won't be.
    pub fn advance(&self, steps: u64) {
        self.bar.inc(steps);
    }

    /// Present activity.
    pub fn tell(&self, message: &str) {
        self.bar.set_message(printable(message).into_owned());
    }

    /// Takes the bar away.
    pub fn close(&self) {
        self.bar.finish_and_clear();
    }

    /// Makes everybody stop: what they do is of no use any more.
    pub fn abandon(&self) {
        self.is_abandoned.store(true, Ordering::SeqCst);
    }

    /// Whether to stop.
    pub fn is_stopped(&self) -> bool {
        (self.is_interrupted)() || self.is_abandoned.load(Ordering::SeqCst)
    }
}
