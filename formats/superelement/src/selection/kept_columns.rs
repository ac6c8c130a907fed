//! Columns of a reduced basis: modes, rows and further columns that stay, as combinations of the whole's.

use dcb_formats::superelement::Superelement;
use faer::Mat;

use super::statics::Statics;

/// Columns that stay, by places in the whole.
pub(super) struct KeptColumns<'a> {
    pub turn: Option<&'a Mat<f64>>,
    pub modes: &'a [usize],
    pub left_out: &'a [usize],
    pub further: &'a [usize],
}

impl KeptColumns<'_> {
    /// S, (n of the whole, n).
    pub(super) fn columns(
        &self,
        whole: &Superelement,
        statics: &Statics,
        forces: &Mat<f64>,
    ) -> Mat<f64> {
        let (n_k, n_b) = (whole.mode_count(), whole.rows.len());
        let n = whole.basis_count();
        let (kept, attached) = (self.modes.len(), forces.ncols());
        let turn_of = |k: usize, mode: usize| match self.turn {
            Some(turn) => turn[(k, mode)],
            None => f64::from(u8::from(k == mode)),
        };
        let absorbed = &statics.absorbed * forces;
        let absorbed = match self.turn {
            Some(turn) => {
                Mat::from_fn(n_k, self.left_out.len(), |k, j| turn[(k, self.left_out[j])])
                    * absorbed
            }
            None => {
                let mut spread = Mat::zeros(n_k, attached);
                for (i, mode) in self.left_out.iter().enumerate() {
                    spread.row_mut(*mode).copy_from(absorbed.row(i));
                }
                spread
            }
        };
        Mat::from_fn(n, kept + attached + self.further.len(), |i, j| {
            if j < kept {
                if i < n_k {
                    turn_of(i, self.modes[j])
                } else {
                    0.0
                }
            } else if j < kept + attached {
                if i < n_k {
                    absorbed[(i, j - kept)]
                } else if i < n_k + n_b {
                    forces[(i - n_k, j - kept)]
                } else {
                    0.0
                }
            } else {
                f64::from(u8::from(i == n_k + n_b + self.further[j - kept - attached]))
            }
        })
    }
}
