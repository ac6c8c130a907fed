//! What the interfaces feel statically beside the modes that stay.

use dcb_formats::component::Role;
use dcb_formats::superelement::Superelement;
use faer::{Mat, MatRef};

/// Matrices over all rows of a superelement, (n_b, n_b), with some of its modes absorbed in the attachments.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Statics {
    /// Rows that act and feel elastic motion.
    pub acting: Vec<bool>,
    /// W = Ω⁻² Cᵀ, (modes left out, n_b); zero for motions without stiffness.
    pub absorbed: Mat<f64>,
    /// L_b X, with the rows of output interfaces.
    pub seen: Mat<f64>,
    /// F_res, symmetric.
    pub flexibility: Mat<f64>,
    /// M_res, symmetric.
    pub mass: Mat<f64>,
    /// F_res with no mode kept.
    pub flexibility0: Mat<f64>,
    /// M_res with no mode kept.
    pub mass0: Mat<f64>,
}

impl Statics {
    /// `shapes` is L_b Φ, (n_b, n_k).
    pub fn of(whole: &Superelement, shapes: MatRef<'_, f64>, left_out: &[usize]) -> Self {
        let residual = &whole.residual;
        let acting: Vec<bool> = (whole.rows.iter().zip(&residual.mass_diagonal0))
            .map(|(row, mass)| {
                whole.interfaces[row.interface].role == Role::Attachment && *mass > 0.0
            })
            .collect();
        let eigenvalues = &whole.modes.eigenvalues;
        let responses = |modes: &[usize]| {
            Mat::from_fn(modes.len(), acting.len(), |i, row| {
                match acting[row] && eigenvalues[modes[i]] > 0.0 {
                    true => shapes[(row, modes[i])] / eigenvalues[modes[i]],
                    false => 0.0,
                }
            })
        };
        let columns = |modes: &[usize]| {
            Mat::from_fn(acting.len(), modes.len(), |row, j| shapes[(row, modes[j])])
        };
        // Only acting rows belong to F_res; the columns of others are zero in W.
        let flexibility = |added: &Mat<f64>| {
            symmetrized(Mat::from_fn(acting.len(), acting.len(), |i, j| {
                residual.flexibility[(i, j)] + if acting[i] { added[(i, j)] } else { 0.0 }
            }))
        };
        let mass =
            |absorbed: &Mat<f64>| symmetrized(&residual.mass + absorbed.transpose() * absorbed);
        let absorbed = responses(left_out);
        let added = columns(left_out) * &absorbed;
        let every: Vec<usize> = (0..eigenvalues.len()).collect();
        let all = responses(&every);
        Self {
            seen: residual
                .output_shapes
                .as_ref()
                .unwrap_or(&residual.flexibility)
                + &added,
            flexibility: flexibility(&added),
            mass: mass(&absorbed),
            flexibility0: flexibility(&(shapes * &all)),
            mass0: mass(&all),
            acting,
            absorbed,
        }
    }
}

/// ½ (A + Aᵀ).
pub(super) fn symmetrized(matrix: Mat<f64>) -> Mat<f64> {
    Mat::from_fn(matrix.nrows(), matrix.ncols(), |i, j| {
        0.5 * (matrix[(i, j)] + matrix[(j, i)])
    })
}
