//! Static flexibility of the interfaces beyond the modes that stay.

use dcb_dense::symmetrized;
use dcb_formats::component::Role;
use dcb_formats::superelement::Superelement;
use faer::{Mat, MatRef};

/// Flexibilities below this fraction of the largest of their kind, of forces or of moments, are rounding: what is left of a direction that an earlier
/// selection didn't load.
const ROUNDING: f64 = 1e-12;

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
    /// With all modes kept.
    pub fn with_all_modes(whole: &Superelement) -> Self {
        let shapes = whole.modes.interface_shapes.as_ref();
        Self::of(whole, shapes, &[], acting(whole, shapes))
    }

    /// `shapes` is L_b Φ, (n_b, n_k); `acting` says which rows take over what the modes left out do.
    pub fn of(
        whole: &Superelement,
        shapes: MatRef<'_, f64>,
        left_out: &[usize],
        acting: Vec<bool>,
    ) -> Self {
        let residual = &whole.residual;
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

/// Rows that have columns: those of attachments that feel any elastic motion.
pub(super) fn attached(whole: &Superelement) -> Vec<bool> {
    let rows = whole.rows.iter().zip(&whole.residual.mass_diagonal0);
    rows.map(|(row, mass)| whole.interfaces[row.interface].role == Role::Attachment && *mass > 0.0)
        .collect()
}

/// Those of them along which a force deflects the component by more than rounding.
pub(super) fn acting(whole: &Superelement, shapes: MatRef<'_, f64>) -> Vec<bool> {
    let flexibility = |row: usize| {
        let modes = whole.modes.eigenvalues.iter().enumerate();
        let of_modes = modes.filter(|(_, value)| **value > 0.0);
        let of_modes = of_modes.map(|(k, value)| shapes[(row, k)].powi(2) / value);
        whole.residual.flexibility[(row, row)] + of_modes.sum::<f64>()
    };
    let flexibilities: Vec<f64> = (0..whole.rows.len()).map(flexibility).collect();
    let is_force = |row: usize| (0..3).contains(&whole.rows[row].direction);
    let attached = attached(whole);
    let largest = [false, true].map(|force| {
        let own = (0..attached.len()).filter(|row| attached[*row] && is_force(*row) == force);
        own.fold(0.0, |most: f64, row| most.max(flexibilities[row]))
    });
    (0..attached.len())
        .map(|row| {
            let least = ROUNDING * largest[usize::from(is_force(row))];
            attached[row] && flexibilities[row] > least
        })
        .collect()
}
