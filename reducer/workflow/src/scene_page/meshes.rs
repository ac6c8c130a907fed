//! Meshes of a page with the patterns in which they deflect: what has room, and how exact it is.

use dcb_runtime::error::Error;
use dcb_runtime::model::FieldPlan;
use dcb_view::{Array, Arrays, Drawing, Pattern, Shape};
use faer::Mat;
use nalgebra::Vector3;

use super::Run;
use super::moments::Moments;
use crate::page_room;

/// Patterns whose largest displacement in the run is less than this part of the largest one of the body are left out.
const SEEN: f64 = 1e-4;
/// Frames in which the largest displacement is looked for.
const LOOKED_AT: usize = 40;
/// Relative error of an amplitude in single precision.
const SINGLE: f64 = 6e-8;

/// A mesh that bodies of one superelement share.
pub struct SharedMesh<'a> {
    plan: &'a FieldPlan,
    /// The bodies, by their numbers.
    pub bodies: Vec<usize>,
    drawing: Drawing,
    /// Amplitudes of all patterns in each of the bodies: (frames, patterns).
    histories: Vec<Mat<f64>>,
    /// The largest displacement of each pattern in the run.
    reaches: Vec<f64>,
    /// Patterns that the page has.
    kept: Vec<usize>,
}

/// The meshes of all bodies that have fields.
pub fn of<'a>(run: &'a Run, moments: &Moments) -> Result<Vec<SharedMesh<'a>>, Error> {
    let bodies = &run.model.system.bodies;
    let mut meshes: Vec<SharedMesh> = Vec::new();
    for plan in &run.model.fields {
        let name = plan.body_name();
        let Some(body) = bodies.iter().position(|body| body.name == name) else {
            continue;
        };
        let history = amplitudes(run, plan, moments)?;
        let is_same = |known: &&mut SharedMesh| {
            known.plan.field() == plan.field() && known.plan.mesh() == plan.mesh()
        };
        match meshes.iter_mut().find(is_same) {
            Some(known) => {
                known.bodies.push(body);
                known.histories.push(history);
            }
            None => meshes.push(SharedMesh {
                plan,
                bodies: vec![body],
                drawing: Drawing::of(plan.mesh()),
                histories: vec![history],
                reaches: Vec::new(),
                kept: Vec::new(),
            }),
        }
    }
    for mesh in &mut meshes {
        mesh.see();
    }
    Ok(meshes)
}

/// Makes the meshes smaller until they have room, first by nodes, then by patterns: what was left out, for people.
pub fn fit(meshes: &mut [SharedMesh], room: usize) -> Vec<String> {
    let bytes = |meshes: &[SharedMesh]| meshes.iter().map(SharedMesh::bytes).sum::<usize>();
    let nodes = |meshes: &[SharedMesh]| -> usize {
        meshes.iter().map(|mesh| mesh.drawing.nodes.len()).sum()
    };
    let mut said = Vec::new();
    if bytes(meshes) <= room {
        return said;
    }
    let all_nodes = nodes(meshes);
    for mesh in meshes.iter_mut() {
        let corners = Drawing::of_corners(mesh.plan.mesh());
        if corners.nodes.len() < mesh.drawing.nodes.len() {
            mesh.drawing = corners;
        }
    }
    if nodes(meshes) < all_nodes {
        said.push(format!(
            "The view draws the {} corners of the surfaces, not all {all_nodes} nodes on them: the page stays small.",
            nodes(meshes)
        ));
    }
    let mut needed = bytes(meshes);
    let mut by_size: Vec<(f64, usize, usize)> = Vec::new();
    for (number, mesh) in meshes.iter().enumerate() {
        let largest = mesh.largest_reach();
        let shares = mesh.kept.iter();
        by_size.extend(shares.map(|column| (mesh.reaches[*column] / largest, number, *column)));
    }
    by_size.sort_by(|a, b| a.0.total_cmp(&b.0));
    let all = by_size.len();
    let mut left_out = 0;
    for (_, number, column) in by_size {
        let mesh = &mut meshes[number];
        if needed <= room {
            break;
        }
        if mesh.kept.len() > 1 {
            mesh.kept.retain(|kept| *kept != column);
            needed -= page_room::DISPLACEMENT_BYTES * mesh.drawing.nodes.len();
            left_out += 1;
        }
    }
    if left_out > 0 {
        said.push(format!(
            "The view leaves out the smallest {left_out} of {all} patterns of deflection: the page stays small."
        ));
    }
    if needed > room {
        said.push(format!(
            "The surfaces have {} nodes: the page is larger than pages usually are.",
            nodes(meshes)
        ));
    }
    said
}

fn amplitudes(run: &Run, plan: &FieldPlan, moments: &Moments) -> Result<Mat<f64>, Error> {
    let (name, expected) = (plan.body_name(), plan.field().pattern_count());
    let found = moments.amplitudes(run, name)?;
    match found.ncols() == expected {
        true => Ok(found),
        false => Err(run.refused(&format!(
            "has {} coordinates of body {name:?}, but its superelement has {expected} in this scene; run the scene again",
            found.ncols()
        ))),
    }
}

impl SharedMesh<'_> {
    /// Name of one of the bodies.
    pub fn body_name(&self) -> &str {
        self.plan.body_name()
    }

    /// Places of the nodes that are drawn, body axes.
    pub fn positions(&self) -> Vec<[f64; 3]> {
        let places = self.plan.field().positions();
        let drawn = self.drawing.nodes.iter();
        drawn.map(|node| places[*node as usize].into()).collect()
    }

    /// Types of cells that aren't drawn.
    pub fn others(&self) -> &[String] {
        &self.drawing.others
    }

    /// Amplitudes of the patterns that the page has, body after body.
    pub fn amplitudes(&self, arrays: &mut Arrays) -> Vec<Array> {
        let of_body = |history: &Mat<f64>| {
            let numbers = (0..history.nrows())
                .flat_map(|row| self.kept.iter().map(move |column| history[(row, *column)]));
            arrays.reals(numbers)
        };
        self.histories.iter().map(of_body).collect()
    }

    /// The shape, with a bound of what rounding and left-out patterns do to a displacement in the run, over the largest one.
    pub fn shape(&self, name: &str, arrays: &mut Arrays) -> Shape {
        let patterns: Vec<Pattern> = (self.kept.iter())
            .map(|column| self.pattern(*column))
            .collect();
        let mut shape = Shape::rounded(name, &self.drawing, &self.positions(), &patterns, arrays);
        let left_out = (0..self.reaches.len()).filter(|column| !self.kept.contains(column));
        let lost: f64 = left_out.map(|column| self.reaches[column]).sum();
        let per_unit: Vec<f64> = (shape.columns.iter().zip(&patterns))
            .map(|(column, pattern)| column.rounding() + SINGLE * pattern.largest())
            .collect();
        let rounded = (self.histories.iter())
            .flat_map(|history| (0..history.nrows()).map(move |row| (history, row)))
            .map(|(history, row)| {
                let each = self.kept.iter().zip(&per_unit);
                each.map(|(column, off)| history[(row, *column)].abs() * off)
                    .sum::<f64>()
            })
            .fold(0.0, f64::max);
        let largest = (self.histories.iter())
            .map(|history| self.largest_displacement(history, &patterns))
            .fold(0.0, f64::max);
        shape.error = match largest > 0.0 {
            true => (lost + rounded) / largest,
            false => 0.0,
        };
        shape
    }

    /// Finds how far each pattern reaches, and keeps those that can be seen.
    fn see(&mut self) {
        let reach = |column: usize| {
            let values = self.histories.iter();
            let values = values.flat_map(|history| history.col(column).iter());
            let largest = values.fold(0.0_f64, |largest, value| largest.max(value.abs()));
            largest * self.pattern(column).largest()
        };
        let reaches: Vec<f64> = (0..self.plan.field().pattern_count()).map(reach).collect();
        self.reaches = reaches;
        let least = SEEN * self.largest_reach();
        self.kept = (0..self.reaches.len())
            .filter(|column| self.reaches[*column] > least)
            .collect();
    }

    fn largest_reach(&self) -> f64 {
        self.reaches.iter().copied().fold(0.0, f64::max)
    }

    fn bytes(&self) -> usize {
        page_room::of_mesh(self.drawing.nodes.len(), self.kept.len())
    }

    fn pattern(&self, column: usize) -> Pattern {
        let all = self.plan.field().pattern(column);
        let drawn = self.drawing.nodes.iter();
        Pattern {
            name: format!("coordinate {}", column + 1),
            displacements: drawn.map(|node| all[*node as usize].into()).collect(),
        }
    }

    /// In some of the frames, and in that in which the patterns together could reach furthest.
    fn largest_displacement(&self, history: &Mat<f64>, patterns: &[Pattern]) -> f64 {
        let could_reach = |row: usize| -> f64 {
            let each = self.kept.iter().zip(patterns);
            each.map(|(column, pattern)| history[(row, *column)].abs() * pattern.largest())
                .sum()
        };
        let furthest = (0..history.nrows())
            .map(|row| (could_reach(row), row))
            .max_by(|a, b| a.0.total_cmp(&b.0));
        let mut rows = super::spread(history.nrows(), LOOKED_AT);
        rows.extend(furthest.map(|(_, row)| row));
        let mut largest = 0.0_f64;
        for row in rows {
            let mut sums = vec![Vector3::zeros(); self.drawing.nodes.len()];
            for (column, pattern) in self.kept.iter().zip(patterns) {
                let amplitude = history[(row, *column)];
                for (sum, of_node) in sums.iter_mut().zip(&pattern.displacements) {
                    *sum += Vector3::from(*of_node) * amplitude;
                }
            }
            largest = sums.iter().map(Vector3::norm).fold(largest, f64::max);
        }
        largest
    }
}
