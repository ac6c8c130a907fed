//! How good a reduction is: the identities that it must satisfy, evaluated, with the limits that they are held to.
//!
//! Every defect is dimensionless: divided by the size of what it is a part of.

pub mod lines;
pub mod scene_fit;

use dcb_formats::Superelement;
use dcb_formats::identities::Couplings;
use dcb_formats::superelement::Inertia;
use dcb_sparse::block_algebra::{gram, symmetric_product};
use faer::{Mat, MatRef};
use serde::{Deserialize, Serialize};

use self::scene_fit::SceneFit;
use crate::attachments::columns::residual_limit;
use crate::attachments::enrichment::{FurtherColumns, Reducing};
use crate::attachments::interface_reduction::InterfaceReduction;
use crate::attachments::residual::ResidualFlexibility;
use crate::model::condensation::Model;
use crate::model::rigid_body::MassProperties;
use crate::model::shift::AbsoluteForces;
use crate::modes::certificate::Sturm;
use crate::modes::free_modes::{FreeModes, RESIDUAL_TOLERANCE, residual_is_accepted};

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
    /// What rounding in K can do to ω², relatively: ε |φ|ᵀ |K| |φ| / ω².
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
    /// The eigenvalue count that certifies completeness.
    pub sturm: Sturm,
    /// Number of attachment coordinates in the transform.
    pub residual_rank: usize,
    /// Directions kept statically only.
    pub static_directions: usize,
    /// Rank of the scaled F_res.
    pub flexibility_rank: usize,
    /// Condition number of the scaled F_res over its rank.
    pub flexibility_condition: f64,
    /// What an interface reduction left out of F_res; absent if none was asked for, and in files of older versions.
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
    /// Where L3 and I2 come from; absent in files of older versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub couplings: Option<Couplings>,
    /// The scene that the superelement was made for; absent if it was made for none, and in files of older versions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scene: Option<SceneFit>,
}

/// How good further columns are.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EnrichmentQuality {
    /// What each column answers to.
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
}

/// A dependent row by name.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct DependentRow {
    /// The row.
    pub row: String,
    /// What it depends on; empty if it sees no elastic motion.
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
        sturm: Sturm,
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
            sturm,
            residual_rank: residual.rank(),
            static_directions: residual.static_directions,
            flexibility_rank: residual.flexibility_rank,
            flexibility_condition: residual.condition,
            interface_reduction: residual.interface_reduction.clone(),
            enrichment: further.map(EnrichmentQuality::of),
            rigid_motions: rigid.count(),
            nullity: sturm
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
            couplings: None,
            scene: None,
        }
    }

    /// The limits that are broken, as sentences; empty for a good reduction.
    pub fn broken_limits(&self) -> Vec<String> {
        let mut broken = Vec::from_iter(self.refused_modes());
        let mut check = |what: &str, value: f64, limit: f64| {
            if value > limit || value.is_nan() {
                broken.push(format!(
                    "{what} is {value:.1e}, above its limit {limit:.0e}"
                ));
            }
        };
        let attachment_limit = residual_limit(self.attachment_residual_rounding);
        check(
            "the attachment residual",
            self.attachment_residual,
            attachment_limit,
        );
        check(
            "Φᵀ K G_res (Eq. 29)",
            self.stiffness_orthogonality,
            ORTHOGONALITY_LIMIT,
        );
        check(
            "Φᵀ M G_res (Eq. 30)",
            self.mass_orthogonality,
            ORTHOGONALITY_LIMIT,
        );
        check(
            "Φᵀ M Φ - I (Eq. 31)",
            self.mass_orthonormality,
            ORTHONORMALITY_LIMIT,
        );
        check(
            "Φᵀ K Φ - Ω² (Eq. 31)",
            self.stiffness_diagonality,
            ORTHOGONALITY_LIMIT,
        );
        check(
            "G_resᵀ K G_res - G_res (Eq. 32)",
            self.flexibility_identity,
            ORTHOGONALITY_LIMIT,
        );
        if let Some(further) = &self.enrichment {
            check(
                "the residual of the further columns",
                further.residual,
                residual_limit(further.residual_rounding),
            );
            check(
                "Φᵀ M X of the further columns",
                further.mass_orthogonality,
                ORTHOGONALITY_LIMIT,
            );
            check(
                "Φᵀ K X of the further columns",
                further.stiffness_orthogonality,
                ORTHOGONALITY_LIMIT,
            );
        }
        check("L1 Ψ (Eq. 39)", self.l1_norm, ORTHOGONALITY_LIMIT);
        check("I3 Ψ (Eq. 40)", self.i3_norm, ORTHOGONALITY_LIMIT);
        if self.sturm.counted != self.sturm.found {
            broken.push(format!(
                "the inertia count finds {} eigenvalues where {} were computed",
                self.sturm.counted, self.sturm.found
            ));
        }
        broken
    }

    fn refused_modes(&self) -> Option<String> {
        let pairs = self
            .mode_residuals
            .iter()
            .zip(&self.mode_residual_roundings);
        let refused: Vec<(usize, f64)> = (pairs.enumerate())
            .filter(|(_, (residual, rounding))| !residual_is_accepted(**residual, **rounding))
            .map(|(i, (residual, _))| (i + 1, *residual))
            .collect();
        let (mode, residual) = refused.iter().max_by(|a, b| a.1.total_cmp(&b.1))?;
        Some(format!(
            "{} of {} modes have a residual above the limit {RESIDUAL_TOLERANCE:.0e}, the largest {residual:.1e} in mode {mode}",
            refused.len(),
            self.mode_residuals.len()
        ))
    }
}

/// Left sides of Eq. 29–32 minus their right sides, scaled.
struct Identities {
    stiffness_orthogonality: f64,
    mass_orthogonality: f64,
    mass_orthonormality: f64,
    stiffness_diagonality: f64,
    flexibility_identity: f64,
}

fn largest_scaled(matrix: MatRef<'_, f64>, scale: impl Fn(usize, usize) -> f64) -> f64 {
    let mut largest = 0.0_f64;
    for j in 0..matrix.ncols() {
        for i in 0..matrix.nrows() {
            let s = scale(i, j);
            if s > 0.0 {
                largest = largest.max((matrix[(i, j)] / s).abs());
            }
        }
    }
    largest
}

impl Identities {
    fn of(model: &Model, modes: &FreeModes, residual: &ResidualFlexibility) -> Self {
        let phi = modes.shapes.as_ref();
        let k_phi = symmetric_product(&model.stiffness, phi);
        let highest = modes
            .eigenvalues
            .last()
            .copied()
            .unwrap_or(0.0)
            .max(f64::MIN_POSITIVE);
        // A motion of a loose piece has no ω² of its own: it is measured against the first elastic one.
        let elastic = modes
            .eigenvalues
            .iter()
            .copied()
            .find(|value| *value > 0.0)
            .unwrap_or(modes.first_omitted);
        let floor = if elastic.is_finite() {
            elastic.max(1e-12 * highest)
        } else {
            1.0
        };
        // What rounding in K makes of a motion without stiffness is within the limit: a light, stiff piece has more of it than a soft one has stiffness.
        let loose = phi.subcols(0, modes.zero_count);
        let energies = AbsoluteForces::of(&model.stiffness, loose).energies;
        let omega_squared = |i: usize| match energies.get(i) {
            Some(energy) => floor.max(f64::EPSILON / ORTHOGONALITY_LIMIT * energy),
            None => modes.eigenvalues[i],
        };
        let f0 = |i: usize| residual.flexibility0[(i, i)].max(0.0);
        let m0 = |i: usize| residual.mass_diagonal0[i];
        let n_k = modes.count();
        let mass = gram(phi, modes.mass_shapes.as_ref());
        let stiffness = gram(phi, k_phi.as_ref());
        let identity = |i: usize, j: usize| if i == j { 1.0 } else { 0.0 };
        let mass_defect = Mat::from_fn(n_k, n_k, |i, j| mass[(i, j)] - identity(i, j));
        let stiffness_defect = Mat::from_fn(n_k, n_k, |i, j| {
            stiffness[(i, j)] - identity(i, j) * modes.eigenvalues[i]
        });
        let flexibility_defect = &residual.stiffness.columns - &residual.flexibility;
        Self {
            stiffness_orthogonality: largest_scaled(residual.stiffness.modes.as_ref(), |i, j| {
                (omega_squared(i) * f0(j)).sqrt()
            }),
            mass_orthogonality: largest_scaled(
                gram(modes.mass_shapes.as_ref(), residual.shapes.as_ref()).as_ref(),
                |_, j| m0(j).sqrt(),
            ),
            mass_orthonormality: largest_scaled(mass_defect.as_ref(), |_, _| 1.0),
            stiffness_diagonality: largest_scaled(stiffness_defect.as_ref(), |i, j| {
                omega_squared(i).max(omega_squared(j))
            }),
            flexibility_identity: largest_scaled(flexibility_defect.as_ref(), |i, j| {
                (f0(i) * f0(j)).sqrt()
            }),
        }
    }
}

/// M norm of each basis column: 1 for a mode, for the others that with no mode kept (so a vanishing residual stays small).
fn basis_norms(modes: &FreeModes, residual: &ResidualFlexibility, further: usize) -> Vec<f64> {
    let attachments = residual.mass_diagonal0.iter().map(|m| m.sqrt());
    std::iter::repeat_n(1.0, modes.count())
        .chain(attachments)
        .chain(std::iter::repeat_n(1.0, further))
        .collect()
}

/// Largest |L1 ψ| / (√m ‖ψ‖) and |I3 ψ| / (√I ‖ψ‖): cosines between a rigid motion and a column of the basis.
pub fn mean_axis_defects(
    properties: &MassProperties,
    inertia: &Inertia,
    norms: &[f64],
) -> (f64, f64) {
    let largest_moment = (0..3).map(|a| properties.tensor[a][a]).fold(0.0, f64::max);
    let l1 = largest_scaled(inertia.l1.as_ref(), |_, j| {
        properties.mass.sqrt() * norms[j]
    });
    let i3 = largest_scaled(inertia.i3.as_ref(), |_, j| largest_moment.sqrt() * norms[j]);
    (l1, i3)
}
