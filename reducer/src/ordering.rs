//! Fill-reducing order of the dofs: nested dissection (METIS) of the node graph, expanded to dofs.
//!
//! The dofs of a node have nearly the same neighbours, so the graph of nodes has the same separators as the graph of
//! dofs at a ninth of the size, and a node's dofs stay together in one supernode.

use std::sync::{Mutex, PoisonError};

use dcb_formats::SparseMatrix;

/// Held while METIS runs.
static METIS: Mutex<()> = Mutex::new(());

/// An elimination order: `forward[new] = old`, `inverse[old] = new`.
#[derive(Clone, Debug)]
pub struct Ordering {
    /// Old index of each new position.
    pub forward: Vec<u32>,
    /// New position of each old index.
    pub inverse: Vec<u32>,
}

/// Orders the rows of the union of symmetric patterns, each in full storage; rows of the same `group` stay together.
pub fn nested_dissection(patterns: &[&SparseMatrix], groups: &[u32]) -> Ordering {
    let members = members_of_groups(groups);
    let forward: Vec<u32> = Graph::of(patterns, groups, &members)
        .dissect()
        .into_iter()
        .flat_map(|group| members[group as usize].iter().copied())
        .collect();
    let mut inverse = vec![0; forward.len()];
    for (new, old) in forward.iter().enumerate() {
        inverse[*old as usize] = new as u32;
    }
    Ordering { forward, inverse }
}

/// The rows of each group; a group without rows stays as an isolated vertex.
fn members_of_groups(groups: &[u32]) -> Vec<Vec<u32>> {
    let count = groups
        .iter()
        .map(|group| *group as usize + 1)
        .max()
        .unwrap_or(0);
    let mut members = vec![Vec::new(); count];
    for (row, group) in groups.iter().enumerate() {
        members[*group as usize].push(row as u32);
    }
    members
}

/// Adjacency lists of the groups, without loops, both directions.
struct Graph {
    starts: Vec<i32>,
    neighbours: Vec<i32>,
    weights: Vec<i32>,
}

impl Graph {
    fn of(patterns: &[&SparseMatrix], groups: &[u32], members: &[Vec<u32>]) -> Self {
        let mut starts = vec![0_i32];
        let mut neighbours = Vec::new();
        let mut last_seen_by = vec![u32::MAX; members.len()];
        for (here, rows) in members.iter().enumerate() {
            let here = here as u32;
            last_seen_by[here as usize] = here;
            for pattern in patterns {
                for row in rows {
                    for other in pattern.row_idx_of_col_raw(*row as usize) {
                        let there = groups[*other as usize];
                        if last_seen_by[there as usize] != here {
                            last_seen_by[there as usize] = here;
                            neighbours.push(there as i32);
                        }
                    }
                }
            }
            starts.push(neighbours.len() as i32);
        }
        let weights = members.iter().map(|rows| rows.len() as i32).collect();
        Self {
            starts,
            neighbours,
            weights,
        }
    }

    fn vertex_count(&self) -> usize {
        self.weights.len()
    }

    fn dissect(mut self) -> Vec<u32> {
        let count = self.vertex_count();
        let natural = || (0..count as u32).collect();
        // METIS needs an edge to have something to dissect.
        if count < 3 || self.neighbours.is_empty() {
            return natural();
        }
        let mut order = vec![0_i32; count];
        let mut inverse = vec![0_i32; count];
        let mut vertex_count = count as i32;
        let mut options = [0_i32; metis_sys::METIS_NOPTIONS as usize];
        // METIS draws from the C library's one random sequence: two calls at the same time would share it, and get orders
        // that depend on timing.
        let _alone = METIS.lock().unwrap_or_else(PoisonError::into_inner);
        // SAFETY: METIS reads `count + 1` starts, `starts[count]` neighbours and `count` weights, which is what the
        // vectors hold, and writes `count` entries of each permutation; it keeps no pointer.
        let status = unsafe {
            metis_sys::METIS_SetDefaultOptions(options.as_mut_ptr());
            metis_sys::METIS_NodeND(
                &mut vertex_count,
                self.starts.as_mut_ptr(),
                self.neighbours.as_mut_ptr(),
                self.weights.as_mut_ptr(),
                options.as_mut_ptr(),
                order.as_mut_ptr(),
                inverse.as_mut_ptr(),
            )
        };
        // Any order is a correct order: if METIS refuses (out of memory), the natural one still factorizes.
        if status != metis_sys::rstatus_et_METIS_OK {
            return natural();
        }
        order.into_iter().map(|old| old as u32).collect()
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use faer::sparse::Triplet;

    #[test]
    fn dofs_of_a_node_stay_together_and_every_dof_appears_once() {
        let nodes = 400_u32;
        let mut entries = Vec::new();
        for node in 0..nodes {
            for neighbour in [node, (node + 1) % nodes, (node + 20) % nodes] {
                for a in 0..3 {
                    for b in 0..3 {
                        entries.push(Triplet::new(3 * node + a, 3 * neighbour + b, 1.0));
                        entries.push(Triplet::new(3 * neighbour + b, 3 * node + a, 1.0));
                    }
                }
            }
        }
        let n = 3 * nodes as usize;
        let pattern = SparseMatrix::try_new_from_triplets(n, n, &entries).unwrap();
        let groups: Vec<u32> = (0..n as u32).map(|dof| dof / 3).collect();
        let ordering = nested_dissection(&[&pattern], &groups);
        assert!(
            ordering
                .forward
                .chunks(3)
                .all(|three| three.iter().all(|dof| dof / 3 == three[0] / 3))
        );
        for (new, old) in ordering.forward.iter().enumerate() {
            assert_eq!(ordering.inverse[*old as usize] as usize, new);
        }
        let mut sorted = ordering.forward.clone();
        sorted.sort_unstable();
        assert!(sorted.iter().enumerate().all(|(i, dof)| *dof as usize == i));
    }
}
