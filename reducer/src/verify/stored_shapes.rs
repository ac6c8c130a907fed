//! `reduce verify --component`: nodal fields of a file against those of the component reduced anew, where the file doesn't have a field
//! for every row of the matrices: fields of some nodes, or internal rows.

use std::collections::HashMap;

use dcb_formats::RecoveryBasis;
use dcb_formats::mesh::Dof;
use faer::Mat;

use super::findings::{Findings, SHAPE_AGREEMENT};
use crate::Reduced;

/// Columns with less than this part of their mass left are rounding.
const LEFT_OF_A_COLUMN: f64 = 1e-9;

/// Checks modes and attachments at the dofs that the file has.
pub(super) fn check_stored_shapes(basis: &RecoveryBasis, again: &Reduced, findings: &mut Findings) {
    let places: HashMap<Dof, usize> = (again.recovery.dofs.iter().copied())
        .enumerate()
        .map(|(row, dof)| (dof, row))
        .collect();
    let rows: Option<Vec<usize>> = (basis.dofs.iter())
        .map(|dof| places.get(dof).copied())
        .collect();
    let same_columns = basis.modes.ncols() == again.recovery.modes.ncols()
        && basis.residual.ncols() == again.recovery.residual.ncols();
    let Some(rows) = rows.filter(|_| same_columns) else {
        findings.require("dofs of the fields are those of the component", false, "no");
        return;
    };
    let at_rows = |all: &Mat<f64>| Mat::from_fn(rows.len(), all.ncols(), |i, j| all[(rows[i], j)]);
    let (modes, residual) = (
        at_rows(&again.recovery.modes),
        at_rows(&again.recovery.residual),
    );
    // Φ Φᵀ w is the same whatever the signs, and the axes of a multiple root.
    let weights = Mat::from_fn(rows.len(), 1, |i, _| {
        match basis.dofs[i].direction.is_rotation() {
            true => 0.0,
            false => ((i + 1) as f64 * 0.7).sin(),
        }
    });
    let seen = |modes: &Mat<f64>| modes * (modes.transpose() * &weights);
    let of_modes = largest_difference(&basis.dofs, &seen(&basis.modes), &seen(&modes));
    findings.check("Φ Φᵀ at the nodes", of_modes, SHAPE_AGREEMENT);
    let of = &again.superelement.residual;
    let attachments = (0..residual.ncols())
        .filter(|k| of.mass[(*k, *k)] > LEFT_OF_A_COLUMN * of.mass_diagonal0[*k])
        .map(|k| {
            let column = |all: &Mat<f64>| Mat::from_fn(all.nrows(), 1, |i, _| all[(i, k)]);
            largest_difference(&basis.dofs, &column(&basis.residual), &column(&residual))
        });
    findings.check(
        "attachments at the nodes",
        attachments.fold(0.0, f64::max),
        SHAPE_AGREEMENT,
    );
}

/// Largest difference of a field over its largest entry, translations and rotations each by themselves.
fn largest_difference(dofs: &[Dof], stored: &Mat<f64>, computed: &Mat<f64>) -> f64 {
    let of_kind = |is_rotation: bool| {
        let rows = (0..dofs.len()).filter(|row| dofs[*row].direction.is_rotation() == is_rotation);
        let (mut difference, mut size) = (0.0_f64, f64::MIN_POSITIVE);
        for row in rows {
            difference = difference.max((stored[(row, 0)] - computed[(row, 0)]).abs());
            size = size.max(computed[(row, 0)].abs());
        }
        difference / size
    };
    of_kind(false).max(of_kind(true))
}
