//! Rows below the columns of each group of vertices.

use crate::multifrontal::amalgamation::Groups;
use crate::ordering::elimination_tree::{NONE, OrderedGraph, children_of};

/// Rows (vertices) below the columns of each group.
pub(super) fn rows_below_groups(graph: &OrderedGraph, groups: &Groups) -> Vec<Vec<u32>> {
    let count = groups.vertices.len();
    let mut group_of = vec![0_u32; graph.len()];
    for (group, vertices) in groups.vertices.iter().enumerate() {
        for vertex in vertices {
            group_of[*vertex as usize] = group as u32;
        }
    }
    let (children, _) = children_of(&groups.parents);
    let mut below: Vec<Vec<u32>> = vec![Vec::new(); count];
    let mut seen_by = vec![NONE; graph.len()];
    for group in 0..count {
        let vertices = &groups.vertices[group];
        let mut rows = Vec::new();
        for vertex in vertices {
            seen_by[*vertex as usize] = group as u32;
        }
        let mut add = |vertex: u32| {
            if seen_by[vertex as usize] != group as u32 {
                seen_by[vertex as usize] = group as u32;
                rows.push(vertex);
            }
        };
        for child in &children[group] {
            for row in &below[*child as usize] {
                add(*row);
            }
        }
        for vertex in vertices {
            // Neighbours eliminated before belong to descendants.
            for neighbour in graph.neighbours_of(*vertex) {
                if group_of[*neighbour as usize] > group as u32 {
                    add(*neighbour);
                }
            }
        }
        below[group] = rows;
    }
    below
}
