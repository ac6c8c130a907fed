//! How far stresses are off, by the forces at the interfaces.
//!
//! A superelement is the best approximation in its basis: the error e of the displacements under a force b at the angular frequency ω, below the first omitted
//! ω_o, has the energy eᵀ (K − ω² M) e = h_bb − h̃_bb, the error of the collocated response. With G_o the flexibility of what the modes leave out and
//! r = ω²/ω_o², sᵀ (K − ω² M)⁻¹ s ≤ s G_o sᵀ / (1 − r) there, so that by Cauchy and Schwarz
//!
//! ```text
//! |s e|² ≤ s G_o sᵀ (h_bb − h̃_bb) / (1 − r)
//! ```
//! Both factors are in the file. Statically the error is zero.

use dcb_formats::superelement::{StressField, Superelement};
use faer::Mat;

use crate::{Error, ErrorBounds};

/// The largest error of each field's rows under a force at any attachment that oscillates with ω², as a part of the field's largest entry by any of these
/// forces at rest. Forces are so large that each stores the same energy at rest. `None` for a field of which nobody has computed what is left out, or that no
/// force stresses.
///
/// # Errors
/// As [`ErrorBounds::at`].
pub fn stress_errors(
    element: &Superelement,
    bounds: &ErrorBounds,
    square: f64,
) -> Result<Vec<Option<f64>>, Error> {
    let rows = bounds.attached_rows();
    if rows.is_empty() || element.stresses.is_empty() {
        return Ok(vec![None; element.stresses.len()]);
    }
    let found = bounds.at(&rows, square, 0.0)?;
    let all = bounds.forces();
    let forces = Mat::from_fn(all.nrows(), rows.len(), |b, j| all[(b, rows[j])]);
    let room = 1.0 - square / bounds.eigenvalue_bound();
    let energy = |j: usize| (found.difference[(j, j)].norm() + found.radius[(j, j)]) / room;
    // Twice the energy at rest of each force.
    let still = element.modes.interface_shapes.transpose() * &forces;
    let flexible = forces.transpose() * &element.residual.flexibility * &forces;
    let stored: Vec<f64> = (0..rows.len())
        .map(|j| {
            let of_modes = element.modes.eigenvalues.iter().enumerate();
            let of_modes = of_modes.filter(|(_, square)| **square > 0.0);
            let sum: f64 = of_modes
                .map(|(k, square)| still[(k, j)].powi(2) / square)
                .sum();
            sum + flexible[(j, j)]
        })
        .collect();
    let of_field = |field: &StressField| -> Option<f64> {
        let omitted = field.omitted.as_ref()?;
        let most = omitted.iter().fold(0.0, |most: f64, one| most.max(*one));
        let at_rest = static_stress(element, field, &forces);
        let columns = || (0..rows.len()).filter(|j| stored[*j] > 0.0);
        let size = columns()
            .map(|j| at_rest.col(j).norm_max() / stored[j].sqrt())
            .fold(0.0, f64::max);
        let error = columns()
            .map(|j| most * (energy(j) / stored[j]).sqrt())
            .fold(0.0, f64::max);
        (size > 0.0).then_some(error / size)
    };
    Ok(element.stresses.iter().map(of_field).collect())
}

/// S (Φ Ω⁻² Φᵀ + G_res) L_bᵀ B: stress by forces that don't change, the inertia relieved.
fn static_stress(element: &Superelement, field: &StressField, forces: &Mat<f64>) -> Mat<f64> {
    let (n_k, n_b) = (element.mode_count(), element.rows.len());
    let work = element.modes.interface_shapes.transpose() * forces;
    let amounts = Mat::from_fn(n_k, forces.ncols(), |k, j| {
        match element.modes.eigenvalues[k] {
            square if square > 0.0 => work[(k, j)] / square,
            _ => 0.0,
        }
    });
    field.shapes.subcols(0, n_k) * amounts + field.shapes.subcols(n_k, n_b) * forces
}
