//! Stress or strain inside a body, over its coordinates and, where interface forces deflect it beside them, over these forces.
//!
//! ```text
//! σ = S Ψ_r y + S_g g
//! static    S_g = S G_res L_bᵀ                                       all attachments act at once
//! strong    S_g = S (G_res L_bᵀ − Ψ_ζ diag(σ²)⁻¹ (L_b Ψ_ζ)ᵀ)         directions without mass only
//! ```
//! Ψ_ζ are the columns of the attachments' coordinates. Rigid motions make no stress.

use dcb_formats::component::{StressComponent, StressPoint, StressQuantity};
use dcb_formats::superelement::{StressField, Superelement};
use dcb_superelement::DynamicCoordinates;
use faer::Mat;

use super::Compatibility;

/// A stress or strain field of a body.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyStress {
    /// Name in the file.
    pub name: String,
    /// Stress or strain.
    pub quantity: StressQuantity,
    /// Components at every place, body axes.
    pub components: Vec<StressComponent>,
    /// Places, body frame.
    pub points: Vec<StressPoint>,
    /// S Ψ_r, (places x components, n).
    shapes: Mat<f64>,
    /// S_g, (places x components, n_b), or without columns.
    of_forces: Mat<f64>,
}

impl BodyStress {
    /// Over the coordinates whose columns, amplitudes of the file's, are these.
    pub(super) fn of(
        field: &StressField,
        superelement: &Superelement,
        coordinates: &DynamicCoordinates,
        columns: &Mat<f64>,
        compatibility: Compatibility,
    ) -> Self {
        let shapes = &field.shapes * columns;
        let (n_k, n_b) = (superelement.mode_count(), superelement.rows.len());
        let attached = field.shapes.subcols(n_k, n_b);
        let of_forces = match (compatibility, &coordinates.residual_flexibility) {
            (Compatibility::Static, _) => attached.to_owned(),
            (Compatibility::Strong, Some(_)) => {
                let rank = shapes.ncols() - n_k;
                let seen = coordinates.interface_shapes.subcols(n_k, rank);
                let soft = Mat::from_fn(shapes.nrows(), rank, |i, j| {
                    shapes[(i, n_k + j)] / coordinates.stiffness[n_k + j]
                });
                attached - soft * seen.transpose()
            }
            (Compatibility::Strong, None) | (Compatibility::Weak, _) => {
                Mat::zeros(shapes.nrows(), 0)
            }
        };
        Self {
            name: field.name.clone(),
            quantity: field.quantity,
            components: field.components.clone(),
            points: field.points.clone(),
            shapes,
            of_forces,
        }
    }

    /// Whether interface forces are needed beside the coordinates.
    pub fn needs_forces(&self) -> bool {
        self.of_forces.ncols() > 0
    }

    /// Components of one place at coordinates y, (n), and interface forces, (n_b) where they are needed, appended to `values`.
    pub fn at(&self, point: usize, y: &[f64], forces: &[f64], values: &mut Vec<f64>) {
        let count = self.components.len();
        values.extend((point * count..(point + 1) * count).map(|row| {
            let own: f64 = y
                .iter()
                .enumerate()
                .map(|(k, y)| self.shapes[(row, k)] * y)
                .sum();
            let beside = forces.iter().enumerate().take(self.of_forces.ncols());
            own + beside
                .map(|(b, g)| self.of_forces[(row, b)] * g)
                .sum::<f64>()
        }));
    }
}
