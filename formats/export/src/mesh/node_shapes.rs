//! Displacements of nodes over coordinates of a superelement.

use dcb_formats::RecoveryBasis;
use dcb_formats::mesh::Mesh;
use faer::Mat;

/// Displacements of the nodes that have all translations.
pub(crate) struct NodeShapes {
    /// Numbers of these nodes in the mesh, ascending.
    pub nodes: Vec<u32>,
    /// (3 nodes, q), node after node: x, y, z; zero along z for planar parts.
    pub shapes: Mat<f64>,
    /// Whether a node turns too.
    pub has_rotations: bool,
}

impl NodeShapes {
    /// Over the columns of `to_file`, (n, q): amplitudes of modes, attachments and further columns.
    pub(crate) fn of(fields: &RecoveryBasis, mesh: &Mesh, to_file: &Mat<f64>) -> Self {
        let d = mesh.dimension.coordinate_count();
        let mut rows = vec![[None; 3]; mesh.node_count()];
        let mut has_rotations = false;
        for (row, dof) in fields.dofs.iter().enumerate() {
            if dof.direction.is_rotation() {
                has_rotations = true;
            } else if let Some(of_node) = rows.get_mut(dof.node as usize) {
                of_node[dof.direction.axis()] = Some(row);
            }
        }
        let nodes: Vec<u32> = (0..mesh.node_count())
            .filter(|node| rows[*node][..d].iter().all(Option::is_some))
            .map(|node| node as u32)
            .collect();
        let row = |i: usize| rows[nodes[i / 3] as usize][i % 3];
        let mut shapes = Mat::zeros(3 * nodes.len(), to_file.ncols());
        let further = fields.enrichment.as_ref();
        let blocks = [Some(&fields.modes), Some(&fields.residual), further];
        let mut first = 0;
        for block in blocks.into_iter().flatten() {
            let taken = Mat::from_fn(shapes.nrows(), block.ncols(), |i, j| {
                row(i).map_or(0.0, |row| block[(row, j)])
            });
            let last = (first + block.ncols()).min(to_file.nrows());
            shapes += taken.as_ref().subcols(0, last - first)
                * to_file.as_ref().subrows(first, last - first);
            first = last;
        }
        Self {
            nodes,
            shapes,
            has_rotations,
        }
    }
}
