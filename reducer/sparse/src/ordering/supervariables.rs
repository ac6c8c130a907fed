//! Dofs that the pattern can't tell apart: the same neighbours, themselves included.
//!
//! The three dofs of a solid's node are such a set, and eliminating one makes no fill that the others don't share.

use dcb_formats::SparseMatrix;
use rayon::prelude::*;

/// The first dof of each dof's supervariable, from the union of symmetric patterns in full storage.
pub(super) fn of(patterns: &[&SparseMatrix]) -> Vec<u32> {
    let count = patterns.first().map_or(0, |pattern| pattern.ncols());
    let mut hashes: Vec<(u64, u32)> = (0..count as u32)
        .into_par_iter()
        .map_init(Vec::new, |neighbours, dof| {
            closed_neighbours(patterns, dof, neighbours);
            (hash(neighbours), dof)
        })
        .collect();
    hashes.par_sort_unstable();
    let mut first_of: Vec<u32> = (0..count as u32).collect();
    let candidates: Vec<&[(u64, u32)]> = hashes
        .chunk_by(|a, b| a.0 == b.0)
        .filter(|same_hash| same_hash.len() > 1)
        .collect();
    let merged: Vec<(u32, u32)> = candidates
        .into_par_iter()
        .flat_map_iter(|same_hash| verified(patterns, same_hash))
        .collect();
    for (dof, first) in merged {
        first_of[dof as usize] = first;
    }
    first_of
}

/// Pairs (dof, first dof with exactly the same neighbours) among dofs of the same hash.
fn verified(patterns: &[&SparseMatrix], same_hash: &[(u64, u32)]) -> Vec<(u32, u32)> {
    let mut known: Vec<(u32, Vec<u32>)> = Vec::new();
    let mut merged = Vec::new();
    let mut neighbours = Vec::new();
    for (_, dof) in same_hash {
        closed_neighbours(patterns, *dof, &mut neighbours);
        match known.iter().find(|(_, list)| *list == neighbours) {
            Some((first, _)) => merged.push((*dof, *first)),
            None => known.push((*dof, neighbours.clone())),
        }
    }
    merged
}

/// Rows of the union of the patterns in the column of `dof`, and `dof` itself, ascending.
fn closed_neighbours(patterns: &[&SparseMatrix], dof: u32, neighbours: &mut Vec<u32>) {
    neighbours.clear();
    let Some((first, others)) = patterns.split_first() else {
        return;
    };
    let rows = first.row_idx_of_col_raw(dof as usize);
    neighbours.extend_from_slice(rows);
    for other in others {
        push_missing(rows, other.row_idx_of_col_raw(dof as usize), neighbours);
    }
    push_missing(rows, &[dof], neighbours);
    if neighbours.len() > rows.len() {
        neighbours.sort_unstable();
        neighbours.dedup();
    }
}

/// Pushes what is in `candidates` and not in `rows`, both ascending.
fn push_missing(rows: &[u32], candidates: &[u32], found: &mut Vec<u32>) {
    let mut position = match candidates.first() {
        Some(first) => rows.partition_point(|row| row < first),
        None => return,
    };
    for candidate in candidates {
        while rows.get(position).is_some_and(|row| row < candidate) {
            position += 1;
        }
        if rows.get(position) != Some(candidate) {
            found.push(*candidate);
        }
    }
}

/// A sum of scrambled indices (the finalizer of SplitMix64): equal sets have equal hashes.
fn hash(set: &[u32]) -> u64 {
    set.iter().fold(0, |sum: u64, index| {
        let mut x = u64::from(*index).wrapping_add(0x9E37_79B9_7F4A_7C15);
        x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        sum.wrapping_add(x ^ (x >> 31))
    })
}
