//! How a caller follows a reduction: which stage runs, how far it is, and whether it is to go on. Clocks, bars and printing are the caller's.

use crate::error::Error;
use crate::resources::forecast::Forecast;
use crate::resources::memory_limit::MemoryLimit;
pub use crate::resources::stage::Stage;

/// Told what a reduction is doing.
pub trait Observer {
    /// A stage begins; the one before is over.
    fn begin(&mut self, stage: Stage);
    /// The running stage has done about this share of its work, 0 to 1.
    fn progress(&mut self, share: f64);
    /// Cost of the reduction, before the first factorization.
    fn forecast(&mut self, _: &Forecast, _: &MemoryLimit) {}
    /// Whether the reduction is to end without a result. It is asked between stages and between blocks of work.
    fn is_stopped(&self) -> bool {
        false
    }
}

impl dyn Observer + '_ {
    /// Begins a stage.
    ///
    /// # Errors
    /// [`Error::Interrupted`] where the observer asks to end.
    pub fn enter(&mut self, stage: Stage) -> Result<(), Error> {
        self.begin(stage);
        self.ask()
    }

    /// Goes on within a stage.
    ///
    /// # Errors
    /// As for a stage that begins.
    pub fn advance(&mut self, share: f64) -> Result<(), Error> {
        self.progress(share);
        self.ask()
    }

    fn ask(&mut self) -> Result<(), Error> {
        match self.is_stopped() {
            true => Err(Error::Interrupted),
            false => Ok(()),
        }
    }
}

/// Nobody is watching.
impl Observer for () {
    fn begin(&mut self, _: Stage) {}
    fn progress(&mut self, _: f64) {}
}
