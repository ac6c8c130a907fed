//! Projector P of interface forces: column by column, the force that replaces a unit force on a row.
//!
//! Where an interface is loaded along the forces B only, its attachments are X B. They stay one for each row, because the file has them so:
//!
//! ```text
//! P = B (Bᵀ F_res B)⁻¹ Bᵀ F_res          P B = B,   Pᵀ F_res P = F_res P
//! ```
//! X P spans what X B spans, F_res' = L_b X P is symmetric, and displacements in directions that aren't loaded are known from the same columns.
//! Another projector onto B would do for the dynamics, but F_res' wouldn't be symmetric. Rows of interfaces loaded in all directions belong to B.

use dcb_dense::{symmetric_eigen, symmetric_eigenvalues, symmetrized};
use faer::Mat;

use super::interface::InterfaceSelection;
use super::statics::Statics;
use crate::Error;

/// Forces count as dependent where the energy of what one has beyond the others is below this fraction of its own.
const DEPENDENT: f64 = 1e-12;

/// P over the rows of `of`, (n_b, rows): `interfaces` says what interface each row of the whole belongs to.
///
/// # Errors
/// [`Error::NoEigenvalues`] if F_res isn't finite.
pub(super) fn projector(
    statics: &Statics,
    interfaces: &[usize],
    wanted: &[InterfaceSelection],
    rows: &[usize],
) -> Result<Mat<f64>, Error> {
    let mut all = Mat::zeros(interfaces.len(), rows.len());
    let mut along = Vec::new();
    for (column, row) in rows.iter().enumerate() {
        match &wanted[interfaces[*row]] {
            InterfaceSelection::Loaded => all[(*row, column)] = 1.0,
            InterfaceSelection::LoadedAlong(_) => along.push((column, *row)),
            InterfaceSelection::Observed | InterfaceSelection::Dropped => {}
        }
    }
    if along.is_empty() {
        return Ok(all);
    }
    let forces = forces(statics, interfaces, wanted, &scale(statics))?;
    let gram =
        |flexibility: &Mat<f64>| symmetrized((forces.transpose() * flexibility * &forces).as_ref());
    let of_whole = gram(&statics.flexibility0);
    let of_whole = symmetric_eigenvalues(of_whole.as_ref()).ok_or(Error::NoEigenvalues)?;
    let least = DEPENDENT * of_whole.last().copied().unwrap_or(0.0);
    let (values, vectors) =
        symmetric_eigen(gram(&statics.flexibility).as_ref()).ok_or(Error::NoEigenvalues)?;
    let kept: Vec<usize> = (0..values.len()).filter(|k| values[*k] > least).collect();
    // B' with B'ᵀ F_res B' = I.
    let units = Mat::from_fn(values.len(), kept.len(), |i, k| {
        vectors[(i, kept[k])] / values[kept[k]].sqrt()
    });
    let units = &forces * units;
    for (column, row) in along {
        let amounts = units.transpose() * statics.flexibility.col(row);
        let force = &units * amounts;
        all.col_mut(column).copy_from(force);
    }
    Ok(all)
}

/// Factor of each row: one over the root of its flexibility with no mode kept, zero for one that nothing moves.
pub(super) fn scale(statics: &Statics) -> Vec<f64> {
    (0..statics.acting.len())
        .map(|row| statics.flexibility0[(row, row)])
        .map(|whole| {
            if whole > 0.0 {
                whole.sqrt().recip()
            } else {
                0.0
            }
        })
        .collect()
}

/// B over all rows, (n_b, forces): those of each interface orthonormal in the rows' scale.
pub(super) fn forces(
    statics: &Statics,
    interfaces: &[usize],
    wanted: &[InterfaceSelection],
    scale: &[f64],
) -> Result<Mat<f64>, Error> {
    let mut columns: Vec<(usize, Vec<f64>)> = Vec::new();
    for (interface, wanted) in wanted.iter().enumerate() {
        let first = interfaces.partition_point(|of| *of < interface);
        let rows = first..interfaces.partition_point(|of| *of <= interface);
        match wanted {
            InterfaceSelection::Loaded => {
                let acting = rows.filter(|row| statics.acting[*row]);
                columns.extend(acting.map(|row| (row, vec![scale[row]])));
            }
            InterfaceSelection::LoadedAlong(forces) => {
                let orthonormal = orthonormal(forces, &scale[rows])?;
                let own = orthonormal.col_iter();
                columns.extend(own.map(|force| (first, force.iter().copied().collect())));
            }
            InterfaceSelection::Observed | InterfaceSelection::Dropped => {}
        }
    }
    Ok(Mat::from_fn(interfaces.len(), columns.len(), |row, j| {
        let (first, entries) = &columns[j];
        let entry = row.checked_sub(*first).and_then(|at| entries.get(at));
        entry.copied().unwrap_or(0.0)
    }))
}

/// Combinations Q of forces on some rows, orthonormal if a force counts as itself over the row's scale.
fn orthonormal(forces: &Mat<f64>, scale: &[f64]) -> Result<Mat<f64>, Error> {
    let scaled = Mat::from_fn(forces.nrows(), forces.ncols(), |i, j| match scale[i] {
        0.0 => 0.0,
        scale => forces[(i, j)] / scale,
    });
    let sizes: Vec<f64> = scaled.col_iter().map(|force| force.norm_l2()).collect();
    let unit = Mat::from_fn(scaled.nrows(), sizes.len(), |i, j| match sizes[j] {
        0.0 => 0.0,
        size => scaled[(i, j)] / size,
    });
    let shares = symmetrized((unit.transpose() * &unit).as_ref());
    let (values, vectors) = symmetric_eigen(shares.as_ref()).ok_or(Error::NoEigenvalues)?;
    let least = DEPENDENT * values.last().copied().unwrap_or(0.0);
    let kept: Vec<usize> = (0..values.len()).filter(|k| values[*k] > least).collect();
    let combinations = Mat::from_fn(values.len(), kept.len(), |i, k| {
        vectors[(i, kept[k])] / values[kept[k]].sqrt()
    });
    let unit = unit * combinations;
    Ok(Mat::from_fn(unit.nrows(), unit.ncols(), |i, j| {
        scale[i] * unit[(i, j)]
    }))
}
