//! Nested dissection by METIS.

use std::sync::{Mutex, PoisonError};

use super::QuotientGraph;

/// Held while METIS runs: it draws from the C library's one random sequence, and two calls at the same time would share
/// it and get orders that depend on timing.
static METIS: Mutex<()> = Mutex::new(());

/// Imbalance allowed between the two sides of a separator, in thousandths. METIS' own 200 gives the same fill within its
/// scatter, a quarter slower.
const IMBALANCE: i32 = 70;

/// Elimination order of the vertices, each counted by its weight, with the best of some separators at each bisection; `None` if METIS
/// can't (indices beyond 32 bits, out of memory).
pub(super) fn dissect(graph: &QuotientGraph, weights: &[u32], separators: u32) -> Option<Vec<u32>> {
    let mut vertex_count = i32::try_from(graph.vertex_count()).ok()?;
    i32::try_from(graph.all_neighbours().len()).ok()?;
    let mut starts: Vec<i32> = graph.starts().iter().map(|start| *start as i32).collect();
    let mut neighbours: Vec<i32> = graph.all_neighbours().iter().map(|v| *v as i32).collect();
    let mut weights: Vec<i32> = weights.iter().map(|weight| *weight as i32).collect();
    let mut order = vec![0_i32; graph.vertex_count()];
    let mut inverse = vec![0_i32; graph.vertex_count()];
    let mut options = [0_i32; metis_sys::METIS_NOPTIONS as usize];
    let alone = METIS.lock().unwrap_or_else(PoisonError::into_inner);
    // SAFETY: METIS reads `vertex_count + 1` starts, as many neighbours as the last start says and `vertex_count`
    // weights, which is what the vectors hold; every neighbour is a vertex. It writes `vertex_count` entries of each
    // permutation and `METIS_NOPTIONS` options, and keeps no pointer.
    let status = unsafe {
        metis_sys::METIS_SetDefaultOptions(options.as_mut_ptr());
        options[metis_sys::moptions_et_METIS_OPTION_UFACTOR as usize] = IMBALANCE;
        options[metis_sys::moptions_et_METIS_OPTION_NSEPS as usize] = separators as i32;
        metis_sys::METIS_NodeND(
            &mut vertex_count,
            starts.as_mut_ptr(),
            neighbours.as_mut_ptr(),
            weights.as_mut_ptr(),
            options.as_mut_ptr(),
            order.as_mut_ptr(),
            inverse.as_mut_ptr(),
        )
    };
    drop(alone);
    (status == metis_sys::rstatus_et_METIS_OK)
        .then(|| order.into_iter().map(|old| old as u32).collect())
}
