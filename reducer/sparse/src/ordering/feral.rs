//! Nested dissection in Rust alone, by `feral-metis`.

use feral_metis::{CscPattern, MetisOptions, metis_order_full};

use super::QuotientGraph;

/// Elimination order of the vertices, all weighted alike, with one separator at each bisection; `None` if the graph is beyond 32-bit indices.
pub(super) fn dissect(graph: &QuotientGraph, _: &[u32], _: u32) -> Option<Vec<u32>> {
    i32::try_from(graph.all_neighbours().len()).ok()?;
    let starts: Vec<i32> = graph.starts().iter().map(|start| *start as i32).collect();
    let neighbours: Vec<i32> = graph.all_neighbours().iter().map(|v| *v as i32).collect();
    let pattern = CscPattern::new(graph.vertex_count(), &starts, &neighbours)?;
    let options = MetisOptions {
        // Three trials of the coarsest bisection: the same fill as its own seven, a tenth faster.
        niparts: 3,
        ..MetisOptions::default()
    };
    let (order, _, _) = metis_order_full(&pattern, &options).ok()?;
    Some(order.into_iter().map(|old| old as u32).collect())
}
