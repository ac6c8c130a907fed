//! The graph that is dissected: dofs that belong together are one vertex.

use dcb_formats::SparseMatrix;
use rayon::prelude::*;

use super::supervariables;

/// Vertices whose adjacency one task collects; fixed, so that the graph doesn't depend on the number of threads.
const CHUNK: usize = 4096;

/// Adjacency of supervariables: sets of dofs that are eliminated together.
///
/// Lists are sorted, hold both directions of an edge and no loops. Vertices are numbered by their first dof.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct QuotientGraph {
    starts: Vec<usize>,
    neighbours: Vec<u32>,
    member_starts: Vec<usize>,
    members: Vec<u32>,
}

impl QuotientGraph {
    /// The graph of the union of symmetric patterns, each in full storage, with the dofs of a `point` (node or frame) as
    /// one vertex.
    ///
    /// Dofs of a node stay together even where their neighbours differ. Where every point has a single dof, the points
    /// tell nothing: dofs with the same neighbours are put together instead ([`Self::of_pattern`]).
    pub fn of_points(patterns: &[&SparseMatrix], points: &[u32]) -> Self {
        let vertex_of = numbered_by_first_dof(points);
        if vertex_of.iter().max().map_or(0, |last| *last as usize + 1) == points.len() {
            return Self::of_pattern(patterns);
        }
        Self::of_vertices(patterns, &vertex_of)
    }

    /// The graph of the union of symmetric patterns, each in full storage, with dofs that have the same neighbours as one
    /// vertex.
    pub fn of_pattern(patterns: &[&SparseMatrix]) -> Self {
        Self::of_vertices(
            patterns,
            &numbered_by_first_dof(&supervariables::of(patterns)),
        )
    }

    /// `vertex_of` gives each dof's vertex, 0 to the number of vertices without gaps.
    fn of_vertices(patterns: &[&SparseMatrix], vertex_of: &[u32]) -> Self {
        let (member_starts, members) = members_of_vertices(vertex_of);
        let count = member_starts.len() - 1;
        let chunks: Vec<(Vec<usize>, Vec<u32>)> = (0..count.div_ceil(CHUNK))
            .into_par_iter()
            .map_init(
                || vec![u32::MAX; count],
                |last_seen_by, chunk| {
                    let mut collector = Collector {
                        patterns,
                        vertex_of,
                        last_seen_by,
                        neighbours: Vec::new(),
                    };
                    let here = chunk * CHUNK..count.min((chunk + 1) * CHUNK);
                    let ends = here.map(|vertex| {
                        let dofs = &members[member_starts[vertex]..member_starts[vertex + 1]];
                        collector.collect(vertex as u32, dofs)
                    });
                    (ends.collect(), collector.neighbours)
                },
            )
            .collect();
        let mut starts = Vec::with_capacity(count + 1);
        starts.push(0);
        let mut neighbours = Vec::with_capacity(chunks.iter().map(|(_, list)| list.len()).sum());
        for (ends, list) in chunks {
            starts.extend(ends.iter().map(|end| neighbours.len() + end));
            neighbours.extend(list);
        }
        Self {
            starts,
            neighbours,
            member_starts,
            members,
        }
    }

    /// Number of supervariables.
    pub fn vertex_count(&self) -> usize {
        self.starts.len() - 1
    }

    /// Number of dofs.
    pub fn dof_count(&self) -> usize {
        self.members.len()
    }

    /// Whether there is nothing to order.
    pub fn is_empty(&self) -> bool {
        self.vertex_count() == 0
    }

    /// Where each vertex' neighbours begin in [`Self::all_neighbours`], and the end.
    pub fn starts(&self) -> &[usize] {
        &self.starts
    }

    /// The neighbours of vertex 0, 1, 2, ...
    pub fn all_neighbours(&self) -> &[u32] {
        &self.neighbours
    }

    /// Vertices next to a vertex, ascending, without itself.
    pub fn neighbours(&self, vertex: u32) -> &[u32] {
        let vertex = vertex as usize;
        &self.neighbours[self.starts[vertex]..self.starts[vertex + 1]]
    }

    /// Dofs of a vertex, ascending, never none.
    pub fn members(&self, vertex: u32) -> &[u32] {
        let vertex = vertex as usize;
        &self.members[self.member_starts[vertex]..self.member_starts[vertex + 1]]
    }

    /// Number of dofs of a vertex.
    pub fn weight(&self, vertex: u32) -> u32 {
        self.members(vertex).len() as u32
    }

    /// The vertices of `kept` with the edges among them; vertex `i` of the result is `kept[i]`, which ascends.
    pub(super) fn induced(&self, kept: &[u32]) -> Self {
        let mut new_index = vec![u32::MAX; self.vertex_count()];
        for (new, old) in kept.iter().enumerate() {
            new_index[*old as usize] = new as u32;
        }
        let mut graph = Self {
            starts: vec![0],
            neighbours: Vec::new(),
            member_starts: vec![0],
            members: Vec::new(),
        };
        for old in kept {
            let there = self.neighbours(*old).iter();
            graph.neighbours.extend(
                there
                    .map(|other| new_index[*other as usize])
                    .filter(|other| *other != u32::MAX),
            );
            graph.starts.push(graph.neighbours.len());
            graph.members.extend_from_slice(self.members(*old));
            graph.member_starts.push(graph.members.len());
        }
        graph
    }
}

/// Collects adjacency lists one after the other.
struct Collector<'a> {
    patterns: &'a [&'a SparseMatrix],
    vertex_of: &'a [u32],
    /// The vertex in whose list each vertex was put last.
    last_seen_by: &'a mut [u32],
    neighbours: Vec<u32>,
}

impl Collector<'_> {
    /// Appends the neighbours of a vertex and returns the new length.
    fn collect(&mut self, vertex: u32, dofs: &[u32]) -> usize {
        let begin = self.neighbours.len();
        self.last_seen_by[vertex as usize] = vertex;
        for pattern in self.patterns {
            let mut before: &[u32] = &[];
            for dof in dofs {
                let rows = pattern.row_idx_of_col_raw(*dof as usize);
                // The dofs of a node mostly have the same rows, and comparing them is faster than looking them up.
                if rows != before {
                    self.append(vertex, rows);
                }
                before = rows;
            }
        }
        let new = &mut self.neighbours[begin..];
        if !new.is_sorted() {
            new.sort_unstable();
        }
        self.neighbours.len()
    }

    fn append(&mut self, vertex: u32, rows: &[u32]) {
        for row in rows {
            let other = self.vertex_of[*row as usize];
            if self.last_seen_by[other as usize] != vertex {
                self.last_seen_by[other as usize] = vertex;
                self.neighbours.push(other);
            }
        }
    }
}

/// Labels replaced by 0, 1, 2, ... in the order of their first appearance.
fn numbered_by_first_dof(labels: &[u32]) -> Vec<u32> {
    let bound = labels.iter().max().map_or(0, |last| *last as usize + 1);
    let mut number_of = vec![u32::MAX; bound];
    let mut next = 0;
    labels
        .iter()
        .map(|label| {
            let number = &mut number_of[*label as usize];
            if *number == u32::MAX {
                *number = next;
                next += 1;
            }
            *number
        })
        .collect()
}

/// The dofs of vertex 0, 1, 2, ..., ascending within each, and where each vertex' dofs begin.
fn members_of_vertices(vertex_of: &[u32]) -> (Vec<usize>, Vec<u32>) {
    let count = vertex_of.iter().max().map_or(0, |last| *last as usize + 1);
    let mut starts = vec![0_usize; count + 1];
    for vertex in vertex_of {
        starts[*vertex as usize + 1] += 1;
    }
    for vertex in 0..count {
        starts[vertex + 1] += starts[vertex];
    }
    let mut next = starts.clone();
    let mut members = vec![0; vertex_of.len()];
    for (dof, vertex) in vertex_of.iter().enumerate() {
        members[next[*vertex as usize]] = dof as u32;
        next[*vertex as usize] += 1;
    }
    (starts, members)
}
