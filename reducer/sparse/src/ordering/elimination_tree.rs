//! Elimination tree and column counts of a weighted graph (Liu 1990; Gilbert, Ng and Peyton 1994).

use super::QuotientGraph;

/// Marks "none" in arrays of vertices and fronts.
pub const NONE: u32 = u32::MAX;

/// A graph whose vertices stand for some rows each, numbered in elimination order.
pub struct OrderedGraph {
    starts: Vec<usize>,
    neighbours: Vec<u32>,
    /// Rows of each vertex.
    pub weights: Vec<u32>,
}

impl OrderedGraph {
    /// Number of vertices.
    pub fn len(&self) -> usize {
        self.weights.len()
    }

    /// Neighbours of a vertex.
    pub fn neighbours_of(&self, vertex: u32) -> &[u32] {
        let vertex = vertex as usize;
        &self.neighbours[self.starts[vertex]..self.starts[vertex + 1]]
    }

    /// The vertices of a graph in elimination order, `order[new] = old`.
    pub fn of(graph: &QuotientGraph, order: &[u32]) -> Self {
        let mut rank = vec![0_u32; order.len()];
        for (new, old) in order.iter().enumerate() {
            rank[*old as usize] = new as u32;
        }
        let mut starts = Vec::with_capacity(order.len() + 1);
        let mut neighbours = Vec::with_capacity(graph.all_neighbours().len());
        starts.push(0);
        for old in order {
            neighbours.extend(graph.neighbours(*old).iter().map(|v| rank[*v as usize]));
            starts.push(neighbours.len());
        }
        Self {
            starts,
            neighbours,
            weights: order.iter().map(|old| graph.weight(*old)).collect(),
        }
    }

    /// Parent of each vertex in the elimination tree.
    pub fn elimination_tree(&self) -> Vec<u32> {
        let n = self.len();
        let (mut parents, mut ancestors) = (vec![NONE; n], vec![NONE; n]);
        for vertex in 0..n as u32 {
            for neighbour in self.neighbours_of(vertex).iter().filter(|v| **v < vertex) {
                let mut lower = *neighbour;
                loop {
                    let next = ancestors[lower as usize];
                    if next == vertex {
                        break;
                    }
                    ancestors[lower as usize] = vertex;
                    if next == NONE {
                        parents[lower as usize] = vertex;
                        break;
                    }
                    lower = next;
                }
            }
        }
        parents
    }

    /// Rows of each vertex's columns in the factor, its own included; the graph must be numbered in postorder.
    pub fn column_counts(&self, parents: &[u32]) -> Vec<u32> {
        let n = self.len();
        // Signed contributions of whole row subtrees, summed up the tree at the end.
        let mut counts: Vec<i64> = vec![0; n];
        let mut first = vec![NONE; n];
        for vertex in 0..n as u32 {
            counts[vertex as usize] = match first[vertex as usize] {
                NONE => i64::from(self.weights[vertex as usize]),
                _ => 0,
            };
            let mut up = vertex;
            while up != NONE && first[up as usize] == NONE {
                first[up as usize] = vertex;
                up = parents[up as usize];
            }
        }
        let mut sets: Vec<u32> = (0..n as u32).collect();
        let (mut last_first, mut last_leaf) = (vec![NONE; n], vec![NONE; n]);
        for vertex in 0..n as u32 {
            let parent = parents[vertex as usize];
            if parent != NONE {
                counts[parent as usize] -= i64::from(self.weights[vertex as usize]);
            }
            for row in self.neighbours_of(vertex).iter().filter(|v| **v > vertex) {
                let row = *row as usize;
                // A leaf of the row's subtree: no descendant of it was seen in this row before.
                let seen = last_first[row];
                if seen != NONE && first[vertex as usize] <= seen {
                    continue;
                }
                last_first[row] = first[vertex as usize];
                counts[vertex as usize] += i64::from(self.weights[row]);
                let previous = std::mem::replace(&mut last_leaf[row], vertex);
                if previous != NONE {
                    let common = root_of(&mut sets, previous);
                    counts[common as usize] -= i64::from(self.weights[row]);
                }
            }
            if parent != NONE {
                sets[vertex as usize] = parent;
            }
        }
        for vertex in 0..n {
            if parents[vertex] != NONE {
                counts[parents[vertex] as usize] += counts[vertex];
            }
        }
        counts.into_iter().map(|count| count as u32).collect()
    }
}

fn root_of(sets: &mut [u32], start: u32) -> u32 {
    let mut root = start;
    while sets[root as usize] != root {
        root = sets[root as usize];
    }
    let mut next = start;
    while next != root {
        next = std::mem::replace(&mut sets[next as usize], root);
    }
    root
}

/// Children before parents, each subtree contiguous; children in the order of `children`.
pub fn postorder(children: &[Vec<u32>], roots: &[u32]) -> Vec<u32> {
    let mut order = Vec::with_capacity(children.len());
    let mut stack: Vec<(u32, usize)> = Vec::new();
    for root in roots {
        stack.push((*root, 0));
        while let Some((vertex, next)) = stack.last_mut() {
            match children[*vertex as usize].get(*next) {
                Some(child) => {
                    *next += 1;
                    stack.push((*child, 0));
                }
                None => {
                    order.push(*vertex);
                    stack.pop();
                }
            }
        }
    }
    order
}

/// Children of each vertex, ascending, and the roots.
pub fn children_of(parents: &[u32]) -> (Vec<Vec<u32>>, Vec<u32>) {
    let mut children = vec![Vec::new(); parents.len()];
    let mut roots = Vec::new();
    for (vertex, parent) in parents.iter().enumerate() {
        match *parent {
            NONE => roots.push(vertex as u32),
            parent => children[parent as usize].push(vertex as u32),
        }
    }
    (children, roots)
}
