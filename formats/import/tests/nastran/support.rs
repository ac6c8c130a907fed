//! Samples, matrices as maps of places, and damage.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use dcb_formats::Error;
use dcb_formats::matrix::read_symmetric_operator;
use dcb_import::stored::{Content, Listed, Reading, StoredMatrix, Triangles};

/// A reader of one format.
#[derive(Clone, Copy)]
pub struct Reader {
    pub recognises: fn(&[u8]) -> bool,
    pub list: fn(&Path) -> Result<Vec<Listed>, Error>,
    pub read: fn(&Path, &[usize]) -> Result<Reading, Error>,
}

/// Entries by their 0-based place, as bits: -0.0 isn't 0.0.
pub type Places = BTreeMap<(u32, u32), u64>;

pub fn sample(name: &str) -> PathBuf {
    let exchange = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data/exchange");
    exchange.join(name)
}

/// A symmetric Matrix Market file in full.
pub fn truth(name: &str) -> Places {
    let (matrix, _) = read_symmetric_operator(&sample(name)).unwrap();
    let (symbolic, values) = matrix.parts();
    let mut places = Places::new();
    for column in 0..matrix.ncols() {
        for at in symbolic.col_range(column) {
            let row = symbolic.row_idx()[at];
            places.insert((row, column as u32), values[at].to_bits());
        }
    }
    places
}

/// A matrix in full; no place may come twice.
pub fn full(matrix: &StoredMatrix) -> Places {
    let Content::Entries(blocks) = &matrix.content else {
        unreachable!("Nastran's matrices come as entries");
    };
    let mut places = Places::new();
    for entry in blocks.iter().flat_map(|block| block.iter()) {
        let value = entry.value.to_bits();
        let before = places.insert((entry.row, entry.column), value);
        assert!(before.is_none(), "{entry:?} comes twice");
        if matrix.triangles == Triangles::One && entry.row != entry.column {
            let before = places.insert((entry.column, entry.row), value);
            assert!(before.is_none(), "{entry:?} comes in both triangles");
        }
        assert!((entry.row as usize) < matrix.size && (entry.column as usize) < matrix.size);
    }
    places
}

/// Writes bytes to a file of their own.
pub fn file(bytes: &[u8]) -> tempfile::NamedTempFile {
    let file = tempfile::NamedTempFile::new().unwrap();
    std::fs::write(file.path(), bytes).unwrap();
    file
}

/// Largest difference of two matrices over the largest entry.
pub fn difference(found: &Places, expected: &Places) -> f64 {
    let value = |bits: Option<&u64>| f64::from_bits(bits.copied().unwrap_or(0));
    let places = found.keys().chain(expected.keys());
    let worst = places
        .map(|place| (value(found.get(place)) - value(expected.get(place))).abs())
        .fold(0.0, f64::max);
    let largest = expected.values().map(|bits| f64::from_bits(*bits).abs());
    worst / largest.fold(0.0, f64::max)
}

/// Largest relative difference of an entry.
pub fn entry_difference(found: &Places, expected: &Places) -> f64 {
    assert!(found.keys().eq(expected.keys()), "other places");
    let pairs = found.values().zip(expected.values());
    let relative = pairs.map(|(found, expected)| {
        let (found, expected) = (f64::from_bits(*found), f64::from_bits(*expected));
        (found - expected).abs() / expected.abs()
    });
    relative.fold(0.0, f64::max)
}

/// Pseudo-random numbers (xorshift).
pub struct Random(pub u64);

impl Random {
    pub fn below(&mut self, bound: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 % bound as u64) as usize
    }
}

impl Reader {
    /// What is read of the first matrices, as many as can be.
    fn matrices(&self, path: &Path) -> Result<Vec<Places>, Error> {
        let listed = (self.list)(path)?;
        let wanted: Vec<usize> = (0..listed.len())
            .filter(|&number| listed[number].obstacle.is_none())
            .collect();
        let reading = (self.read)(path, &wanted)?;
        Ok(reading.matrices.iter().map(full).collect())
    }

    /// A file cut off at every 64th byte gives an error, or all its matrices.
    pub fn is_cut_off(&self, bytes: &[u8]) {
        let whole = file(bytes);
        let all = self.matrices(whole.path()).unwrap();
        let listed = (self.list)(whole.path()).unwrap();
        let wanted: Vec<usize> = (0..listed.len())
            .filter(|&number| listed[number].obstacle.is_none())
            .collect();
        for length in (0..bytes.len()).step_by(64) {
            let part = file(&bytes[..length]);
            let _ = (self.list)(part.path());
            let Ok(reading) = (self.read)(part.path(), &wanted) else {
                continue;
            };
            let found: Vec<_> = reading.matrices.iter().map(full).collect();
            assert!(found == all, "cut off after {length} bytes");
        }
    }

    /// Flipped bytes give an error or some matrices, and quickly.
    pub fn is_flipped(&self, bytes: &[u8], times: usize) {
        let mut random = Random(0x2545_f491_4f6c_dd1d);
        let file = file(bytes);
        for _ in 0..times {
            let mut damaged = bytes.to_vec();
            for _ in 0..=random.below(3) {
                let at = random.below(damaged.len());
                damaged[at] = random.below(256) as u8;
            }
            std::fs::write(file.path(), &damaged).unwrap();
            let _ = (self.recognises)(&damaged);
            if let Ok(listed) = (self.list)(file.path()) {
                for number in 0..listed.len() {
                    let _ = (self.read)(file.path(), &[number]);
                }
            }
        }
    }
}
