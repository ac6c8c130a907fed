//! Vertices that a neighbour dominates: it sees them and all that they see.
//!
//! The midside nodes of quadratic tetrahedra are such vertices, dominated by the corners at the ends of their edge: seven of eight nodes of a
//! mesh. Eliminated right before the first of their dominators they make no fill that it wouldn't make. So only the others are dissected, a
//! graph of an eighth of the size.
//!
//! A separator of corners would take all midside nodes between its corners along. Those of them that see one side of it only are eliminated
//! on that side.

use rayon::prelude::*;

use super::QuotientGraph;
use super::elimination_tree::OrderedGraph;

/// The whole graph is dissected if less than this share of the vertices is dominated by one that sees twice as much: in meshes of hexahedra orders of the
/// corners fill up to a fifth more.
const WORTH_IT: f64 = 0.65;

/// Vertices that nobody dominates, and by which of them the others are dominated.
pub(super) struct Dominated<'a> {
    graph: &'a QuotientGraph,
    /// Those that nobody dominates, ascending.
    pub kept: Vec<u32>,
    /// Of each vertex the kept ones that dominate it; none of a kept vertex.
    dominators: Vec<Vec<u32>>,
}

impl<'a> Dominated<'a> {
    /// `None` if there are too few to be worth it.
    pub fn of(graph: &'a QuotientGraph) -> Option<Self> {
        let vertices = 0..graph.vertex_count() as u32;
        let mut dominators: Vec<Vec<u32>> = vertices
            .clone()
            .into_par_iter()
            .map(|vertex| dominators(graph, vertex))
            .collect();
        let is_kept: Vec<bool> = dominators.iter().map(Vec::is_empty).collect();
        let kept: Vec<u32> = vertices.filter(|v| is_kept[*v as usize]).collect();
        let size = |vertex: usize| graph.neighbours(vertex as u32).len();
        let is_small = |(vertex, list): &(usize, &Vec<u32>)| {
            let mut others = list.iter();
            others.any(|other| size(*other as usize) >= 2 * size(*vertex))
        };
        let small = dominators.iter().enumerate().filter(is_small).count();
        if (small as f64) < WORTH_IT * graph.vertex_count() as f64 {
            return None;
        }
        for list in &mut dominators {
            list.retain(|other| is_kept[*other as usize]);
        }
        Some(Self {
            graph,
            kept,
            dominators,
        })
    }

    /// Weights of the kept vertices with their shares of the dominated ones, times two.
    pub fn weights(&self) -> Vec<u32> {
        let mut weights = vec![0; self.graph.vertex_count()];
        for (vertex, dominators) in self.dominators.iter().enumerate() {
            let own = 2 * self.graph.weight(vertex as u32);
            if dominators.is_empty() {
                weights[vertex] += own;
            }
            for other in dominators {
                weights[*other as usize] += own / dominators.len() as u32;
            }
        }
        self.kept.iter().map(|v| weights[*v as usize]).collect()
    }

    /// All vertices in an order of the kept ones, whose graph is `among_kept`.
    pub fn inserted(&self, among_kept: &QuotientGraph, order: &[u32]) -> Vec<u32> {
        let mut places = vec![NOT_KEPT; self.graph.vertex_count()];
        for (place, vertex) in order.iter().enumerate() {
            places[self.kept[*vertex as usize] as usize] = place as u32;
        }
        let tree = Tree {
            parents: OrderedGraph::of(among_kept, order).elimination_tree(),
        };
        let vertices = (0..places.len() as u32).into_par_iter();
        let sides: Vec<Option<u32>> = vertices
            .clone()
            .map(|vertex| self.one_side(vertex, &places, &tree))
            .collect();
        let mut keys: Vec<(Place, u32)> = vertices
            .map(|vertex| (self.place(vertex, &places, &sides, &tree), vertex))
            .collect();
        keys.par_sort_unstable();
        keys.into_iter().map(|(_, vertex)| vertex).collect()
    }

    /// The place of its first dominator.
    fn first_dominator(&self, vertex: u32, places: &[u32]) -> Option<u32> {
        let dominators = self.dominators[vertex as usize].iter();
        dominators.map(|v| places[*v as usize]).min()
    }

    /// The last of the kept vertices that it sees before its first dominator, if they are all on one way to the root of the tree.
    fn one_side(&self, vertex: u32, places: &[u32], tree: &Tree) -> Option<u32> {
        let first = self.first_dominator(vertex, places)?;
        let seen = self.graph.neighbours(vertex).iter();
        let mut before = seen.map(|v| places[*v as usize]).filter(|v| *v < first);
        let start = before.next()?;
        before.try_fold(start, |last, next| tree.higher(last, next))
    }

    /// Where a vertex goes. Two that see each other go to one side together or not at all: an element inside a separator has them both.
    fn place(&self, vertex: u32, places: &[u32], sides: &[Option<u32>], tree: &Tree) -> Place {
        let Some(first) = self.first_dominator(vertex, places) else {
            return Place {
                of: places[vertex as usize],
                side: Side::Itself,
                degree: 0,
            };
        };
        let seen = self.graph.neighbours(vertex);
        let on_one_side = sides[vertex as usize].filter(|own| {
            let mut others = seen.iter().filter_map(|v| sides[*v as usize]);
            others.all(|other| tree.higher(*own, other).is_some())
        });
        Place {
            of: on_one_side.unwrap_or(first),
            side: match on_one_side {
                Some(_) => Side::After,
                None => Side::Before,
            },
            // What is dominated by another dominated vertex sees less, and comes before it.
            degree: seen.len(),
        }
    }
}

/// In place of the place of a dominated vertex: after all others.
const NOT_KEPT: u32 = u32::MAX;

/// A place beside a kept vertex.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Place {
    of: u32,
    side: Side,
    degree: usize,
}

#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Side {
    Before,
    Itself,
    After,
}

/// The elimination tree of the kept vertices, by their places.
struct Tree {
    parents: Vec<u32>,
}

impl Tree {
    /// The higher one of two vertices on one way to the root.
    fn higher(&self, a: u32, b: u32) -> Option<u32> {
        let (mut lower, higher) = (a.min(b), a.max(b));
        // A parent comes later; that of a root comes after all.
        while lower < higher {
            lower = self.parents[lower as usize];
        }
        (lower == higher).then_some(higher)
    }
}

/// Neighbours of a vertex that see all that it sees, and more or come before it.
fn dominators(graph: &QuotientGraph, vertex: u32) -> Vec<u32> {
    let seen = graph.neighbours(vertex);
    let dominates = |other: &u32| {
        let others = graph.neighbours(*other);
        let is_larger =
            others.len() > seen.len() || (others.len() == seen.len() && *other < vertex);
        is_larger && contains(others, seen, *other)
    };
    seen.iter().copied().filter(dominates).collect()
}

/// Whether a list contains another one but for one vertex; both ascending.
fn contains(list: &[u32], part: &[u32], but: u32) -> bool {
    let mut rest = list.iter();
    part.iter()
        .filter(|vertex| **vertex != but)
        .all(|vertex| rest.by_ref().find(|other| *other >= vertex) == Some(vertex))
}
