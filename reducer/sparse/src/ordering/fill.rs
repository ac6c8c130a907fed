//! Cost of an order: entries of the Cholesky factor and multiplications to compute it, by a symbolic elimination.

use super::QuotientGraph;

/// Cost of a Cholesky factorization of full supervariable blocks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fill {
    /// Entries of the lower triangle.
    pub entries: f64,
    /// Sum of the squares of the column lengths, which is the number of additions and multiplications.
    pub flops: f64,
}

impl Fill {
    /// Counts for an elimination order of the supervariables.
    pub fn of(graph: &QuotientGraph, order: &[u32]) -> Self {
        let count = order.len();
        let mut position = vec![0_usize; count];
        for (new, old) in order.iter().enumerate() {
            position[*old as usize] = new;
        }
        let mut parent = vec![usize::MAX; count];
        let mut seen_by = vec![usize::MAX; count];
        let mut below = vec![0_u64; count];
        // Row i of the factor is the part of the elimination tree between its entries in the matrix and i.
        for (row, old) in order.iter().enumerate() {
            seen_by[row] = row;
            for other in graph.neighbours(*old) {
                let mut column = position[*other as usize];
                while column < row && seen_by[column] != row {
                    seen_by[column] = row;
                    below[column] += u64::from(graph.weight(*old));
                    if parent[column] == usize::MAX {
                        parent[column] = row;
                    }
                    column = parent[column];
                }
            }
        }
        let mut fill = Self {
            entries: 0.0,
            flops: 0.0,
        };
        for (old, below) in order.iter().zip(below) {
            for within in 1..=u64::from(graph.weight(*old)) {
                let length = (below + within) as f64;
                fill.entries += length;
                fill.flops += length * length;
            }
        }
        fill
    }
}
