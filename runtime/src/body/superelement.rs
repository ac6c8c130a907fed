//! The body of a superelement, in the coordinates that the compatibility of its interfaces asks for.

use dcb_formats::superelement::{FrameKind, PartLoad, Superelement};
use dcb_superelement::{DynamicCoordinates, MadeFor};
use faer::{ColRef, Mat, MatRef};
use nalgebra::Vector3;

use super::stress::BodyStress;
use super::{BodyLoad, Compatibility, FlexibleBody, GrowingDirections, MEAN_AXIS_LIMIT};
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
        let coordinates = DynamicCoordinates::of(superelement, compatibility)?;
        let columns = coordinates.to_file();
        check_frame(superelement, compatibility, &columns)?;
        let rank = coordinates.attached.ncols();
        let attached_damping = match compatibility {
            Compatibility::Strong => modes.residual_damping,
            Compatibility::Static | Compatibility::Weak => 0.0,
        };
        let inertia = frame_inertia(superelement, compatibility, &columns)?;
        let interface_stiffening = superelement
            .stiffening
            .interface
            .iter()
            .map(|of_row| columns.transpose() * of_row * &columns)
            .collect();
        let stress =
            |field| BodyStress::of(field, superelement, &coordinates, &columns, compatibility);
        let stresses = superelement.stresses.iter().map(stress).collect();
        Ok(Self {
            stresses,
            name: superelement.name.clone(),
            units: superelement.units.clone(),
            origin: superelement.origin,
            compatibility,
            mode_count: superelement.mode_count(),
            stiffness: coordinates.stiffness,
            damping: [modes.damping.as_slice(), &vec![attached_damping; rank]].concat(),
            first_omitted_eigenvalue: modes.first_omitted_eigenvalue,
            made_for: MadeFor::of(superelement),
            attachment_transform: coordinates.attached,
            further_transform: coordinates.further,
            residual_flexibility: coordinates.residual_flexibility,
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
            interface_shapes: coordinates.interface_shapes,
        }
        .with_attachments())
    }

    /// Whether geometric stiffening acts in it.
    pub fn is_stiffened(&self) -> bool {
        !self.interface_stiffening.is_empty() || self.inertia.is_stiffened()
    }
}

/// Refuses a basis with momentum in a frame that is called mean-axis. The check takes coordinates that have mass, whatever those of the
/// body are: their columns are of unit norm.
fn check_frame(
    superelement: &Superelement,
    compatibility: Compatibility,
    columns: &Mat<f64>,
) -> Result<(), Error> {
    match (superelement.frame_kind, compatibility) {
        (FrameKind::Given, _) => Ok(()),
        (FrameKind::MeanAxis, Compatibility::Strong) => check_mean_axes(superelement, columns),
        (FrameKind::MeanAxis, Compatibility::Static | Compatibility::Weak) => {
            let massive = DynamicCoordinates::of(superelement, Compatibility::Strong)?;
            check_mean_axes(superelement, &massive.to_file())
        }
    }
}

/// Inertia of the frame over the columns of the coordinates, with what the spin stiffens.
fn frame_inertia(
    superelement: &Superelement,
    compatibility: Compatibility,
    columns: &Mat<f64>,
) -> Result<FrameInertia, Error> {
    let of_file = &superelement.inertia;
    let momentum = match superelement.frame_kind {
        FrameKind::MeanAxis => None,
        FrameKind::Given => FrameMomentum::over(of_file, columns.as_ref()),
    };
    let inertia = FrameInertia::over(of_file, superelement.dimension, columns.as_ref())
        .with_momentum(momentum);
    if compatibility == Compatibility::Weak {
        refuse_stiffening(superelement)?;
        let mass = AttachmentMass::of(&superelement.residual.mass);
        Ok(inertia.with_attachment_mass(mass))
    } else {
        let centrifugal = &superelement.stiffening.centrifugal;
        Ok(inertia.with_stiffening(centrifugal, columns.as_ref()))
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

/// The columns of Ψ_r have unit M norm, so L1 Ψ_r / √m and I3 Ψ_r / √I are cosines.
fn check_mean_axes(of: &Superelement, to_dynamic: &Mat<f64>) -> Result<(), Error> {
    let inertia = &of.inertia;
    let largest_moment = (0..3).map(|a| inertia.tensor[a][a]).fold(0.0, f64::max);
    for (quantity, rows, size) in [
        ("L1", &inertia.l1, inertia.mass),
        ("I3", &inertia.i3, largest_moment),
    ] {
        let found = largest_entry((rows * to_dynamic).as_ref()) / size.sqrt();
        if found.is_nan() || found > MEAN_AXIS_LIMIT {
            return Err(Error::NotMeanAxis {
                body: of.name.clone(),
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
