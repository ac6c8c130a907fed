//! A superelement over the coordinates of its strong form, and the integrals that other programs ask for.
//!
//! ```text
//! y = (η, ζ)                  modes, then attachments (and further columns) combined to unit mass; M = 1, K = diag(ω², σ²)
//! ∫ρ ψ_k = L1_k               ∫ρ x × ψ_k = I3_k               ∫ρ ψ_k × ψ_l = L3_kl          (docs/theory.md §7)
//! N_k  = ∫ρ ((x·ψ_k) 1 − ψ_k xᵀ) =  ½ I1_k − ½ [I3_k]         [v] the matrix of v ×
//! P_kl = ∫ρ [ψ_k][ψ_l]           = −I2_kl + ½ [L3_kl]
//! ```
//! The file's invariants alone give them, exactly: no matrix of the finite elements is read. A frame whose origin is off the centre of mass, x' = x + c, changes
//!
//! ```text
//! J' = J + m (c² 1 − c cᵀ)    I3'_k = I3_k + c × L1_k    I1'_k = I1_k + 2 (c·L1_k) 1 − c L1_kᵀ − L1_k cᵀ
//! ```

use dcb_formats::Superelement;
use dcb_formats::scene::Compatibility;
use dcb_superelement::{DynamicCoordinates, Error};
use faer::Mat;
use nalgebra::{Matrix3, Vector3};

use crate::Axes;

/// Places of xx, yy, zz, xy, yz, zx in a symmetric 3 x 3 matrix.
pub(crate) const PAIRS: [(usize, usize); 6] = [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (2, 0)];

/// The integrals of a spatial superelement over its strong coordinates, q of them; axes are the body's, the origin as asked for.
#[derive(Debug)]
pub(crate) struct Basis {
    /// m.
    pub mass: f64,
    /// c, the centre of mass seen from the origin.
    pub centre: Vector3<f64>,
    /// J about the centre of mass.
    pub tensor: Matrix3<f64>,
    /// n_k, the free modes among the coordinates.
    pub mode_count: usize,
    /// ω², σ², (q).
    pub stiffness: Vec<f64>,
    /// 2 ζ ω, (q).
    pub damping: Vec<f64>,
    /// Displacements of the interface rows, (n_b, q).
    pub rows: Mat<f64>,
    /// L1, (3, q).
    pub l1: Mat<f64>,
    /// I3 about the origin, (3, q).
    pub i3: Mat<f64>,
    /// I1 about the origin, (q).
    pub i1: Vec<Matrix3<f64>>,
    /// L3, three matrices (q, q).
    pub l3: Vec<Mat<f64>>,
    /// I2, six matrices (q, q) in the order of [`PAIRS`].
    pub i2: Vec<Mat<f64>>,
    /// Geometric stiffness per spin product, six matrices (q, q) in the order of [`PAIRS`]; empty where the file has none.
    pub centrifugal: Vec<Mat<f64>>,
    /// Geometric stiffness per force on an interface row, n_b matrices (q, q); empty where the file has none.
    pub interface: Vec<Mat<f64>>,
    /// Amplitudes of the file's columns, (n, q).
    pub to_file: Mat<f64>,
    /// Flexibility without mass, which the strong form has beside its coordinates: no other program has a place for it.
    pub has_massless_flexibility: bool,
}

impl Basis {
    /// Of a spatial superelement.
    ///
    /// # Errors
    /// [`Error::NoCoordinates`].
    pub(crate) fn of(superelement: &Superelement, axes: Axes) -> Result<Self, Error> {
        let coordinates = DynamicCoordinates::of(superelement, Compatibility::Strong)?;
        let to_file = coordinates.to_file();
        let both = |of: &Mat<f64>| to_file.transpose() * of * &to_file;
        let inertia = &superelement.inertia;
        let q = coordinates.stiffness.len();
        let combined = |k: usize| {
            let columns = inertia.i1.iter().enumerate();
            columns.fold(Matrix3::zeros(), |sum, (i, of)| {
                sum + matrix3(of) * to_file[(i, k)]
            })
        };
        let modes = &superelement.modes;
        let ratio = |k: usize| *modes.damping.get(k).unwrap_or(&modes.residual_damping);
        let damping = coordinates.stiffness.iter().enumerate();
        let basis = Self {
            mass: inertia.mass,
            centre: Vector3::zeros(),
            tensor: matrix3(&inertia.tensor),
            mode_count: superelement.mode_count(),
            damping: damping
                .map(|(k, square)| 2.0 * ratio(k) * square.max(0.0).sqrt())
                .collect(),
            stiffness: coordinates.stiffness,
            rows: coordinates.interface_shapes,
            l1: &inertia.l1 * &to_file,
            i3: &inertia.i3 * &to_file,
            i1: (0..q).map(combined).collect(),
            l3: inertia.l3.iter().map(both).collect(),
            i2: inertia.i2.iter().map(both).collect(),
            centrifugal: superelement
                .stiffening
                .centrifugal
                .iter()
                .map(both)
                .collect(),
            interface: superelement.stiffening.interface.iter().map(both).collect(),
            to_file,
            has_massless_flexibility: coordinates.residual_flexibility.is_some(),
        };
        Ok(match axes {
            Axes::Body => basis,
            Axes::Component => basis.moved(Vector3::from(superelement.origin)),
        })
    }

    /// About an origin from which the centre of mass is at c.
    fn moved(mut self, c: Vector3<f64>) -> Self {
        for k in 0..self.count() {
            let l1 = column(&self.l1, k);
            let i3 = c.cross(&l1);
            for a in 0..3 {
                self.i3[(a, k)] += i3[a];
            }
            self.i1[k] +=
                Matrix3::identity() * (2.0 * c.dot(&l1)) - c * l1.transpose() - l1 * c.transpose();
        }
        self.centre = c;
        self
    }

    /// q.
    pub(crate) fn count(&self) -> usize {
        self.stiffness.len()
    }

    /// J about the origin.
    pub(crate) fn tensor_about_origin(&self) -> Matrix3<f64> {
        let c = self.centre;
        self.tensor + (Matrix3::identity() * c.dot(&c) - c * c.transpose()) * self.mass
    }

    /// L1_k.
    pub(crate) fn l1(&self, k: usize) -> Vector3<f64> {
        column(&self.l1, k)
    }

    /// L3_kl.
    pub(crate) fn l3(&self, k: usize, l: usize) -> Vector3<f64> {
        Vector3::from_fn(|a, _| self.l3[a][(k, l)])
    }

    /// N_k.
    pub(crate) fn first(&self, k: usize) -> Matrix3<f64> {
        (self.i1[k] - column(&self.i3, k).cross_matrix()) * 0.5
    }

    /// P_kl.
    pub(crate) fn second(&self, k: usize, l: usize) -> Matrix3<f64> {
        let mut of = self.l3(k, l).cross_matrix() * 0.5;
        for (pair, &(a, b)) in PAIRS.iter().enumerate() {
            let value = self.i2[pair][(k, l)];
            of[(a, b)] -= value;
            if a != b {
                of[(b, a)] -= value;
            }
        }
        of
    }
}

/// Column of a matrix with three rows.
pub(crate) fn column(of: &Mat<f64>, k: usize) -> Vector3<f64> {
    Vector3::from_fn(|a, _| of[(a, k)])
}

pub(crate) fn matrix3(of: &[[f64; 3]; 3]) -> Matrix3<f64> {
    Matrix3::from_fn(|a, b| of[a][b])
}
