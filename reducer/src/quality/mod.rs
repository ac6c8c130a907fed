//! How good a reduction is: the identities that it must satisfy, evaluated, with the limits that they are held to.
//!
//! Every defect is dimensionless: divided by the size of what it is a part of.

mod identities;
mod limits;
pub mod lines;
pub mod scene_fit;

use dcb_formats::Superelement;
use dcb_formats::superelement::CouplingSource;
use dcb_formats::superelement::Inertia;
use serde::{Deserialize, Serialize};

pub use self::identities::mean_axis_defects;
use self::identities::{Identities, basis_norms};
use self::scene_fit::SceneFit;
use crate::attachments::enrichment::{FurtherColumns, Reducing};
use crate::attachments::interface_reduction::InterfaceReduction;
use crate::modes::certificate::ModeCount;

/// Limit of the orthogonality defects (Eq. 29–32, 39–40).
pub const ORTHOGONALITY_LIMIT: f64 = 1e-8;
/// Limit of mass-orthonormality (first half of Eq. 31).
pub const ORTHONORMALITY_LIMIT: f64 = 1e-10;

/// The quality report.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Quality {
    /// ‖K φ - ω² M φ‖ / ‖K φ‖ of each mode.
    pub mode_residuals: Vec<f64>,
    /// The part of it that rounding in K φ explains, ε ‖|K| |φ|‖ / ‖K φ‖.
    pub mode_residual_roundings: Vec<f64>,
    /// Effect of rounding in K on ω², relative: ε |φ|ᵀ |K| |φ| / ω².
    pub eigenvalue_roundings: Vec<f64>,
    /// Largest relative residual of an attachment column.
    pub attachment_residual: f64,
    /// The part of it that rounding in K x explains, ε ‖|K| |x|‖ / ‖f‖.
    pub attachment_residual_rounding: f64,
    /// Eq. 29: max |Φᵀ K G_res L_bᵀ|, scaled.
    pub stiffness_orthogonality: f64,
    /// Eq. 30: max |Φᵀ M G_res L_bᵀ|, scaled.
    pub mass_orthogonality: f64,
    /// Eq. 31: max |Φᵀ M Φ - I|.
    pub mass_orthonormality: f64,
    /// Eq. 31: max |Φᵀ K Φ - Ω²|, scaled.
    pub stiffness_diagonality: f64,
    /// Eq. 32: max |(G_res L_bᵀ)ᵀ K G_res L_bᵀ - F_res|, scaled.
    pub flexibility_identity: f64,
    /// Eq. 39: ‖L1 Ψ‖, scaled.
    pub l1_norm: f64,
    /// Eq. 40: ‖I3 Ψ‖, scaled.
    pub i3_norm: f64,
    /// max|K r| / (max row sum |K| · max|r|) of each rigid motion.
    pub rigid_defects: Vec<f64>,
    /// Relative disagreement of the mass matrix's directions.
    pub mass_defect: f64,
    /// How many modes there are, and how that is known; `sturm` in files of older versions.
    #[serde(alias = "sturm")]
    pub mode_count: ModeCount,
    /// Number of attachment coordinates in the transform.
    pub residual_rank: usize,
    /// Directions kept statically only.
    pub static_directions: usize,
    /// Modes kept beyond those that were asked for, so that a multiple root is whole; absent in files of older versions.
    #[serde(default)]
    pub added_modes: usize,
    /// Rank of the scaled F_res.
    pub flexibility_rank: usize,
    /// Condition number of the scaled F_res over its rank.
    pub flexibility_condition: f64,
    /// F_res that an interface reduction left out; absent if none was asked for, and in files of older versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub interface_reduction: Option<InterfaceReduction>,
    /// Further columns of the basis; absent if there are none, and in files of older versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub enrichment: Option<EnrichmentQuality>,
    /// Rigid motions of the frame, from geometry.
    pub rigid_motions: usize,
    /// Motions without stiffness by the eigenvalue count: what it leaves after the elastic modes found.
    pub nullity: usize,
    /// Motions without stiffness beyond the rigid ones, kept as modes.
    pub zero_modes: usize,
    /// Highest frequency kept and lowest left out, cycles per time unit; absent where there is none.
    pub highest_kept: Option<f64>,
    /// Lowest frequency left out.
    pub lowest_omitted: Option<f64>,
    /// Rows of L_b that depend on others.
    pub dependent_rows: Vec<DependentRow>,
    /// Lanczos block steps and preconditioned iterations of the attachments.
    pub iterations: (usize, usize),
    /// Why there is no error estimate; absent where there is one, or none was asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub missing_estimate: Option<String>,
    /// Where L3 and I2 come from; absent in files of older versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub couplings: Option<CouplingSource>,
    /// The scene that the superelement was made for; absent if it was made for none, and in files of older versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scene: Option<SceneFit>,
}

/// How good further columns are.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EnrichmentQuality {
    /// Load that each column responds to.
    pub names: Vec<String>,
    /// Largest relative residual of a column.
    pub residual: f64,
    /// The part of it that rounding explains.
    pub residual_rounding: f64,
    /// max |Φᵀ M X|; columns have unit M norm with no mode kept.
    pub mass_orthogonality: f64,
    /// max |Φᵀ K X|, over the square root of both stiffnesses.
    pub stiffness_orthogonality: f64,
    /// Responses that were asked for and have nothing beyond the kept modes.
    pub left_out: Vec<String>,
}

impl EnrichmentQuality {
    /// Of columns that were computed.
    pub fn of(further: &FurtherColumns) -> Self {
        Self {
            names: further.names.clone(),
            residual: further.residual,
            residual_rounding: further.residual_rounding,
            mass_orthogonality: further.mass_orthogonality,
            stiffness_orthogonality: further.stiffness_orthogonality,
            left_out: further.left_out.clone(),
        }
    }

    /// What is said of a response that is left out.
    pub fn warning(left_out: &str) -> String {
        format!(
            "the response to {left_out} has nothing beyond the kept modes and rigid motions: no column"
        )
    }
}

/// A dependent row by name.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DependentRow {
    /// The row.
    pub row: String,
    /// Rows that it depends on; empty if it sees no elastic motion.
    pub depends_on: Vec<String>,
}

impl Quality {
    /// The one that a superelement's file holds; `None` where another program made it.
    pub fn stored(element: &Superelement) -> Option<Self> {
        serde_json::from_value(element.provenance.quality.clone()).ok()
    }

    /// Evaluates the identities.
    pub fn of(
        of: &Reducing<'_>,
        rigid_defects: &[f64],
        further: Option<&FurtherColumns>,
        inertia: &Inertia,
        mode_count: ModeCount,
    ) -> Self {
        let Reducing {
            model,
            properties,
            rigid,
            modes,
            residual,
            ..
        } = *of;
        let further_count = inertia
            .i1
            .len()
            .saturating_sub(modes.count() + residual.mass_diagonal0.len());
        let identities = Identities::of(model, modes, residual);
        let (l1_norm, i3_norm) = mean_axis_defects(
            properties,
            inertia,
            &basis_norms(modes, residual, further_count),
        );
        let cycles = |eigenvalue: f64| eigenvalue.max(0.0).sqrt() / (2.0 * std::f64::consts::PI);
        Self {
            mode_residuals: modes.residuals.clone(),
            mode_residual_roundings: modes.residual_roundings.clone(),
            eigenvalue_roundings: modes.eigenvalue_roundings.clone(),
            attachment_residual: residual.residual,
            attachment_residual_rounding: residual.residual_rounding,
            stiffness_orthogonality: identities.stiffness_orthogonality,
            mass_orthogonality: identities.mass_orthogonality,
            mass_orthonormality: identities.mass_orthonormality,
            stiffness_diagonality: identities.stiffness_diagonality,
            flexibility_identity: identities.flexibility_identity,
            // A held part has no mean axes: its L1 and I3 are data, not defects.
            l1_norm: if rigid.count() > 0 { l1_norm } else { 0.0 },
            i3_norm: if rigid.count() > 0 { i3_norm } else { 0.0 },
            rigid_defects: rigid_defects.to_vec(),
            mass_defect: properties.defect,
            mode_count,
            residual_rank: residual.rank(),
            static_directions: residual.static_directions,
            added_modes: modes.added_for_cluster,
            flexibility_rank: residual.flexibility_rank,
            flexibility_condition: residual.condition,
            interface_reduction: residual.interface_reduction.clone(),
            enrichment: further.map(EnrichmentQuality::of),
            rigid_motions: rigid.count(),
            nullity: mode_count
                .counted
                .saturating_sub(modes.count() - modes.zero_count),
            zero_modes: modes.zero_count,
            highest_kept: modes.eigenvalues.last().map(|value| cycles(*value)),
            lowest_omitted: modes
                .first_omitted
                .is_finite()
                .then(|| cycles(modes.first_omitted)),
            dependent_rows: residual
                .dependencies
                .iter()
                .map(|d| DependentRow {
                    row: d.row.clone(),
                    depends_on: d.depends_on.clone(),
                })
                .collect(),
            iterations: (modes.iterations, residual.iterations),
            missing_estimate: None,
            couplings: None,
            scene: None,
        }
    }

    /// The report of these modes alone.
    pub fn of_modes(self, modes: &[usize]) -> Self {
        let picked = |values: &[f64]| -> Vec<f64> {
            let values = modes.iter().filter_map(|mode| values.get(*mode));
            values.copied().collect()
        };
        Self {
            mode_residuals: picked(&self.mode_residuals),
            mode_residual_roundings: picked(&self.mode_residual_roundings),
            eigenvalue_roundings: picked(&self.eigenvalue_roundings),
            ..self
        }
    }
}
