//! CalculiX's rigid bodies: the rows of a node whose translations stand for the rotations of another one.

use dcb_formats::mesh::{Direction, Dof, MatrixRow};

use crate::part::Part;
use crate::proof::doubt::TOLERATED;
use crate::rigid_motions::{Resistance, resistance};
use crate::rows::order::row_places;

/// A node whose rows are taken as rotations of another one.
#[derive(Clone, Copy, Debug)]
struct RotationNode {
    rotation: u32,
    reference: u32,
}

impl Part {
    /// Takes the rows of nodes without cells as rotations of reference nodes, where K proves it; `None` where nothing is changed.
    ///
    /// No file says which rows are rotations. The deck may name the nodes (`ROT NODE`); else two nodes at one place are tried both ways.
    pub(crate) fn with_rotation_nodes(&mut self) -> Option<Resistance> {
        let mut candidates = self.candidates();
        candidates.retain(|of| of.rotation != of.reference);
        if candidates.is_empty() {
            return None;
        }
        let mut rows = self.rows.clone();
        let mut taken = Vec::new();
        let mut best = self.resistance_of(&rows).worst();
        let mut found = None;
        for candidate in candidates {
            let Some(tried) = as_rotations(&rows, candidate) else {
                continue;
            };
            let resistance = self.resistance_of(&tried);
            if resistance.worst() < best {
                (rows, best) = (tried, resistance.worst());
                taken.push(candidate);
                found = Some(resistance);
            }
        }
        let found = found.filter(|found| found.worst() <= TOLERATED)?;
        self.rows = rows;
        for RotationNode {
            rotation,
            reference,
        } in taken
        {
            self.notes.push(format!(
                "the rows of node {} are rotations of node {}: as translations they would resist rigid motions",
                self.label(rotation),
                self.label(reference)
            ));
        }
        Some(found)
    }

    /// Pairs that the deck names, then pairs at one place among the nodes without cells.
    fn candidates(&self) -> Vec<RotationNode> {
        let mut candidates: Vec<RotationNode> = Vec::new();
        for body in &self.mesh.rigid_bodies {
            if let Some(rotation) = body.rotation {
                let reference = body.reference;
                candidates.push(RotationNode {
                    rotation,
                    reference,
                });
            }
        }
        let loose = self.mesh.nodes_without_cells();
        // Reference nodes are few; a mesh with many loose nodes has other troubles.
        const MOST_LOOSE: usize = 64;
        if loose.len() <= MOST_LOOSE {
            for &rotation in &loose {
                for &reference in &loose {
                    if self.mesh.points[rotation as usize] == self.mesh.points[reference as usize] {
                        candidates.push(RotationNode {
                            rotation,
                            reference,
                        });
                    }
                }
            }
        }
        candidates
    }

    fn resistance_of(&self, rows: &[MatrixRow]) -> Resistance {
        resistance(&self.stiffness, &row_places(&self.mesh, rows))
    }
}

/// The rows of a node as rotations of another; `None` if it has none, or the other has rotations already.
fn as_rotations(rows: &[MatrixRow], of: RotationNode) -> Option<Vec<MatrixRow>> {
    let has_rotations = rows.iter().any(|owner| {
        matches!(owner, MatrixRow::Nodal(Dof { node, direction }) if *node == of.reference && direction.is_rotation())
    });
    let mut changed = 0;
    let rows = rows
        .iter()
        .map(|owner| match owner {
            MatrixRow::Nodal(Dof { node, direction }) if *node == of.rotation => {
                let rotation = Direction::from_index(3 + direction.axis());
                changed += 1;
                MatrixRow::Nodal(Dof {
                    node: of.reference,
                    direction: rotation.unwrap_or(*direction),
                })
            }
            other => *other,
        })
        .collect();
    (changed > 0 && !has_rotations).then_some(rows)
}
