//! Inertia invariants of the reduced basis Ψ = [Φ, G_res L_bᵀ]: L1, I1, I3, L3 and, in space, the second-order change of inertia.
//!
//! From the mass matrix and the node coordinates alone, nothing lumped: exact for solids, whose three components share one
//! shape function. Nodes with rotations interpolate differently per component; for them the element-integrated component
//! masses M_cd = ∫ ρ N_cᵀ N_d, where given, make the coupling terms exact.
//!
//! ```text
//! L1      = Tᵀ M Ψ                         (d, n)
//! I3      = X_rᵀ M Ψ                       (1 or 3, n)
//! L3_a    = (Ω_a Ψ)ᵀ M Ψ                   (n, n), antisymmetric
//! J1_ab   = X_raᵀ M Ω_b Ψ + X_rbᵀ M Ω_a Ψ  (n) for each a, b
//! J2_ab   = sym (Ω_a Ψ)ᵀ M (Ω_b Ψ)         (n, n) for each a, b
//! ```
//! with Ω_a u = e_a × u at every node. Planar I1 is half of J1_zz.

use dcb_formats::SparseMatrix;
use dcb_formats::component::{Component, ComponentMasses};
use dcb_formats::mesh::{Dimension, Direction};
use dcb_formats::superelement::Inertia;
use faer::{Mat, MatRef};

use crate::block_algebra::{gram, symmetric_product, symmetrized, transposed_product};
use crate::rigid_body::{MassProperties, component_columns};

/// Pairs (a, b) in the order in which six-fold quantities are stored.
pub const PAIRS: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)];
/// Columns rotated and multiplied by M at a time, to bound memory.
const COLUMNS_AT_A_TIME: usize = 32;

/// Computes all invariants over the component's own dofs; `basis` is Ψ, (n_e, n).
pub fn inertia_invariants(
    component: &Component,
    properties: &MassProperties,
    basis: MatRef<'_, f64>,
) -> Inertia {
    let d = component.dimension().coordinate_count();
    let x = component_columns(component, properties.centre);
    let mass_x = symmetric_product(&component.mass, x.as_ref());
    let coupling = gram(mass_x.as_ref(), basis);
    let l1 = coupling.as_ref().subrows(0, d).to_owned();
    let i3 = coupling.as_ref().subrows(d, x.ncols() - d).to_owned();
    let terms = match &component.component_masses {
        Some(masses) => from_component_masses(component, masses, properties.centre, basis),
        None => from_mass(component, properties.centre, basis),
    };
    Inertia {
        mass: properties.mass,
        tensor: properties.tensor,
        l1,
        i1: terms.i1,
        i3,
        l3: terms.l3,
        i2: terms.i2,
    }
}

struct Terms {
    i1: Vec<[[f64; 3]; 3]>,
    l3: Vec<Mat<f64>>,
    i2: Vec<Mat<f64>>,
}

/// For every dof, the dof that e_a × u takes its value from, and the sign.
fn cross_partners(component: &Component, a: usize) -> Vec<Option<(u32, f64)>> {
    let (next, after) = ((a + 1) % 3, (a + 2) % 3);
    component
        .dofs
        .dofs()
        .iter()
        .map(|dof| {
            if dof.direction.is_rotation() {
                return None;
            }
            let (from, sign) = match dof.direction.axis() {
                axis if axis == next => (after, -1.0),
                axis if axis == after => (next, 1.0),
                _ => return None,
            };
            component
                .dofs
                .row(dof.node, Direction::ALL[from])
                .map(|row| (row as u32, sign))
        })
        .collect()
}

/// Number of nodes that have some translations but not all: e_a × u can't be formed there.
pub fn nodes_with_missing_translations(component: &Component) -> usize {
    let d = component.dimension().coordinate_count();
    (0..component.mesh.node_count() as u32)
        .filter(|node| {
            let present = Direction::ALL[..d]
                .iter()
                .filter(|dir| component.dofs.row(*node, **dir).is_some())
                .count();
            present > 0 && present < d
        })
        .count()
}

/// Rows of Ω_a x.
fn crossed(partners: &[Option<(u32, f64)>], x: MatRef<'_, f64>) -> Mat<f64> {
    Mat::from_fn(partners.len(), x.ncols(), |i, j| {
        partners[i].map_or(0.0, |(row, sign)| sign * x[(row as usize, j)])
    })
}

/// (Ω_a x)ᵀ y without forming all of Ω_a x at once.
fn crossed_gram(
    partners: &[Option<(u32, f64)>],
    x: MatRef<'_, f64>,
    y: MatRef<'_, f64>,
) -> Mat<f64> {
    let mut product = Mat::zeros(x.ncols(), y.ncols());
    for first in (0..x.ncols()).step_by(COLUMNS_AT_A_TIME) {
        let count = COLUMNS_AT_A_TIME.min(x.ncols() - first);
        let part = gram(crossed(partners, x.subcols(first, count)).as_ref(), y);
        product.as_mut().subrows_mut(first, count).copy_from(&part);
    }
    product
}

/// M Ω_b x.
fn mass_of_crossed(
    mass: &SparseMatrix,
    partners: &[Option<(u32, f64)>],
    x: MatRef<'_, f64>,
) -> Mat<f64> {
    let mut product = Mat::zeros(x.nrows(), x.ncols());
    for first in (0..x.ncols()).step_by(COLUMNS_AT_A_TIME) {
        let count = COLUMNS_AT_A_TIME.min(x.ncols() - first);
        let part = symmetric_product(mass, crossed(partners, x.subcols(first, count)).as_ref());
        product.as_mut().subcols_mut(first, count).copy_from(&part);
    }
    product
}

fn antisymmetrized(a: &Mat<f64>) -> Mat<f64> {
    Mat::from_fn(a.nrows(), a.ncols(), |i, j| 0.5 * (a[(i, j)] - a[(j, i)]))
}

/// Invariants as M and the node coordinates give them.
fn from_mass(component: &Component, centre: [f64; 3], basis: MatRef<'_, f64>) -> Terms {
    let n = basis.ncols();
    match component.dimension() {
        Dimension::Planar => {
            let partners = cross_partners(component, 2);
            let mass_basis = symmetric_product(&component.mass, basis);
            let stretch = gram(positions(component, centre).as_ref(), mass_basis.as_ref());
            let l3 = antisymmetrized(&crossed_gram(&partners, basis, mass_basis.as_ref()));
            Terms {
                i1: (0..n).map(|k| planar_i1(stretch[(0, k)])).collect(),
                l3: vec![l3],
                i2: Vec::new(),
            }
        }
        Dimension::Spatial => {
            let partners: [_; 3] = std::array::from_fn(|a| cross_partners(component, a));
            let x = component_columns(component, centre);
            let rotations = x.as_ref().subcols(3, 3);
            let mut i1 = vec![[[0.0; 3]; 3]; n];
            let mut l3 = Vec::new();
            let mut i2: Vec<Mat<f64>> = vec![Mat::zeros(0, 0); PAIRS.len()];
            for b in 0..3 {
                let mass_crossed = mass_of_crossed(&component.mass, &partners[b], basis);
                // (Ω_b Ψ)ᵀ M Ψ is the transpose of Ψᵀ (M Ω_b Ψ).
                l3.push(antisymmetrized(&gram(mass_crossed.as_ref(), basis)));
                let first_order = gram(rotations, mass_crossed.as_ref());
                for (k, block) in i1.iter_mut().enumerate() {
                    for a in 0..3 {
                        block[a][b] += first_order[(a, k)];
                        block[b][a] += first_order[(a, k)];
                    }
                }
                for (pair, (first, second)) in PAIRS.iter().enumerate() {
                    if *second == b {
                        i2[pair] = symmetrized(
                            crossed_gram(&partners[*first], basis, mass_crossed.as_ref()).as_ref(),
                        );
                    }
                }
            }
            Terms { i1, l3, i2 }
        }
    }
}

/// Invariants from S_cd = Ψᵀ M_cd Ψ and G_cd = ∫ ρ r_c ψ_d, which make up every one of them.
///
/// The position r inside the element, off the nodes' line or surface too, is what rigid rotations show: e_a × r = N X_a, so
/// r_x = N_y X_z and so on round, and G_xd = X_zᵀ M_yd Ψ.
fn from_component_masses(
    component: &Component,
    masses: &ComponentMasses,
    centre: [f64; 3],
    basis: MatRef<'_, f64>,
) -> Terms {
    let n = basis.ncols();
    // Position in the stored order of M_cd; M_dc is its transpose.
    let order: &[(usize, usize)] = match component.dimension() {
        Dimension::Planar => &[(0, 0), (1, 1), (0, 1)],
        Dimension::Spatial => &PAIRS,
    };
    let x = component_columns(component, centre);
    let first_rotation = component.dimension().coordinate_count();
    let rotations = x
        .as_ref()
        .subcols(first_rotation, x.ncols() - first_rotation);
    let mut s: [[Mat<f64>; 3]; 3] =
        std::array::from_fn(|_| std::array::from_fn(|_| Mat::zeros(n, n)));
    // h[c][d] = X_rᵀ M_cd Ψ, one row per rotation.
    let mut h: [[Mat<f64>; 3]; 3] =
        std::array::from_fn(|_| std::array::from_fn(|_| Mat::zeros(rotations.ncols(), n)));
    for ((c, d), matrix) in order.iter().zip(&masses.matrices) {
        let transposed = transposed_product(matrix, basis);
        s[*c][*d] = gram(transposed.as_ref(), basis);
        h[*c][*d] = gram(transposed_product(matrix, rotations).as_ref(), basis);
        if c != d {
            s[*d][*c] = s[*c][*d].transpose().to_owned();
            h[*d][*c] = gram(rotations, transposed.as_ref());
        }
    }
    let g: [[Vec<f64>; 3]; 3] = match component.dimension() {
        // r_x = N_y X_z, r_y = -N_x X_z.
        Dimension::Planar => std::array::from_fn(|c| {
            std::array::from_fn(|d| match c {
                0 => (0..n).map(|k| h[1][d][(0, k)]).collect(),
                1 => (0..n).map(|k| -h[0][d][(0, k)]).collect(),
                _ => Vec::new(),
            })
        }),
        // r_c = N_{c+1} X_{c+2}.
        Dimension::Spatial => std::array::from_fn(|c| {
            std::array::from_fn(|d| {
                (0..n)
                    .map(|k| h[(c + 1) % 3][d][((c + 2) % 3, k)])
                    .collect()
            })
        }),
    };
    match component.dimension() {
        Dimension::Planar => Terms {
            i1: (0..n).map(|k| planar_i1(g[0][0][k] + g[1][1][k])).collect(),
            l3: vec![&s[0][1] - s[0][1].transpose()],
            i2: Vec::new(),
        },
        Dimension::Spatial => {
            let i1 = (0..n)
                .map(|k| {
                    let trace = g[0][0][k] + g[1][1][k] + g[2][2][k];
                    std::array::from_fn(|a| {
                        std::array::from_fn(|b| {
                            let diagonal = if a == b { 2.0 * trace } else { 0.0 };
                            diagonal - g[a][b][k] - g[b][a][k]
                        })
                    })
                })
                .collect();
            let l3 = (0..3)
                .map(|a| {
                    antisymmetrized(&(&s[(a + 1) % 3][(a + 2) % 3] - &s[(a + 2) % 3][(a + 1) % 3]))
                })
                .collect();
            let whole = &s[0][0] + &s[1][1] + &s[2][2];
            let i2 = PAIRS
                .iter()
                .map(|(a, b)| {
                    let crossed = symmetrized(s[*a][*b].as_ref());
                    if a == b {
                        symmetrized(whole.as_ref()) - crossed
                    } else {
                        -crossed
                    }
                })
                .collect();
            Terms { i1, l3, i2 }
        }
    }
}

/// Node positions relative to the centre as one displacement field: (x0, 0) with zero rotations.
fn positions(component: &Component, centre: [f64; 3]) -> Mat<f64> {
    Mat::from_fn(component.dofs.len(), 1, |row, _| {
        let dof = component.dofs.dofs()[row];
        match dof.direction.is_rotation() {
            true => 0.0,
            false => {
                component.mesh.position(dof.node)[dof.direction.axis()]
                    - centre[dof.direction.axis()]
            }
        }
    })
}

fn planar_i1(value: f64) -> [[f64; 3]; 3] {
    let mut block = [[0.0; 3]; 3];
    block[2][2] = value;
    block
}
