//! Couplings between the directions of a reduced basis Ψ, from which all invariants of inertia follow:
//!
//! ```text
//! S_cd = ∫ ρ ψ_c ψ_d = Ψᵀ M_cd Ψ      (n, n) for each c, d; S_dc = S_cdᵀ
//! G_cd = ∫ ρ r_c ψ_d                  (n) for each c, d
//! ```
//! from element-integrated component masses M_cd, or from the mass matrix of a solid, which is the same matrix m in every
//! direction: with Ψ_c the rows of direction c, S_cd = Ψ_cᵀ m Ψ_d and m Ψ_d are rows of M Ψ. Neither holds a second array of Ψ's
//! size.

use dcb_formats::component::{Component, ComponentMasses};
use dcb_formats::mesh::{Dimension, Direction};
use dcb_sparse::block_algebra::{gram, symmetric_product_into, transposed_product};
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef, Par};
use rayon::prelude::*;

use crate::model::rigid_body::component_columns;

/// Pairs (a, b) in the order in which six-fold quantities are stored.
pub const PAIRS: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)];
/// Columns multiplied by M at a time, to bound memory.
const COLUMNS_AT_A_TIME: usize = 80;
/// Nodes whose rows of Ψ are gathered at a time: they stay in the cache of one core.
const NODES_AT_A_TIME: usize = 256;
/// Nodes per task, whose sums are added in order.
const NODES_PER_TASK: usize = 4 * NODES_AT_A_TIME;
/// Relative difference of two directions' mass that is rounding.
const ROUNDING: f64 = 16.0 * f64::EPSILON;

/// Ψ as blocks that stand side by side.
#[derive(Clone, Copy)]
pub struct BasisColumns<'a>(pub &'a [MatRef<'a, f64>]);

impl<'a> BasisColumns<'a> {
    /// n.
    pub fn ncols(self) -> usize {
        self.0.iter().map(|part| part.ncols()).sum()
    }

    /// Each block with the column that it starts at.
    pub fn parts(self) -> impl Iterator<Item = (usize, MatRef<'a, f64>)> {
        self.0.iter().scan(0, |start, part| {
            let first = *start;
            *start += part.ncols();
            Some((first, *part))
        })
    }

    /// All columns, a few at a time.
    pub fn strips(self) -> impl Iterator<Item = (usize, MatRef<'a, f64>)> {
        self.parts().flat_map(|(start, part)| {
            (0..part.ncols())
                .step_by(COLUMNS_AT_A_TIME)
                .map(move |first| {
                    let count = COLUMNS_AT_A_TIME.min(part.ncols() - first);
                    (start + first, part.subcols(first, count))
                })
        })
    }

    /// `Ψᵀ y`, (n, k).
    pub fn gram(self, y: MatRef<'_, f64>) -> Mat<f64> {
        let mut product = Mat::zeros(self.ncols(), y.ncols());
        for (start, part) in self.parts() {
            product
                .as_mut()
                .subrows_mut(start, part.ncols())
                .copy_from(gram(part, y));
        }
        product
    }
}

/// S and G; in the plane only what has a use there: S_xy, and G_xx and G_yy.
pub struct Couplings {
    /// S_cd.
    pub s: [[Mat<f64>; 3]; 3],
    /// G_cd.
    pub g: [[Vec<f64>; 3]; 3],
}

impl Couplings {
    fn zero(n: usize) -> Self {
        Self {
            s: std::array::from_fn(|_| std::array::from_fn(|_| Mat::zeros(n, n))),
            g: std::array::from_fn(|_| std::array::from_fn(|_| vec![0.0; n])),
        }
    }

    /// From M_cd = ∫ ρ N_cᵀ N_d.
    ///
    /// The position r inside the element, off the nodes' line or surface too, is what rigid rotations show: e_a × r = N X_a, so
    /// r_x = N_y X_z and so on round, and G_xd = X_zᵀ M_yd Ψ.
    pub fn of_component_masses(
        component: &Component,
        masses: &ComponentMasses,
        centre: [f64; 3],
        basis: BasisColumns<'_>,
    ) -> Self {
        // Position in the stored order of M_cd; M_dc is its transpose.
        let order: &[(usize, usize)] = match component.dimension() {
            Dimension::Planar => &[(0, 0), (1, 1), (0, 1)],
            Dimension::Spatial => &PAIRS,
        };
        let n = basis.ncols();
        let x = component_columns(component, centre);
        let first_rotation = component.dimension().coordinate_count();
        let rotations = x
            .as_ref()
            .subcols(first_rotation, x.ncols() - first_rotation);
        let mut found = Self::zero(n);
        // h[c][d] = X_rᵀ M_cd Ψ, one row per rotation.
        let mut h: [[Mat<f64>; 3]; 3] =
            std::array::from_fn(|_| std::array::from_fn(|_| Mat::zeros(rotations.ncols(), n)));
        for ((c, d), matrix) in order.iter().zip(&masses.matrices) {
            for (first, strip) in basis.strips() {
                let transposed = transposed_product(matrix, strip);
                found.s[*d][*c]
                    .as_mut()
                    .subcols_mut(first, strip.ncols())
                    .copy_from(basis.gram(transposed.as_ref()));
                h[*d][*c]
                    .as_mut()
                    .subcols_mut(first, strip.ncols())
                    .copy_from(gram(rotations, transposed.as_ref()));
            }
            if c != d {
                found.s[*c][*d] = found.s[*d][*c].transpose().to_owned();
                let mass_rotations = transposed_product(matrix, rotations);
                h[*c][*d] = basis.gram(mass_rotations.as_ref()).transpose().to_owned();
            }
        }
        found.g = match component.dimension() {
            // r_x = N_y X_z, r_y = -N_x X_z.
            Dimension::Planar => std::array::from_fn(|c| {
                std::array::from_fn(|d| match c {
                    0 => h[1][d].row(0).iter().copied().collect(),
                    1 => h[0][d].row(0).iter().map(|value| -value).collect(),
                    _ => Vec::new(),
                })
            }),
            // r_c = N_{c+1} X_{c+2}.
            Dimension::Spatial => std::array::from_fn(|c| {
                std::array::from_fn(|d| {
                    let about = h[(c + 1) % 3][d].row((c + 2) % 3);
                    about.iter().copied().collect()
                })
            }),
        };
        found
    }

    /// From the mass matrix of a solid.
    pub fn of_solid(
        component: &Component,
        solid: &Solid,
        centre: [f64; 3],
        basis: BasisColumns<'_>,
    ) -> Self {
        let d = component.dimension().coordinate_count();
        let n = basis.ncols();
        let pairs: &[(usize, usize)] = match component.dimension() {
            Dimension::Planar => &[(0, 1)],
            Dimension::Spatial => &PAIRS,
        };
        let mut found = Self::zero(n);
        let mut product = Mat::zeros(component.dofs.len(), COLUMNS_AT_A_TIME.min(n));
        for (first, strip) in basis.strips() {
            let mut product = product.as_mut().subcols_mut(0, strip.ncols());
            symmetric_product_into(&component.mass, strip, product.as_mut());
            let product = product.as_ref();
            let sums: Vec<Strip> = solid
                .nodes
                .par_chunks(NODES_PER_TASK)
                .map(|nodes| {
                    let mut sums = Strip::zero(pairs.len(), d, n, strip.ncols());
                    let mut room = Room::empty();
                    for nodes in nodes.chunks(NODES_AT_A_TIME) {
                        room.positions = Mat::from_fn(nodes.len(), d, |i, c| {
                            component.mesh.position(nodes[i].node)[c] - centre[c]
                        });
                        sums.add(pairs, d, first, nodes, basis, product, &mut room);
                    }
                    sums
                })
                .collect();
            for strip_sums in &sums {
                for ((a, b), sum) in pairs.iter().zip(&strip_sums.s) {
                    let mut s = found.s[*a][*b].as_mut().subcols_mut(first, strip.ncols());
                    s += sum;
                }
                for (b, sum) in strip_sums.g.iter().enumerate() {
                    for a in 0..d {
                        for j in 0..strip.ncols() {
                            found.g[a][b][first + j] += sum[(a, j)];
                        }
                    }
                }
            }
        }
        for (a, b) in pairs {
            if a == b {
                // Only rows from a strip's first on were computed.
                let s = &mut found.s[*a][*a];
                for j in 0..n {
                    for i in 0..j {
                        s[(i, j)] = s[(j, i)];
                    }
                }
            } else {
                found.s[*b][*a] = found.s[*a][*b].transpose().to_owned();
            }
        }
        found
    }
}

/// Parts of S and G that belong to a few columns.
struct Strip {
    /// For each pair (a, b), (n, columns).
    s: Vec<Mat<f64>>,
    /// For each direction b, (d, columns).
    g: Vec<Mat<f64>>,
}

/// Gathered rows, one block per direction.
struct Room {
    basis: [Mat<f64>; 3],
    product: [Mat<f64>; 3],
    positions: Mat<f64>,
}

impl Room {
    fn empty() -> Self {
        Self {
            basis: std::array::from_fn(|_| Mat::new()),
            product: std::array::from_fn(|_| Mat::new()),
            positions: Mat::new(),
        }
    }
}

impl Strip {
    fn zero(pairs: usize, d: usize, n: usize, columns: usize) -> Self {
        Self {
            s: (0..pairs).map(|_| Mat::zeros(n, columns)).collect(),
            g: (0..d).map(|_| Mat::zeros(d, columns)).collect(),
        }
    }

    /// Adds what some nodes contribute to the columns from `first` on, whose product with M is given.
    #[allow(clippy::too_many_arguments)] // the two sides of a product, and where it goes
    fn add(
        &mut self,
        pairs: &[(usize, usize)],
        d: usize,
        first: usize,
        nodes: &[SolidNode],
        basis: BasisColumns<'_>,
        product: MatRef<'_, f64>,
        room: &mut Room,
    ) {
        gather(d, nodes, BasisColumns(&[product]), &mut room.product);
        gather(d, nodes, basis, &mut room.basis);
        let add = |to: &mut Mat<f64>, skipped: usize, left: &Mat<f64>, right: &Mat<f64>| {
            let count = left.ncols() - skipped;
            matmul(
                to.as_mut().subrows_mut(skipped, count),
                Accum::Add,
                left.as_ref().subcols(skipped, count).transpose(),
                right,
                1.0,
                Par::Seq,
            );
        };
        for ((a, b), s) in pairs.iter().zip(&mut self.s) {
            let skipped = if a == b { first } else { 0 };
            add(s, skipped, &room.basis[*a], &room.product[*b]);
        }
        for (b, g) in self.g.iter_mut().enumerate() {
            add(g, 0, &room.positions, &room.product[b]);
        }
    }
}

/// The rows of some nodes, each direction by itself.
fn gather(d: usize, nodes: &[SolidNode], from: BasisColumns<'_>, to: &mut [Mat<f64>; 3]) {
    for block in &mut to[..d] {
        if (block.nrows(), block.ncols()) != (nodes.len(), from.ncols()) {
            *block = Mat::zeros(nodes.len(), from.ncols());
        }
    }
    for (start, part) in from.parts() {
        for j in 0..part.ncols() {
            let column = part.col(j);
            for (c, block) in to[..d].iter_mut().enumerate() {
                let entries = block.col_as_slice_mut(start + j).iter_mut().zip(nodes);
                for (entry, node) in entries {
                    *entry = column[node.rows[c] as usize];
                }
            }
        }
    }
}

/// A node with its rows of ux, uy and, in space, uz.
struct SolidNode {
    node: u32,
    rows: [u32; 3],
}

/// A component whose nodes have all translations and no rotations, and whose mass matrix is the same in every direction, with
/// nothing between directions.
pub struct Solid {
    nodes: Vec<SolidNode>,
}

impl Solid {
    /// The component as a solid, if it is one; differences between directions of the size of rounding don't count.
    pub fn of(component: &Component) -> Option<Self> {
        if component.dofs.internal_count() > 0 {
            return None;
        }
        let d = component.dimension().coordinate_count();
        let solid = |node: u32| -> Option<Option<SolidNode>> {
            let found = Direction::ALL.map(|direction| component.dofs.row(node, direction));
            let mut rows = [0; 3];
            for (row, found) in rows[..d].iter_mut().zip(found) {
                *row = found.unwrap_or(0) as u32;
            }
            match found[..d].iter().flatten().count() {
                0 => Some(None),
                all if all == d => Some(Some(SolidNode { node, rows })),
                _ => None,
            }
        };
        let all = (0..component.mesh.node_count() as u32).into_par_iter();
        let all: Vec<Option<SolidNode>> = all.map(solid).collect::<Option<_>>()?;
        let nodes: Vec<SolidNode> = all.into_iter().flatten().collect();
        let same = nodes
            .par_iter()
            .all(|node| has_equal_directions(component, &node.rows[..d]));
        (d * nodes.len() == component.dofs.len() && same).then_some(Self { nodes })
    }

    /// Rows of ux.
    pub fn rows_along_x(&self) -> impl Iterator<Item = u32> {
        self.nodes.iter().map(|node| node.rows[0])
    }
}

/// Whether a node's rows of M have the same entries in the same order, each in its own direction.
fn has_equal_directions(component: &Component, rows: &[u32]) -> bool {
    let dofs = &component.dofs;
    let entries = |c: usize| {
        let row = rows[c] as usize;
        component
            .mass
            .row_idx_of_col(row)
            .zip(component.mass.val_of_col(row))
            .filter(|(_, value)| **value != 0.0)
            .filter_map(|(column, value)| Some((dofs.dof(column)?, *value)))
    };
    let size = entries(0).map(|(_, value)| value.abs()).fold(0.0, f64::max);
    (0..rows.len()).all(|c| {
        entries(c).count() == entries(0).count()
            && entries(c).zip(entries(0)).all(|(own, first)| {
                own.0.direction.index() == c
                    && own.0.node == first.0.node
                    && (own.1 - first.1).abs() <= ROUNDING * size
            })
    })
}
