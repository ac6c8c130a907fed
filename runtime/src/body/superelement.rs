//! The body of a superelement, in the coordinates that the compatibility of its interfaces asks for.

use dcb_formats::superelement::{FrameKind, Inertia, Residual, Superelement};
use faer::{Mat, MatRef};

use super::{Compatibility, FlexibleBody, GrowingDirections, MEAN_AXIS_LIMIT};
use crate::error::Error;
use crate::frame::{AttachmentMass, FrameInertia, FrameMomentum};

impl FlexibleBody {
    /// The body of a superelement. All of the change of its inertia is followed;
    /// [`FlexibleBody::with_inertia_change`] restricts that.
    ///
    /// # Errors
    /// [`Error::NotHandled`] for enrichment columns and stiffening matrices; [`Error::NotMeanAxis`] if the frame is
    /// called mean-axis and the basis has momentum beyond [`MEAN_AXIS_LIMIT`].
    pub fn from_superelement(
        superelement: &Superelement,
        compatibility: Compatibility,
    ) -> Result<Self, Error> {
        refuse_unhandled(superelement)?;
        let (modes, residual) = (&superelement.modes, &superelement.residual);
        let (n_k, n_b) = (modes.eigenvalues.len(), superelement.rows.len());
        if superelement.frame_kind == FrameKind::MeanAxis {
            let columns = basis_columns(n_k, &residual.transform);
            check_mean_axes(&superelement.name, &superelement.inertia, &columns)?;
        }
        // T: a nodal field is Φ η + G_res L_bᵀ T ζ.
        let (transform, stiffness) = match compatibility {
            Compatibility::Strong => (residual.transform.clone(), residual.sigma_squared.clone()),
            Compatibility::Static => (Mat::zeros(n_b, 0), Vec::new()),
            Compatibility::Weak => (Mat::identity(n_b, n_b), vec![0.0; n_b]),
        };
        let rank = transform.ncols();
        let attached_damping = match compatibility {
            Compatibility::Strong => modes.residual_damping,
            Compatibility::Static | Compatibility::Weak => 0.0,
        };
        let attachments = residual
            .output_shapes
            .as_ref()
            .unwrap_or(&residual.flexibility);
        let mut interface_shapes = Mat::zeros(n_b, n_k + rank);
        interface_shapes
            .as_mut()
            .subcols_mut(0, n_k)
            .copy_from(&modes.interface_shapes);
        interface_shapes
            .as_mut()
            .subcols_mut(n_k, rank)
            .copy_from(attachments * &transform);

        let columns = basis_columns(n_k, &transform);
        let momentum = match superelement.frame_kind {
            FrameKind::MeanAxis => None,
            FrameKind::Given => FrameMomentum::over(&superelement.inertia, columns.as_ref()),
        };
        let mut inertia = FrameInertia::over(
            &superelement.inertia,
            superelement.dimension,
            columns.as_ref(),
        )
        .with_momentum(momentum);
        if compatibility == Compatibility::Weak {
            inertia = inertia.with_attachment_mass(AttachmentMass::of(&residual.mass));
        }
        let chained =
            |modal: &[f64], attached: &[f64]| modal.iter().chain(attached).copied().collect();
        Ok(Self {
            name: superelement.name.clone(),
            units: superelement.units.clone(),
            origin: superelement.origin,
            compatibility,
            mode_count: n_k,
            stiffness: chained(&modes.eigenvalues, &stiffness),
            damping: chained(&modes.damping, &vec![attached_damping; rank]),
            first_omitted_eigenvalue: modes.first_omitted_eigenvalue,
            attachment_transform: transform,
            residual_flexibility: match compatibility {
                Compatibility::Strong => massless_flexibility(superelement),
                Compatibility::Static | Compatibility::Weak => Some(attachments.clone()),
            },
            residual_mass: match compatibility {
                Compatibility::Weak => Some(residual.mass.clone()),
                Compatibility::Strong | Compatibility::Static => None,
            },
            growing: match compatibility {
                Compatibility::Weak => Some(GrowingDirections {
                    shapes: &residual.flexibility * &residual.transform,
                    sigma_squared: residual.sigma_squared.clone(),
                }),
                Compatibility::Strong | Compatibility::Static => None,
            },
            to_original: columns,
            inertia,
            attachments: Vec::new(),
            interfaces: superelement.interfaces.clone(),
            rows: superelement.rows.clone(),
            interface_shapes,
        }
        .with_attachments())
    }
}

/// What F_res has beyond T_r: it acts statically. `None` where that is rounding, measured by the whole flexibility of each
/// row with no mode kept and the tolerance that T_r was made with.
///
/// ```text
/// F_res - F_res T_r diag(σ²)⁻¹ T_rᵀ F_res
/// ```
fn massless_flexibility(superelement: &Superelement) -> Option<Mat<f64>> {
    let (modes, residual) = (&superelement.modes, &superelement.residual);
    let Residual {
        flexibility,
        transform,
        sigma_squared,
        ..
    } = residual;
    let carried = flexibility * transform;
    let scaled = Mat::from_fn(carried.nrows(), carried.ncols(), |i, j| {
        carried[(i, j)] / sigma_squared[j]
    });
    let rest = flexibility - &scaled * carried.transpose();
    let modal = |row: usize| -> f64 {
        let shapes = modes.eigenvalues.iter().enumerate();
        shapes
            .map(|(k, eigenvalue)| modes.interface_shapes[(row, k)].powi(2) / eigenvalue)
            .sum()
    };
    let beyond_rounding = (0..rest.nrows())
        .any(|row| rest[(row, row)] > residual.tolerance * (flexibility[(row, row)] + modal(row)));
    beyond_rounding.then_some(rest)
}

fn refuse_unhandled(superelement: &Superelement) -> Result<(), Error> {
    let refused = |what, remedy| {
        Err(Error::NotHandled {
            body: superelement.name.clone(),
            what,
            remedy,
        })
    };
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

/// `blkdiag(I, T)`, (n_k + n_b, n_k + rank): the file's basis columns to those of the dynamics.
fn basis_columns(n_k: usize, transform: &Mat<f64>) -> Mat<f64> {
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
