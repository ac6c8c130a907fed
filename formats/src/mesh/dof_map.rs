//! Which row of the matrices belongs to which node and direction, and which rows belong to no node.

use super::{Direction, Dof};

/// Owner of a row, and of the column of the same number, of the matrices.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum MatrixRow {
    /// A direction of a node.
    Nodal(Dof),
    /// No node: an amplitude inside an element or of a substructure (internal nodes of beams, incompatible modes, scalar points). Rigid
    /// motions of the part leave it at rest.
    Internal,
}

impl MatrixRow {
    /// The dof, if the row belongs to a node.
    pub fn dof(self) -> Option<Dof> {
        match self {
            Self::Nodal(dof) => Some(dof),
            Self::Internal => None,
        }
    }
}

impl From<Dof> for MatrixRow {
    fn from(dof: Dof) -> Self {
        Self::Nodal(dof)
    }
}

/// Owners of all rows of the matrices.
#[derive(Clone, Debug, PartialEq)]
pub struct DofMap {
    owners: Vec<MatrixRow>,
    rows: Vec<[u32; 6]>,
    internal_count: usize,
}

const NO_ROW: u32 = u32::MAX;

impl DofMap {
    /// Builds the map from the owner of every matrix row, or from its dof where no row is internal.
    ///
    /// # Errors
    /// The first row whose node is not below `node_count`, or that repeats an earlier row's dof.
    pub fn new<R: Into<MatrixRow>>(owners: Vec<R>, node_count: usize) -> Result<Self, DofMapError> {
        let owners: Vec<MatrixRow> = owners.into_iter().map(Into::into).collect();
        let mut rows = vec![[NO_ROW; 6]; node_count];
        let mut internal_count = 0;
        for (row, owner) in owners.iter().enumerate() {
            let Some(dof) = owner.dof() else {
                internal_count += 1;
                continue;
            };
            let Some(of_node) = rows.get_mut(dof.node as usize) else {
                return Err(DofMapError::NoSuchNode {
                    row,
                    node: dof.node,
                    node_count,
                });
            };
            let slot = &mut of_node[dof.direction.index()];
            if *slot != NO_ROW {
                return Err(DofMapError::Repeated {
                    row,
                    first_row: *slot as usize,
                    dof,
                });
            }
            *slot = row as u32;
        }
        Ok(Self {
            owners,
            rows,
            internal_count,
        })
    }

    /// Every node with the same directions, node after node.
    ///
    /// # Errors
    /// As [`DofMap::new`]: a direction named twice.
    pub fn uniform(node_count: usize, pattern: &[Direction]) -> Result<Self, DofMapError> {
        let dofs: Vec<Dof> = (0..node_count as u32)
            .flat_map(|node| {
                pattern
                    .iter()
                    .map(move |&direction| Dof { node, direction })
            })
            .collect();
        Self::new(dofs, node_count)
    }

    /// Number of rows, n_e, internal ones too.
    pub fn len(&self) -> usize {
        self.owners.len()
    }

    /// Whether there is no row at all.
    pub fn is_empty(&self) -> bool {
        self.owners.is_empty()
    }

    /// Number of nodes of the mesh, with or without dofs.
    pub fn node_count(&self) -> usize {
        self.rows.len()
    }

    /// Number of rows that belong to no node.
    pub fn internal_count(&self) -> usize {
        self.internal_count
    }

    /// Owners of all rows, in matrix order.
    pub fn rows(&self) -> &[MatrixRow] {
        &self.owners
    }

    /// The dof of a row; `None` for an internal row.
    pub fn dof(&self, row: usize) -> Option<Dof> {
        self.owners.get(row)?.dof()
    }

    /// Rows of nodes with their dofs, in matrix order.
    pub fn nodal(&self) -> impl Iterator<Item = (usize, Dof)> + Clone {
        let owners = self.owners.iter().enumerate();
        owners.filter_map(|(row, owner)| Some((row, owner.dof()?)))
    }

    /// The dofs of the nodes in matrix order, n_f of them: internal rows are left out.
    pub fn nodal_dofs(&self) -> Vec<Dof> {
        self.nodal().map(|(_, dof)| dof).collect()
    }

    /// Matrix row of a node's direction, if the node has it.
    pub fn row(&self, node: u32, direction: Direction) -> Option<usize> {
        let row = self.rows.get(node as usize)?[direction.index()];
        (row != NO_ROW).then_some(row as usize)
    }

    /// Name of a row for messages: `node 17 uy`, or `internal row 17` (rows count from 0).
    pub fn row_name(&self, row: usize) -> String {
        match self.dof(row) {
            Some(dof) => format!("node {} {}", dof.node, dof.direction.name()),
            None => format!("internal row {row}"),
        }
    }

    /// The directions of the nodes, if all have the same in the same order, node after node, and no row is internal.
    pub fn pattern(&self) -> Option<Vec<Direction>> {
        let size = self.len().checked_div(self.node_count())?;
        let direction = |owner: &MatrixRow| owner.dof().map(|dof| dof.direction);
        let first = self.owners.get(..size)?.iter().map(direction);
        let pattern = first.collect::<Option<Vec<Direction>>>()?;
        let is_uniform = self.len() == size * self.node_count()
            && size > 0
            && self
                .owners
                .chunks_exact(size)
                .enumerate()
                .all(|(node, owners)| {
                    let mut as_first = owners.iter().zip(&pattern);
                    as_first.all(|(owner, direction)| {
                        owner.dof().is_some_and(|dof| {
                            dof.node as usize == node && dof.direction == *direction
                        })
                    })
                });
        is_uniform.then_some(pattern)
    }

    /// Whether any node carries a rotation.
    pub fn has_rotations(&self) -> bool {
        self.nodal().any(|(_, dof)| dof.direction.is_rotation())
    }
}

/// Why a dof table is not a map.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum DofMapError {
    /// A row names a node that the mesh doesn't have.
    #[error("row {row} names node {node}, but the mesh has {node_count} nodes (0-based ids)")]
    NoSuchNode {
        /// 0-based row.
        row: usize,
        /// Node named.
        node: u32,
        /// Nodes of the mesh.
        node_count: usize,
    },
    /// Two rows are the same dof.
    #[error("row {row} is node {} {} again, which is row {first_row} already", dof.node, dof.direction.name())]
    Repeated {
        /// 0-based row.
        row: usize,
        /// Where the dof stands first.
        first_row: usize,
        /// The dof.
        dof: Dof,
    },
}
