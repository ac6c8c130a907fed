//! Reads all real, square matrices of a file and prints the seconds each pass took, and the largest memory: `read_matrices FILE [PASSES]`.

use std::path::Path;
use std::time::Instant;

use dcb_import::MatrixFile;
use dcb_import::stored::Content;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let file = arguments
        .next()
        .ok_or("usage: read_matrices FILE [PASSES]")?;
    let passes: usize = arguments.next().map_or(Ok(1), |count| count.parse())?;
    for _ in 0..passes {
        let start = Instant::now();
        let matrices = MatrixFile::open(Path::new(&file))?;
        let listed = start.elapsed().as_secs_f64();
        let listing = matrices.listed().iter().enumerate();
        let wanted = listing.filter(|(_, one)| one.obstacle.is_none());
        let wanted: Vec<usize> = wanted.map(|(number, _)| number).collect();
        let start = Instant::now();
        let reading = matrices.read(&wanted)?;
        let seconds = start.elapsed().as_secs_f64();
        for matrix in &reading.matrices {
            let entries: usize = match &matrix.content {
                Content::Entries(blocks) => blocks.iter().map(|block| block.len()).sum(),
                Content::Compressed(matrix) => matrix.compute_nnz(),
            };
            println!(
                "{seconds:.6} s ({listed:.6} s to list), {} `{}`, {} rows, {entries} entries, {:?} digits, peak {} kB",
                matrices.format_name(),
                matrix.name,
                matrix.size,
                matrix.digits,
                peak().unwrap_or_default(),
            );
        }
    }
    Ok(())
}

/// Largest memory of this process so far, kB, where the system says it.
fn peak() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
    line.split_whitespace().nth(1)?.parse().ok()
}
