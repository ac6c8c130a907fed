//! Damaged files: an error or the right matrix, always soon, never a panic.

use std::path::Path;
use std::time::{Duration, Instant};

use dcb_import::stored::StoredMatrix;

use crate::support::{Format, Places, sample, stored_anew};

/// The longest that a damaged small file may take.
const SOON: Duration = Duration::from_secs(1);

/// All matrices that can be read of a file, where all of it works.
fn readable(format: Format, path: &Path) -> Option<Vec<(String, Places)>> {
    let listed = (format.list)(path).ok()?;
    let usable = |number: &usize| listed[*number].obstacle.is_none();
    let wanted: Vec<usize> = (0..listed.len()).filter(usable).collect();
    let read = (format.read)(path, &wanted).ok()?;
    let named = |matrix: &StoredMatrix| (matrix.name.clone(), stored_anew(matrix));
    Some(read.matrices.iter().map(named).collect())
}

/// Reads a damaged file, within the time that it may take.
fn attempt(format: Format, path: &Path) -> Option<Vec<(String, Places)>> {
    let start = Instant::now();
    let found = readable(format, path);
    assert!(start.elapsed() < SOON, "{:?}", start.elapsed());
    found
}

/// Cut off at every 64th byte, a file gives an error, or matrices that are all there.
pub fn cut_off(format: Format, name: &str) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("damaged");
    let length = std::fs::copy(sample(name), &path).unwrap();
    let right = readable(format, &path).unwrap();
    let file = std::fs::File::options().write(true).open(&path).unwrap();
    for length in (0..length / 64).rev().map(|blocks| 64 * blocks) {
        file.set_len(length).unwrap();
        for found in attempt(format, &path).unwrap_or_default() {
            let is_whole = right.iter().any(|(_, places)| *places == found.1);
            assert!(is_whole, "{name} cut off at {length}: {}", found.0);
        }
    }
}

/// Bits flipped at a few places, thousands of times.
pub fn flipped(format: Format, name: &str, times: usize) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("damaged");
    let whole = std::fs::read(sample(name)).unwrap();
    let mut state = 0x9e37_79b9_7f4a_7c15_u64;
    let mut random = |below: usize| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state % below as u64) as usize
    };
    for _ in 0..times {
        let mut bytes = whole.clone();
        for _ in 0..=random(3) {
            // Headers are where damage bites: most of it is there.
            let at = match random(4) {
                0 => random(bytes.len()),
                1 => bytes.len() - 1 - random(bytes.len().min(512)),
                _ => random(bytes.len().min(512)),
            };
            bytes[at] = random(256) as u8;
        }
        std::fs::write(&path, &bytes).unwrap();
        attempt(format, &path);
    }
}

/// A byte changed in a file whose parts have checksums: an error, or the right numbers, wherever the byte is.
pub fn checked(format: Format, name: &str) {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("damaged");
    let whole = std::fs::read(sample(name)).unwrap();
    std::fs::write(&path, &whole).unwrap();
    let right = readable(format, &path).unwrap();
    let mut refused = 0;
    for at in (0..whole.len()).step_by(whole.len() / 200) {
        let mut bytes = whole.clone();
        bytes[at] ^= 0x10;
        std::fs::write(&path, &bytes).unwrap();
        match attempt(format, &path) {
            None => refused += 1,
            Some(found) => {
                for (of, places) in found {
                    let is_right = right.iter().any(|(_, expected)| *expected == places);
                    assert!(is_right, "{name}, byte {at}: {of}");
                }
            }
        }
    }
    assert!(refused > 150, "{name}: {refused}");
}

/// A file with some bytes replaced is refused; returns the message.
pub fn replaced(format: Format, name: &str, at: usize, with: &[u8]) -> String {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("damaged");
    let mut bytes = std::fs::read(sample(name)).unwrap();
    bytes[at..at + with.len()].copy_from_slice(with);
    std::fs::write(&path, &bytes).unwrap();
    let start = Instant::now();
    let read = (format.list)(&path).and_then(|listed| {
        let all: Vec<usize> = (0..listed.len()).collect();
        (format.read)(&path, &all)
    });
    assert!(start.elapsed() < SOON, "{:?}", start.elapsed());
    let message = read.expect_err(name).to_string();
    message.replace(&format!("{}: ", path.display()), "")
}
