//! Surface that belongs to each node of an interface: the boundary faces (planar: edges) of the mesh all of whose nodes are in
//! the set, shared among a face's nodes in proportion to ∫ N_i² dA, which stays positive on quadratic faces.

use std::collections::HashMap;

use dcb_formats::component::{Component, Interface, Weights};
use dcb_formats::mesh::{Dimension, Direction, Mesh};

use crate::error::InterfaceRefusal;

/// Faces of a cell by local node numbers, corners first, in meshio's node order.
pub fn faces_of(cell_type: &str, dimension: Dimension) -> &'static [&'static [usize]] {
    match (dimension, cell_type) {
        (Dimension::Planar, "triangle") => &[&[0, 1], &[1, 2], &[2, 0]],
        (Dimension::Planar, "triangle6") => &[&[0, 1, 3], &[1, 2, 4], &[2, 0, 5]],
        (Dimension::Planar, "quad") => &[&[0, 1], &[1, 2], &[2, 3], &[3, 0]],
        (Dimension::Planar, "quad8" | "quad9") => &[&[0, 1, 4], &[1, 2, 5], &[2, 3, 6], &[3, 0, 7]],
        (Dimension::Planar, "line") => &[&[0, 1]],
        (Dimension::Planar, "line3") => &[&[0, 1, 2]],
        (_, "triangle") => &[&[0, 1, 2]],
        (_, "triangle6") => &[&[0, 1, 2, 3, 4, 5]],
        (_, "quad") => &[&[0, 1, 2, 3]],
        (_, "quad8" | "quad9") => &[&[0, 1, 2, 3, 4, 5, 6, 7]],
        (_, "tetra") => &[&[0, 1, 2], &[0, 1, 3], &[1, 2, 3], &[0, 2, 3]],
        (_, "tetra10") => &[
            &[0, 1, 2, 4, 5, 6],
            &[0, 1, 3, 4, 8, 7],
            &[1, 2, 3, 5, 9, 8],
            &[0, 2, 3, 6, 9, 7],
        ],
        (_, "hexahedron") => &[
            &[0, 1, 2, 3],
            &[4, 5, 6, 7],
            &[0, 1, 5, 4],
            &[1, 2, 6, 5],
            &[2, 3, 7, 6],
            &[3, 0, 4, 7],
        ],
        (_, "hexahedron20" | "hexahedron27") => &[
            &[0, 1, 2, 3, 8, 9, 10, 11],
            &[4, 5, 6, 7, 12, 13, 14, 15],
            &[0, 1, 5, 4, 8, 17, 12, 16],
            &[1, 2, 6, 5, 9, 18, 13, 17],
            &[2, 3, 7, 6, 10, 19, 14, 18],
            &[3, 0, 4, 7, 11, 16, 15, 19],
        ],
        (_, "wedge") => &[
            &[0, 1, 2],
            &[3, 4, 5],
            &[0, 1, 4, 3],
            &[1, 2, 5, 4],
            &[2, 0, 3, 5],
        ],
        (_, "wedge15") => &[
            &[0, 1, 2, 6, 7, 8],
            &[3, 4, 5, 9, 10, 11],
            &[0, 1, 4, 3, 6, 13, 9, 12],
            &[1, 2, 5, 4, 7, 14, 10, 13],
            &[2, 0, 3, 5, 8, 12, 11, 14],
        ],
        (_, "pyramid") => &[
            &[0, 1, 2, 3],
            &[0, 1, 4],
            &[1, 2, 4],
            &[2, 3, 4],
            &[3, 0, 4],
        ],
        _ => &[],
    }
}

/// Whether cells of this type are surfaces (planar: edges) rather than volumes (planar: areas).
pub fn is_skin(cell_type: &str, dimension: Dimension) -> bool {
    match dimension {
        Dimension::Planar => cell_type.starts_with("line"),
        Dimension::Spatial => cell_type.starts_with("triangle") || cell_type.starts_with("quad"),
    }
}

/// Shape functions of a face with this many nodes at a local point, and their two local derivatives.
fn shape(node_count: usize, s: f64, t: f64) -> Vec<(f64, f64, f64)> {
    match node_count {
        2 => vec![(0.5 * (1.0 - s), -0.5, 0.0), (0.5 * (1.0 + s), 0.5, 0.0)],
        3 => vec![(1.0 - s - t, -1.0, -1.0), (s, 1.0, 0.0), (t, 0.0, 1.0)],
        4 => CORNERS
            .iter()
            .map(|(a, b)| {
                let (p, q) = (1.0 + a * s, 1.0 + b * t);
                (0.25 * p * q, 0.25 * a * q, 0.25 * b * p)
            })
            .collect(),
        6 => {
            let l = [1.0 - s - t, s, t];
            let (ds, dt) = ([-1.0, 1.0, 0.0], [-1.0, 0.0, 1.0]);
            let corner = |i: usize| {
                let d = 4.0 * l[i] - 1.0;
                (l[i] * (2.0 * l[i] - 1.0), d * ds[i], d * dt[i])
            };
            let middle = |i: usize, j: usize| {
                (
                    4.0 * l[i] * l[j],
                    4.0 * (ds[i] * l[j] + l[i] * ds[j]),
                    4.0 * (dt[i] * l[j] + l[i] * dt[j]),
                )
            };
            vec![
                corner(0),
                corner(1),
                corner(2),
                middle(0, 1),
                middle(1, 2),
                middle(2, 0),
            ]
        }
        _ => {
            let corner = |(a, b): &(f64, f64)| {
                let (p, q) = (1.0 + a * s, 1.0 + b * t);
                let r = a * s + b * t - 1.0;
                (
                    0.25 * p * q * r,
                    0.25 * a * q * (r + p),
                    0.25 * b * p * (r + q),
                )
            };
            let along_s = |b: f64| {
                let (p, q) = (1.0 - s * s, 1.0 + b * t);
                (0.5 * p * q, -s * q, 0.5 * b * p)
            };
            let along_t = |a: f64| {
                let (p, q) = (1.0 + a * s, 1.0 - t * t);
                (0.5 * p * q, 0.5 * a * q, -t * p)
            };
            let mut all: Vec<_> = CORNERS.iter().map(corner).collect();
            all.extend([along_s(-1.0), along_t(1.0), along_s(1.0), along_t(-1.0)]);
            all
        }
    }
}

const CORNERS: [(f64, f64); 4] = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
/// Three-point Gauss rule on (-1, 1): exact to degree 5.
const GAUSS: [(f64, f64); 3] = [
    (-0.774_596_669_241_483_4, 5.0 / 9.0),
    (0.0, 8.0 / 9.0),
    (0.774_596_669_241_483_4, 5.0 / 9.0),
];

/// Integration points (s, t, weight) of a face.
fn quadrature(node_count: usize) -> Vec<(f64, f64, f64)> {
    let square = GAUSS
        .iter()
        .flat_map(|(s, ws)| GAUSS.iter().map(move |(t, wt)| (*s, *t, ws * wt)));
    match node_count {
        2 => GAUSS.iter().map(|(s, w)| (*s, 0.0, *w)).collect(),
        // The square collapsed onto the triangle.
        3 | 6 => square
            .map(|(a, b, w)| {
                let (u, v) = (0.5 * (1.0 + a), 0.5 * (1.0 + b));
                (u, v * (1.0 - u), 0.25 * w * (1.0 - u))
            })
            .collect(),
        _ => square.collect(),
    }
}

/// Share of each node in the face's area (planar: length).
fn shares(mesh: &Mesh, face: &[u32]) -> Vec<f64> {
    let points: Vec<[f64; 3]> = face.iter().map(|node| mesh.position(*node)).collect();
    let is_edge = mesh.dimension == Dimension::Planar;
    let mut squares = vec![0.0; face.len()];
    let mut area = 0.0;
    let points_of_rule = if is_edge {
        quadrature(2)
    } else {
        quadrature(face.len())
    };
    for (s, t, weight) in points_of_rule {
        let functions = match (is_edge, face.len()) {
            (true, 3) => vec![
                (0.5 * s * (s - 1.0), s - 0.5, 0.0),
                (0.5 * s * (s + 1.0), s + 0.5, 0.0),
                (1.0 - s * s, -2.0 * s, 0.0),
            ],
            (_, count) => shape(count, s, t),
        };
        let (mut along_s, mut along_t) = ([0.0; 3], [0.0; 3]);
        for ((_, ds, dt), x) in functions.iter().zip(&points) {
            for axis in 0..3 {
                along_s[axis] += ds * x[axis];
                along_t[axis] += dt * x[axis];
            }
        }
        let jacobian = if is_edge {
            norm(along_s)
        } else {
            norm(cross(along_s, along_t))
        };
        area += weight * jacobian;
        for (square, (n, _, _)) in squares.iter_mut().zip(&functions) {
            *square += weight * jacobian * n * n;
        }
    }
    let total: f64 = squares.iter().sum();
    squares.iter().map(|square| area * square / total).collect()
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

fn norm(a: [f64; 3]) -> f64 {
    a.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// Area (planar: length) that belongs to each of the nodes.
///
/// # Errors
/// A message when the mesh has no boundary face within the set, or a node touches none.
fn area_weights(mesh: &Mesh, nodes: &[u32]) -> Result<Vec<f64>, u32> {
    let position: HashMap<u32, usize> = nodes
        .iter()
        .enumerate()
        .map(|(i, node)| (*node, i))
        .collect();
    // Faces within the set by their sorted nodes: one that occurs twice lies between two cells. Cells that are surfaces
    // themselves (a skin exported beside the volume) count only where no volume cell has that face.
    let mut faces: HashMap<Vec<u32>, (usize, Vec<u32>)> = HashMap::new();
    let mut order = Vec::new();
    let (skins, volumes): (Vec<_>, Vec<_>) = mesh
        .cells
        .iter()
        .partition(|block| is_skin(&block.cell_type, mesh.dimension));
    for (block, of_skin) in volumes
        .iter()
        .map(|b| (b, false))
        .chain(skins.iter().map(|b| (b, true)))
    {
        for cell in block.cells() {
            for local in faces_of(&block.cell_type, mesh.dimension) {
                let face: Vec<u32> = local.iter().map(|i| cell[*i]).collect();
                if face.iter().all(|node| position.contains_key(node)) {
                    let mut key = face.clone();
                    key.sort_unstable();
                    match faces.get_mut(&key) {
                        Some(known) if !of_skin => known.0 += 1,
                        Some(_) => {}
                        None => {
                            order.push(key.clone());
                            faces.insert(key, (1, face));
                        }
                    }
                }
            }
        }
    }
    let mut weights = vec![0.0; nodes.len()];
    for key in &order {
        let (count, face) = &faces[key];
        if *count == 1 {
            for (node, share) in face.iter().zip(shares(mesh, face)) {
                weights[position[node]] += share;
            }
        }
    }
    match weights.iter().position(|weight| *weight <= 0.0) {
        None => Ok(weights),
        Some(at) => Err(nodes[at]),
    }
}

/// Node weights of an averaged interface, positive.
pub(crate) fn weights_of(
    component: &Component,
    interface: &Interface,
) -> Result<Vec<f64>, InterfaceRefusal> {
    match &interface.weights {
        Weights::Uniform => Ok(vec![1.0; interface.nodes.len()]),
        Weights::Given(weights) => Ok(weights.clone()),
        Weights::Area => {
            let no_area = |node| InterfaceRefusal::NoArea {
                interface: interface.name.clone(),
                node,
            };
            area_weights(&component.mesh, &interface.nodes).map_err(no_area)
        }
        Weights::Mass => {
            let translations = &Direction::ALL[..component.dimension().coordinate_count()];
            let mass_at = |node: u32| -> f64 {
                let rows = translations
                    .iter()
                    .filter_map(|direction| component.dofs.row(node, *direction));
                rows.filter_map(|row| component.mass.as_ref().get(row, row))
                    .sum()
            };
            let weights: Vec<f64> = interface.nodes.iter().map(|node| mass_at(*node)).collect();
            match weights.iter().position(|weight| *weight <= 0.0) {
                Some(at) => Err(InterfaceRefusal::NoMass {
                    interface: interface.name.clone(),
                    node: interface.nodes[at],
                }),
                None => Ok(weights),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use dcb_formats::mesh::CellBlock;
    use std::collections::BTreeMap;

    #[test]
    fn weights_of_a_face_sum_to_its_area_and_stay_positive() {
        // One hexahedron20 of 2 x 3 x 1.
        let corners = [(0., 0.), (2., 0.), (2., 3.), (0., 3.)];
        let mut points: Vec<[f64; 3]> = Vec::new();
        for z in [0.0, 1.0] {
            points.extend(corners.iter().map(|(x, y)| [*x, *y, z]));
        }
        let middle =
            |a: usize, b: usize, p: &Vec<[f64; 3]>| [0, 1, 2].map(|i| 0.5 * (p[a][i] + p[b][i]));
        for (a, b) in [
            (0, 1),
            (1, 2),
            (2, 3),
            (3, 0),
            (4, 5),
            (5, 6),
            (6, 7),
            (7, 4),
            (0, 4),
            (1, 5),
            (2, 6),
            (3, 7),
        ] {
            points.push(middle(a, b, &points));
        }
        let mesh = Mesh {
            dimension: Dimension::Spatial,
            coordinates: points.concat(),
            cells: vec![CellBlock {
                cell_type: "hexahedron20".into(),
                nodes_per_cell: 20,
                nodes: (0..20).collect(),
            }],
            point_sets: BTreeMap::new(),
        };
        let weights = area_weights(&mesh, &[0, 1, 2, 3, 8, 9, 10, 11]).unwrap();
        assert!((weights.iter().sum::<f64>() - 6.0).abs() < 1e-13);
        assert!(weights.iter().all(|weight| *weight > 0.0));
        assert!((weights[0] - weights[2]).abs() < 1e-14 && (weights[4] - weights[6]).abs() < 1e-14);
        let side = area_weights(&mesh, &[1, 2, 6, 5, 9, 18, 13, 17]).unwrap();
        assert!((side.iter().sum::<f64>() - 3.0).abs() < 1e-13);
        assert_eq!(area_weights(&mesh, &[0, 1, 2]).unwrap_err(), 0);
    }
}
