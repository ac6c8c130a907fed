//! Readers of meshes, a file each, and what they find.

use dcb_formats::mesh::CellBlock;

use crate::stored::RowLabel;

/// A mesh as a file lists it: nodes in file order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FoundMesh {
    /// Coordinates of each node.
    pub points: Vec<[f64; 3]>,
    /// Label of each node, all different; `None` where the format has none.
    pub labels: Option<Vec<u32>>,
    /// Cells in meshio's names and node order; nodes by their place in `points`.
    pub cells: Vec<CellBlock>,
    /// Named sets of nodes, by their place in `points`, in file order, each node once.
    pub sets: Vec<(String, Vec<u32>)>,
    /// Nodes whose displacements are along axes of their own: three unit vectors, one a row, in the axes of the points.
    pub displacement_axes: Vec<(u32, [[f64; 3]; 3])>,
    /// Points without place that have a row each, by their label.
    pub scalar_points: Vec<u32>,
    /// Rows of matrices that go with this mesh but have no labels, where the file says their order.
    pub rows: Option<Vec<RowLabel>>,
    /// Remarks for the user, a sentence each.
    pub notes: Vec<String>,
}
