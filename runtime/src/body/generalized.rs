//! A body given by reduced matrices over any coordinates, without a superelement's file.

use dcb_dense::{symmetric_eigen, symmetrized};
use dcb_formats::component::Units;
use dcb_formats::mesh::Dimension;
use dcb_formats::superelement::{BoundaryRow, Inertia, InterfaceFrame};
use faer::{Mat, MatRef};

use super::{Compatibility, FlexibleBody, MadeFor};
use crate::error::Error;
use crate::frame::{FrameInertia, FrameMomentum};

/// Part of the largest eigenvalue below which one of the stiffness counts as zero, and one of the mass as not positive.
const EIGENVALUE_ROUNDING: f64 = 1e-12;

/// A body over coordinates q with displacements u = Ψ q, whatever the shapes Ψ are.
#[derive(Clone, Debug, PartialEq)]
pub struct GeneralizedBody {
    /// Name.
    pub name: String,
    /// Unit system.
    pub units: Units,
    /// Planar or spatial.
    pub dimension: Dimension,
    /// Centre of mass of the undeformed body, the frame's origin, component coordinates.
    pub origin: [f64; 3],
    /// Ψᵀ M Ψ, (n, n), symmetric positive definite.
    pub mass: Mat<f64>,
    /// Ψᵀ K Ψ, (n, n), symmetric positive semi-definite.
    pub stiffness: Mat<f64>,
    /// Ratios to critical in the order of ascending frequency; the last holds for any further ones. Empty: none.
    pub damping: Vec<f64>,
    /// Inertia invariants over q, as in a superelement. Where L1 or I3 isn't zero the frame isn't on mean axes.
    pub inertia: Inertia,
    /// Interfaces.
    pub interfaces: Vec<InterfaceFrame>,
    /// Meaning of the rows of `interface_shapes`, interface by interface.
    pub rows: Vec<BoundaryRow>,
    /// Displacements of the interfaces, (n_b, n).
    pub interface_shapes: Mat<f64>,
}

impl FlexibleBody {
    /// The body of reduced matrices: M and K are diagonalised together, q = V y with Vᵀ M V = I, Vᵀ K V = diag(ω²).
    /// [`FlexibleBody::original_coordinates`] gives q back.
    ///
    /// # Errors
    /// [`Error::Shape`] if arrays don't fit, [`Error::NotPositive`] if the mass isn't positive definite or the stiffness
    /// not positive semi-definite.
    pub fn from_generalized(body: &GeneralizedBody) -> Result<Self, Error> {
        body.check_shapes()?;
        let (transform, stiffness) = body.modes()?;
        let n = stiffness.len();
        let last = body.damping.last().copied().unwrap_or(0.0);
        let ratios = body.damping.iter().copied().chain(std::iter::repeat(last));
        let columns = transform.as_ref();
        Ok(Self {
            name: body.name.clone(),
            units: body.units.clone(),
            origin: body.origin,
            compatibility: Compatibility::Strong,
            mode_count: n,
            damping: ratios.take(n).collect(),
            stiffness,
            first_omitted_eigenvalue: f64::INFINITY,
            made_for: MadeFor::default(),
            interface_shapes: &body.interface_shapes * &transform,
            attachment_transform: Mat::zeros(0, 0),
            further_transform: Mat::zeros(0, 0),
            interface_stiffening: Vec::new(),
            loads: Vec::new(),
            stresses: Vec::new(),
            residual_flexibility: None,
            residual_mass: None,
            growing: None,
            inertia: FrameInertia::over(&body.inertia, body.dimension, columns)
                .with_momentum(FrameMomentum::over(&body.inertia, columns)),
            to_original: transform,
            attachments: Vec::new(),
            interfaces: body.interfaces.clone(),
            rows: body.rows.clone(),
        }
        .with_attachments())
    }
}

impl GeneralizedBody {
    fn check_shapes(&self) -> Result<(), Error> {
        let n = self.mass.nrows();
        let (d, axes, pairs) = match self.dimension {
            Dimension::Planar => (2, 1, 0),
            Dimension::Spatial => (3, 3, 6),
        };
        let of = |matrix: &Mat<f64>| (matrix.nrows(), matrix.ncols());
        let inertia = &self.inertia;
        let single = [
            ("the mass", of(&self.mass), (n, n)),
            ("the stiffness", of(&self.stiffness), (n, n)),
            (
                "the interface shapes",
                of(&self.interface_shapes),
                (self.rows.len(), n),
            ),
            ("L1", of(&inertia.l1), (d, n)),
            ("I3", of(&inertia.i3), (axes, n)),
            ("I1", (inertia.i1.len(), 1), (n, 1)),
            ("the list of L3", (inertia.l3.len(), 1), (axes, 1)),
            ("the list of J2", (inertia.i2.len(), 1), (pairs, 1)),
        ];
        let l3 = inertia.l3.iter().map(|matrix| ("L3", of(matrix), (n, n)));
        let j2 = inertia.i2.iter().map(|matrix| ("J2", of(matrix), (n, n)));
        match (single.into_iter().chain(l3).chain(j2)).find(|(_, found, needed)| found != needed) {
            None => Ok(()),
            Some((quantity, found, expected)) => Err(Error::Shape {
                body: self.name.clone(),
                quantity,
                found,
                expected,
            }),
        }
    }

    /// V and ω², ascending: with M = Q D Qᵀ and W = Q D^(-1/2), V = W Z for the eigenvectors Z of Wᵀ K W.
    fn modes(&self) -> Result<(Mat<f64>, Vec<f64>), Error> {
        let (q, masses) = self.eigen("the mass", "positive definite", self.mass.as_ref())?;
        let largest = masses.last().copied().unwrap_or(0.0);
        if let Some(found) = masses.iter().find(|m| **m <= EIGENVALUE_ROUNDING * largest) {
            return Err(self.not_positive("the mass", "positive definite", *found));
        }
        let w = Mat::from_fn(q.nrows(), q.ncols(), |i, j| q[(i, j)] / masses[j].sqrt());
        let (what, required) = ("the stiffness", "positive semi-definite");
        let (z, mut squares) = self.eigen(
            what,
            required,
            (w.transpose() * &self.stiffness * &w).as_ref(),
        )?;
        let largest = squares.last().copied().unwrap_or(0.0).abs();
        for square in &mut squares {
            if *square < -EIGENVALUE_ROUNDING * largest {
                return Err(self.not_positive(what, required, *square));
            }
            *square = square.max(0.0);
        }
        Ok((w * z, squares))
    }

    /// Eigenvectors and ascending eigenvalues of the symmetric part.
    fn eigen(
        &self,
        quantity: &'static str,
        required: &'static str,
        matrix: MatRef<'_, f64>,
    ) -> Result<(Mat<f64>, Vec<f64>), Error> {
        let (values, vectors) = symmetric_eigen(symmetrized(matrix).as_ref())
            .ok_or_else(|| self.not_positive(quantity, required, f64::NAN))?;
        Ok((vectors, values))
    }

    fn not_positive(&self, quantity: &'static str, required: &'static str, found: f64) -> Error {
        Error::NotPositive {
            body: self.name.clone(),
            quantity,
            required,
            found,
        }
    }
}
