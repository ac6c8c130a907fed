//! The entries of a Matrix Market file, read in parallel.
//!
//! Of the text nothing is kept: each block remembers which entry is in which line.

use std::path::Path;

use super::MatrixReader;
use super::block_reading::{Rest, read_blocks};
use super::bytes::{BLOCK, TextBlocks};
use super::entries::{Entries, Triplet};
use super::entry_reader::{BadEntry, EntryReader};
use super::header::{Layout, MatrixHeader, Symmetry};
use crate::Error;

/// Text for each announced entry: lines are shorter, but comments and blanks may be between them.
const TEXT_PER_ENTRY: u64 = 1 << 10;
/// Text of comments that any file may have.
const UNQUESTIONED_TEXT: u64 = 1 << 28;

/// Entries of one block, in file order.
#[derive(Debug, Default)]
pub(super) struct Block {
    pub(super) entries: Entries,
    /// Entries stored as zero.
    pub(super) zero_count: usize,
    /// Entries above the diagonal.
    pub(super) upper_count: usize,
    /// Entries below the diagonal.
    pub(super) lower_count: usize,
    /// Number of an entry and its line in the block (both 0-based), where an entry isn't in the line after the one before.
    jumps: Vec<[u32; 2]>,
    /// Line ends.
    line_count: u64,
    /// The last line with something on it.
    last_filled: Option<u64>,
    refusal: Option<BadEntry>,
    /// Memory that the system didn't give.
    missing_bytes: u64,
}

/// The blocks of a file.
pub(super) struct Blocks {
    pub(super) blocks: Vec<Block>,
    /// 1-based line that the first one begins with.
    first_line: u64,
}

impl Blocks {
    /// 1-based line of the `nth` entry (0-based) of a block.
    pub(super) fn line_of_entry(&self, block: usize, nth: usize) -> u64 {
        self.first_line_of(block) + self.blocks[block].line_of_entry(nth)
    }

    fn first_line_of(&self, block: usize) -> u64 {
        let before = self.blocks[..block].iter();
        self.first_line + before.map(|block| block.line_count).sum::<u64>()
    }

    /// Compares the number of entries with the size line; the first bad line in file order is told.
    fn check(&self, path: &Path, header: &MatrixHeader) -> Result<(), Error> {
        let bad = |line, message| Error::Line {
            path: path.into(),
            line,
            message,
        };
        let mut found = 0u64;
        for (number, block) in self.blocks.iter().enumerate() {
            let before = found;
            found += block.entries.len() as u64;
            if found > header.entries {
                let line = self.line_of_entry(number, (header.entries - before) as usize);
                return Err(bad(
                    line,
                    format!(
                        "one entry more than the {} announced in line {}",
                        header.entries, header.size_line
                    ),
                ));
            }
            if let Some(BadEntry { line, message }) = &block.refusal {
                let line = self.first_line_of(number) + u64::from(*line);
                return Err(bad(line, message.clone()));
            }
        }
        if found < header.entries {
            let filled = |(number, block): (usize, &Block)| {
                Some(self.first_line_of(number) + block.last_filled?)
            };
            let last = self.blocks.iter().enumerate().rev().find_map(filled);
            return Err(bad(
                last.unwrap_or(header.size_line),
                format!(
                    "the file ends after {found} entries; line {} announces {}",
                    header.size_line, header.entries
                ),
            ));
        }
        Ok(())
    }
}

/// Reads every entry and compares their number with the size line. The text stands behind the size line.
///
/// # Errors
/// [`Error::Line`] for the first line in file order that is not an entry, or where entries are missing or left over;
/// [`Error::NotEnoughMemory`] if they take more memory than they may; and as [`TextBlocks::next_block`].
pub(super) fn read_entries(
    path: &Path,
    text: &mut TextBlocks,
    header: &MatrixHeader,
    memory: &MatrixReader,
) -> Result<Blocks, Error> {
    let blocks = read_in_parallel(path, text, header, memory)?;
    let mut blocks = Blocks {
        blocks,
        first_line: header.size_line + 1,
    };
    blocks.check(path, header)?;
    if may_be_cut(text.open_end()) {
        let lines = blocks
            .blocks
            .iter()
            .map(|block| block.line_count)
            .sum::<u64>();
        return Err(Error::Line {
            path: path.into(),
            line: blocks.first_line + lines,
            message: "the file ends within this line, so its last number may be cut off; if it is whole, end it with a line end".into(),
        });
    }
    if header.layout == Layout::Array {
        place_array_values(&mut blocks.blocks, header);
    }
    Ok(blocks)
}

/// Digits of numbers that no one types, of which some may be missing.
const PRINTED_DIGITS: usize = 10;

/// Whether a last line without an end can be the beginning of a longer one: with an exponent, or many digits.
fn may_be_cut(line: &[u8]) -> bool {
    let word = line
        .rsplit(u8::is_ascii_whitespace)
        .next()
        .unwrap_or_default();
    let digits = word.iter().filter(|byte| byte.is_ascii_digit()).count();
    digits >= PRINTED_DIGITS
        || word
            .iter()
            .any(|byte| matches!(byte, b'e' | b'E' | b'd' | b'D' | b'.'))
}

/// Reads the blocks behind the header, within the limit of memory.
fn read_in_parallel(
    path: &Path,
    text: &mut TextBlocks,
    header: &MatrixHeader,
    memory: &MatrixReader,
) -> Result<Vec<Block>, Error> {
    let most_text = header
        .entries
        .saturating_mul(TEXT_PER_ENTRY)
        .saturating_add(UNQUESTIONED_TEXT);
    let (mut entries, mut bytes) = (0, 0);
    let took = |block: &mut Block, text_length: u64| {
        if text_length > most_text {
            return Err(Error::File {
                path: path.into(),
                message: format!(
                    "more than {most_text} bytes of text for {} announced entries",
                    header.entries
                ),
            });
        }
        entries += block.entries.len() as u64;
        bytes += block.entries.bytes();
        if block.missing_bytes > 0 {
            return Err(Error::NotEnoughMemory {
                path: path.into(),
                needed: bytes + block.missing_bytes,
                allowed: None,
            });
        }
        memory.check(path, bytes)?;
        Ok(match block.refusal.is_some() || entries > header.entries {
            true => Rest::Unwanted,
            false => Rest::Wanted,
        })
    };
    read_blocks(text, |block| read_block(block, header), took)
}

/// Reads the lines of one block; an error ends it and keeps what was read before.
fn read_block(text: &[u8], header: &MatrixHeader) -> Block {
    let capacity = likely_line_count(text);
    let Some(entries) = Entries::with_capacity(capacity) else {
        return Block {
            missing_bytes: Entries::bytes_of(capacity),
            ..Block::default()
        };
    };
    let mut block = Block {
        entries,
        ..Block::default()
    };
    let mut reader = EntryReader::new(text);
    let mut expected_line = 0;
    while reader.advance_to_entry() {
        match reader.entry(header) {
            // Where an array's value belongs is known when all before it have been counted.
            Ok(triplet) if header.layout == Layout::Array => block.entries.push(triplet),
            Ok(triplet) => block.push(triplet),
            Err(refusal) => {
                block.refusal = Some(refusal);
                break;
            }
        }
        if reader.line != expected_line {
            let number = block.entries.len() as u32 - 1;
            block.jumps.push([number, reader.line]);
        }
        expected_line = reader.line + 1;
    }
    block.entries.give_back_room();
    // Behind a refusal no line is asked for.
    block.line_count = u64::from(reader.line);
    let filled = text.trim_ascii_end();
    let blank = line_ends(&text[filled.len()..]) as u64;
    block.last_filled = (!filled.is_empty()).then(|| block.line_count.saturating_sub(blank));
    block
}

fn line_ends(text: &[u8]) -> usize {
    text.iter().filter(|&&byte| byte == b'\n').count()
}

/// Lines of a text that go on as they begin, and some more.
pub fn likely_line_count(text: &[u8]) -> usize {
    const LOOKED_AT: usize = 4096;
    let start = &text[..text.len().min(LOOKED_AT)];
    let lines = (line_ends(start) + 1) * text.len() / start.len().max(1);
    lines + lines / 64
}

impl Block {
    /// Entries that no line is asked of any more.
    pub(super) fn of_entries(entries: Entries) -> Self {
        let (upper_count, lower_count) = entries.triangle_counts();
        Self {
            upper_count,
            lower_count,
            entries,
            ..Self::default()
        }
    }

    /// Line of an entry in the block, 0-based both.
    fn line_of_entry(&self, nth: usize) -> u64 {
        let after = self.jumps.partition_point(|jump| jump[0] as usize <= nth);
        let jumps = &self.jumps[..after];
        let [number, line] = jumps.last().copied().unwrap_or_default();
        u64::from(line) + (nth - number as usize) as u64
    }

    #[inline]
    fn push(&mut self, triplet: Triplet) {
        let Triplet { row, column, value } = triplet;
        self.zero_count += usize::from(value == 0.0);
        self.upper_count += usize::from(row < column);
        self.lower_count += usize::from(row > column);
        self.entries.push(triplet);
    }
}

const _: () = assert!(BLOCK < u32::MAX as usize);

/// Gives array values their places, column after column; of symmetric arrays the file holds the lower triangle, of skew ones
/// the strictly lower. Zeros are dropped: in a dense listing they say that there is no entry.
fn place_array_values(blocks: &mut [Block], header: &MatrixHeader) {
    let first_row = |column: usize| match header.symmetry {
        Symmetry::General => 0,
        Symmetry::Symmetric | Symmetry::Hermitian => column,
        Symmetry::Skew => column + 1,
    };
    let mut column = 0;
    let mut row = first_row(0);
    for block in blocks {
        let values = std::mem::take(block).entries;
        for Triplet { value, .. } in values.iter() {
            while row >= header.rows && column < header.columns {
                column += 1;
                row = first_row(column);
            }
            if value != 0.0 {
                let (row, column) = (row as u32, column as u32);
                block.push(Triplet { row, column, value });
            }
            row += 1;
        }
    }
}
