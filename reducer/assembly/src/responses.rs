//! What the parts' own truncation does to the responses at the interfaces of the whole: an estimate.
//!
//! A part answers by Ẽ(λ) where its mesh answers by E(λ), with E − Ẽ ≤ E⁺ − Ẽ (`bounds.rs`). To first order the receptance of the whole changes by
//!
//! ```text
//! δH = Σ W_iᵀ (E_i − Ẽ_i) W_i        W_i(λ) forces on the rows of part i by unit forces at the interfaces
//! ```
//! The largest that this can be is told. It is first order, so no bound; tests compare it with the whole mesh.

use faer::{Mat, c64};

use dcb_superelement::LOSS_FACTOR;

use crate::bounds::{excess, multipliers};
use crate::closing::Closing;
use crate::measure::stiffness;
use crate::part::Part;
use crate::whole::Whole;

/// Frequencies of the band, evenly spaced.
const POINTS: usize = 60;
/// End of the band in parts of the parts' least eigenvalue bound: half the frequency.
const BELOW: f64 = 0.25;

/// The largest estimate over a band.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct ResponseEstimate {
    /// ‖δH‖ / ‖H‖ over all interface rows, each in units of its own flexibility, at a structural loss factor of 0.02.
    pub error: f64,
    /// ω² at which it is largest.
    pub at: f64,
    /// ω² at the end of the band.
    pub end: f64,
}

/// Modes of the whole, all of them, and what they do.
struct Modal {
    /// ω², zero for rigid and loose motions.
    squares: Vec<f64>,
    /// At the interface rows, (e, modes).
    seen: Mat<f64>,
    /// Forces on the rows of each part in each mode, (n_b, modes).
    forces: Vec<Mat<f64>>,
    /// Forces on the rows of each part by interface forces at rest, (n_b, e).
    direct: Vec<Mat<f64>>,
}

impl Modal {
    fn of(parts: &[Part], whole: &Whole, closing: &Closing) -> Self {
        let elastic = &whole.elastic * &whole.shapes;
        let (r, l) = (whole.rigid.ncols(), whole.loose.ncols());
        let count = r + l + whole.eigenvalues.len();
        let shapes = Mat::from_fn(elastic.nrows(), count, |i, k| {
            if k < r {
                whole.rigid[(i, k)]
            } else if k < r + l {
                whole.loose[(i, k - r)]
            } else {
                elastic[(i, k - r - l)]
            }
        });
        let still = std::iter::repeat_n(0.0, r + l);
        let squares: Vec<f64> = still.chain(whole.eigenvalues.iter().copied()).collect();
        let held = multipliers(closing, &stiffness(parts), &squares, &shapes);
        let e = closing.interfaces.nrows();
        let at_rest = closing.constraints.nrows();
        // Hᵀ μ = −Eᵀ f where nothing moves.
        let by_forces = match at_rest {
            0 => Mat::zeros(0, e),
            _ => -crate::bounds::least(
                &(&closing.constraints * closing.constraints.transpose()),
                &(&closing.constraints * closing.interfaces.transpose()),
            ),
        };
        let (none, still) = (Mat::zeros(e, count), Mat::zeros(shapes.nrows(), e));
        let unit = Mat::<f64>::identity(e, e);
        Self {
            seen: &closing.interfaces * &shapes,
            forces: (0..parts.len())
                .map(|i| {
                    closing.forces_on(i, &shapes, &none) + closing.constraint_forces_on(i, &held)
                })
                .collect(),
            direct: (0..parts.len())
                .map(|i| {
                    closing.forces_on(i, &still, &unit)
                        + closing.constraint_forces_on(i, &by_forces)
                })
                .collect(),
            squares,
        }
    }
}

/// The largest relative change of responses up to `end` (ω²), or as far as the parts' files tell.
pub(crate) fn estimate(
    parts: &[Part],
    whole: &Whole,
    closing: &Closing,
    end: f64,
    limit: f64,
) -> Option<ResponseEstimate> {
    let end = end.min(BELOW * limit);
    if !(end > 0.0 && end.is_finite()) || closing.interfaces.nrows() == 0 {
        return None;
    }
    let modal = Modal::of(parts, whole, closing);
    let first = modal
        .squares
        .iter()
        .copied()
        .find(|square| *square > 0.0)
        .unwrap_or(end);
    let rows = modal.seen.nrows();
    let scale: Vec<f64> = (0..rows)
        .map(|i| {
            let dynamic: f64 = (0..modal.squares.len())
                .map(|k| modal.seen[(i, k)].powi(2) / modal.squares[k].max(first))
                .sum();
            match dynamic + closing.flexible[(i, i)] {
                whole if whole > 0.0 => whole.sqrt().recip(),
                _ => 0.0,
            }
        })
        .collect();
    let mut largest = ResponseEstimate {
        error: 0.0,
        at: end,
        end,
    };
    for point in 1..=POINTS {
        let square = end * (point as f64 / POINTS as f64).powi(2);
        let lambda = c64::new(square, 0.0) / c64::new(1.0, LOSS_FACTOR);
        let weights: Vec<c64> = modal
            .squares
            .iter()
            .map(|own| c64::new(1.0, 0.0) / (c64::new(*own, 0.0) - lambda))
            .collect();
        let weighted = |left: &Mat<f64>, part: fn(&c64) -> f64| {
            Mat::from_fn(left.nrows(), left.ncols(), |i, k| {
                left[(i, k)] * part(&weights[k])
            }) * modal.seen.transpose()
        };
        let whole_response = [
            weighted(&modal.seen, |w| w.re) + &closing.flexible,
            weighted(&modal.seen, |w| w.im),
        ];
        let mut change = [Mat::<f64>::zeros(rows, rows), Mat::<f64>::zeros(rows, rows)];
        for (i, part) in parts.iter().enumerate() {
            let Some(excess) = part.flexible().and_then(|of| excess(of, square)) else {
                continue;
            };
            let real = weighted(&modal.forces[i], |w| w.re) + &modal.direct[i];
            let imaginary = weighted(&modal.forces[i], |w| w.im);
            let (of_real, of_imaginary) = (&excess * &real, &excess * &imaginary);
            change[0] += real.transpose() * &of_real - imaginary.transpose() * &of_imaginary;
            change[1] += real.transpose() * &of_imaginary + imaginary.transpose() * &of_real;
        }
        let norm = |of: &[Mat<f64>; 2]| -> f64 {
            let entries = (0..rows).flat_map(|i| (0..rows).map(move |j| (i, j)));
            entries
                .map(|(i, j)| {
                    (scale[i] * scale[j]).powi(2) * (of[0][(i, j)].powi(2) + of[1][(i, j)].powi(2))
                })
                .sum::<f64>()
                .sqrt()
        };
        let error = norm(&change) / norm(&whole_response);
        if error > largest.error {
            largest.error = error;
            largest.at = square;
        }
    }
    largest.error.is_finite().then_some(largest)
}
