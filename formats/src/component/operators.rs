//! Checks of the matrices of a component: their sizes, their order, and their symmetry.

use rayon::prelude::*;

use super::fault::{ComponentFault, Place};
use super::{GeometricStiffness, Interface, InterfaceKind, NamedLoad, Role, RowStiffness};
use crate::SparseMatrix;
use crate::matrix::made_symmetric;
use crate::mesh::{Dimension, DofMap};

/// An operator of (n_e, n_e), made exactly symmetric where it is so within rounding; that is noted.
///
/// # Errors
/// Another size, entries out of order or not finite, a pair that differs by more than rounding.
pub(super) fn symmetric(
    matrix: SparseMatrix,
    n_e: usize,
    place: Place,
    notes: &mut Vec<String>,
) -> Result<SparseMatrix, ComponentFault> {
    check_size(&matrix, n_e, &place)?;
    check_entries(&matrix, &place)?;
    match made_symmetric(matrix) {
        Ok((matrix, asymmetry)) => {
            notes.extend(asymmetry_note(&place.to_string(), asymmetry));
            Ok(matrix)
        }
        Err(reason) => Err(ComponentFault::at(place, reason)),
    }
}

/// Sums in another order differ by less; nobody can do anything about that.
pub const ROUNDING_ASYMMETRY: f64 = 1e-13;

/// Note on the largest relative asymmetry of an operator that was made symmetric, if it is more than rounding.
pub(crate) fn asymmetry_note(of: &str, largest: f64) -> Option<String> {
    (largest > ROUNDING_ASYMMETRY)
        .then(|| format!("{of}: asymmetry of up to {largest:.1e} was averaged away"))
}

/// (n_e, n_e).
pub(super) fn check_size(
    matrix: &SparseMatrix,
    n_e: usize,
    place: &Place,
) -> Result<(), ComponentFault> {
    let (rows, columns) = (matrix.nrows(), matrix.ncols());
    if (rows, columns) == (n_e, n_e) {
        return Ok(());
    }
    let message = match place {
        Place::Mass => format!(
            "is {rows} x {columns}, but the stiffness matrix is {n_e} x {n_e}: stiffness and mass must be of one model"
        ),
        _ => format!("is {rows} x {columns}, but the component has {n_e} dofs"),
    };
    Err(ComponentFault::at(place.clone(), message))
}

/// Columns without gaps, rows in order and once, values that are numbers.
pub(super) fn check_entries(matrix: &SparseMatrix, place: &Place) -> Result<(), ComponentFault> {
    if matrix.symbolic().col_nnz().is_some() {
        return Err(ComponentFault::at(
            place.clone(),
            "has gaps between its columns; expected compressed columns",
        ));
    }
    let columns = (0..matrix.ncols()).into_par_iter();
    match columns.find_map_first(|column| wrong_entry(matrix, column)) {
        None => Ok(()),
        Some(message) => Err(ComponentFault::at(place.clone(), message)),
    }
}

/// The first entry of a column that is out of order or no number.
fn wrong_entry(matrix: &SparseMatrix, column: usize) -> Option<String> {
    let (rows, values) = (matrix.row_idx_of_col_raw(column), matrix.val_of_col(column));
    if let Some(pair) = rows.windows(2).find(|pair| pair[1] <= pair[0]) {
        return Some(format!(
            "column {} has row {} after {}; expected rows in order, each once",
            column + 1,
            pair[1] + 1,
            pair[0] + 1
        ));
    }
    let at = values.iter().position(|value| !value.is_finite())?;
    Some(format!(
        "the entry at row {}, column {} is {}, expected a finite number",
        rows[at] + 1,
        column + 1,
        values[at]
    ))
}

/// Rows of L_b that are given as a matrix: (any, n_e), none of them zero, all of them zero on internal rows.
pub(super) fn check_boundary(matrix: &SparseMatrix, dofs: &DofMap) -> Result<(), ComponentFault> {
    let n_e = dofs.len();
    if matrix.ncols() != n_e {
        return Err(ComponentFault::at(
            Place::Boundary,
            format!(
                "{} columns, but the component has {n_e} dofs; a boundary localization is n_b x n_e",
                matrix.ncols()
            ),
        ));
    }
    check_entries(matrix, &Place::Boundary)?;
    let mut is_zero = vec![true; matrix.nrows()];
    for column in 0..matrix.ncols() {
        let entries = matrix.row_idx_of_col_raw(column).iter();
        for (row, value) in entries.zip(matrix.val_of_col(column)) {
            is_zero[*row as usize] &= *value == 0.0;
            if *value != 0.0 && dofs.dof(column).is_none() {
                return Err(ComponentFault::at(
                    Place::Boundary,
                    format!(
                        "row {} has an entry in column {}, which is an internal row of the component: nothing outside acts on what \
                         belongs to no node; expected zero there",
                        row + 1,
                        column + 1
                    ),
                ));
            }
        }
    }
    match is_zero.iter().position(|is_zero| *is_zero) {
        None => Ok(()),
        Some(row) => Err(ComponentFault::at(
            Place::Boundary,
            format!("row {} has no entry other than zero; remove it", row + 1),
        )),
    }
}

/// Names that differ, n_e finite forces each, not all zero.
pub(super) fn check_loads(loads: &[NamedLoad], n_e: usize) -> Result<(), ComponentFault> {
    for (index, NamedLoad { name, forces }) in loads.iter().enumerate() {
        let wrong = |message: String| Err(ComponentFault::at(Place::Load(index), message));
        if name.is_empty() || loads[..index].iter().any(|other| other.name == *name) {
            return wrong(format!(
                "is named {name:?}; expected a name that no other load has"
            ));
        }
        if forces.len() != n_e {
            return wrong(format!(
                "has {} entries, but a load of this component is one column of {n_e} entries, one for each dof",
                forces.len()
            ));
        }
        if let Some(row) = forces.iter().position(|force| !force.is_finite()) {
            return wrong(format!("entry {} is not finite", row + 1));
        }
        if forces.iter().all(|force| *force == 0.0) {
            return wrong("has no entry that isn't zero".into());
        }
    }
    Ok(())
}

/// One stiffness or none for each product of spins, and rows that a force acts along, all of them (n_e, n_e).
pub(super) fn check_geometric_stiffness(
    of: &GeometricStiffness,
    (n_e, dimension): (usize, Dimension),
    interfaces: &[Interface],
) -> Result<(), ComponentFault> {
    let products = GeometricStiffness::spin_products(dimension).len();
    if ![0, products].contains(&of.spins.len()) {
        return Err(ComponentFault::at(
            Place::SpinStiffness(of.spins.len().min(products)),
            format!(
                "there are {} products of spins, expected {products} or none",
                of.spins.len()
            ),
        ));
    }
    for (index, RowStiffness { row, .. }) in of.rows.iter().enumerate() {
        let (interface, direction) = *row;
        if !(interfaces.get(interface)).is_some_and(Interface::has_row_of_forces) {
            return Err(ComponentFault::at(
                Place::RowStiffness(index),
                format!(
                    "is for {} of interface {interface}, which is no attached interface that moves as one",
                    direction.name()
                ),
            ));
        }
    }
    let mut matrices = of.matrices();
    matrices.try_for_each(|(place, matrix)| check_size(matrix, n_e, &place))
}

impl GeometricStiffness {
    fn matrices(&self) -> impl Iterator<Item = (Place, &SparseMatrix)> {
        let spins = self.spins.iter().enumerate();
        let spins = spins.filter_map(|(i, spin)| Some((Place::SpinStiffness(i), spin.as_ref()?)));
        let rows = self.rows.iter().enumerate();
        spins.chain(rows.map(|(i, row)| (Place::RowStiffness(i), &row.matrix)))
    }

    /// With operators as [`symmetric`] makes them.
    pub(super) fn symmetric(
        mut self,
        n_e: usize,
        notes: &mut Vec<String>,
    ) -> Result<Self, ComponentFault> {
        for (index, spin) in self.spins.iter_mut().enumerate() {
            if let Some(matrix) = spin.take() {
                *spin = Some(symmetric(matrix, n_e, Place::SpinStiffness(index), notes)?);
            }
        }
        let rows = self.rows.into_iter().enumerate();
        self.rows = rows
            .map(|(index, RowStiffness { row, matrix })| {
                let matrix = symmetric(matrix, n_e, Place::RowStiffness(index), notes)?;
                Ok(RowStiffness { row, matrix })
            })
            .collect::<Result<_, _>>()?;
        Ok(self)
    }
}

impl Interface {
    /// Whether it is attached and moves as one, so that a row of it has a direction that a force acts along.
    pub(crate) fn has_row_of_forces(&self) -> bool {
        let moves_as_one = self.kind != InterfaceKind::Nodes || self.nodes.len() == 1;
        moves_as_one && self.role == Role::Attachment
    }
}
