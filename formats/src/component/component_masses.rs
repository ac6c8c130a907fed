//! Component masses compared with the mass matrix.

use super::fault::{ComponentFault, Place};
use super::mass_moments::check_moments;
use super::operators::{check_entries, check_size};
use super::{ComponentDraft, ComponentMasses};
use crate::SparseMatrix;

/// The component masses of the three axes must add up to the mass matrix this closely, relative to its largest entry.
const MASS_SUM_TOLERANCE: f64 = 1e-8;

/// The component masses are those of this component.
///
/// # Errors
/// The first one of another size, or the sum or the moment that differs from the mass matrix's.
pub(super) fn check_component_masses(
    masses: &ComponentMasses,
    of: &ComponentDraft,
) -> Result<(), ComponentFault> {
    let dimension = of.mesh.dimension;
    let expected = ComponentMasses::names(dimension).len();
    let found = masses.matrices.len();
    if found != expected {
        return Err(ComponentFault::at(
            Place::ComponentMass(found.min(expected)),
            format!("there are {found} component masses, expected {expected}"),
        ));
    }
    for (index, matrix) in masses.matrices.iter().enumerate() {
        let place = Place::ComponentMass(index);
        check_size(matrix, of.mass.nrows(), &place)?;
        check_entries(matrix, &place)?;
    }
    check_sum(&masses.matrices[..dimension.coordinate_count()], &of.mass)?;
    check_moments(masses, of)
}

/// M_xx + M_yy (+ M_zz) = M, or the component masses are not of this model.
fn check_sum(axes: &[SparseMatrix], mass: &SparseMatrix) -> Result<(), ComponentFault> {
    let largest = mass
        .as_ref()
        .val()
        .iter()
        .fold(0.0_f64, |largest, value| largest.max(value.abs()));
    let mut column_sum = vec![0.0; mass.nrows()];
    for column in 0..mass.ncols() {
        let mut touched = Vec::new();
        for (matrix, sign) in axes.iter().map(|axis| (axis, 1.0)).chain([(mass, -1.0)]) {
            for (row, value) in matrix
                .row_idx_of_col_raw(column)
                .iter()
                .zip(matrix.val_of_col(column))
            {
                column_sum[*row as usize] += sign * value;
                touched.push(*row as usize);
            }
        }
        for row in touched {
            let defect = std::mem::take(&mut column_sum[row]);
            if defect.abs() > MASS_SUM_TOLERANCE * largest {
                return Err(ComponentFault::at(
                    Place::Mass,
                    format!(
                        "the component masses of the axes don't add up to it: at row {}, column {} they differ by {defect:.3e}",
                        row + 1,
                        column + 1
                    ),
                ));
            }
        }
    }
    Ok(())
}
