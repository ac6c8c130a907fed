//! Plane outlines of quadrilaterals that are extruded into hexahedra.
//!
//! A planform holds points on half-step lattices: every quadrilateral knows its 3 × 3 points, so linear and quadratic
//! elements use the same blocks, curved edges included. Blocks are joined by sharing points, never by tolerance.

use std::f64::consts::PI;
use std::ops::Range;

use dcb_formats::mesh::Mesh;

use crate::solid::SolidElement;
use crate::solid::lattice::mesh_of_used_points;

/// Points and quadrilaterals in the x–y plane.
#[derive(Default)]
pub(crate) struct Planform {
    points: Vec<[f64; 2]>,
    quads: Vec<Quad>,
}

/// One quadrilateral: its 3 × 3 points, first index fastest, and the layers it is extruded through.
struct Quad {
    points: [u32; 9],
    layers: Range<usize>,
}

/// Points of a ring block, as `(circumferential half-step, radial half-step)`.
pub(crate) struct Ring {
    first: u32,
    around: usize,
    across: usize,
}

impl Ring {
    /// Point id; `circumferential` wraps around.
    pub(crate) fn point(&self, circumferential: usize, radial: usize) -> u32 {
        self.first + (circumferential % self.around * self.across + radial) as u32
    }

    /// Points on the inner circle.
    pub(crate) fn inner(&self) -> Vec<u32> {
        (0..self.around)
            .map(|around| self.point(around, 0))
            .collect()
    }

    /// Radial half-step of the outer circle.
    pub(crate) fn outer_step(&self) -> usize {
        self.across - 1
    }
}

/// Centre and radii of a ring.
#[derive(Clone, Copy)]
pub(crate) struct Annulus {
    pub(crate) center: [f64; 2],
    pub(crate) inner: f64,
    pub(crate) outer: f64,
}

impl Planform {
    /// Adds a point.
    pub(crate) fn add_point(&mut self, point: [f64; 2]) -> u32 {
        self.points.push(point);
        self.points.len() as u32 - 1
    }

    /// Adds `cells[0] × cells[1]` quadrilaterals over half-step points `id(i, j)`; i to j must turn counter-clockwise.
    pub(crate) fn add_grid(
        &mut self,
        cells: [usize; 2],
        layers: Range<usize>,
        id: impl Fn(usize, usize) -> u32,
    ) {
        for i in 0..cells[0] {
            for j in 0..cells[1] {
                let points = std::array::from_fn(|at| id(2 * i + at % 3, 2 * j + at / 3));
                self.quads.push(Quad {
                    points,
                    layers: layers.clone(),
                });
            }
        }
    }

    /// Adds a ring with `radial` cells across; `angles` are those of all half-steps once around, ascending.
    pub(crate) fn add_ring(
        &mut self,
        annulus: Annulus,
        angles: &[f64],
        radial: usize,
        layers: Range<usize>,
    ) -> Ring {
        let ring = Ring {
            first: self.points.len() as u32,
            around: angles.len(),
            across: 2 * radial + 1,
        };
        for &angle in angles {
            for step in 0..ring.across {
                let share = step as f64 / ring.outer_step() as f64;
                let radius = annulus.inner + (annulus.outer - annulus.inner) * share;
                self.add_point(on_circle(annulus.center, radius, angle));
            }
        }
        self.add_grid([radial, angles.len() / 2], layers, |radial, around| {
            ring.point(around, radial)
        });
        ring
    }

    /// Extrudes through the planes at `heights`, one layer between two of them.
    pub(crate) fn extrude(&self, heights: &[f64], element: SolidElement) -> Extrusion {
        let levels = 2 * heights.len() - 1;
        let z = |level: usize| match level % 2 {
            0 => heights[level / 2],
            _ => 0.5 * (heights[level / 2] + heights[level / 2 + 1]),
        };
        let offsets = cell_offsets(element);
        let mut slots = Vec::new();
        for quad in &self.quads {
            for layer in quad.layers.clone() {
                slots.extend(
                    offsets
                        .iter()
                        .map(|&[i, j, k]| quad.points[i + 3 * j] as usize * levels + 2 * layer + k),
                );
            }
        }
        let position = |slot: usize| {
            let [x, y] = self.points[slot / levels];
            [x, y, z(slot % levels)]
        };
        let slot_count = self.points.len() * levels;
        let (mesh, node_of_slot) = mesh_of_used_points(element, &slots, slot_count, position);
        Extrusion {
            mesh,
            node_of_slot,
            levels,
        }
    }
}

/// A mesh and where its nodes stand over the planform.
pub(crate) struct Extrusion {
    pub(crate) mesh: Mesh,
    node_of_slot: Vec<u32>,
    levels: usize,
}

impl Extrusion {
    /// Nodes over these planform points, ascending.
    pub(crate) fn nodes_over(&self, points: &[u32]) -> Vec<u32> {
        let mut nodes: Vec<u32> = points
            .iter()
            .flat_map(|&point| {
                &self.node_of_slot[point as usize * self.levels..(point as usize + 1) * self.levels]
            })
            .copied()
            .filter(|&node| node != u32::MAX)
            .collect();
        nodes.sort_unstable();
        nodes
    }
}

/// Half-step offsets of an element's nodes in meshio's order.
fn cell_offsets(element: SolidElement) -> Vec<[usize; 3]> {
    let corners = [
        [0, 0, 0],
        [2, 0, 0],
        [2, 2, 0],
        [0, 2, 0],
        [0, 0, 2],
        [2, 0, 2],
        [2, 2, 2],
        [0, 2, 2],
    ];
    let middles = crate::solid::HEXAHEDRON_EDGES
        .map(|[a, b]| std::array::from_fn(|axis| (corners[a][axis] + corners[b][axis]) / 2));
    match element {
        SolidElement::Hexahedron20 => corners.into_iter().chain(middles).collect(),
        _ => corners.to_vec(),
    }
}

/// A point of a circle.
pub(crate) fn on_circle(center: [f64; 2], radius: f64, angle: f64) -> [f64; 2] {
    let (sine, cosine) = angle.sin_cos();
    [center[0] + radius * cosine, center[1] + radius * sine]
}

/// Half-step angles of `cells` equal steps from `from` to `to`, without the last one.
pub(crate) fn half_steps(from: f64, to: f64, cells: usize) -> impl Iterator<Item = f64> {
    (0..2 * cells).map(move |step| from + (to - from) * step as f64 / (2 * cells) as f64)
}

/// A closed circle of `cells` equal steps.
pub(crate) fn full_circle(cells: usize) -> Vec<f64> {
    half_steps(0.0, 2.0 * PI, cells).collect()
}
