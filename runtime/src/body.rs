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

use std::path::Path;

use dcb_formats::component::Units;
use dcb_formats::mesh::Dimension;
use dcb_formats::superelement::{BoundaryRow, FrameKind, Inertia, InterfaceFrame, Superelement};
use faer::{Mat, MatRef};
use nalgebra::Matrix3;

use crate::error::Error;
use crate::frame::spatial::PAIRS;
use crate::frame::{FrameInertia, PlanarInertia, SpatialInertia};

/// Largest cosine between a rigid motion and a column of Ψ_r that still counts as rounding. The reducer holds the file's
/// columns to 1e-8 of their size with no mode kept, and T_r magnifies weak attachments.
pub const MEAN_AXIS_LIMIT: f64 = 1e-6;

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
    /// Number of modes among the coordinates; the attachments follow them.
    pub mode_count: usize,
    /// diag(ω², σ²), (n), 1/time².
    pub stiffness: Vec<f64>,
    /// Ratio to critical of each coordinate, (n).
    pub damping: Vec<f64>,
    /// The lowest ω² that the modes leave out; infinite if nothing is.
    pub first_omitted_eigenvalue: f64,
    /// L_b Ψ_r, (n_b, n), 1/√mass (rotation rows: 1/(√mass·length)).
    pub interface_shapes: Mat<f64>,
    /// T_r, (n_b, rank): a nodal field is u = Φ η + G_res L_bᵀ T_r ζ.
    pub attachment_transform: Mat<f64>,
    /// Inertia about the centre of mass and its dependence on y.
    pub inertia: FrameInertia,
}

impl FlexibleBody {
    /// Reads the body of a `.dcb.h5` file; its nodal fields stay unread.
    ///
    /// # Errors
    /// [`Error::File`] if the file can't be used, or those of [`FlexibleBody::from_superelement`].
    pub fn load(path: &Path) -> Result<Self, Error> {
        Self::from_superelement(&dcb_formats::dcb::read_superelement(path)?)
    }

    /// The body of a superelement.
    ///
    /// # Errors
    /// [`Error::NotHandled`] for a frame of kind `given`, enrichment columns and stiffening matrices;
    /// [`Error::NotMeanAxis`] if the basis has momentum beyond [`MEAN_AXIS_LIMIT`].
    pub fn from_superelement(superelement: &Superelement) -> Result<Self, Error> {
        refuse_unhandled(superelement)?;
        let (modes, residual) = (&superelement.modes, &superelement.residual);
        let (n_k, rank) = (modes.eigenvalues.len(), residual.sigma_squared.len());
        let to_dynamic = dynamic_columns(n_k, &residual.transform);
        check_mean_axes(&superelement.name, &superelement.inertia, &to_dynamic)?;

        let attachments = residual
            .output_shapes
            .as_ref()
            .unwrap_or(&residual.flexibility);
        let mut interface_shapes = Mat::zeros(superelement.rows.len(), n_k + rank);
        interface_shapes
            .as_mut()
            .subcols_mut(0, n_k)
            .copy_from(&modes.interface_shapes);
        interface_shapes
            .as_mut()
            .subcols_mut(n_k, rank)
            .copy_from(attachments * &residual.transform);

        let chained =
            |modal: &[f64], attached: &[f64]| modal.iter().chain(attached).copied().collect();
        Ok(Self {
            name: superelement.name.clone(),
            units: superelement.units.clone(),
            origin: superelement.origin,
            interfaces: superelement.interfaces.clone(),
            rows: superelement.rows.clone(),
            mode_count: n_k,
            stiffness: chained(&modes.eigenvalues, &residual.sigma_squared),
            damping: chained(&modes.damping, &vec![modes.residual_damping; rank]),
            first_omitted_eigenvalue: modes.first_omitted_eigenvalue,
            interface_shapes,
            attachment_transform: residual.transform.clone(),
            inertia: over_dynamic_coordinates(
                &superelement.inertia,
                superelement.dimension,
                &to_dynamic,
            ),
        })
    }

    /// n, the number of dynamic coordinates: modes, then attachments.
    pub fn coordinate_count(&self) -> usize {
        self.stiffness.len()
    }

    /// `diag(ω², σ²) y + diag(2 ζ ω) y'`: internal forces, elastic and damping, on the side of the inertia.
    pub fn internal_forces(&self, y: &[f64], rates: &[f64], forces: &mut [f64]) {
        for (i, force) in forces.iter_mut().enumerate() {
            let stiffness = self.stiffness[i];
            *force = stiffness * y[i] + 2.0 * self.damping[i] * stiffness.sqrt() * rates[i];
        }
    }

    /// `½ yᵀ diag(ω², σ²) y`
    pub fn strain_energy(&self, y: &[f64]) -> f64 {
        0.5 * y
            .iter()
            .zip(&self.stiffness)
            .map(|(y, stiffness)| stiffness * y * y)
            .sum::<f64>()
    }
}

fn refuse_unhandled(superelement: &Superelement) -> Result<(), Error> {
    let refused = |what, remedy| {
        Err(Error::NotHandled {
            body: superelement.name.clone(),
            what,
            remedy,
        })
    };
    if superelement.frame_kind == FrameKind::Given {
        return refused(
            "its frame is of kind `given`, not on mean axes",
            "reduce the free component (without supports) and hold it by joints",
        );
    }
    if superelement.enrichment.is_some() {
        return refused("it has enrichment columns", "reduce it without enrichment");
    }
    if !superelement.stiffening.centrifugal.is_empty()
        || !superelement.stiffening.interface.is_empty()
    {
        return refused(
            "it has geometric stiffening matrices",
            "reduce it without them",
        );
    }
    Ok(())
}

/// `blkdiag(I, T_r)`, (n_k + n_b, n_k + rank): the file's basis columns to the dynamic ones.
fn dynamic_columns(n_k: usize, transform: &Mat<f64>) -> Mat<f64> {
    Mat::from_fn(
        n_k + transform.nrows(),
        n_k + transform.ncols(),
        |i, j| match (i < n_k, j < n_k) {
            (true, true) => f64::from(u8::from(i == j)),
            (false, false) => transform[(i - n_k, j - n_k)],
            _ => 0.0,
        },
    )
}

/// The columns of Ψ_r have unit M norm, so L1 Ψ_r / √m and I3 Ψ_r / √I are cosines.
fn check_mean_axes(name: &str, inertia: &Inertia, to_dynamic: &Mat<f64>) -> Result<(), Error> {
    let largest_moment = (0..3).map(|a| inertia.tensor[a][a]).fold(0.0, f64::max);
    for (quantity, rows, size) in [
        ("L1", &inertia.l1, inertia.mass),
        ("I3", &inertia.i3, largest_moment),
    ] {
        let found = largest_entry((rows * to_dynamic).as_ref()) / size.sqrt();
        if found.is_nan() || found > MEAN_AXIS_LIMIT {
            return Err(Error::NotMeanAxis {
                body: name.to_owned(),
                quantity,
                found,
                limit: MEAN_AXIS_LIMIT,
            });
        }
    }
    Ok(())
}

fn largest_entry(matrix: MatRef<'_, f64>) -> f64 {
    matrix
        .col_iter()
        .flat_map(|column| column.iter())
        .fold(0.0, |most, entry| f64::max(most, entry.abs()))
}

/// The invariants `Bᵀ · B` with B = `to_dynamic`.
fn over_dynamic_coordinates(
    inertia: &Inertia,
    dimension: Dimension,
    to_dynamic: &Mat<f64>,
) -> FrameInertia {
    let congruent = |matrix: &Mat<f64>| to_dynamic.transpose() * matrix * to_dynamic;
    let symmetric = |matrix: &Mat<f64>| {
        let full = congruent(matrix);
        Mat::from_fn(full.nrows(), full.ncols(), |i, j| {
            0.5 * (full[(i, j)] + full[(j, i)])
        })
    };
    let antisymmetric = |matrix: &Mat<f64>| {
        let full = congruent(matrix);
        Mat::from_fn(full.nrows(), full.ncols(), |i, j| {
            0.5 * (full[(i, j)] - full[(j, i)])
        })
    };
    let first_order = |pairs: &[(usize, usize)]| {
        let stored = Mat::from_fn(inertia.i1.len(), pairs.len(), |k, pair| {
            let (a, b) = pairs[pair];
            inertia.i1[k][a][b]
        });
        to_dynamic.transpose() * stored
    };
    match dimension {
        Dimension::Planar => FrameInertia::Planar(PlanarInertia {
            mass: inertia.mass,
            moment: inertia.tensor[2][2],
            first_order: first_order(&[(2, 2)]).col_as_slice(0).to_vec(),
            coupling: antisymmetric(&inertia.l3[0]),
        }),
        Dimension::Spatial => FrameInertia::Spatial(Box::new(SpatialInertia {
            mass: inertia.mass,
            tensor: Matrix3::from_fn(|a, b| inertia.tensor[a][b]),
            first_order: first_order(&PAIRS),
            second_order: std::array::from_fn(|pair| symmetric(&inertia.i2[pair])),
            coupling: std::array::from_fn(|axis| antisymmetric(&inertia.l3[axis])),
        })),
    }
}
