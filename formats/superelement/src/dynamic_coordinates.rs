//! The coordinates that the compatibility of a superelement's interfaces asks for.
//!
//! ```text
//! y   = (η, ζ)                                       n = n_k + r
//! u   = Φ η + (G_res L_bᵀ T + X T_x) ζ               nodal field
//! u_Γ = L_b u + F g                                  (n_b), g the interface forces
//! ```

use dcb_formats::component::Role;
use dcb_formats::scene::Compatibility;
use dcb_formats::superelement::Superelement;
use faer::Mat;

use crate::Error;
use crate::residual_coordinates::ResidualCoordinates;

/// Coordinates of a superelement, modes first.
#[derive(Clone, Debug)]
pub struct DynamicCoordinates {
    /// ω² and σ², (n), 1/time²; zero for interface forces as coordinates (weak).
    pub stiffness: Vec<f64>,
    /// Their displacements of the interface rows, (n_b, n).
    pub interface_shapes: Mat<f64>,
    /// T, (n_b, r): T_r where compatibility is strong, without columns where it is static, the identity where it is weak.
    pub attached: Mat<f64>,
    /// T_x, (n_x, r).
    pub further: Mat<f64>,
    /// Flexibility beyond the coordinates, (n_b, n_b). Strong: the directions of F_res without mass, `None` if there are none.
    /// Static and weak: all of F_res, with the rows of output interfaces.
    pub residual_flexibility: Option<Mat<f64>>,
    mode_count: usize,
}

impl DynamicCoordinates {
    /// Of a superelement.
    ///
    /// # Errors
    /// [`Error::NoCoordinates`].
    pub fn of(superelement: &Superelement, compatibility: Compatibility) -> Result<Self, Error> {
        let modes = &superelement.modes;
        let (n_k, n_b) = (modes.eigenvalues.len(), superelement.rows.len());
        let n_x = superelement.basis_count() - n_k - n_b;
        let massive =
            ResidualCoordinates::of(superelement).map_err(|why| Error::NoCoordinates {
                body: superelement.name.clone(),
                why,
            })?;
        let residual_flexibility = match compatibility {
            Compatibility::Strong => massless_flexibility(superelement, &massive),
            Compatibility::Static | Compatibility::Weak => Some(attachments(superelement)),
        };
        let ResidualCoordinates {
            attached,
            further,
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
        let rank = attached.ncols();
        let mut interface_shapes = Mat::zeros(n_b, n_k + rank);
        let (mut of_modes, mut of_rest) = interface_shapes.as_mut().split_at_col_mut(n_k);
        of_modes.copy_from(&modes.interface_shapes);
        of_rest.copy_from(seen(superelement, &attached, &further));
        let stiffness = modes.eigenvalues.iter().chain(&stiffness);
        Ok(Self {
            stiffness: stiffness.copied().collect(),
            interface_shapes,
            attached,
            further,
            residual_flexibility,
            mode_count: n_k,
        })
    }

    /// `blkdiag(I, [T; T_x])`, (n_k + n_b + n_x, n): amplitudes of the file's columns from these coordinates.
    pub fn to_file(&self) -> Mat<f64> {
        let (n_k, n_b) = (self.mode_count, self.attached.nrows());
        Mat::from_fn(
            n_k + n_b + self.further.nrows(),
            n_k + self.attached.ncols(),
            |i, j| match (i < n_k, j < n_k) {
                (true, true) => f64::from(u8::from(i == j)),
                (false, false) if i < n_k + n_b => self.attached[(i - n_k, j - n_k)],
                (false, false) => self.further[(i - n_k - n_b, j - n_k)],
                _ => 0.0,
            },
        )
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

/// The static flexibility of F_res beyond the coordinates ζ. `None` where that is rounding, measured by the whole flexibility of
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
