//! Results that are not good enough.

/// Why nothing can be concluded from a result.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("not good enough: {}", self.reason())]
pub enum Shortfall {
    /// A reduction breaks limits of its quality.
    Limits(Vec<BrokenLimit>),
    /// The reference of a study leaves more of the unreduced equations than it may.
    ReferenceResidual {
        /// Relative.
        residual: f64,
        /// Relative.
        limit: f64,
    },
    /// The series of a study's reference doesn't converge over the band.
    ReferenceSeries {
        /// Size of the last term, relative to the flexibility.
        left: f64,
        /// Terms that were added.
        terms: usize,
    },
    /// A part can't go without what its scene doesn't ask for.
    LeftOut {
        /// Relative change of the responses.
        change: f64,
        /// Of the tolerance, what is left for it.
        share: f64,
    },
    /// There is no estimate of the error, and why.
    NoEstimate(Option<String>),
    /// The tolerance of a scene isn't reached.
    Tolerance {
        /// Modes of the last attempt.
        modes: usize,
        /// Highest frequency of the scene, in cycles per time.
        frequency: String,
        /// The error that is certified there.
        found: ErrorFound,
        /// The error that is wanted, relative.
        wanted: f64,
        /// Why it isn't smaller.
        limited_by: LimitedBy,
    },
}

/// The error of the last attempt over a scene's frequencies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ErrorFound {
    /// Relative, at least and at most.
    Between(f64, f64),
    /// The modes end below the highest frequency.
    BeyondModes,
    /// There is no bound.
    Unknown,
}

/// Why an error isn't smaller.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LimitedBy {
    /// Rounding in the stiffness matrix.
    Rounding,
    /// The number of modes that are allowed.
    MostModes(usize),
    /// The modes that there are.
    AllModes,
}

impl Shortfall {
    fn reason(&self) -> String {
        match self {
            Self::Limits(broken) => {
                let broken: Vec<String> = broken.iter().map(BrokenLimit::to_string).collect();
                broken.join("; ")
            }
            Self::ReferenceResidual { residual, limit } => format!(
                "the reference leaves {residual:.1e} of the unreduced equations (limit {limit:.0e}); take another band, or check the part for extreme stiffness contrasts"
            ),
            Self::ReferenceSeries { left, terms } => format!(
                "the reference doesn't converge: {left:.1e} is left after {terms} terms; take a band that ends lower"
            ),
            Self::LeftOut { change, share } => format!(
                "what the scene doesn't ask for can't be left out without changing the part's responses by {change:.1e}, and {share:.1e} is left of the tolerance; raise --tolerance"
            ),
            Self::NoEstimate(None) => "no error estimate".to_owned(),
            Self::NoEstimate(Some(why)) => format!("no error estimate: {why}"),
            Self::Tolerance {
                modes,
                frequency,
                found,
                wanted,
                limited_by,
            } => format!(
                "with {modes} modes, over the scene's frequencies up to {frequency}, {}; wanted is {wanted:.1e}, half the tolerance; {}",
                found.sentence(),
                limited_by.remedy()
            ),
        }
    }
}

impl ErrorFound {
    fn sentence(self) -> String {
        match self {
            Self::Between(lower, upper) => {
                format!("the error is certified to be between {lower:.1e} and {upper:.1e}")
            }
            Self::BeyondModes => "the modes don't reach its highest frequency".to_owned(),
            Self::Unknown => "there is no error bound".to_owned(),
        }
    }
}

impl LimitedBy {
    fn remedy(self) -> String {
        match self {
            Self::Rounding => {
                "more modes don't lower it: rounding in the stiffness matrix makes it; raise --tolerance".to_owned()
            }
            Self::MostModes(most) => format!("allow more than --modes {most}, or raise --tolerance"),
            Self::AllModes => "there are no more modes; raise --tolerance".to_owned(),
        }
    }
}

/// A limit of quality that a reduction breaks.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum BrokenLimit {
    /// Modes don't satisfy K φ = ω² M φ closely enough.
    #[error(
        "{refused} of {modes} modes have a residual above the limit {limit:.0e}, the largest {residual:.1e} in mode {worst}"
    )]
    Modes {
        /// How many.
        refused: usize,
        /// Of so many.
        modes: usize,
        /// Number of the worst, from 1.
        worst: usize,
        /// Its relative residual.
        residual: f64,
        /// Of the relative residual.
        limit: f64,
    },
    /// A defect is above its limit.
    #[error("{quantity} is {found:.1e}, above its limit {limit:.0e}")]
    Defect {
        /// Which, with its equation.
        quantity: &'static str,
        /// Dimensionless.
        found: f64,
        /// Dimensionless.
        limit: f64,
    },
    /// The modes are not all that there are.
    #[error("the inertia count finds {counted} eigenvalues where {computed} were computed")]
    Count {
        /// By the factorization.
        counted: usize,
        /// By the iteration.
        computed: usize,
    },
}
