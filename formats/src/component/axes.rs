//! The axes of an interface frame: checked, then made orthonormal to rounding.

use super::fault::{ComponentFault, fault};
use crate::mesh::Dimension;

/// Largest deviation of given axes from orthogonal unit vectors: the rounding of seven written digits.
const AXES_TOLERANCE: f64 = 1e-6;

/// Rows that deviate by no more are orthonormal to rounding.
const ROUNDING: f64 = 8.0 * f64::EPSILON;

/// The rotation nearest to three rows that are orthonormal within seven written digits; rows that are orthonormal to rounding stay as
/// they are.
///
/// # Errors
/// Rows that aren't, or that turn a planar frame out of its plane.
pub(super) fn checked_axes(
    location: &str,
    axes: [[f64; 3]; 3],
    dimension: Dimension,
) -> Result<[[f64; 3]; 3], ComponentFault> {
    check_axes(location, &axes)?;
    if dimension == Dimension::Planar && (axes[2][2] - 1.0).abs() > AXES_TOLERANCE {
        return Err(fault(
            format!("{location}[2]"),
            format!(
                "is {:?}, but a planar frame turns about z: expected [0, 0, 1]",
                axes[2]
            ),
        ));
    }
    let unit = |i: usize, j: usize| if i == j { 1.0 } else { 0.0 };
    let is_orthonormal =
        (0..3).all(|i| (0..3).all(|j| (dot(&axes[i], &axes[j]) - unit(i, j)).abs() <= ROUNDING));
    Ok(if is_orthonormal {
        axes
    } else {
        orthonormal(axes)
    })
}

fn dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: &[f64; 3], b: &[f64; 3]) -> [f64; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

fn check_axes(location: &str, axes: &[[f64; 3]; 3]) -> Result<(), ComponentFault> {
    for (row, axis) in axes.iter().enumerate() {
        let length = dot(axis, axis).sqrt();
        if length.is_nan() || (length - 1.0).abs() > AXES_TOLERANCE {
            return Err(fault(
                format!("{location}[{row}]"),
                format!("has length {length}, expected a unit vector (within {AXES_TOLERANCE:e})"),
            ));
        }
    }
    for (a, b) in [(0, 1), (1, 2), (0, 2)] {
        let cosine = dot(&axes[a], &axes[b]);
        if cosine.abs() > AXES_TOLERANCE {
            return Err(fault(
                location,
                format!(
                    "rows {a} and {b} are not perpendicular: their product is {cosine:e}, expected 0 (within {AXES_TOLERANCE:e})"
                ),
            ));
        }
    }
    if dot(&cross(&axes[0], &axes[1]), &axes[2]) < 0.0 {
        return Err(fault(
            location,
            "are left-handed; reverse the sign of one row",
        ));
    }
    Ok(())
}

/// The rotation nearest to nearly orthonormal rows: Newton-Schulz, X ← (3 X - X Xᵀ X) / 2, which squares the defect.
fn orthonormal(mut axes: [[f64; 3]; 3]) -> [[f64; 3]; 3] {
    const STEPS: usize = 3; // 1e-6, 1e-12, rounding
    for _ in 0..STEPS {
        let gram = axes.map(|a| axes.map(|b| dot(&a, &b)));
        let mut next = axes;
        for (row, gram_row) in next.iter_mut().zip(&gram) {
            for (column, entry) in row.iter_mut().enumerate() {
                let projected: f64 = gram_row
                    .iter()
                    .zip(&axes)
                    .map(|(factor, axis)| factor * axis[column])
                    .sum();
                *entry = 1.5 * *entry - 0.5 * projected;
            }
        }
        axes = next;
    }
    axes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nearly_orthonormal_axes_become_orthonormal_to_rounding() {
        let (c, s) = (0.8 + 3e-7, 0.6 - 2e-7);
        let axes = orthonormal([[c, s, 4e-7], [-s, c, 0.0], [0.0, 1e-7, 1.0]]);
        for (i, a) in axes.iter().enumerate() {
            for (j, b) in axes.iter().enumerate() {
                let defect = dot(a, b) - if i == j { 1.0 } else { 0.0 };
                assert!(
                    defect.abs() < 4.0 * f64::EPSILON,
                    "rows {i}, {j}: {defect:e}"
                );
            }
        }
        assert!((axes[0][0] - c).abs() < 1e-6);
    }
}
