//! A component as an FE code hands it over: stiffness, mass, mesh, dof table and interface requests,
//! checked against each other but not yet reduced.

use crate::SparseMatrix;
use crate::mesh::{Dimension, Direction, DofMap, Mesh};

/// The unit system, as the component names it. Every number of the component and of its superelement is in
/// these units and their products (force = mass·length/time²).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Units {
    /// Length unit, for example `m` or `mm`.
    pub length: String,
    /// Mass unit, for example `kg` or `t`.
    pub mass: String,
    /// Time unit, for example `s`.
    pub time: String,
}

/// How an interface turns nodal dofs into rows of the boundary localization L_b.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum InterfaceKind {
    /// The raw dofs of the nodes.
    Nodes,
    /// One frame that follows the nodes' weighted mean motion (force-distributing, RBE3).
    Average,
    /// The nodes move as one rigid frame (RBE2).
    Rigid,
    /// Rows given explicitly as a matrix.
    Boundary,
}

impl InterfaceKind {
    /// Name as files write it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Nodes => "nodes",
            Self::Average => "average",
            Self::Rigid => "rigid",
            Self::Boundary => "boundary",
        }
    }
}

/// Weights of an averaged interface's nodes.
#[derive(Clone, Debug, PartialEq)]
pub enum Weights {
    /// Every node counts the same.
    Uniform,
    /// By the surface (planar: boundary length) that belongs to each node.
    Area,
    /// By the diagonal of the mass matrix.
    Mass,
    /// One positive number per node, in the order of the nodes.
    Given(Vec<f64>),
}

/// What an interface is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// Forces act here: it gets attachment columns.
    Attachment,
    /// Observed only: rows in the interface shapes, no attachment columns.
    Output,
}

/// One requested interface.
#[derive(Clone, Debug, PartialEq)]
pub struct Interface {
    /// Unique name.
    pub name: String,
    /// Kind of coupling.
    pub kind: InterfaceKind,
    /// Its nodes, 0-based, not empty, no repeats, in the order given.
    pub nodes: Vec<u32>,
    /// Reference point in component coordinates; the weighted centroid where `None`.
    pub position: Option<[f64; 3]>,
    /// Node weights (`average` only).
    pub weights: Weights,
    /// The frame's own axes as three unit vectors in component coordinates, one a row; the component's axes where `None`.
    pub axes: Option<[[f64; 3]; 3]>,
    /// Directions wanted, a subset; all that the kind has where `None`.
    pub directions: Option<Vec<Direction>>,
    /// Attachment or output.
    pub role: Role,
}

/// Damping as the component states it.
#[derive(Clone, Debug, PartialEq)]
pub enum Damping {
    /// None given.
    None,
    /// The same ratio to critical for every mode.
    Uniform(f64),
    /// One ratio per mode; the last holds for any further ones and for the attachments.
    PerMode(Vec<f64>),
    /// Rayleigh: `C = alpha M + beta K`, alpha in 1/time, beta in time.
    Rayleigh {
        /// Mass factor.
        alpha: f64,
        /// Stiffness factor.
        beta: f64,
    },
}

/// An input file and what it was used for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Source {
    /// `stiffness`, `mass`, `mesh`, `boundary`, `mass.xx` and so on.
    pub role: String,
    /// File name without its folder.
    pub file_name: String,
    /// SHA-256 of the file's bytes, hex.
    pub sha256: String,
}

/// Element-integrated component masses `M_cd = ∫ ρ N_cᵀ N_d dV`, (n_e, n_e) each: exact invariants for beams and shells.
#[derive(Clone, Debug)]
pub struct ComponentMasses {
    /// Order xx, yy, zz, xy, yz, zx; planar xx, yy, xy.
    pub matrices: Vec<SparseMatrix>,
}

/// A load on the inside of the part.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedLoad {
    /// Unique name.
    pub name: String,
    /// Force or moment on each dof, (n_e).
    pub forces: Vec<f64>,
}

/// Geometric stiffness of the free part by what its prestress comes from, inertia relieved (the part accelerates under it).
#[derive(Clone, Debug, Default)]
pub struct GeometricStiffness {
    /// (n_e, n_e) per product of spins ω_a ω_b, (rad/time)²: xx, yy, zz, xy, yz, zx, planar zz, `None` where there is none of it;
    /// empty where spins weren't considered.
    pub spins: Vec<Option<SparseMatrix>>,
    /// (n_e, n_e) for a unit force on a row of an interface.
    pub rows: Vec<RowStiffness>,
}

/// Geometric stiffness of a unit force along a row.
#[derive(Clone, Debug)]
pub struct RowStiffness {
    /// Index of the interface and direction of its row.
    pub row: (usize, Direction),
    /// (n_e, n_e).
    pub matrix: SparseMatrix,
}

/// A component ready to be reduced: every part has been checked against the others.
#[derive(Clone, Debug)]
pub struct Component {
    /// Name.
    pub name: String,
    /// Unit system.
    pub units: Units,
    /// Geometry.
    pub mesh: Mesh,
    /// Row ↔ node and direction, n_e of them.
    pub dofs: DofMap,
    /// K_ee, (n_e, n_e), full symmetric storage, sorted, no duplicates.
    pub stiffness: SparseMatrix,
    /// M_ee, (n_e, n_e), full symmetric storage, positive semi-definite.
    pub mass: SparseMatrix,
    /// Exact component masses, if the FE code gave them.
    pub component_masses: Option<ComponentMasses>,
    /// Requested interfaces, in row order.
    pub interfaces: Vec<Interface>,
    /// Rows of L_b given as a matrix, (n_rows, n_e); they follow the interfaces' rows.
    pub explicit_boundary: Option<SparseMatrix>,
    /// Loads on the inside, by name.
    pub loads: Vec<NamedLoad>,
    /// Geometric stiffness, if the FE code gave it.
    pub geometric_stiffness: Option<GeometricStiffness>,
    /// Damping.
    pub damping: Damping,
    /// Where everything came from.
    pub sources: Vec<Source>,
    /// What a reader of the files should be told: duplicates summed, asymmetry averaged and the like.
    pub notes: Vec<String>,
}

impl Component {
    /// Planar or spatial.
    pub fn dimension(&self) -> Dimension {
        self.mesh.dimension
    }
}
