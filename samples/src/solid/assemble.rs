//! Stiffness and consistent mass of a mesh of solid elements, straight into compressed columns.
//!
//! Node neighbourhoods fix the pattern first (3 × 3 blocks for the stiffness, multiples of the identity for the mass),
//! element matrices are computed in parallel and added in the order of the cells. So the sums at (i, j) and (j, i)
//! are the same numbers in the same order: the result is exactly symmetric and doesn't depend on the thread count.

use dcb_formats::SparseMatrix;
use dcb_formats::mesh::{CellBlock, Mesh};
use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;

use super::element::{ShapeFunction, SolidElement};
use crate::material::Material;
use crate::sparse::from_columns;

/// Element matrices computed at a time before they are added up.
const BATCH: usize = 1024;

/// Assembled matrices of a solid; rows are node-major, `ux uy uz`.
#[derive(Clone, Debug)]
pub struct SolidMatrices {
    /// Stiffness, N/m.
    pub stiffness: SparseMatrix,
    /// Consistent mass, kg.
    pub mass: SparseMatrix,
}

/// Assembles every solid cell of the mesh; cells of other types contribute nothing. Nodes without a solid cell get
/// empty rows.
pub fn assemble_solid(mesh: &Mesh, material: &Material) -> SolidMatrices {
    let neighbours = Neighbours::of(mesh);
    let entry_count = neighbours.nodes.len();
    let mut stiffness = vec![0.0; 9 * entry_count];
    let mut mass = vec![0.0; 3 * entry_count];
    for (element, block) in solid_blocks(mesh) {
        let points = EvaluatedPoints::of(element);
        let cells: Vec<&[u32]> = block.cells().collect();
        for batch in cells.chunks(BATCH) {
            let computed: Vec<ElementMatrices> = batch
                .par_iter()
                .map(|cell| ElementMatrices::compute(mesh, cell, &points, material))
                .collect();
            for (cell, matrices) in batch.iter().zip(&computed) {
                matrices.add_to(cell, &neighbours, &mut stiffness, &mut mass);
            }
        }
    }
    neighbours.matrices(stiffness, mass)
}

/// Determinant of the Jacobian at every quadrature point of every solid cell, cell after cell: all positive in a valid
/// mesh.
pub fn jacobian_determinants(mesh: &Mesh) -> Vec<f64> {
    let mut determinants = Vec::new();
    for (element, block) in solid_blocks(mesh) {
        let points = EvaluatedPoints::of(element);
        for cell in block.cells() {
            determinants.extend(
                points
                    .shapes
                    .iter()
                    .map(|shapes| jacobian(mesh, cell, shapes).determinant()),
            );
        }
    }
    determinants
}

pub(super) fn solid_blocks(mesh: &Mesh) -> impl Iterator<Item = (SolidElement, &CellBlock)> {
    mesh.cells
        .iter()
        .filter_map(|block| Some((SolidElement::from_cell_type(&block.cell_type)?, block)))
}

/// `J[i, j] = ∂x_j / ∂ξ_i`.
pub(super) fn jacobian(mesh: &Mesh, cell: &[u32], shapes: &[ShapeFunction]) -> Matrix3<f64> {
    let mut jacobian = Matrix3::zeros();
    for (&node, shape) in cell.iter().zip(shapes) {
        jacobian += Vector3::from(shape.gradient) * Vector3::from(mesh.position(node)).transpose();
    }
    jacobian
}

/// Shape functions at the quadrature points.
struct EvaluatedPoints {
    weights: Vec<f64>,
    shapes: Vec<Vec<ShapeFunction>>,
}

impl EvaluatedPoints {
    fn of(element: SolidElement) -> Self {
        let points = element.quadrature();
        Self {
            weights: points.iter().map(|point| point.weight).collect(),
            shapes: points
                .iter()
                .map(|point| element.shape_functions(point.at))
                .collect(),
        }
    }
}

/// Upper node-block triangle of one element's matrices: pairs (a, b), a ≤ b, row after row.
struct ElementMatrices {
    stiffness: Vec<Matrix3<f64>>,
    mass: Vec<f64>,
}

impl ElementMatrices {
    fn compute(mesh: &Mesh, cell: &[u32], points: &EvaluatedPoints, material: &Material) -> Self {
        let n = cell.len();
        let pair_count = n * (n + 1) / 2;
        let mut stiffness = vec![Matrix3::zeros(); pair_count];
        let mut mass = vec![0.0; pair_count];
        let mut gradients = vec![Vector3::zeros(); n];
        for (shapes, weight) in points.shapes.iter().zip(&points.weights) {
            let jacobian = jacobian(mesh, cell, shapes);
            // An inverted or flat element is the mesh's error and is left to show in the result.
            let inverse = jacobian.try_inverse().unwrap_or_else(Matrix3::zeros);
            let volume = weight * jacobian.determinant();
            for (gradient, shape) in gradients.iter_mut().zip(shapes) {
                *gradient = inverse * Vector3::from(shape.gradient);
            }
            let mut pair = 0;
            for a in 0..n {
                let weighted = gradients[a] * volume;
                let weighted_value = shapes[a].value * volume * material.density;
                for b in a..n {
                    stiffness[pair] += weighted * gradients[b].transpose();
                    mass[pair] += weighted_value * shapes[b].value;
                    pair += 1;
                }
            }
        }
        // From G = ∫ ∇N_a ⊗ ∇N_b:  K_ab = λ G + μ Gᵀ + μ tr(G) 1
        let (lambda, mu) = material.lame();
        for block in &mut stiffness {
            let g = *block;
            *block = g * lambda + g.transpose() * mu + Matrix3::identity() * (mu * g.trace());
        }
        Self { stiffness, mass }
    }

    fn add_to(
        &self,
        cell: &[u32],
        neighbours: &Neighbours,
        stiffness: &mut [f64],
        mass: &mut [f64],
    ) {
        let mut pair = 0;
        for (a, &node_a) in cell.iter().enumerate() {
            for &node_b in &cell[a..] {
                let block = &self.stiffness[pair];
                let value = self.mass[pair];
                if node_a == node_b {
                    // The diagonal block is symmetric up to rounding: keep its upper triangle.
                    neighbours.add(
                        node_a,
                        node_a,
                        |r, c| block[(r.min(c), r.max(c))],
                        value,
                        stiffness,
                        mass,
                    );
                } else {
                    neighbours.add(node_a, node_b, |r, c| block[(r, c)], value, stiffness, mass);
                    neighbours.add(node_b, node_a, |r, c| block[(c, r)], value, stiffness, mass);
                }
                pair += 1;
            }
        }
    }
}

/// Nodes that share a cell with each node, itself included, ascending.
struct Neighbours {
    starts: Vec<usize>,
    nodes: Vec<u32>,
}

impl Neighbours {
    fn of(mesh: &Mesh) -> Self {
        let node_count = mesh.node_count();
        let cells: Vec<&[u32]> = solid_blocks(mesh)
            .flat_map(|(_, block)| block.cells())
            .collect();
        let mut cell_starts = vec![0_usize; node_count + 1];
        for &node in cells.iter().copied().flatten() {
            cell_starts[node as usize + 1] += 1;
        }
        for node in 0..node_count {
            cell_starts[node + 1] += cell_starts[node];
        }
        let mut next = cell_starts.clone();
        let mut cells_of_node = vec![0_u32; cell_starts[node_count]];
        for (cell, nodes) in cells.iter().enumerate() {
            for &node in *nodes {
                cells_of_node[next[node as usize]] = cell as u32;
                next[node as usize] += 1;
            }
        }
        let mut starts = Vec::with_capacity(node_count + 1);
        starts.push(0);
        let mut nodes = Vec::new();
        let mut around = Vec::new();
        for node in 0..node_count {
            around.clear();
            for &cell in &cells_of_node[cell_starts[node]..cell_starts[node + 1]] {
                around.extend_from_slice(cells[cell as usize]);
            }
            around.sort_unstable();
            around.dedup();
            nodes.extend_from_slice(&around);
            starts.push(nodes.len());
        }
        Self { starts, nodes }
    }

    /// Adds `block(r, c)` and `value` times the identity at the node pair (row node, column node).
    fn add(
        &self,
        row: u32,
        column: u32,
        block: impl Fn(usize, usize) -> f64,
        value: f64,
        stiffness: &mut [f64],
        mass: &mut [f64],
    ) {
        let (start, end) = (
            self.starts[column as usize],
            self.starts[column as usize + 1],
        );
        let count = end - start;
        let Ok(position) = self.nodes[start..end].binary_search(&row) else {
            return;
        };
        for c in 0..3 {
            let at = 9 * start + 3 * (c * count + position);
            for r in 0..3 {
                stiffness[at + r] += block(r, c);
            }
            mass[3 * start + c * count + position] += value;
        }
    }

    fn matrices(&self, stiffness: Vec<f64>, mass: Vec<f64>) -> SolidMatrices {
        let node_count = self.starts.len() - 1;
        let size = 3 * node_count;
        let mut stiffness_starts = vec![0_u32];
        let mut stiffness_rows = Vec::with_capacity(stiffness.len());
        let mut mass_starts = vec![0_u32];
        let mut mass_rows = Vec::with_capacity(mass.len());
        for node in 0..node_count {
            let around = &self.nodes[self.starts[node]..self.starts[node + 1]];
            for c in 0..3 {
                stiffness_rows.extend(
                    around
                        .iter()
                        .flat_map(|&row| [3 * row, 3 * row + 1, 3 * row + 2]),
                );
                stiffness_starts.push(stiffness_rows.len() as u32);
                mass_rows.extend(around.iter().map(|&row| 3 * row + c));
                mass_starts.push(mass_rows.len() as u32);
            }
        }
        SolidMatrices {
            stiffness: from_columns(size, stiffness_starts, stiffness_rows, stiffness),
            mass: from_columns(size, mass_starts, mass_rows, mass),
        }
    }
}
