//! The nodes of a mesh in the order of the rows.

use dcb_formats::mesh::{Dimension, Direction, Dof, MatrixRow, Mesh};

use crate::interfaces::counted;
use crate::mesh::FoundMesh;
use crate::part::Part;

impl Part {
    /// Puts nodes in the order of their rows, and leaves those out that have neither rows nor cells: construction points of a mesher.
    pub fn order_nodes(&mut self) {
        let mut is_used = vec![false; self.mesh.points.len()];
        for owner in &self.rows {
            if let MatrixRow::Nodal(Dof { node, .. }) = owner {
                is_used[*node as usize] = true;
            }
        }
        let without_rows: Vec<u32> = (0..is_used.len() as u32)
            .filter(|&node| !is_used[node as usize])
            .collect();
        for node in self.mesh.cells.iter().flat_map(|block| &block.nodes) {
            is_used[*node as usize] = true;
        }
        let (dependent, unused): (Vec<u32>, Vec<u32>) = without_rows
            .iter()
            .partition(|&&node| is_used[node as usize]);
        if !dependent.is_empty() {
            self.notes.push(format!(
                "{} of the mesh {} no rows, though the part is free: dependent on others, and without motion of {} own in the result (labels {})",
                counted(dependent.len(), "node"),
                if dependent.len() == 1 { "has" } else { "have" },
                if dependent.len() == 1 { "its" } else { "their" },
                self.first_labels(&dependent)
            ));
        }
        if !unused.is_empty() {
            self.notes.push(format!(
                "{} of the mesh without rows and cells {} left out",
                counted(unused.len(), "node"),
                if unused.len() == 1 { "was" } else { "were" }
            ));
        }
        // Nodes in the order of their rows; those without rows after them.
        let mut order: Vec<u32> = Vec::new();
        let mut is_placed = vec![false; is_used.len()];
        let of_rows = self.rows.iter().filter_map(|owner| owner.dof());
        let of_rows = of_rows.map(|dof| dof.node);
        for node in of_rows.chain(dependent) {
            if !std::mem::replace(&mut is_placed[node as usize], true) {
                order.push(node);
            }
        }
        let new = self.mesh.keep(&order);
        for owner in &mut self.rows {
            if let MatrixRow::Nodal(Dof { node, .. }) = owner {
                *node = new[*node as usize];
            }
        }
    }
}

/// Number of a node that is gone.
const GONE: u32 = u32::MAX;

impl FoundMesh {
    /// Keeps the nodes of a list, in its order, and puts each set into that order; the new number of every node.
    pub(crate) fn keep(&mut self, order: &[u32]) -> Vec<u32> {
        let mut new = vec![GONE; self.points.len()];
        for (&node, at) in order.iter().zip(0..) {
            new[node as usize] = at;
        }
        self.points = order
            .iter()
            .map(|&node| self.points[node as usize])
            .collect();
        if let Some(labels) = &mut self.labels {
            *labels = order.iter().map(|&node| labels[node as usize]).collect();
        }
        for block in &mut self.cells {
            block
                .nodes
                .iter_mut()
                .for_each(|node| *node = new[*node as usize]);
        }
        for (_, nodes) in self.sets.iter_mut().chain(&mut self.cell_sets) {
            nodes.retain(|node| new[*node as usize] != GONE);
            nodes
                .iter_mut()
                .for_each(|node| *node = new[*node as usize]);
            nodes.sort_unstable();
            nodes.dedup();
        }
        new
    }

    /// As the mesh of a component whose nodes have some directions: planar where these are in the plane and the points too.
    pub(crate) fn of_component(&self, mut directions: impl Iterator<Item = Direction>) -> Mesh {
        let in_plane = Dimension::Planar.frame_directions();
        let is_planar = directions.all(|direction| in_plane.contains(&direction))
            && self.points.iter().all(|point| point[2] == 0.0);
        let dimension = match is_planar {
            true => Dimension::Planar,
            false => Dimension::Spatial,
        };
        let coordinates = self
            .points
            .iter()
            .flat_map(|point| point[..dimension.coordinate_count()].iter().copied());
        let sets = self.sets.iter().chain(&self.cell_sets);
        Mesh {
            dimension,
            coordinates: coordinates.collect(),
            cells: self
                .cells
                .iter()
                .filter(|block| !block.nodes.is_empty())
                .cloned()
                .collect(),
            point_sets: sets
                .filter(|(_, nodes)| !nodes.is_empty())
                .cloned()
                .collect(),
        }
    }
}
