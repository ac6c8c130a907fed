//! Lines `row column value` without banner or sizes: CalculiX's `.sti` and `.mas` (`*FREQUENCY, SOLVER=MATRIXSTORAGE`), Abaqus'
//! `*MATRIX OUTPUT, FORMAT=COORDINATE`.
//!
//! Rows and columns count from 1, in any order; the size is the largest of them. Zeros are left out: programs print the places that their
//! elements have, and what cancels there. Nothing says how many lines there should be, so two signs of a file that is cut off are looked
//! for: a last line without end, and entries beside the diagonal of a row that has none on it, which no stiffness and no mass matrix has.

use std::path::Path;

use dcb_formats::Error;
use dcb_formats::matrix::blocks::{Entries, Gathered, NotANumber, Triplet, unsigned};
use rayon::prelude::*;

use crate::stored::{Content, LARGEST_LABEL, Listed, Reading, Rows, StoredMatrix, Triangles};
use crate::text::cursor::{Cursor, Stopped};
use crate::text::line_blocks::{
    LineBlock, filled_lines, read_line_blocks_in_context, read_text, refuse_open_end,
    room_for_entries,
};
use crate::text::real::{Digits, whole_real};

/// The one matrix of the file.
///
/// # Errors
/// None.
pub fn list(_path: &Path) -> Result<Vec<Listed>, Error> {
    Ok(vec![Listed {
        name: String::new(),
        shape: None,
        obstacle: None,
    }])
}

/// Whether the first filled line is an entry.
pub fn recognises(start: &[u8]) -> bool {
    let mut lines = filled_lines(start).filter(|line| !line.starts_with(COMMENT));
    lines.next().is_some_and(is_entry)
}

/// Abaqus'.
const COMMENT: &[u8] = b"**";

fn is_entry(line: &[u8]) -> bool {
    let words: Vec<&[u8]> = line
        .split(u8::is_ascii_whitespace)
        .filter(|word| !word.is_empty())
        .collect();
    let is_index =
        |word: &[u8]| matches!(unsigned(word), Ok((1.., length)) if length == word.len());
    matches!(words[..], [row, column, value] if is_index(row) && is_index(column) && whole_real(value).is_ok())
}

/// Reads the matrix, number 0 of the list.
///
/// # Errors
/// [`Error::Line`] for a line that is no entry, for a size line of Matrix Market, for rows that the file can't fill; [`Error::File`] for
/// signs of a file that is cut off; [`Error::NotEnoughMemory`]; and what reading a text meets.
pub fn read(path: &Path, wanted: &[usize]) -> Result<Reading, Error> {
    let (matrix, sha256) = read_text(path, |text| {
        let mut entries = Gathered::default();
        let work = |cursor: &mut Cursor<'_>, (), block: &mut Block| read_block(cursor, block);
        let take = |block: &mut LineBlock<Block>| {
            entries.push(std::mem::take(&mut block.content.entries));
            Ok(())
        };
        let blocks = read_line_blocks_in_context(path, text, 0, |_| (), work, take)?;
        refuse_open_end(path, &blocks)?;
        stored(path, &blocks, entries.into_blocks())
    })?;
    Ok(Reading::of_one(wanted, matrix, sha256))
}

/// Entries of a block of lines.
#[derive(Debug, Default)]
struct Block {
    entries: Entries,
    /// Lines with an entry, zeros among them.
    count: u64,
    digits: Digits,
    /// Rows with a line for their diagonal.
    diagonal: Vec<u32>,
    /// Largest 1-based row or column, and its line in the block.
    largest: (u32, u32),
    /// The first entry, and its line in the block.
    first: Option<(Triplet, u32)>,
}

fn read_block(cursor: &mut Cursor<'_>, block: &mut Block) -> Result<(), Stopped> {
    block.entries = room_for_entries(cursor)?;
    while cursor.advance(COMMENT) {
        let line = cursor.line();
        let row = index(cursor)?;
        let column = index(cursor)?;
        let value = value(cursor, &mut block.digits)?;
        let largest = row.max(column);
        if largest > block.largest.0 {
            block.largest = (largest, line);
        }
        let entry = Triplet {
            row: row - 1,
            column: column - 1,
            value,
        };
        if block.count == 0 {
            block.first = Some((entry, line));
        }
        block.count += 1;
        if row == column {
            block.diagonal.push(entry.row);
        }
        if value != 0.0 {
            block.entries.push(entry);
        }
    }
    block.entries.give_back_room();
    Ok(())
}

const ENTRY: &str = "`row column value`, rows and columns counted from 1";

/// A 1-based row or column, and the blanks behind it.
#[inline(always)]
fn index(cursor: &mut Cursor<'_>) -> Result<u32, Stopped> {
    match cursor.unsigned() {
        Ok(index) if (1..=u64::from(LARGEST_LABEL)).contains(&index) && cursor.pass_blanks() => {
            Ok(index as u32)
        }
        Ok(index) if index > u64::from(LARGEST_LABEL) => Err(cursor.refused(format!(
            "row or column {index}; at most {LARGEST_LABEL} are supported"
        ))),
        Err(NotANumber::OutOfRange) => Err(cursor.expected("a row or column that 32 bits hold")),
        _ => Err(cursor.expected(ENTRY)),
    }
}

/// The value, up to the end of the line.
#[inline(always)]
fn value(cursor: &mut Cursor<'_>, digits: &mut Digits) -> Result<f64, Stopped> {
    let word = *cursor;
    if let Ok(value) = cursor.real(digits) {
        cursor.pass_blanks();
        if cursor.is_line_end() {
            return Ok(value);
        }
    }
    *cursor = word;
    value_in_other_spelling(cursor, digits)
}

#[cold]
fn value_in_other_spelling(cursor: &mut Cursor<'_>, digits: &mut Digits) -> Result<f64, Stopped> {
    let field = cursor.rest_of_line().trim_ascii();
    match whole_real(field) {
        Ok(value) => {
            digits.see(field);
            cursor.pass_line();
            Ok(value)
        }
        Err(NotANumber::NotFinite) => Err(cursor.expected("a finite value")),
        Err(_) => Err(cursor.expected(ENTRY)),
    }
}

/// The matrix of all blocks.
fn stored(
    path: &Path,
    blocks: &[LineBlock<Block>],
    entries: Vec<Entries>,
) -> Result<StoredMatrix, Error> {
    let count: u64 = blocks.iter().map(|block| block.content.count).sum();
    let largest = blocks.iter().max_by_key(|block| block.content.largest.0);
    let size = largest.map_or(0, |block| block.content.largest.0);
    if let Some(block) = largest
        && u64::from(size) > 2 * count
    {
        let line = block.content.largest.1;
        return Err(block.refused(
            path,
            line,
            format!(
                "row or column {size}, but the file has {count} entries, and an entry fills one row and one column; expected rows and columns counted from 1 without gaps"
            ),
        ));
    }
    if size == 0 {
        return Err(Error::File {
            path: path.into(),
            message: "has no entry; expected lines `row column value`".into(),
        });
    }
    refuse_size_line(path, blocks, size, count)?;
    refuse_missing_diagonal(path, blocks, &entries, size)?;
    let mut digits = Digits::default();
    blocks
        .iter()
        .for_each(|block| digits.join(block.content.digits));
    Ok(StoredMatrix {
        name: String::new(),
        size: size as usize,
        triangles: Triangles::Unsaid,
        content: Content::Entries(entries),
        rows: Rows::Unlabelled,
        digits: digits.count(),
        notes: Vec::new(),
    })
}

/// Refuses a Matrix Market file that has lost its banner: its size line would be an entry.
fn refuse_size_line(
    path: &Path,
    blocks: &[LineBlock<Block>],
    size: u32,
    count: u64,
) -> Result<(), Error> {
    let first = blocks
        .iter()
        .find_map(|block| Some((block, block.content.first?)));
    match first {
        Some((block, (entry, line)))
            if entry.row + 1 == size
                && entry.column + 1 == size
                && entry.value == (count - 1) as f64 =>
        {
            Err(block.refused(
                path,
                line,
                "is the size line of a Matrix Market file that has lost its banner; put the line \
                 `%%MatrixMarket matrix coordinate real symmetric` (or `general`, where both triangles are stored) in front",
            ))
        }
        _ => Ok(()),
    }
}

fn refuse_missing_diagonal(
    path: &Path,
    blocks: &[LineBlock<Block>],
    entries: &[Entries],
    size: u32,
) -> Result<(), Error> {
    let mut has_diagonal = vec![false; size as usize];
    for row in blocks.iter().flat_map(|block| &block.content.diagonal) {
        has_diagonal[*row as usize] = true;
    }
    if !has_diagonal.contains(&false) {
        return Ok(());
    }
    let without = |entry: Triplet| {
        [entry.row, entry.column]
            .into_iter()
            .find(|row| !has_diagonal[*row as usize])
    };
    let first = entries
        .par_iter()
        .find_map_first(|block| block.iter().find_map(without));
    match first {
        Some(row) => Err(Error::File {
            path: path.into(),
            message: format!(
                "row {} has entries, but none on the diagonal, as no stiffness or mass matrix has it; the file is cut off, or has rows of Lagrange multipliers",
                row + 1
            ),
        }),
        None => Ok(()),
    }
}
