#![allow(clippy::unwrap_used)]

use std::collections::BTreeSet;

use dcb_formats::SparseMatrix;
use dcb_samples::Material;
use dcb_samples::solid::{SolidElement, box_block};
use faer::sparse::Triplet;

use super::fill::Fill;
use super::*;

/// A symmetric pattern with a full diagonal.
fn pattern(size: usize, edges: impl IntoIterator<Item = (u32, u32)>) -> SparseMatrix {
    let mut entries: Vec<_> = (0..size as u32).map(|i| Triplet::new(i, i, 1.0)).collect();
    for (a, b) in edges {
        entries.extend([Triplet::new(a, b, 1.0), Triplet::new(b, a, 1.0)]);
    }
    SparseMatrix::try_new_from_triplets(size, size, &entries).unwrap()
}

/// Edges of a grid of `side`³ vertices from `first` on, each next to its six neighbours.
fn grid(side: u32, first: u32) -> Vec<(u32, u32)> {
    let mut edges = Vec::new();
    for vertex in 0..side.pow(3) {
        for (step, along) in [
            (1, vertex % side),
            (side, vertex / side % side),
            (side * side, vertex / side / side),
        ] {
            if along + 1 < side {
                edges.push((first + vertex, first + vertex + step));
            }
        }
    }
    edges
}

/// Every vertex on its own.
fn graph_of(pattern: &SparseMatrix) -> QuotientGraph {
    let graph = QuotientGraph::of_points(&[pattern], &labels(pattern.ncols()));
    assert_eq!(graph.vertex_count(), pattern.ncols());
    graph
}

fn labels(count: usize) -> Vec<u32> {
    (0..count as u32).collect()
}

fn assert_permutation(order: &[u32], count: usize) {
    let mut sorted = order.to_vec();
    sorted.sort_unstable();
    assert_eq!(sorted, labels(count));
}

/// A block: stiffness, mass, and the node of each dof.
fn solid(element: SolidElement) -> (SparseMatrix, SparseMatrix, Vec<u32>) {
    let block = box_block([6, 5, 4], [0.6, 0.5, 0.4], element, &Material::STEEL).into_draft();
    let nodes = block.dofs.nodal_dofs().iter().map(|dof| dof.node).collect();
    (block.stiffness, block.mass, nodes)
}

#[test]
fn dofs_of_a_node_stay_together_and_every_dof_appears_once() {
    let (stiffness, mass, nodes) = solid(SolidElement::Hexahedron20);
    let graph = QuotientGraph::of_points(&[&stiffness, &mass], &nodes);
    let order = nested_dissection(&graph);
    let dofs: Vec<u32> = order
        .iter()
        .flat_map(|vertex| graph.members(*vertex).iter().copied())
        .collect();
    assert_permutation(&dofs, nodes.len());
    for three in dofs.chunks(3) {
        assert!(
            three
                .iter()
                .all(|dof| nodes[*dof as usize] == nodes[three[0] as usize])
        );
    }
}

#[test]
fn quotient_graph_is_the_union_of_the_patterns_over_nodes() {
    let (stiffness, _, nodes) = solid(SolidElement::Hexahedron20);
    // A mass that couples what the stiffness doesn't.
    let last = stiffness.ncols() as u32 - 1;
    let mass = pattern(stiffness.ncols(), [(0, last), (7, last)]);
    let graph = QuotientGraph::of_points(&[&stiffness, &mass], &nodes);
    let mut expected = vec![BTreeSet::new(); graph.vertex_count()];
    for matrix in [&stiffness, &mass] {
        for column in 0..matrix.ncols() {
            let here = nodes[column];
            let there = matrix.row_idx_of_col_raw(column).iter();
            expected[here as usize].extend(there.map(|row| nodes[*row as usize]));
        }
    }
    for (vertex, mut list) in expected.into_iter().enumerate() {
        list.remove(&(vertex as u32));
        let found = graph.neighbours(vertex as u32);
        assert_eq!(found, list.into_iter().collect::<Vec<_>>());
        let dofs = graph.members(vertex as u32);
        assert!(dofs.iter().all(|dof| nodes[*dof as usize] == vertex as u32));
        assert_eq!(graph.weight(vertex as u32) as usize, dofs.len());
    }
    assert_eq!(graph.dof_count(), nodes.len());
}

#[test]
fn supervariables_of_a_solid_without_a_dof_table_are_its_nodes() {
    let (stiffness, mass, nodes) = solid(SolidElement::Hexahedron);
    let patterns = [&stiffness, &mass];
    let named = QuotientGraph::of_points(&patterns, &nodes);
    let found = QuotientGraph::of_points(&patterns, &labels(nodes.len()));
    assert!(found == named);
}

#[test]
fn supervariables_of_quadratic_elements_are_whole_nodes_of_the_same_elements() {
    let (stiffness, mass, nodes) = solid(SolidElement::Hexahedron20);
    let graph = QuotientGraph::of_pattern(&[&stiffness, &mass]);
    // Where a single element has an edge of the block to itself, the nodes of that edge see the same.
    assert!(graph.vertex_count() < nodes.len() / 3);
    for vertex in 0..graph.vertex_count() as u32 {
        let dofs = graph.members(vertex);
        let here: BTreeSet<u32> = dofs.iter().map(|dof| nodes[*dof as usize]).collect();
        assert_eq!(dofs.len(), 3 * here.len());
        for dof in dofs {
            assert_eq!(
                stiffness.row_idx_of_col_raw(*dof as usize),
                stiffness.row_idx_of_col_raw(dofs[0] as usize)
            );
        }
    }
}

#[test]
fn dofs_are_merged_by_both_patterns_and_only_where_neighbours_agree() {
    // 0, 1 and 2 see each other and 3; the mass takes 2 apart by its edge to 4.
    let stiffness = pattern(5, [(0, 1), (0, 2), (1, 2), (0, 3), (1, 3), (2, 3), (3, 4)]);
    let mass = pattern(5, [(2, 4)]);
    let members = |graph: &QuotientGraph| -> Vec<Vec<u32>> {
        let vertices = 0..graph.vertex_count() as u32;
        vertices.map(|v| graph.members(v).to_vec()).collect()
    };
    let alone = QuotientGraph::of_pattern(&[&stiffness]);
    assert_eq!(members(&alone), [vec![0, 1, 2], vec![3], vec![4]]);
    let both = QuotientGraph::of_pattern(&[&stiffness, &mass]);
    assert_eq!(members(&both), [vec![0, 1], vec![2, 3], vec![4]]);
    assert_eq!(both.neighbours(0), [1]);
    assert_eq!(both.neighbours(1), [0, 2]);
}

#[test]
fn dissection_of_a_cube_beats_its_natural_order() {
    let side = 14;
    let count = side * side * side;
    let graph = graph_of(&pattern(count as usize, grid(side, 0)));
    let order = nested_dissection(&graph);
    assert_permutation(&order, count as usize);
    let natural = Fill::of(&graph, &labels(count as usize));
    let dissected = Fill::of(&graph, &order);
    assert!(
        dissected.flops < 0.4 * natural.flops,
        "{dissected:?} against {natural:?}"
    );
}

#[test]
fn fill_of_a_dense_matrix_is_its_triangle() {
    let graph = QuotientGraph::of_pattern(&[&pattern(3, [(0, 1)])]);
    // A full pair and a single dof: 3 + 1 entries, 1 + 4 + 1 multiplications.
    let fill = Fill::of(&graph, &[0, 1]);
    assert_eq!((fill.entries, fill.flops), (4.0, 6.0));
}

#[test]
fn dense_rows_come_last_and_add_their_own_rows_only() {
    let side = 14;
    let cube = side * side * side;
    // A rigid frame's six dofs, next to every other vertex of the cube, are one dense vertex.
    let frame = cube..cube + 6;
    let coupled = frame
        .clone()
        .flat_map(|dof| (0..cube).step_by(2).map(move |v| (dof, v)));
    let among = frame.clone().flat_map(|a| (cube..a).map(move |b| (a, b)));
    let edges = grid(side, 0).into_iter().chain(coupled).chain(among);
    let size = cube as usize + 6;
    let matrix = pattern(size, edges);
    let graph = QuotientGraph::of_pattern(&[&matrix]);
    assert_eq!(graph.members(cube), frame.collect::<Vec<_>>());

    let order = nested_dissection(&graph);
    assert_permutation(&order, cube as usize + 1);
    assert_eq!(order.last(), Some(&cube));
    let with = Fill::of(&graph, &order);
    let without = graph_of(&pattern(cube as usize, grid(side, 0)));
    let without = Fill::of(&without, &nested_dissection(&without));
    let rows_of_the_frame = 6.0 * size as f64;
    assert!(
        with.entries <= without.entries + rows_of_the_frame,
        "{with:?} against {without:?}"
    );
    // Eliminated first, it would fill the factor.
    let mut worst = order;
    worst.rotate_right(1);
    assert!(Fill::of(&graph, &worst).entries > 5.0 * with.entries);
}

#[test]
fn components_are_dissected_as_if_alone() {
    let (small, large) = (8_u32, 12_u32);
    let first_of_large = small.pow(3);
    // Two cubes, and at the end a few vertices without any edge.
    let count = (first_of_large + large.pow(3) + 5) as usize;
    let edges = grid(small, 0)
        .into_iter()
        .chain(grid(large, first_of_large));
    let graph = graph_of(&pattern(count, edges));
    let order = nested_dissection(&graph);
    assert_permutation(&order, count);
    let alone: f64 = [small, large]
        .into_iter()
        .map(|side| {
            let cube = graph_of(&pattern(side.pow(3) as usize, grid(side, 0)));
            Fill::of(&cube, &nested_dissection(&cube)).flops
        })
        .sum();
    assert_eq!(Fill::of(&graph, &order).flops, alone + 5.0);
}

#[test]
fn graphs_without_edges_keep_their_order() {
    for count in [0, 1, 2, 300] {
        let graph = QuotientGraph::of_pattern(&[&pattern(count, [])]);
        assert_eq!(graph.is_empty(), count == 0);
        assert_eq!(nested_dissection(&graph), labels(count));
    }
    let none = QuotientGraph::of_points(&[], &[]);
    assert!(nested_dissection(&none).is_empty());
}

#[test]
fn small_and_full_graphs_are_ordered() {
    for count in 2..40_u32 {
        let chain = (1..count).map(|i| (i - 1, i));
        let full = (0..count).flat_map(|i| (0..i).map(move |j| (i, j)));
        let with_tail = full.chain([(count - 1, count)]);
        let graphs = [
            QuotientGraph::of_pattern(&[&pattern(count as usize, chain)]),
            QuotientGraph::of_pattern(&[&pattern(count as usize + 1, with_tail)]),
        ];
        for graph in graphs {
            assert_permutation(&nested_dissection(&graph), graph.vertex_count());
        }
    }
}

#[test]
fn graph_and_order_are_the_same_for_any_number_of_threads_and_at_the_same_time() {
    let (stiffness, mass, nodes) = solid(SolidElement::Hexahedron20);
    let patterns = [&stiffness, &mass];
    let ordered = |points: &[u32]| {
        let graph = QuotientGraph::of_points(&patterns, points);
        let order = nested_dissection(&graph);
        (graph, order)
    };
    let on_threads = |count| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(count);
        pool.build()
            .unwrap()
            .install(|| rayon::join(|| ordered(&nodes), || ordered(&labels(nodes.len()))))
    };
    let one = on_threads(1);
    for _ in 0..3 {
        assert!(on_threads(4) == one);
    }
}

/// The dissection in Rust alone is a little worse than METIS', and as good as it is when it is the only one.
#[test]
fn the_dissection_in_rust_alone_fills_little_more() {
    for element in [SolidElement::Tetra10, SolidElement::Hexahedron20] {
        let (stiffness, mass, nodes) = solid(element);
        let graph = QuotientGraph::of_points(&[&stiffness, &mass], &nodes);
        let order = feral::dissect(&graph, &[], 1).unwrap();
        assert_permutation(&order, graph.vertex_count());
        let [alone, built_in] =
            [order, nested_dissection(&graph)].map(|order| Fill::of(&graph, &order).flops);
        println!("{element:?}: {:.3}", alone / built_in);
        assert!(
            alone < 1.3 * built_in,
            "{element:?}: {alone:e} {built_in:e}"
        );
    }
}

/// The graph of the nodes of a block of elements, and those that are first in an element, its corners.
fn quadratic(element: SolidElement, cells: [usize; 3]) -> (QuotientGraph, BTreeSet<u32>) {
    let size = [0.6, 0.5, 0.05];
    let block = box_block(cells, size, element, &Material::STEEL).into_draft();
    let nodes: Vec<u32> = block.dofs.nodal_dofs().iter().map(|dof| dof.node).collect();
    let graph = QuotientGraph::of_points(&[&block.stiffness, &block.mass], &nodes);
    let corners = block.mesh.cells.iter().flat_map(|block| {
        let elements = block.nodes.chunks(block.nodes_per_cell);
        elements.flat_map(|nodes| nodes[..4].iter().copied())
    });
    (graph, corners.collect())
}

#[test]
fn midside_nodes_of_tetrahedra_are_dominated_by_their_corners() {
    let (graph, corners) = quadratic(SolidElement::Tetra10, [6, 5, 4]);
    let dominated = Dominated::of(&graph).unwrap();
    let kept: BTreeSet<u32> = dominated.kept.iter().copied().collect();
    let midside = kept.difference(&corners).count();
    println!(
        "{} corners, kept {} and {midside} others",
        corners.len(),
        kept.len()
    );
    assert!(kept.len() as f64 > 0.7 * corners.len() as f64);
    assert!((midside as f64) < 0.1 * corners.len() as f64);
    let weights: u32 = dominated.weights().iter().sum();
    let dofs = 2 * graph.dof_count() as u32;
    assert!(weights <= dofs && f64::from(weights) > 0.95 * f64::from(dofs));
    // Of hexahedra, whose nodes on an edge see more than half of what its ends see, all nodes are dissected.
    for element in [SolidElement::Hexahedron, SolidElement::Hexahedron20] {
        assert!(Dominated::of(&quadratic(element, [6, 5, 4]).0).is_none());
    }
}

/// Dissecting the corners alone costs little fill where a part is small, and saves some where it is large.
#[test]
fn orders_of_corners_fill_as_much_as_orders_of_all_nodes() {
    for element in [SolidElement::Tetra10, SolidElement::Hexahedron20] {
        for cells in [[12, 10, 8], [24, 20, 2], [40, 3, 3], [24, 20, 16]] {
            let (graph, _) = quadratic(element, cells);
            let order = nested_dissection(&graph);
            assert_permutation(&order, graph.vertex_count());
            let weights: Vec<u32> = (0..order.len() as u32).map(|v| graph.weight(v)).collect();
            let [found, whole] =
                [order, by_library(&graph, &weights, 1)].map(|order| Fill::of(&graph, &order));
            println!(
                "{element:?} {cells:?}: flops {:.3}, entries {:.3}",
                found.flops / whole.flops,
                found.entries / whole.entries
            );
            assert!(found.flops < 1.12 * whole.flops, "{element:?} {cells:?}");
            assert!(
                found.entries < 1.08 * whole.entries,
                "{element:?} {cells:?}"
            );
        }
    }
}
