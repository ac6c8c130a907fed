//! A block of lines of an ASCII file.

use std::sync::Arc;

use dcb_formats::matrix::blocks::{Entries, NotANumber, Triplet, shown};
use memchr::memchr;

use super::format::{Format, TextHeader, signed};
use crate::matrix::nastran::op4::{Header, Run};
use crate::text::cursor::{Cursor, Stopped};
use crate::text::real::whole_real;

/// What stands before a block: the last header and its number.
#[derive(Clone, Debug, Default)]
pub(super) struct Context {
    last: Option<(usize, Arc<TextHeader>)>,
}

impl Context {
    /// Takes the headers of a block in, and shows them.
    pub(super) fn look(&mut self, block: &[u8], mut show: impl FnMut(&Header)) {
        let mut cursor = Cursor::new(block);
        let mut format = self.format();
        while let Some(line) = cursor.take_line() {
            let is_others = format.is_some_and(|format| is_numbers(line, format));
            if !is_others && let Some(Ok(header)) = TextHeader::of(line) {
                show(&header.matrix);
                self.add(header);
                format = self.format();
            }
        }
    }

    fn format(&self) -> Option<Format> {
        self.last.as_ref().map(|(_, header)| header.format)
    }

    fn add(&mut self, header: TextHeader) {
        let number = self.last.as_ref().map_or(0, |(number, _)| number + 1);
        self.last = Some((number, Arc::new(header)));
    }
}

/// A header in a block.
#[derive(Debug)]
pub(super) struct Known {
    /// Of the matrix in the file.
    pub(super) number: usize,
    pub(super) header: Arc<TextHeader>,
    pub(super) is_wanted: bool,
}

/// What a block has.
#[derive(Debug, Default)]
pub(super) struct Block {
    /// Numbers before the first head.
    pub(super) carried: Vec<f64>,
    pub(super) heads: Vec<Head>,
    /// Those that begin columns: column, first row, length.
    columns: Vec<[u32; 3]>,
    pub(super) headers: Vec<Known>,
    /// Entries of strings before the first column, of the column that the blocks before end with; their own column doesn't count.
    pub(super) headless: Entries,
    /// Entries behind the first column, by the number of their matrix.
    pub(super) parts: Vec<(usize, Entries)>,
    /// Numbers behind the last head.
    pub(super) numbers: u32,
}

/// A line that isn't numbers, in 16 bytes: where strings are short there are many.
#[derive(Clone, Copy, Debug)]
pub(super) struct Head {
    /// 0-based in the block.
    pub(super) line: u32,
    /// Numbers between this head and the one before in this block, and above them the kind.
    numbers_and_kind: u32,
    first: u32,
    second: u32,
}

/// Bits of the numbers that a block can have.
const NUMBER_BITS: u32 = 24;

#[derive(Clone, Copy, Debug)]
pub(super) enum What {
    /// A header, by its place in the block's list.
    Matrix(u32),
    /// Column, first row, length.
    Column([u32; 3]),
    /// A string.
    Run { first_row: u32, length: u32 },
}

impl Block {
    /// What a head of this block is.
    pub(super) fn what(&self, head: &Head) -> What {
        match head.numbers_and_kind >> NUMBER_BITS {
            0 => What::Matrix(head.first),
            1 => What::Column(self.columns[head.first as usize]),
            _ => What::Run {
                first_row: head.first,
                length: head.second,
            },
        }
    }

    fn add_head(&mut self, line: u32, what: What) {
        let (kind, first, second) = match what {
            What::Matrix(place) => (0, place, 0),
            What::Column(column) => {
                self.columns.push(column);
                (1, self.columns.len() as u32 - 1, 0)
            }
            What::Run { first_row, length } => (2, first_row, length),
        };
        let numbers = std::mem::take(&mut self.numbers);
        self.heads.push(Head {
            line,
            numbers_and_kind: numbers | kind << NUMBER_BITS,
            first,
            second,
        });
    }
}

impl Head {
    /// Numbers between this head and the one before in this block.
    pub(super) fn numbers_before(&self) -> u32 {
        self.numbers_and_kind & ((1 << NUMBER_BITS) - 1)
    }
}

/// Where numbers go.
#[derive(Clone, Copy)]
enum To {
    /// Nothing was seen of what they belong to.
    Carried,
    /// Column and next row, 0-based, and whether zeros are entries.
    Rows(u32, u32, bool),
    /// They don't count.
    Nowhere,
}

struct Reader<'a> {
    block: &'a mut Block,
    matrix: Option<Arc<TextHeader>>,
    number: usize,
    is_wanted: bool,
    column: Option<u32>,
    to: To,
    entries: Entries,
    /// Numbers that the block may have.
    room: usize,
}

/// Reads the lines of a block.
pub(super) fn read(
    cursor: &mut Cursor<'_>,
    context: Context,
    is_wanted: &impl Fn(usize) -> bool,
    block: &mut Block,
) -> Result<(), Stopped> {
    let (number, matrix) = match context.last {
        Some((number, header)) => (Some(number), Some(header)),
        None => (None, None),
    };
    let mut next = number.map_or(0, |number| number + 1);
    let mut reader = Reader {
        block,
        is_wanted: number.is_some_and(is_wanted)
            && matrix
                .as_ref()
                .is_some_and(|header| header.matrix.size().is_ok()),
        number: number.unwrap_or(0),
        matrix,
        column: None,
        to: To::Carried,
        entries: Entries::default(),
        room: likely_count(cursor.text()),
    };
    loop {
        let at = cursor.line();
        let Some(line) = cursor.take_line() else {
            break;
        };
        let format = reader.matrix.as_ref().map(|header| header.format);
        let refused = |message| Stopped::BadLine { line: at, message };
        match format {
            Some(format) if is_numbers(line, format) => {
                if reader.is_wanted {
                    reader.numbers(line, format).map_err(refused)?;
                }
            }
            _ => match (TextHeader::of(line), format) {
                (Some(header), _) => {
                    let header = Arc::new(header.map_err(refused)?);
                    reader.begin(header, next, is_wanted(next), at);
                    next += 1;
                }
                (None, None) => {
                    return Err(refused(format!(
                        "`{}`; expected the header of a matrix, such as `     240    -240       6       2KGG     1P,3E23.16`",
                        shown(line)
                    )));
                }
                (None, Some(_)) if !reader.is_wanted || line.trim_ascii().is_empty() => {}
                (None, Some(_)) => reader.head(line, at).map_err(refused)?,
            },
        }
    }
    reader.end_part();
    block.heads.shrink_to_fit();
    block.columns.shrink_to_fit();
    Ok(())
}

/// Numbers of a text that goes on as it begins, and some more.
fn likely_count(text: &[u8]) -> usize {
    const LOOKED_AT: usize = 4096;
    let start = &text[..text.len().min(LOOKED_AT)];
    let points = start.iter().filter(|&&byte| byte == b'.').count();
    let count = (points + 1) * text.len() / start.len().max(1);
    // Narrower fields are refused.
    (count + count / 64).min(text.len() / 8)
}

/// Whether a line has numbers: a point where the first number has one, or in other layouts anywhere in its field.
#[inline(always)]
fn is_numbers(line: &[u8], format: Format) -> bool {
    line.get(format.point) == Some(&b'.') || {
        let field = &line[..format.width.min(line.len())];
        memchr(b'.', field).is_some() && memchr(b',', line).is_none()
    }
}

impl Reader<'_> {
    fn begin(&mut self, header: Arc<TextHeader>, number: usize, is_wanted: bool, line: u32) {
        self.end_part();
        let what = What::Matrix(self.block.headers.len() as u32);
        self.block.add_head(line, what);
        // What can't be read is told when the blocks before are there.
        self.is_wanted = is_wanted && header.matrix.size().is_ok();
        self.block.headers.push(Known {
            number,
            header: Arc::clone(&header),
            is_wanted,
        });
        self.matrix = Some(header);
        self.number = number;
        self.column = None;
        self.to = To::Nowhere;
    }

    fn end_part(&mut self) {
        let mut entries = std::mem::take(&mut self.entries);
        entries.give_back_room();
        match self.column {
            _ if entries.is_empty() => {}
            Some(_) => self.block.parts.push((self.number, entries)),
            None => self.block.headless = entries,
        }
    }

    /// A line of numbers.
    fn numbers(&mut self, line: &[u8], format: Format) -> Result<(), String> {
        let line = line.trim_ascii_end();
        for field in line.chunks(format.width) {
            let value = value(field).map_err(|reason| unusable(field, reason))?;
            match &mut self.to {
                To::Rows(column, row, keeps_zeros) => {
                    self.block.numbers += 1;
                    if value != 0.0 || *keeps_zeros {
                        let (column, row) = (*column, *row);
                        self.entries.push(Triplet { row, column, value });
                    }
                    *row += 1;
                }
                To::Carried => self.block.carried.push(value),
                To::Nowhere => self.block.numbers += 1,
            }
        }
        if let (To::Rows(column, row, _), Some(header)) = (self.to, &self.matrix)
            && u64::from(row) > header.matrix.rows
        {
            return Err(format!(
                "column {} has numbers beyond row {}",
                column + 1,
                header.matrix.rows
            ));
        }
        Ok(())
    }

    /// The line that begins a column or string.
    fn head(&mut self, line: &[u8], at: u32) -> Result<(), String> {
        let Some(header) = &self.matrix else {
            return Ok(());
        };
        let header = &header.matrix;
        let (is_bigmat, columns) = (header.is_bigmat, header.columns);
        let text = line.trim_ascii_end();
        let is_packed = !is_bigmat && !text.trim_ascii_start().contains(&b' ');
        let unreadable = || format!("`{}`; {EXPECTED}", shown(line));
        let what = if is_packed {
            let run = signed(text).and_then(Run::packed);
            run_head(run.ok_or_else(unreadable)?).ok_or_else(unreadable)?
        } else {
            match text.len() {
                24 | 48 => {
                    let [column, row, length] = fields::<3>(text).ok_or_else(unreadable)?;
                    let small = |value| u32::try_from(value).map_err(|_| unreadable());
                    What::Column([small(column)?, small(row)?, small(length)?])
                }
                16 | 32 => {
                    let run =
                        fields::<2>(text).and_then(|[length, row]| Run::unpacked(length, row));
                    run_head(run.ok_or_else(unreadable)?).ok_or_else(unreadable)?
                }
                _ => return Err(unreadable()),
            }
        };
        self.block.add_head(at, what);
        if let What::Column([column, ..]) = what {
            if self.column.is_none() {
                self.end_part();
            }
            self.column = Some(column);
        }
        let column = match self.column {
            Some(column) if u64::from(column) > columns => None,
            // Until the first column shows, any will do.
            column => column.unwrap_or(1).checked_sub(1),
        };
        let (first_row, keeps_zeros) = match what {
            What::Column([_, first_row, _]) => (first_row, false),
            What::Run { first_row, .. } => (first_row, true),
            What::Matrix(_) => (0, false),
        };
        self.to = match (column, first_row.checked_sub(1)) {
            (Some(column), Some(row)) => To::Rows(column, row, keeps_zeros),
            _ => To::Nowhere,
        };
        if self.entries.is_empty() {
            self.entries = Entries::with_capacity(self.room).unwrap_or_default();
        }
        Ok(())
    }
}

const EXPECTED: &str = "expected the integers that begin a column or a string, 8 or 16 characters each, or numbers with a point";

/// Integers that fill a line, equally wide.
fn fields<const N: usize>(line: &[u8]) -> Option<[i64; N]> {
    let mut integers = [0; N];
    let width = line.len() / N;
    for (integer, field) in integers.iter_mut().zip(line.chunks(width)) {
        *integer = signed(field)?;
    }
    Some(integers)
}

fn run_head(run: Run) -> Option<What> {
    Some(What::Run {
        first_row: u32::try_from(run.first_row).ok()?,
        length: u32::try_from(run.length).ok()?,
    })
}

/// The number in a field.
#[inline]
fn value(field: &[u8]) -> Result<f64, NotANumber> {
    let letter = field.len().wrapping_sub(4);
    let blanks = field.iter().take_while(|byte| **byte == b' ').count();
    if field.get(letter) == Some(&b'E')
        && let Ok(value) = fast_float2::parse::<f64, _>(&field[blanks..])
        && value.is_finite()
    {
        return Ok(value);
    }
    whole_real(field)
}

#[cold]
fn unusable(field: &[u8], reason: NotANumber) -> String {
    let expected = match reason {
        NotANumber::NotFinite => "expected a finite number",
        _ => "expected a number in every field of the width that the header gives",
    };
    format!("`{}`; {expected}", shown(field))
}
