//! The geometry of a component: nodes, cells, node sets, and which matrix row
//! belongs to which node and direction.
//!
//! Nothing here knows about stiffness or mass. Node ids are 0-based and are
//! used as the component file gives them.

mod dof_map;

use std::collections::BTreeMap;

pub use dof_map::{DofMap, DofMapError, MatrixRow};

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

/// A direction of a node.
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
