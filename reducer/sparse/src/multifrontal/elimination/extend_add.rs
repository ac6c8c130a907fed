//! Update matrices of children added to their parent. Threads share the columns of a large parent; every entry is the same sum in the
//! order of the children.

use std::ops::Range;

use rayon::prelude::*;

use crate::multifrontal::dense::Trapezoid;
use crate::multifrontal::fronts::{Fronts, Run};

/// A panel or an update matrix of fewer entries is one task.
const LARGE: usize = 1 << 18;

/// A child with its update matrix.
#[derive(Clone, Copy)]
pub(super) struct Child<'a> {
    pub front: usize,
    pub update: &'a [f64],
}

/// Adds the part of the children's update matrices that lies in some columns of the parent from `offset` on: its own, or those of its update
/// matrix.
pub(super) fn add_children(
    fronts: &Fronts,
    children: &[Child<'_>],
    values: &mut [f64],
    layout: Trapezoid,
    offset: usize,
) {
    let add = |(chunk, values): (Range<usize>, &mut [f64])| {
        let start = offset + chunk.start;
        let wanted = start..offset + chunk.end;
        for child in children {
            let target = Target {
                values: &mut *values,
                columns: wanted.clone(),
                height: layout.rows - chunk.start,
                start,
            };
            add_columns(fronts, *child, target);
        }
    };
    let is_large = values.len() >= LARGE;
    let chunks = layout.slices(values);
    match is_large {
        true => chunks.into_par_iter().for_each(add),
        false => chunks.into_iter().for_each(add),
    }
}

/// Some columns of a parent, one after the other.
struct Target<'a> {
    values: &'a mut [f64],
    /// Their places in the parent's front.
    columns: Range<usize>,
    /// Rows of each.
    height: usize,
    /// The row that they start with.
    start: usize,
}

impl Target<'_> {
    fn column(&mut self, column: usize) -> (&mut [f64], usize) {
        let first = (column - self.columns.start) * self.height;
        (&mut self.values[first..first + self.height], self.start)
    }
}

/// Adds the part of a child's update matrix that lies in some of the parent's columns.
fn add_columns(fronts: &Fronts, child: Child<'_>, mut to: Target<'_>) {
    let wanted = to.columns.clone();
    let runs = fronts.rows_in_parent(child.front);
    let layout = fronts.update_layout(child.front);
    let first = runs.partition_point(|run| ((run.target + run.length) as usize) <= wanted.start);
    for (index, across) in runs.iter().enumerate().skip(first) {
        let target = across.target as usize;
        if target >= wanted.end {
            break;
        }
        let begin = wanted.start.saturating_sub(target);
        let end = (across.length as usize).min(wanted.end - target);
        for offset in begin..end {
            let (source, above) = layout.column(across.source as usize + offset);
            let source = (&child.update[source], above);
            add_runs(source, to.column(target + offset), &runs[index..], offset);
        }
    }
}

/// Adds a column from its diagonal on; the first run begins `skip` rows above the diagonal. Both columns come with the row that
/// they start with.
fn add_runs(
    (source, source_start): (&[f64], usize),
    (target, target_start): (&mut [f64], usize),
    runs: &[Run],
    skip: usize,
) {
    let mut skip = skip;
    for run in runs {
        let from = run.source as usize + skip - source_start;
        let to = run.target as usize + skip - target_start;
        let length = run.length as usize - skip;
        skip = 0;
        for (target, source) in target[to..to + length]
            .iter_mut()
            .zip(&source[from..from + length])
        {
            *target += *source;
        }
    }
}
