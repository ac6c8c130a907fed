//! Rows of matrices in the order of a component, and the node of the mesh that each belongs to.

use dcb_formats::mesh::{Direction, Dof, MatrixRow};
use rustc_hash::FxHashMap;

use crate::mesh::FoundMesh;
use crate::request::NodeOrder;
use crate::rigid_motions::RowPlace;
use crate::stored::RowLabel;

/// Labelled rows of stiffness and mass in one order: nodes by rising label, internal rows after them.
#[derive(Debug)]
pub(crate) struct CommonRows {
    /// Label of each row.
    pub labels: Vec<RowLabel>,
    /// New number of each row of the stiffness; `None` where it keeps its own.
    pub stiffness: Option<Vec<u32>>,
    /// The same of the mass.
    pub mass: Option<Vec<u32>>,
}

impl CommonRows {
    /// Every label of either matrix.
    pub fn of(stiffness: &[RowLabel], mass: &[RowLabel]) -> Self {
        let mut labels = [stiffness, mass].concat();
        labels.sort_unstable();
        labels.dedup();
        let numbers = |of: &[RowLabel]| {
            let place = |label: &RowLabel| labels.binary_search(label).unwrap_or_default() as u32;
            let numbers: Vec<u32> = of.iter().map(place).collect();
            let is_kept = numbers.iter().copied().eq(0..labels.len() as u32);
            (!is_kept).then_some(numbers)
        };
        Self {
            stiffness: numbers(stiffness),
            mass: numbers(mass),
            labels,
        }
    }
}

/// Owners of labelled rows.
#[derive(Debug, Default)]
pub(crate) struct Owners {
    /// Of each row.
    pub rows: Vec<MatrixRow>,
    /// Labels that the mesh doesn't have, rising, each once; their rows are taken as internal ones for the time being.
    pub unknown: Vec<u32>,
    /// Rows of labels that the mesh doesn't have.
    pub unknown_rows: usize,
    /// Remarks for the user.
    pub notes: Vec<String>,
}

impl Owners {
    /// Looks up the labels of rows in a mesh. In a mesh without labels the nodes have the labels of the rows in rising order, if they are as
    /// many.
    pub fn of(labels: &[RowLabel], mesh: &FoundMesh) -> Self {
        let mut owners = Self::default();
        let nodes: FxHashMap<u32, u32> = match &mesh.labels {
            Some(labels) => labels.iter().copied().zip(0..).collect(),
            None => owners.by_rank(labels, mesh.points.len()),
        };
        for label in labels {
            let owner = match label {
                RowLabel::Internal { .. } => MatrixRow::Internal,
                RowLabel::Nodal { node, direction } => match nodes.get(node) {
                    Some(&node) => MatrixRow::Nodal(Dof {
                        node,
                        direction: *direction,
                    }),
                    None => {
                        owners.unknown.push(*node);
                        owners.unknown_rows += 1;
                        MatrixRow::Internal
                    }
                },
            };
            owners.rows.push(owner);
        }
        owners.unknown.sort_unstable();
        owners.unknown.dedup();
        owners
    }

    fn by_rank(&mut self, labels: &[RowLabel], node_count: usize) -> FxHashMap<u32, u32> {
        let mut nodes: Vec<u32> = labels
            .iter()
            .filter_map(|label| match label {
                RowLabel::Nodal { node, .. } => Some(*node),
                RowLabel::Internal { .. } => None,
            })
            .collect();
        nodes.sort_unstable();
        nodes.dedup();
        if nodes.len() != node_count {
            return FxHashMap::default();
        }
        self.notes.push(
            "the mesh has no labels: its nodes, as they are listed, are taken for the rows' labels in rising order"
                .into(),
        );
        nodes.into_iter().zip(0..).collect()
    }
}

/// Owners of rows without labels: every node with the same directions, node after node.
pub(crate) fn positional(
    mesh: &FoundMesh,
    order: NodeOrder,
    pattern: &[Direction],
) -> Vec<MatrixRow> {
    node_after_node(&nodes_in_order(mesh, order), pattern)
}

/// Owners of rows that go node after node, each with the same directions.
pub(crate) fn node_after_node(nodes: &[u32], pattern: &[Direction]) -> Vec<MatrixRow> {
    let owners = |&node: &u32| {
        let owner = move |&direction| MatrixRow::Nodal(Dof { node, direction });
        pattern.iter().map(owner)
    };
    nodes.iter().flat_map(owners).collect()
}

/// Places of the nodes in an order.
pub(crate) fn nodes_in_order(mesh: &FoundMesh, order: NodeOrder) -> Vec<u32> {
    let mut nodes: Vec<u32> = (0..mesh.points.len() as u32).collect();
    if let (NodeOrder::Label, Some(labels)) = (order, &mesh.labels) {
        nodes.sort_by_key(|&node| labels[node as usize]);
    }
    nodes
}

/// Position and direction of each row.
pub(crate) fn row_places(mesh: &FoundMesh, rows: &[MatrixRow]) -> Vec<RowPlace> {
    let place = |owner: &MatrixRow| match owner {
        MatrixRow::Nodal(Dof { node, direction }) => {
            Some((mesh.points[*node as usize], *direction))
        }
        MatrixRow::Internal => None,
    };
    rows.iter().map(place).collect()
}
