//! Rules that numbers, lists and matrices from anywhere must keep.

use faer::{Mat, MatRef};

use crate::hdf5_files::inventory::Finding;
use crate::terminal::shortened;

/// Entries that should be equal may differ by this much of their scale: rounding of a long sum, not more.
pub(in crate::dcb) const SYMMETRY_TOLERANCE: f64 = 1e-9;
/// Names longer than this are a mistake.
const LONGEST_NAME: usize = 4096;

pub(in crate::dcb) type Checked = Result<(), Finding>;

pub(super) fn wrong<T>(path: &str, message: impl Into<String>) -> Result<T, Finding> {
    Err(Finding::at(path, message))
}

pub(super) fn name(path: &str, what: &str, text: &str) -> Checked {
    if text.is_empty() || text.len() > LONGEST_NAME || text.contains(['\0', '\n']) {
        return wrong(
            path,
            format!(
                "{what} is {:?}; it must have 1 to {LONGEST_NAME} bytes and no line feed or zero byte",
                shortened(text)
            ),
        );
    }
    Ok(())
}

pub(super) fn length(path: &str, found: usize, right: usize) -> Checked {
    if found == right {
        Ok(())
    } else {
        wrong(path, format!("has {found} entries; {right} are needed"))
    }
}

pub(in crate::dcb) fn finite(path: &str, values: &[f64]) -> Checked {
    match values.iter().position(|value| !value.is_finite()) {
        Some(index) => wrong(
            path,
            format!(
                "entry {index} is {}; every entry must be finite",
                values[index]
            ),
        ),
        None => Ok(()),
    }
}

pub(super) fn not_negative(path: &str, values: &[f64]) -> Checked {
    finite(path, values)?;
    match values.iter().position(|value| *value < 0.0) {
        Some(index) => wrong(
            path,
            format!("entry {index} is {}; none may be negative", values[index]),
        ),
        None => Ok(()),
    }
}

pub(super) fn ascending(path: &str, values: &[f64]) -> Checked {
    not_negative(path, values)?;
    match values.windows(2).position(|pair| pair[1] < pair[0]) {
        Some(index) => wrong(
            path,
            format!(
                "entry {} is below entry {index}; they must ascend",
                index + 1
            ),
        ),
        None => Ok(()),
    }
}

pub(super) fn matrix(path: &str, matrix: &Mat<f64>, rows: usize, columns: usize) -> Checked {
    if (matrix.nrows(), matrix.ncols()) != (rows, columns) {
        return wrong(
            path,
            format!(
                "is {}x{}; {rows}x{columns} is needed",
                matrix.nrows(),
                matrix.ncols()
            ),
        );
    }
    (0..columns).try_for_each(|j| finite(path, matrix.col_as_slice(j)))
}

pub(super) fn layers(path: &str, matrices: &[Mat<f64>], count: usize, n: usize) -> Checked {
    length(path, matrices.len(), count)?;
    matrices
        .iter()
        .try_for_each(|layer| matrix(path, layer, n, n))
}

/// Symmetric on the scale of its diagonal; where that is zero, of its largest entry.
pub(super) fn symmetric(path: &str, matrix: MatRef<'_, f64>) -> Checked {
    let n = matrix.nrows();
    let diagonal: Vec<f64> = (0..n).map(|i| matrix[(i, i)].abs().sqrt()).collect();
    let least = diagonal
        .iter()
        .fold(0.0_f64, |most, &value| most.max(value))
        * f64::EPSILON.sqrt();
    mirrored(path, matrix, 1.0, |i, j| {
        diagonal[i].max(least) * diagonal[j].max(least)
    })
}

pub(super) fn trace(tensor: &[[f64; 3]; 3]) -> f64 {
    (0..3).map(|a| tensor[a][a]).sum()
}

pub(super) fn symmetric_tensor(path: &str, tensor: &[[f64; 3]; 3], scale: f64) -> Checked {
    let matrix = Mat::from_fn(3, 3, |a, b| tensor[a][b]);
    (0..3).try_for_each(|j| finite(path, matrix.col_as_slice(j)))?;
    mirrored(path, matrix.as_ref(), 1.0, |_, _| scale)
}

/// `a_ij = sign a_ji` within the tolerance times `scale`.
pub(super) fn mirrored(
    path: &str,
    matrix: MatRef<'_, f64>,
    sign: f64,
    scale: impl Fn(usize, usize) -> f64,
) -> Checked {
    for j in 0..matrix.ncols() {
        for i in 0..=j {
            let (upper, lower) = (matrix[(i, j)], matrix[(j, i)]);
            let allowed = SYMMETRY_TOLERANCE * scale(i, j).max(0.0);
            if (upper - sign * lower).abs() > allowed {
                let kind = if sign > 0.0 {
                    "symmetric"
                } else {
                    "antisymmetric"
                };
                return wrong(
                    path,
                    format!(
                        "isn't {kind}: entry ({i}, {j}) is {upper:e}, entry ({j}, {i}) is {lower:e}"
                    ),
                );
            }
        }
    }
    Ok(())
}
