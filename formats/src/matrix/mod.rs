//! Sparse matrices from files, in the Matrix Market exchange format (plain or gzipped).
//!
//! Coordinate and array files with real, integer or pattern entries, general, symmetric or skew-symmetric; complex ones are
//! refused. The file is read once, in blocks of lines that are hashed and decompressed one after the other and parsed by all
//! threads, and assembled into full, sorted compressed columns; what is stored on the way is half the matrix, and never the text.
//! So the digest is that of the bytes which the entries come from; a file that was changed meanwhile is refused. The result is the
//! same bit for bit whatever the number of threads. Nothing is allocated from an announced size before the file's length makes it
//! plausible.

mod assemble;
mod banner;
mod block_reading;
mod bytes;
mod entries;
mod entry_blocks;
mod entry_reader;
mod foreign;
mod gathered;
mod header;
mod number;
mod shared;
mod symmetry;

use std::path::Path;

use assemble::{CannotAssemble, Columns, Expansion, full_count};
use bytes::{BLOCK, TextBlocks};
use entry_blocks::Blocks;
use header::{Field, Layout, MatrixHeader, Symmetry};
pub(crate) use symmetry::made_symmetric;

use crate::{Error, SparseMatrix};

/// A matrix with sorted columns made exactly symmetric, and its largest relative asymmetry; beyond rounding, what is wrong in words.
///
/// # Errors
/// The worst pair, in words.
#[doc(hidden)]
pub fn symmetrized(matrix: SparseMatrix) -> Result<(SparseMatrix, f64), String> {
    made_symmetric(matrix).map_err(String::from)
}

// No part of the door: for readers of other formats.
#[doc(hidden)]
pub mod blocks {
    //! Text in blocks that all threads work on, and entries on their way into a matrix.

    pub use super::assemble::{CannotAssemble, Expansion, assembled};
    pub use super::block_reading::{Rest, read_blocks, read_blocks_in_context};
    pub use super::bytes::{CR_ALONE, TextBlocks};
    pub use super::entries::{Entries, Triplet};
    pub use super::entry_blocks::likely_line_count;
    pub use super::gathered::Gathered;
    pub use super::header::shown;
    pub use super::number::{NotANumber, integer, real, unsigned};
}

/// Report of reading a matrix.
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
/// symmetric file, damaged gzip data, sizes out of proportion to the file, a file that was changed while it was read.
pub fn read_matrix(path: &Path) -> Result<(SparseMatrix, MatrixReport), Error> {
    MatrixReader::default().read_matrix(path)
}

/// Reads a stiffness or mass matrix: square, real, exactly symmetric in full storage. A `general` file is checked for symmetry;
/// differences of rounding level are averaged and reported.
///
/// # Errors
/// As [`read_matrix`]; besides for pattern, skew-symmetric, hermitian and non-square matrices, for vectors, and for a
/// `general` file whose asymmetry is beyond rounding, with its worst pair.
pub fn read_symmetric_operator(path: &Path) -> Result<(SparseMatrix, MatrixReport), Error> {
    MatrixReader::default().read_symmetric_operator(path)
}

/// Looks only at the beginning of a file: whether it could be a stiffness or mass matrix.
///
/// # Errors
/// As [`read_symmetric_operator`], for what shows before the first entry.
pub fn check_operator_header(path: &Path) -> Result<(), Error> {
    let header = read_header(path, &mut TextBlocks::open(path)?)?;
    refuse_as_operator(path, &header)
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Purpose {
    AnyMatrix,
    SymmetricOperator,
}

/// Reads matrices that are held together, within a limit of memory.
#[derive(Clone, Copy, Debug, Default)]
pub struct MatrixReader {
    limit: Option<u64>,
    /// Bytes of the matrices that were read.
    held: u64,
}

impl MatrixReader {
    /// So many bytes may be taken, by the matrices and by what is needed on the way; `None` for no limit.
    pub fn new(limit: Option<u64>) -> Self {
        Self { limit, held: 0 }
    }

    /// As [`read_matrix`].
    ///
    /// # Errors
    /// Besides, [`Error::NotEnoughMemory`].
    pub fn read_matrix(&mut self, path: &Path) -> Result<(SparseMatrix, MatrixReport), Error> {
        self.read(path, Purpose::AnyMatrix)
    }

    /// As [`read_symmetric_operator`].
    ///
    /// # Errors
    /// Besides, [`Error::NotEnoughMemory`].
    pub fn read_symmetric_operator(
        &mut self,
        path: &Path,
    ) -> Result<(SparseMatrix, MatrixReport), Error> {
        self.read(path, Purpose::SymmetricOperator)
    }

    fn read(
        &mut self,
        path: &Path,
        purpose: Purpose,
    ) -> Result<(SparseMatrix, MatrixReport), Error> {
        let mut text = TextBlocks::open(path)?;
        let (header, blocks) = match self.read_entries(path, &mut text, purpose) {
            Ok(read) => read,
            Err(error @ Error::Line { .. }) => return Err(text.reason_or(error)),
            Err(error) => return Err(error),
        };
        let sha256 = text.finish()?;
        if header.is_mirrored() && header.layout == Layout::Coordinate {
            symmetry::refuse_pairs_in_both_triangles(path, &blocks)?;
        }
        let blocks = blocks.blocks;
        let explicit_zeros = blocks.iter().map(|block| block.zero_count).sum();
        let expansion = match header.symmetry {
            Symmetry::General => Expansion::AsStored,
            Symmetry::Symmetric | Symmetry::Hermitian => Expansion::Mirrored,
            Symmetry::Skew => Expansion::MirroredNegated,
        };
        let stored: u64 = blocks.iter().map(|block| block.entries.bytes()).sum();
        let columns = ENTRY_BYTES * full_count(&blocks, expansion) + 8 * header.columns as u64;
        self.check(path, stored + columns)?;
        check_room(path, columns)?;
        let columns = Columns::assemble(blocks, header.rows, header.columns, expansion).map_err(
            |refusal| Error::File {
                path: path.into(),
                message: cannot_assemble(refusal),
            },
        )?;
        let (columns, largest_asymmetry) =
            if purpose == Purpose::SymmetricOperator && !header.is_mirrored() {
                symmetry::averaged(columns).map_err(|reason| Error::File {
                    path: path.into(),
                    message: reason.into(),
                })?
            } else {
                (columns, 0.0)
            };
        self.held += ENTRY_BYTES * columns.rows.len() as u64 + 4 * columns.starts.len() as u64;
        let report = MatrixReport {
            file_name: path
                .file_name()
                .unwrap_or_default()
                .to_string_lossy()
                .into_owned(),
            sha256,
            rows: columns.row_count,
            columns: columns.column_count(),
            stored_entries: header.entries as usize,
            duplicates_summed: columns.duplicates_summed,
            explicit_zeros,
            largest_asymmetry,
        };
        Ok((columns.into_matrix(), report))
    }

    fn read_entries(
        &self,
        path: &Path,
        text: &mut TextBlocks,
        purpose: Purpose,
    ) -> Result<(MatrixHeader, Blocks), Error> {
        let header = read_header(path, text)?;
        if let Some(length) = text.text_length() {
            header.check_dimensions(path, length)?;
        }
        if purpose == Purpose::SymmetricOperator {
            refuse_as_operator(path, &header)?;
        }
        let blocks = entry_blocks::read_entries(path, text, &header, self)?;
        header.check_dimensions(path, text.length())?;
        Ok((header, blocks))
    }

    /// Refuses so many bytes beside the matrices that are held.
    fn check(&self, path: &Path, bytes: u64) -> Result<(), Error> {
        let needed = self.held + bytes;
        match self.limit {
            Some(limit) if needed > limit => Err(Error::NotEnoughMemory {
                path: path.into(),
                needed,
                allowed: Some(limit),
            }),
            _ => Ok(()),
        }
    }
}

/// Bytes of an entry in full storage.
const ENTRY_BYTES: u64 = (size_of::<u32>() + size_of::<f64>()) as u64;

/// Asks for memory without touching it, because an allocation that fails later would end the program.
fn check_room(path: &Path, bytes: u64) -> Result<(), Error> {
    let is_there =
        usize::try_from(bytes).is_ok_and(|bytes| Vec::<u8>::new().try_reserve_exact(bytes).is_ok());
    match is_there {
        true => Ok(()),
        false => Err(Error::NotEnoughMemory {
            path: path.into(),
            needed: bytes,
            allowed: None,
        }),
    }
}

/// UTF-8's, which some editors put in front.
const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";
/// Text up to the size line.
const LONGEST_HEADER: usize = 1 << 26;

/// Reads up to the size line; entries come next.
fn read_header(path: &Path, text: &mut TextBlocks) -> Result<MatrixHeader, Error> {
    if text.pending().starts_with(BYTE_ORDER_MARK) {
        text.skip(BYTE_ORDER_MARK.len());
    }
    let mut wanted = BLOCK;
    loop {
        let pending = text.pending();
        let last_line = pending.iter().rposition(|&byte| byte == b'\n');
        let whole = match last_line {
            Some(end) if !text.is_at_end() => end + 1,
            _ => pending.len(),
        };
        if let Some(header) = MatrixHeader::read(path, &pending[..whole])? {
            text.skip(header.body_start);
            return Ok(header);
        }
        if text.is_at_end() {
            return Err(Error::Line {
                path: path.into(),
                line: pending
                    .trim_ascii_end()
                    .split(|&byte| byte == b'\n')
                    .count() as u64,
                message: "the file ends before its size line".into(),
            });
        }
        if wanted >= LONGEST_HEADER {
            return Err(Error::File {
                path: path.into(),
                message: format!("no size line in the first {wanted} bytes"),
            });
        }
        wanted *= 2;
        text.fill_to(wanted)?;
    }
}

fn refuse_as_operator(path: &Path, header: &MatrixHeader) -> Result<(), Error> {
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
