//! Abaqus' `*MATRIX OUTPUT, FORMAT=MATRIX INPUT`: lines `node,dof, node,dof, value`, row first, without header or size.
//!
//! Abaqus writes the lower triangle column by column; what was made by hand may hold the upper one or both. Negative nodes are internal
//! to elements. Zeros are left out, as in [`super::coordinate`]; a label without a line for its diagonal shows that the file is cut off.

use std::path::Path;

use dcb_formats::Error;
use dcb_formats::matrix::blocks::{NotANumber, shown, unsigned};

use crate::matrix::labelled::LabelledEntries;
use crate::stored::row_key::{RowKey, direction, no_direction};
use crate::stored::{Content, LARGEST_LABEL, Listed, Reading, Rows, StoredMatrix, Triangles};
use crate::text::cursor::{Cursor, Stopped};
use crate::text::line_blocks::{
    LineBlock, filled_lines, look_at_text, read_line_blocks_in_context, read_text, refuse_open_end,
    room_for_entries,
};
use crate::text::real::Digits;

const COMMENT: &[u8] = b"**";
/// Abaqus' stiffness of a degree of freedom that `*BOUNDARY` holds.
const HELD: f64 = 1e36;
/// Labels that a message repeats.
const SHOWN_LABELS: usize = 10;

/// The one matrix of the file.
///
/// # Errors
/// [`Error::File`] for a vector of loads, which Abaqus writes beside matrices.
pub fn list(path: &Path) -> Result<Vec<Listed>, Error> {
    look_at_text(path, |text| refuse_loads(path, text.pending()))?;
    Ok(vec![Listed {
        name: String::new(),
        shape: None,
        obstacle: None,
    }])
}

/// Whether the first filled line is an entry, in numbers or in Abaqus' labels, or the head of a vector of loads.
pub fn recognises(start: &[u8]) -> bool {
    is_loads(start)
        || filled_lines(start)
            .find(|line| !line.starts_with(COMMENT))
            .is_some_and(is_entry)
}

/// Five fields: a node and its direction twice, a value. Nodes of the form LABELS are names.
fn is_entry(line: &[u8]) -> bool {
    let is_index = |word: &[u8]| matches!(unsigned(word), Ok((_, length)) if length == word.len());
    let is_real = |word: &[u8]| crate::text::real::whole_real(word).is_ok();
    let fields: Vec<&[u8]> = line
        .split(|&byte| byte == b',')
        .map(<[u8]>::trim_ascii)
        .collect();
    matches!(fields[..], [node, dof, other, other_dof, value]
        if !node.is_empty() && !other.is_empty() && !node.starts_with(b"*") && is_index(dof) && is_index(other_dof) && is_real(value))
}

fn is_loads(start: &[u8]) -> bool {
    let start = start
        .strip_prefix(crate::text::line_blocks::BYTE_ORDER_MARK)
        .unwrap_or(start);
    let begins = |line: &[u8], word: &[u8]| {
        line.get(..word.len())
            .is_some_and(|start| start.eq_ignore_ascii_case(word))
    };
    begins(start, b"** Assembled nodal loads")
        || filled_lines(start)
            .find(|line| !line.starts_with(COMMENT))
            .is_some_and(|line| begins(line, b"*CLOAD"))
}

fn refuse_loads(path: &Path, start: &[u8]) -> Result<(), Error> {
    if !is_loads(start) {
        return Ok(());
    }
    Err(Error::File {
        path: path.into(),
        message: "holds nodal loads of Abaqus (*CLOAD), no matrix; the stiffness is in the file whose name has STIF instead of LOAD, the mass in that with MASS".into(),
    })
}

/// Reads the matrix, number 0 of the list. Rows are sorted by label.
///
/// # Errors
/// [`Error::Line`] for a line that is no entry, a label or direction out of range, nodes by name (LABELS); [`Error::File`] for loads, held
/// degrees of freedom and signs of a file that is cut off; [`Error::NotEnoughMemory`]; and what reading a text meets.
pub fn read(path: &Path, wanted: &[usize]) -> Result<Reading, Error> {
    let (matrix, sha256) = read_text(path, |text| {
        refuse_loads(path, text.pending())?;
        let mut entries = LabelledEntries::default();
        let work = |cursor: &mut Cursor<'_>, (), block: &mut Block| read_block(cursor, block);
        let take = |block: &mut LineBlock<Block>| {
            let appended = entries.append(std::mem::take(&mut block.content.entries));
            appended.map_err(|message| Error::File {
                path: path.into(),
                message,
            })
        };
        let blocks = read_line_blocks_in_context(path, text, 0, |_| (), work, take)?;
        refuse_open_end(path, &blocks)?;
        stored(path, &blocks, entries)
    })?;
    Ok(Reading::of_one(wanted, matrix, sha256))
}

/// A block of lines.
#[derive(Debug, Default)]
struct Block {
    entries: LabelledEntries,
    digits: Digits,
    /// Labels that Abaqus holds.
    held: Vec<RowKey>,
}

fn read_block(cursor: &mut Cursor<'_>, block: &mut Block) -> Result<(), Stopped> {
    block.entries = LabelledEntries::new(room_for_entries(cursor)?);
    // Most lines repeat the column of the line before.
    let mut last_column = None;
    while cursor.advance(COMMENT) {
        let row_key = label(cursor)?;
        let column_key = label(cursor)?;
        let Ok(value) = cursor.real(&mut block.digits) else {
            return Err(cursor.expected(ENTRY));
        };
        cursor.pass_blanks();
        if !cursor.is_line_end() {
            return Err(cursor.expected(ENTRY));
        }
        let column = match last_column {
            Some((key, column)) if key == column_key => column,
            _ => block.entries.number(column_key),
        };
        last_column = Some((column_key, column));
        let row = block.entries.number(row_key);
        if row == column && value == HELD {
            block.held.push(row_key);
        }
        block.entries.add_filled(row, column, value);
    }
    block.entries.give_back_room();
    Ok(())
}

const ENTRY: &str = "`node,dof, node,dof, value`, as FORMAT=MATRIX INPUT writes it";

/// A node and its direction, with the commas and blanks behind them.
#[inline(always)]
fn label(cursor: &mut Cursor<'_>) -> Result<RowKey, Stopped> {
    let is_internal = cursor.pass(b'-');
    let node = match cursor.unsigned() {
        Ok(node) if (1..=u64::from(LARGEST_LABEL)).contains(&node) => node as u32,
        read => return Err(bad_node(cursor, read)),
    };
    cursor.pass_blanks();
    let has_comma = cursor.pass(b',');
    cursor.pass_blanks();
    let key = match cursor.unsigned() {
        Ok(dof) if has_comma && is_internal => internal(node, dof),
        Ok(dof) if has_comma => match direction(dof) {
            Some(direction) => Some(RowKey::nodal(node, direction)),
            None => return Err(cursor.refused(no_direction(node, dof))),
        },
        _ => None,
    };
    cursor.pass_blanks();
    let has_comma = cursor.pass(b',');
    cursor.pass_blanks();
    match key {
        Some(key) if has_comma => Ok(key),
        _ => Err(cursor.expected(ENTRY)),
    }
}

fn internal(point: u32, number: u64) -> Option<RowKey> {
    let number = u32::try_from(number).ok().filter(|number| *number > 0)?;
    Some(RowKey::internal(point, number))
}

#[cold]
fn bad_node(cursor: &Cursor<'_>, read: Result<u64, NotANumber>) -> Stopped {
    match read {
        Ok(0) => cursor.expected("labels of nodes, which are counted from 1"),
        Ok(_) | Err(NotANumber::OutOfRange) => {
            cursor.expected(&format!("labels of nodes up to {LARGEST_LABEL}"))
        }
        Err(_) if is_entry(cursor.whole_line()) => cursor.refused(format!(
            "`{}`: nodes by name, as FORMAT=LABELS writes them, can't be told from each other; write the matrices with FORMAT=MATRIX INPUT",
            shown(cursor.whole_line())
        )),
        Err(_) => cursor.expected(ENTRY),
    }
}

/// The matrix of all blocks.
fn stored(
    path: &Path,
    blocks: &[LineBlock<Block>],
    entries: LabelledEntries,
) -> Result<StoredMatrix, Error> {
    refuse_held(path, blocks)?;
    let mut digits = Digits::default();
    blocks
        .iter()
        .for_each(|block| digits.join(block.content.digits));
    let (keys, entries) = entries.sorted().map_err(|message| Error::File {
        path: path.into(),
        message,
    })?;
    Ok(StoredMatrix {
        name: String::new(),
        size: keys.len(),
        triangles: Triangles::One,
        content: Content::Entries(vec![entries]),
        rows: Rows::Labelled(keys.into_iter().map(RowKey::label).collect()),
        digits: digits.count(),
        notes: Vec::new(),
    })
}

fn refuse_held(path: &Path, blocks: &[LineBlock<Block>]) -> Result<(), Error> {
    let held = blocks.iter().flat_map(|block| &block.content.held);
    let mut held: Vec<RowKey> = held.copied().collect();
    if held.is_empty() {
        return Ok(());
    }
    held.sort_unstable();
    held.dedup();
    let first: Vec<String> = (held.iter().take(SHOWN_LABELS))
        .map(RowKey::to_string)
        .collect();
    let more = match held.len() > SHOWN_LABELS {
        true => ", ...",
        false => "",
    };
    Err(Error::File {
        path: path.into(),
        message: format!(
            "{} degrees of freedom are held: a stiffness of 1e36 on the diagonal of {}{more}; remove *BOUNDARY from the model and write the matrices again",
            held.len(),
            first.join(", ")
        ),
    })
}
