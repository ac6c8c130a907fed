//! Fill-reducing order of the dofs: nested dissection of the graph of supervariables, expanded to dofs.
//!
//! The dofs of a node have nearly the same neighbours, so the graph of nodes has the same separators as the graph of
//! dofs at a ninth of the size, and a node's dofs stay together in one supernode. Where the dof table says nothing about
//! nodes, dofs with the same neighbours are found from the pattern ([`QuotientGraph::of_points`]). Midside nodes are left out of the
//! dissection and put where their corners are (`dominated`).
//!
//! The dissection is METIS' (feature `metis`, a C library built with this crate) or, without that feature, that of
//! `feral-metis` (feature `pure-rust-ordering`). Vertices with very many neighbours are kept out of it and come last.

mod dominated;
pub(crate) mod elimination_tree;
mod quotient;
mod supervariables;

#[cfg(test)]
mod fill;

// Tests compare it with METIS.
#[cfg(any(not(feature = "metis"), test))]
mod feral;
#[cfg(feature = "metis")]
mod metis;

#[cfg(not(feature = "metis"))]
use feral as dissection;
#[cfg(feature = "metis")]
use metis as dissection;

use dominated::Dominated;
pub use quotient::QuotientGraph;

#[cfg(not(any(feature = "metis", feature = "pure-rust-ordering")))]
compile_error!("dcb-sparse needs an ordering: feature \"metis\" or \"pure-rust-ordering\"");

/// A vertex with more than this many times the square root of the number of vertices as neighbours is eliminated last;
/// the factor of AMD and CHOLMOD.
const DENSE: f64 = 10.0;

/// Separators of which the best is taken where the graph is small beside the part: they take less time than they save.
const SEPARATORS_TRIED: u32 = 4;

/// Components below this number of vertices are dissected together.
const SMALL_COMPONENT: usize = 200;

/// Elimination order of the supervariables: those that are eliminated first come first.
///
/// The same graph gives the same order whatever the number of threads.
pub fn nested_dissection(graph: &QuotientGraph) -> Vec<u32> {
    let (sparse, dense) = split_by_degree(graph);
    if dense.is_empty() {
        return dissect_components(graph);
    }
    let mut order = part_order(graph, &sparse, dissect_components);
    order.extend(dense);
    order
}

/// Vertices in two ascending lists: those to dissect, and those next to so many others that they come last.
///
/// A vertex eliminated last adds a row per dof to the factor at most. METIS would put it into a separator, which costs the
/// same; `feral-metis` finds worse separators around it, and both are slowed down by cliques.
fn split_by_degree(graph: &QuotientGraph) -> (Vec<u32>, Vec<u32>) {
    let vertices = 0..graph.vertex_count() as u32;
    let limit = DENSE * (graph.vertex_count() as f64).sqrt();
    vertices.partition(|vertex| graph.neighbours(*vertex).len() as f64 <= limit)
}

/// Each connected component by itself, the small ones together: a separator of unequal components would split the larger
/// at a worse place than its middle.
fn dissect_components(graph: &QuotientGraph) -> Vec<u32> {
    let mut parts = vec![Vec::new()];
    for component in components(graph) {
        if component.len() < SMALL_COMPONENT {
            parts[0].extend(component);
        } else {
            parts.push(component);
        }
    }
    if parts.iter().any(|part| part.len() == graph.vertex_count()) {
        return dissect(graph);
    }
    parts[0].sort_unstable();
    let orders = parts.iter().map(|part| part_order(graph, part, dissect));
    orders.flatten().collect()
}

/// The order that `method` gives the subgraph of some vertices (ascending), in the graph's own indices.
fn part_order(
    graph: &QuotientGraph,
    part: &[u32],
    method: fn(&QuotientGraph) -> Vec<u32>,
) -> Vec<u32> {
    let order = method(&graph.induced(part));
    order.into_iter().map(|v| part[v as usize]).collect()
}

/// The vertices of each connected component, ascending; components by their first vertex.
fn components(graph: &QuotientGraph) -> Vec<Vec<u32>> {
    let mut reached = vec![false; graph.vertex_count()];
    let mut components = Vec::new();
    for start in 0..graph.vertex_count() as u32 {
        if reached[start as usize] {
            continue;
        }
        reached[start as usize] = true;
        let mut component = vec![start];
        let mut next = 0;
        while let Some(vertex) = component.get(next) {
            next += 1;
            for other in graph.neighbours(*vertex) {
                if !reached[*other as usize] {
                    reached[*other as usize] = true;
                    component.push(*other);
                }
            }
        }
        component.sort_unstable();
        components.push(component);
    }
    components
}

/// Nested dissection of all vertices: of those that no neighbour dominates, if there are enough others.
fn dissect(graph: &QuotientGraph) -> Vec<u32> {
    match Dominated::of(graph) {
        Some(dominated) => {
            let among_kept = graph.induced(&dominated.kept);
            let order = by_library(&among_kept, &dominated.weights(), SEPARATORS_TRIED);
            dominated.inserted(&among_kept, &order)
        }
        None => {
            let vertices = 0..graph.vertex_count() as u32;
            let weights: Vec<u32> = vertices.map(|v| graph.weight(v)).collect();
            by_library(graph, &weights, 1)
        }
    }
}

/// Nested dissection by the library built in, of vertices that count by their weights, with the best of so many separators.
fn by_library(graph: &QuotientGraph, weights: &[u32], separators: u32) -> Vec<u32> {
    let natural = || (0..graph.vertex_count() as u32).collect();
    // There must be an edge to have something to dissect.
    if graph.vertex_count() < 3 || graph.all_neighbours().is_empty() {
        return natural();
    }
    // Any order is a correct order: if the library refuses (out of memory), the natural one still factorizes.
    dissection::dissect(graph, weights, separators).unwrap_or_else(natural)
}

#[cfg(test)]
mod tests;
