//! What the dynamic coordinates do for forces at some rows, at any λ: g has D of them beside the static shapes, and the rows move by C.
//!
//! D = diag(1 / (σ² - λ)) R diag(c) with a real R, so that products with it are real. An attached row has c = λ and the column Bᵀ/σ² of R; an output row,
//! whose static part isn't told apart, has c = 1 and Bᵀ.

use faer::{Mat, c64};

use super::model::Dynamic;
use super::split::Split;

/// Dynamic coordinates and some rows.
pub(super) struct DynamicRows<'a> {
    squares: &'a [f64],
    /// Bᵀ of the rows, (r, rows).
    seen: Mat<f64>,
    /// R, (r, rows).
    real: Mat<f64>,
    attached: Vec<bool>,
    /// F between the rows.
    flexibility: Mat<f64>,
}

/// D at one λ, (r, rows).
pub(super) struct Amounts<'a> {
    /// 1 / (σ² - λ), (r).
    weights: Vec<c64>,
    real: &'a Mat<f64>,
    /// c, (rows).
    factors: Vec<c64>,
    /// D
    pub values: Split,
}

impl<'a> DynamicRows<'a> {
    pub(super) fn of(
        dynamic: &'a Dynamic,
        flexibility: &Mat<f64>,
        attached: &[bool],
        rows: &[usize],
    ) -> Self {
        let squares = &dynamic.squares;
        let attached: Vec<bool> = rows.iter().map(|row| attached[*row]).collect();
        let seen = Mat::from_fn(squares.len(), rows.len(), |k, j| dynamic.seen[(rows[j], k)]);
        let real = Mat::from_fn(squares.len(), rows.len(), |k, j| {
            match (squares[k] > 0.0, attached[j]) {
                (false, _) => 0.0,
                (true, true) => seen[(k, j)] / squares[k],
                (true, false) => seen[(k, j)],
            }
        });
        let between = |i: usize, j: usize| flexibility[(rows[i], rows[j])];
        Self {
            squares,
            flexibility: Mat::from_fn(rows.len(), rows.len(), between),
            seen,
            real,
            attached,
        }
    }

    pub(super) fn at(&self, lambda: c64) -> Amounts<'_> {
        let one = c64::new(1.0, 0.0);
        let weights: Vec<c64> = (self.squares.iter())
            .map(|square| match *square > 0.0 {
                true => one / (c64::new(*square, 0.0) - lambda),
                false => c64::new(0.0, 0.0),
            })
            .collect();
        let factors: Vec<c64> = (self.attached.iter())
            .map(|attached| if *attached { lambda } else { one })
            .collect();
        let mut values = Split::weighted_rows(&weights, &self.real);
        values.scale_columns(factors.iter().copied());
        Amounts {
            weights,
            real: &self.real,
            factors,
            values,
        }
    }

    /// C = F + B D between the rows and those at some places among them, which forces act on.
    pub(super) fn responses(&self, amounts: &Amounts<'_>, places: &[usize]) -> Split {
        let forced = amounts.values.columns(places);
        let mut responses = Split::after_transposed(&self.seen, &forced);
        for (j, place) in places.iter().enumerate() {
            let column = responses.re.col_as_slice_mut(j).iter_mut();
            let flexibility = self.flexibility.col_as_slice(*place);
            column.zip(flexibility).for_each(|(sum, own)| *sum += own);
        }
        responses
    }
}

impl Amounts<'_> {
    /// matrix · D
    pub(super) fn after(&self, mut matrix: Split) -> Split {
        matrix.scale_columns(self.weights.iter().copied());
        let mut product = Split::before(&matrix, self.real);
        product.scale_columns(self.factors.iter().copied());
        product
    }

    /// Dᵀ · matrix
    pub(super) fn transposed_before(&self, matrix: Split) -> Split {
        self.before(matrix, |weight| weight)
    }

    /// Dᴴ · matrix
    pub(super) fn adjoint_before(&self, matrix: Split) -> Split {
        self.before(matrix, |weight| weight.conj())
    }

    fn before(&self, mut matrix: Split, of: fn(c64) -> c64) -> Split {
        matrix.scale_rows(self.weights.iter().map(|weight| of(*weight)));
        let mut product = Split::after_transposed(self.real, &matrix);
        product.scale_rows(self.factors.iter().map(|factor| of(*factor)));
        product
    }
}
