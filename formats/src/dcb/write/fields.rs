//! Nodal fields and the mesh to a file.

use super::Writer;
use crate::dcb::names;
use crate::dcb::sink::About;
use crate::dcb::units::{Factor, LENGTH, Rule};
use crate::mesh::Mesh;
use crate::superelement::RecoveryBasis;

impl Writer<'_> {
    /// Nodal shapes.
    pub(super) fn recovery(&mut self, recovery: &RecoveryBasis) -> hdf5::Result<()> {
        self.sink.group("fields")?;
        let dofs: Vec<i64> = recovery
            .dofs
            .iter()
            .flat_map(|dof| [i64::from(dof.node), dof.direction.index() as i64])
            .collect();
        self.sink.integers("/fields/dofs", &dofs)?;
        self.sink.field("/modes/shapes", &recovery.modes)?;
        self.sink.field("/residual/shapes", &recovery.residual)?;
        match &recovery.enrichment {
            Some(shapes) => self.sink.field("/enrichment/shapes", shapes),
            None => Ok(()),
        }
    }

    /// Geometry; its names depend on the component, so the table of the contract doesn't have them.
    pub(super) fn mesh(&mut self, mesh: &Mesh) -> hdf5::Result<()> {
        for group in ["mesh", "mesh/cells", "mesh/point_sets"] {
            self.sink.group(group)?;
        }
        let plain = Rule::Text("1");
        let lengths = Rule::Product(&[Factor::Uniform(LENGTH)]);
        let points = About {
            path: "/mesh/points",
            shape: vec![mesh.node_count(), mesh.dimension.coordinate_count()],
            symbol: "x",
            units: lengths,
            description: "node coordinates, component axes",
        };
        self.sink.put_reals(&points, &mesh.coordinates)?;
        for (index, block) in mesh.cells.iter().enumerate() {
            self.sink.group(&format!("mesh/cells/{index}"))?;
            let path = format!("/mesh/cells/{index}/type");
            let about = About {
                path: &path,
                shape: vec![],
                symbol: "",
                units: plain,
                description: "meshio cell name",
            };
            self.sink
                .put_texts(&about, std::slice::from_ref(&block.cell_type))?;
            let path = format!("/mesh/cells/{index}/data");
            let shape = vec![block.cell_count(), block.nodes_per_cell];
            let about = About {
                path: &path,
                shape,
                symbol: "",
                units: plain,
                description: "0-based nodes of each cell, meshio order",
            };
            self.sink.put_integers(
                &about,
                &block
                    .nodes
                    .iter()
                    .map(|&node| i64::from(node))
                    .collect::<Vec<_>>(),
            )?;
        }
        for (name, nodes) in &mesh.point_sets {
            let path = format!("/mesh/point_sets/{}", names::encode(name));
            let about = About {
                path: &path,
                shape: vec![nodes.len()],
                symbol: "",
                units: plain,
                description: "0-based nodes of the set",
            };
            self.sink.put_integers(
                &about,
                &nodes
                    .iter()
                    .map(|&node| i64::from(node))
                    .collect::<Vec<_>>(),
            )?;
        }
        Ok(())
    }
}
