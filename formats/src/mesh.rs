//! The geometry of a component: nodes, cells, node sets, and which matrix row
//! belongs to which node and direction.
//!
//! Nothing here knows about stiffness or mass. Node ids are 0-based and are
//! used as the component file gives them.

use std::collections::BTreeMap;

/// Planar (x, y) or spatial (x, y, z). A component, a superelement and a scene are one or the other.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Dimension {
    /// Two translations and one rotation per rigid body.
    Planar,
    /// Three translations and three rotations per rigid body.
    Spatial,
}

impl Dimension {
    /// Number of coordinates of a point: 2 or 3.
    pub fn coordinate_count(self) -> usize {
        match self {
            Self::Planar => 2,
            Self::Spatial => 3,
        }
    }

    /// Number of rigid-body motions: 3 or 6.
    pub fn rigid_mode_count(self) -> usize {
        match self {
            Self::Planar => 3,
            Self::Spatial => 6,
        }
    }

    /// Directions a rigid frame has, translations before rotations.
    pub fn frame_directions(self) -> &'static [Direction] {
        match self {
            Self::Planar => &[Direction::Ux, Direction::Uy, Direction::Rz],
            Self::Spatial => &Direction::ALL,
        }
    }
}

/// One of the six nodal directions, in component axes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(u8)]
pub enum Direction {
    /// Displacement along x.
    Ux = 0,
    /// Displacement along y.
    Uy = 1,
    /// Displacement along z.
    Uz = 2,
    /// Rotation about x.
    Rx = 3,
    /// Rotation about y.
    Ry = 4,
    /// Rotation about z.
    Rz = 5,
}

impl Direction {
    /// All six, in index order.
    pub const ALL: [Self; 6] = [Self::Ux, Self::Uy, Self::Uz, Self::Rx, Self::Ry, Self::Rz];
    /// Names as files write them, in index order.
    pub const NAMES: [&'static str; 6] = ["ux", "uy", "uz", "rx", "ry", "rz"];

    /// Index 0..6 in `ux uy uz rx ry rz`.
    pub fn index(self) -> usize {
        self as usize
    }

    /// Name as files write it.
    pub fn name(self) -> &'static str {
        Self::NAMES[self.index()]
    }

    /// The direction with index 0..6, if there is one.
    pub fn from_index(index: usize) -> Option<Self> {
        Self::ALL.get(index).copied()
    }

    /// The direction with this name, if there is one.
    pub fn from_name(name: &str) -> Option<Self> {
        Self::NAMES
            .iter()
            .position(|known| *known == name)
            .and_then(Self::from_index)
    }

    /// Whether this is a rotation.
    pub fn is_rotation(self) -> bool {
        self.index() >= 3
    }

    /// Axis 0, 1, 2 along which the translation or about which the rotation goes.
    pub fn axis(self) -> usize {
        self.index() % 3
    }
}

/// One matrix row or column: a direction of a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Dof {
    /// 0-based node id.
    pub node: u32,
    /// Direction in component axes.
    pub direction: Direction,
}

/// Cells of one type, in meshio's names and node order.
#[derive(Clone, Debug, PartialEq)]
pub struct CellBlock {
    /// meshio cell name, for example `hexahedron20`.
    pub cell_type: String,
    /// Nodes of one cell.
    pub nodes_per_cell: usize,
    /// Node ids, cell after cell; its length is a multiple of `nodes_per_cell`.
    pub nodes: Vec<u32>,
}

impl CellBlock {
    /// Number of cells in the block.
    pub fn cell_count(&self) -> usize {
        self.nodes
            .len()
            .checked_div(self.nodes_per_cell)
            .unwrap_or(0)
    }

    /// The cells, each as its node ids.
    pub fn cells(&self) -> impl Iterator<Item = &[u32]> {
        self.nodes.chunks_exact(self.nodes_per_cell.max(1))
    }
}

/// Nodes, cells and node sets of a component, in component axes and the component's length unit.
#[derive(Clone, Debug, PartialEq)]
pub struct Mesh {
    /// Planar or spatial; decides the stride of `coordinates`.
    pub dimension: Dimension,
    /// Node coordinates, node after node (2 or 3 numbers each).
    pub coordinates: Vec<f64>,
    /// Cells; may be empty.
    pub cells: Vec<CellBlock>,
    /// Named node sets.
    pub point_sets: BTreeMap<String, Vec<u32>>,
}

impl Mesh {
    /// The places of the nodes, without cells and sets.
    pub fn points_alone(self) -> Self {
        Self {
            cells: Vec::new(),
            point_sets: BTreeMap::new(),
            ..self
        }
    }

    /// Number of nodes.
    pub fn node_count(&self) -> usize {
        self.coordinates.len() / self.dimension.coordinate_count()
    }

    /// Position of a node; the third coordinate of a planar mesh is 0.
    pub fn position(&self, node: u32) -> [f64; 3] {
        let stride = self.dimension.coordinate_count();
        let at = node as usize * stride;
        let mut position = [0.0; 3];
        position[..stride].copy_from_slice(&self.coordinates[at..at + stride]);
        position
    }
}

/// Which matrix row belongs to which node and direction.
#[derive(Clone, Debug, PartialEq)]
pub struct DofMap {
    dofs: Vec<Dof>,
    rows: Vec<[u32; 6]>,
}

const NO_ROW: u32 = u32::MAX;

impl DofMap {
    /// Builds the map from the dof of every matrix row.
    ///
    /// # Errors
    /// The first row whose node is not below `node_count`, or that repeats an earlier row's dof.
    pub fn new(dofs: Vec<Dof>, node_count: usize) -> Result<Self, DofMapError> {
        let mut rows = vec![[NO_ROW; 6]; node_count];
        for (row, dof) in dofs.iter().enumerate() {
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
                    dof: *dof,
                });
            }
            *slot = row as u32;
        }
        Ok(Self { dofs, rows })
    }

    /// Every node with the same directions, node after node.
    ///
    /// # Errors
    /// As [`DofMap::new`]: a direction named twice.
    pub fn uniform(node_count: usize, pattern: &[Direction]) -> Result<Self, DofMapError> {
        let dofs = (0..node_count as u32)
            .flat_map(|node| {
                pattern
                    .iter()
                    .map(move |&direction| Dof { node, direction })
            })
            .collect();
        Self::new(dofs, node_count)
    }

    /// Number of dofs, n_e.
    pub fn len(&self) -> usize {
        self.dofs.len()
    }

    /// Whether there is no dof at all.
    pub fn is_empty(&self) -> bool {
        self.dofs.is_empty()
    }

    /// Number of nodes of the mesh, with or without dofs.
    pub fn node_count(&self) -> usize {
        self.rows.len()
    }

    /// The dofs in matrix order.
    pub fn dofs(&self) -> &[Dof] {
        &self.dofs
    }

    /// Matrix row of a node's direction, if the node has it.
    pub fn row(&self, node: u32, direction: Direction) -> Option<usize> {
        let row = self.rows.get(node as usize)?[direction.index()];
        (row != NO_ROW).then_some(row as usize)
    }

    /// The directions of the nodes, if all have the same in the same order, node after node.
    pub fn pattern(&self) -> Option<Vec<Direction>> {
        let size = self.len().checked_div(self.node_count())?;
        let of_node = |dofs: &[Dof]| dofs.iter().map(|dof| dof.direction).collect::<Vec<_>>();
        let pattern = of_node(self.dofs.get(..size)?);
        let is_uniform = self.len() == size * self.node_count()
            && size > 0
            && self
                .dofs
                .chunks_exact(size)
                .enumerate()
                .all(|(node, dofs)| {
                    let as_first = dofs.iter().zip(&pattern);
                    as_first.into_iter().all(|(dof, direction)| {
                        dof.node as usize == node && dof.direction == *direction
                    })
                });
        is_uniform.then_some(pattern)
    }

    /// Whether any node carries a rotation.
    pub fn has_rotations(&self) -> bool {
        self.dofs.iter().any(|dof| dof.direction.is_rotation())
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
