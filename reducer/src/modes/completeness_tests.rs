//! What a random start proves, against matrices whose eigenvectors are known.
#![allow(clippy::unwrap_used)]

use faer::{Mat, MatRef};
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::SeedableRng;

use crate::modes::completeness::{Cell, KrylovSpace, smallest_singular_value};

fn normal(rows: usize, columns: usize, random: &mut Pcg64) -> Mat<f64> {
    Mat::from_fn(rows, columns, |_, _| StandardNormal.sample(random))
}

/// Block Lanczos of a diagonal S, M and D the identity.
struct Run {
    /// The start block over the eigenvectors.
    shares: Mat<f64>,
    values: Vec<f64>,
    start: Mat<f64>,
    leaving: Mat<f64>,
}

impl Run {
    fn new(spectrum: &[f64], block: usize, steps: usize, random: &mut Pcg64) -> Self {
        let times =
            |x: MatRef<'_, f64>| Mat::from_fn(x.nrows(), x.ncols(), |i, j| spectrum[i] * x[(i, j)]);
        let shares = times(normal(spectrum.len(), block, random).as_ref());
        let mut basis = Mat::<f64>::zeros(spectrum.len(), 0);
        let (mut next, first) = orthonormal(shares.clone(), &basis);
        let mut coupling = first.clone();
        for _ in 0..steps {
            basis = faer::concat![[basis, next]];
            (next, coupling) = orthonormal(times(next.as_ref()), &basis);
        }
        let projected = basis.transpose() * times(basis.as_ref());
        let (theta, vectors) = dcb_dense::symmetric_eigen(projected.as_ref()).unwrap();
        let size = theta.len();
        let vectors = Mat::from_fn(size, size, |i, j| vectors[(i, size - 1 - j)]);
        Self {
            shares,
            values: theta.into_iter().rev().collect(),
            start: first.transpose() * vectors.as_ref().subrows(0, block),
            leaving: &coupling * vectors.as_ref().subrows(size - block, block),
        }
    }

    fn space(&self, chance: f64) -> KrylovSpace<'_> {
        KrylovSpace {
            values: &self.values,
            start: self.start.as_ref(),
            leaving: self.leaving.as_ref(),
            chance,
            mass_part: 1.0,
            rounding: 0.0,
        }
    }
}

/// What is left of a block without a basis, made orthonormal, and the block over that.
fn orthonormal(mut block: Mat<f64>, basis: &Mat<f64>) -> (Mat<f64>, Mat<f64>) {
    for _ in 0..2 {
        let amounts = basis.transpose() * &block;
        block -= basis * amounts;
    }
    let qr = block.qr();
    (qr.compute_thin_Q(), qr.thin_R().to_owned())
}

/// λ of bars and cubes, roughly: 1/θ of the lowest ones is 1, 4, 9, …
fn spectrum(count: usize) -> Vec<f64> {
    (1..=count).map(|k| 1.0 / (k * k) as f64).collect()
}

#[test]
fn normal_matrices_are_rarely_below_their_smallest_singular_value() {
    let mut random = Pcg64::seed_from_u64(1);
    for (rows, columns) in [(8, 1), (8, 2), (8, 5), (3, 3), (1, 1), (16, 8)] {
        for chance in [0.2, 0.02] {
            let limit = smallest_singular_value(rows, columns, chance);
            let trials = 20_000;
            let below = (0..trials)
                .filter(|_| {
                    let matrix = normal(rows, columns, &mut random);
                    let values = matrix.singular_values().unwrap();
                    values.iter().copied().fold(f64::INFINITY, f64::min) < limit
                })
                .count();
            let found = below as f64 / f64::from(trials);
            let scatter = 4.0 * (chance / f64::from(trials)).sqrt();
            println!("{rows} x {columns}: {found:.4} below {limit:.4}, {chance} allowed");
            assert!(
                found < chance + scatter,
                "{rows} {columns} {found} {chance}"
            );
            // The bound is close enough to be of use.
            assert!(
                found > 0.1 * chance - scatter,
                "{rows} {columns} {found} {chance}"
            );
        }
    }
}

/// The largest eigenvalues are above all Ritz values. What the space says of their shares in the start holds, and not by much more than it must.
#[test]
fn shares_of_eigenvectors_beyond_the_ritz_values_are_bounded() {
    let mut random = Pcg64::seed_from_u64(2);
    let spectrum: Vec<f64> = (1..=60).map(|k| 1.0 / f64::from(k)).collect();
    let mut tightest = 0.0_f64;
    for (block, steps) in [(1, 3), (2, 3), (3, 2), (3, 3), (4, 2)] {
        for _ in 0..20 {
            let run = Run::new(&spectrum, block, steps, &mut random);
            let pole = run.values[0];
            let (theta, share) = (spectrum[0], run.shares.row(0).norm_l2());
            assert!(pole < theta);
            let reach = theta - pole;
            let half = reach / 17.0;
            let cell = Cell {
                centre: theta,
                half,
                low: theta - half,
            };
            let bound = run.space(1e-12).series(&cell, 0);
            assert!(
                share <= bound * (1.0 + 1e-6),
                "{block} {steps}: {share:e} {bound:e}"
            );
            tightest = tightest.max(share / bound);
        }
    }
    assert!(tightest > 0.1, "{tightest}");
}

/// With a chance of one in twenty, wrong answers are rarer than that; right ones come.
#[test]
fn wrong_proofs_are_as_rare_as_they_are_said_to_be() {
    let mut random = Pcg64::seed_from_u64(3);
    let chance = 0.05;
    let mut spectrum = spectrum(80);
    // Two close pairs, a double and a triple root.
    spectrum[3] = spectrum[2] * 0.9999;
    spectrum[6] = spectrum[5] * 0.98;
    spectrum[9] = spectrum[8];
    spectrum[12] = spectrum[11];
    spectrum[13] = spectrum[11];
    let (mut right, mut wrong, mut runs) = (0, 0, 0);
    for block in [1, 2, 3, 4] {
        for steps in 2..=(48 / block) {
            for _ in 0..4 {
                runs += 1;
                let run = Run::new(&spectrum, block, steps, &mut random);
                for found in 1..run.values.len().min(16) {
                    let [above, below] = [run.values[found - 1], run.values[found]];
                    let limit = below + 0.5 * (above - below);
                    if run.space(chance).has_all(found, limit) {
                        let there = spectrum.iter().filter(|theta| **theta > limit).count();
                        match there == found {
                            true => right += 1,
                            false => wrong += 1,
                        }
                    }
                }
            }
        }
    }
    println!("{right} proofs right, {wrong} wrong in {runs} runs");
    assert!(right > 1000, "{right}");
    assert!(
        f64::from(wrong) <= chance * f64::from(runs),
        "{wrong} of {runs}"
    );
}

/// A block of four finds four copies of a root and can't say that there is no fifth; of two it can.
#[test]
fn copies_of_a_root_are_proven_up_to_the_width_of_the_block() {
    let mut random = Pcg64::seed_from_u64(4);
    for (copies, is_proven) in [(1, true), (2, true), (4, false), (5, false)] {
        let mut spectrum = spectrum(60);
        for copy in 1..copies {
            spectrum[4 + copy] = spectrum[4];
        }
        let run = Run::new(&spectrum, 4, 8, &mut random);
        let seen = copies.min(4);
        let found = 4 + seen;
        let [last, next] = [run.values[found - 1], run.values[found]];
        assert!((last / spectrum[4] - 1.0).abs() < 1e-9 && next < 0.999 * last);
        let limit = 0.5 * (last + next);
        let has_all = run.space(1e-9).has_all(found, limit);
        assert_eq!(has_all, is_proven, "{copies} copies");
        // No answer for a limit that isn't between what was found and the rest.
        assert!(!run.space(1e-9).has_all(found - 1, limit));
        assert!(!run.space(1e-9).has_all(found + 1, limit));
    }
}

/// A limit between two values that are nearly one is proven by the gap below both, steps before its own gap would do.
#[test]
fn a_narrow_gap_at_the_limit_is_proven_by_the_next_one() {
    let mut random = Pcg64::seed_from_u64(5);
    let mut spectrum = spectrum(80);
    let found = 6;
    spectrum[found] = spectrum[found - 1] * (1.0 - 2e-5);
    let limit = spectrum[found - 1] * (1.0 - 1e-5);
    let mut earlier = 0;
    for steps in 4..14 {
        let run = Run::new(&spectrum, 4, steps, &mut random);
        let space = run.space(1e-9);
        let by_its_own = space.has_all_from(found, limit, &space.allowed(found + 2));
        let proven = space.has_all(found, limit);
        assert!(proven || !by_its_own);
        earlier += usize::from(proven && !by_its_own);
        // Not where the next one is above the limit, however little.
        assert!(!space.has_all(found, spectrum[found] * (1.0 - 1e-9)));
    }
    assert!(earlier > 0);
}
