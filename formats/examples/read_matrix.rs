//! Reads a matrix file and prints the seconds each pass took: `read_matrix FILE [PASSES]`.

use std::path::Path;
use std::time::Instant;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let file = arguments.next().ok_or("usage: read_matrix FILE [PASSES]")?;
    let passes: usize = arguments.next().map_or(Ok(1), |count| count.parse())?;
    for _ in 0..passes {
        let start = Instant::now();
        let (matrix, report) = dcb_formats::matrix::read_symmetric_operator(Path::new(&file))?;
        let seconds = start.elapsed().as_secs_f64();
        println!(
            "{seconds:.6} s, {} x {}, {} entries, {}",
            report.rows,
            report.columns,
            matrix.compute_nnz(),
            report.sha256
        );
    }
    Ok(())
}
