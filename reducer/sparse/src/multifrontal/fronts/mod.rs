//! The symbolic factorization: fronts, their rows, where a child's rows lie in its parent, and what the numbers will cost.

mod rows_below;
mod tasks;

use rows_below::rows_below_groups;

use super::amalgamation::{Groups, gather};
use super::dense::Trapezoid;
use super::kernels::packed_length;
use crate::ordering::QuotientGraph;
use crate::ordering::elimination_tree::{NONE, OrderedGraph, children_of, postorder};

/// A run of consecutive rows: `length` rows from `source` on lie from `target` on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Run {
    /// First row in the child's update matrix.
    pub source: u32,
    /// First row in the parent's front.
    pub target: u32,
    /// Number of rows.
    pub length: u32,
}

/// The fronts of a factorization, in the order of elimination: children before parents, each subtree contiguous.
pub struct Fronts {
    /// Original dof at each position of the elimination order.
    pub forward: Vec<u32>,
    /// Position of each original dof.
    pub inverse: Vec<u32>,
    /// First column of each front, one more than fronts.
    starts: Vec<u32>,
    /// Number of rows of each front, its columns included.
    rows: Vec<u32>,
    /// Rows below the columns as runs (`source`: position in the front's update, `target`: position in the elimination order).
    below: Vec<Vec<Run>>,
    /// Rows of each front's update in its parent's front; empty for a root.
    to_parent: Vec<Vec<Run>>,
    children: Vec<Vec<u32>>,
    roots: Vec<u32>,
    depths: Vec<u32>,
    /// First front of the subtree of each front.
    first_descendants: Vec<u32>,
    /// Where each front's columns start among the stored values, one more than fronts.
    values: Vec<usize>,
    /// Floating-point operations in each subtree, and in all.
    subtree_flops: Vec<f64>,
    flops: f64,
    /// Largest sum of update matrices held at once while a subtree is eliminated by one thread, entries.
    subtree_stack: Vec<usize>,
}

/// Multiplications and additions that eliminate `k` columns of a front of `m` rows.
fn front_flops(k: f64, m: f64) -> f64 {
    // Σ_{j<k} (m - j)²
    k * m * m - m * k * (k - 1.0) + (k - 1.0) * k * (2.0 * k - 1.0) / 6.0
}

impl Fronts {
    /// Analyses a graph whose vertices are eliminated in the given order (`order[new] = old`).
    pub fn analyse(graph: &QuotientGraph, order: &[u32]) -> Self {
        let ordered = OrderedGraph::of(graph, order);
        let (children, roots) = children_of(&ordered.elimination_tree());
        let post = postorder(&children, &roots);
        let order: Vec<u32> = post.iter().map(|v| order[*v as usize]).collect();
        let ordered = OrderedGraph::of(graph, &order);
        let parents = ordered.elimination_tree();
        let counts = ordered.column_counts(&parents);
        let groups = gather(&ordered, &parents, &counts);
        Self::arranged(&ordered, &groups, |vertex| {
            graph.members(order[vertex as usize])
        })
    }

    /// Orders the groups so that little is held at once, and finds the rows of each; `dofs` are those of a vertex.
    fn arranged<'a>(
        graph: &OrderedGraph,
        groups: &Groups,
        dofs: impl Fn(u32) -> &'a [u32],
    ) -> Self {
        let below = rows_below_groups(graph, groups);
        let width = |vertices: &[u32]| -> usize {
            vertices
                .iter()
                .map(|v| graph.weights[*v as usize] as usize)
                .sum()
        };
        let columns: Vec<usize> = groups.vertices.iter().map(|v| width(v)).collect();
        let updates: Vec<usize> = below.iter().map(|v| width(v)).collect();
        let (mut children, roots) = children_of(&groups.parents);
        // A subtree that needs much room beside what it leaves behind comes first (Liu 1986). Empty groups are roots without columns.
        let mut peaks = vec![0_usize; columns.len()];
        for group in 0..columns.len() {
            let left = |g: &u32| Trapezoid::triangle(updates[*g as usize]).len();
            children[group].sort_by_key(|child| {
                std::cmp::Reverse(peaks[*child as usize].saturating_sub(left(child)))
            });
            let mut held = 0;
            let mut peak = 0;
            for child in &children[group] {
                peak = peak.max(held + peaks[*child as usize]);
                held += left(child);
            }
            peaks[group] = peak.max(held + Trapezoid::triangle(updates[group]).len());
        }
        let roots: Vec<u32> = roots
            .into_iter()
            .filter(|root| columns[*root as usize] > 0)
            .collect();
        let sequence = postorder(&children, &roots);
        let mut place = vec![NONE; columns.len()];
        for (new, old) in sequence.iter().enumerate() {
            place[*old as usize] = new as u32;
        }
        let reordered = |list: &[u32]| list.iter().map(|g| place[*g as usize]).collect::<Vec<_>>();
        let mut fronts = Self {
            forward: Vec::new(),
            inverse: Vec::new(),
            starts: vec![0],
            rows: Vec::new(),
            below: Vec::new(),
            to_parent: vec![Vec::new(); sequence.len()],
            children: Vec::new(),
            roots: reordered(&roots),
            depths: vec![0; sequence.len()],
            first_descendants: Vec::new(),
            values: vec![0],
            subtree_flops: Vec::new(),
            flops: 0.0,
            subtree_stack: Vec::new(),
        };
        // Dofs and columns.
        let mut vertex_start = vec![0_u32; graph.len()];
        for old in &sequence {
            for vertex in &groups.vertices[*old as usize] {
                vertex_start[*vertex as usize] = fronts.forward.len() as u32;
                fronts.forward.extend_from_slice(dofs(*vertex));
            }
            fronts.starts.push(fronts.forward.len() as u32);
        }
        fronts.inverse = vec![0; fronts.forward.len()];
        for (new, old) in fronts.forward.iter().enumerate() {
            fronts.inverse[*old as usize] = new as u32;
        }
        // Rows, costs.
        for (new, old) in sequence.iter().enumerate() {
            let old = *old as usize;
            let (k, update) = (columns[old], updates[old]);
            let mut rows_below = below[old].clone();
            rows_below.sort_unstable_by_key(|vertex| vertex_start[*vertex as usize]);
            let mut runs: Vec<Run> = Vec::new();
            let mut source = 0;
            for vertex in &rows_below {
                let length = graph.weights[*vertex as usize];
                push_run(
                    &mut runs,
                    Run {
                        source,
                        target: vertex_start[*vertex as usize],
                        length,
                    },
                );
                source += length;
            }
            fronts.below.push(runs);
            fronts.rows.push((k + update) as u32);
            fronts.children.push(reordered(&children[old]));
            let kids = &fronts.children[new];
            let first = kids.first().map_or(new as u32, |child| {
                fronts.first_descendants[*child as usize]
            });
            fronts.first_descendants.push(first);
            let flops = front_flops(k as f64, (k + update) as f64)
                + kids
                    .iter()
                    .map(|child| fronts.subtree_flops[*child as usize])
                    .sum::<f64>();
            fronts.subtree_flops.push(flops);
            fronts.subtree_stack.push(peaks[old]);
            let end = fronts.values[new] + packed_length(k + update, k);
            fronts.values.push(end);
        }
        let roots = fronts.roots.iter();
        fronts.flops = roots.map(|root| fronts.subtree_flops[*root as usize]).sum();
        fronts.locate_children();
        for front in (0..fronts.len()).rev() {
            let depth = fronts.depths[front] + 1;
            for child in fronts.children[front].clone() {
                fronts.depths[child as usize] = depth;
            }
        }
        fronts
    }

    fn locate_children(&mut self) {
        // Where a position of the elimination order lies in the front at hand.
        let mut local = vec![0_u32; self.forward.len()];
        for front in 0..self.len() {
            let columns = self.columns(front);
            for (position, local) in local[columns.clone()].iter_mut().enumerate() {
                *local = position as u32;
            }
            for run in &self.below[front] {
                for offset in 0..run.length {
                    local[(run.target + offset) as usize] =
                        columns.len() as u32 + run.source + offset;
                }
            }
            for child in &self.children[front] {
                let mut runs: Vec<Run> = Vec::new();
                for run in &self.below[*child as usize] {
                    for offset in 0..run.length {
                        let target = local[(run.target + offset) as usize];
                        let single = Run {
                            source: run.source + offset,
                            target,
                            length: 1,
                        };
                        // No run crosses from the parent's columns into its rows below.
                        if target as usize == columns.len() {
                            runs.push(single);
                        } else {
                            push_run(&mut runs, single);
                        }
                    }
                }
                self.to_parent[*child as usize] = runs;
            }
        }
    }

    /// Number of fronts.
    pub fn len(&self) -> usize {
        self.rows.len()
    }

    /// Whether there is nothing to eliminate.
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// Number of dofs.
    pub fn dof_count(&self) -> usize {
        self.forward.len()
    }

    /// Positions of a front's columns in the elimination order.
    pub fn columns(&self, front: usize) -> std::ops::Range<usize> {
        self.starts[front] as usize..self.starts[front + 1] as usize
    }

    /// Number of a front's columns.
    pub fn column_count(&self, front: usize) -> usize {
        (self.starts[front + 1] - self.starts[front]) as usize
    }

    /// Number of a front's rows, its columns included.
    pub fn row_count(&self, front: usize) -> usize {
        self.rows[front] as usize
    }

    /// Order of a front's update matrix.
    pub fn update_size(&self, front: usize) -> usize {
        self.row_count(front) - self.column_count(front)
    }

    /// How a front's update matrix is stored.
    pub fn update_layout(&self, front: usize) -> Trapezoid {
        Trapezoid::triangle(self.update_size(front))
    }

    /// How a front's columns are stored while they are eliminated.
    pub fn panel_layout(&self, front: usize) -> Trapezoid {
        Trapezoid {
            rows: self.row_count(front),
            columns: self.column_count(front),
        }
    }

    /// Entries of a front's update matrix.
    pub fn update_length(&self, front: usize) -> usize {
        self.update_layout(front).len()
    }

    /// Rows below a front's columns: `target` is a position of the elimination order.
    pub fn rows_below(&self, front: usize) -> &[Run] {
        &self.below[front]
    }

    /// Where the rows of a front's update lie in its parent's front; no run crosses from the parent's columns to the rows below.
    pub fn rows_in_parent(&self, front: usize) -> &[Run] {
        &self.to_parent[front]
    }

    /// Children, in the order of elimination.
    pub fn children(&self, front: usize) -> &[u32] {
        &self.children[front]
    }

    /// Fronts without parent.
    pub fn roots(&self) -> &[u32] {
        &self.roots
    }

    /// Number of fronts above.
    pub fn depth(&self, front: usize) -> usize {
        self.depths[front] as usize
    }

    /// First front of a front's subtree, which ends with itself.
    pub fn first_descendant(&self, front: usize) -> usize {
        self.first_descendants[front] as usize
    }

    /// Where a front's columns are stored, packed in strips of columns.
    pub fn value_range(&self, front: usize) -> std::ops::Range<usize> {
        self.values[front]..self.values[front + 1]
    }

    /// Where a whole subtree is stored.
    pub fn subtree_values(&self, front: usize) -> std::ops::Range<usize> {
        self.values[self.first_descendant(front)]..self.values[front + 1]
    }

    /// Number of stored entries, the padding of fronts and strips included.
    pub fn stored_entries(&self) -> usize {
        self.values.last().copied().unwrap_or(0)
    }

    /// Entries of the lower triangle, padding of the fronts included.
    pub fn factor_entries(&self) -> usize {
        (0..self.len())
            .map(|front| {
                let k = self.column_count(front);
                k * self.row_count(front) - k * k.saturating_sub(1) / 2
            })
            .sum()
    }

    /// Floating-point operations of a Cholesky factorization.
    pub fn flops(&self) -> f64 {
        self.flops
    }

    /// Largest panel of one front, entries.
    pub fn largest_panel(&self) -> usize {
        (0..self.len())
            .map(|front| self.panel_layout(front).len())
            .max()
            .unwrap_or(0)
    }
}

fn push_run(runs: &mut Vec<Run>, run: Run) {
    match runs.last_mut() {
        Some(last)
            if last.source + last.length == run.source
                && last.target + last.length == run.target =>
        {
            last.length += run.length;
        }
        _ => runs.push(run),
    }
}
