//! Ceilings of a response's errors at all points of a band, from a few: most points can't have the largest error, and needn't be looked at.
//!
//! S, which is H without the kept modes, is analytic in ω² as far as the nearest σ² of a dynamic coordinate or the eigenvalue bound, and so is all that its error is
//! made of. Its norms are interpolated from Chebyshev points; the modes come in by products of their shapes, with w = 1 / (ω² - λ):
//!
//! ```text
//! ‖H‖² = ‖S‖² + 2 Re Σ w̄_p ⟨φ_p φ_pᵀ, S⟩ + Σ w_p w̄_q ⟨φ_p φ_pᵀ, φ_q φ_qᵀ⟩
//! ```
//! over the blocks of one kind. What these sums cancel, and what rounding in the interpolation does, the ceilings allow for.

use std::array::from_fn;
use std::iter::once;

use faer::{ColRef, Mat, c64};
use rayon::prelude::*;

use super::Bracket;
use super::blocks::{Blocks, InterfacePairs};
use super::deviation::{Deviations, ModeWeights, RestBetween, Shapes};
use super::interpolation::ChebyshevPoints;
use super::split::Split;
use crate::FrequencyBand;

/// So many points of a band for each one of interpolation, or it doesn't pay.
const POINTS_FOR_ONE: usize = 4;
/// Part of the terms of a sum that it may be off by cancelling.
const CANCELLED: f64 = 1e-10;
/// Part of a norm's largest square over the band that an interpolated square may be off.
const INTERPOLATED: f64 = 1e-12;
/// Rounding has corners, so that it isn't interpolated: between points it is below so many times that at any of them.
const ROUNDING_BETWEEN: f64 = 16.0;

/// By kind of pair ([`InterfacePairs`]).
type ByKind<T> = [T; 2];

/// At every point of a band, for each kind of response, what neither side of its error exceeds; `None` for a band of few points, or near a pole.
pub(super) fn ceilings(
    of: &Deviations<'_>,
    band: &FrequencyBand,
    loss_factor: f64,
) -> Option<Vec<ByKind<Bracket>>> {
    let damping = c64::new(1.0, loss_factor);
    let ends = [*band.squares.first()?, *band.squares.last()?];
    let (squares, _) = of.bounds.model.dynamic();
    // An infinite one is none.
    let poles = squares.iter().copied().filter(|square| *square > 0.0);
    let poles = poles
        .chain(once(of.bounds.eigenvalue_bound))
        .filter(|square| square.is_finite())
        .map(|square| square * damping);
    let most = band.squares.len() / POINTS_FOR_ONE;
    let points = ChebyshevPoints::for_poles(ends, poles, most)?;
    let norms = Norms::at(of, &points, damping);
    let modes = ModeProducts::of(of);
    let ceiling = |square: &f64| {
        let lambda = c64::new(*square, 0.0) / damping;
        norms.between(&points.shares(*square)).ceiling(
            &norms,
            &modes,
            of.rest_size(lambda),
            &of.mode_weights(lambda),
        )
    };
    Some(band.squares.par_iter().map(ceiling).collect())
}

/// What is interpolated, at one place.
struct Smooth {
    /// ‖known‖²
    known: ByKind<f64>,
    /// ‖S‖²
    apart: ByKind<f64>,
    /// ‖N_aa‖² for each interface, N the form that bounds the rest, without its size.
    own: Vec<f64>,
    /// ⟨φ_p φ_pᵀ, S⟩ for each kept mode.
    with_modes: ByKind<Vec<c64>>,
}

/// The same at the points of interpolation, and the largest of each norm.
struct Norms {
    at_points: Vec<Smooth>,
    most_known: ByKind<f64>,
    most_own: Vec<f64>,
    /// Bound of ‖rounding‖.
    rounding: ByKind<f64>,
    /// Pairs of interfaces that have a block.
    pairs: Vec<(usize, usize)>,
}

/// Products between the kept modes' parts of H, and of bounds of their errors, (poles, poles).
struct ModeProducts {
    motions: ByKind<Mat<f64>>,
    errors: ByKind<Mat<f64>>,
}

impl Norms {
    fn at(of: &Deviations<'_>, points: &ChebyshevPoints, damping: c64) -> Self {
        let interface = &of.bounds.rows.interface;
        let found: Vec<(Smooth, Blocks)> = points
            .places
            .par_iter()
            .map(|square| {
                let lambda = c64::new(*square, 0.0) / damping;
                let mut deviation = of.without_modes(lambda, RestBetween::RowsOfAnInterface);
                let blocks = Blocks::of(&deviation, interface, &of.rows, &of.forced);
                deviation.reduced.add(1.0, &deviation.known);
                let size = of.rest_size(lambda);
                let of_size_one = |square: &f64| match size > 0.0 {
                    true => square / (size * size),
                    false => 0.0,
                };
                let smooth = Smooth {
                    known: blocks.known,
                    apart: blocks.whole,
                    own: blocks.own.iter().map(of_size_one).collect(),
                    with_modes: with_modes(of, &deviation.reduced),
                };
                (smooth, blocks)
            })
            .collect();
        let largest =
            |of: &dyn Fn(&(Smooth, Blocks)) -> f64| found.iter().map(of).fold(0.0, f64::max);
        let rounding = |blocks: &Blocks, kind: usize| -> f64 {
            let pairs = blocks.rounding.iter();
            let of_kind = pairs.filter(|(a, b, _)| InterfacePairs::of(*a, *b) as usize == kind);
            of_kind.map(|(_, _, square)| square).sum::<f64>().sqrt()
        };
        let interfaces = found.first().map_or(0, |(smooth, _)| smooth.own.len());
        Self {
            most_known: from_fn(|kind| largest(&|(smooth, _)| smooth.known[kind])),
            most_own: (0..interfaces)
                .map(|a| largest(&|(smooth, _)| smooth.own[a]))
                .collect(),
            rounding: from_fn(|kind| {
                ROUNDING_BETWEEN * largest(&|(_, blocks)| rounding(blocks, kind))
            }),
            pairs: (found.first().iter())
                .flat_map(|(_, blocks)| blocks.rounding.iter().map(|(a, b, _)| (*a, *b)))
                .collect(),
            at_points: found.into_iter().map(|(smooth, _)| smooth).collect(),
        }
    }

    /// Interpolated.
    fn between(&self, shares: &[f64]) -> Smooth {
        let sum = |of: &dyn Fn(&Smooth) -> f64| -> f64 {
            let terms = self.at_points.iter().zip(shares);
            terms.map(|(smooth, share)| share * of(smooth)).sum()
        };
        let first = &self.at_points[0];
        Smooth {
            known: from_fn(|kind| sum(&|smooth| smooth.known[kind])),
            apart: from_fn(|kind| sum(&|smooth| smooth.apart[kind])),
            own: (0..first.own.len())
                .map(|a| sum(&|smooth| smooth.own[a]))
                .collect(),
            with_modes: from_fn(|kind| {
                let parts = 0..first.with_modes[kind].len();
                let part = |p: usize| {
                    c64::new(
                        sum(&|smooth| smooth.with_modes[kind][p].re),
                        sum(&|smooth| smooth.with_modes[kind][p].im),
                    )
                };
                parts.map(part).collect()
            }),
        }
    }
}

impl Smooth {
    fn ceiling(
        &self,
        norms: &Norms,
        modes: &ModeProducts,
        rest_size: f64,
        weights: &ModeWeights,
    ) -> ByKind<Bracket> {
        let (mut least_rest, mut most_rest) = ([0.0; 2], [0.0; 2]);
        for (a, b) in &norms.pairs {
            let kind = InterfacePairs::of(*a, *b) as usize;
            let end = |place: usize, sign: f64| {
                (self.own[place] + sign * INTERPOLATED * norms.most_own[place]).max(0.0)
            };
            least_rest[kind] += end(*a, -1.0).sqrt() * end(*b, -1.0).sqrt();
            most_rest[kind] += end(*a, 1.0).sqrt() * end(*b, 1.0).sqrt();
        }
        from_fn(|kind| {
            let known = self.known[kind] + INTERPOLATED * norms.most_known[kind];
            let known = known.max(0.0).sqrt();
            let whole = self.least_whole(kind, weights, modes);
            let of_modes = form(&modes.errors[kind], &weights.errors).sqrt();
            let margin = rest_size * most_rest[kind].sqrt() + norms.rounding[kind] + of_modes;
            if known + whole + margin == 0.0 {
                // No pair of this kind.
                return Bracket::ZERO;
            }
            let rest = rest_size * least_rest[kind].sqrt();
            let allowed = 1.0 + CANCELLED;
            Bracket {
                lower: allowed * (known - rest).max(0.0) / (whole + rest),
                upper: match whole > margin {
                    true => allowed * (known + margin) / (whole - margin),
                    false => f64::INFINITY,
                },
            }
        })
    }

    /// ‖H‖ isn't below this.
    fn least_whole(&self, kind: usize, weights: &ModeWeights, modes: &ModeProducts) -> f64 {
        let of = |part: fn(&c64) -> f64| -> Vec<f64> { weights.motions.iter().map(part).collect() };
        let among_modes =
            [of(|w| w.re), of(|w| w.im)].map(|part| form(&modes.motions[kind], &part));
        let sizes = form(&modes.errors[kind], &of(|w| w.norm()));
        let pairs = weights.motions.iter().zip(&self.with_modes[kind]);
        let (mut sum, mut size) = (0.0, 0.0);
        for (w, part) in pairs {
            let term = 2.0 * (w.conj() * part).re;
            sum += term;
            size += term.abs();
        }
        let apart = self.apart[kind];
        let square = apart + sum + among_modes[0] + among_modes[1];
        (square - CANCELLED * (apart.abs() + size + sizes))
            .max(0.0)
            .sqrt()
    }
}

impl ModeProducts {
    fn of(of: &Deviations<'_>) -> Self {
        let shapes = &of.shapes;
        Self {
            motions: products(of, &shapes.rows, &shapes.forced),
            errors: products(of, &shapes.row_sizes, &shapes.forced_sizes),
        }
    }
}

/// ⟨φ_p φ_pᵀ, φ_q φ_qᵀ⟩ over the blocks of each kind: for a pair of interfaces the product of what its rows and its forces give.
fn products(of: &Deviations<'_>, rows: &Mat<f64>, forced: &Mat<f64>) -> ByKind<Mat<f64>> {
    let count = forced.nrows();
    let zero = || Mat::<f64>::zeros(count, count);
    let (mut collocated, mut transfer) = (zero(), zero());
    let (mut rows_before, mut forces_before) = (zero(), zero());
    let add = |sum: &mut Mat<f64>, a: &Mat<f64>, b: &Mat<f64>| {
        *sum += Mat::from_fn(count, count, |p, q| a[(p, q)] * b[(p, q)]);
    };
    for (a, places) in of.interfaces.iter().enumerate() {
        let own = of_rows(rows, places);
        let of_rows = own.transpose() * &own;
        let columns = of.columns_of(a);
        let own = Mat::from_fn(count, columns.len(), |p, j| forced[(p, columns[j])]);
        let of_forces = &own * own.transpose();
        add(&mut collocated, &of_rows, &of_forces);
        add(&mut transfer, &of_rows, &forces_before);
        add(&mut transfer, &rows_before, &of_forces);
        rows_before += of_rows;
        forces_before += of_forces;
    }
    [collocated, transfer]
}

/// ⟨φ_p φ_pᵀ, S⟩ over the blocks of each kind.
fn with_modes(of: &Deviations<'_>, s: &Split) -> ByKind<Vec<c64>> {
    let Shapes { rows, forced, .. } = &of.shapes;
    let mut sums = from_fn(|_| vec![c64::new(0.0, 0.0); forced.nrows()]);
    for (a, places) in of.interfaces.iter().enumerate() {
        let own = of_rows(rows, places);
        let along = [&s.re, &s.im].map(|part| own.transpose() * of_rows(part, places));
        for (j, force) in of.forced.iter().enumerate() {
            let kind = InterfacePairs::of(a, of.bounds.rows.interface[*force]);
            let sums: &mut Vec<c64> = &mut sums[kind as usize];
            for (p, sum) in sums.iter_mut().enumerate() {
                *sum += c64::new(along[0][(p, j)], along[1][(p, j)]) * forced[(p, j)];
            }
        }
    }
    sums
}

fn of_rows(of: &Mat<f64>, places: &[usize]) -> Mat<f64> {
    Mat::from_fn(places.len(), of.ncols(), |i, j| of[(places[i], j)])
}

/// wᵀ A w
fn form(matrix: &Mat<f64>, weights: &[f64]) -> f64 {
    let weights = ColRef::from_slice(weights);
    weights.transpose() * (matrix * weights)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use dcb_formats::scene::Compatibility;

    use super::super::ErrorBounds;
    use super::*;
    use crate::LOSS_FACTOR;

    fn ceilings_are_above_errors_and_close(part: &str, form: Compatibility) {
        let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../samples/gallery/parts");
        let file = std::path::Path::new(folder).join(part);
        let part = dcb_formats::dcb::read_superelement(&file).unwrap();
        let bounds = ErrorBounds::of(&part, form).unwrap().unwrap();
        let band = bounds.usual_band(200).unwrap();
        let rows = bounds.attached_rows();
        let deviations = bounds.deviations(&rows, &rows);
        let ceilings = ceilings(&deviations, &band, LOSS_FACTOR).unwrap();
        for (lambda, ceiling) in band.damped(LOSS_FACTOR).zip(&ceilings) {
            let found = deviations.at(lambda, RestBetween::RowsOfAnInterface);
            let blocks = Blocks::of(&found, &bounds.rows.interface, &rows, &rows);
            for (exact, ceiling) in blocks.errors().iter().zip(ceiling) {
                let allowed = 1e-3 * exact.upper + 1e-6;
                for (exact, ceiling) in [(exact.upper, ceiling.upper), (exact.lower, ceiling.lower)]
                {
                    let what = format!("{} {form:?} {lambda}", part.name);
                    assert!(exact <= ceiling, "{what}: {exact:e} {ceiling:e}");
                    assert!(ceiling <= exact + allowed, "{what}: {exact:e} {ceiling:e}");
                }
            }
        }
    }

    #[test]
    fn ceilings_are_above_the_errors_and_close_to_them() {
        for part in ["engine-rod.dcb.h5", "scissor-bar.dcb.h5"] {
            for form in [Compatibility::Strong, Compatibility::Static] {
                ceilings_are_above_errors_and_close(part, form);
            }
        }
    }
}
