//! How much of a body's response to its own spin stays.
//!
//! ```text
//! f_k = ∂J/∂y_k           the centrifugal force on a coordinate for each product of spins, first order
//! E   = Σ_k |f_k|² / κ_k   twice the strain energy under unit spins, all products together
//! ```

use dcb_formats::superelement::Superelement;

use crate::Error;
use dcb_formats::scene::Compatibility;
use dcb_superelement::DynamicCoordinates;

/// E of a superelement.
///
/// # Errors
/// Those of [`DynamicCoordinates::of`].
pub(super) fn strain(of: &Superelement) -> Result<f64, Error> {
    let coordinates = DynamicCoordinates::of(of, Compatibility::Strong)?;
    let columns = coordinates.to_file();
    let mut energy = 0.0;
    for (column, stiffness) in columns.col_iter().zip(&coordinates.stiffness) {
        if *stiffness <= 0.0 {
            continue;
        }
        let mut force = [[0.0; 3]; 3];
        for (block, amount) in of.inertia.i1.iter().zip(column.iter()) {
            for (sum, row) in force.iter_mut().zip(block) {
                for (sum, entry) in sum.iter_mut().zip(row) {
                    *sum += amount * entry;
                }
            }
        }
        let square: f64 = force.iter().flatten().map(|entry| entry * entry).sum();
        energy += square / stiffness;
    }
    Ok(energy)
}

/// Root of the part of E that `left` lacks of `whole`.
pub(super) fn lost(whole: f64, left: f64) -> f64 {
    if whole > 0.0 {
        (1.0 - left / whole).max(0.0).sqrt()
    } else {
        0.0
    }
}
