//! The proof that rows and mesh belong together: K resists no rigid motion.

mod doubt;
mod mass;
mod rotation_node;

use std::path::Path;

use dcb_formats::Error;
use dcb_formats::mesh::{Direction, Dof, MatrixRow};

use crate::interfaces::counted;
use crate::operators::of_file;
use crate::part::{Part, first_ten};
use crate::proof::doubt::{Doubt, QUIET, TOLERATED};
use crate::request::{Import, LostOrder};
use crate::rigid_motions::{Resistance, resistance};
use crate::rows::lost_order::found_order;
use crate::rows::order::{node_after_node, row_places};

impl Part {
    fn resistance(&self) -> Resistance {
        resistance(&self.stiffness, &row_places(&self.mesh, &self.rows))
    }

    /// How K resists rigid motions, once it doesn't.
    pub fn proven(&mut self, request: &Import) -> Result<Resistance, Error> {
        let found = self.resistance();
        if found.worst() <= TOLERATED {
            self.tell_internal_rows(&request.stiffness.path)?;
            if request.lost_order == LostOrder::Repair {
                self.notes
                    .push("the order of the rows needs no repair".into());
            }
            if found.worst() > QUIET {
                self.warnings.push(format!(
                    "rigid motions leave K R = {:.1e} of the stiffness: as much as few printed digits do; binary files or more digits are better",
                    found.worst()
                ));
            }
            return Ok(found);
        }
        if let Some(found) = self.with_rotation_nodes() {
            self.tell_internal_rows(&request.stiffness.path)?;
            return Ok(found);
        }
        if request.lost_order == LostOrder::Repair {
            return self.repaired(request, found);
        }
        let doubt = Doubt {
            part: self,
            resistance: found,
        };
        Err(of_file(&request.stiffness.path, doubt.message()))
    }

    /// Labels that the mesh doesn't have are internal ones where rigid motions leave their rows at rest and all are above those of the mesh.
    fn tell_internal_rows(&mut self, stiffness: &Path) -> Result<(), Error> {
        let (labels, rows) = &self.unknown;
        let Some(least) = labels.first() else {
            return Ok(());
        };
        let largest = self.mesh.labels.iter().flatten().max();
        if largest.is_some_and(|largest| least < largest) {
            let message = format!(
                "rows have labels that the mesh doesn't have: {}; is it the mesh of these matrices?",
                first_ten(labels)
            );
            return Err(of_file(stiffness, message));
        }
        let rows = counted(*rows, "row");
        self.notes.push(format!(
            "{rows} of labels above the mesh's largest belong to no node and rest in rigid motions: internal rows of elements, kept as they are"
        ));
        Ok(())
    }

    /// The order of the nodes that follows from K.
    fn repaired(&mut self, request: &Import, before: Resistance) -> Result<Resistance, Error> {
        if let Some((rows, found)) = self.by_direction()
            && found.worst() <= TOLERATED
        {
            self.rows = rows;
            self.order = "direction after direction".into();
            self.warnings.push(format!(
                "the rows go direction after direction, all ux first (--repair-order): K R was {:.1e} and is {:.1e}",
                before.worst(),
                found.worst()
            ));
            return Ok(found);
        }
        let pattern = self.pattern().ok_or_else(|| {
            let message = "the order of the rows can be found only where every node has the same directions, in rows that follow each other";
            of_file(&request.stiffness.path, message.into())
        })?;
        let order = found_order(&self.stiffness, &self.mesh, &pattern)
            .map_err(|message| of_file(&request.stiffness.path, message))?;
        self.rows = node_after_node(&order.nodes, &pattern);
        let found = self.resistance();
        let moved = order
            .nodes
            .iter()
            .zip(0..)
            .filter(|(node, at)| **node != *at)
            .count();
        self.order = "found from the null space of the stiffness".into();
        self.warnings.push(format!(
            "the order of the rows was found from the stiffness (--repair-order): K R was {:.1e} and is {:.1e}; {moved} of {} nodes aren't where the mesh \
             lists them; positions from K and mesh differ by up to {:.1e} of the part's size",
            before.worst(),
            found.worst(),
            order.nodes.len(),
            order.distance
        ));
        if order.has_twin {
            self.warnings.push(
                "the part turned inside out through its middle fits these matrices just as well; the first of both orders was taken: check which end is which"
                    .into(),
            );
        }
        Ok(found)
    }

    /// Rows that go direction after direction, in the order of the nodes, and how K resists rigid motions then; `None` where labels say which row
    /// is which, or nodes have one direction.
    fn by_direction(&self) -> Option<(Vec<MatrixRow>, Resistance)> {
        let pattern = self
            .pattern()
            .filter(|pattern| self.is_positional && pattern.len() > 1)?;
        let first = self.rows.chunks_exact(pattern.len());
        let nodes: Vec<u32> = first.filter_map(|rows| Some(rows[0].dof()?.node)).collect();
        let of_direction = |direction| {
            let owner = move |&node| MatrixRow::Nodal(Dof { node, direction });
            nodes.iter().map(owner)
        };
        let rows: Vec<MatrixRow> = pattern.iter().copied().flat_map(of_direction).collect();
        let found = resistance(&self.stiffness, &row_places(&self.mesh, &rows));
        Some((rows, found))
    }

    /// Directions of every node, if rows go node after node with the same ones.
    fn pattern(&self) -> Option<Vec<Direction>> {
        let direction = |owner: &MatrixRow| owner.dof().map(|dof| dof.direction);
        let all: Vec<Direction> = self.rows.iter().map(direction).collect::<Option<_>>()?;
        let size = all.len().checked_div(self.mesh.points.len())?;
        let pattern = all
            .get(..size)
            .filter(|pattern| !pattern.is_empty())?
            .to_vec();
        let is_uniform =
            all.len().is_multiple_of(size) && all.chunks_exact(size).all(|chunk| chunk == pattern);
        is_uniform.then_some(pattern)
    }
}
