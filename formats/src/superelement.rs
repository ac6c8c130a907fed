//! The reduced component: the content of a `.dcb.h5` file, as plain data.
//!
//! Symbols and shapes are those of `docs/notation.md`; n_b counts the rows of the boundary localization,
//! n_k the kept modes, n_x further columns, n = n_k + n_b + n_x. Dense arrays are faer matrices in the shape
//! that the file documents; small fixed-size blocks are plain arrays.

mod derivation;
mod stress;

pub use derivation::{CouplingSource, Derivation, InterfaceDirections, SelectionRecord};
pub use stress::StressField;

use faer::Mat;

use crate::component::{InterfaceKind, Role, Source, Units};
use crate::mesh::{Dimension, Direction, Dof};

/// How the body frame follows the body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrameKind {
    /// Tisserand axes: L1 and I3 vanish.
    MeanAxis,
    /// Some other frame: L1 and I3 are not zero and must be carried.
    Given,
}

impl FrameKind {
    /// Name as files write it.
    pub fn name(self) -> &'static str {
        match self {
            Self::MeanAxis => "mean-axis",
            Self::Given => "given",
        }
    }
}

/// One named interface, body frame.
#[derive(Clone, Debug, PartialEq)]
pub struct InterfaceFrame {
    /// Unique name.
    pub name: String,
    /// Kind of coupling.
    pub kind: InterfaceKind,
    /// Attachment or output.
    pub role: Role,
    /// Reference position, body frame, component's length unit (planar: z = 0).
    pub position: [f64; 3],
    /// Rest rotation matrix, frame axes to body axes; its columns are the frame's axes (planar: about z).
    pub orientation: [[f64; 3]; 3],
}

/// One row of the boundary localization.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoundaryRow {
    /// Index of the interface it belongs to.
    pub interface: usize,
    /// Index in `ux uy uz rx ry rz`, or -1 for a row of an explicit boundary.
    pub direction: i64,
    /// Node of the row, or -1 for a frame or an explicit row.
    pub node: i64,
    /// Reference position, body frame.
    pub position: [f64; 3],
}

/// Kept free-free elastic modes as the interfaces see them.
#[derive(Clone, Debug, PartialEq)]
pub struct Modes {
    /// ω², ascending, (n_k), 1/time².
    pub eigenvalues: Vec<f64>,
    /// Ratio to critical, (n_k).
    pub damping: Vec<f64>,
    /// The attachments' ratio to critical.
    pub residual_damping: f64,
    /// L_b Φ, (n_b, n_k).
    pub interface_shapes: Mat<f64>,
    /// The lowest ω² left out; infinite if nothing was.
    pub first_omitted_eigenvalue: f64,
}

/// Residual flexibility as the interfaces see it. Rows and columns of output interfaces are zero.
#[derive(Clone, Debug, PartialEq)]
pub struct Residual {
    /// F_res = L_b G_res L_bᵀ, (n_b, n_b), symmetric positive semi-definite.
    pub flexibility: Mat<f64>,
    /// M_res = (G_res L_bᵀ)ᵀ M (G_res L_bᵀ), (n_b, n_b), symmetric positive semi-definite.
    pub mass: Mat<f64>,
    /// diag(M_res) with no mode kept, (n_b): the filter's unit-free scaling.
    pub mass_diagonal0: Vec<f64>,
    /// T_r, (n_b, rank): T_rᵀ M_res T_r = I, T_rᵀ F_res T_r = diag(sigma_squared).
    pub transform: Mat<f64>,
    /// σ², ascending, (rank).
    pub sigma_squared: Vec<f64>,
    /// Relative tolerance below which a scaled direction of M_res was left out of `transform`.
    pub tolerance: f64,
    /// L_b G_res L_bᵀ with the rows of output interfaces, (n_b, n_b); `None` where there is no output interface.
    pub output_shapes: Option<Mat<f64>>,
}

/// Inertia about the centre of mass and its dependence on the reduced coordinates, body frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Inertia {
    /// Total mass.
    pub mass: f64,
    /// Inertia tensor (planar: only the (z, z) entry is meaningful).
    pub tensor: [[f64; 3]; 3],
    /// L1 over the basis, (d, n).
    pub l1: Mat<f64>,
    /// First-order change of inertia: planar (n) blocks of which only entry (z, z) is used and holds I1; spatial J1, n blocks 3x3.
    pub i1: Vec<[[f64; 3]; 3]>,
    /// I3 over the basis: planar (1, n), spatial (3, n).
    pub i3: Mat<f64>,
    /// Antisymmetric coupling, planar one, spatial three matrices (n, n).
    pub l3: Vec<Mat<f64>>,
    /// Second-order change of inertia J2, spatial: six matrices (n, n) in the order xx, yy, zz, xy, yz, zx; planar empty.
    pub i2: Vec<Mat<f64>>,
}

impl Inertia {
    /// Root of the tensor's trace by the mass: a length that says how large the body is.
    pub fn radius_of_gyration(&self) -> f64 {
        let trace: f64 = (0..3).map(|axis| self.tensor[axis][axis]).sum();
        (trace / self.mass).sqrt()
    }
}

/// Geometric stiffening matrices, optional.
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Stiffening {
    /// Per spin product, (6, n, n) or planar (1, n, n); empty where absent.
    pub centrifugal: Vec<Mat<f64>>,
    /// Per unit interface force, (n_b, n, n); empty where absent.
    pub interface: Vec<Mat<f64>>,
}

/// Further columns X of the reduced basis, optional.
#[derive(Clone, Debug, PartialEq)]
pub struct Enrichment {
    /// Source of each column, (n_x); empty where the file doesn't say.
    pub names: Vec<String>,
    /// (n_b, n_x).
    pub interface_shapes: Mat<f64>,
    /// Reduced mass over the whole basis, (n, n).
    pub reduced_mass: Mat<f64>,
    /// Reduced stiffness over the whole basis, (n, n).
    pub reduced_stiffness: Mat<f64>,
}

/// Power moments of the motions beyond the modes: an error estimate follows from them over any band, optional.
///
/// M_1 = Σ c cᵀ / μ, M_2 = Σ c cᵀ / μ², M_3 = Σ c cᵀ / (μ² (μ + σ)), M_4 = Σ c cᵀ / (μ² (μ + σ)²) over the omitted modes, c their rows, μ
/// their ω² and σ the shift. The rows L are those of the boundary, output interfaces included, and then the work of each further column's load.
#[derive(Clone, Debug, PartialEq)]
pub struct Moments {
    /// No omitted ω² is below this, 1/time²; infinite if nothing was omitted.
    pub eigenvalue_bound: f64,
    /// Relative bounds of what ω² of the kept modes may be off, (n_k).
    pub eigenvalue_errors: Vec<f64>,
    /// M-orthonormal rigid motions at the boundary rows, (n_b, 3 or 6); no column for a component that is held.
    pub rigid_shapes: Mat<f64>,
    /// σ, 1/time².
    pub shift: f64,
    /// M_1, the flexibility, (n_b + n_x, n_b + n_x), symmetric.
    pub first: Mat<f64>,
    /// M_2, the mass of the static shapes, likewise.
    pub second: Mat<f64>,
    /// M_3, likewise.
    pub third: Mat<f64>,
    /// M_4, likewise.
    pub fourth: Mat<f64>,
    /// Relative rounding in the moments of each row, (n_b + n_x).
    pub rounding: Vec<f64>,
    /// The forces that the superelement is made for; `None` where that is any on rows of attachments (since 1.3).
    pub loaded: Option<LoadedForces>,
}

/// Forces that a superelement is made for where that isn't any, or where they leave out modes that others would move.
#[derive(Clone, Debug, PartialEq)]
pub struct LoadedForces {
    /// One column each, zero at output interfaces, (n_b, n_p).
    pub forces: Mat<f64>,
    /// No omitted ω² of a mode that they move is below this, 1/time²: not below that of all modes.
    pub eigenvalue_bound: f64,
}

/// A load on the inside of the component, as its work on the component's motions; it keeps its direction in the body frame.
#[derive(Clone, Debug, PartialEq)]
pub struct PartLoad {
    /// Unique name.
    pub name: String,
    /// Resultant force, body frame (planar: z = 0).
    pub force: [f64; 3],
    /// Resultant moment about the centre of mass, body frame (planar: only z).
    pub moment: [f64; 3],
    /// Ψᵀ f, (n): work on each column of the basis.
    pub work: Vec<f64>,
}

/// Provenance: the work done, its input and its results, for people. Programs go by [`Derivation`].
#[derive(Clone, Debug, PartialEq, Default)]
pub struct Provenance {
    /// Program and version that wrote the superelement.
    pub generator: String,
    /// Input files.
    pub inputs: Vec<Source>,
    /// Options of the reduction, JSON.
    pub options: serde_json::Value,
    /// Quality report, JSON.
    pub quality: serde_json::Value,
    /// Warnings, most important first.
    pub warnings: Vec<String>,
}

/// Everything the dynamics needs of a reduced component: small, whatever the size of its mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Superelement {
    /// Name.
    pub name: String,
    /// Planar or spatial.
    pub dimension: Dimension,
    /// Unit system.
    pub units: Units,
    /// Centre of mass in component coordinates; the body frame is parallel to the component's axes.
    pub origin: [f64; 3],
    /// How the frame follows the body.
    pub frame_kind: FrameKind,
    /// Interfaces in row order.
    pub interfaces: Vec<InterfaceFrame>,
    /// Rows of the boundary localization, n_b of them.
    pub rows: Vec<BoundaryRow>,
    /// Kept modes.
    pub modes: Modes,
    /// Residual flexibility.
    pub residual: Residual,
    /// Inertia invariants.
    pub inertia: Inertia,
    /// Geometric stiffening, if the file has it.
    pub stiffening: Stiffening,
    /// Further basis columns, if the file has them.
    pub enrichment: Option<Enrichment>,
    /// Power moments of the motions beyond the modes, if the file has them (since 1.2).
    pub moments: Option<Moments>,
    /// Loads on the inside of the component, by name.
    pub loads: Vec<PartLoad>,
    /// Stress and strain inside, by name.
    pub stresses: Vec<StressField>,
    /// How it was made; `None` if its maker doesn't say. Files before 1.4 say so in the provenance.
    pub derivation: Option<Derivation>,
    /// Where it came from.
    pub provenance: Provenance,
}

impl Superelement {
    /// n_b, the number of boundary rows.
    pub fn boundary_row_count(&self) -> usize {
        self.rows.len()
    }

    /// n_k, the number of kept modes.
    pub fn mode_count(&self) -> usize {
        self.modes.eigenvalues.len()
    }

    /// Where L3 and I2 come from.
    pub fn coupling_source(&self) -> CouplingSource {
        let derivation = self.derivation.as_ref();
        derivation.map_or(CouplingSource::Unknown, |of| of.coupling_source)
    }

    /// All selections that it went through, the first one first.
    pub fn selections(&self) -> &[SelectionRecord] {
        let derivation = self.derivation.as_ref();
        derivation.map_or(&[], |of| of.selections.as_slice())
    }

    /// An entry of Ψᵀ M Ψ: of its own over all columns, or of modes and attachments, which are orthogonal.
    pub fn reduced_mass(&self, k: usize, l: usize) -> f64 {
        let n_k = self.mode_count();
        match &self.enrichment {
            Some(enrichment) => enrichment.reduced_mass[(k, l)],
            None if k < n_k || l < n_k => f64::from(u8::from(k == l)),
            None => self.residual.mass[(k - n_k, l - n_k)],
        }
    }

    /// Name of a row of the boundary localization.
    pub fn row_name(&self, row: usize) -> String {
        let BoundaryRow {
            interface,
            direction,
            node,
            ..
        } = self.rows[row];
        let first = self.rows.partition_point(|row| row.interface < interface);
        let direction = usize::try_from(direction).ok();
        row_name(
            &self.interfaces[interface].name,
            direction.and_then(Direction::from_index),
            u32::try_from(node).ok(),
            row - first,
        )
    }

    /// n = n_k + n_b + n_x, the number of columns of the stored basis.
    pub fn basis_count(&self) -> usize {
        let enrichment = self
            .enrichment
            .as_ref()
            .map_or(0, |e| e.interface_shapes.ncols());
        self.mode_count() + self.boundary_row_count() + enrichment
    }
}

/// Name of a row of an interface, the `place`th of its rows: by direction and node, where it has them.
pub fn row_name(
    interface: &str,
    direction: Option<Direction>,
    node: Option<u32>,
    place: usize,
) -> String {
    match (direction, node) {
        (Some(direction), Some(node)) => format!("{interface}/{} at node {node}", direction.name()),
        (Some(direction), None) => format!("{interface}/{}", direction.name()),
        (None, _) => format!("{interface}/row {}", place + 1),
    }
}

/// Nodal fields of the reduced basis: large, opened only when a displacement inside the body is wanted.
#[derive(Clone, Debug, PartialEq)]
pub struct RecoveryBasis {
    /// The dof of each field row, n_f of them.
    pub dofs: Vec<Dof>,
    /// Φ, (n_f, n_k).
    pub modes: Mat<f64>,
    /// G_res L_bᵀ, (n_f, n_b).
    pub residual: Mat<f64>,
    /// X, (n_f, n_x); `None` where the basis has no further columns, or the file (of format 1.0) not their fields.
    pub enrichment: Option<Mat<f64>>,
}
