//! Numbers that a factored iteration matrix consists of: real ones for a real shift, complex ones for a complex shift.

use faer::c64;

use nalgebra::{Matrix3, Vector3};

use crate::frame::tall_products;
use crate::kinematics::frame_motion::{Six, SixOf};

/// A real or complex number. The motion itself stays real: markers, gradients and shapes are real whatever they are multiplied with.
pub trait Number:
    nalgebra::ComplexField<RealField = f64> + faer::traits::ComplexField<Real = f64> + Copy
{
    /// A real number as one of these.
    fn of(value: f64) -> Self;

    /// The product with a real number.
    fn times(self, factor: f64) -> Self;

    /// `y += Σ_k factors[k] columns_k` with real columns.
    fn add_columns(y: &mut [Self], columns: &[f64], factors: &[Self]);

    /// `products[k] += columns_k · x` with real columns.
    fn add_products(products: &mut [Self], columns: &[f64], x: &[Self]);

    /// The same with columns of these numbers.
    fn add_own_columns(y: &mut [Self], columns: &[Self], factors: &[Self]);

    /// The same with columns of these numbers, not conjugated.
    fn add_own_products(products: &mut [Self], columns: &[Self], x: &[Self]);
}

impl Number for f64 {
    fn of(value: f64) -> Self {
        value
    }

    fn times(self, factor: f64) -> Self {
        self * factor
    }

    fn add_columns(y: &mut [Self], columns: &[f64], factors: &[Self]) {
        tall_products::add_columns(y, columns, factors);
    }

    fn add_products(products: &mut [Self], columns: &[f64], x: &[Self]) {
        tall_products::add_products(products, columns, x);
    }

    fn add_own_columns(y: &mut [Self], columns: &[Self], factors: &[Self]) {
        tall_products::add_columns(y, columns, factors);
    }

    fn add_own_products(products: &mut [Self], columns: &[Self], x: &[Self]) {
        tall_products::add_products(products, columns, x);
    }
}

impl Number for c64 {
    fn of(value: f64) -> Self {
        Self::new(value, 0.0)
    }

    fn times(self, factor: f64) -> Self {
        Self::new(self.re * factor, self.im * factor)
    }

    fn add_columns(y: &mut [Self], columns: &[f64], factors: &[Self]) {
        for (column, factor) in columns.chunks_exact(y.len().max(1)).zip(factors) {
            for (y, entry) in y.iter_mut().zip(column) {
                *y += factor.times(*entry);
            }
        }
    }

    fn add_products(products: &mut [Self], columns: &[f64], x: &[Self]) {
        for (column, product) in columns.chunks_exact(x.len().max(1)).zip(products) {
            let terms = column.iter().zip(x).map(|(entry, x)| x.times(*entry));
            *product += terms.sum::<Self>();
        }
    }

    fn add_own_columns(y: &mut [Self], columns: &[Self], factors: &[Self]) {
        for (column, factor) in columns.chunks_exact(y.len().max(1)).zip(factors) {
            for (y, entry) in y.iter_mut().zip(column) {
                *y += factor * entry;
            }
        }
    }

    fn add_own_products(products: &mut [Self], columns: &[Self], x: &[Self]) {
        for (column, product) in columns.chunks_exact(x.len().max(1)).zip(products) {
            let terms = column.iter().zip(x).map(|(entry, x)| entry * x);
            *product += terms.sum::<Self>();
        }
    }
}

/// The product of six real numbers and six of these.
pub fn dot<T: Number>(real: &Six, other: &SixOf<T>) -> T {
    let mut sum = T::of(0.0);
    for (entry, factor) in other.iter().zip(real.iter()) {
        sum += entry.times(*factor);
    }
    sum
}

/// `matrix x`
pub fn rotated<T: Number>(matrix: &Matrix3<f64>, x: &Vector3<T>) -> Vector3<T> {
    Vector3::from_fn(|i, _| {
        x[0].times(matrix[(i, 0)]) + x[1].times(matrix[(i, 1)]) + x[2].times(matrix[(i, 2)])
    })
}

/// `matrixᵀ x`
pub fn rotated_back<T: Number>(matrix: &Matrix3<f64>, x: &Vector3<T>) -> Vector3<T> {
    Vector3::from_fn(|i, _| {
        x[0].times(matrix[(0, i)]) + x[1].times(matrix[(1, i)]) + x[2].times(matrix[(2, i)])
    })
}

/// `x × arm`
pub fn crossed<T: Number>(x: &Vector3<T>, arm: &Vector3<f64>) -> Vector3<T> {
    Vector3::new(
        x[1].times(arm[2]) - x[2].times(arm[1]),
        x[2].times(arm[0]) - x[0].times(arm[2]),
        x[0].times(arm[1]) - x[1].times(arm[0]),
    )
}
