//! Nastran's direct matrix input (DMIG), as punch files and bulk data have it.
//!
//! A card `DMIG name 0 form type` announces a matrix; a card `DMIG name label component` begins a column, and groups of label, component,
//! real and imaginary part follow in it. Fields have 8 or 16 columns or end with commas. Columns come in any order, and their cards again
//! and again. Form 6 stands for a symmetric matrix of which one triangle is written. Other cards are left out.
//!
//! Blocks of lines are read side by side. Before that, each is looked through for headers and for the card that its last lines belong to.

mod block;
mod card_line;
mod field;
mod header;

use std::path::Path;

use dcb_formats::Error;
use dcb_formats::matrix::blocks::TextBlocks;

use crate::matrix::labelled::LabelledEntries;
use crate::matrix::wanted::Wanted;
use crate::stored::row_key::RowKey;
use crate::stored::{Content, Listed, Reading, Rows, StoredMatrix};
use crate::text::cursor::Cursor;
use crate::text::line_blocks::{
    LineBlock, filled_lines, look_at_text, read_line_blocks_in_context, read_text, refuse_open_end,
};
use block::{Block, Found};
use header::{Context, Header};

/// Whether some line at the beginning of a file begins with DMIG.
pub fn recognises(start: &[u8]) -> bool {
    let is_text = !start.iter().take(1024).any(|byte| *byte == 0);
    is_text && filled_lines(start).any(card_line::is_dmig)
}

/// The matrices of a file, in the order of their headers.
///
/// # Errors
/// [`Error::Io`], and as [`TextBlocks::next_block`].
pub fn list(path: &Path) -> Result<Vec<Listed>, Error> {
    let headers = look_at_text(path, |text| {
        let mut context = Context::default();
        let mut block = Vec::new();
        loop {
            let used = text.next_block(&mut block)?;
            if used == 0 {
                return Ok(context.headers);
            }
            context.look(&block[..used]);
        }
    })?;
    let listed = headers.iter().map(|header| Listed {
        name: header.name.clone(),
        shape: None,
        obstacle: header.obstacle(),
    });
    Ok(listed.collect())
}

/// Reads matrices by their place in the list. Rows are sorted by label.
///
/// # Errors
/// [`Error::Line`] for a card that can't be read, labels and components out of range, values that aren't finite; [`Error::File`] for
/// matrices that aren't real and square, columns without a header, signs of a file that is cut off.
pub fn read(path: &Path, wanted: &[usize]) -> Result<Reading, Error> {
    let wanted = Wanted::new(wanted);
    let (matrices, sha256) = read_text(path, |text| {
        let mut context = Context::default();
        let mut matrices: Vec<Found> = Vec::new();
        let blocks = read_blocks(path, text, &mut context, &wanted, &mut matrices)?;
        refuse_open_end(path, &blocks)?;
        let headers = context.headers;
        refuse_strays(path, &blocks, &headers)?;
        let numbers = 0..headers.len();
        let asked = numbers.filter(|&number| wanted.has(number));
        let read = asked.map(|number| {
            let header = &headers[number];
            let place = matrices.iter().position(|found| found.name == header.name);
            let found = place.map(|place| matrices.swap_remove(place));
            Ok((number, matrix(path, header, found)?))
        });
        read.collect::<Result<Vec<_>, Error>>()
    })?;
    wanted.reading(path, matrices, sha256)
}

fn read_blocks(
    path: &Path,
    text: &mut TextBlocks,
    context: &mut Context,
    wanted: &Wanted<'_>,
    matrices: &mut Vec<Found>,
) -> Result<Vec<LineBlock<Block>>, Error> {
    let look = |block: &[u8]| {
        let card = context.card.clone();
        context.look(block);
        // Headers of this block too: the matrices behind them may not be wanted.
        Context {
            headers: context.headers.clone(),
            card,
        }
    };
    let work = |cursor: &mut Cursor<'_>, context: Context, block: &mut Block| {
        let is_wanted = |name: &str| {
            let number = context
                .headers
                .iter()
                .position(|header| header.name == name);
            // What has no header yet is read, and told when none comes.
            number.is_none_or(|number| {
                wanted.has(number) && context.headers[number].obstacle().is_none()
            })
        };
        block::read(cursor, &context.card, &is_wanted, block)
    };
    let take = |block: &mut LineBlock<Block>| {
        for found in &mut block.content.matrices {
            let entries = std::mem::take(&mut found.entries);
            match matrices.iter_mut().find(|known| known.name == found.name) {
                Some(known) => {
                    known.digits.join(&found.digits);
                    let appended = known.entries.append(entries);
                    appended.map_err(|message| Error::File {
                        path: path.into(),
                        message: format!("the matrix {}: {message}", found.name),
                    })?;
                }
                None => matrices.push(Found {
                    name: found.name.clone(),
                    line: found.line,
                    entries,
                    digits: found.digits.clone(),
                }),
            }
        }
        Ok(())
    };
    read_line_blocks_in_context(path, text, 0, look, work, take)
}

/// Refuses a matrix that has two headers, and one that has none.
fn refuse_strays(
    path: &Path,
    blocks: &[LineBlock<Block>],
    headers: &[Header],
) -> Result<(), Error> {
    for (number, header) in headers.iter().enumerate() {
        if headers[..number]
            .iter()
            .any(|other| other.name == header.name)
        {
            return Err(Error::File {
                path: path.into(),
                message: format!(
                    "has two headers of the matrix {}; name the matrices apart, or split the file",
                    header.name
                ),
            });
        }
    }
    for block in blocks {
        for Found { name, line, .. } in &block.content.matrices {
            if !headers.iter().any(|header| header.name == *name) {
                return Err(block.refused(
                    path,
                    *line,
                    format!("a column of {name}, which has no header; expected a card `DMIG, {name}, 0, ...`"),
                ));
            }
        }
    }
    Ok(())
}

/// The matrix that was found behind a header, if one was.
fn matrix(path: &Path, header: &Header, found: Option<Found>) -> Result<StoredMatrix, Error> {
    let refused = |message: String| Error::File {
        path: path.into(),
        message: format!("the matrix {}: {message}", header.name),
    };
    if let Some(obstacle) = header.obstacle() {
        return Err(refused(format!(
            "is {obstacle}; stiffness and mass are real and square"
        )));
    }
    let (entries, digits) = match found {
        Some(found) => (found.entries, found.digits.count()),
        None => (LabelledEntries::default(), None),
    };
    let (keys, entries) = entries.sorted().map_err(refused)?;
    Ok(StoredMatrix {
        name: header.name.clone(),
        size: keys.len(),
        triangles: header.triangles(),
        content: Content::Entries(vec![entries]),
        rows: Rows::Labelled(keys.into_iter().map(RowKey::label).collect()),
        digits,
        notes: Vec::new(),
    })
}
