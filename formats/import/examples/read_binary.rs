//! Time and memory of reading a binary file with matrices, for `tests/benches/binary_matrices.py`.
//!
//! `read_binary read FILE` reads all matrices; `read_binary copy FILE` reads the bytes and copies them in memory once. One JSON line: seconds by
//! the clock and of the processor (all threads, in steps of 0.01 s), the most memory that was in use (bytes), and what the matrices take in full
//! storage (12 bytes an entry).

use std::error::Error;
use std::io::Read;
use std::path::Path;
use std::time::Instant;

use dcb_import::matrix::matlab::{version5, version73};
use dcb_import::matrix::{numpy, petsc};
use dcb_import::stored::{Content, Listed, Reading};

type List = fn(&Path) -> Result<Vec<Listed>, dcb_formats::Error>;
type Readers = fn(&Path, &[usize]) -> Result<Reading, dcb_formats::Error>;
type Format = (fn(&[u8]) -> bool, List, Readers);

const FORMATS: [Format; 4] = [
    (numpy::recognises, numpy::list, numpy::read),
    (version5::recognises, version5::list, version5::read),
    (version73::recognises, version73::list, version73::read),
    (petsc::recognises, petsc::list, petsc::read),
];

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [mode, path] = &arguments[..] else {
        return Err("expected read|copy FILE".into());
    };
    let path = Path::new(path);
    let (seconds, bytes) = match mode.as_str() {
        "read" => read(path)?,
        "copy" => copy(path)?,
        _ => return Err("expected read|copy FILE".into()),
    };
    let status = std::fs::read_to_string("/proc/self/status")?;
    let peak = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let peak: u64 = peak
        .and_then(|line| line.split_whitespace().next())
        .unwrap_or("0")
        .parse()?;
    let peak = peak * 1024;
    let processor = processor_seconds()?;
    println!(
        "{{\"seconds\": {seconds}, \"processor\": {processor}, \"peak\": {peak}, \"matrices\": {bytes}}}"
    );
    Ok(())
}

/// Of this process so far; the system counts in hundredths.
fn processor_seconds() -> Result<f64, Box<dyn Error>> {
    let told = std::fs::read_to_string("/proc/self/stat")?;
    let (_, fields) = told.rsplit_once(')').ok_or("no fields")?;
    let ticks = fields.split_whitespace().skip(11).take(2);
    let ticks: Vec<f64> = ticks.map(str::parse).collect::<Result<_, _>>()?;
    Ok(ticks.iter().sum::<f64>() / 100.0)
}

fn read(path: &Path) -> Result<(f64, usize), Box<dyn Error>> {
    let mut start = vec![0; 1 << 12];
    let count = std::fs::File::open(path)?.read(&mut start)?;
    let format = FORMATS.iter().find(|format| format.0(&start[..count]));
    let (_, list, read) = format.ok_or("an unknown format")?;
    let clock = Instant::now();
    let listed = list(path)?;
    let wanted: Vec<usize> = (0..listed.len()).collect();
    let found = read(path, &wanted)?;
    let seconds = clock.elapsed().as_secs_f64();
    let entries = found.matrices.iter().map(|matrix| match &matrix.content {
        Content::Compressed(matrix) => matrix.compute_nnz(),
        Content::Entries(blocks) => blocks.iter().map(|block| block.len()).sum(),
    });
    Ok((seconds, 12 * entries.sum::<usize>()))
}

fn copy(path: &Path) -> Result<(f64, usize), Box<dyn Error>> {
    let clock = Instant::now();
    let bytes = std::fs::read(path)?;
    let again = std::hint::black_box(bytes.clone());
    Ok((clock.elapsed().as_secs_f64(), again.len()))
}
