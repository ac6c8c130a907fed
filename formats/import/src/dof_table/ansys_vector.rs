//! The map of Ansys' APDL Math (`*VEC,MAP,I,IMPORT,FULL,file.full,BACK`, `*EXPORT,MAP,MMF,file`): a dense Matrix Market array of integers, the label of
//! the node of each block of rows, in the solver's order.

use std::path::Path;

use dcb_formats::Error;
use dcb_formats::matrix::blocks::shown;

use super::direction::{label, note, of_each_node};
use super::lines::TableLines;
use super::{DofTable, RowList};
use crate::stored::row_key::RowKey;
use crate::text::line_blocks::filled_lines;

/// Whether it has the banner of Matrix Market.
pub(super) fn recognises(start: &[u8]) -> bool {
    let banner = b"%%matrixmarket";
    let first = filled_lines(start).next();
    let first = first.and_then(|line| line.get(..banner.len()));
    first.is_some_and(|line| line.eq_ignore_ascii_case(banner))
}

/// Reads the file.
pub(super) fn read(path: &Path, row_count: usize) -> Result<DofTable, Error> {
    let mut lines = TableLines::open(path)?;
    let Some(sizes) = lines.next_filled()? else {
        return Err(lines.refused("the file ends before its size line"));
    };
    let node_count = node_count(&sizes).map_err(|message| lines.refused(message))?;
    let directions =
        of_each_node(row_count, node_count).map_err(|message| lines.refused(message))?;
    let mut rows = RowList::new(row_count);
    let mut found = 0;
    while let Some(line) = lines.next_filled()? {
        let node = label(&line).map_err(|message| lines.refused(message))?;
        for direction in directions {
            let key = RowKey::nodal(node, *direction);
            rows.push(key, lines.number())
                .map_err(|message| lines.refused(message))?;
        }
        found += 1;
        if found == node_count && !lines.is_ended() {
            return Err(lines.refused("the file ends within this line, as one that is cut off; write it anew, or add a line end if it is whole"));
        }
    }
    let sha256 = lines.finish()?;
    Ok(DofTable {
        rows: rows.finish(path, "a map names every node once")?,
        sha256,
        notes: vec![note(row_count, node_count, directions)],
    })
}

/// Labels by the size line.
fn node_count(line: &[u8]) -> Result<usize, String> {
    let text = std::str::from_utf8(line).unwrap_or_default();
    let sizes: Result<Vec<usize>, _> = text.split_whitespace().map(str::parse).collect();
    match sizes.as_deref() {
        Ok([count] | [count, 1]) if *count > 0 => Ok(*count),
        Ok([_, _, _]) => Err(
            "a sparse matrix; a map of degrees of freedom is a dense array of one column".into(),
        ),
        _ => Err(format!(
            "`{}`; expected the sizes of a vector, `rows 1`",
            shown(line)
        )),
    }
}
