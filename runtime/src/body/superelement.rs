//! The body of a superelement, in the coordinates that the compatibility of its interfaces asks for.

use dcb_formats::component::Role;
use dcb_formats::superelement::{FrameKind, Inertia, PartLoad, Superelement};
use dcb_superelement::ResidualCoordinates;
use faer::{ColRef, Mat, MatRef};
use nalgebra::Vector3;

use super::{BodyLoad, Compatibility, FlexibleBody, GrowingDirections, MEAN_AXIS_LIMIT, MadeFor};
use crate::error::Error;
use crate::frame::{AttachmentMass, FrameInertia, FrameMomentum};

impl FlexibleBody {
    /// The body of a superelement, with its geometric stiffening. All of the change of its inertia is followed;
    /// [`FlexibleBody::with_inertia_change`] restricts that. Further columns of the basis are coordinates under strong compatibility
    /// only; the others, which count their flexibility among F_res, leave them out.
    ///
    /// # Errors
    /// [`Error::NotMeanAxis`] if the frame is called mean-axis and the basis has momentum beyond [`MEAN_AXIS_LIMIT`];
    /// [`Error::NotHandled`] for geometric stiffening with weak compatibility, or further columns that aren't orthogonal to the
    /// modes; [`Error::NotPositive`] if the reduced matrices with further columns aren't those of a body.
    pub fn from_superelement(
        superelement: &Superelement,
        compatibility: Compatibility,
    ) -> Result<Self, Error> {
        let (modes, residual) = (&superelement.modes, &superelement.residual);
        let (n_k, n_b) = (modes.eigenvalues.len(), superelement.rows.len());
        let n_x = superelement.basis_count() - n_k - n_b;
        let massive = ResidualCoordinates::of(superelement)
            .map_err(|why| Error::without_coordinates(&superelement.name, why))?;
        if superelement.frame_kind == FrameKind::MeanAxis {
            let columns = basis_columns(n_k, &massive.attached, &massive.further);
            check_mean_axes(&superelement.name, &superelement.inertia, &columns)?;
        }
        let static_part = match compatibility {
            Compatibility::Strong => massless_flexibility(superelement, &massive),
            Compatibility::Static | Compatibility::Weak => None,
        };
        // T and T_x: a nodal field is Φ η + (G_res L_bᵀ T + X T_x) ζ.
        let ResidualCoordinates {
            attached: transform,
            further: further_transform,
            stiffness,
        } = match compatibility {
            Compatibility::Strong => massive,
            Compatibility::Static => ResidualCoordinates {
                attached: Mat::zeros(n_b, 0),
                further: Mat::zeros(n_x, 0),
                stiffness: Vec::new(),
            },
            Compatibility::Weak => ResidualCoordinates {
                attached: Mat::identity(n_b, n_b),
                further: Mat::zeros(n_x, n_b),
                stiffness: vec![0.0; n_b],
            },
        };
        let rank = transform.ncols();
        let attached_damping = match compatibility {
            Compatibility::Strong => modes.residual_damping,
            Compatibility::Static | Compatibility::Weak => 0.0,
        };
        let mut interface_shapes = Mat::zeros(n_b, n_k + rank);
        interface_shapes
            .as_mut()
            .subcols_mut(0, n_k)
            .copy_from(&modes.interface_shapes);
        interface_shapes
            .as_mut()
            .subcols_mut(n_k, rank)
            .copy_from(seen(superelement, &transform, &further_transform));

        let columns = basis_columns(n_k, &transform, &further_transform);
        let momentum = match superelement.frame_kind {
            FrameKind::MeanAxis => None,
            FrameKind::Given => FrameMomentum::over(&superelement.inertia, columns.as_ref()),
        };
        let stiffening = &superelement.stiffening;
        let mut inertia = FrameInertia::over(
            &superelement.inertia,
            superelement.dimension,
            columns.as_ref(),
        )
        .with_momentum(momentum);
        if compatibility == Compatibility::Weak {
            refuse_stiffening(superelement)?;
            inertia = inertia.with_attachment_mass(AttachmentMass::of(&residual.mass));
        } else {
            inertia = inertia.with_stiffening(&stiffening.centrifugal, columns.as_ref());
        }
        let interface_stiffening = stiffening
            .interface
            .iter()
            .map(|of_row| columns.transpose() * of_row * &columns)
            .collect();
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
            made_for: MadeFor::of(superelement),
            attachment_transform: transform,
            further_transform,
            residual_flexibility: match compatibility {
                Compatibility::Strong => static_part,
                Compatibility::Static | Compatibility::Weak => Some(attachments(superelement)),
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
            interface_stiffening,
            loads: superelement
                .loads
                .iter()
                .map(|load| body_load(load, &columns))
                .collect(),
            to_original: columns,
            inertia,
            attachments: Vec::new(),
            interfaces: superelement.interfaces.clone(),
            rows: superelement.rows.clone(),
            interface_shapes,
        }
        .with_attachments())
    }

    /// Whether geometric stiffening acts in it.
    pub fn is_stiffened(&self) -> bool {
        !self.interface_stiffening.is_empty() || self.inertia.is_stiffened()
    }
}

fn body_load(load: &PartLoad, columns: &Mat<f64>) -> BodyLoad {
    let on_column = |column: ColRef<'_, f64>| -> f64 {
        column.iter().zip(&load.work).map(|(a, b)| a * b).sum()
    };
    BodyLoad {
        name: load.name.clone(),
        force: Vector3::from(load.force),
        moment: Vector3::from(load.moment),
        elastic: columns.col_iter().map(on_column).collect(),
    }
}

/// L_b G_res L_bᵀ, with the rows of output interfaces.
fn attachments(superelement: &Superelement) -> Mat<f64> {
    let residual = &superelement.residual;
    let shapes = residual.output_shapes.as_ref();
    shapes.unwrap_or(&residual.flexibility).clone()
}

/// L_b (G_res L_bᵀ T + X T_x), (n_b, r).
fn seen(superelement: &Superelement, transform: &Mat<f64>, further: &Mat<f64>) -> Mat<f64> {
    let of_attachments = attachments(superelement) * transform;
    match &superelement.enrichment {
        Some(enrichment) => of_attachments + &enrichment.interface_shapes * further,
        None => of_attachments,
    }
}

/// What F_res has beyond the coordinates ζ: it acts statically. `None` where that is rounding, measured by the whole flexibility of
/// each row with no mode kept and the tolerance that T_r was made with.
///
/// ```text
/// F_res - S diag(σ²)⁻¹ Sᵀ        S = L_b (G_res L_bᵀ T + X T_x)
/// ```
fn massless_flexibility(
    superelement: &Superelement,
    coordinates: &ResidualCoordinates,
) -> Option<Mat<f64>> {
    let (modes, residual) = (&superelement.modes, &superelement.residual);
    let flexibility = &residual.flexibility;
    let mut carried = coordinates.seen(superelement);
    // Output interfaces carry no force.
    for (row, of_row) in superelement.rows.iter().enumerate() {
        if superelement.interfaces[of_row.interface].role == Role::Output {
            carried.as_mut().row_mut(row).fill(0.0);
        }
    }
    let scaled = Mat::from_fn(carried.nrows(), carried.ncols(), |i, j| {
        carried[(i, j)] / coordinates.stiffness[j]
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

fn refuse_stiffening(superelement: &Superelement) -> Result<(), Error> {
    let stiffening = &superelement.stiffening;
    if stiffening.centrifugal.is_empty() && stiffening.interface.is_empty() {
        return Ok(());
    }
    Err(Error::NotHandled {
        body: superelement.name.clone(),
        what: "weak compatibility has no geometric stiffening",
        remedy: "use strong or static compatibility, or switch the stiffening off",
    })
}

/// `blkdiag(I, [T; T_x])`, (n, n_k + r): the file's basis columns to those of the dynamics.
fn basis_columns(n_k: usize, transform: &Mat<f64>, further: &Mat<f64>) -> Mat<f64> {
    let n_b = transform.nrows();
    Mat::from_fn(
        n_k + n_b + further.nrows(),
        n_k + transform.ncols(),
        |i, j| match (i < n_k, j < n_k) {
            (true, true) => f64::from(u8::from(i == j)),
            (false, false) if i < n_k + n_b => transform[(i - n_k, j - n_k)],
            (false, false) => further[(i - n_k - n_b, j - n_k)],
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
