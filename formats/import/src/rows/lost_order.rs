//! The order of rows that got lost, from the null space of the stiffness.
//!
//! The six motions without stiffness are Z = R A, with the rigid motions R of the unknown positions p_i and an unknown A, six by six. The three
//! rows of a node are Z_i = [1, -[p_i]×] A, [v] w = v × w. Less what the first node does, with the motions N that leave it at rest (Z_0 N = 0):
//! ```text
//! U_i = Z_i N = -[q_i]× B⁻¹      q_i = p_i - p_0, B three by three
//! U_i B + (U_i B)ᵀ = 0           for every node: B is the null vector of nine equations in the mean
//! ```
//! so B follows up to a factor, and q_i with it. The factor is the size of the mesh; its sign is tried both ways, because a part that is
//! turned inside out through a point resists rigid motions just as little. Rows are along the component's axes, so nothing has to be turned.
//! Rotations of nodes, where they are, all turn alike in a rigid motion: nothing is lost by leaving them out.

use dcb_formats::SparseMatrix;
use dcb_formats::mesh::Direction;
use nalgebra::{DMatrix, Matrix3, SMatrix, Vector3};

use crate::mesh::FoundMesh;
use crate::rigid_motions::null_space::null_space;
use crate::rigid_motions::resistance;
use crate::rows::order::{node_after_node, row_places};

/// Found order.
pub(crate) struct FoundOrder {
    /// Place in the mesh of each node in the order of the rows.
    pub nodes: Vec<u32>,
    /// Largest distance between a position that follows from K and the node of the mesh there, relative to the size of the mesh.
    pub distance: f64,
    /// Whether the part turned inside out through its middle would fit as well.
    pub has_twin: bool,
}

/// Largest max |K r| / max |K| of an order that is believed.
const BELIEVED: f64 = 1e-9;
/// Largest distance of a node from its place, relative to the size of the mesh, that can be a match at all.
const FARTHEST: f64 = 1e-3;

/// Finds which node of a mesh each block of rows belongs to; `pattern` are the directions of every node, in its rows' order.
///
/// # Errors
/// Why there is none: a message.
pub(crate) fn found_order(
    stiffness: &SparseMatrix,
    mesh: &FoundMesh,
    pattern: &[Direction],
) -> Result<FoundOrder, String> {
    let node_count = mesh.points.len();
    let expected = node_count * pattern.len();
    if stiffness.nrows() != expected {
        return Err(format!(
            "the stiffness has {} rows, but {node_count} nodes with {} directions make {expected}; an order can be found only for a mesh with \
             exactly these nodes",
            stiffness.nrows(),
            pattern.len()
        ));
    }
    let translations: [usize; 3] = {
        let place = |wanted| pattern.iter().position(|direction| *direction == wanted);
        match [Direction::Ux, Direction::Uy, Direction::Uz].map(place) {
            [Some(x), Some(y), Some(z)] => [x, y, z],
            _ => {
                return Err("an order can be found only where every node has ux, uy and uz".into());
            }
        }
    };
    let groups: Vec<u32> = (0..expected)
        .map(|row| (row / pattern.len()) as u32)
        .collect();
    let null_space = null_space(stiffness, &groups)?;
    let of_node = |node: usize| {
        SMatrix::<f64, 3, 6>::from_fn(|axis, motion| {
            null_space[(node * pattern.len() + translations[axis], motion)]
        })
    };
    let places = positions(node_count, of_node)?;
    let mut found: Vec<(FoundOrder, f64)> = Vec::new();
    for sign in [1.0, -1.0] {
        let Some((nodes, distance)) = assigned(&places, &mesh.points, sign) else {
            continue;
        };
        let residual = resistance(
            stiffness,
            &row_places(mesh, &node_after_node(&nodes, pattern)),
        )
        .worst();
        let order = FoundOrder {
            nodes,
            distance,
            has_twin: false,
        };
        found.push((order, residual));
    }
    found.retain(|(_, residual)| *residual < BELIEVED);
    let has_twin = found.len() > 1;
    match found.into_iter().next() {
        Some((order, _)) => Ok(FoundOrder { has_twin, ..order }),
        None => Err(
            "no order of its rows fits this mesh: the positions that follow from K aren't those of its nodes; is it the mesh of these matrices, \
             in the same axes, and is the part free?"
                .into(),
        ),
    }
}

/// Positions of the nodes about the first one, up to one factor for all.
fn positions(
    node_count: usize,
    of_node: impl Fn(usize) -> SMatrix<f64, 3, 6>,
) -> Result<Vec<Vector3<f64>>, String> {
    const DEGENERATE: &str = "the motions without stiffness aren't those of one rigid body; is the part free, and in one piece?";
    // Motions that leave the first node at rest: the null space of its three rows.
    let first = of_node(0);
    let decomposed = (first.transpose() * first).symmetric_eigen();
    let mut by_size: Vec<usize> = (0..6).collect();
    by_size.sort_by(|a, b| decomposed.eigenvalues[*a].total_cmp(&decomposed.eigenvalues[*b]));
    let at_rest = SMatrix::<f64, 6, 3>::from_fn(|row, column| {
        decomposed.eigenvectors[(row, by_size[column])]
    });
    let moved: Vec<Matrix3<f64>> = (0..node_count)
        .map(|node| of_node(node) * at_rest)
        .collect();
    // Six equations a node for the nine entries of B, column by column.
    let mut normal = DMatrix::<f64>::zeros(9, 9);
    for u in &moved {
        for row in 0..3 {
            for column in row..3 {
                let mut equation = [0.0; 9];
                for k in 0..3 {
                    equation[3 * column + k] += u[(row, k)];
                    equation[3 * row + k] += u[(column, k)];
                }
                for a in 0..9 {
                    for b in 0..9 {
                        normal[(a, b)] += equation[a] * equation[b];
                    }
                }
            }
        }
    }
    let decomposed = normal.symmetric_eigen();
    let smallest = decomposed.eigenvalues.imin();
    let b = Matrix3::from_fn(|row, column| decomposed.eigenvectors[(3 * column + row, smallest)]);
    let places: Vec<Vector3<f64>> = moved
        .iter()
        .map(|u| {
            let skew = u * b;
            // -[q]×
            0.5 * Vector3::new(
                skew[(1, 2)] - skew[(2, 1)],
                skew[(2, 0)] - skew[(0, 2)],
                skew[(0, 1)] - skew[(1, 0)],
            )
        })
        .collect();
    match places
        .iter()
        .all(|place| place.iter().all(|x| x.is_finite()))
    {
        true => Ok(places),
        false => Err(DEGENERATE.into()),
    }
}

/// The node of the mesh at each position, and the largest distance from it over the size of the mesh; `None` if some node would be taken twice.
fn assigned(places: &[Vector3<f64>], points: &[[f64; 3]], sign: f64) -> Option<(Vec<u32>, f64)> {
    let points: Vec<Vector3<f64>> = points.iter().map(|point| Vector3::from(*point)).collect();
    let middle = |of: &[Vector3<f64>]| of.iter().sum::<Vector3<f64>>() / of.len() as f64;
    let spread = |of: &[Vector3<f64>], middle: Vector3<f64>| {
        of.iter()
            .map(|place| (place - middle).norm_squared())
            .sum::<f64>()
    };
    let (of_places, of_points) = (middle(places), middle(&points));
    let (found, size) = (spread(places, of_places), spread(&points, of_points));
    let factor = sign * (size / found).sqrt();
    if !factor.is_finite() || factor == 0.0 {
        return None;
    }
    let size = (size / points.len() as f64).sqrt();
    let grid = Grid::of(&points, size * FARTHEST);
    let mut is_taken = vec![false; points.len()];
    let mut farthest = 0.0_f64;
    let mut nodes = Vec::with_capacity(places.len());
    for place in places {
        let place = factor * (place - of_places) + of_points;
        let (node, distance) = grid.nearest(&points, place)?;
        if std::mem::replace(&mut is_taken[node as usize], true) {
            return None;
        }
        farthest = farthest.max(distance);
        nodes.push(node);
    }
    Some((nodes, farthest / size))
}

/// Points in cubes, to find those near a place.
struct Grid {
    width: f64,
    cubes: rustc_hash::FxHashMap<[i64; 3], Vec<u32>>,
}

impl Grid {
    fn of(points: &[Vector3<f64>], width: f64) -> Self {
        let mut grid = Self {
            width,
            cubes: rustc_hash::FxHashMap::default(),
        };
        for (point, node) in points.iter().zip(0..) {
            grid.cubes.entry(grid.cube(*point)).or_default().push(node);
        }
        grid
    }

    fn cube(&self, place: Vector3<f64>) -> [i64; 3] {
        std::array::from_fn(|axis| (place[axis] / self.width).floor() as i64)
    }

    /// The nearest point within the width of a cube.
    fn nearest(&self, points: &[Vector3<f64>], place: Vector3<f64>) -> Option<(u32, f64)> {
        let middle = self.cube(place);
        let mut best: Option<(u32, f64)> = None;
        for number in 0..27_i64 {
            let cube = [
                middle[0] + number % 3 - 1,
                middle[1] + number / 3 % 3 - 1,
                middle[2] + number / 9 - 1,
            ];
            for &node in self.cubes.get(&cube).into_iter().flatten() {
                let distance = (points[node as usize] - place).norm();
                if best.is_none_or(|(_, least)| distance < least) {
                    best = Some((node, distance));
                }
            }
        }
        best.filter(|(_, distance)| *distance <= self.width)
    }
}
