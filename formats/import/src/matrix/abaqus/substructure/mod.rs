//! Substructures of Abaqus and CalculiX (`*SUBSTRUCTURE MATRIX OUTPUT`): `*USER ELEMENT` with its nodes, then dense matrices, `*MATRIX, TYPE=STIFFNESS` and others.
//!
//! The numbers stand four in a line, and every row begins a new line. Symmetric matrices are lower triangles row by row; in a file that says
//! UNSYM, a matrix may still be such a triangle, so that the count of numbers decides. Zeros are left out.

mod head;
mod numbers;

use std::path::Path;

use dcb_formats::Error;
use dcb_formats::matrix::blocks::{Entries, TextBlocks, Triplet};
use rayon::prelude::*;

use self::head::Head;
use self::numbers::{Dense, Part, read_matrices};
use crate::stored::{Content, Listed, Reading, Rows, StoredMatrix, Triangles};
use crate::text::line_blocks::{filled_lines, look_at_text, read_text};

/// The matrices of the file, called as their types are: `STIFFNESS`, `MASS`.
///
/// # Errors
/// As [`read`], except for what shows in the numbers only.
pub fn list(path: &Path) -> Result<Vec<Listed>, Error> {
    let (head, types) = look_at_text(path, |text| {
        let head = Head::read(path, text)?;
        let types = numbers::types(path, text, head.line_count)?;
        Ok((head, types))
    })?;
    let size = head.rows.len() as u64;
    let listed = |name| Listed {
        name,
        shape: Some((size, size)),
        obstacle: None,
    };
    Ok(types.into_iter().map(listed).collect())
}

/// Whether the first line that is no comment is `*USER ELEMENT`.
pub fn recognises(start: &[u8]) -> bool {
    let mut lines = filled_lines(start).filter(|line| !line.starts_with(b"**"));
    lines
        .next()
        .is_some_and(|line| head::is_keyword(line, b"*USER ELEMENT"))
}

/// Reads matrices by their number in the list. Rows are in the order of the file.
///
/// # Errors
/// [`Error::Line`] for lines that are no numbers, labels or directions out of range, rows that are longer or shorter than they should be;
/// [`Error::File`] for numbers that are missing, and two elements in a file; [`Error::NotEnoughMemory`]; and what reading a text meets.
pub fn read(path: &Path, wanted: &[usize]) -> Result<Reading, Error> {
    let ((head, matrices), sha256) = read_text(path, |text: &mut TextBlocks| {
        let head = Head::read(path, text)?;
        let matrices = read_matrices(path, text, head.line_count)?;
        Ok((head, matrices))
    })?;
    let mut found: Vec<Option<Dense>> = matrices.into_iter().map(Some).collect();
    let mut matrices = Vec::with_capacity(wanted.len());
    for number in wanted {
        let Some(dense) = found.get_mut(*number).and_then(Option::take) else {
            return Err(Error::File {
                path: path.into(),
                message: format!("has no matrix {} that isn't taken yet", number + 1),
            });
        };
        matrices.push(stored(path, &head, dense)?);
    }
    Ok(Reading { matrices, sha256 })
}

fn stored(path: &Path, head: &Head, dense: Dense) -> Result<StoredMatrix, Error> {
    let size = head.rows.len();
    let count = dense.count();
    let (full, triangle) = (size * size, size * (size + 1) / 2);
    let triangles = match count {
        _ if count == triangle => Triangles::One,
        _ if count == full => Triangles::Both,
        _ => {
            return Err(Error::Line {
                path: path.into(),
                line: dense.line,
                message: format!(
                    "{} has {count} numbers; {size} rows have {triangle} (the lower triangle) or {full}",
                    dense.name
                ),
            });
        }
    };
    let (name, digits) = (dense.name.clone(), dense.digits.count());
    let content = placed(path, dense, size, triangles)?;
    let labels = head.rows.iter().map(|key| key.label()).collect();
    Ok(StoredMatrix {
        name,
        size,
        triangles,
        content: Content::Entries(content),
        rows: match head.has_labels {
            true => Rows::Labelled(labels),
            false => Rows::Unlabelled,
        },
        digits,
        notes: match head.has_labels {
            true => Vec::new(),
            false => {
                vec!["the file has no line `** ELEMENT NODES` with the labels of its nodes".into()]
            }
        },
    })
}

/// Gives the numbers their places; a row that doesn't begin a line shows that some are missing or left over.
fn placed(
    path: &Path,
    dense: Dense,
    size: usize,
    triangles: Triangles,
) -> Result<Vec<Entries>, Error> {
    let length = |row: usize| match triangles {
        Triangles::Both => size,
        Triangles::One | Triangles::Unsaid => row + 1,
    };
    let (mut row, mut column) = (0, 0);
    let mut starts = Vec::with_capacity(dense.parts.len());
    for part in &dense.parts {
        starts.push((row, column));
        for (line, count) in part.line_counts.iter().enumerate() {
            column += usize::from(*count);
            if column > length(row) {
                return Err(Error::Line {
                    path: path.into(),
                    line: part.first_line + line as u64,
                    message: format!(
                        "row {} of {} has more than {} numbers here; every row begins a new line",
                        row + 1,
                        dense.name,
                        length(row)
                    ),
                });
            }
            if column == length(row) {
                (row, column) = (row + 1, 0);
            }
        }
    }
    let placed = |(part, start): (Part, _)| {
        let count = part.values.len();
        entries(part.values, start, length).ok_or_else(|| Error::NotEnoughMemory {
            path: path.into(),
            needed: Entries::bytes_of(count),
            allowed: None,
        })
    };
    let parts = dense.parts.into_par_iter().zip(starts);
    parts.map(placed).collect()
}

/// Numbers of rows of some lengths, from a place on; `None` without memory.
fn entries(
    values: Vec<f64>,
    (mut row, mut column): (usize, usize),
    length: impl Fn(usize) -> usize,
) -> Option<Entries> {
    let mut entries = Entries::with_capacity(values.len())?;
    for value in values {
        if value != 0.0 {
            entries.push(Triplet {
                row: row as u32,
                column: column as u32,
                value,
            });
        }
        column += 1;
        if column == length(row) {
            (row, column) = (row + 1, 0);
        }
    }
    entries.give_back_room();
    Some(entries)
}
