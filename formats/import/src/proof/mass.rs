//! What shows that matrices can't be a stiffness and a mass of this part, though rigid motions meet no resistance.

use std::collections::HashMap;

use dcb_formats::mesh::MatrixRow;
use dcb_formats::{Error, SparseMatrix};
use rayon::prelude::*;
use rustc_hash::FxBuildHasher;

use crate::operators::of_file;
use crate::part::Part;
use crate::report::MassCentre;
use crate::request::Import;
use crate::rows::order::row_places;

/// Rigid motions may contradict each other by this much: masses of points that differ by direction do a little.
const TOLERATED: f64 = 1e-3;
/// Digits of a mass that are worth a word.
const FEW_DIGITS: u32 = 10;

impl Part {
    /// Refuses what is no stiffness or mass, and warns of a mass that rigid motions contradict.
    ///
    /// # Errors
    /// [`Error::File`].
    pub fn check_mass(&mut self, request: &Import) -> Result<(), Error> {
        let stiffness = &request.stiffness.path;
        if let Some(row) = not_positive(&self.stiffness) {
            let message = format!(
                "the diagonal of the stiffness is {:.3e} in row {}; it is positive in every row of a free part. Were the matrices exchanged, or its sign?",
                diagonal(&self.stiffness, row),
                row + 1
            );
            return Err(of_file(stiffness, message));
        }
        let mass_path = request.mass.as_ref().map_or(stiffness, |mass| &mass.path);
        let found = MassCentre::of(&self.mass, &row_places(&self.mesh, &self.rows));
        if found.mass.is_nan() || found.mass <= 0.0 {
            let message = format!(
                "the mass is {:.3e}; a mass matrix gives a positive one",
                found.mass
            );
            return Err(of_file(mass_path, message));
        }
        if found.contradiction > TOLERATED {
            let what = format!(
                "the mass matrix doesn't move as a rigid body with the mesh: its translations and rotations contradict each other by {:.1e}",
                found.contradiction
            );
            if self.mass_follows_stiffness {
                let message = format!(
                    "{what}. It has no labels, and was taken in the order of the stiffness's rows; give the order of both, --dofs FILE, or a mass with labels"
                );
                return Err(of_file(mass_path, message));
            }
            self.warnings.push(format!(
                "{what}; is the file cut off, or are its rows in another order than the stiffness's?"
            ));
        }
        let (strange, all) = couplings_beside(&self.mass, &self.stiffness, &self.rows);
        if 2 * strange > all {
            self.warnings.push(format!(
                "{strange} of {all} pairs of nodes that the mass couples are not coupled by the stiffness; are the rows of both in the same order?"
            ));
        }
        if let Some(digits) = self.mass_digits.filter(|digits| *digits < FEW_DIGITS) {
            self.warnings.push(format!(
                "the mass is printed with {digits} digits, and the results are no better; export more digits, or a binary file"
            ));
        }
        Ok(())
    }
}

/// Pairs of different nodes that a mass couples: those that the stiffness doesn't, and all. What elements couple, they couple in both.
fn couplings_beside(
    mass: &SparseMatrix,
    stiffness: &SparseMatrix,
    rows: &[MatrixRow],
) -> (usize, usize) {
    let mut rows_of: HashMap<u32, Vec<usize>, FxBuildHasher> = HashMap::default();
    let node = |row: usize| rows[row].dof().map(|dof| dof.node);
    for row in 0..rows.len() {
        if let Some(node) = node(row) {
            rows_of.entry(node).or_default().push(row);
        }
    }
    let partners = |matrix: &SparseMatrix, own: u32, rows: &[usize]| {
        let mut partners: Vec<u32> = rows
            .iter()
            .flat_map(|row| {
                let entries = matrix.row_idx_of_col_raw(*row).iter();
                entries.zip(matrix.val_of_col(*row))
            })
            .filter(|(_, value)| **value != 0.0)
            .filter_map(|(row, _)| node(*row as usize))
            .filter(|other| *other > own)
            .collect();
        partners.sort_unstable();
        partners.dedup();
        partners
    };
    let of_node = |(own, rows): (&u32, &Vec<usize>)| {
        let of_stiffness = partners(stiffness, *own, rows);
        let of_mass = partners(mass, *own, rows);
        let strange = of_mass.iter();
        let strange = strange.filter(|other| of_stiffness.binary_search(other).is_err());
        (strange.count(), of_mass.len())
    };
    rows_of
        .par_iter()
        .map(of_node)
        .reduce(|| (0, 0), |a, b| (a.0 + b.0, a.1 + b.1))
}

fn diagonal(matrix: &SparseMatrix, row: usize) -> f64 {
    let rows = matrix.row_idx_of_col_raw(row);
    let at = rows.iter().position(|found| *found as usize == row);
    at.map_or(0.0, |at| matrix.val_of_col(row)[at])
}

/// The first row whose diagonal isn't positive.
fn not_positive(matrix: &SparseMatrix) -> Option<usize> {
    (0..matrix.nrows()).find(|row| {
        let value = diagonal(matrix, *row);
        value.is_nan() || value < 0.0
    })
}
