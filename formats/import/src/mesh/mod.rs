//! Readers of meshes, a file each, and what they find.

use dcb_formats::mesh::CellBlock;

use crate::stored::RowLabel;

/// A mesh as a file lists it: nodes in file order. Nodes are named by their place in `points`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FoundMesh {
    /// Coordinates of each node.
    pub points: Vec<[f64; 3]>,
    /// Label of each node, all different; `None` where the format has none.
    pub labels: Option<Vec<u32>>,
    /// Cells in meshio's names and node order, a block for each type.
    pub cells: Vec<CellBlock>,
    /// Named sets of nodes, and the nodes of named faces and edges; in file order, each node once. Sets may be empty.
    pub sets: Vec<(String, Vec<u32>)>,
    /// Nodes of named groups of the part's own cells, such as those of one material: no interfaces unless somebody asks for them by name.
    pub cell_sets: Vec<(String, Vec<u32>)>,
    /// Nodes whose displacements are along axes of their own: three unit vectors, one a row, in the axes of the points.
    pub displacement_axes: Vec<(u32, [[f64; 3]; 3])>,
    /// Points without place that have a row each, by their label.
    pub scalar_points: Vec<u32>,
    /// Rows of matrices that go with this mesh but have no labels, where the file says their order.
    pub rows: Option<Vec<RowLabel>>,
    /// Nodes that move as one rigid body.
    pub rigid_bodies: Vec<RigidBody>,
    /// Nodes that are held in some direction, each once.
    pub held: Vec<u32>,
    /// Nodes of which some direction depends on other nodes, each once: those of rigid bodies, the first ones of equations.
    pub dependent: Vec<u32>,
    /// Files that this one includes: name as it is written there, and SHA-256 of the bytes, hexadecimal.
    pub included: Vec<(String, String)>,
    /// Remarks for the user, a sentence each.
    pub notes: Vec<String>,
}

/// Nodes that a deck makes one rigid body of.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RigidBody {
    /// Dependent nodes, in file order, each once.
    pub nodes: Vec<u32>,
    /// Node that carries the translations.
    pub reference: u32,
    /// Node whose translations stand for the rotations, where the deck names one.
    pub rotation: Option<u32>,
}

impl FoundMesh {
    /// Nodes that no cell has, in file order: reference points, forgotten geometry.
    pub fn nodes_without_cells(&self) -> Vec<u32> {
        let mut is_used = vec![false; self.points.len()];
        for node in self.cells.iter().flat_map(|cells| &cells.nodes) {
            if let Some(is_used) = is_used.get_mut(*node as usize) {
                *is_used = true;
            }
        }
        (0..self.points.len() as u32)
            .filter(|node| !is_used[*node as usize])
            .collect()
    }
}
