//! The matrices among the arrays of a file: those of one array, and those in pieces, as SciPy or somebody by hand saves them.

use dcb_formats::Error;

use super::arrays::Arrays;
use super::header::Element;
use crate::matrix::labels::DOF_REF;
use crate::matrix::storage::collected::obstacle_of_shape;
use crate::matrix::storage::compressed::Along;

/// A matrix before it is read.
pub(super) struct Found {
    pub(super) name: String,
    pub(super) shape: (u64, u64),
    pub(super) storage: Storage,
    pub(super) obstacle: Option<String>,
}

/// The arrays that a matrix is in, by their numbers.
#[derive(Clone, Copy, Debug)]
pub(super) enum Storage {
    /// All of it.
    Dense { data: usize },
    /// Compressed rows or columns.
    Compressed {
        along: Along,
        starts: usize,
        across: usize,
        data: usize,
    },
    /// Compressed rows of blocks, all of the same size.
    Blocks {
        starts: usize,
        across: usize,
        data: usize,
        size: u32,
    },
    /// Row, column and value of each entry.
    Places {
        rows: usize,
        columns: usize,
        data: usize,
    },
    /// Diagonals by their distance from the main one.
    Diagonals { offsets: usize, data: usize },
}

impl Storage {
    /// The array with the values.
    pub(super) fn data(self) -> usize {
        match self {
            Self::Dense { data }
            | Self::Compressed { data, .. }
            | Self::Blocks { data, .. }
            | Self::Places { data, .. }
            | Self::Diagonals { data, .. } => data,
        }
    }
}

/// The last pieces of the names by which matrices in pieces are known, and what goes with them.
const PIECES: [[&str; 3]; 3] = [
    ["indptr", "indices", "data"],
    ["row", "col", "data"],
    ["offsets", "data", "data"],
];
/// Pieces that say what the others are.
const FORMAT: &str = "format";
const SHAPE: &str = "shape";

/// All matrices of a file, in the order of their first array.
pub(super) fn matrices(arrays: &Arrays) -> Result<Vec<Found>, Error> {
    let mut is_piece = vec![false; arrays.list.len()];
    let mut in_pieces: Vec<Option<Found>> = arrays.list.iter().map(|_| None).collect();
    for (number, array) in arrays.list.iter().enumerate() {
        for pieces in PIECES {
            let Some(before) = array.name.strip_suffix(pieces[0]) else {
                continue;
            };
            let piece = |last: &str| arrays.named(&format!("{before}{last}"));
            let (Some(second), Some(data)) = (piece(pieces[1]), piece(pieces[2])) else {
                continue;
            };
            in_pieces[number] = Some(found(arrays, before, [number, second, data])?);
            for part in [
                Some(number),
                Some(second),
                Some(data),
                piece(FORMAT),
                piece(SHAPE),
                piece("_is_array"),
            ] {
                part.into_iter().for_each(|part| is_piece[part] = true);
            }
        }
    }
    let mut all = Vec::new();
    for (number, piece) in in_pieces.into_iter().enumerate() {
        match piece {
            Some(found) => all.push(found),
            None if !is_piece[number] => all.extend(dense(arrays, number)),
            None => {}
        }
    }
    Ok(all)
}

/// A matrix of one array with two axes.
fn dense(arrays: &Arrays, data: usize) -> Option<Found> {
    let array = &arrays.list[data];
    let is_numeric = matches!(
        array.header.element,
        Element::Number(_) | Element::Complex | Element::Other(_)
    );
    let [rows, columns] = array.header.shape[..] else {
        return None;
    };
    (is_numeric && !array.name.eq_ignore_ascii_case(DOF_REF)).then(|| Found {
        name: array.name.clone(),
        shape: (rows, columns),
        storage: Storage::Dense { data },
        obstacle: obstacle(&array.header.element, rows, columns),
    })
}

fn obstacle(element: &Element, rows: u64, columns: u64) -> Option<String> {
    match element {
        Element::Number(_) => obstacle_of_shape(rows, columns),
        Element::Complex => Some("complex".into()),
        Element::Text { .. } => Some("text".into()),
        Element::Object => Some("pickled".into()),
        Element::Other(name) => Some(format!("of the type {name}; save float64")),
    }
}

/// A matrix in pieces whose names begin alike: first, second and values.
fn found(arrays: &Arrays, before: &str, pieces: [usize; 3]) -> Result<Found, Error> {
    let storage = storage(arrays, before, pieces)?;
    let [first, _, data] = pieces;
    let (rows, columns) = shape(arrays, before, first, storage)?;
    Ok(Found {
        name: before.trim_end_matches(['_', '.', '/', '-']).to_owned(),
        shape: (rows, columns),
        storage,
        obstacle: obstacle(&arrays.list[data].header.element, rows, columns),
    })
}

/// Storage of a matrix by its format, said or told by its pieces.
fn storage(
    arrays: &Arrays,
    before: &str,
    [first, second, data]: [usize; 3],
) -> Result<Storage, Error> {
    let of = |number: usize| &arrays.list[number].header;
    let refused =
        |number: usize, message: String| arrays.refused(&arrays.list[number].name, message);
    let is_compressed = arrays.list[first].name.ends_with(PIECES[0][0]);
    let format = match arrays.named(&format!("{before}{FORMAT}")) {
        Some(number) => arrays.word(number)?,
        None if is_compressed && of(data).shape.len() == 3 => "bsr".into(),
        None if is_compressed => "csr".into(),
        None if arrays.list[first].name.ends_with(PIECES[1][0]) => "coo".into(),
        None => "dia".into(),
    };
    Ok(match (format.as_str(), is_compressed) {
        ("csr", true) => Storage::Compressed {
            along: Along::Rows,
            starts: first,
            across: second,
            data,
        },
        ("csc", true) => Storage::Compressed {
            along: Along::Columns,
            starts: first,
            across: second,
            data,
        },
        ("bsr", true) => match of(data).shape[..] {
            [_, rows, columns] if rows == columns && (1..=1024).contains(&rows) => {
                Storage::Blocks {
                    starts: first,
                    across: second,
                    data,
                    size: rows as u32,
                }
            }
            _ => {
                return Err(refused(
                    data,
                    format!(
                        "of shape {:?}; blocks are square, up to 1024 rows",
                        of(data).shape
                    ),
                ));
            }
        },
        ("coo", false) => Storage::Places {
            rows: first,
            columns: second,
            data,
        },
        ("dia", false) => Storage::Diagonals {
            offsets: first,
            data,
        },
        (other, _) => {
            return Err(refused(
                first,
                format!(
                    "belongs to a matrix of the format {other:?}; expected csr, csc, coo, bsr or dia"
                ),
            ));
        }
    })
}

/// Rows and columns, said or told by the pieces.
fn shape(
    arrays: &Arrays,
    before: &str,
    first: usize,
    storage: Storage,
) -> Result<(u64, u64), Error> {
    let of = |number: usize| &arrays.list[number].header;
    let refused =
        |number: usize, message: String| arrays.refused(&arrays.list[number].name, message);
    Ok(match (arrays.named(&format!("{before}{SHAPE}")), storage) {
        (Some(number), _) => match arrays.small_integers(number)?[..] {
            [rows, columns] if rows >= 0 && columns >= 0 => (rows as u64, columns as u64),
            ref other => {
                return Err(refused(
                    number,
                    format!("is {other:?}; expected rows and columns"),
                ));
            }
        },
        (None, Storage::Compressed { .. }) => square_of(of(first).count(), 1),
        (None, Storage::Blocks { size, .. }) => square_of(of(first).count(), size.into()),
        (None, Storage::Diagonals { data, .. }) => {
            let columns = of(data).shape.last().copied().unwrap_or(0);
            (columns, columns)
        }
        (None, _) => {
            let message =
                format!("needs the array {before}{SHAPE} beside it, with rows and columns");
            return Err(refused(first, message));
        }
    })
}

/// Rows and columns of a square matrix with so many starts of lines of blocks.
fn square_of(starts: Option<u64>, block: u64) -> (u64, u64) {
    let size = starts.unwrap_or(0).saturating_sub(1).saturating_mul(block);
    (size, size)
}
