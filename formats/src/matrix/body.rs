//! The entries of a Matrix Market file, read in parallel.
//!
//! The text is cut at line ends into chunks that keep their entries in file order, so the result doesn't depend on their number.
//! A chunk remembers byte offsets only; the line of an error is counted when there is one.

use std::path::Path;

use rayon::prelude::*;

use super::entries::{Entries, Triplet};
use super::header::{Field, Header, Layout, Symmetry, shown};
use super::number::{self, NotANumber};
use crate::Error;

/// Chunks shorter than this aren't worth a thread.
const SHORTEST_CHUNK: usize = 1 << 20;
/// 32 bits count the entries of a longer one, of at least two bytes each.
const LONGEST_CHUNK: usize = 1 << 32;
/// Chunks for each thread, so that none waits long for another.
const CHUNKS_PER_THREAD: usize = 4;
/// Threads beyond these would mostly wait for the same memory.
const MOST_CHUNKS: usize = 64;
/// A column takes a counter of four bytes in every chunk: together at most a quarter of the text.
const TEXT_PER_COUNTER: usize = 16;

/// Entries of one stretch of the file, in file order.
#[derive(Debug, Default)]
pub(super) struct Chunk {
    pub(super) entries: Entries,
    /// Entries for each column of the full matrix: of a file with one triangle, mirror images too.
    pub(super) per_column: Vec<u32>,
    /// Entries stored as zero.
    pub(super) zero_count: usize,
    /// Entries above the diagonal.
    pub(super) upper_count: usize,
    /// Entries below the diagonal.
    pub(super) lower_count: usize,
}

/// A bad place, before its line is known.
struct BadEntry {
    offset: usize,
    message: String,
}

/// Reads every entry and compares their number with the size line.
///
/// # Errors
/// [`Error::Line`] for the first line in file order that is not an entry, or where entries are missing or left over.
pub(super) fn read_entries(path: &Path, text: &[u8], header: &Header) -> Result<Vec<Chunk>, Error> {
    let bad = |line, message| Error::Line {
        path: path.into(),
        line,
        message,
    };
    let limits = chunk_limits(text, header);
    let results: Vec<(Chunk, Option<BadEntry>)> = limits
        .par_iter()
        .map(|&[start, end]| read_chunk(text, start, end, header))
        .collect();
    let mut chunks = Vec::with_capacity(results.len());
    let mut found = 0u64;
    for (chunk, refusal) in results {
        let before = found;
        found += chunk.entries.len() as u64;
        if found > header.entries {
            let start = limits[chunks.len()][0];
            let line = line_of_entry(text, start, (header.entries - before) as usize);
            return Err(bad(
                line,
                format!(
                    "one entry more than the {} announced in line {}",
                    header.entries, header.size_line
                ),
            ));
        }
        if let Some(BadEntry { offset, message }) = refusal {
            return Err(bad(line_at(text, offset), message));
        }
        chunks.push(chunk);
    }
    if found < header.entries {
        let line = line_at(text, text.trim_ascii_end().len());
        return Err(bad(
            line,
            format!(
                "the file ends after {found} entries; line {} announces {}",
                header.size_line, header.entries
            ),
        ));
    }
    if header.layout == Layout::Array {
        place_array_values(&mut chunks, header);
    }
    Ok(chunks)
}

/// Line of the `nth` entry (0-based) in file order.
pub(super) fn line_of_stored_entry(text: &[u8], header: &Header, nth: usize) -> u64 {
    line_of_entry(text, header.body_start, nth)
}

fn chunk_limits(text: &[u8], header: &Header) -> Vec<[usize; 2]> {
    let total = text.len().saturating_sub(header.body_start);
    let count = (CHUNKS_PER_THREAD * rayon::current_num_threads())
        .min(MOST_CHUNKS)
        .min(total / SHORTEST_CHUNK)
        .min(total / TEXT_PER_COUNTER / header.columns.max(1))
        .max(1);
    let length = total.div_ceil(count).min(LONGEST_CHUNK);
    let mut limits = Vec::new();
    let mut start = header.body_start;
    while start < text.len() {
        let wanted = (start + length).min(text.len());
        let to_line_end = text[wanted..].iter().position(|&byte| byte == b'\n');
        let end = to_line_end.map_or(text.len(), |length| wanted + length + 1);
        limits.push([start, end]);
        start = end;
    }
    limits
}

/// 1-based line of a byte.
fn line_at(text: &[u8], offset: usize) -> u64 {
    1 + text[..offset.min(text.len())]
        .par_iter()
        .filter(|&&byte| byte == b'\n')
        .count() as u64
}

fn line_of_entry(text: &[u8], start: usize, nth: usize) -> u64 {
    let mut line = line_at(text, start);
    let mut seen = 0;
    for content in text[start..].split(|&byte| byte == b'\n') {
        let content = content.trim_ascii();
        if !content.is_empty() && !content.starts_with(b"%") {
            if seen == nth {
                break;
            }
            seen += 1;
        }
        line += 1;
    }
    line
}

/// Reads the lines of one stretch; an error ends it and keeps what was read before.
fn read_chunk(text: &[u8], start: usize, end: usize, header: &Header) -> (Chunk, Option<BadEntry>) {
    // The stretch's share of the announced entries, but never more than its bytes can hold (two bytes an entry).
    let share =
        header.entries as f64 * (end - start) as f64 / (text.len() - header.body_start) as f64;
    let capacity = (share as usize + 64).min((end - start) / 2 + 1);
    let mut chunk = Chunk::new(capacity, header);
    let mut reader = Reader {
        text: &text[..end],
        at: start,
    };
    let mirrors = header.is_mirrored();
    while reader.advance_to_entry() {
        match reader.entry(header) {
            // Where an array's value belongs is known when all before it have been counted.
            Ok(triplet) if header.layout == Layout::Array => chunk.entries.push(triplet),
            Ok(triplet) => chunk.push(triplet, mirrors),
            Err(refusal) => return (chunk, Some(refusal)),
        }
    }
    (chunk, None)
}

impl Chunk {
    fn new(capacity: usize, header: &Header) -> Self {
        Self {
            entries: Entries::with_capacity(capacity),
            per_column: vec![0; header.columns],
            ..Self::default()
        }
    }

    #[inline]
    fn push(&mut self, triplet: Triplet, mirrors: bool) {
        let Triplet { row, column, value } = triplet;
        self.zero_count += usize::from(value == 0.0);
        self.upper_count += usize::from(row < column);
        self.lower_count += usize::from(row > column);
        // What 32 bits don't hold is refused before the counts are used.
        let here = &mut self.per_column[column as usize];
        *here = here.wrapping_add(1);
        if mirrors && row != column {
            let there = &mut self.per_column[row as usize];
            *there = there.wrapping_add(1);
        }
        self.entries.push(triplet);
    }
}

struct Reader<'a> {
    text: &'a [u8],
    at: usize,
}

impl Reader<'_> {
    /// Skips blanks, line ends and comment lines; false at the end.
    #[inline(always)]
    fn advance_to_entry(&mut self) -> bool {
        while let Some(&byte) = self.text.get(self.at) {
            match byte {
                b' ' | b'\t' | b'\r' | b'\n' => self.at += 1,
                b'%' => self.at += self.rest_of_line().len(),
                _ => return true,
            }
        }
        false
    }

    #[inline(always)]
    fn entry(&mut self, header: &Header) -> Result<Triplet, BadEntry> {
        let (mut row, mut column) = (0, 0);
        if header.layout == Layout::Coordinate {
            row = self.index("row", header.rows)?;
            if !header.is_vector {
                self.gap("a column")?;
                column = self.index("column", header.columns)?;
            }
            if header.field != Field::Pattern {
                self.gap("a value")?;
            }
        }
        let value = match header.field {
            Field::Pattern => 1.0,
            Field::Real => self.value(number::real(&self.text[self.at..]))?,
            Field::Integer => self.value(number::integer(&self.text[self.at..]))?,
        };
        self.end_of_entry()?;
        if header.symmetry == Symmetry::Skew
            && header.layout == Layout::Coordinate
            && row == column
            && value != 0.0
        {
            let place = row + 1;
            return Err(self.refuse(format!(
                "({place}, {place}) = {value:e} in a skew-symmetric matrix; its diagonal is zero"
            )));
        }
        Ok(Triplet { row, column, value })
    }

    /// A 1-based index, returned 0-based.
    #[inline(always)]
    fn index(&mut self, name: &str, count: usize) -> Result<u32, BadEntry> {
        match number::unsigned(&self.text[self.at..]) {
            Ok((index, length)) if index >= 1 && index <= count as u64 => {
                self.at += length;
                Ok((index - 1) as u32)
            }
            Ok((0, _)) => Err(self.refuse(format!("{name} 0; {name}s are counted from 1"))),
            Ok((index, _)) => Err(self.refuse(format!(
                "{name} {index} exceeds the announced {count} {name}s"
            ))),
            Err(NotANumber::OutOfRange) => Err(self.refuse(format!(
                "{name} `{}` exceeds the announced {count} {name}s",
                shown(self.word())
            ))),
            Err(_) => Err(self.refuse(format!(
                "`{}`; expected a {name} from 1 to {count}",
                shown(self.word())
            ))),
        }
    }

    #[inline(always)]
    fn value(&mut self, read: Result<(f64, usize), NotANumber>) -> Result<f64, BadEntry> {
        match read {
            Ok((value, length)) if self.is_word_end(self.at + length) => {
                self.at += length;
                Ok(value)
            }
            Err(NotANumber::NotFinite) => Err(self.refuse(format!(
                "value `{}`; expected a finite number",
                shown(self.word())
            ))),
            Err(NotANumber::OutOfRange) => Err(self.refuse(format!(
                "integer `{}` is beyond 64 bits",
                shown(self.word())
            ))),
            _ => Err(self.refuse(format!("`{}`; expected a number", shown(self.word())))),
        }
    }

    /// Blanks, then something on the same line.
    #[inline(always)]
    fn gap(&mut self, expected: &str) -> Result<(), BadEntry> {
        let before = self.at;
        self.skip_blanks();
        match self.text.get(self.at) {
            None | Some(b'\n') => Err(self.refuse(format!("the line ends; expected {expected}"))),
            Some(_) if self.at == before => Err(self.refuse(format!(
                "`{}` after an index; expected a blank, then {expected}",
                shown(self.word())
            ))),
            Some(_) => Ok(()),
        }
    }

    #[inline(always)]
    fn end_of_entry(&mut self) -> Result<(), BadEntry> {
        self.skip_blanks();
        match self.text.get(self.at) {
            None | Some(b'\n') => Ok(()),
            Some(_) => Err(self.refuse(format!(
                "`{}` after the entry; expected the end of the line",
                shown(self.word())
            ))),
        }
    }

    #[inline(always)]
    fn skip_blanks(&mut self) {
        while matches!(self.text.get(self.at), Some(b' ' | b'\t' | b'\r')) {
            self.at += 1;
        }
    }

    #[inline(always)]
    fn is_word_end(&self, at: usize) -> bool {
        matches!(self.text.get(at), None | Some(b' ' | b'\t' | b'\r' | b'\n'))
    }

    fn rest_of_line(&self) -> &[u8] {
        let rest = &self.text[self.at..];
        &rest[..rest
            .iter()
            .position(|&byte| byte == b'\n')
            .unwrap_or(rest.len())]
    }

    fn word(&self) -> &[u8] {
        let rest = self.rest_of_line();
        &rest[..rest
            .iter()
            .position(u8::is_ascii_whitespace)
            .unwrap_or(rest.len())]
    }

    #[cold]
    fn refuse(&self, message: String) -> BadEntry {
        BadEntry {
            offset: self.at,
            message,
        }
    }
}

/// Gives array values their places, column after column; of symmetric arrays the file holds the lower triangle, of skew ones
/// the strictly lower. Zeros are dropped: in a dense listing they say that there is no entry.
fn place_array_values(chunks: &mut [Chunk], header: &Header) {
    let first_row = |column: usize| match header.symmetry {
        Symmetry::General => 0,
        Symmetry::Symmetric | Symmetry::Hermitian => column,
        Symmetry::Skew => column + 1,
    };
    let mut column = 0;
    let mut row = first_row(0);
    for chunk in chunks {
        let values = std::mem::replace(chunk, Chunk::new(0, header)).entries;
        for Triplet { value, .. } in values.iter() {
            while row >= header.rows && column < header.columns {
                column += 1;
                row = first_row(column);
            }
            if value != 0.0 {
                let (row, column) = (row as u32, column as u32);
                chunk.push(Triplet { row, column, value }, header.is_mirrored());
            }
            row += 1;
        }
    }
}
