//! Geometric stiffness of a straight, uniform beam from the axial forces in it.
//!
//! ```text
//! K_G  =  ∫ N(s) w'ᵀ w' ds      w = deflections across the axis, cubic between the nodes
//! ```
//! The beam is free: under a force at one end it accelerates, and its inertia makes the axial force N fall linearly to zero at the
//! other; a spin ω about the centre pulls with N = ½ μ (L²/4 − s²) (|ω|² − (ω·t)²), s from the centre, μ the mass per length.

use dcb_formats::component::{GeometricStiffness, InterfaceKind, RowStiffness};
use dcb_formats::mesh::{Dimension, Direction};
use dcb_formats::{Component, SparseMatrix};
use nalgebra::Vector3;

use crate::planar_rod::GAUSS_4;
use crate::sparse::Assembly;

/// Products of spins in the order of the files: xx, yy, zz, xy, yz, zx.
const PAIRS: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)];
/// An axial part of a force below this fraction is rounding.
const ACROSS: f64 = 1e-12;

/// The geometric stiffness of a beam of one of the samples: nodes in a row along a straight line, rotations at each, of
/// `mass_per_length` (kg/m), with forces at its first and last node.
pub fn axial_prestress(component: &Component, mass_per_length: f64) -> GeometricStiffness {
    let beam = Beam::of(component);
    let half = 0.5 * beam.length;
    let pulled = |factor: f64| {
        beam.stiffness(|s| 0.5 * mass_per_length * factor * (half * half - (s - half).powi(2)))
    };
    let t = beam.tangent;
    let spins = match component.dimension() {
        Dimension::Planar => vec![Some(pulled(1.0))],
        Dimension::Spatial => PAIRS
            .iter()
            .map(|&(a, b)| match a == b {
                true => Some(pulled(1.0 - t[a] * t[a])),
                false => Some(pulled(-2.0 * t[a] * t[b])),
            })
            .collect(),
    };
    let last = component.mesh.node_count() as u32 - 1;
    let mut rows = Vec::new();
    for (index, interface) in component.interfaces.iter().enumerate() {
        let at_end = match interface.nodes[..] {
            [0] => false,
            [node] if node == last => true,
            _ => continue,
        };
        if interface.kind != InterfaceKind::Nodes {
            continue;
        }
        for direction in &Direction::ALL[..component.dimension().coordinate_count()] {
            let along = t[direction.axis()];
            if along.abs() <= ACROSS {
                continue;
            }
            // Tension at s: what the force has to set in motion beyond the cut.
            let matrix = match at_end {
                true => beam.stiffness(|s| along * s / beam.length),
                false => beam.stiffness(|s| -along * (1.0 - s / beam.length)),
            };
            rows.push(RowStiffness {
                row: (index, *direction),
                matrix,
            });
        }
    }
    GeometricStiffness { spins, rows }
}

struct Beam<'a> {
    component: &'a Component,
    tangent: Vector3<f64>,
    length: f64,
    across: Vec<Vector3<f64>>,
}

impl<'a> Beam<'a> {
    fn of(component: &'a Component) -> Self {
        let mesh = &component.mesh;
        let position = |node: usize| Vector3::from(mesh.position(node as u32));
        let span = position(mesh.node_count() - 1) - position(0);
        let tangent = span.normalize();
        let across = match component.dimension() {
            Dimension::Planar => vec![Vector3::z().cross(&tangent)],
            Dimension::Spatial => {
                let smallest = tangent.iamin();
                let first = tangent.cross(&Vector3::ith(smallest, 1.0)).normalize();
                vec![first, tangent.cross(&first)]
            }
        };
        Self {
            component,
            tangent,
            length: span.norm(),
            across,
        }
    }

    /// K_G of an axial force, positive as tension, at each distance from the first node.
    fn stiffness(&self, tension: impl Fn(f64) -> f64) -> SparseMatrix {
        let elements = self.component.mesh.node_count() - 1;
        let h = self.length / elements as f64;
        let mut assembly = Assembly::new(self.component.dofs.len());
        for element in 0..elements {
            for (s, weight) in GAUSS_4 {
                let force = weight * h * tension(h * (element as f64 + s));
                for across in &self.across {
                    let slope = self.slope(element, h, s, across);
                    for &(i, a) in &slope {
                        for &(j, b) in &slope {
                            assembly.add(i, j, force * (a * b));
                        }
                    }
                }
            }
        }
        assembly.finish()
    }

    /// w' along `across` as a combination of dofs: (dof, coefficient).
    fn slope(&self, element: usize, h: f64, s: f64, across: &Vector3<f64>) -> Vec<(usize, f64)> {
        let s2 = s * s;
        // Derivatives along the beam of the cubic Hermite functions.
        let deflection = 6.0 * (s2 - s) / h;
        let [start, end] = [1.0 - 4.0 * s + 3.0 * s2, 3.0 * s2 - 2.0 * s];
        let turn = self.tangent.cross(across);
        let mut row = Vec::new();
        for (node, translation, rotation) in [
            (element as u32, deflection, start),
            (element as u32 + 1, -deflection, end),
        ] {
            for direction in Direction::ALL {
                let coefficient = match direction.is_rotation() {
                    true => rotation * turn[direction.axis()],
                    false => translation * across[direction.axis()],
                };
                if let Some(dof) = self.component.dofs.row(node, direction)
                    && coefficient != 0.0
                {
                    row.push((dof, coefficient));
                }
            }
        }
        row
    }
}
