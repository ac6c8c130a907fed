//! A component as an FE code hands it over: stiffness, mass, mesh, dof table and interface requests,
//! checked against each other but not yet reduced.
//!
//! Whoever has one, a file, an importer of another code's files or a program, fills a [`ComponentDraft`]. [`Component::checked`] is the
//! only way from there to a [`Component`].
//!
//! ```
//! use std::collections::BTreeMap;
//!
//! use dcb_formats::component::{Component, ComponentDraft, Place, Units};
//! use dcb_formats::mesh::{Dimension, Direction, DofMap, Mesh};
//! use dcb_formats::SparseMatrix;
//! use faer::sparse::Triplet;
//!
//! // Two points and a spring between them, along x.
//! let mesh = Mesh {
//!     dimension: Dimension::Planar,
//!     coordinates: vec![0.0, 0.0, 1.0, 0.0],
//!     cells: Vec::new(),
//!     point_sets: BTreeMap::new(),
//! };
//! let dofs = DofMap::uniform(2, &[Direction::Ux, Direction::Uy])?;
//! let (k, m) = (1e6, 0.5);
//! let stiffness = [(0, 0, k), (2, 0, -k), (0, 2, -k), (2, 2, k)];
//! let stiffness = stiffness.map(|(row, column, value)| Triplet::new(row, column, value));
//! let mass = [0, 1, 2, 3].map(|row| Triplet::new(row, row, m));
//! let draft = ComponentDraft::new(
//!     "two points",
//!     Units { length: "m".into(), mass: "kg".into(), time: "s".into() },
//!     (mesh, dofs),
//!     SparseMatrix::try_new_from_triplets(4, 4, &stiffness)?,
//!     SparseMatrix::try_new_from_triplets(4, 4, &mass)?,
//! );
//! let component = Component::checked(draft)?;
//! assert_eq!(component.dofs.len(), 4);
//!
//! // The mass of another model is refused, by its place.
//! let other = SparseMatrix::try_new_from_triplets(3, 3, &mass[..3])?;
//! let fault = component.changed(|draft| draft.mass = other).unwrap_err();
//! assert_eq!(fault.place, Place::Mass);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod axes;
mod component_masses;
mod damping;
mod draft;
mod fault;
mod geometry;
mod interfaces;
mod label;
mod mass_moments;
mod operators;
mod stiffening;
mod stress;

use schemars::JsonSchema;
use serde::Deserialize;

use crate::SparseMatrix;
use crate::mesh::{Dimension, Direction};

pub use damping::Damping;
pub use draft::{Component, ComponentDraft};
pub use fault::{ComponentFault, Place};

pub(crate) use fault::fault;
pub(crate) use geometry::{CELL_TYPES, check_directions, check_mesh, check_nodal, check_repeats};
pub(crate) use interfaces::{check_interfaces, check_weights_kind};
pub(crate) use label::{check_label, check_units};
pub use operators::ROUNDING_ASYMMETRY;
pub(crate) use operators::asymmetry_note;
pub use stiffening::UnknownPrestress;
pub use stress::{
    NamedStress, StressComponent, StressPoint, StressQuantity, have_von_mises, von_mises,
};

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

/// How the nodes of an interface become rows of L_b.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum InterfaceKind {
    /// The raw dofs of the nodes.
    Nodes,
    /// One frame that follows the weighted mean motion of the nodes (force-distributing, RBE3).
    Average,
    /// The nodes move as one rigid frame (RBE2).
    Rigid,
    /// Rows given explicitly as a matrix.
    #[serde(skip)]
    Boundary,
}

impl InterfaceKind {
    /// All of them.
    pub(crate) const ALL: [Self; 4] = [Self::Nodes, Self::Average, Self::Rigid, Self::Boundary];

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

/// Purpose of an interface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Role {
    /// Forces act here: attachment columns are computed.
    #[default]
    Attachment,
    /// Observed only: rows in the interface shapes.
    Output,
}

impl Role {
    /// Both.
    pub(crate) const ALL: [Self; 2] = [Self::Attachment, Self::Output];

    /// Name as files write it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Attachment => "attachment",
            Self::Output => "output",
        }
    }
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

/// Name of the interface that the rows of [`ComponentDraft::explicit_boundary`] make.
pub const EXPLICIT_BOUNDARY: &str = "boundary";

/// An input file and its use.
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

impl ComponentMasses {
    /// Names of the matrices, in their order.
    pub fn names(dimension: Dimension) -> &'static [&'static str] {
        match dimension {
            Dimension::Planar => &["xx", "yy", "xy"],
            Dimension::Spatial => &PAIRS_OF_AXES,
        }
    }
}

/// Pairs of axes in stored order.
const PAIRS_OF_AXES: [&str; 6] = ["xx", "yy", "zz", "xy", "yz", "zx"];

/// A load on the inside of the component.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedLoad {
    /// Unique name.
    pub name: String,
    /// Force or moment on each dof, (n_e).
    pub forces: Vec<f64>,
}

/// Geometric stiffness of the free component by the source of its prestress, inertia relieved (the component accelerates under it).
#[derive(Clone, Debug, Default)]
pub struct GeometricStiffness {
    /// (n_e, n_e) per product of spins ω_a ω_b, (rad/time)²: xx, yy, zz, xy, yz, zx, planar zz, `None` where there is none of it;
    /// empty where spins weren't considered.
    pub spins: Vec<Option<SparseMatrix>>,
    /// (n_e, n_e) for a unit force on a row of an interface.
    pub rows: Vec<RowStiffness>,
}

impl GeometricStiffness {
    /// Names of the products of spins, in the order of `spins`.
    pub fn spin_products(dimension: Dimension) -> &'static [&'static str] {
        match dimension {
            Dimension::Planar => &["zz"],
            Dimension::Spatial => &PAIRS_OF_AXES,
        }
    }
}

/// Geometric stiffness of a unit force along a row.
#[derive(Clone, Debug)]
pub struct RowStiffness {
    /// Index of the interface and direction of its row.
    pub row: (usize, Direction),
    /// (n_e, n_e).
    pub matrix: SparseMatrix,
}
