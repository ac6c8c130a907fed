//! Triangular solutions over the tree: a front's right-hand sides go up to its parent as in the factorization, the solution
//! comes down the same way. Subtrees are tasks of their own.

use faer::reborrow::*;
use faer::{MatMut, MatRef};
use rayon::prelude::*;

use super::fronts::Fronts;
use super::kernels::{Real, backward, forward};

/// Rows packed or unpacked by one task.
const CHUNK: usize = 2048;
/// Rows turned to columns or back together, which stay in the nearest cache.
const TILE: usize = 32;

/// Replaces the columns of `block` (at most `N`, a multiple of 8) by the solutions of `L Lᵀ x = b`.
pub fn solve_columns<T: Real, const N: usize>(
    fronts: &Fronts,
    values: &[T],
    block: MatMut<'_, f64>,
) {
    debug_assert!(block.ncols() <= N);
    let mut x = packed::<N>(fronts, block.rb());
    let solution = Solution::<T, N> { fronts, values };
    solution.side_by_side_forward(fronts.roots(), &mut x);
    solution.side_by_side_backward(fronts.roots(), &mut x, None);
    unpack(fronts, &x, block);
}

/// The right-hand sides by rows, in the order of elimination: turned to rows first, so that whole lines are fetched from here and there.
fn packed<const N: usize>(fronts: &Fronts, block: MatRef<'_, f64>) -> Vec<[f64; N]> {
    let tiles = (0..block.nrows().div_ceil(TILE)).into_par_iter();
    let rows: Vec<[[f64; N]; TILE]> = tiles.map(|tile| turned(block, tile * TILE)).collect();
    let rows = rows.as_flattened();
    let order = fronts.forward.par_iter();
    order.map(|dof| rows[*dof as usize]).collect()
}

/// Some rows from `first` on; zeros where there are none, and beyond the last column.
fn turned<const N: usize>(block: MatRef<'_, f64>, first: usize) -> [[f64; N]; TILE] {
    let mut rows = [[0.0; N]; TILE];
    let block = block.subrows(first, TILE.min(block.nrows() - first));
    for (column, values) in block.col_iter().enumerate() {
        for (row, value) in rows.iter_mut().zip(values.iter()) {
            row[column] = *value;
        }
    }
    rows
}

/// The solution as columns, in the order of the dofs.
fn unpack<const N: usize>(fronts: &Fronts, x: &[[f64; N]], block: MatMut<'_, f64>) {
    block
        .par_row_chunks_mut(CHUNK)
        .zip(fronts.inverse.par_chunks(CHUNK))
        .for_each(|(mut block, positions)| {
            let mut tile = [[0.0; N]; TILE];
            for (number, positions) in positions.chunks(TILE).enumerate() {
                for (row, position) in tile.iter_mut().zip(positions) {
                    *row = x[*position as usize];
                }
                let rows = block.rb_mut().subrows_mut(number * TILE, positions.len());
                for (column, values) in rows.col_iter_mut().enumerate() {
                    for (value, row) in values.iter_mut().zip(&tile) {
                        *value = row[column];
                    }
                }
            }
        });
}

struct Solution<'a, T, const N: usize> {
    fronts: &'a Fronts,
    values: &'a [T],
}

impl<T: Real, const N: usize> Solution<'_, T, N> {
    fn packed(&self, front: usize) -> &[T] {
        &self.values[self.fronts.value_range(front)]
    }

    /// The rows of the right-hand sides (or the solution) that belong to each subtree.
    fn split<'x>(
        &self,
        subtrees: &[u32],
        x: &'x mut [[f64; N]],
    ) -> Vec<(usize, &'x mut [[f64; N]])> {
        let mut rest = x;
        let mut tasks = Vec::with_capacity(subtrees.len());
        for front in subtrees {
            let front = *front as usize;
            let first = self
                .fronts
                .columns(self.fronts.first_descendant(front))
                .start;
            let length = self.fronts.columns(front).end - first;
            let (own, after) = rest.split_at_mut(length);
            tasks.push((front, own));
            rest = after;
        }
        tasks
    }

    fn side_by_side_forward(&self, subtrees: &[u32], x: &mut [[f64; N]]) -> Vec<Vec<[f64; N]>> {
        self.split(subtrees, x)
            .into_par_iter()
            .map(|(front, x)| self.up(front, x))
            .collect()
    }

    /// Solves a subtree's rows; returns what it hands up.
    fn up(&self, front: usize, x: &mut [[f64; N]]) -> Vec<[f64; N]> {
        if self.fronts.is_one_task(front) {
            return self.up_alone(front, x);
        }
        let own = self.fronts.column_count(front);
        let (below, own) = x.split_at_mut(x.len() - own);
        let handed = self.side_by_side_forward(self.fronts.children(front), below);
        let mut w = vec![[0.0; N]; self.fronts.row_count(front)];
        w[..own.len()].copy_from_slice(own);
        for (child, update) in self.fronts.children(front).iter().zip(&handed) {
            self.add_update(*child as usize, update, &mut w);
        }
        forward(self.packed(front), self.fronts.column_count(front), &mut w);
        own.copy_from_slice(&w[..own.len()]);
        w.drain(..own.len());
        w
    }

    fn up_alone(&self, root: usize, x: &mut [[f64; N]]) -> Vec<[f64; N]> {
        let fronts = self.fronts;
        let first = fronts.first_descendant(root);
        let base = fronts.columns(first).start;
        // The rows of fronts of even and of odd depth, one above the other; a parent's children are on top when its turn comes.
        let mut stacks: [Vec<[f64; N]>; 2] = Default::default();
        for front in first..=root {
            let columns = fronts.columns(front);
            let own = &mut x[columns.start - base..columns.end - base];
            let [even, odd] = &mut stacks;
            let (to, from) = match (fronts.depth(root) - fronts.depth(front)) % 2 {
                0 => (even, odd),
                _ => (odd, even),
            };
            let start = to.len();
            to.extend_from_slice(own);
            to.resize(start + fronts.row_count(front), [0.0; N]);
            let w = &mut to[start..];
            let children = fronts.children(front).iter().map(|child| *child as usize);
            let height: usize = children.clone().map(|child| fronts.row_count(child)).sum();
            let mut at = from.len() - height;
            let rest = at;
            for child in children {
                let end = at + fronts.row_count(child);
                self.add_update(child, &from[end - fronts.update_size(child)..end], w);
                at = end;
            }
            from.truncate(rest);
            forward(self.packed(front), own.len(), w);
            own.copy_from_slice(&w[..own.len()]);
        }
        let [mut of_root, _] = stacks;
        of_root.drain(..fronts.column_count(root));
        of_root
    }

    fn add_update(&self, child: usize, update: &[[f64; N]], w: &mut [[f64; N]]) {
        for run in self.fronts.rows_in_parent(child) {
            let length = run.length as usize;
            let source = &update[run.source as usize..][..length];
            for (to, from) in w[run.target as usize..][..length].iter_mut().zip(source) {
                for l in 0..N {
                    to[l] += from[l];
                }
            }
        }
    }

    fn side_by_side_backward(
        &self,
        subtrees: &[u32],
        x: &mut [[f64; N]],
        above: Option<&[[f64; N]]>,
    ) {
        self.split(subtrees, x)
            .into_par_iter()
            .for_each(|(front, x)| self.down(front, x, above));
    }

    fn down(&self, front: usize, x: &mut [[f64; N]], above: Option<&[[f64; N]]>) {
        if self.fronts.is_one_task(front) {
            return self.down_alone(front, x, above);
        }
        let own = self.fronts.column_count(front);
        let (below, own) = x.split_at_mut(x.len() - own);
        let mut w = Vec::new();
        self.solve_down(front, own, above, &mut w);
        self.side_by_side_backward(self.fronts.children(front), below, Some(&w));
    }

    /// One front: its rows below come from its parent's rows, its own are solved.
    fn solve_down(
        &self,
        front: usize,
        own: &mut [[f64; N]],
        above: Option<&[[f64; N]]>,
        w: &mut Vec<[f64; N]>,
    ) {
        let start = w.len();
        w.extend_from_slice(own);
        if let Some(above) = above {
            for run in self.fronts.rows_in_parent(front) {
                w.extend_from_slice(&above[run.target as usize..][..run.length as usize]);
            }
        }
        backward(
            self.packed(front),
            self.fronts.column_count(front),
            &mut w[start..],
        );
        own.copy_from_slice(&w[start..start + own.len()]);
    }

    fn down_alone(&self, root: usize, x: &mut [[f64; N]], above: Option<&[[f64; N]]>) {
        let fronts = self.fronts;
        let first = fronts.first_descendant(root);
        let base = fronts.columns(first).start;
        // The rows of the fronts from the root to the one at hand, one above the other, with where each starts.
        let mut path: Vec<usize> = Vec::new();
        let mut rows: Vec<[f64; N]> = Vec::new();
        for front in (first..=root).rev() {
            let depth = fronts.depth(front) - fronts.depth(root);
            let start = path.get(depth).copied().unwrap_or(rows.len());
            rows.truncate(start);
            path.truncate(depth);
            let columns = fronts.columns(front);
            let own = &mut x[columns.start - base..columns.end - base];
            match path.last() {
                Some(parent) => {
                    rows.extend_from_slice(own);
                    for run in fronts.rows_in_parent(front) {
                        let from = parent + run.target as usize;
                        rows.extend_from_within(from..from + run.length as usize);
                    }
                    backward(
                        self.packed(front),
                        self.fronts.column_count(front),
                        &mut rows[start..],
                    );
                    own.copy_from_slice(&rows[start..start + own.len()]);
                }
                None => self.solve_down(front, own, above, &mut rows),
            }
            path.push(start);
        }
    }
}
