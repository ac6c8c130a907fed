//! The limits that a reduction is held to.

use super::{ORTHOGONALITY_LIMIT, ORTHONORMALITY_LIMIT, Quality};
use crate::attachments::columns::residual_limit;
use crate::error::BrokenLimit;
use crate::modes::free_modes::{RESIDUAL_TOLERANCE, residual_is_accepted};

impl Quality {
    /// The limits that are broken; empty for a good reduction.
    pub fn broken_limits(&self) -> Vec<BrokenLimit> {
        let mut defects = vec![
            (
                "the attachment residual",
                self.attachment_residual,
                residual_limit(self.attachment_residual_rounding),
            ),
            (
                "Φᵀ K G_res (Eq. 29)",
                self.stiffness_orthogonality,
                ORTHOGONALITY_LIMIT,
            ),
            (
                "Φᵀ M G_res (Eq. 30)",
                self.mass_orthogonality,
                ORTHOGONALITY_LIMIT,
            ),
            (
                "Φᵀ M Φ - I (Eq. 31)",
                self.mass_orthonormality,
                ORTHONORMALITY_LIMIT,
            ),
            (
                "Φᵀ K Φ - Ω² (Eq. 31)",
                self.stiffness_diagonality,
                ORTHOGONALITY_LIMIT,
            ),
            (
                "G_resᵀ K G_res - G_res (Eq. 32)",
                self.flexibility_identity,
                ORTHOGONALITY_LIMIT,
            ),
        ];
        if let Some(further) = &self.enrichment {
            defects.extend([
                (
                    "the residual of the further columns",
                    further.residual,
                    residual_limit(further.residual_rounding),
                ),
                (
                    "Φᵀ M X of the further columns",
                    further.mass_orthogonality,
                    ORTHOGONALITY_LIMIT,
                ),
                (
                    "Φᵀ K X of the further columns",
                    further.stiffness_orthogonality,
                    ORTHOGONALITY_LIMIT,
                ),
            ]);
        }
        defects.extend([
            ("L1 Ψ (Eq. 39)", self.l1_norm, ORTHOGONALITY_LIMIT),
            ("I3 Ψ (Eq. 40)", self.i3_norm, ORTHOGONALITY_LIMIT),
        ]);
        let above = |&(quantity, found, limit): &(&'static str, f64, f64)| {
            (found > limit || found.is_nan()).then_some(BrokenLimit::Defect {
                quantity,
                found,
                limit,
            })
        };
        let mut broken = Vec::from_iter(self.refused_modes());
        broken.extend(defects.iter().filter_map(above));
        if self.mode_count.counted != self.mode_count.found {
            broken.push(BrokenLimit::Count {
                counted: self.mode_count.counted,
                computed: self.mode_count.found,
            });
        }
        broken
    }

    fn refused_modes(&self) -> Option<BrokenLimit> {
        let residuals = self.mode_residuals.iter();
        let pairs = residuals.zip(&self.mode_residual_roundings);
        let refused: Vec<(usize, f64)> = (pairs.enumerate())
            .filter(|(_, (residual, rounding))| !residual_is_accepted(**residual, **rounding))
            .map(|(i, (residual, _))| (i + 1, *residual))
            .collect();
        let (worst, residual) = *refused.iter().max_by(|a, b| a.1.total_cmp(&b.1))?;
        Some(BrokenLimit::Modes {
            refused: refused.len(),
            modes: self.mode_residuals.len(),
            worst,
            residual,
            limit: RESIDUAL_TOLERANCE,
        })
    }
}
