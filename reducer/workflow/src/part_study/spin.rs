//! Missing fraction of the static response to centrifugal forces in a basis: the reason for `--enrich spin`.
//!
//! A pattern f has the strain energy ½ fᵀ G f, of which a mode has ½ (φᵀ f)² / ω² and further columns, orthogonal to the modes in K, have
//! ½ fᵀX (XᵀKX)⁻¹ Xᵀf. The error is the root of the part that is beyond them, over all patterns, each scaled so that G f has unit M norm.

use dcb_formats::further_column::Answer;
use dcb_formats::{Component, Superelement};
use dcb_sparse::block_algebra::gram;
use faer::Mat;

use crate::inverse_root::inverse_root;
use dcb_reducer::inertia::spin_forces::spin_forces;
use dcb_reducer::model::rigid_body::MassProperties;
use dcb_reducer::pipeline::row_shapes::RowShapesRef;
use dcb_superelement::MASS_TOLERANCE;

/// The strain that centrifugal forces make in a part.
#[derive(Clone, Debug)]
pub struct SpinStrain {
    /// Forces of all patterns over the component's dofs, (n_e, 6), planar (n_e, 1).
    forces: Mat<f64>,
    /// Those that strain the part.
    patterns: Vec<Pattern>,
    /// Missing fraction with 0, 1, … modes, up to those of the superelement that it is known from.
    pub beyond_modes: Vec<f64>,
}

/// One pattern f.
#[derive(Clone, Debug)]
struct Pattern {
    /// Its place among all patterns.
    place: usize,
    /// s² with s G f of unit M norm.
    scale: f64,
    /// s² fᵀ G f.
    whole: f64,
}

impl SpinStrain {
    /// From a superelement with centrifugal columns; `None` for a part that no spin strains.
    pub fn of(
        component: &Component,
        properties: &MassProperties,
        element: &Superelement,
        shapes: RowShapesRef<'_>,
    ) -> Option<Self> {
        let (further, fields) = (element.enrichment.as_ref()?, shapes.enrichment?);
        let forces = spin_forces(component, properties.centre);
        let eigenvalues = &element.modes.eigenvalues;
        let amounts = gram(shapes.modes, forces.as_ref());
        let own = gram(fields, forces.as_ref());
        let first = element.mode_count() + element.boundary_row_count();
        let mut patterns = Vec::new();
        let mut lacking = vec![0.0; eigenvalues.len() + 1];
        for (column, name) in further.names.iter().enumerate() {
            let Some(Answer::Spin(_, place)) = Answer::named(name, element.dimension) else {
                continue;
            };
            let at = (first + column, first + column);
            let carried = |power: i32| -> f64 {
                let modes = eigenvalues.iter().enumerate();
                modes
                    .map(|(k, square)| amounts[(k, place)].powi(2) / square.powi(power))
                    .sum()
            };
            // With no mode kept the column has unit norm, 1 = XᵀMX + s² Σ (φᵀf)² / ω⁴, and XᵀKX = s Xᵀf: whichever keeps its digits.
            let (mass, stiffness) = (further.reduced_mass[at], further.reduced_stiffness[at]);
            let scale = match mass < 0.5 {
                true => (1.0 - mass) / carried(2),
                false => (stiffness / own[(column, place)]).powi(2),
            };
            if !scale.is_finite() {
                continue;
            }
            let whole = stiffness + scale * carried(1);
            patterns.push(Pattern {
                place,
                scale,
                whole,
            });
            let mut beyond = whole;
            lacking[0] += beyond;
            for (k, square) in eigenvalues.iter().enumerate() {
                beyond -= scale * amounts[(k, place)].powi(2) / square;
                lacking[k + 1] += beyond.max(0.0);
            }
        }
        let whole = lacking[0];
        (whole > 0.0).then(|| Self {
            beyond_modes: lacking.iter().map(|part| (part / whole).sqrt()).collect(),
            patterns,
            forces,
        })
    }

    /// Missing fraction with the modes and further columns of a superelement of the same component; `None` if an eigenproblem fails.
    pub fn beyond(&self, element: &Superelement, shapes: RowShapesRef<'_>) -> Option<f64> {
        let Some((further, fields)) = element.enrichment.as_ref().zip(shapes.enrichment) else {
            return self.beyond_modes.get(element.mode_count()).copied();
        };
        let first = element.mode_count() + element.boundary_row_count();
        let of_modes = gram(shapes.modes, self.forces.as_ref());
        let of_further = gram(fields, self.forces.as_ref());
        let count = further.interface_shapes.ncols();
        let own = &further.reduced_stiffness;
        let own = own.submatrix(first, first, count, count);
        let of_further = inverse_root(own, MASS_TOLERANCE)?.transpose() * of_further;
        let mut lacking = 0.0;
        for pattern in &self.patterns {
            let modal = element.modes.eigenvalues.iter().enumerate();
            let modal: f64 = modal
                .map(|(k, square)| of_modes[(k, pattern.place)].powi(2) / square)
                .sum();
            let columns = of_further.col(pattern.place).squared_norm_l2();
            lacking += (pattern.whole - pattern.scale * (modal + columns)).max(0.0);
        }
        let whole: f64 = self.patterns.iter().map(|pattern| pattern.whole).sum();
        Some((lacking / whole).sqrt())
    }
}
