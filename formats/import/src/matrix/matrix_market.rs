//! Matrix Market files, by the reader of components.

use std::path::Path;

use dcb_formats::Error;
use dcb_formats::matrix::{check_operator_header, read_symmetric_operator};

use crate::stored::{Content, Listed, Reading, StoredMatrix, Triangles};

pub(crate) fn recognises(start: &[u8]) -> bool {
    let start = start.strip_prefix(b"\xef\xbb\xbf").unwrap_or(start);
    let banner = b"%%matrixmarket";
    (start.get(..banner.len())).is_some_and(|first| first.eq_ignore_ascii_case(banner))
}

pub(crate) fn list(path: &Path) -> Result<Vec<Listed>, Error> {
    check_operator_header(path)?;
    Ok(vec![Listed {
        name: String::new(),
        shape: None,
        obstacle: None,
    }])
}

pub(crate) fn read(path: &Path, wanted: &[usize]) -> Result<Reading, Error> {
    let (matrix, report) = read_symmetric_operator(path)?;
    let mut notes = Vec::new();
    if report.duplicates_summed > 0 {
        notes.push(format!(
            "{} repeated entries were summed",
            report.duplicates_summed
        ));
    }
    let stored = StoredMatrix {
        triangles: Triangles::Both,
        notes,
        ..StoredMatrix::unlabelled(String::new(), report.rows, Content::Compressed(matrix))
    };
    Ok(Reading {
        matrices: wanted
            .iter()
            .map(|_| ())
            .zip([stored])
            .map(|(_, stored)| stored)
            .collect(),
        sha256: report.sha256,
    })
}
