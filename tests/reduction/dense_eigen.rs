//! Where eigensolutions lose digits: repeated roots, graded and tiny entries, many rows.

use dcb_dense::{symmetric_eigen, symmetric_eigenvalues, symmetrized};
use dcb_samples::PseudoRandom;
use faer::Mat;

/// Below 128 rows, at this limit and beyond it faer takes different ways.
const ROWS: [usize; 7] = [1, 2, 60, 127, 128, 200, 400];
const SIZES: [f64; 7] = [1.0, 1e-30, 1e-9, 1e9, 1e30, 1e-250, 1e250];

/// I - 2 v vᵀ / vᵀ v, which is orthogonal.
fn reflection(n: usize) -> Mat<f64> {
    let v = PseudoRandom::new(7).matrix(n, 1);
    let square = v.squared_norm_l2();
    Mat::from_fn(n, n, |i, j| {
        f64::from(u8::from(i == j)) - 2.0 * v[(i, 0)] * v[(j, 0)] / square
    })
}

/// Residuals and orthonormality beside the largest entry; the eigenvalues.
fn defects(matrix: &Mat<f64>, size: f64) -> (f64, Vec<f64>) {
    let n = matrix.nrows();
    let (values, vectors) = symmetric_eigen(matrix.as_ref()).unwrap();
    // Without products that leave the range of numbers.
    let unit = Mat::from_fn(n, n, |i, j| matrix[(i, j)] / size);
    let values: Vec<f64> = values.iter().map(|value| value / size).collect();
    let left = &unit * &vectors - Mat::from_fn(n, n, |i, j| vectors[(i, j)] * values[j]);
    let gram = vectors.transpose() * &vectors - Mat::<f64>::identity(n, n);
    let alone = symmetric_eigenvalues(matrix.as_ref()).unwrap();
    let apart = alone.iter().zip(&values).map(|(a, b)| (a / size - b).abs());
    let apart = apart.fold(0.0, f64::max);
    (left.norm_max().max(gram.norm_max()).max(apart), values)
}

#[test]
fn repeated_roots_are_found_whatever_the_size() {
    for n in ROWS {
        let turn = reflection(n);
        // Three roots, each as often as the others, and one by itself.
        let roots: Vec<f64> = (0..n)
            .map(|i| {
                if i == 0 {
                    -1.0
                } else {
                    [0.5, 1.0, 3.0][3 * i / n.max(1)]
                }
            })
            .collect();
        for size in SIZES {
            let matrix = Mat::from_fn(n, n, |i, j| {
                (0..n)
                    .map(|k| turn[(i, k)] * roots[k] * turn[(j, k)])
                    .sum::<f64>()
                    * size
            });
            let (defect, values) = defects(&symmetrized(&matrix), size);
            assert!(defect < 1e-12, "{n} rows of size {size:e}: {defect:e}");
            for (value, root) in values.iter().zip(&roots) {
                assert!(
                    (value - root).abs() < 1e-12,
                    "{n} rows of size {size:e}: {value}"
                );
            }
        }
    }
}

/// A chain of n equal masses between walls: 2 - 2 cos(k π / (n + 1)).
#[test]
fn a_chain_has_the_frequencies_of_its_closed_form() {
    for n in ROWS {
        for size in SIZES {
            let matrix = Mat::from_fn(n, n, |i, j| match i.abs_diff(j) {
                0 => 2.0 * size,
                1 => -size,
                _ => 0.0,
            });
            let (defect, values) = defects(&matrix, size);
            assert!(defect < 1e-12, "{n} rows of size {size:e}: {defect:e}");
            for (k, value) in values.iter().enumerate() {
                let angle = (k + 1) as f64 * std::f64::consts::PI / (n + 1) as f64;
                assert!(
                    (value - (2.0 - 2.0 * angle.cos())).abs() < 1e-13,
                    "{n}: {value}"
                );
            }
        }
    }
}

/// As projected flexibilities are: of order 1e-9, and falling by 1e-7 to 1e-25 from the first row to the last.
#[test]
fn graded_matrices_are_diagonal_beside_their_own_size() {
    for n in ROWS {
        let random = PseudoRandom::new(7).matrix(n, n);
        for size in SIZES {
            let matrix = Mat::from_fn(n, n, |i, j| {
                let decay = size * 0.93_f64.powi((i + j) as i32);
                match i == j {
                    true => decay,
                    false => decay * random[(i.min(j), i.max(j))],
                }
            });
            let (defect, _) = defects(&matrix, size);
            assert!(defect < 1e-12, "{n} rows of size {size:e}: {defect:e}");
        }
    }
}

#[test]
fn nothing_zero_and_no_numbers() {
    let (values, vectors) = symmetric_eigen(Mat::zeros(0, 0).as_ref()).unwrap();
    assert!(values.is_empty() && vectors.ncols() == 0);
    let (values, _) = symmetric_eigen(Mat::zeros(200, 200).as_ref()).unwrap();
    assert_eq!(values, vec![0.0; 200]);
    for wrong in [f64::NAN, f64::INFINITY] {
        let matrix = Mat::from_fn(3, 3, |_, _| wrong);
        assert!(symmetric_eigen(matrix.as_ref()).is_none());
        assert!(symmetric_eigenvalues(matrix.as_ref()).is_none());
    }
}
