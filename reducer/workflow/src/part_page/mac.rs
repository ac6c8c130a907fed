//! How alike the modes look: the modal assurance criterion over the translations of the file's nodes.
//!
//! ```text
//! MAC_ij  =  (φ_iᵀ φ_j)² / (φ_iᵀ φ_i · φ_jᵀ φ_j)
//! ```
//!
//! Modes are orthogonal over the mass, not over the nodes alone: unlike modes have small values here, not zeros. Large ones off the
//! diagonal mean that the nodes don't tell two modes apart.

use std::fmt::Write as _;

use dcb_formats::{RecoveryBasis, Superelement};
use faer::Mat;

/// Modes that are shown, at most.
const MOST: usize = 60;
/// Side of a square of the picture.
const SIDE: usize = 14;

/// A picture, and the largest value off the diagonal with its modes.
pub struct Likeness {
    pub svg: String,
    pub largest: Option<(f64, usize, usize)>,
}

pub fn picture(element: &Superelement, fields: &RecoveryBasis) -> Likeness {
    let count = element.mode_count().min(MOST);
    let values = likeness(fields, count);
    let mut largest: Option<(f64, usize, usize)> = None;
    for i in 0..count {
        for j in 0..i {
            if largest.is_none_or(|(value, ..)| values[(i, j)] > value) {
                largest = Some((values[(i, j)], j, i));
            }
        }
    }
    let margin = 30;
    let side = margin + SIDE * count + 4;
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {side} {side}\" width=\"{side}\" role=\"img\" aria-label=\"Modal assurance criterion between {count} modes\">"
    );
    for i in 0..count {
        for j in 0..count {
            let value = values[(i, j)];
            // From pale to dark blue.
            let [r, g, b] = [(243.0, 22.0), (246.0, 62.0), (250.0, 122.0)]
                .map(|(pale, dark): (f64, f64)| (pale + (dark - pale) * value).round() as u8);
            let _ = write!(
                svg,
                "<rect x=\"{}\" y=\"{}\" width=\"{SIDE}\" height=\"{SIDE}\" fill=\"rgb({r},{g},{b})\"><title>modes {} and {}: {value:.3}</title></rect>",
                margin + SIDE * j,
                margin + SIDE * i,
                i + 1,
                j + 1,
            );
        }
        if i % 5 == 4 || i == 0 {
            let middle = margin + SIDE * i + SIDE / 2;
            let _ = write!(
                svg,
                "<text x=\"{}\" y=\"{}\" font-size=\"10\" text-anchor=\"end\" fill=\"currentColor\" font-family=\"sans-serif\">{}</text><text x=\"{middle}\" y=\"{}\" font-size=\"10\" text-anchor=\"middle\" fill=\"currentColor\" font-family=\"sans-serif\">{}</text>",
                margin - 5,
                middle + 4,
                i + 1,
                margin - 6,
                i + 1
            );
        }
    }
    svg += "</svg>";
    Likeness { svg, largest }
}

fn likeness(fields: &RecoveryBasis, count: usize) -> Mat<f64> {
    let rows: Vec<usize> = (0..fields.dofs.len())
        .filter(|row| !fields.dofs[*row].direction.is_rotation())
        .collect();
    let shapes = Mat::from_fn(rows.len(), count, |i, j| fields.modes[(rows[i], j)]);
    let products = shapes.transpose() * &shapes;
    Mat::from_fn(count, count, |i, j| {
        let norms = products[(i, i)] * products[(j, j)];
        match norms > 0.0 {
            true => (products[(i, j)].powi(2) / norms).min(1.0),
            false => 0.0,
        }
    })
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use dcb_formats::mesh::{Direction, Dof};

    #[test]
    fn alike_modes_have_one_and_perpendicular_ones_zero() {
        let direction = |index| Direction::from_index(index).unwrap();
        let fields = RecoveryBasis {
            dofs: [(0, 0), (0, 1), (1, 0), (0, 5)]
                .map(|(node, index)| Dof {
                    node,
                    direction: direction(index),
                })
                .to_vec(),
            // The rotation in the last row must not count.
            modes: Mat::from_fn(4, 3, |i, j| {
                [
                    [1.0, 2.0, 0.0],
                    [2.0, 4.0, 1.0],
                    [0.0, 0.0, 3.0],
                    [7.0, -9.0, 5.0],
                ][i][j]
            }),
            residual: Mat::zeros(4, 0),
            enrichment: None,
        };
        let values = likeness(&fields, 3);
        assert!((values[(0, 1)] - 1.0).abs() < 1e-15);
        assert!((values[(0, 2)] - 4.0 / (5.0 * 10.0)).abs() < 1e-15);
    }
}
