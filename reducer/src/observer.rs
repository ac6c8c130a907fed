//! How a caller follows a reduction: which stage runs, how far it is. Clocks, bars and printing are the caller's.

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
}

/// Nobody is watching.
impl Observer for () {
    fn begin(&mut self, _: Stage) {}
    fn progress(&mut self, _: f64) {}
}
