//! Centrifugal forces inside a component: a pattern of nodal forces for each product of spins.

use dcb_formats::SparseMatrix;
use dcb_formats::component::{Component, ComponentMasses};
use dcb_formats::mesh::Dimension;
use dcb_sparse::block_algebra::{symmetric_product, transposed_product};
use faer::{Mat, MatRef};

use crate::model::couplings::{PAIRS, Solid};
use crate::model::rigid_body::component_columns;

/// ∫ ρ Nᵀ S r, (n_e, 6) for S = e_a e_bᵀ + e_b e_aᵀ (a ≠ b) or e_a e_aᵀ; planar (n_e, 1) for S = I.
pub fn spin_forces(component: &Component, centre: [f64; 3]) -> Mat<f64> {
    let moments = match (&component.component_masses, Solid::of(component)) {
        (Some(masses), None) => moments_of_component_masses(component, masses, centre),
        _ => moments_of_mass(component, centre),
    };
    // Column c + 3 d is ∫ ρ N_cᵀ r_d.
    let entry = |i: usize, c: usize, d: usize| moments[(i, c + 3 * d)];
    let n_e = component.dofs.len();
    match component.dimension() {
        Dimension::Planar => Mat::from_fn(n_e, 1, |i, _| entry(i, 0, 0) + entry(i, 1, 1)),
        Dimension::Spatial => Mat::from_fn(n_e, PAIRS.len(), |i, pair| match PAIRS[pair] {
            (a, b) if a == b => entry(i, a, a),
            (a, b) => entry(i, a, b) + entry(i, b, a),
        }),
    }
}

/// `∫ ρ N_cᵀ r_d` = M e_c x_d: exact where the displacement e_c x_d is one of the mesh with internal rows at rest, as for solids.
fn moments_of_mass(component: &Component, centre: [f64; 3]) -> Mat<f64> {
    let mut fields = Mat::zeros(component.dofs.len(), 9);
    for (row, dof) in component.dofs.nodal() {
        for d in (0..3).filter(|_| !dof.direction.is_rotation()) {
            let column = dof.direction.axis() + 3 * d;
            fields[(row, column)] = component.mesh.position(dof.node)[d] - centre[d];
        }
    }
    symmetric_product(&component.mass, fields.as_ref())
}

/// `∫ ρ N_cᵀ r_d` = M_c,d+1 X_d+2, for rigid rotations X show the position off the nodes too: r_d = N_d+1 X_d+2. Planar r_x = N_y X_z,
/// r_y = -N_x X_z.
fn moments_of_component_masses(
    component: &Component,
    masses: &ComponentMasses,
    centre: [f64; 3],
) -> Mat<f64> {
    let order: &[(usize, usize)] = match component.dimension() {
        Dimension::Planar => &[(0, 0), (1, 1), (0, 1)],
        Dimension::Spatial => &PAIRS,
    };
    let columns = component_columns(component, centre);
    let rotation = |axis: usize| match component.dimension() {
        Dimension::Planar => columns.as_ref().subcols(2, 1),
        Dimension::Spatial => columns.as_ref().subcols(3 + axis, 1),
    };
    // M_cd x, from M_cd or from its transpose M_dc.
    let product = |c: usize, d: usize, x: MatRef<'_, f64>| -> Mat<f64> {
        let stored = |pair: (usize, usize)| order.iter().position(|known| *known == pair);
        match (stored((d, c)), stored((c, d))) {
            (Some(at), _) => transposed_product(&masses.matrices[at], x),
            (None, Some(at)) => plain_product(&masses.matrices[at], x),
            (None, None) => Mat::zeros(x.nrows(), x.ncols()),
        }
    };
    let mut moments = Mat::zeros(component.dofs.len(), 9);
    let axes = component.dimension().coordinate_count();
    for c in 0..axes {
        for d in 0..axes {
            let (through, sign) = match component.dimension() {
                Dimension::Planar => (1 - d, if d == 0 { 1.0 } else { -1.0 }),
                Dimension::Spatial => ((d + 1) % 3, 1.0),
            };
            let found = product(c, through, rotation((d + 2) % 3));
            for i in 0..found.nrows() {
                moments[(i, c + 3 * d)] = sign * found[(i, 0)];
            }
        }
    }
    moments
}

/// `A x` for a matrix that isn't symmetric.
fn plain_product(matrix: &SparseMatrix, x: MatRef<'_, f64>) -> Mat<f64> {
    let mut product = Mat::zeros(matrix.nrows(), x.ncols());
    for column in 0..matrix.ncols() {
        let entries = matrix.row_idx_of_col_raw(column);
        for (row, value) in entries.iter().zip(matrix.val_of_col(column)) {
            for k in 0..x.ncols() {
                product[(*row as usize, k)] += value * x[(column, k)];
            }
        }
    }
    product
}
