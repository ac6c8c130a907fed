//! Displacements of the nodes that are drawn, column by column of the nodal fields.

use dcb_formats::RecoveryBasis;
use dcb_formats::mesh::Mesh;
use dcb_view::Drawing;
use faer::MatRef;

/// Which rows of the fields are the translations of each drawn node.
pub struct Displacements {
    rows: Vec<[Option<usize>; 3]>,
}

impl Displacements {
    pub fn of(fields: &RecoveryBasis, mesh: &Mesh, drawing: &Drawing) -> Self {
        let mut of_nodes = vec![[None; 3]; mesh.node_count()];
        for (row, dof) in fields.dofs.iter().enumerate() {
            if dof.direction.is_rotation() {
                continue;
            }
            if let Some(of_node) = of_nodes.get_mut(dof.node as usize) {
                of_node[dof.direction.axis()] = Some(row);
            }
        }
        let drawn = drawing.nodes.iter();
        Self {
            rows: drawn.map(|node| of_nodes[*node as usize]).collect(),
        }
    }

    /// Body axes; zero for nodes that the fields don't have.
    pub fn of_column(&self, fields: MatRef<'_, f64>, column: usize) -> Vec<[f64; 3]> {
        let value = |row: Option<usize>| row.map_or(0.0, |row| fields[(row, column)]);
        self.rows.iter().map(|rows| rows.map(value)).collect()
    }
}
