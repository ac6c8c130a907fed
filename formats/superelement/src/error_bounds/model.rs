//! Model of the motions beyond a superelement's modes, in combinations of the static shapes X of the power moments.
//!
//! A unit force at row j moves the component by X g_j(λ) beside its rigid motions and modes, and the rows by C_j(λ):
//!
//! ```text
//! strong   g = Q + T diag(λ / (σ² (σ² - λ))) Bᵀ     C = F + B diag(λ / (σ² (σ² - λ))) Bᵀ
//! static   g = Q                                     C = F
//! ```
//! F is the file's L G_res Lᵀ, T its dynamic coordinates ζ with their σ², B what ζ do to the rows, and Q the directions that an interface
//! reduction has left (the identity where there was none). At λ = 0 both forms are the same, directions without mass included.

use crate::ResidualCoordinates;
use dcb_dense::{symmetric_eigen, symmetrized};
use dcb_formats::Superelement;
use dcb_formats::scene::Compatibility;
use dcb_formats::superelement::Moments;
use faer::{Mat, c64, concat};

use super::amounts::DynamicRows;
use super::rows::Rows;
use crate::MASS_TOLERANCE;

/// Matrices that differ by less than this, scaled, are the same flexibility.
const SAME_FLEXIBILITY: f64 = 1e-12;

/// Dynamic coordinates ζ, each M-orthonormal, in scaled rows.
pub(super) struct Dynamic {
    /// σ², (r).
    pub squares: Vec<f64>,
    /// T, (n_b + n_x, r).
    combinations: Mat<f64>,
    /// B, (n_b, r).
    pub seen: Mat<f64>,
}

/// The residual part of a superelement in one form, in scaled rows.
pub(super) struct Model {
    /// Q, (n_b + n_x, n_b).
    base: Mat<f64>,
    /// F, (n_b, n_b), columns of output rows zero.
    flexibility: Mat<f64>,
    dynamic: Dynamic,
    attached: Vec<bool>,
}

impl Model {
    /// `None` if a dense eigenproblem fails, which only numbers that aren't finite cause.
    pub(super) fn of(
        element: &Superelement,
        moments: &Moments,
        rows: &Rows,
        compatibility: Compatibility,
    ) -> Option<Self> {
        let residual = &element.residual;
        let stored = (residual.output_shapes.as_ref()).unwrap_or(&residual.flexibility);
        let flexibility = rows.seen(rows.scaled(stored));
        let file_n_b = stored.nrows();
        let first = moments.first.get(..file_n_b, ..file_n_b).to_owned();
        let directions = directions(&first, rows, &flexibility)?;
        let n_b = rows.count();
        let n = n_b + moments.first.nrows() - element.boundary_row_count();
        let file_n = moments.first.nrows();
        let base = Mat::from_fn(
            n,
            n_b,
            |i, j| {
                if i < n_b { directions[(i, j)] } else { 0.0 }
            },
        );
        let coordinates = match compatibility {
            Compatibility::Static | Compatibility::Weak => Coordinates::none(file_n),
            Compatibility::Strong => Coordinates::dynamic(element)?,
        };
        // Coordinates of attachments and further columns as the file has them; T in all static shapes is Q times that.
        let amounts = rows.scaled_amounts(&coordinates.combinations, stored)?;
        let combinations = Mat::from_fn(n, amounts.ncols(), |i, j| match i < n_b {
            true => (0..n_b).map(|k| directions[(i, k)] * amounts[(k, j)]).sum(),
            false => amounts[(i, j)],
        });
        let mut seen = &flexibility * amounts.subrows(0, n_b);
        if let Some(further) = &element.enrichment {
            let shapes = rows.scaled_further(&further.interface_shapes);
            seen += shapes * amounts.subrows(n_b, n - n_b);
        }
        Some(Self {
            base,
            flexibility,
            dynamic: Dynamic {
                squares: coordinates.squares,
                combinations,
                seen,
            },
            attached: rows.attached.clone(),
        })
    }

    /// g at λ = 0 without what the dynamic coordinates make of it, for forces at some rows, (n_b + n_x, rows). Output rows feel none: theirs is
    /// what the dynamic coordinates say.
    pub(super) fn static_amounts(&self, rows: &[usize]) -> Mat<f64> {
        Mat::from_fn(self.base.nrows(), rows.len(), |i, j| {
            match self.attached[rows[j]] {
                true => self.base[(i, rows[j])],
                false => 0.0,
            }
        })
    }

    /// T, (n_b + n_x, r).
    pub(super) fn combinations(&self) -> &Mat<f64> {
        &self.dynamic.combinations
    }

    /// D and C at any λ, for forces at some rows.
    pub(super) fn dynamic_rows(&self, rows: &[usize]) -> DynamicRows<'_> {
        DynamicRows::of(&self.dynamic, &self.flexibility, &self.attached, rows)
    }

    /// C between one row and one row that forces act on.
    pub(super) fn response(&self, row: usize, forced: usize, lambda: c64) -> c64 {
        let Dynamic { squares, seen, .. } = &self.dynamic;
        (0..squares.len()).fold(c64::new(self.flexibility[(row, forced)], 0.0), |sum, k| {
            sum + weight(squares[k], lambda) * (seen[(row, k)] * seen[(forced, k)])
        })
    }

    /// σ² and B of the dynamic coordinates.
    pub(super) fn dynamic(&self) -> (&[f64], &Mat<f64>) {
        (&self.dynamic.squares, &self.dynamic.seen)
    }

    /// Flexibility between rows that forces act on which no dynamic coordinate carries.
    pub(super) fn massless(&self, rows: &[usize]) -> Mat<f64> {
        let Dynamic { squares, seen, .. } = &self.dynamic;
        let rest = Mat::from_fn(rows.len(), rows.len(), |i, j| {
            let (i, j) = (rows[i], rows[j]);
            let carried: f64 = (0..squares.len())
                .filter(|k| squares[*k] > 0.0)
                .map(|k| seen[(i, k)] * seen[(j, k)] / squares[k])
                .sum();
            self.flexibility[(i, j)] - carried
        });
        symmetrized(rest.as_ref())
    }
}

/// λ / (σ² (σ² - λ))
fn weight(square: f64, lambda: c64) -> c64 {
    match square > 0.0 {
        true => lambda / (square * (c64::new(square, 0.0) - lambda)),
        false => c64::new(0.0, 0.0),
    }
}

/// Q in scaled rows: the projector on the forces that an interface reduction has left, E U Uᵀ E⁻¹ with U the range of E F E and E the
/// scale in which it was made.
fn directions(first: &Mat<f64>, rows: &Rows, flexibility: &Mat<f64>) -> Option<Mat<f64>> {
    let n_b = rows.count();
    let whole = rows.seen(rows.scaled(first));
    let between = |i: usize, j: usize| rows.attached[i] && rows.attached[j];
    let apart = Mat::from_fn(n_b, n_b, |i, j| match between(i, j) {
        true => whole[(i, j)] - flexibility[(i, j)],
        false => 0.0,
    });
    if apart.norm_max() <= SAME_FLEXIBILITY {
        return Some(Mat::identity(n_b, n_b));
    }
    // The scale of a reduction leaves rigid motions out.
    let scale: Vec<f64> = (0..n_b)
        .map(|i| match rows.elastic_flexibility[i] {
            whole if whole > 0.0 => 1.0 / whole.sqrt(),
            _ => 0.0,
        })
        .collect();
    let scaled = Mat::from_fn(n_b, n_b, |i, j| match between(i, j) {
        true => scale[i] * flexibility[(i, j)] * scale[j],
        false => 0.0,
    });
    let (values, vectors) = symmetric_eigen(symmetrized(scaled.as_ref()).as_ref())?;
    let limit = MASS_TOLERANCE * values.last().copied().unwrap_or(0.0);
    let kept: Vec<usize> = (0..n_b).filter(|k| values[*k] > limit).collect();
    Some(Mat::from_fn(n_b, n_b, |i, j| match scale[j] > 0.0 {
        true => {
            let shared: f64 = (kept.iter())
                .map(|k| vectors[(i, *k)] * vectors[(j, *k)])
                .sum();
            scale[i] * shared / scale[j]
        }
        false => 0.0,
    }))
}

/// Coordinates over attachments and further columns, M-orthonormal and diagonal in K.
struct Coordinates {
    /// σ², (r).
    squares: Vec<f64>,
    /// (n_b + n_x, r).
    combinations: Mat<f64>,
}

impl Coordinates {
    fn none(count: usize) -> Self {
        Self {
            squares: Vec::new(),
            combinations: Mat::zeros(count, 0),
        }
    }

    fn dynamic(element: &Superelement) -> Option<Self> {
        let ResidualCoordinates {
            attached,
            further,
            stiffness,
        } = ResidualCoordinates::of(element).ok()?;
        Some(Self {
            squares: stiffness,
            combinations: concat![[attached], [further]],
        })
    }
}
