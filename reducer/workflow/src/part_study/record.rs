//! Records of a study: the reference and the rows, as lines of `rows.jsonl` and in `study.json`.

use serde::{Deserialize, Serialize};

use super::errors::{Drawn, Errors};
use super::sources::Sources;
use super::variant::Variant;

/// A line of the ledger.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ComponentEntry {
    /// Reference of all rows.
    Reference(Box<ReferenceRecord>),
    /// One row.
    Row(Box<ComponentRow>),
}

/// The unreduced part.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ReferenceRecord {
    /// Name of the part.
    pub name: String,
    /// Its unit of time: eigenvalues are in its inverse square.
    pub time_unit: String,
    /// Dofs.
    pub dofs: usize,
    /// Interfaces on which forces act.
    pub interfaces: Vec<String>,
    /// Their rows, and how many of them are independent.
    pub rows: [usize; 2],
    /// Free elastic ω² that are known.
    pub free_eigenvalues: Vec<f64>,
    /// ω² with the interfaces held, within the band.
    pub held_eigenvalues: Vec<f64>,
    /// Motions that the interfaces leave free.
    pub loose_motions: usize,
    /// ω² of each point of the band.
    pub band: Vec<f64>,
    /// Structural loss factor η of the responses.
    pub loss_factor: f64,
    /// Residual of the reference in the unreduced equations.
    pub residual: f64,
    /// Terms of its series.
    pub terms: usize,
    /// Missing fraction of the static response to centrifugal forces with 0, 1, … modes, in the norm of strain energy; empty where no spin strains the part.
    pub spin: Vec<f64>,
    /// Time it took, s.
    pub seconds: f64,
    /// Titles of the drawn responses, on the diagonal and between interfaces.
    pub drawn: [Option<String>; 2],
    /// |H| of these.
    #[serde(default, skip_serializing_if = "StoredCurves::is_empty")]
    pub curves: StoredCurves,
    /// Pictures of the lowest modes, SVG and caption.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub pictures: Vec<(String, String)>,
}

/// One way to reduce the part.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct ComponentRow {
    /// Form of use.
    pub variant: Variant,
    /// Modes asked for.
    pub asked_modes: usize,
    /// Interface modes asked for; `None` for all.
    pub asked_interface_modes: Option<usize>,
    /// Further columns asked for; studies from before there were any in them don't say.
    #[serde(default)]
    pub enrichment: Sources,
    /// Modes kept.
    pub modes: usize,
    /// Attachment coordinates that the superelement offers.
    pub attachments: usize,
    /// ReducedCoordinates of a simulation beside the body's frame.
    pub unknowns: usize,
    /// Time of the reduction and of writing the file, s.
    pub reduction_seconds: f64,
    /// Of so many repeats the shortest.
    pub repeats: usize,
    /// Size of the file, bytes.
    pub file_bytes: u64,
    /// Errors.
    pub errors: Errors,
    /// Missing fraction of the static response to centrifugal forces with modes and further columns, in the norm of strain energy; `None` where no spin strains
    /// the part, and in studies from before rows said it.
    #[serde(default)]
    pub spin_error: Option<f64>,
    /// Responses over the band; `study.json` leaves them to the ledger.
    #[serde(default, skip_serializing_if = "StoredCurves::is_empty")]
    pub curves: StoredCurves,
}

/// Curves with as many digits as a picture shows. What isn't finite is `None`.
#[derive(Clone, Debug, PartialEq, Default, Serialize, Deserialize)]
pub struct StoredCurves {
    /// ‖H - H_ref‖ / ‖H_ref‖.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub error: Vec<Option<f64>>,
    /// |H| on the diagonal.
    pub collocated: Vec<Option<f64>>,
    /// |H| between interfaces.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub transfer: Vec<Option<f64>>,
}

impl StoredCurves {
    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.collocated.is_empty()
    }

    /// With five digits; the drawn entries are one on the diagonal and one between interfaces, if there is such a one.
    pub(super) fn of(error: &[f64], entries: &[[f64; 2]], drawn: Drawn) -> Self {
        let short = |value: f64| {
            let short = format!("{value:.4e}").parse().ok();
            short.filter(|short: &f64| short.is_finite())
        };
        let curve = |place: usize| entries.iter().map(|pair| short(pair[place])).collect();
        Self {
            error: error.iter().map(|error| short(*error)).collect(),
            collocated: curve(0),
            transfer: drawn.transfer.map_or_else(Vec::new, |_| curve(1)),
        }
    }
}

/// Measures for judging a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Measure {
    /// Frequencies with the interfaces held.
    HeldFrequencies,
    /// Static response.
    StaticResponse,
    /// Receptance of each interface at itself.
    CollocatedResponse,
    /// Receptance between interfaces.
    TransferResponse,
    /// Forces that move the interfaces.
    InterfaceForces,
}

impl Measure {
    /// All, in the order of tables.
    pub const ALL: [Self; 5] = [
        Self::HeldFrequencies,
        Self::StaticResponse,
        Self::CollocatedResponse,
        Self::TransferResponse,
        Self::InterfaceForces,
    ];

    /// For people.
    pub fn title(self) -> &'static str {
        match self {
            Self::HeldFrequencies => "frequencies with held interfaces",
            Self::StaticResponse => "static response",
            Self::CollocatedResponse => "collocated response",
            Self::TransferResponse => "transfer response",
            Self::InterfaceForces => "interface forces",
        }
    }

    /// For files.
    pub fn column(self) -> &'static str {
        match self {
            Self::HeldFrequencies => "held_frequency_error",
            Self::StaticResponse => "static_error",
            Self::CollocatedResponse => "collocated_error",
            Self::TransferResponse => "transfer_error",
            Self::InterfaceForces => "interface_force_error",
        }
    }
}

impl ComponentRow {
    /// Its error by a measure; `None` where it has no such response, or nothing is measured.
    pub fn error(&self, measure: Measure) -> Option<f64> {
        let errors = &self.errors;
        match measure {
            Measure::HeldFrequencies => {
                let all = errors.held_frequencies.as_ref()?.iter().copied();
                all.reduce(f64::max)
            }
            Measure::StaticResponse => {
                let all = errors.static_response.iter().map(|one| one.error);
                all.reduce(f64::max)
            }
            Measure::CollocatedResponse => Some(errors.collocated.largest),
            Measure::TransferResponse => errors.transfer.map(|one| one.largest),
            Measure::InterfaceForces => errors.interface_force.map(|one| one.largest),
        }
    }

    /// Name of the row for people, for example `strong, 20 modes`, or `strong+krylov, 20 modes, 8 interface modes`.
    pub fn title(&self) -> String {
        format!(
            "{}, {} modes{}",
            self.form(),
            self.modes,
            self.interface_modes()
        )
    }

    /// Name of its curve: the form, and interface modes where they are limited.
    pub fn family(&self) -> String {
        format!("{}{}", self.form(), self.interface_modes())
    }

    /// The form with its further columns, for example `strong+krylov`.
    pub fn form(&self) -> String {
        match self.enrichment.is_empty() {
            true => self.variant.name().to_owned(),
            false => format!("{}+{}", self.variant.name(), self.enrichment),
        }
    }

    fn interface_modes(&self) -> String {
        match self.asked_interface_modes {
            Some(count) => format!(", {count} interface modes"),
            None => String::new(),
        }
    }
}
