//! Reading a generated Matrix Market file to a complete symmetric matrix, with SHA-256: `cargo bench -p dcb-formats`.
#![allow(clippy::unwrap_used)] // as in tests: what goes wrong ends the bench

use std::fmt::Write as _;
use std::hint::black_box;
use std::time::Duration;

use criterion::{Criterion, Throughput};
use dcb_formats::matrix::read_symmetric_operator;

const SIZE: usize = 30_000;
/// Entries of a column on and below the diagonal.
const COLUMN_ENTRIES: usize = 40;

/// A band of every third diagonal with 17 digits a value, column after column: one triangle, or both.
fn band(symmetry: &str, is_triangle: bool) -> String {
    let mut lines = String::new();
    let mut count = 0;
    let reach = 3 * (COLUMN_ENTRIES - 1);
    for column in 0..SIZE {
        let first = if is_triangle {
            column
        } else {
            column % 3 + (column - column % 3).saturating_sub(reach)
        };
        for row in (first..SIZE.min(column + reach + 1)).step_by(3) {
            let value = 1e9 * ((row.min(column) * 7 + row.max(column)) as f64).sin();
            let _ = writeln!(lines, "{} {} {value:.16e}", row + 1, column + 1);
            count += 1;
        }
    }
    format!("%%MatrixMarket matrix coordinate real {symmetry}\n{SIZE} {SIZE} {count}\n{lines}")
}

fn main() {
    let mut criterion = Criterion::default()
        .sample_size(20)
        .warm_up_time(Duration::from_secs(1))
        .measurement_time(Duration::from_secs(5))
        .configure_from_args();
    let folder = tempfile::tempdir().unwrap();
    let mut group = criterion.benchmark_group("read");
    for (symmetry, is_triangle) in [("symmetric", true), ("general", false)] {
        let path = folder.path().join(symmetry);
        let text = band(symmetry, is_triangle);
        std::fs::write(&path, &text).unwrap();
        group.throughput(Throughput::BytesDecimal(text.len() as u64));
        group.bench_function(symmetry, |bencher| {
            bencher.iter(|| black_box(read_symmetric_operator(&path).unwrap()));
        });
    }
    group.finish();
    criterion.final_summary();
}
