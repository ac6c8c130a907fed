//! A mesh with the patterns in which it deflects, as small as a picture allows.

use serde::Serialize;

use crate::arrays::{Array, Arrays};
use crate::drawing::Drawing;

/// Largest integer of a pattern.
const STEPS: f64 = 32767.0;

/// Displacement of the drawn nodes, a length for each unit of its amplitude.
#[derive(Clone, Debug, PartialEq)]
pub struct Pattern {
    /// What it is called.
    pub name: String,
    /// For each node of the drawing, body axes.
    pub displacements: Vec<[f64; 3]>,
}

impl Pattern {
    /// The largest displacement.
    pub fn largest(&self) -> f64 {
        let lengths = self.displacements.iter();
        lengths
            .map(|[x, y, z]| (x * x + y * y + z * z).sqrt())
            .fold(0.0, f64::max)
    }
}

/// A pattern in integers.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Column {
    /// What it is called.
    pub name: String,
    /// Length of an integer's step for each unit of the amplitude.
    pub scale: f64,
    /// Integers, node after node: x, y, z.
    pub values: Array,
}

impl Column {
    /// How far rounding can move a node for each unit of the amplitude, a length: half a step along each of three axes.
    pub fn rounding(&self) -> f64 {
        0.5 * 3.0_f64.sqrt() * self.scale
    }
}

/// What is drawn of a mesh.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Shape {
    /// What it is called.
    pub name: String,
    /// Of the nodes, about the origin of the body's frame, body axes.
    pub positions: Array,
    /// Numbers of the nodes in the mesh.
    pub nodes: Array,
    /// Nodes of a cell: 3, 2 or 1.
    pub corners: usize,
    /// Places in the positions.
    pub cells: Array,
    /// Edges that are drawn over triangles.
    pub edges: Array,
    /// Patterns.
    pub columns: Vec<Column>,
    /// Bound of a displacement's error over its largest value.
    pub error: f64,
}

impl Shape {
    /// Rounds patterns to integers, each with a scale of its own: a displacement along an axis is off by half a step at most, 1/65534 of the pattern's largest.
    /// `positions` are those of the drawing's nodes. The error of the shape is that of one pattern at a time; who adds several up knows by how much of each.
    pub fn rounded(
        name: &str,
        drawing: &Drawing,
        positions: &[[f64; 3]],
        patterns: &[Pattern],
        arrays: &mut Arrays,
    ) -> Self {
        let columns = patterns.iter().map(|pattern| {
            let along_axes = || pattern.displacements.iter().flatten();
            let largest = along_axes().fold(0.0_f64, |largest, value| largest.max(value.abs()));
            let scale = match largest > 0.0 && largest.is_finite() {
                true => largest / STEPS,
                false => 1.0,
            };
            Column {
                name: pattern.name.clone(),
                scale,
                values: arrays.shorts(along_axes().map(|value| (value / scale).round() as i16)),
            }
        });
        let columns = columns.collect();
        Self {
            name: name.to_owned(),
            positions: arrays.reals(positions.iter().flatten().copied()),
            nodes: arrays.indices(drawing.nodes.iter().copied()),
            corners: drawing.corners,
            cells: arrays.indices(drawing.cells.iter().copied()),
            edges: arrays.indices([]),
            columns,
            error: 0.5 * 3.0_f64.sqrt() / STEPS,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_node_is_further_off_than_the_columns_say() {
        let drawing = Drawing {
            nodes: vec![0, 1, 2],
            cells: vec![0, 1, 2],
            corners: 3,
            others: Vec::new(),
        };
        let patterns = [[0.3, 1.0, 0.7], [2e-3, 5e-4, 1.7e-3]].map(|[a, b, c]| Pattern {
            name: String::new(),
            displacements: vec![[a, b, c], [b, c, a], [a / 3.0, c / 7.0, b / 11.0]],
        });
        let mut arrays = Arrays::default();
        let shape = Shape::rounded("", &drawing, &[[0.0; 3]; 3], &patterns, &mut arrays);
        for (column, pattern) in shape.columns.iter().zip(&patterns) {
            for of_node in &pattern.displacements {
                let off =
                    of_node.map(|value| value - (value / column.scale).round() * column.scale);
                let off = off.iter().map(|value| value * value).sum::<f64>().sqrt();
                assert!(off <= column.rounding());
                assert!(off <= shape.error * pattern.largest());
            }
        }
    }
}
