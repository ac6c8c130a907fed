//! What shows that matrices can't be a stiffness and a mass of this part, though rigid motions meet no resistance.

use dcb_formats::{Error, SparseMatrix};

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
        if let Some(digits) = self.mass_digits.filter(|digits| *digits < FEW_DIGITS) {
            self.warnings.push(format!(
                "the mass is printed with {digits} digits, and the results are no better; export more digits, or a binary file"
            ));
        }
        Ok(())
    }
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
