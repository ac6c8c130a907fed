//! Which columns make a front: those with the same rows below, and small neighbours in the tree where the zeros that this stores
//! cost less than the handling of many small fronts.

use crate::ordering::elimination_tree::{NONE, OrderedGraph, children_of};

/// Largest share of stored zeros in a front of up to so many columns.
const ZEROS_ALLOWED: [(u64, f64); 4] = [(8, 1.0), (32, 0.6), (96, 0.12), (u64::MAX, 0.04)];

/// Groups of vertices that are eliminated together, a tree.
pub struct Groups {
    /// Vertices of each group, ascending; empty for a group that was merged into another.
    pub vertices: Vec<Vec<u32>>,
    /// Parent group.
    pub parents: Vec<u32>,
}

/// Columns, rows (columns included) and stored zeros of a front.
#[derive(Clone, Copy)]
struct Shape {
    columns: u64,
    rows: u64,
    zeros: u64,
}

impl Shape {
    fn merged_into(self, parent: Self) -> Self {
        let rows = self.columns + parent.rows;
        Self {
            columns: self.columns + parent.columns,
            rows,
            zeros: self.zeros + parent.zeros + self.columns * (rows - self.rows),
        }
    }

    fn is_worth_it(self) -> bool {
        let stored = self.columns * self.rows - self.columns * (self.columns.max(1) - 1) / 2;
        ZEROS_ALLOWED
            .iter()
            .find(|(columns, _)| self.columns <= *columns)
            .is_some_and(|(_, share)| self.zeros as f64 <= share * stored as f64)
    }
}

/// Gathers the vertices of a postordered graph into groups.
pub fn gather(graph: &OrderedGraph, parents: &[u32], counts: &[u32]) -> Groups {
    let (mut groups, mut shapes) = same_rows(graph, parents, counts);
    let (mut children, _) = children_of(&groups.parents);
    for group in 0..shapes.len() {
        // Children are in their final form, because a child's number is smaller.
        let mut candidates = std::mem::take(&mut children[group]);
        let mut kept = Vec::new();
        // The largest first: it brings the fewest zeros along.
        candidates.sort_by_key(|child| shapes[*child as usize].rows);
        while let Some(child) = candidates.pop() {
            let merged = shapes[child as usize].merged_into(shapes[group]);
            if merged.is_worth_it() {
                shapes[group] = merged;
                let mut vertices = std::mem::take(&mut groups.vertices[child as usize]);
                vertices.append(&mut groups.vertices[group]);
                groups.vertices[group] = vertices;
                candidates.append(&mut children[child as usize]);
                groups.parents[child as usize] = NONE;
            } else {
                kept.push(child);
            }
        }
        for child in &kept {
            groups.parents[*child as usize] = group as u32;
        }
        children[group] = kept;
        groups.vertices[group].sort_unstable();
    }
    groups
}

/// Chains of vertices with the same rows below.
fn same_rows(graph: &OrderedGraph, parents: &[u32], counts: &[u32]) -> (Groups, Vec<Shape>) {
    let n = graph.len();
    let mut group_of = vec![0_u32; n];
    let mut vertices: Vec<Vec<u32>> = Vec::new();
    for vertex in 0..n {
        let continues = vertex > 0
            && parents[vertex - 1] == vertex as u32
            && counts[vertex - 1] == counts[vertex] + graph.weights[vertex - 1];
        if !continues {
            vertices.push(Vec::new());
        }
        let group = vertices.len() - 1;
        group_of[vertex] = group as u32;
        vertices[group].push(vertex as u32);
    }
    let group_parents = vertices
        .iter()
        .map(|members| {
            let last = members.last().map_or(0, |v| *v as usize);
            match parents[last] {
                NONE => NONE,
                parent => group_of[parent as usize],
            }
        })
        .collect();
    let shapes = vertices
        .iter()
        .map(|members| Shape {
            columns: members
                .iter()
                .map(|v| u64::from(graph.weights[*v as usize]))
                .sum(),
            rows: u64::from(counts[members[0] as usize]),
            zeros: 0,
        })
        .collect();
    (
        Groups {
            vertices,
            parents: group_parents,
        },
        shapes,
    )
}
