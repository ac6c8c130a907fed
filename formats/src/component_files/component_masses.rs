//! Component masses from their files, compared with the mass matrix.

use super::mass_moments::check_moments;
use super::{ComponentFiles, SPATIAL_MASSES, source};
use crate::SparseMatrix;
use crate::component::{ComponentMasses, Source};
use crate::error::Error;
use crate::matrix::MatrixReader;
use crate::mesh::{Dimension, DofMap, Mesh};

const PLANAR_MASSES: [&str; 3] = ["xx", "yy", "xy"];
/// The component masses of the three axes must add up to the mass matrix this closely, relative to its largest entry.
const MASS_SUM_TOLERANCE: f64 = 1e-8;

/// The operators and the mesh that component masses are compared with.
#[derive(Clone, Copy)]
pub(super) struct Operators<'a> {
    pub(super) mass: &'a SparseMatrix,
    pub(super) stiffness: &'a SparseMatrix,
    pub(super) mesh: &'a Mesh,
    pub(super) dofs: &'a DofMap,
}

/// Reads the component masses; `None` without any file.
///
/// # Errors
/// The first file that is missing, of another size or not of this component.
pub(super) fn read_component_masses(
    files: &ComponentFiles,
    reader: &mut MatrixReader,
    of: Operators<'_>,
    sources: &mut Vec<Source>,
) -> Result<Option<ComponentMasses>, Error> {
    let dimension = of.mesh.dimension;
    let n_e = of.mass.nrows();
    let names = component_mass_names(dimension);
    let paths = files.component_masses(names);
    if !paths.iter().any(|path| path.exists()) {
        return Ok(None);
    }
    if let Some(absent) = paths.iter().find(|path| !path.exists()) {
        let present = paths.iter().filter(|path| path.exists()).count();
        return Err(Error::File {
            path: absent.clone(),
            message: format!(
                "missing, while {present} of the {} component masses ({}) are there; give all of them or none",
                names.len(),
                names.join(" ")
            ),
        });
    }
    let mut matrices = Vec::with_capacity(paths.len());
    for (path, name) in paths.iter().zip(names) {
        let (matrix, report) = reader.read_matrix(path)?;
        if matrix.nrows() != n_e || matrix.ncols() != n_e {
            return Err(Error::File {
                path: path.clone(),
                message: format!(
                    "{} x {}, but the component has {n_e} dofs",
                    matrix.nrows(),
                    matrix.ncols()
                ),
            });
        }
        if matrix.as_ref().val().iter().any(|value| !value.is_finite()) {
            return Err(Error::File {
                path: path.clone(),
                message: "has an entry that is not finite".into(),
            });
        }
        sources.push(source(&format!("mass.{name}"), &report));
        matrices.push(matrix);
    }
    check_sum(files, &matrices[..dimension.coordinate_count()], of.mass)?;
    let named: Vec<_> = (paths.into_iter().zip(names).zip(&matrices))
        .map(|((path, name), matrix)| (path, *name, matrix))
        .collect();
    check_moments(&named, of.mass, of.stiffness, of.mesh, of.dofs)?;
    Ok(Some(ComponentMasses { matrices }))
}

fn component_mass_names(dimension: Dimension) -> &'static [&'static str] {
    match dimension {
        Dimension::Planar => &PLANAR_MASSES,
        Dimension::Spatial => &SPATIAL_MASSES,
    }
}

/// M_xx + M_yy (+ M_zz) = M, or the component masses are not of this model.
fn check_sum(
    files: &ComponentFiles,
    axes: &[SparseMatrix],
    mass: &SparseMatrix,
) -> Result<(), Error> {
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
                return Err(Error::Mismatch {
                    message: format!(
                        "{}: the component masses of the axes don't add up to it: at row {}, column {} they differ by {defect:.3e}",
                        files.mass.display(),
                        row + 1,
                        column + 1
                    ),
                });
            }
        }
    }
    Ok(())
}
