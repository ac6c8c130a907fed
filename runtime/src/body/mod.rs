//! One flexible body: a superelement in dynamic coordinates.
//!
//! The file stores Φ and G_res L_bᵀ with one column for every interface row, dependent or not. The dynamics keeps the modes
//! and the orthonormalised attachments that the file's transform T_r names:
//!
//! ```text
//! y     = (η, ζ)                                     n = n_k + rank
//! Ψ_r   = [Φ, G_res L_bᵀ T_r]                        Ψ_rᵀ M Ψ_r = I,  Ψ_rᵀ K Ψ_r = diag(ω², σ²)
//! u_Γ   = L_b Ψ_r y = [L_b Φ, F_res T_r] y           (n_b); rows of output interfaces are observed as well
//! ```
//!
//! so that T and V are positive whatever the body is joined to (Rubin's form of the dual Craig–Bampton basis). The
//! constant description is here; its evaluation at a motion is [`crate::frame`]. Nothing of size n_e is read.
//! [`Compatibility`] names the other choices of coordinates. Bodies also come from reduced matrices in memory
//! ([`GeneralizedBody`]) and without any coordinates ([`RigidBody`]).

mod attachment;
mod generalized;
mod rigid;
mod stress;
mod superelement;

use std::path::Path;

use dcb_formats::component::{Role, Units};
use dcb_formats::scene::InertiaChange;
use dcb_formats::superelement::{BoundaryRow, InterfaceFrame};
use faer::Mat;
use nalgebra::{Matrix3, Vector3};

use crate::error::Error;
use crate::frame::FrameInertia;
pub use attachment::Attachment;
pub use dcb_formats::scene::Compatibility;
use dcb_superelement::MadeFor;
pub use generalized::GeneralizedBody;
pub use rigid::{RigidBody, RigidPoint};
pub use stress::BodyStress;

/// Largest cosine between a rigid motion and a column of Ψ_r that still counts as rounding. The reducer holds the file's
/// columns to 1e-8 of their size with no mode kept, and T_r magnifies weak attachments.
pub const MEAN_AXIS_LIMIT: f64 = 1e-6;

/// Directions of the residual flexibility that have mass: F_res T_r and σ² of the file.
#[derive(Clone, Debug, PartialEq)]
pub struct GrowingDirections {
    /// F_res T_r, (n_b, rank): displacements of the interfaces.
    pub shapes: Mat<f64>,
    /// σ², ascending, (rank), 1/time².
    pub sigma_squared: Vec<f64>,
}

/// A load on the inside of a body, which keeps its direction in the body frame.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyLoad {
    /// Name.
    pub name: String,
    /// Resultant force, body axes.
    pub force: Vector3<f64>,
    /// Resultant moment about the frame's origin, body axes.
    pub moment: Vector3<f64>,
    /// Force on each coordinate, (n).
    pub elastic: Vec<f64>,
}

/// A flexible body, ready for the dynamics. Never changes during a simulation.
#[derive(Clone, Debug, PartialEq)]
pub struct FlexibleBody {
    /// Name.
    pub name: String,
    /// Unit system.
    pub units: Units,
    /// Centre of mass in component coordinates; the body frame is parallel to the component's axes.
    pub origin: [f64; 3],
    /// Interfaces in row order, body frame.
    pub interfaces: Vec<InterfaceFrame>,
    /// Rows of u_Γ, n_b of them.
    pub rows: Vec<BoundaryRow>,
    /// How the displacement of the interfaces enters; decides what the coordinates are.
    pub compatibility: Compatibility,
    /// Number of modes among the coordinates; the attachments follow them.
    pub mode_count: usize,
    /// diag(ω², σ²), (n), 1/time²; zero for interface forces as coordinates, whose flexibility is `residual_flexibility`.
    pub stiffness: Vec<f64>,
    /// Ratio to critical of each coordinate, (n).
    pub damping: Vec<f64>,
    /// The lowest ω² that the modes leave out; infinite if nothing is.
    pub first_omitted_eigenvalue: f64,
    /// Purpose of the superelement.
    pub made_for: MadeFor,
    /// L_b Ψ_r, (n_b, n), 1/√mass (rotation rows: 1/(√mass·length)).
    pub interface_shapes: Mat<f64>,
    /// T, (n_b, rank): a nodal field is u = Φ η + G_res L_bᵀ T ζ. T is T_r where compatibility is strong, without columns where
    /// it is static, and the identity where it is weak.
    pub attachment_transform: Mat<f64>,
    /// T_x, (n_x, rank), for further columns X of the basis: u = Φ η + (G_res L_bᵀ T + X T_x) ζ.
    pub further_transform: Mat<f64>,
    /// Deflection of interface forces g beyond the coordinates, u_Γ += F g, (n_b, n_b). Static: F_res. Strong: the directions of F_res
    /// without mass, `None` if there are none. Weak: F_res, already in `interface_shapes` and, as strain energy
    /// ½ gᵀ F_res g, not in `stiffness`. Rows of output interfaces are observed.
    pub residual_flexibility: Option<Mat<f64>>,
    /// M_res, (n_b, n_b), where interface forces are coordinates (weak).
    pub residual_mass: Option<Mat<f64>>,
    /// The directions in which interface forces grow where they are coordinates (weak); `None` otherwise.
    pub growing: Option<GrowingDirections>,
    /// Geometric stiffness per unit force on each interface row, (n_b) of (n, n), or none: the row moves by −½ yᵀ K y besides, by which
    /// its force does work.
    pub interface_stiffening: Vec<Mat<f64>>,
    /// Loads on the inside that a scene may apply.
    pub loads: Vec<BodyLoad>,
    /// Stress and strain fields that a scene may look at.
    pub stresses: Vec<BodyStress>,
    /// Inertia about the centre of mass and its dependence on y.
    pub inertia: FrameInertia,
    /// (N, n): the coordinates that the body was given in are this matrix times y.
    to_original: Mat<f64>,
    /// Frames of the interfaces; `None` where the rows don't describe one.
    attachments: Vec<Option<Attachment>>,
}

impl FlexibleBody {
    /// Reads the body of a `.dcb.h5` file, of [`Compatibility::Strong`]; its nodal fields stay unread.
    ///
    /// # Errors
    /// [`Error::File`] if the file can't be used, or those of [`FlexibleBody::from_superelement`].
    pub fn load(path: &Path) -> Result<Self, Error> {
        let superelement = dcb_formats::dcb::SuperelementFile::open(path)?.for_dynamics()?;
        Self::from_superelement(&superelement, Compatibility::Strong)
    }

    /// The same body with the change of its inertia followed no further than `change`.
    pub fn with_inertia_change(mut self, change: InertiaChange) -> Self {
        self.inertia = self.inertia.with_change(change);
        self
    }

    /// Whether it is a mass at one point: it has no rotation, and nothing takes hold of it elsewhere.
    pub fn is_point_mass(&self) -> bool {
        let mut interfaces = self.interfaces.iter();
        self.stiffness.is_empty()
            && *self.inertia.rotation().tensor() == Matrix3::zeros()
            && interfaces.all(|interface| interface.position == [0.0; 3])
    }

    /// n, the number of dynamic coordinates: modes, then attachments.
    pub fn coordinate_count(&self) -> usize {
        self.stiffness.len()
    }

    /// How many of the coordinates are displacements; the others, after them, are interface forces.
    pub fn displacement_count(&self) -> usize {
        match self.compatibility {
            Compatibility::Strong | Compatibility::Static => self.coordinate_count(),
            Compatibility::Weak => self.mode_count,
        }
    }

    /// The frame of interface `index`.
    ///
    /// # Errors
    /// [`Error::NoFrame`] if the interface has several nodes or explicit rows.
    pub fn attachment(&self, index: usize) -> Result<&Attachment, Error> {
        self.attachments[index].as_ref().ok_or_else(|| {
            let interface = &self.interfaces[index];
            Error::NoFrame {
                body: self.name.clone(),
                interface: interface.name.clone(),
                kind: interface.kind.name(),
            }
        })
    }

    /// How many coordinates the body was given in: columns of the stored basis, or reduced coordinates.
    pub fn original_coordinate_count(&self) -> usize {
        self.to_original.nrows()
    }

    /// The coordinates that the body was given in: amplitudes of the stored basis [Φ, G_res L_bᵀ], or the reduced coordinates
    /// of a [`GeneralizedBody`]. `original` has [`FlexibleBody::original_coordinate_count`] entries.
    pub fn original_coordinates(&self, y: &[f64], original: &mut [f64]) {
        original.fill(0.0);
        for (column, y) in self.to_original.col_iter().zip(y) {
            for (original, entry) in original.iter_mut().zip(column.iter()) {
                *original += y * entry;
            }
        }
    }

    /// `diag(ω², σ²) y + diag(2 ζ ω) y'`: internal forces, elastic and damping, on the side of the inertia. Nothing for
    /// interface forces as coordinates.
    pub fn internal_forces(&self, y: &[f64], rates: &[f64], forces: &mut [f64]) {
        for (i, force) in forces.iter_mut().enumerate() {
            *force = self.stiffness[i] * y[i] + self.damping_coefficient(i) * rates[i];
        }
    }

    /// `2 ζ ω` of a coordinate, zero for interface forces: the damping force over the rate, coordinates having unit mass.
    pub fn damping_coefficient(&self, coordinate: usize) -> f64 {
        2.0 * self.damping[coordinate] * self.stiffness[coordinate].sqrt()
    }

    /// `½ yᵀ diag(ω², σ²) y`, and `½ gᵀ F_res g` where interface forces are coordinates.
    pub fn strain_energy(&self, y: &[f64]) -> f64 {
        let diagonal = y
            .iter()
            .zip(&self.stiffness)
            .map(|(y, stiffness)| stiffness * y * y)
            .sum::<f64>();
        let of_forces = match (self.compatibility, &self.residual_flexibility) {
            (Compatibility::Weak, Some(flexibility)) => {
                let forces = &y[self.mode_count..];
                let columns = flexibility.col_iter().zip(forces);
                columns
                    .map(|(column, g)| {
                        g * column.iter().zip(forces).map(|(f, g)| f * g).sum::<f64>()
                    })
                    .sum()
            }
            _ => 0.0,
        };
        0.5 * (diagonal + of_forces)
    }

    /// `½ gᵀ F g`: strain energy of what the interface forces g, (n_b), do beyond the coordinates. Zero where they are
    /// coordinates themselves. Forces on output interfaces do no work on it: their flexibility is not in the file.
    pub fn residual_energy(&self, forces: &[f64]) -> f64 {
        let Some(flexibility) = &self.residual_flexibility else {
            return 0.0;
        };
        if self.compatibility == Compatibility::Weak {
            return 0.0;
        }
        let attached = |row: usize| {
            let interface = self.rows[row].interface;
            self.interfaces[interface].role == Role::Attachment
        };
        let columns = flexibility.col_iter().zip(forces);
        let twice: f64 = columns
            .map(|(column, force)| {
                let seen = column.iter().zip(forces).enumerate();
                let seen = seen.filter(|(row, _)| attached(*row));
                force * seen.map(|(_, (f, g))| f * g).sum::<f64>()
            })
            .sum();
        0.5 * twice
    }

    fn with_attachments(mut self) -> Self {
        let interfaces = self.interfaces.iter().enumerate();
        self.attachments = interfaces
            .map(|(index, interface)| {
                let shapes = self.interface_shapes.as_ref();
                let stiffening = &self.interface_stiffening;
                Attachment::of_interface(index, interface, &self.rows, shapes, stiffening)
            })
            .collect();
        self
    }
}
