//! Inertia invariants of the reduced basis Ψ = [Φ, G_res L_bᵀ]: L1, I1, I3, L3 and, in space, the second-order change of inertia.
//!
//! From the mass matrix and the node coordinates alone, nothing lumped: exact for solids, whose three components share one
//! shape function. Nodes with rotations interpolate differently per component; for them the element-integrated component
//! masses M_cd = ∫ ρ N_cᵀ N_d, where given, make the coupling terms exact. With them, and on solids, everything follows from
//! the couplings of directions (`crate::model::couplings`); other parts take the definitions below as they stand.
//!
//! ```text
//! L1      = Tᵀ M Ψ                         (d, n)
//! I3      = X_rᵀ M Ψ                       (1 or 3, n)
//! L3_a    = (Ω_a Ψ)ᵀ M Ψ                   (n, n), antisymmetric
//! J1_ab   = X_raᵀ M Ω_b Ψ + X_rbᵀ M Ω_a Ψ  (n) for each a, b
//! J2_ab   = sym (Ω_a Ψ)ᵀ M (Ω_b Ψ)         (n, n) for each a, b
//! ```
//! with Ω_a u = e_a × u at every node, and nothing in internal rows. Planar I1 is half of J1_zz.

use dcb_dense::symmetrized;
use dcb_formats::component::Component;
use dcb_formats::mesh::{Dimension, Direction};
use dcb_formats::superelement::CouplingSource;
use dcb_formats::superelement::Inertia;
use dcb_sparse::block_algebra::{gram, symmetric_product};
use faer::{Mat, MatRef};

use crate::model::couplings::{BasisColumns, Couplings, Solid};
use crate::model::rigid_body::{MassProperties, component_columns};

pub use crate::model::couplings::PAIRS;

/// Computes all invariants over the component's own dofs, and says what they come from; `basis` is Ψ, (n_e, n), as blocks that stand
/// side by side.
pub fn inertia_invariants(
    component: &Component,
    properties: &MassProperties,
    basis: &[MatRef<'_, f64>],
) -> (Inertia, CouplingSource) {
    let basis = BasisColumns(basis);
    let centre = properties.centre;
    let d = component.dimension().coordinate_count();
    let x = component_columns(component, centre);
    let mass_x = symmetric_product(&component.mass, x.as_ref());
    let coupling = basis.gram(mass_x.as_ref());
    let coupling = coupling.transpose();
    let l1 = coupling.subrows(0, d).to_owned();
    let i3 = coupling.subrows(d, x.ncols() - d).to_owned();
    let couplings = match &component.component_masses {
        Some(masses) => Some(Couplings::of_component_masses(
            component, masses, centre, basis,
        )),
        None => {
            Solid::of(component).map(|solid| Couplings::of_solid(component, &solid, centre, basis))
        }
    };
    let (terms, source) = match &couplings {
        Some(couplings) => (
            from_couplings(component.dimension(), couplings),
            CouplingSource::Integrals,
        ),
        None => (from_mass(component, centre, basis), CouplingSource::Nodal),
    };
    let inertia = Inertia {
        mass: properties.mass,
        tensor: properties.tensor,
        l1,
        i1: terms.i1,
        i3,
        l3: terms.l3,
        i2: terms.i2,
    };
    (inertia, source)
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
        .rows()
        .iter()
        .map(|row| {
            let dof = row.dof()?;
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

/// Ω_a x.
fn crossed(partners: &[Option<(u32, f64)>], x: MatRef<'_, f64>) -> Mat<f64> {
    Mat::from_fn(partners.len(), x.ncols(), |i, j| {
        partners[i].map_or(0.0, |(row, sign)| sign * x[(row as usize, j)])
    })
}

fn antisymmetrized(a: &Mat<f64>) -> Mat<f64> {
    Mat::from_fn(a.nrows(), a.ncols(), |i, j| 0.5 * (a[(i, j)] - a[(j, i)]))
}

/// Invariants as M and the node coordinates give them.
fn from_mass(component: &Component, centre: [f64; 3], basis: BasisColumns<'_>) -> Terms {
    let n = basis.ncols();
    match component.dimension() {
        Dimension::Planar => {
            let partners = cross_partners(component, 2);
            let mass_positions =
                symmetric_product(&component.mass, positions(component, centre).as_ref());
            let stretch = basis.gram(mass_positions.as_ref());
            let mut l3 = Mat::zeros(n, n);
            for (first, strip) in basis.strips() {
                let mass_strip = symmetric_product(&component.mass, strip);
                // Ω is antisymmetric: (Ω Ψ)ᵀ M Ψ = -Ψᵀ Ω (M Ψ).
                let crossed = crossed(&partners, mass_strip.as_ref());
                let mut l3 = l3.as_mut().subcols_mut(first, strip.ncols());
                l3 -= basis.gram(crossed.as_ref());
            }
            Terms {
                i1: (0..n).map(|k| planar_i1(stretch[(k, 0)])).collect(),
                l3: vec![antisymmetrized(&l3)],
                i2: Vec::new(),
            }
        }
        Dimension::Spatial => {
            let partners: [_; 3] = std::array::from_fn(|a| cross_partners(component, a));
            let x = component_columns(component, centre);
            let rotations = x.as_ref().subcols(3, 3);
            let mut i1 = vec![[[0.0; 3]; 3]; n];
            let mut l3 = vec![Mat::zeros(n, n); 3];
            let mut i2 = vec![Mat::zeros(n, n); PAIRS.len()];
            for (first, strip) in basis.strips() {
                for b in 0..3 {
                    let mass_crossed =
                        symmetric_product(&component.mass, crossed(&partners[b], strip).as_ref());
                    let first_order = gram(rotations, mass_crossed.as_ref());
                    for (k, block) in i1[first..][..strip.ncols()].iter_mut().enumerate() {
                        for a in 0..3 {
                            block[a][b] += first_order[(a, k)];
                            block[b][a] += first_order[(a, k)];
                        }
                    }
                    // (Ω_b Ψ)ᵀ M Ψ is the transpose of Ψᵀ (M Ω_b Ψ).
                    let mut l3 = l3[b].as_mut().subcols_mut(first, strip.ncols());
                    l3 -= basis.gram(mass_crossed.as_ref());
                    for (pair, (a, second)) in PAIRS.iter().enumerate() {
                        if *second == b {
                            // Ω is antisymmetric: (Ω_a Ψ)ᵀ M Ω_b Ψ = -Ψᵀ Ω_a (M Ω_b Ψ).
                            let crossed = crossed(&partners[*a], mass_crossed.as_ref());
                            let mut i2 = i2[pair].as_mut().subcols_mut(first, strip.ncols());
                            i2 -= basis.gram(crossed.as_ref());
                        }
                    }
                }
            }
            Terms {
                i1,
                l3: l3.iter().map(antisymmetrized).collect(),
                i2: i2.iter().map(|i2| symmetrized(i2.as_ref())).collect(),
            }
        }
    }
}

/// Invariants as linear combinations of S and G.
fn from_couplings(dimension: Dimension, couplings: &Couplings) -> Terms {
    let Couplings { s, g } = couplings;
    let n = g[0][0].len();
    match dimension {
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

/// Node positions relative to the centre as one displacement field: (x0, 0) with zero rotations and internal rows.
fn positions(component: &Component, centre: [f64; 3]) -> Mat<f64> {
    let mut field = Mat::zeros(component.dofs.len(), 1);
    for (row, dof) in component.dofs.nodal() {
        if !dof.direction.is_rotation() {
            let axis = dof.direction.axis();
            field[(row, 0)] = component.mesh.position(dof.node)[axis] - centre[axis];
        }
    }
    field
}

fn planar_i1(value: f64) -> [[f64; 3]; 3] {
    let mut block = [[0.0; 3]; 3];
    block[2][2] = value;
    block
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use dcb_samples::{Material, PseudoRandom, RodSection, SolidElement};
    use dcb_sparse::block_algebra::largest_entry;

    fn block() -> Component {
        let size = [0.2, 0.1, 0.05];
        dcb_samples::box_block(
            [5, 4, 3],
            size,
            SolidElement::Hexahedron20,
            &Material::STEEL,
        )
    }

    fn largest_difference(a: &Mat<f64>, b: &Mat<f64>) -> f64 {
        largest_entry((a - b).as_ref()) / largest_entry(b.as_ref())
    }

    /// Couplings of directions and the definitions are two ways to the same numbers.
    #[test]
    fn invariants_of_a_solid_agree_with_their_definitions() {
        let component = block();
        let solid = Solid::of(&component).unwrap();
        let centre = MassProperties::of(&component).unwrap().centre;
        let (modes, attachments) = (
            PseudoRandom::new(5).matrix(component.dofs.len(), 37),
            PseudoRandom::new(5).matrix(component.dofs.len(), 70),
        );
        let parts = [modes.as_ref(), attachments.as_ref()];
        let basis = BasisColumns(&parts);
        let found = from_couplings(
            component.dimension(),
            &Couplings::of_solid(&component, &solid, centre, basis),
        );
        let defined = from_mass(&component, centre, basis);
        for (a, b) in found.l3.iter().zip(&defined.l3) {
            assert!(largest_difference(a, b) < 1e-13);
        }
        for (a, b) in found.i2.iter().zip(&defined.i2) {
            assert!(largest_difference(a, b) < 1e-13);
        }
        let flat = |i1: &[[[f64; 3]; 3]]| {
            Mat::from_fn(9 * i1.len(), 1, |i, _| i1[i / 9][i % 9 / 3][i % 3])
        };
        assert!(largest_difference(&flat(&found.i1), &flat(&defined.i1)) < 1e-13);
    }

    /// A mass that differs between directions, or couples them, is no solid's, however little.
    #[test]
    fn only_equal_directions_make_a_solid() {
        let component = block()
            .changed(|draft| draft.mass.val_mut()[17] *= 1.0 + 1e-12)
            .unwrap();
        assert!(Solid::of(&component).is_none());
        let rod = dcb_samples::planar_rod(4, &RodSection::default());
        assert!(Solid::of(&rod).is_none());
    }

    #[test]
    fn invariants_do_not_depend_on_the_number_of_threads() {
        let component = block();
        let properties = MassProperties::of(&component).unwrap();
        let basis = PseudoRandom::new(5).matrix(component.dofs.len(), 40);
        let run = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .unwrap();
            pool.install(|| inertia_invariants(&component, &properties, &[basis.as_ref()]).0)
        };
        let (one, three) = (run(1), run(3));
        assert_eq!(one.l3, three.l3);
        assert_eq!(one.i2, three.i2);
        assert_eq!(one.i1, three.i1);
    }
}
