//! Update matrices of children added to their parent.

use crate::multifrontal::dense::UpdateLayout;
use crate::multifrontal::fronts::{Fronts, Run};

/// Adds the part of a child's update matrix that lies in the parent's columns.
pub(super) fn add_to_panel(
    fronts: &Fronts,
    child: usize,
    theirs: &[f64],
    values: &mut [f64],
    rows: usize,
    columns: usize,
) {
    let runs = fronts.rows_in_parent(child);
    let layout = fronts.update_layout(child);
    for (index, across) in runs
        .iter()
        .enumerate()
        .take_while(|(_, run)| (run.target as usize) < columns)
    {
        for offset in 0..across.length as usize {
            let (source, above) = layout.column(across.source as usize + offset);
            let source = (&theirs[source], above);
            let target = &mut values[(across.target as usize + offset) * rows..][..rows];
            add_runs(source, (target, 0), &runs[index..], offset);
        }
    }
}

/// Adds the part of a child's update matrix that lies in the parent's update matrix.
pub(super) fn add_to_update(
    fronts: &Fronts,
    child: usize,
    theirs: &[f64],
    update: &mut [f64],
    rows: usize,
    columns: usize,
) {
    let runs = fronts.rows_in_parent(child);
    let layout = fronts.update_layout(child);
    let own_layout = UpdateLayout {
        order: rows - columns,
    };
    let first = runs.partition_point(|run| (run.target as usize) < columns);
    for (index, across) in runs.iter().enumerate().skip(first) {
        for offset in 0..across.length as usize {
            let (source, above) = layout.column(across.source as usize + offset);
            let source = (&theirs[source], above);
            let (target, above) = own_layout.column(across.target as usize - columns + offset);
            let target = (&mut update[target], columns + above);
            add_runs(source, target, &runs[index..], offset);
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
