//! Why errors can't be given for a band of frequencies.

/// A band, or rows, that errors are asked for and not known.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BandRefusal {
    /// The band, in Hz, reaches the first frequency left out.
    #[error(
        "{superelement}: the band ends at {end:.6} Hz, and errors are known below {bound:.6} Hz, next to the first frequency left out; take a band that ends lower, or keep more modes"
    )]
    BeyondHertz {
        /// Name of the superelement.
        superelement: String,
        /// End of the band, Hz.
        end: f64,
        /// Errors are known below, Hz.
        bound: f64,
    },
    /// A superelement without moments.
    #[error(
        "{superelement}: errors are asked for with --band, but the file has no moments to estimate them from (files before format 1.2 haven't), or no interface; reduce the part again"
    )]
    NoMoments {
        /// Name of the superelement.
        superelement: String,
    },
    /// Hz mean nothing in the superelement's time unit.
    #[error("{superelement}: --band is in Hz, but the time unit {unit:?} is not known")]
    UnknownTimeUnit {
        /// Name of the superelement.
        superelement: String,
        /// The unit.
        unit: String,
    },
}
