//! Stress rows of a component: what they make of the rigid motions, of a basis, and as forces on the model.

use dcb_formats::SparseMatrix;
use dcb_formats::component::{Component, NamedStress, StressPoint};
use dcb_formats::superelement::StressField;
use faer::{Mat, MatRef};

use crate::error::{MatrixRefusal, StressRow};
use crate::model::condensation::Model;
use crate::model::couplings::BasisColumns;
use crate::model::frame::offset;
use crate::model::rigid_body::component_columns;

/// A row may see this part of what its entries would make of a rigid motion without cancelling.
const RIGID_LIMIT: f64 = 1e-6;

/// Refuses rows that see a rigid motion of the part as stress: they belong to other degrees of freedom, or to other axes.
///
/// # Errors
/// [`MatrixRefusal::Stress`] with the worst row.
pub fn refuse_rigid_stress(component: &Component, centre: [f64; 3]) -> Result<(), MatrixRefusal> {
    if component.stresses.is_empty() {
        return Ok(());
    }
    let motions = component_columns(component, centre);
    let sizes = Mat::from_fn(motions.nrows(), motions.ncols(), |i, j| {
        motions[(i, j)].abs()
    });
    for field in &component.stresses {
        let seen = product(&field.matrix, motions.as_ref(), |value| value);
        let most = product(&field.matrix, sizes.as_ref(), f64::abs);
        let defect = |row: usize| {
            (0..seen.ncols())
                .map(|j| match most[(row, j)] > 0.0 {
                    true => seen[(row, j)].abs() / most[(row, j)],
                    false => 0.0,
                })
                .fold(0.0, f64::max)
        };
        let worst = (0..seen.nrows())
            .map(|row| (row, defect(row)))
            .max_by(|a, b| a.1.total_cmp(&b.1));
        if let Some((row, defect)) = worst.filter(|(_, defect)| *defect > RIGID_LIMIT) {
            return Err(MatrixRefusal::Stress(StressRow {
                field: field.name.clone(),
                row,
                place: row / field.components.len(),
                component: field.components[row % field.components.len()].name(),
                defect,
            }));
        }
    }
    Ok(())
}

/// S Ψ of every field, Ψ given as blocks over all dofs, (n_e, n).
pub fn stress_fields(
    component: &Component,
    centre: [f64; 3],
    basis: &[MatRef<'_, f64>],
    omitted: Option<Vec<Vec<f64>>>,
) -> Vec<StressField> {
    let mut omitted = omitted.map(Vec::into_iter);
    let field = |of: &NamedStress| {
        let columns = BasisColumns(basis);
        let mut shapes = Mat::zeros(of.matrix.nrows(), columns.ncols());
        for (first, strip) in columns.strips() {
            let part = product(&of.matrix, strip, |value| value);
            shapes
                .as_mut()
                .subcols_mut(first, strip.ncols())
                .copy_from(part);
        }
        StressField {
            name: of.name.clone(),
            quantity: of.quantity,
            components: of.components.clone(),
            points: (of.points.iter())
                .map(|point| StressPoint {
                    position: offset(point.position, centre),
                    ..*point
                })
                .collect(),
            shapes,
            omitted: omitted.as_mut().and_then(Iterator::next),
        }
    };
    component.stresses.iter().map(field).collect()
}

/// Some rows of a field as forces on the model, `Tᵀ sᵀ`, (n_c, count).
pub fn rows_as_forces(
    model: &Model<'_>,
    of: &NamedStress,
    rows: std::ops::Range<usize>,
) -> Mat<f64> {
    let mut forces = Mat::zeros(of.matrix.ncols(), rows.len());
    for column in 0..of.matrix.ncols() {
        let entries = of.matrix.row_idx_of_col_raw(column).iter();
        for (row, value) in entries.zip(of.matrix.val_of_col(column)) {
            let row = *row as usize;
            if rows.contains(&row) {
                forces[(column, row - rows.start)] = *value;
            }
        }
    }
    model.condensed_forces(forces)
}

/// S x with a function of the entries of S, (rows, columns of x).
fn product(matrix: &SparseMatrix, x: MatRef<'_, f64>, of: impl Fn(f64) -> f64) -> Mat<f64> {
    let mut out = Mat::zeros(matrix.nrows(), x.ncols());
    for column in 0..matrix.ncols() {
        let entries = matrix.row_idx_of_col_raw(column).iter();
        for (row, value) in entries.zip(matrix.val_of_col(column)) {
            let value = of(*value);
            for j in 0..x.ncols() {
                out[(*row as usize, j)] += value * x[(column, j)];
            }
        }
    }
    out
}
