//! How the parts of an assembly fit, and what limits its accuracy; kept in the file's provenance.

use std::path::PathBuf;

use dcb_formats::component::Source;
use dcb_formats::superelement::{Provenance, Superelement};
use serde::{Deserialize, Serialize};
use serde_json::json;

use crate::bounds::ModeBound;
use crate::joint::{Meeting, TOLD_ANGLE};
use crate::part::Part;
use crate::responses::ResponseEstimate;
use crate::whole::{Support, Whole};

/// Key of the report in the provenance's quality.
const KEY: &str = "assembly";
/// Error of a frequency that more modes of a part should reach.
const WANTED: f64 = 1e-4;
/// How the error falls with the first omitted ω² of a part: M_3 is a sum of c cᵀ/ω⁶ over modes of evenly spaced ω.
const FALLS: f64 = 2.5;
/// Gaps above this, by the size of the whole, are told.
const TOLD_GAP: f64 = 1e-9;
/// Couplings of modes by dampers above this are told.
const TOLD_COUPLING: f64 = 0.1;

/// How an assembly was made and what is known of it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct AssemblyReport {
    /// Its bodies.
    pub parts: Vec<PartReport>,
    /// Joints, and how well their places meet.
    pub meetings: Vec<Meeting>,
    /// Joint rows that hold what others hold already.
    pub redundant: Vec<String>,
    /// Joint rows that nearly do.
    pub nearly_redundant: Vec<String>,
    /// The kept elastic modes between bounds; `None` where a part's file has no error estimate.
    pub modes: Option<Vec<ModeBound>>,
    /// What the parts' truncation does to responses at the interfaces, an estimate; `None` where it isn't known.
    pub responses: Option<ResponseEstimate>,
    /// The part whose file has none.
    pub without_estimate: Option<String>,
    /// Whether nothing holds it.
    pub is_free: bool,
    /// How far damping turns modes into each other, which one ratio for each leaves out: the largest d_kl ω_l / |ω_k² − ω_l²|.
    pub damping_coupling: f64,
}

/// One body of an assembly.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PartReport {
    /// Its name.
    pub name: String,
    /// Name of its file; `None` for a rigid body.
    pub file: Option<String>,
    /// Modes of its file.
    pub modes: usize,
    /// Its largest share in what a frequency of the whole may be off, relative.
    pub largest_share: Option<f64>,
    /// About as many modes would make that share 1e-4; `None` where it is smaller already.
    pub modes_for_1e_4: Option<usize>,
}

/// What was found of an assembly.
pub(crate) struct Known {
    pub meetings: Vec<Meeting>,
    pub modes: Option<Vec<ModeBound>>,
    pub responses: Option<ResponseEstimate>,
    pub without_estimate: Option<String>,
    pub damping_coupling: f64,
}

impl AssemblyReport {
    pub(crate) fn of(
        parts: &[Part],
        files: &[Option<(PathBuf, String)>],
        whole: &Whole,
        known: Known,
    ) -> Self {
        let modes = known.modes.as_deref();
        let report = |(i, part): (usize, &Part)| {
            let share = |of: &ModeBound| 0.5 * of.shares.get(i).copied().unwrap_or(0.0);
            let largest = modes.map(|modes| modes.iter().map(share).fold(0.0, f64::max));
            let element = part.flexible().map(|of| &of.element);
            PartReport {
                name: part.name.clone(),
                file: files[i].as_ref().map(|(file, _)| file_name(file)),
                modes: element.map_or(0, Superelement::mode_count),
                modes_for_1e_4: largest
                    .zip(element)
                    .and_then(|(share, element)| needed(element, share)),
                largest_share: largest,
            }
        };
        Self {
            parts: parts.iter().enumerate().map(report).collect(),
            meetings: known.meetings,
            redundant: whole.redundant.clone(),
            nearly_redundant: whole.nearly_redundant.clone(),
            responses: known.responses,
            without_estimate: known.without_estimate,
            is_free: whole.support == Support::Free,
            damping_coupling: known.damping_coupling,
            modes: known.modes,
        }
    }

    /// The report of a superelement that is an assembly.
    pub fn stored(element: &Superelement) -> Option<Self> {
        let stored = element.provenance.quality.get(KEY)?;
        serde_json::from_value(stored.clone()).ok()
    }

    /// Largest relative bound of what a frequency may be off.
    pub fn frequency_error(&self) -> Option<f64> {
        let modes = self.modes.as_ref()?;
        Some(
            modes
                .iter()
                .map(ModeBound::frequency_error)
                .fold(0.0, f64::max),
        )
    }

    /// What a user can act on.
    pub fn warnings(&self) -> Vec<String> {
        let mut all = Vec::new();
        for meeting in &self.meetings {
            if meeting.relative_gap > TOLD_GAP {
                all.push(format!(
                    "joint {:?}: its places are {:.1e} of the whole's size apart; they are joined by a rigid link",
                    meeting.joint, meeting.relative_gap
                ));
            }
            if let Some(angle) = meeting.angle.filter(|angle| *angle > TOLD_ANGLE) {
                all.push(format!(
                    "joint {:?}: its frames are turned by {angle:.1e} rad against each other; check `orientation` if they should be aligned",
                    meeting.joint
                ));
            }
        }
        if !self.redundant.is_empty() {
            all.push(format!(
                "{} joint rows hold what others hold already, and change nothing: {}",
                self.redundant.len(),
                shortened(&self.redundant)
            ));
        }
        if !self.nearly_redundant.is_empty() {
            all.push(format!(
                "{} joint rows nearly hold what others hold already, so that small differences of the parts stress the joints: {}",
                self.nearly_redundant.len(),
                shortened(&self.nearly_redundant)
            ));
        }
        if let Some(part) = &self.without_estimate {
            all.push(format!(
                "nothing is known of the errors: the file of {part:?} has no error estimate; reduce it without --without-estimate"
            ));
        }
        if self.damping_coupling > TOLD_COUPLING {
            all.push(format!(
                "damping turns modes into each other by up to {:.0} %, which one ratio for each mode leaves out; keep strong dampers out of the assembly, in a scene",
                100.0 * self.damping_coupling.min(1.0)
            ));
        }
        all
    }

    pub(crate) fn provenance(
        &self,
        parts: &[Part],
        files: &[Option<(PathBuf, String)>],
    ) -> Provenance {
        let inputs = parts.iter().zip(files).filter_map(|(part, file)| {
            file.as_ref().map(|(path, digest)| Source {
                role: format!("part {}", part.name),
                file_name: file_name(path),
                sha256: digest.trim_start_matches("sha256:").to_owned(),
            })
        });
        Provenance {
            generator: format!("dcb-assembly {}", env!("CARGO_PKG_VERSION")),
            inputs: inputs.collect(),
            options: json!({}),
            quality: json!({KEY: self}),
            warnings: self.warnings(),
        }
    }
}

fn file_name(path: &std::path::Path) -> String {
    path.file_name()
        .map_or_else(String::new, |name| name.to_string_lossy().into_owned())
}

fn shortened(names: &[String]) -> String {
    const LISTED: usize = 4;
    let mut text = names[..names.len().min(LISTED)].join(", ");
    if names.len() > LISTED {
        text += &format!(" and {} more", names.len() - LISTED);
    }
    text
}

/// How many modes a part needs, about, so that its share falls to the wanted one: the number of its modes grows with ω as it has so far.
fn needed(element: &Superelement, share: f64) -> Option<usize> {
    let count = element.mode_count();
    if share <= WANTED || !share.is_finite() || count == 0 {
        return None;
    }
    let eigenvalues = &element.modes.eigenvalues;
    let (middle, last) = (eigenvalues[count / 2], eigenvalues[count - 1]);
    let grown = (last / middle).ln();
    let power = match grown > 0.0 && count > 3 {
        true => ((count as f64 / (count / 2 + 1) as f64).ln() / grown).clamp(0.25, 1.5),
        false => 0.5,
    };
    let further = (share / WANTED).powf(power / FALLS);
    Some((count as f64 * further).ceil() as usize)
}
