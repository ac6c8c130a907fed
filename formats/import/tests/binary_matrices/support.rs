//! Samples, and what must be in them.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use dcb_formats::matrix::read_matrix;
use dcb_formats::{Error, SparseMatrix};
use dcb_import::stored::{Content, Listed, Reading, StoredMatrix};

/// A reader of one format.
#[derive(Clone, Copy)]
pub struct Format {
    pub list: fn(&Path) -> Result<Vec<Listed>, Error>,
    pub read: fn(&Path, &[usize]) -> Result<Reading, Error>,
    pub recognises: fn(&[u8]) -> bool,
}

impl Format {
    /// All matrices of a sample that can be stiffness or mass, by their place in the list.
    pub fn all(self, name: &str) -> Vec<StoredMatrix> {
        let path = sample(name);
        let start = std::fs::read(&path).unwrap();
        assert!((self.recognises)(&start), "{name}");
        let listed = (self.list)(&path).unwrap();
        let usable = |number: &usize| listed[*number].obstacle.is_none();
        let wanted: Vec<usize> = (0..listed.len()).filter(usable).collect();
        let read = (self.read)(&path, &wanted).unwrap();
        assert_eq!(read.matrices.len(), wanted.len(), "{name}");
        for (matrix, number) in read.matrices.iter().zip(wanted) {
            assert_eq!(matrix.name, listed[number].name, "{name}");
            if let Some(shape) = listed[number].shape {
                assert_eq!(shape, (matrix.size as u64, matrix.size as u64), "{name}");
            }
        }
        assert_eq!(read.sha256, sha256(&path), "{name}");
        read.matrices
    }

    /// The message with which a sample is refused.
    pub fn refusal(self, name: &str) -> String {
        let path = sample(name);
        let read = (self.list)(&path).and_then(|listed| {
            let all: Vec<usize> = (0..listed.len()).collect();
            (self.read)(&path, &all)
        });
        let message = read.expect_err(name).to_string();
        message.replace(&format!("{}: ", path.display()), "")
    }
}

/// By the system's own program.
fn sha256(path: &Path) -> String {
    let told = std::process::Command::new("sha256sum").arg(path).output();
    let told = String::from_utf8(told.unwrap().stdout).unwrap();
    told.split(' ').next().unwrap().to_owned()
}

/// A file of `tests/data/exchange`.
pub fn sample(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../tests/data/exchange")
        .join(name)
}

/// Values by their place, as bits.
pub type Places = BTreeMap<(u32, u32), u64>;

/// Places of a Matrix Market file in full storage.
pub fn expected(name: &str) -> Places {
    places(&read_matrix(&sample(name)).unwrap().0)
}

fn places(matrix: &SparseMatrix) -> Places {
    let triplets = matrix.triplet_iter();
    triplets
        .map(|entry| ((entry.row as u32, entry.col as u32), entry.val.to_bits()))
        .collect()
}

/// Places of a matrix as it is stored, none twice.
pub fn stored(matrix: &StoredMatrix) -> Places {
    match &matrix.content {
        Content::Compressed(matrix) => places(matrix),
        Content::Entries(blocks) => {
            let mut found = Places::new();
            for entry in blocks.iter().flat_map(|block| block.iter()) {
                let before = found.insert((entry.row, entry.column), entry.value.to_bits());
                assert_eq!(before, None, "{entry:?} comes twice");
            }
            found
        }
    }
}

/// Places of a matrix as it is stored; of repeated ones the last.
pub fn stored_anew(matrix: &StoredMatrix) -> Places {
    match &matrix.content {
        Content::Compressed(matrix) => places(matrix),
        Content::Entries(blocks) => {
            let entries = blocks.iter().flat_map(|block| block.iter());
            entries
                .map(|entry| ((entry.row, entry.column), entry.value.to_bits()))
                .collect()
        }
    }
}

/// Without zeros.
pub fn without_zeros(mut places: Places) -> Places {
    places.retain(|_, bits| f64::from_bits(*bits) != 0.0);
    places
}

/// Whether a matrix went into memory without a copy.
pub fn is_compressed(matrix: &StoredMatrix) -> bool {
    matches!(matrix.content, Content::Compressed(_))
}

/// Holds the same places with the same bits.
pub fn assert_same(name: &str, matrix: &StoredMatrix, expected: &Places) {
    let found = stored(matrix);
    assert_eq!(found.len(), expected.len(), "{name}: entries");
    let differs = found.iter().zip(expected).find(|(a, b)| a != b);
    assert!(differs.is_none(), "{name}: {differs:?}");
}

/// The stiffness of `variants.mtx` rounded to integers, so that any type can hold it, then changed.
pub fn rounded(change: impl Fn(f64) -> f64) -> Places {
    let change = |bits: &u64| change(f64::from_bits(*bits).round_ties_even()).to_bits();
    let places = expected("variants.mtx");
    let changed = places.iter().map(|(place, bits)| (*place, change(bits)));
    without_zeros(changed.collect())
}
