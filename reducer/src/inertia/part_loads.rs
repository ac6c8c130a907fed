//! Loads on the inside of the part, by what they do to its motions.
//!
//! ```text
//! F = Tᵀ f        M = X_rᵀ f (about the centre of mass)        work = Ψᵀ f
//! ```

use dcb_formats::component::Component;
use dcb_formats::superelement::PartLoad;
use dcb_sparse::block_algebra::gram;
use faer::{Mat, MatRef};

use crate::model::couplings::BasisColumns;
use crate::model::rigid_body::component_columns;

/// The component's named loads over Ψ, (n_e, n), given as blocks that stand side by side.
pub fn part_loads(
    component: &Component,
    centre: [f64; 3],
    basis: &[MatRef<'_, f64>],
) -> Vec<PartLoad> {
    let loads = &component.loads;
    if loads.is_empty() {
        return Vec::new();
    }
    let forces = Mat::from_fn(component.dofs.len(), loads.len(), |i, j| loads[j].forces[i]);
    let work = BasisColumns(basis).gram(forces.as_ref());
    let columns = component_columns(component, centre);
    let resultants = gram(columns.as_ref(), forces.as_ref());
    let d = component.dimension().coordinate_count();
    let turns = resultants.nrows() - d;
    let load = |j: usize| PartLoad {
        name: loads[j].name.clone(),
        force: std::array::from_fn(|a| if a < d { resultants[(a, j)] } else { 0.0 }),
        // Planar: one row, about z.
        moment: std::array::from_fn(|a| match (a + turns).checked_sub(3) {
            Some(row) => resultants[(d + row, j)],
            None => 0.0,
        }),
        work: work.col(j).iter().copied().collect(),
    };
    (0..loads.len()).map(load).collect()
}
