//! Sparse matrices from files, in the Matrix Market exchange format (plain or gzipped).
//!
//! Coordinate and array files with real, integer or pattern entries, general, symmetric or skew-symmetric; complex ones are
//! refused. The file is mapped, cut at line ends, read by all threads and assembled into full, sorted compressed columns; what is
//! stored on the way is half the matrix (and the text of a gzipped file, which goes before the matrix comes). The result is the
//! same bit for bit whatever the number of threads. Nothing is allocated from an announced size before the file's length makes it
//! plausible.

mod assemble;
mod body;
mod bytes;
mod entries;
mod foreign;
mod header;
mod number;
mod shared;
mod symmetry;

use std::path::Path;

use assemble::{CannotAssemble, Columns, Expansion};
use bytes::FileBytes;
use header::{Field, Header, Layout, Symmetry};

use crate::{Error, SparseMatrix};

/// What was found while reading a matrix.
#[derive(Clone, Debug, PartialEq)]
pub struct MatrixReport {
    /// File name without its folder.
    pub file_name: String,
    /// SHA-256 of the file's bytes as they are on disk, hex.
    pub sha256: String,
    /// Rows.
    pub rows: usize,
    /// Columns.
    pub columns: usize,
    /// Entries as the file stores them, one a line.
    pub stored_entries: usize,
    /// Stored entries that were added to an earlier one in the same place.
    pub duplicates_summed: usize,
    /// Stored coordinate entries with the value zero; they stay in the pattern. Zeros of an array are not stored at all.
    pub explicit_zeros: usize,
    /// Largest |a_ij - a_ji| / max(|a_ij|, |a_ji|, √|a_ii a_jj|) before averaging. Zero unless an operator was stored as `general`.
    pub largest_asymmetry: f64,
}

/// Reads any real, integer or pattern matrix. Symmetric and skew-symmetric files are expanded to full storage, pattern entries
/// are 1, a vector is one column, duplicates are summed in file order.
///
/// # Errors
/// [`Error::Io`] if the file can't be read, [`Error::Line`] or [`Error::File`] if it isn't such a matrix: among others
/// complex or not finite values, indices out of range, entries missing or left over, a pair stored in both triangles of a
/// symmetric file, damaged gzip data, sizes out of proportion to the file.
pub fn read_matrix(path: &Path) -> Result<(SparseMatrix, MatrixReport), Error> {
    read(path, Purpose::AnyMatrix)
}

/// Reads a stiffness or mass matrix: square, real, exactly symmetric in full storage. A `general` file is checked for symmetry;
/// differences of rounding level are averaged and reported.
///
/// # Errors
/// As [`read_matrix`]; besides for pattern, skew-symmetric, hermitian and non-square matrices, for vectors, and for a
/// `general` file whose asymmetry is beyond rounding, with its worst pair.
pub fn read_symmetric_operator(path: &Path) -> Result<(SparseMatrix, MatrixReport), Error> {
    read(path, Purpose::SymmetricOperator)
}

/// Looks only at the beginning of a file: whether it could be a stiffness or mass matrix.
///
/// # Errors
/// As [`read_symmetric_operator`], for what shows before the first entry.
pub fn check_operator_header(path: &Path) -> Result<(), Error> {
    let file = FileBytes::open(path)?;
    let text = bytes::text_of(path, file.as_slice())?;
    let text = text.strip_prefix(BYTE_ORDER_MARK).unwrap_or(&text);
    refuse_as_operator(path, &Header::read(path, text)?)
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Purpose {
    AnyMatrix,
    SymmetricOperator,
}

/// The matrix with what was found on the way.
struct Parsed {
    columns: Columns,
    stored_entries: usize,
    explicit_zeros: usize,
    largest_asymmetry: f64,
}

fn read(path: &Path, purpose: Purpose) -> Result<(SparseMatrix, MatrixReport), Error> {
    let file = FileBytes::open(path)?;
    let stored = file.as_slice();
    let (parsed, sha256) = rayon::join(
        || parse(path, stored, purpose),
        || bytes::sha256_hex(stored),
    );
    let Parsed {
        columns,
        stored_entries,
        explicit_zeros,
        largest_asymmetry,
    } = parsed?;
    let report = MatrixReport {
        file_name: path
            .file_name()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned(),
        sha256,
        rows: columns.row_count,
        columns: columns.column_count(),
        stored_entries,
        duplicates_summed: columns.duplicates_summed,
        explicit_zeros,
        largest_asymmetry,
    };
    Ok((columns.into_matrix(), report))
}

/// UTF-8's, which some editors put in front.
const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

fn parse(path: &Path, stored: &[u8], purpose: Purpose) -> Result<Parsed, Error> {
    let text = bytes::text_of(path, stored)?;
    let without_mark = text.strip_prefix(BYTE_ORDER_MARK).unwrap_or(&text);
    let header = Header::read(path, without_mark)?;
    if purpose == Purpose::SymmetricOperator {
        refuse_as_operator(path, &header)?;
    }
    let chunks = body::read_entries(path, without_mark, &header)?;
    if header.is_mirrored() && header.layout == Layout::Coordinate {
        symmetry::refuse_pairs_in_both_triangles(path, without_mark, &header, &chunks)?;
    }
    drop(text);
    let explicit_zeros = chunks.iter().map(|chunk| chunk.zero_count).sum();
    let expansion = match header.symmetry {
        Symmetry::General => Expansion::AsStored,
        Symmetry::Symmetric | Symmetry::Hermitian => Expansion::Mirrored,
        Symmetry::Skew => Expansion::MirroredNegated,
    };
    let columns =
        Columns::assemble(chunks, header.rows, header.columns, expansion).map_err(|refusal| {
            Error::File {
                path: path.into(),
                message: cannot_assemble(refusal),
            }
        })?;
    let (columns, largest_asymmetry) =
        if purpose == Purpose::SymmetricOperator && !header.is_mirrored() {
            symmetry::averaged(path, columns)?
        } else {
            (columns, 0.0)
        };
    Ok(Parsed {
        columns,
        stored_entries: header.entries as usize,
        explicit_zeros,
        largest_asymmetry,
    })
}

fn refuse_as_operator(path: &Path, header: &Header) -> Result<(), Error> {
    let expected = "a stiffness or mass matrix has to be real and symmetric";
    let refuse = |line, found: &str| {
        Err(Error::Line {
            path: path.into(),
            line,
            message: format!("{found}; {expected}"),
        })
    };
    if header.is_vector {
        return refuse(header.size_line, "a vector");
    }
    if header.field == Field::Pattern {
        return refuse(1, "a pattern without values");
    }
    match header.symmetry {
        Symmetry::Skew => return refuse(1, "a skew-symmetric matrix"),
        Symmetry::Hermitian => return refuse(1, "a hermitian matrix"),
        Symmetry::General | Symmetry::Symmetric => {}
    }
    if header.rows != header.columns {
        return refuse(
            header.size_line,
            &format!("{} rows and {} columns", header.rows, header.columns),
        );
    }
    Ok(())
}

fn cannot_assemble(refusal: CannotAssemble) -> String {
    match refusal {
        CannotAssemble::TooMany { entries } => {
            format!(
                "{entries} entries in full storage; at most {} are supported",
                u32::MAX
            )
        }
        CannotAssemble::NotFinite { row, column } => {
            format!(
                "the duplicates of ({}, {}) add up to something infinite",
                row + 1,
                column + 1
            )
        }
    }
}
