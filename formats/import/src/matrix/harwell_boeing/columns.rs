//! Numbers in fixed columns, read in blocks of lines.

use std::path::Path;

use dcb_formats::Error;
use dcb_formats::matrix::blocks::TextBlocks;

use super::format::Format;
use crate::text::cursor::{Cursor, Stopped};
use crate::text::line_blocks::{LineBlock, read_line_blocks_in_context};
use crate::text::real::Digits;

/// Lines of the file with numbers of one kind.
#[derive(Clone, Debug)]
pub(super) struct Section {
    /// As messages call the numbers.
    pub(super) name: &'static str,
    pub(super) format: Format,
    /// How many there are.
    pub(super) numbers: u64,
    pub(super) line_count: u64,
    /// Lines of the file before.
    pub(super) lines_before: u64,
}

/// Numbers of a section.
pub(super) struct Numbers<T> {
    pub(super) values: Vec<T>,
    /// Most digits of any number.
    pub(super) digits: Digits,
}

#[derive(Debug)]
struct Block<T> {
    values: Vec<T>,
    digits: Digits,
    /// The first line with fewer numbers than the format has, 0-based.
    short: Option<u32>,
    /// The last line with numbers, 0-based.
    last: u32,
}

impl<T> Default for Block<T> {
    fn default() -> Self {
        Self {
            values: Vec::new(),
            digits: Digits::default(),
            short: None,
            last: 0,
        }
    }
}

impl<T> Block<T> {
    /// Adds the numbers of a line.
    fn take<'a>(
        &mut self,
        fields: impl Iterator<Item = &'a [u8]>,
        read: &impl Fn(&[u8]) -> Result<T, String>,
    ) -> Result<(), String> {
        for field in fields {
            let field = field.trim_ascii();
            self.values.push(read(field)?);
            self.digits.see(field);
        }
        Ok(())
    }
}

/// Reads the lines of a section; `read` turns a field without blanks around it into a number.
///
/// # Errors
/// [`Error::Line`] for fields that `read` refuses, and lines that have fewer or more than they should; as [`read_line_blocks_in_context`].
pub(super) fn read_numbers<T: Copy + Send>(
    path: &Path,
    text: &mut TextBlocks,
    section: &Section,
    read: impl Fn(&[u8]) -> Result<T, String> + Sync,
) -> Result<Numbers<T>, Error> {
    text.end_after_lines(Some(section.line_count));
    let mut numbers = Numbers {
        values: Vec::new(),
        digits: Digits::default(),
    };
    let work = |cursor: &mut Cursor<'_>, (), block: &mut Block<T>| {
        read_block(cursor, block, &section.format, &read)
    };
    // A block is given up when its numbers are copied.
    let take = |block: &mut LineBlock<Block<T>>| {
        let values = std::mem::take(&mut block.content.values);
        numbers.values.extend_from_slice(&values);
        numbers.digits.join(block.content.digits);
        Ok(())
    };
    let lines_before = section.lines_before;
    let blocks = read_line_blocks_in_context(path, text, lines_before, |_| (), work, take)?;
    text.end_after_lines(None);
    for (number, block) in blocks.iter().enumerate() {
        let is_last = number + 1 == blocks.len();
        if let Some(short) = block.content.short
            && !(is_last && short == block.content.last)
        {
            return Err(block.refused(
                path,
                short,
                format!(
                    "has fewer than {} {}; only the last line of them may",
                    section.format.fields, section.name
                ),
            ));
        }
    }
    let count = numbers.values.len();
    if count as u64 != section.numbers {
        return Err(Error::File {
            path: path.into(),
            message: format!(
                "{count} {} are there, in lines {} to {}; {} are announced; the file is cut off or damaged",
                section.name,
                lines_before + 1,
                lines_before + section.line_count,
                section.numbers
            ),
        });
    }
    numbers.values.shrink_to_fit();
    Ok(numbers)
}

/// Reads lines of fields. SciPy writes fields of 24 characters where it announces 25: a line that isn't as its format says is split at blanks,
/// if that gives no more numbers than the line may have.
fn read_block<T: Copy>(
    cursor: &mut Cursor<'_>,
    block: &mut Block<T>,
    format: &Format,
    read: &impl Fn(&[u8]) -> Result<T, String>,
) -> Result<(), Stopped> {
    let Format { fields, width, .. } = *format;
    let capacity = cursor.text().len() / width + 1;
    if block.values.try_reserve_exact(capacity).is_err() {
        return Err(Stopped::NoMemory {
            bytes: (capacity * size_of::<T>()) as u64,
        });
    }
    loop {
        let number = cursor.line();
        let Some(line) = cursor.pass_whole_line() else {
            return Ok(());
        };
        let bad = |message| Stopped::BadLine {
            line: number,
            message,
        };
        let filled = line.trim_ascii_end();
        let count = filled.len().div_ceil(width);
        if count > fields {
            return Err(bad(format!(
                "has text behind its {fields} fields of {width} characters"
            )));
        }
        if !line.ends_with(b"\n") && filled.len() % width != 0 {
            return Err(bad(format!(
                "the file ends within a field of {width} characters; it is cut off"
            )));
        }
        let before = block.values.len();
        if let Err(message) = block.take(filled.chunks(width), read) {
            block.values.truncate(before);
            let words = || {
                filled
                    .split(u8::is_ascii_whitespace)
                    .filter(|word| !word.is_empty())
            };
            if words().count() > fields || block.take(words(), read).is_err() {
                return Err(bad(message));
            }
        }
        let count = block.values.len() - before;
        if count < fields && block.short.is_none() {
            block.short = Some(number);
        }
        block.last = number;
    }
}
