//! Why a reduction could not be made. Unusable input and numerical failure are told apart, because a caller reacts to
//! them differently.

mod band;
mod body;
mod command;
mod interface;
mod lacking;
mod matrix;
mod places;
mod shortfall;

use std::path::PathBuf;

use dcb_formats::component_files::ComponentFiles;

pub use self::band::BandRefusal;
pub use self::body::{BodyRefusal, PieceSize, Softness};
pub use self::command::{CommandRefusal, Occupied, RanksRefusal};
pub use self::interface::InterfaceRefusal;
pub use self::lacking::Lacking;
pub use self::matrix::{Matrix, MatrixRefusal, StressRow};
pub(crate) use self::places::LISTED;
pub use self::places::Places;
pub use self::shortfall::{BrokenLimit, ErrorFound, LimitedBy, Shortfall};
use dcb_formats::units::readable;

/// A reduction that ended without a superelement.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// An interface that the component can't have.
    #[error(transparent)]
    Interface(#[from] InterfaceRefusal),
    /// A matrix that isn't what a part has.
    #[error(transparent)]
    Matrix(#[from] MatrixRefusal),
    /// The part is no free elastic body in one piece.
    #[error(transparent)]
    Body(#[from] BodyRefusal),
    /// The component lacks what is asked of it.
    #[error(transparent)]
    Lacking(#[from] Lacking),
    /// Errors aren't known in this band, or at these rows.
    #[error(transparent)]
    Band(#[from] BandRefusal),
    /// Options, files and folders of a command don't go together.
    #[error(transparent)]
    Command(#[from] CommandRefusal),
    /// Defect of the component, and its file.
    #[error("{}: {source}", path.display())]
    In {
        /// The file.
        path: PathBuf,
        /// Defect.
        source: Box<Self>,
    },
    /// All is done but the list of what it took.
    #[error("the superelement is complete, but the timings can't be written: {0}")]
    Timings(#[source] dcb_formats::Error),
    /// A file can't be used or written.
    #[error(transparent)]
    File(#[from] dcb_formats::Error),
    /// A scene and the component that it is about don't fit each other.
    #[error("{}: {message}", path.display())]
    InScene {
        /// The scene's file.
        path: PathBuf,
        /// Finding and expectation.
        message: String,
    },
    /// A scene can't be read, or what it needs can't be taken out of a superelement.
    #[error(transparent)]
    Scene(#[from] dcb_demand::Error),
    /// The observer has asked for it.
    #[error("the reduction was interrupted")]
    Interrupted,
    /// Memory ran out.
    #[error("out of memory for {what}: use a machine with more memory, or a coarser mesh")]
    OutOfMemory {
        /// Purpose.
        what: &'static str,
    },
    /// The forecast exceeds the memory that may be taken; nothing was computed.
    #[error(
        "not enough memory: about {} are needed and {} may be taken; what helps: {remedies}",
        readable(*.needed),
        readable(*.available)
    )]
    NotEnoughMemory {
        /// Forecast, bytes.
        needed: u64,
        /// Allowed, bytes.
        available: u64,
        /// Remedy.
        remedies: String,
    },
    /// The eigenvalue iteration stopped short.
    #[error(
        "modes: {converged} of {wanted} converged after {iterations} block steps (largest residual {residual:.1e}, wanted {tolerance:.0e}); ask for fewer modes, or check the part for extreme stiffness contrasts"
    )]
    ModesNotConverged {
        /// Converged so far.
        converged: usize,
        /// Wanted.
        wanted: usize,
        /// Block steps made.
        iterations: usize,
        /// Largest relative residual among those wanted.
        residual: f64,
        /// Tolerance.
        tolerance: f64,
    },
    /// The inertia count disagrees with the modes found.
    #[error(
        "modes: {found} eigenvalues found below {limit:.6e} rad²/time², but the factorization of K - μM counts {counted}; the reduction would be incomplete"
    )]
    ModesMissed {
        /// Found by the iteration, rigid ones included.
        found: usize,
        /// Counted by the factorization.
        counted: usize,
        /// The μ of the count.
        limit: f64,
    },
    /// Attachment columns don't converge.
    #[error(
        "attachments: relative residual {residual:.1e} after {iterations} refinements (wanted {tolerance:.0e}) at row {row}; the stiffness matrix may be nearly singular beyond its rigid motions"
    )]
    AttachmentsNotConverged {
        /// Largest relative residual.
        residual: f64,
        /// Refinements made.
        iterations: usize,
        /// Tolerance.
        tolerance: f64,
        /// Name of the worst row.
        row: String,
    },
    /// A matrix that must be positive semi-definite is not.
    #[error(
        "{what}: smallest eigenvalue {smallest:.3e} is below -{tolerance:.0e} times the largest, {largest:.3e}"
    )]
    NotPositive {
        /// Which matrix.
        what: &'static str,
        /// Its smallest eigenvalue.
        smallest: f64,
        /// Its largest eigenvalue.
        largest: f64,
        /// Relative tolerance.
        tolerance: f64,
    },
    /// A result isn't good enough to conclude anything from it.
    #[error(transparent)]
    Shortfall(#[from] Shortfall),
    /// Processes that should hold the factor can't be started.
    #[error("ranks: cannot start {program}: {source}; docs/ranks.md says what is needed")]
    CannotStart {
        /// The program.
        program: String,
        /// The system's answer.
        source: std::io::Error,
    },
    /// Processes that hold the factor failed.
    #[error("ranks: {0}")]
    Ranks(String),
    /// A dense eigenvalue problem failed, which only non-finite numbers cause.
    #[error("{what}: numbers overflowed; check the units of the matrices")]
    NotFinite {
        /// Quantity that was being computed.
        what: &'static str,
    },
}

impl From<dcb_superelement::Error> for Error {
    fn from(error: dcb_superelement::Error) -> Self {
        Self::Scene(error.into())
    }
}

impl From<dcb_sparse::Error> for Error {
    fn from(error: dcb_sparse::Error) -> Self {
        match error {
            dcb_sparse::Error::OutOfMemory { what } => Self::OutOfMemory { what },
            dcb_sparse::Error::File(error) => Self::File(error),
            dcb_sparse::Error::CannotStart { program, source } => {
                Self::CannotStart { program, source }
            }
            dcb_sparse::Error::Ranks(why) => Self::Ranks(why),
        }
    }
}

/// A file of a component.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Input {
    /// K.
    Stiffness,
    /// M.
    Mass,
    /// The description: mesh, interfaces, units.
    Description,
    /// The rows of `--boundary`.
    Boundary,
}

impl Error {
    /// The file of the component that is to be corrected, if it is one.
    pub fn concerns(&self) -> Option<Input> {
        match self {
            Self::Matrix(refusal) => Some(refusal.concerns()),
            Self::Interface(_)
            | Self::Lacking(Lacking::Interfaces | Lacking::Forces)
            | Self::Command(CommandRefusal::UnknownTimeUnit { .. }) => Some(Input::Description),
            Self::Body(_) | Self::Lacking(Lacking::ElasticModes | Lacking::Loads) => {
                Some(Input::Stiffness)
            }
            _ => None,
        }
    }

    /// The same with the name of the file that is to be corrected: a reduction knows no files.
    pub fn naming_the_file(self, files: &ComponentFiles) -> Self {
        let path = match self.concerns() {
            None => return self,
            Some(Input::Stiffness) => &files.stiffness,
            Some(Input::Mass) => &files.mass,
            Some(Input::Description) => &files.description,
            Some(Input::Boundary) => files.boundary.as_ref().unwrap_or(&files.stiffness),
        };
        Self::In {
            path: path.clone(),
            source: Box::new(self),
        }
    }

    /// Whether the input is to blame (exit status 2) rather than the numerics (exit status 1).
    pub fn is_unusable_input(&self) -> bool {
        match self {
            // The machine is too small, not the file wrong.
            Self::File(dcb_formats::Error::NotEnoughMemory { allowed: None, .. }) => false,
            Self::Interface(_)
            | Self::Matrix(_)
            | Self::Body(_)
            | Self::Lacking(_)
            | Self::Band(_)
            | Self::Command(_)
            | Self::Timings(_)
            | Self::InScene { .. }
            | Self::NotEnoughMemory { .. }
            | Self::CannotStart { .. } => true,
            Self::In { source, .. } => source.is_unusable_input(),
            Self::File(error) => !error.is_out_of_memory(),
            Self::Scene(error) => error.is_unusable_input(),
            _ => false,
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn the_file_follows_from_what_is_wrong() {
        let files = ComponentFiles {
            stiffness: "rod.mtx".into(),
            mass: "rod.mass.mtx".into(),
            description: "rod.json".into(),
            boundary: Some("rod.boundary.mtx".into()),
            loads: Vec::new(),
            stresses: Vec::new(),
            stiffening: Vec::new(),
        };
        let no_mass = MatrixRefusal::NoMass {
            mass: -1.0,
            unit: "kg".into(),
        };
        let mechanism = BodyRefusal::Mechanism {
            motions: 2,
            moving: None,
        };
        for (error, told) in [
            (
                Error::from(no_mass),
                "rod.mass.mtx: the mass matrix gives a total mass of -1e0 kg",
            ),
            (mechanism.into(), "rod.mtx: the part is a mechanism"),
            (
                InterfaceRefusal::NodeWithoutDof {
                    interface: "hub".into(),
                    node: 3,
                }
                .into(),
                "rod.json: interface \"hub\": node 3 has no dof",
            ),
            (CommandRefusal::NoPart.into(), "no stiffness matrix given"),
        ] {
            let error = error.naming_the_file(&files);
            assert!(error.is_unusable_input());
            assert!(error.to_string().starts_with(told), "{error}");
        }
        let failed = Error::NotFinite { what: "the modes" }.naming_the_file(&files);
        assert!(!failed.is_unusable_input() && failed.concerns().is_none());
    }
}
