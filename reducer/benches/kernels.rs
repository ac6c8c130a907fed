//! The kernels of a reduction on a generated connecting rod, with their rates: `cargo bench -p dcb-reducer`.
//!
//! Criterion's `elem` are floating-point operations (those of the factor for a factorization and an eigenvalue count), its bytes
//! what has to move at least: the factor twice for each pass of a solve, matrix and blocks once for a product. Of the whole
//! reduction they are dofs.
#![allow(clippy::unwrap_used)] // as in tests: what goes wrong ends the bench

use std::hint::black_box;
use std::time::Duration;

use criterion::{BatchSize, BenchmarkId, Criterion, Throughput};
use dcb_formats::SparseMatrix;
use dcb_reducer::model::condensation::Model;
use dcb_reducer::{Reduction, reduce};
use dcb_samples::connecting_rod;
use dcb_sparse::block_algebra::{combination, gram, symmetric_product};
use dcb_sparse::factorization::SymmetricFactor;
use faer::Mat;

#[global_allocator]
static ALLOCATOR: dcb_reducer::resources::huge_pages::HugePages =
    dcb_reducer::resources::huge_pages::HugePages;

/// 28 176 dofs.
const REFINEMENT: u32 = 1;
/// 9 918 dofs.
const SMALL_REFINEMENT: u32 = 0;
const SMALL_MODES: usize = 10;
/// σ and μ of the order of the first elastic eigenvalues.
const SHIFT: f64 = 1e7;
/// Columns of the basis that blocks are made orthogonal to.
const BASIS_COLUMNS: usize = 64;

fn block(rows: usize, columns: usize) -> Mat<f64> {
    Mat::from_fn(rows, columns, |i, j| ((i * (j + 1)) as f64).sin())
}

fn factorizations(criterion: &mut Criterion, model: &Model, factor: &mut SymmetricFactor) {
    let mut group = criterion.benchmark_group("factor");
    group.throughput(Throughput::Elements(factor.flops() as u64));
    group.bench_function("positive", |bencher| {
        bencher.iter(|| {
            let positive = factor.factorize(&model.stiffness, &model.mass, SHIFT);
            black_box(positive.is_ok())
        });
    });
    group.bench_function("eigenvalue count", |bencher| {
        bencher.iter(|| black_box(factor.inertia(&model.stiffness, &model.mass, SHIFT).is_ok()));
    });
}

fn solves(criterion: &mut Criterion, model: &Model, factor: &mut SymmetricFactor) {
    let mut group = criterion.benchmark_group("solve");
    let made = factor.factorize(&model.stiffness, &model.mass, SHIFT);
    assert!(made.is_ok());
    let bytes = factor.stored_bytes() as u64;
    let positive = factor
        .factorize(&model.stiffness, &model.mass, SHIFT)
        .unwrap();
    for columns in [1_usize, 8, 16, 32] {
        let passes = columns.div_ceil(16) as u64;
        group.throughput(Throughput::BytesDecimal(2 * bytes * passes));
        let right_sides = block(model.len(), columns);
        let id = BenchmarkId::from_parameter(columns);
        group.bench_function(id, |bencher| {
            bencher.iter_batched_ref(
                || right_sides.clone(),
                |x| positive.solve_in_place(x.as_mut()).is_ok(),
                BatchSize::LargeInput,
            );
        });
    }
}

fn products(criterion: &mut Criterion, name: &str, matrix: &SparseMatrix) {
    let mut group = criterion.benchmark_group(name);
    for columns in [8, 16] {
        let x = block(matrix.ncols(), columns);
        let bytes = 12 * matrix.compute_nnz() + 2 * 8 * matrix.ncols() * columns;
        group.throughput(Throughput::BytesDecimal(bytes as u64));
        group.bench_function(BenchmarkId::from_parameter(columns), |bencher| {
            bencher.iter(|| black_box(symmetric_product(matrix, x.as_ref())));
        });
    }
}

fn dense(criterion: &mut Criterion, rows: usize) {
    let mut group = criterion.benchmark_group("dense");
    let (basis, x) = (block(rows, BASIS_COLUMNS), block(rows, 8));
    let coefficients = block(BASIS_COLUMNS, 8);
    group.throughput(Throughput::Elements(2 * (rows * BASIS_COLUMNS * 8) as u64));
    group.bench_function("gram 64 x 8", |bencher| {
        bencher.iter(|| black_box(gram(basis.as_ref(), x.as_ref())));
    });
    group.bench_function("combination 64 x 8", |bencher| {
        bencher.iter(|| black_box(combination(basis.as_ref(), coefficients.as_ref())));
    });
}

fn whole(criterion: &mut Criterion) {
    let component = connecting_rod(SMALL_REFINEMENT);
    let mut group = criterion.benchmark_group("reduction");
    group.measurement_time(Duration::from_secs(10));
    group.throughput(Throughput::Elements(component.dofs.len() as u64));
    group.bench_function("9918 dofs", |bencher| {
        bencher.iter(|| reduce(&component, &Reduction::lowest(SMALL_MODES), &mut ()).unwrap());
    });
}

fn main() {
    let mut criterion = Criterion::default()
        .sample_size(10)
        .warm_up_time(Duration::from_secs(1))
        .measurement_time(Duration::from_secs(5))
        .configure_from_args();
    let component = connecting_rod(REFINEMENT);
    let model = Model::of(&component).unwrap();
    let mut factor =
        SymmetricFactor::analyse(&model.stiffness, &model.mass, &model.points()).unwrap();
    factorizations(&mut criterion, &model, &mut factor);
    solves(&mut criterion, &model, &mut factor);
    products(&mut criterion, "stiffness product", &model.stiffness);
    products(&mut criterion, "mass product", &model.mass);
    dense(&mut criterion, model.len());
    whole(&mut criterion);
    criterion.final_summary();
}
