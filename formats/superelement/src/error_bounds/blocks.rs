//! Responses between interfaces, block by block: their errors as norms over many blocks.

use std::ops::Range;

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

impl InterfacePairs {
    pub(super) const ALL: [Self; 2] = [Self::Collocated, Self::Transfer];

    /// Of which kind a pair is.
    pub(super) fn of(a: usize, b: usize) -> Self {
        match a == b {
            true => Self::Collocated,
            false => Self::Transfer,
        }
    }
}

/// Squares of Frobenius norms over the blocks of interfaces, by kind of pair where there are two.
pub(super) struct Blocks {
    /// Of the known part.
    pub known: [f64; 2],
    /// Of H, as far as it is known.
    pub whole: [f64; 2],
    /// Of the bound of the rest between the rows of each interface.
    pub own: Vec<f64>,
    /// Of the rounding, for each pair of interfaces that has a block.
    pub rounding: Vec<(usize, usize, f64)>,
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
        let mut own = vec![0.0_f64; count];
        for j in 0..rows.len() {
            for i in (0..rows.len()).filter(|i| of_row(*i) == of_row(j)) {
                own[of_row(j)] += found.rest[(i, j)].norm_sqr();
            }
        }
        let mut rounding: Vec<Option<f64>> = vec![None; count * count];
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
                let kind = InterfacePairs::of(*a, b) as usize;
                known_sum[kind] += of_known;
                whole_sum[kind] += of_whole;
                *rounding[a * count + b].get_or_insert(0.0) += of_rounding;
            }
        }
        let blocks = rounding.iter().enumerate();
        Self {
            known: known_sum,
            whole: whole_sum,
            own,
            rounding: blocks
                .filter_map(|(place, sum)| Some((place / count, place % count, (*sum)?)))
                .collect(),
        }
    }

    /// The error of each kind of response.
    pub(super) fn errors(&self) -> [Bracket; 2] {
        let mut margin = [0.0; 2];
        for (a, b, rounding) in &self.rounding {
            let rest = (self.own[*a].sqrt() * self.own[*b].sqrt()).sqrt();
            margin[InterfacePairs::of(*a, *b) as usize] += (rest + rounding.sqrt()).powi(2);
        }
        InterfacePairs::ALL.map(|kind| {
            let root = |values: &[f64; 2]| values[kind as usize].sqrt();
            bracket(root(&self.known), root(&margin), root(&self.whole))
        })
    }
}
