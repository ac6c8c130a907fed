//! What the parts' omitted motions add to the power moments of the whole.
//!
//! In a part, the response t of its omitted motions to the inertia of the static shapes has a part t⊥ that its attachments don't have. It moves no interface, so that
//! the rest of the assembly doesn't feel it: the moments of the whole are those over the parts' coordinates and, with the amounts γ of the attachments in the
//! static shapes and α in the responses over the coordinates,
//!
//! ```text
//! M_3 += γᵀ X γ                    X = M_3 − M_2 M_1⁺ M_2
//! M_4 += αᵀ X γ + γᵀ X α + γᵀ Y γ      Y = M_4 − M_3 M_1⁺ M_2 − M_2 M_1⁺ M_3 + M_2 M_1⁺ M_2 M_1⁺ M_2
//! ```
//! of the part's moments without shift: M_3 + σ M_4 of those in the file.

use dcb_dense::{symmetric_eigen, symmetrized};
use dcb_formats::superelement::Moments;
use faer::{Mat, Scale};

use crate::inertia::PartColumns;
use crate::part::{Flexible, Part};

/// Directions of M_1 below this, in units of the rows' flexibility, are rounding.
const DEPENDENT: f64 = 1e-10;

/// X and Y of one part, (n_b + n_x, n_b + n_x).
struct Beyond {
    mixed: Mat<f64>,
    own: Mat<f64>,
}

impl Beyond {
    /// `None` if a dense eigenproblem fails.
    fn of(moments: &Moments) -> Option<Self> {
        let n = moments.first.nrows();
        let scale: Vec<f64> = (0..n)
            .map(|i| match moments.first[(i, i)] {
                positive if positive > 0.0 => positive.sqrt().recip(),
                _ => 0.0,
            })
            .collect();
        let scaled = |of: &Mat<f64>| Mat::from_fn(n, n, |i, j| scale[i] * of[(i, j)] * scale[j]);
        let first = symmetrized(scaled(&moments.first));
        let (second, fourth) = (scaled(&moments.second), scaled(&moments.fourth));
        let third = scaled(&moments.third) + &fourth * Scale(moments.shift);
        let (values, vectors) = symmetric_eigen(first.as_ref())?;
        let kept: Vec<usize> = (0..n).filter(|k| values[*k] > DEPENDENT).collect();
        let root = Mat::from_fn(n, kept.len(), |i, k| {
            vectors[(i, kept[k])] / values[kept[k]].sqrt()
        });
        // M_1⁺ = root rootᵀ
        let seen = root.transpose() * &second;
        let mixed = &third - seen.transpose() * &seen;
        let next = root.transpose() * &third;
        let middle = root.transpose() * &second * &root;
        let cross = next.transpose() * &seen;
        let own = &fourth - &cross - cross.transpose() + seen.transpose() * (middle * &seen);
        let back = |of: Mat<f64>| {
            let of = symmetrized(of);
            Mat::from_fn(n, n, |i, j| match scale[i] * scale[j] {
                0.0 => 0.0,
                both => of[(i, j)] / both,
            })
        };
        Some(Self {
            mixed: back(mixed),
            own: back(own),
        })
    }
}

/// Whether a part's attachments are all that its moments speak of: none was left out by an interface reduction or a selection.
pub(crate) fn has_all_attachments(part: &Part) -> bool {
    part.flexible().is_none_or(|of| {
        let derivation = of.element.derivation.as_ref();
        let directions = derivation.and_then(|of| of.interface_directions);
        of.element.selections().is_empty() && !directions.is_some_and(|of| of.leave_out())
    })
}

/// What M_3 and M_4 of the whole gain; `statics` and `next` are its static shapes and the responses to their inertia in each part. `None` if a dense
/// eigenproblem fails or a part has no moments.
pub(crate) fn added(
    parts: &[Part],
    statics: &[PartColumns],
    next: &[PartColumns],
) -> Option<[Mat<f64>; 2]> {
    let count = statics.first().map_or(0, |of| of.rigid.ncols());
    let mut third = Mat::<f64>::zeros(count, count);
    let mut fourth = Mat::<f64>::zeros(count, count);
    for (i, part) in parts.iter().enumerate() {
        let Some(flexible) = part.flexible() else {
            continue;
        };
        let beyond = Beyond::of(flexible.element.moments.as_ref()?)?;
        let amounts = |of: &PartColumns| amounts(flexible, &of.deformation);
        let (gamma, alpha) = (amounts(&statics[i]), amounts(&next[i]));
        let mixed = &beyond.mixed * &gamma;
        third += gamma.transpose() * &mixed;
        let cross = alpha.transpose() * &mixed;
        fourth += &cross + cross.transpose() + gamma.transpose() * (&beyond.own * &gamma);
    }
    Some([symmetrized(third), symmetrized(fourth)])
}

/// Amplitudes of attachments and further columns.
fn amounts(flexible: &Flexible, deformation: &Mat<f64>) -> Mat<f64> {
    let n_k = flexible.element.mode_count();
    deformation
        .subrows(n_k, deformation.nrows() - n_k)
        .to_owned()
}
