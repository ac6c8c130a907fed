//! Geometric stiffness over the reduced basis.
//!
//! ```text
//! K_ω,ab  =  Ψᵀ K_G,ab Ψ      per product of spins ω_a ω_b        (n, n)
//! K_g,i   =  Ψᵀ K_G,i  Ψ      per unit force on row i of L_b      (n, n)
//! ```
//! The matrices over all dofs come from the FE code, for the free part under each of these loads with its inertia relieved: what the
//! interfaces carry then includes the inertia of whatever acceleration they give the part.

use dcb_dense::symmetrized;
use dcb_formats::SparseMatrix;
use dcb_formats::component::Component;
use dcb_formats::superelement::Stiffening;
use dcb_sparse::block_algebra::symmetric_product;
use faer::{Mat, MatRef};

use crate::model::couplings::BasisColumns;
use crate::model::localization::Localization;

/// Projects the component's geometric stiffness on Ψ, (n_e, n), given as blocks that stand side by side.
pub fn stiffening(
    component: &Component,
    localization: &Localization,
    basis: &[MatRef<'_, f64>],
) -> Stiffening {
    let Some(given) = &component.geometric_stiffness else {
        return Stiffening::default();
    };
    let basis = BasisColumns(basis);
    let n = basis.ncols();
    let centrifugal = given
        .spins
        .iter()
        .map(|matrix| match matrix {
            Some(matrix) => projected(matrix, basis),
            None => Mat::zeros(n, n),
        })
        .collect();
    if given.rows.is_empty() {
        return Stiffening {
            centrifugal,
            interface: Vec::new(),
        };
    }
    let mut interface = vec![Mat::zeros(n, n); localization.len()];
    for of_row in &given.rows {
        let (index, direction) = of_row.row;
        let at = localization
            .rows
            .iter()
            .position(|row| row.interface == index && row.direction == Some(direction));
        if let Some(at) = at {
            interface[at] = projected(&of_row.matrix, basis);
        }
    }
    Stiffening {
        centrifugal,
        interface,
    }
}

/// Note for the user: rows that were given and don't exist.
pub fn unused_rows(component: &Component, localization: &Localization) -> Vec<String> {
    let given = component.geometric_stiffness.iter();
    given
        .flat_map(|given| &given.rows)
        .filter(|of_row| {
            !localization
                .rows
                .iter()
                .any(|row| row.interface == of_row.row.0 && row.direction == Some(of_row.row.1))
        })
        .map(|of_row| {
            format!(
                "geometric stiffness: interface {:?} has no row {}; that file is not used",
                component.interfaces[of_row.row.0].name,
                of_row.row.1.name()
            )
        })
        .collect()
}

fn projected(matrix: &SparseMatrix, basis: BasisColumns<'_>) -> Mat<f64> {
    let n = basis.ncols();
    let mut projected = Mat::zeros(n, n);
    for (first, strip) in basis.strips() {
        let product = symmetric_product(matrix, strip);
        projected
            .as_mut()
            .subcols_mut(first, strip.ncols())
            .copy_from(basis.gram(product.as_ref()));
    }
    symmetrized(projected.as_ref())
}
