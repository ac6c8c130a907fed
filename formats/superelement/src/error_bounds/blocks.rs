//! Responses between interfaces, block by block: their errors as norms over many blocks.

use std::ops::Range;

use faer::Mat;

use super::deviation::Deviation;
use super::{Bracket, bracket};

/// Pairs of interfaces that a response counts for.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum InterfacePairs {
    /// An interface with itself.
    Collocated,
    /// Two different interfaces.
    Transfer,
}

/// Squares of Frobenius norms over the blocks of interfaces.
pub(super) struct Blocks {
    known: [f64; 2],
    whole: [f64; 2],
    margin: [f64; 2],
}

impl Blocks {
    pub(super) fn of(
        found: &Deviation,
        interface: &[usize],
        rows: &[usize],
        forced: &[usize],
    ) -> Self {
        let count = interface.iter().max().map_or(0, |most| most + 1);
        let of_row = |i: usize| interface[rows[i]];
        // ‖N_aa‖ for each interface.
        let mut own = vec![0.0_f64; count];
        for j in 0..rows.len() {
            for i in (0..rows.len()).filter(|i| of_row(*i) == of_row(j)) {
                own[of_row(j)] += found.rest[(i, j)].norm_sqr();
            }
        }
        let mut rounding = Mat::<f64>::zeros(count, count);
        let mut present = Mat::<f64>::zeros(count, count);
        let (mut known_sum, mut whole_sum) = ([0.0; 2], [0.0; 2]);
        // Rows of one interface that stand together.
        let mut runs: Vec<(usize, Range<usize>)> = Vec::new();
        for i in 0..rows.len() {
            match runs.last_mut().filter(|(of, _)| *of == of_row(i)) {
                Some((_, run)) => run.end = i + 1,
                None => runs.push((of_row(i), i..i + 1)),
            }
        }
        for (j, column) in forced.iter().enumerate() {
            let b = interface[*column];
            let (known, reduced) = (found.known.column(j), found.reduced.column(j));
            let (of_sums, of_modes) = (
                found.rounding.col_as_slice(j),
                found.of_modes.col_as_slice(j),
            );
            for (a, run) in &runs {
                let (mut of_known, mut of_whole, mut of_rounding) = (0.0, 0.0, 0.0);
                for i in run.clone() {
                    let (re, im) = (known.0[i], known.1[i]);
                    of_known += re * re + im * im;
                    let (re, im) = (re + reduced.0[i], im + reduced.1[i]);
                    of_whole += re * re + im * im;
                    of_rounding += (of_sums[i] + of_modes[i]).powi(2);
                }
                let kind = usize::from(*a != b);
                known_sum[kind] += of_known;
                whole_sum[kind] += of_whole;
                rounding[(*a, b)] += of_rounding;
                present[(*a, b)] = 1.0;
            }
        }
        let mut margin = [0.0; 2];
        for b in 0..count {
            for a in (0..count).filter(|a| present[(*a, b)] > 0.0) {
                let rest = (own[a].sqrt() * own[b].sqrt()).sqrt();
                margin[usize::from(a != b)] += (rest + rounding[(a, b)].sqrt()).powi(2);
            }
        }
        Self {
            known: known_sum,
            whole: whole_sum,
            margin,
        }
    }

    pub(super) fn error(&self, kind: InterfacePairs) -> Bracket {
        let kind = usize::from(kind == InterfacePairs::Transfer);
        let root = |values: &[f64; 2]| values[kind].sqrt();
        bracket(root(&self.known), root(&self.margin), root(&self.whole))
    }
}
