//! What modes lack of the static response to centrifugal forces: the reason for `--enrich spin`.
//!
//! A pattern f has the strain energy ½ fᵀ G f, of which a mode has ½ (φᵀ f)² / ω² and the column X = s G_res f the rest. The error of k modes is
//! the root of the part that is beyond them, over all patterns.

use dcb_formats::{Component, Superelement};

use crate::block_algebra::gram;
use crate::condensation::Model;
use crate::enrichment::spin_patterns;
use crate::rigid_body::MassProperties;

/// Errors of 0, 1, … modes, up to those of a superelement that was made with centrifugal columns; empty for a part that no spin strains.
/// `shapes` are its modes over the model's dofs.
pub fn spin_errors(
    component: &Component,
    properties: &MassProperties,
    model: &Model,
    element: &Superelement,
    shapes: faer::MatRef<'_, f64>,
) -> Vec<f64> {
    let Some(further) = &element.enrichment else {
        return Vec::new();
    };
    let (names, forces) = spin_patterns(component, properties, model);
    let amounts = gram(shapes, forces.as_ref());
    let eigenvalues = &element.modes.eigenvalues;
    let first = element.mode_count() + element.boundary_row_count();
    let mut lacking = vec![0.0; eigenvalues.len() + 1];
    for (column, name) in further.names.iter().enumerate() {
        let Some(pattern) = names.iter().position(|known| known == name) else {
            continue;
        };
        let at = (first + column, first + column);
        let carried = |power: i32| -> f64 {
            let modes = eigenvalues.iter().enumerate();
            modes
                .map(|(k, square)| amounts[(k, pattern)].powi(2) / square.powi(power))
                .sum()
        };
        // With no mode kept the column has unit norm: 1 = XᵀMX + s² Σ (φᵀf)² / ω⁴.
        let all = carried(2);
        let scale = match all > 0.0 {
            true => (1.0 - further.reduced_mass[at]).max(0.0) / all,
            false => 0.0,
        };
        let mut beyond = further.reduced_stiffness[at] + scale * carried(1);
        lacking[0] += beyond;
        for (k, square) in eigenvalues.iter().enumerate() {
            beyond -= scale * amounts[(k, pattern)].powi(2) / square;
            lacking[k + 1] += beyond.max(0.0);
        }
    }
    let whole = lacking[0];
    if whole <= 0.0 {
        return Vec::new();
    }
    lacking.iter().map(|part| (part / whole).sqrt()).collect()
}
