//! Where forces act and displacements are seen, scaled so that translations and rotations count alike.

use dcb_formats::component::Role;
use dcb_formats::superelement::Superelement;
use faer::Mat;

use super::Selection;
use super::projection::forces;
use super::rigid_motions::rigid_motions;
use super::statics::Statics;
use crate::Error;

/// Rows and forces of a selection in the whole's rows.
pub(super) struct ScaledPorts {
    /// Rows whose displacement is seen.
    pub rows: Vec<usize>,
    /// The interface of each.
    pub row_interfaces: Vec<usize>,
    /// Factor of each: one over the root of its flexibility, zero for a row that nothing moves.
    pub scale: Vec<f64>,
    /// Forces, orthonormal in that scale, (n_b, f).
    pub forces: Mat<f64>,
    /// The interface that each acts on.
    pub force_interfaces: Vec<usize>,
    /// M-orthonormal rigid motions at every row, (n_b, r).
    pub rigid: Mat<f64>,
}

impl ScaledPorts {
    /// Flexibility is that with inertia relieved, plus the rigid motion over ω₁². What forces on rows that are only observed in the whole would
    /// do beyond the modes isn't known; they are scaled by the modes.
    pub fn of(whole: &Superelement, selection: &Selection) -> Result<Self, Error> {
        let shapes = &whole.modes.interface_shapes;
        let statics = Statics::with_all_modes(whole);
        let rigid = rigid_motions(whole);
        let eigenvalues = &whole.modes.eigenvalues;
        let lowest = eigenvalues.iter().copied().find(|value| *value > 0.0);
        let lowest = lowest.unwrap_or(whole.modes.first_omitted_eigenvalue);
        let scale: Vec<f64> = (0..whole.rows.len())
            .map(|row| {
                let moved: f64 = (0..rigid.ncols()).map(|k| rigid[(row, k)].powi(2)).sum();
                let elastic = match whole.interfaces[whole.rows[row].interface].role {
                    Role::Attachment => statics.flexibility0[(row, row)],
                    Role::Output => (eigenvalues.iter().enumerate())
                        .filter(|(_, value)| **value > 0.0)
                        .map(|(k, value)| shapes[(row, k)].powi(2) / value)
                        .sum(),
                };
                match elastic + moved / lowest {
                    all if all > 0.0 => all.sqrt().recip(),
                    _ => 0.0,
                }
            })
            .collect();
        let of_rows: Vec<usize> = whole.rows.iter().map(|row| row.interface).collect();
        let forces = forces(&statics, &of_rows, selection.interfaces(), &scale)?;
        let acts_on = |force: usize| {
            let row = (0..forces.nrows()).find(|row| forces[(*row, force)] != 0.0);
            of_rows[row.unwrap_or(0)]
        };
        let rows = selection.rows(whole);
        Ok(Self {
            row_interfaces: rows.iter().map(|row| of_rows[*row]).collect(),
            scale: rows.iter().map(|row| scale[*row]).collect(),
            force_interfaces: (0..forces.ncols()).map(acts_on).collect(),
            rows,
            forces,
            rigid,
        })
    }
}
