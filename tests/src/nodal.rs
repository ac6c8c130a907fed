//! Inertia invariants of solids by loops over nodes: M times a field is one vector per node.

use dcb_formats::Component;
use dcb_formats::mesh::Direction;
use faer::{Mat, MatRef};
use nalgebra::Vector3;

use crate::dense::dense;

/// Pairs of the six-fold quantities.
pub const PAIRS: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)];

/// All invariants of a basis.
pub struct Invariants {
    /// `∫ ρ ψ`, (3, n).
    pub l1: Mat<f64>,
    /// `∫ ρ r × ψ`, (3, n).
    pub i3: Mat<f64>,
    /// `∫ ρ r · ψ`, (n).
    pub stretch: Vec<f64>,
    /// J1.
    pub j1: Vec<[[f64; 3]; 3]>,
    /// `∫ ρ ψ_k × ψ_l`, three matrices.
    pub l3: Vec<Mat<f64>>,
    /// J2, six matrices.
    pub j2: Vec<Mat<f64>>,
}

/// A column of translations as one vector per node.
pub fn vectors(component: &Component, column: MatRef<'_, f64>) -> Vec<Vector3<f64>> {
    (0..component.mesh.node_count() as u32)
        .map(|node| {
            Vector3::from_fn(|axis, _| {
                component
                    .dofs
                    .row(node, Direction::ALL[axis])
                    .map_or(0.0, |row| column[(row, 0)])
            })
        })
        .collect()
}

/// One vector per node as a column of translations; rotations zero.
pub fn column(component: &Component, vectors: &[Vector3<f64>]) -> Mat<f64> {
    let dofs = component.dofs.nodal_dofs();
    Mat::from_fn(dofs.len(), 1, |row, _| {
        match dofs[row].direction.is_rotation() {
            true => 0.0,
            false => vectors[dofs[row].node as usize][dofs[row].direction.axis()],
        }
    })
}

/// Node positions from a point.
pub fn positions(component: &Component, centre: [f64; 3]) -> Vec<Vector3<f64>> {
    (0..component.mesh.node_count() as u32)
        .map(|node| Vector3::from(component.mesh.position(node)) - Vector3::from(centre))
        .collect()
}

/// Invariants from M and the node positions.
pub fn invariants(component: &Component, centre: [f64; 3], basis: MatRef<'_, f64>) -> Invariants {
    let mass = dense(&component.mass);
    let n = basis.ncols();
    let x = positions(component, centre);
    let e = |a: usize| Vector3::ith(a, 1.0);
    let psi: Vec<_> = (0..n)
        .map(|k| vectors(component, basis.subcols(k, 1)))
        .collect();
    let times_mass =
        |field: &[Vector3<f64>]| vectors(component, (&mass * column(component, field)).as_ref());
    let mass_psi: Vec<_> = psi.iter().map(|field| times_mass(field)).collect();
    let crossed = |a: usize, field: &[Vector3<f64>]| -> Vec<_> {
        field.iter().map(|u| e(a).cross(u)).collect()
    };
    let mass_crossed: Vec<Vec<Vec<Vector3<f64>>>> = (0..3)
        .map(|a| {
            psi.iter()
                .map(|field| times_mass(&crossed(a, field)))
                .collect()
        })
        .collect();
    let sum = |a: &[Vector3<f64>], b: &[Vector3<f64>]| {
        a.iter().zip(b).map(|(a, b)| a.dot(b)).sum::<f64>()
    };
    Invariants {
        l1: Mat::from_fn(3, n, |a, k| mass_psi[k].iter().map(|f| f[a]).sum()),
        i3: Mat::from_fn(3, n, |a, k| {
            x.iter().zip(&mass_psi[k]).map(|(x, f)| x.cross(f)[a]).sum()
        }),
        stretch: (0..n).map(|k| sum(&x, &mass_psi[k])).collect(),
        j1: (0..n)
            .map(|k| {
                std::array::from_fn(|a| {
                    std::array::from_fn(|b| {
                        sum(&crossed(a, &x), &mass_crossed[b][k])
                            + sum(&crossed(b, &x), &mass_crossed[a][k])
                    })
                })
            })
            .collect(),
        l3: (0..3)
            .map(|a| {
                Mat::from_fn(n, n, |k, l| {
                    psi[k]
                        .iter()
                        .zip(&mass_psi[l])
                        .map(|(u, f)| u.cross(f)[a])
                        .sum()
                })
            })
            .collect(),
        j2: PAIRS
            .iter()
            .map(|(a, b)| {
                Mat::from_fn(n, n, |k, l| {
                    let one = sum(&crossed(*a, &psi[k]), &mass_crossed[*b][l]);
                    0.5 * (one + sum(&crossed(*a, &psi[l]), &mass_crossed[*b][k]))
                })
            })
            .collect(),
    }
}
