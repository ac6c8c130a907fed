//! Reads a text matrix and prints what it took: `read_text_matrix FORMAT FILE`.
//!
//! FORMAT is `coordinate`, `dmig`, `harwell_boeing`, `matrix_input`, `op4_binary`, `op4_text`, `substructure` or `matrix_market`; of several matrices the
//! first is read. Printed are the seconds of reading, the seconds up to the full, sorted matrix, the peak of memory after both in kB, rows, entries in full storage, and the digest.

use std::path::Path;
use std::time::Instant;

use dcb_formats::matrix::blocks::{Expansion, assembled};
use dcb_formats::matrix::read_symmetric_operator;
use dcb_import::matrix::abaqus::{coordinate, matrix_input, substructure};
use dcb_import::matrix::harwell_boeing;
use dcb_import::matrix::nastran::{dmig, op4};
use dcb_import::stored::{Content, Triangles};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [format, file] = &arguments[..] else {
        return Err("usage: read_text_matrix FORMAT FILE".into());
    };
    let path = Path::new(file);
    let read = match format.as_str() {
        "coordinate" => coordinate::read,
        "dmig" => dmig::read,
        "harwell_boeing" => harwell_boeing::read,
        "matrix_input" => matrix_input::read,
        "op4_binary" => op4::binary::read,
        "op4_text" => op4::text::read,
        "substructure" => substructure::read,
        "matrix_market" => {
            let start = Instant::now();
            let (matrix, report) = read_symmetric_operator(path)?;
            let whole = start.elapsed().as_secs_f64();
            let peak = peak_memory();
            println!(
                "{whole:.6} {whole:.6} {peak} {peak} {} {} {}",
                report.rows,
                matrix.compute_nnz(),
                report.sha256
            );
            return Ok(());
        }
        other => return Err(format!("{other}: unknown format").into()),
    };
    let start = Instant::now();
    let mut reading = read(path, &[0])?;
    let read_seconds = start.elapsed().as_secs_f64();
    let read_peak = peak_memory();
    let stored = reading.matrices.remove(0);
    let Content::Entries(entries) = stored.content else {
        return Err("compressed already".into());
    };
    let has_both = |blocks: &[dcb_formats::matrix::blocks::Entries]| {
        let mut entries = blocks.iter().flat_map(|block| block.iter());
        let first = entries.find(|entry| entry.row != entry.column);
        let is_lower = first.is_none_or(|entry| entry.row > entry.column);
        entries.any(|entry| entry.row != entry.column && (entry.row > entry.column) != is_lower)
    };
    let expansion = match stored.triangles {
        Triangles::One => Expansion::Mirrored,
        Triangles::Both => Expansion::AsStored,
        Triangles::Unsaid if has_both(&entries) => Expansion::AsStored,
        Triangles::Unsaid => Expansion::Mirrored,
    };
    let assembled = assembled(entries, (stored.size, stored.size), expansion);
    let (matrix, _) = assembled.map_err(|reason| format!("{reason:?}"))?;
    println!(
        "{read_seconds:.6} {:.6} {read_peak} {} {} {} {}",
        start.elapsed().as_secs_f64(),
        peak_memory(),
        stored.size,
        matrix.compute_nnz(),
        reading.sha256
    );
    Ok(())
}

/// Most memory that the process had, in kB; 0 where the system doesn't tell.
fn peak_memory() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let number = line.and_then(|line| line.split_whitespace().next());
    number.and_then(|number| number.parse().ok()).unwrap_or(0)
}
