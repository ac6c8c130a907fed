//! CalculiX' `.dof` file, which it writes beside `.sti` and `.mas`: `label.direction` of each row.

use std::path::Path;

use dcb_formats::Error;
use dcb_formats::matrix::blocks::{shown, unsigned};

use super::direction::label;
use super::lines::TableLines;
use super::{DofTable, RowList};
use crate::stored::row_key::{RowKey, direction, no_direction};
use crate::text::line_blocks::filled_lines;

const TWICE: &str = "CalculiX has expanded shells or beams to solids, whose nodes are not those of the deck; use solid elements only, or convert the model first";

/// Whether the first filled line is `label.direction`, or ends with CR alone.
pub(super) fn recognises(start: &[u8]) -> bool {
    filled_lines(start)
        .next()
        .is_some_and(|line| fields(line).is_some())
}

/// Label and direction.
fn fields(line: &[u8]) -> Option<(&[u8], &[u8])> {
    let point = line.iter().position(|&byte| byte == b'.')?;
    let (label, rest) = (&line[..point], &line[point + 1..]);
    let is_number = |field: &[u8]| !field.is_empty() && field.iter().all(u8::is_ascii_digit);
    (is_number(label) && is_number(rest)).then_some((label, rest))
}

/// Reads the file.
pub(super) fn read(path: &Path, row_count: usize) -> Result<DofTable, Error> {
    let mut lines = TableLines::open(path)?;
    let mut rows = RowList::new(row_count);
    while let Some(line) = lines.next_filled()? {
        let row = row(&line).and_then(|key| rows.push(key, lines.number()));
        row.map_err(|message| lines.refused(message))?;
    }
    let sha256 = lines.finish()?;
    Ok(DofTable {
        rows: rows.finish(path, TWICE)?,
        sha256,
        notes: Vec::new(),
    })
}

fn row(line: &[u8]) -> Result<RowKey, String> {
    let (node, number) =
        fields(line).ok_or_else(|| format!("`{}`; expected `label.direction`", shown(line)))?;
    let node = label(node)?;
    let number = unsigned(number).map_or(u64::MAX, |(number, _)| number);
    match direction(number).filter(|_| number <= 3) {
        Some(direction) => Ok(RowKey::nodal(node, direction)),
        None if number <= 6 => Err(format!(
            "direction {number} of node {node}; expected displacements, 1 to 3, which CalculiX' elements have"
        )),
        None => Err(no_direction(node, number)),
    }
}
