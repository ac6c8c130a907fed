//! Texts that tests make up.

use dcb_import::stored::StoredMatrix;

use crate::support::{Format, Places, stored};

/// The matrix of a text.
pub fn read_text(format: Format, text: impl AsRef<[u8]>) -> Result<StoredMatrix, String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("part");
    std::fs::write(&path, text).unwrap();
    let read = (format.list)(&path).and_then(|_| (format.read)(&path, &[0]));
    match read {
        Ok(mut read) => Ok(read.matrices.remove(0)),
        Err(error) => Err(error
            .to_string()
            .replace(&path.display().to_string(), "part")),
    }
}

/// A text is refused with these words.
#[track_caller]
pub fn assert_refused(format: Format, text: impl AsRef<[u8]>, words: &str) {
    let message = read_text(format, text).map(|_| "read".to_owned());
    let message = message.unwrap_or_else(|message| message);
    assert!(message.contains(words), "no {words:?} in: {message}");
}

/// Both triangles of one.
pub fn mirrored(mut places: Places) -> Places {
    let images: Vec<_> = places
        .iter()
        .map(|((row, column), bits)| ((*column, *row), *bits))
        .collect();
    for (place, bits) in images {
        assert_eq!(*places.entry(place).or_insert(bits), bits, "{place:?}");
    }
    places
}

/// The places of a matrix that stores one triangle, in full storage.
pub fn completed(matrix: &StoredMatrix) -> Places {
    mirrored(stored(matrix))
}

/// Lower triangle of some places.
pub fn lower(mut places: Places) -> Places {
    places.retain(|(row, column), _| row >= column);
    places
}

/// A text, gzipped.
pub fn gzip(text: &[u8]) -> Vec<u8> {
    let mut packed = Vec::new();
    let mut encoder = flate2::read::GzEncoder::new(text, flate2::Compression::fast());
    std::io::Read::read_to_end(&mut encoder, &mut packed).unwrap();
    packed
}
