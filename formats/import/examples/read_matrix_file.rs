//! Time and memory of reading one file, for `formats/import/benches/read_matrices.py`: `read_matrix_file MODE FILE`.
//!
//! `ours` reads the file's first matrix as `reduce import` does, up to the full, sorted matrix; `matrix_market` reads a Matrix Market file as
//! `reduce` does; `copy` reads the bytes and copies them in memory once. Printed is one line of JSON: seconds up to the entries and up to the
//! full matrix, seconds of all processors (in steps of 0.01 s), the most memory after both (bytes), rows, entries in full storage.

use std::error::Error;
use std::path::Path;
use std::time::Instant;

use dcb_formats::SparseMatrix;
use dcb_formats::matrix::blocks::{Entries, Expansion, assembled};
use dcb_formats::matrix::read_symmetric_operator;
use dcb_import::MatrixFile;
use dcb_import::stored::{Content, StoredMatrix, Triangles};
use serde_json::json;

/// When something was done, and the most memory until then.
struct Reached {
    seconds: f64,
    peak: u64,
}

impl Reached {
    fn since(start: Instant) -> Self {
        Self {
            seconds: start.elapsed().as_secs_f64(),
            peak: peak_memory(),
        }
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [mode, path] = &arguments[..] else {
        return Err("usage: read_matrix_file ours|matrix_market|copy FILE".into());
    };
    let path = Path::new(path);
    let start = Instant::now();
    let (read, matrix) = match mode.as_str() {
        "ours" => {
            let mut reading = MatrixFile::open(path)?.read(&[0])?;
            let read = Reached::since(start);
            (read, Some(whole(reading.matrices.remove(0))?))
        }
        "matrix_market" => {
            let (matrix, _) = read_symmetric_operator(path)?;
            (Reached::since(start), Some(matrix))
        }
        "copy" => {
            let bytes = std::fs::read(path)?;
            std::hint::black_box(bytes.clone());
            (Reached::since(start), None)
        }
        other => return Err(format!("{other}: no such mode").into()),
    };
    let whole = Reached::since(start);
    println!(
        "{}",
        json!({
            "read_s": read.seconds,
            "whole_s": whole.seconds,
            "processor_s": processor_seconds()?,
            "read_peak": read.peak,
            "whole_peak": whole.peak,
            "rows": matrix.as_ref().map_or(0, |matrix| matrix.nrows()),
            "entries": matrix.as_ref().map_or(0, |matrix| matrix.compute_nnz()),
        })
    );
    Ok(())
}

/// Both triangles, sorted.
fn whole(stored: StoredMatrix) -> Result<SparseMatrix, String> {
    let mut entries = match stored.content {
        Content::Compressed(matrix) => return Ok(matrix),
        Content::Entries(entries) => entries,
    };
    let expansion = match stored.triangles {
        Triangles::One => Expansion::Mirrored,
        Triangles::Unsaid if !has_both(&entries) => Expansion::Mirrored,
        Triangles::Both | Triangles::Unsaid => Expansion::AsStored,
    };
    if expansion == Expansion::AsStored && entries.iter().all(Entries::stand_by_rows) {
        entries.iter_mut().for_each(Entries::transpose);
    }
    let assembled = assembled(entries, (stored.size, stored.size), expansion);
    Ok(assembled.map_err(|reason| format!("{reason:?}"))?.0)
}

fn has_both(blocks: &[Entries]) -> bool {
    let entries = blocks.iter().flat_map(|block| block.iter());
    let mut off_diagonal = entries.filter(|entry| entry.row != entry.column);
    let Some(first) = off_diagonal.next() else {
        return false;
    };
    off_diagonal.any(|entry| (entry.row > entry.column) != (first.row > first.column))
}

/// Most memory that the process had, in bytes; 0 where the system doesn't tell.
fn peak_memory() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let number = line.and_then(|line| line.split_whitespace().next());
    1024 * number.and_then(|number| number.parse().ok()).unwrap_or(0)
}

/// Of this process so far; the system counts in hundredths.
fn processor_seconds() -> Result<f64, Box<dyn Error>> {
    let told = std::fs::read_to_string("/proc/self/stat")?;
    let (_, fields) = told.rsplit_once(')').ok_or("no fields")?;
    let ticks = fields.split_whitespace().skip(11).take(2);
    let ticks: Vec<f64> = ticks.map(str::parse).collect::<Result<_, _>>()?;
    Ok(ticks.iter().sum::<f64>() / 100.0)
}
