#![allow(clippy::unwrap_used)]
use dcb_formats::SparseMatrix;
use dcb_samples::PseudoRandom;
use faer::sparse::Triplet;
use faer::{Mat, Side};

use super::*;
use crate::ordering::elimination_tree::{OrderedGraph, children_of, postorder};
use crate::ordering::{QuotientGraph, nested_dissection};

/// A connected random graph of `points` points with `width` dofs each; diagonally dominant if `excess` is positive.
fn random_matrix(points: u32, width: u32, excess: f64, seed: u64) -> (SparseMatrix, Vec<u32>) {
    let mut random = PseudoRandom::new(seed);
    let n = (points * width) as usize;
    let mut dense = Mat::<f64>::zeros(n, n);
    for point in 0..points {
        let mut others = vec![point];
        if point > 0 {
            others.push(point - 1);
        }
        for _ in 0..3 {
            others.push(random.below(points as usize) as u32);
        }
        for other in others {
            for a in 0..width {
                for b in 0..width {
                    let (i, j) = ((point * width + a) as usize, (other * width + b) as usize);
                    let value = 0.5 * random.number();
                    dense[(i, j)] = value;
                    dense[(j, i)] = value;
                }
            }
        }
    }
    for i in 0..n {
        let sum: f64 = (0..n).map(|j| dense[(i, j)].abs()).sum();
        dense[(i, i)] += excess * sum;
    }
    let mut entries = Vec::new();
    for j in 0..n {
        for i in 0..n {
            if dense[(i, j)] != 0.0 {
                entries.push(Triplet::new(i as u32, j as u32, dense[(i, j)]));
            }
        }
    }
    let groups = (0..n as u32).map(|dof| dof / width).collect();
    (
        SparseMatrix::try_new_from_triplets(n, n, &entries).unwrap(),
        groups,
    )
}

fn fronts_of(matrix: &SparseMatrix, groups: &[u32]) -> Fronts {
    let graph = QuotientGraph::of_points(&[matrix], groups);
    Fronts::analyse(&graph, &nested_dissection(&graph))
}

fn empty(n: usize) -> SparseMatrix {
    SparseMatrix::try_new_from_triplets(n, n, &[]).unwrap()
}

fn solved<T: Real, const N: usize>(
    fronts: &Fronts,
    matrix: &SparseMatrix,
    rhs: &Mat<f64>,
) -> Mat<f64> {
    let mass = empty(matrix.ncols());
    let mut values = vec![T::ZERO; fronts.stored_entries()];
    let pencil = Matrix {
        stiffness: matrix,
        mass: &mass,
        shift: 0.0,
    };
    eliminate(fronts, pencil, &Cholesky::<T>::default(), &mut values).unwrap();
    let mut x = rhs.clone();
    solve_columns::<T, N>(fronts, &values, x.as_mut());
    x
}

fn largest(x: &Mat<f64>) -> f64 {
    crate::block_algebra::largest_entry(x.as_ref())
}

#[test]
fn solutions_are_those_of_a_dense_factorization() {
    for (points, width) in [(1, 1), (1, 5), (40, 3), (150, 2), (90, 6)] {
        let (matrix, groups) = random_matrix(points, width, 1.1, u64::from(points));
        let fronts = fronts_of(&matrix, &groups);
        let rhs = Mat::from_fn(matrix.ncols(), 5, |i, j| ((i + 3 * j) as f64).cos());
        let dense = matrix.to_dense();
        let expected = faer::linalg::solvers::Solve::solve(&dense.llt(Side::Lower).unwrap(), &rhs);
        let narrow = solved::<f64, 8>(&fronts, &matrix, &rhs);
        let wide = solved::<f64, 16>(&fronts, &matrix, &rhs);
        let widest = solved::<f64, 32>(&fronts, &matrix, &rhs);
        let coarse = solved::<f32, 8>(&fronts, &matrix, &rhs);
        assert!(largest(&(&narrow - &expected)) < 1e-13 * largest(&expected));
        assert!(largest(&(&wide - &expected)) < 1e-13 * largest(&expected));
        assert!(largest(&(&widest - &expected)) < 1e-13 * largest(&expected));
        let single = largest(&(&coarse - &expected)) / largest(&expected);
        assert!(
            single < 1e-5 && (single > 1e-12 || points == 1),
            "{single:e}"
        );
    }
}

#[test]
fn negative_pivots_count_the_negative_eigenvalues() {
    for (points, width, seed) in [(1, 4, 1), (60, 3, 2), (120, 2, 3), (45, 6, 4)] {
        let (matrix, groups) = random_matrix(points, width, 0.0, seed);
        let fronts = fronts_of(&matrix, &groups);
        let mass = empty(matrix.ncols());
        let pencil = Matrix {
            stiffness: &matrix,
            mass: &mass,
            shift: 0.0,
        };
        let signs = eliminate(&fronts, pencil, &Indefinite, &mut []).unwrap();
        let values = matrix
            .to_dense()
            .self_adjoint_eigenvalues(Side::Lower)
            .unwrap();
        let negative = values.iter().filter(|value| **value < 0.0).count();
        assert!(negative > 0 && negative < matrix.ncols());
        assert_eq!((signs.negative, signs.zero), (negative, 0));
    }
}

#[test]
fn an_indefinite_matrix_is_told_by_the_dof_of_a_pivot() {
    let (matrix, groups) = random_matrix(80, 3, 1.1, 9);
    let n = matrix.ncols();
    let fronts = fronts_of(&matrix, &groups);
    // Only one dof's diagonal is made negative.
    let mass = SparseMatrix::try_new_from_triplets(n, n, &[Triplet::new(77, 77, 1.0)]).unwrap();
    let pencil = Matrix {
        stiffness: &matrix,
        mass: &mass,
        shift: -1e3,
    };
    let mut values = vec![0.0; fronts.stored_entries()];
    let failed = eliminate(&fronts, pencil, &Cholesky::<f64>::default(), &mut values);
    assert_eq!(failed, Err(NotPositive { dof: 77 }));
}

#[test]
fn results_are_the_same_to_the_last_bit_whatever_the_number_of_threads() {
    let (matrix, groups) = random_matrix(1500, 3, 1.1, 5);
    let rhs = Mat::from_fn(matrix.ncols(), 11, |i, j| ((i * (j + 2)) as f64).sin());
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| {
            let fronts = fronts_of(&matrix, &groups);
            solved::<f64, 16>(&fronts, &matrix, &rhs)
        })
    };
    let one = run(1);
    for threads in [2, 3, 4] {
        assert_eq!(one, run(threads));
    }
}

#[test]
fn column_counts_are_those_of_a_symbolic_elimination() {
    let (matrix, groups) = random_matrix(200, 3, 1.1, 6);
    let graph = QuotientGraph::of_points(&[&matrix], &groups);
    let order = nested_dissection(&graph);
    let ordered = OrderedGraph::of(&graph, &order);
    let (children, roots) = children_of(&ordered.elimination_tree());
    let order: Vec<u32> = postorder(&children, &roots)
        .iter()
        .map(|vertex| order[*vertex as usize])
        .collect();
    let ordered = OrderedGraph::of(&graph, &order);
    let counts = ordered.column_counts(&ordered.elimination_tree());
    // By the definition: the pattern of a dense elimination.
    let n = order.len();
    let mut filled = vec![vec![false; n]; n];
    for (column, filled) in filled.iter_mut().enumerate() {
        for row in ordered.neighbours_of(column as u32) {
            filled[*row as usize] = true;
        }
    }
    let mut entries = 0;
    for k in 0..n {
        let below: Vec<usize> = (k + 1..n).filter(|i| filled[k][*i]).collect();
        assert_eq!(counts[k] as usize, 3 * (1 + below.len()), "vertex {k}");
        entries += 9 * below.len() + 6;
        for i in &below {
            for j in &below {
                filled[*i][*j] = true;
            }
        }
    }
    let fronts = Fronts::analyse(&graph, &order);
    // Fronts store zeros on purpose, many only where they are small.
    assert!(fronts.factor_entries() >= entries);
    assert!((fronts.factor_entries() as f64) < 1.5 * entries as f64);
}
