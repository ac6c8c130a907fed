//! The outside of a mesh as triangles, through all nodes that lie on it.
//!
//! Faces of solid cells that no second cell shares, and cells that are faces themselves. Faces with mid-edge nodes become several flat triangles.

use std::collections::HashMap;

use dcb_formats::mesh::{CellBlock, Mesh};
use nalgebra::Vector3;

/// Corners and faces of a cell, and which corners each mid-edge node is between; nodes as meshio orders them.
struct Shape {
    name: &'static str,
    corners: usize,
    faces: &'static [&'static [usize]],
    edges: &'static [(usize, usize)],
}

const TETRA: &[&[usize]] = &[&[0, 2, 1], &[0, 1, 3], &[1, 2, 3], &[0, 3, 2]];
const HEXA: &[&[usize]] = &[
    &[0, 3, 2, 1],
    &[4, 5, 6, 7],
    &[0, 1, 5, 4],
    &[1, 2, 6, 5],
    &[2, 3, 7, 6],
    &[3, 0, 4, 7],
];
const WEDGE: &[&[usize]] = &[
    &[0, 2, 1],
    &[3, 4, 5],
    &[0, 1, 4, 3],
    &[1, 2, 5, 4],
    &[2, 0, 3, 5],
];
const PYRAMID: &[&[usize]] = &[
    &[0, 3, 2, 1],
    &[0, 1, 4],
    &[1, 2, 4],
    &[2, 3, 4],
    &[3, 0, 4],
];
const TRIANGLE: &[&[usize]] = &[&[0, 1, 2]];
const QUAD: &[&[usize]] = &[&[0, 1, 2, 3]];
const TETRA_EDGES: &[(usize, usize)] = &[(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)];
const HEXA_EDGES: &[(usize, usize)] = &[
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
];
const WEDGE_EDGES: &[(usize, usize)] = &[
    (0, 1),
    (1, 2),
    (2, 0),
    (3, 4),
    (4, 5),
    (5, 3),
    (0, 3),
    (1, 4),
    (2, 5),
];
const PYRAMID_EDGES: &[(usize, usize)] = &[
    (0, 1),
    (1, 2),
    (2, 3),
    (3, 0),
    (0, 4),
    (1, 4),
    (2, 4),
    (3, 4),
];
const TRIANGLE_EDGES: &[(usize, usize)] = &[(0, 1), (1, 2), (2, 0)];
const QUAD_EDGES: &[(usize, usize)] = &[(0, 1), (1, 2), (2, 3), (3, 0)];

const fn shape(
    name: &'static str,
    corners: usize,
    faces: &'static [&'static [usize]],
    edges: &'static [(usize, usize)],
) -> Shape {
    Shape {
        name,
        corners,
        faces,
        edges,
    }
}

const SHAPES: [Shape; 14] = [
    shape("tetra", 4, TETRA, &[]),
    shape("tetra10", 4, TETRA, TETRA_EDGES),
    shape("hexahedron", 8, HEXA, &[]),
    shape("hexahedron20", 8, HEXA, HEXA_EDGES),
    shape("hexahedron27", 8, HEXA, HEXA_EDGES),
    shape("wedge", 6, WEDGE, &[]),
    shape("wedge15", 6, WEDGE, WEDGE_EDGES),
    shape("pyramid", 5, PYRAMID, &[]),
    shape("pyramid13", 5, PYRAMID, PYRAMID_EDGES),
    shape("triangle", 3, TRIANGLE, &[]),
    shape("triangle6", 3, TRIANGLE, TRIANGLE_EDGES),
    shape("quad", 4, QUAD, &[]),
    shape("quad8", 4, QUAD, QUAD_EDGES),
    shape("quad9", 4, QUAD, QUAD_EDGES),
];

/// Triangles of nodes of the mesh, seen from outside against the clock.
pub struct Surface {
    /// Corners of the triangles, nodes of the mesh.
    pub triangles: Vec<[u32; 3]>,
    /// Cells that are neither solids nor faces, by type.
    pub others: Vec<String>,
}

impl Surface {
    /// Of a mesh.
    pub fn of(mesh: &Mesh) -> Self {
        let mut faces: HashMap<[u32; 4], Option<(usize, Face)>> = HashMap::new();
        let mut count = 0;
        let mut others = Vec::new();
        for block in &mesh.cells {
            let known = SHAPES.iter().find(|shape| shape.name == block.cell_type);
            let Some(shape) = known.filter(|shape| shape.fits(block)) else {
                others.push(block.cell_type.clone());
                continue;
            };
            for cell in block.cells() {
                for corners in shape.faces {
                    let face = shape.face(mesh, cell, corners);
                    count += 1;
                    let twice = |found: &mut Option<_>| *found = None;
                    let entry = faces.entry(face.key()).and_modify(twice);
                    entry.or_insert(Some((count, face)));
                }
            }
        }
        let mut outside: Vec<(usize, Face)> = faces.into_values().flatten().collect();
        outside.sort_unstable_by_key(|(number, _)| *number);
        // Hexahedra stand for wedges with nodes named twice.
        let has_area = |[a, b, c]: &[u32; 3]| a != b && b != c && c != a;
        let triangles = outside.iter().flat_map(|(_, face)| face.triangles());
        Self {
            triangles: triangles.filter(has_area).collect(),
            others,
        }
    }
}

impl Shape {
    fn fits(&self, block: &CellBlock) -> bool {
        block.nodes_per_cell >= self.corners + self.edges.len()
    }

    fn face(&self, mesh: &Mesh, cell: &[u32], corners: &[usize]) -> Face {
        let count = corners.len();
        let middle = |a: usize, b: usize| {
            let between = |edge: &&(usize, usize)| **edge == (a, b) || **edge == (b, a);
            let place = self.edges.iter().position(|edge| between(&edge));
            place.map(|place| cell[self.corners + place])
        };
        let mut face = Face {
            corners: corners.iter().map(|corner| cell[*corner]).collect(),
            middles: (0..count)
                .filter_map(|i| middle(corners[i], corners[(i + 1) % count]))
                .collect(),
        };
        if self.faces.len() > 1 && face.looks_inwards(mesh, &cell[..self.corners]) {
            face.turn();
        }
        face
    }
}

/// Corners in their order round the face, and the nodes between each and the next.
struct Face {
    corners: Vec<u32>,
    middles: Vec<u32>,
}

impl Face {
    /// The same for the two cells that share it.
    fn key(&self) -> [u32; 4] {
        let mut key = [u32::MAX; 4];
        for (place, corner) in key.iter_mut().zip(&self.corners) {
            *place = *corner;
        }
        key.sort_unstable();
        key
    }

    /// Programs turn their cells over: what counts is where the cell is.
    fn looks_inwards(&self, mesh: &Mesh, cell: &[u32]) -> bool {
        let place = |node: &u32| Vector3::from(mesh.position(*node));
        let mean =
            |nodes: &[u32]| nodes.iter().map(place).sum::<Vector3<f64>>() / nodes.len() as f64;
        let at: Vec<Vector3<f64>> = self.corners.iter().map(place).collect();
        let last = at.len() - 1;
        let normal = match last {
            3 => (at[2] - at[0]).cross(&(at[3] - at[1])),
            _ => (at[1] - at[0]).cross(&(at[2] - at[0])),
        };
        normal.dot(&(mean(&self.corners) - mean(cell))) < 0.0
    }

    fn turn(&mut self) {
        self.corners.reverse();
        // Between the last corner and the first now stands what stood there before.
        self.middles.reverse();
        if !self.middles.is_empty() {
            self.middles.rotate_left(1);
        }
    }

    fn triangles(&self) -> Vec<[u32; 3]> {
        let (c, m) = (&self.corners, &self.middles);
        match (c.as_slice(), m.as_slice()) {
            ([a, b, c], [x, y, z]) => vec![[*a, *x, *z], [*x, *b, *y], [*z, *y, *c], [*x, *y, *z]],
            ([a, b, c, d], [w, x, y, z]) => vec![
                [*a, *w, *z],
                [*w, *b, *x],
                [*x, *c, *y],
                [*y, *d, *z],
                [*w, *x, *y],
                [*w, *y, *z],
            ],
            ([a, b, c], _) => vec![[*a, *b, *c]],
            ([a, b, c, d], _) => vec![[*a, *b, *c], [*a, *c, *d]],
            _ => Vec::new(),
        }
    }
}
