//! A block of lines of bulk data.

use dcb_formats::matrix::blocks::{Entries, likely_line_count, shown};

use super::LabelledEntries;
use super::card_line::{CardLine, bare, is_continuation, is_dmig};
use super::field::{FieldDigits, real, row};
use super::header::{Dmig, name_of};
use crate::text::cursor::{Cursor, Stopped};

/// What a block has, matrix by matrix.
#[derive(Debug, Default)]
pub(super) struct Block {
    pub(super) matrices: Vec<Found>,
}

/// What a block has of a matrix.
#[derive(Debug)]
pub(super) struct Found {
    pub(super) name: String,
    /// Its first line, 0-based in the block.
    pub(super) line: u32,
    pub(super) entries: LabelledEntries,
    pub(super) digits: FieldDigits,
}

/// What a line belongs to.
#[derive(Clone, Copy)]
enum Card {
    /// Nothing that is wanted.
    Other,
    /// A matrix by its place in the block, and the number of the column in it.
    Column(usize, u32),
}

struct Reader<'a, W> {
    block: &'a mut Block,
    is_wanted: &'a W,
    card: Card,
    /// Entries that the block may have.
    room: usize,
    /// The name of the last column as it is written, and its matrix, if that is wanted.
    last: Vec<u8>,
    last_matrix: Option<usize>,
}

/// Reads the lines of a block that begins within a card.
pub(super) fn read(
    cursor: &mut Cursor<'_>,
    card: &[u8],
    is_wanted: &impl Fn(&str) -> bool,
    block: &mut Block,
) -> Result<(), Stopped> {
    let mut reader = Reader {
        block,
        is_wanted,
        card: Card::Other,
        room: likely_entry_count(cursor.text()),
        last: Vec::new(),
        last_matrix: None,
    };
    let bad = |line, message| Stopped::BadLine { line, message };
    if let Some(first) = bare(card).filter(|first| is_dmig(first)) {
        // What is wrong with it was told in the block before.
        if let Ok(line) = CardLine::of(&first) {
            let _ = reader.begin(&line, 0)?;
        }
    }
    loop {
        let at = cursor.line();
        let Some(line) = cursor.take_line() else {
            break;
        };
        let Some(line) = bare(line) else { continue };
        let goes_on = is_continuation(&line);
        if goes_on && matches!(reader.card, Card::Other) {
            continue;
        }
        if !goes_on && !is_dmig(&line) {
            reader.card = Card::Other;
            continue;
        }
        let line = CardLine::of(&line).map_err(|message| bad(at, message))?;
        let first = match goes_on {
            true => 0,
            false => {
                let begun = reader.begin(&line, at)?;
                begun.map_err(|message| bad(at, message))?;
                1
            }
        };
        for group in first..line.group_count() {
            let group = line.group(group);
            let added = reader.entry(group, line.width);
            added.map_err(|message| bad(at, message))?;
        }
    }
    for found in &mut reader.block.matrices {
        found.entries.give_back_room();
    }
    Ok(())
}

/// Entries of a text that goes on as it begins: one a line where fields are large, two where they are small.
fn likely_entry_count(text: &[u8]) -> usize {
    const LOOKED_AT: usize = 4096;
    let is_large = text[..text.len().min(LOOKED_AT)].contains(&b'*');
    likely_line_count(text) * if is_large { 1 } else { 2 }
}

impl<W: Fn(&str) -> bool> Reader<'_, W> {
    /// Begins a DMIG card.
    fn begin(&mut self, line: &CardLine<'_>, at: u32) -> Result<Result<(), String>, Stopped> {
        self.card = Card::Other;
        let [name, label, component] = match Dmig::of(line) {
            Ok(Dmig::Column(column)) => column,
            Ok(Dmig::Header(_) | Dmig::NoMatrix) => return Ok(Ok(())),
            Err(message) => return Ok(Err(message)),
        };
        if name != self.last || self.last.is_empty() {
            self.last.clear();
            self.last.extend_from_slice(name);
            self.last_matrix = self.matrix(&name_of(name), at)?;
        }
        if let Some(matrix) = self.last_matrix {
            let key = match row(label, component) {
                Ok(key) => key,
                Err(message) => return Ok(Err(message)),
            };
            let column = self.block.matrices[matrix].entries.number(key);
            self.card = Card::Column(matrix, column);
        }
        Ok(Ok(()))
    }

    /// The place of a matrix in the block; `None` if it isn't wanted.
    fn matrix(&mut self, name: &str, line: u32) -> Result<Option<usize>, Stopped> {
        let matrices = &mut self.block.matrices;
        if let Some(place) = matrices.iter().position(|found| found.name == name) {
            return Ok(Some(place));
        }
        if !(self.is_wanted)(name) {
            return Ok(None);
        }
        // Room for all that the block can hold of the first matrix; others are rare.
        let room = match matrices.is_empty() {
            true => self.room,
            false => 0,
        };
        let entries = LabelledEntries::with_capacity(room).ok_or(Stopped::NoMemory {
            bytes: Entries::bytes_of(room),
        })?;
        matrices.push(Found {
            name: name.to_owned(),
            line,
            entries,
            digits: FieldDigits::default(),
        });
        Ok(Some(matrices.len() - 1))
    }

    /// Adds the entry of four fields.
    #[inline]
    fn entry(
        &mut self,
        [label, component, value, imaginary]: [&[u8]; 4],
        width: Option<usize>,
    ) -> Result<(), String> {
        let Card::Column(matrix, column) = self.card else {
            return Ok(());
        };
        if label.is_empty() && component.is_empty() && value.is_empty() && imaginary.is_empty() {
            return Ok(());
        }
        if !imaginary.is_empty() {
            return Err(format!(
                "`{}` as the imaginary part of a real matrix",
                shown(imaginary)
            ));
        }
        let found = &mut self.block.matrices[matrix];
        let key = row(label, component)?;
        let value = real(value, width, &mut found.digits)?;
        let row = found.entries.number(key);
        found.entries.add(row, column, value);
        Ok(())
    }
}
