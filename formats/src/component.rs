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

/// Purpose of an interface.
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

impl Damping {
    /// `[alpha, beta]` of the Rayleigh damping with these ratios to critical at these frequencies, in cycles per time:
    /// `2 ζ ω = alpha + beta ω²` at both.
    ///
    /// # Errors
    /// Found and expected, for numbers that no Rayleigh damping with alpha and beta of zero or more goes through.
    pub fn rayleigh_through(frequencies: [f64; 2], ratios: [f64; 2]) -> Result<[f64; 2], String> {
        if let Some(found) = frequencies.iter().find(|f| !(**f > 0.0 && f.is_finite())) {
            return Err(format!(
                "has the frequency {found}, expected frequencies above 0 in cycles per time"
            ));
        }
        if let Some(found) = ratios.iter().find(|z| !(**z >= 0.0 && z.is_finite())) {
            return Err(format!("has the ratio {found}, expected ratios >= 0"));
        }
        let [first, second] = frequencies.map(|frequency| std::f64::consts::TAU * frequency);
        if first == second {
            return Err(format!(
                "has the frequency {} twice, expected two that differ",
                frequencies[0]
            ));
        }
        let [at_first, at_second] = ratios;
        let square = second * second - first * first;
        let factors = [
            2.0 * first * second * (at_first * second - at_second * first) / square,
            2.0 * (at_second * second - at_first * first) / square,
        ];
        // A ratio that is just proportional to the frequency, or its inverse, has a factor of zero.
        let sizes = [
            at_first * second + at_second * first,
            at_second * second + at_first * first,
        ];
        let scales = [2.0 * first * second / square, 2.0 / square];
        let mut rounded = factors;
        for ((factor, size), scale) in rounded.iter_mut().zip(sizes).zip(scales) {
            if factor.abs() <= 1e-12 * size * scale.abs() {
                *factor = 0.0;
            }
        }
        match rounded.iter().position(|factor| *factor < 0.0) {
            None => Ok(rounded),
            Some(which) => {
                let span = frequencies[1] / frequencies[0];
                let [least, most] = if span > 1.0 {
                    [1.0 / span, span]
                } else {
                    [span, 1.0 / span]
                };
                Err(format!(
                    "needs {} = {:.4e}, which would feed energy in: with these frequencies the second ratio must be {:.4e} to {:.4e} of the first, but is {:.4e} of it",
                    ["alpha", "beta"][which],
                    rounded[which],
                    least,
                    most,
                    at_second / at_first
                ))
            }
        }
    }
}

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

/// Geometric stiffness of a unit force along a row.
#[derive(Clone, Debug)]
pub struct RowStiffness {
    /// Index of the interface and direction of its row.
    pub row: (usize, Direction),
    /// (n_e, n_e).
    pub matrix: SparseMatrix,
}

/// A component ready to be reduced: every member has been checked against the others.
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
    /// Notes for the reader of the files: duplicates summed, asymmetry averaged and the like.
    pub notes: Vec<String>,
}

impl Component {
    /// Planar or spatial.
    pub fn dimension(&self) -> Dimension {
        self.mesh.dimension
    }
}
