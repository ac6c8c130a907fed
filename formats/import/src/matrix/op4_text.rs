//! Nastran's OUTPUT4, ASCII: integers and numbers in fields of fixed width.
//!
//! A header has columns, rows (negative: *bigmat*), form, type, a name of eight characters and the format of the numbers, such as
//! `1P,3E23.16`; behind `|I16` the sizes have 16 characters instead of 8. A column has its number, its first row (0: strings) and a length:
//! numbers in a dense column, words of 4 or of 8 bytes in one with strings. Nothing says how long words are, but numbers and lengths do.
//!
//! A line says by itself what it is: numbers have a point, headers four integers at least. So blocks of lines are read side by side; what the first
//! numbers of a block belong to is known when the blocks before are there.

mod block;
mod format;

use std::path::Path;

use dcb_formats::Error;
use dcb_formats::matrix::blocks::{Entries, TextBlocks, Triplet};

use super::op4::{Header, Places};
use super::wanted::Wanted;
use crate::cursor::Cursor;
use crate::line_blocks::{LineBlock, read_line_blocks_in_context, read_text};
use crate::stored::{Content, Listed, Reading, Rows, StoredMatrix, Triangles};
use block::{Block, Context, Head, Known, What};
use format::TextHeader;

/// Whether a file begins with the header of a matrix.
pub fn recognises(start: &[u8]) -> bool {
    let line = start.split(|&byte| byte == b'\n').next();
    line.is_some_and(|line| {
        line.contains(&b',') && TextHeader::of(line).is_some_and(|header| header.is_ok())
    })
}

/// The matrices of a file, without reading their numbers.
///
/// # Errors
/// [`Error::Line`] for a file that doesn't begin with a matrix; [`Error::Io`].
pub fn list(path: &Path) -> Result<Vec<Listed>, Error> {
    let (listed, _) = read_text(path, |text| {
        let mut context = Context::default();
        let mut found = Vec::new();
        let mut block = Vec::new();
        loop {
            let used = text.next_block(&mut block)?;
            if used == 0 {
                return Ok(found);
            }
            context.look(&block[..used], |header| found.push(header.listed()));
            if found.is_empty() {
                return Err(no_header(path));
            }
        }
    })?;
    Ok(listed)
}

/// Reads matrices by their place in the list.
///
/// # Errors
/// [`Error::Line`] for what isn't OUTPUT4: numbers missing or left over, places outside, values that aren't finite; [`Error::File`] for
/// matrices that aren't real and square, and files that are cut off; [`Error::Io`].
pub fn read(path: &Path, wanted: &[usize]) -> Result<Reading, Error> {
    let mut wanted = Wanted::new(wanted);
    let (matrices, sha256) = read_text(path, |text| {
        let blocks = read_blocks(path, text, &wanted)?;
        let mut matrices = Matrices {
            path,
            current: None,
            found: Vec::new(),
        };
        for block in blocks {
            matrices.take(block)?;
        }
        let found = matrices.finish()?;
        Ok(found)
    })?;
    for (number, matrix) in matrices {
        wanted.put(number, matrix);
    }
    Ok(Reading {
        matrices: wanted.found(path)?,
        sha256,
    })
}

fn no_header(path: &Path) -> Error {
    Error::Line {
        path: path.into(),
        line: 1,
        message: "expected the header of a matrix of OUTPUT4: columns, rows, form and type with 8 characters each, a name of 8 and a format such as 1P,3E23.16".into(),
    }
}

fn read_blocks(
    path: &Path,
    text: &mut TextBlocks,
    wanted: &Wanted<'_>,
) -> Result<Vec<LineBlock<Block>>, Error> {
    let mut context = Context::default();
    let look = |block: &[u8]| {
        let before = context.clone();
        context.look(block, |_| {});
        before
    };
    let is_wanted = |number| wanted.has(number);
    let work = |cursor: &mut Cursor<'_>, context: Context, block: &mut Block| {
        block::read(cursor, context, &is_wanted, block)
    };
    read_line_blocks_in_context(path, text, 0, look, work)
}

/// Matrices on their way, while their blocks are looked through in file order.
struct Matrices<'a> {
    path: &'a Path,
    current: Option<Matrix>,
    found: Vec<(usize, StoredMatrix)>,
}

/// A matrix of which some blocks were seen.
struct Matrix {
    number: usize,
    header: Header,
    digits: u32,
    places: Places,
    entries: Vec<Entries>,
    state: State,
    /// Words of a number, once a string has shown them.
    words_each: Option<u64>,
}

/// What the numbers that come next belong to.
#[derive(Clone, Copy)]
enum State {
    /// Nothing: a column, or the end of the matrix, must come.
    Between,
    /// A dense column.
    Dense {
        first_row: u64,
        length: u64,
        got: u64,
    },
    /// A string of a column, with the words that are left for other strings.
    String {
        first_row: u64,
        length: u64,
        got: u64,
        words_left: u64,
    },
    /// A column whose strings follow.
    Strings { words_left: u64 },
    /// The matrix is complete; what numbers follow don't count.
    Ended,
}

impl Matrices<'_> {
    fn take(&mut self, block: LineBlock<Block>) -> Result<(), Error> {
        let refused = |line: u32, message: String| block.refused(self.path, line, message);
        let content = &block.content;
        if let Some(matrix) = &mut self.current {
            let taken = matrix.carry(&content.carried);
            taken.map_err(|message| refused(0, message))?;
            matrix.carry_strings(&content.headless);
        }
        for head in &content.heads {
            let at_line = |message: String| refused(head.line, message);
            if let What::Matrix(place) = head.what {
                if let Some(matrix) = self.current.take() {
                    self.found.push(matrix.finish().map_err(at_line)?);
                }
                let known: &Known = &content.headers[place as usize];
                self.current = match known.is_wanted {
                    true => Some(Matrix::new(known).map_err(at_line)?),
                    false => None,
                };
            } else if let Some(matrix) = &mut self.current {
                matrix.head(head).map_err(at_line)?;
            }
        }
        if let (Some(matrix), true) = (&mut self.current, content.numbers > 0) {
            let taken = matrix.numbers(u64::from(content.numbers));
            let line = content.heads.last().map_or(0, |head| head.line);
            taken.map_err(|message| refused(line, message))?;
        }
        for (number, entries) in block.content.parts {
            if let Some(matrix) = &mut self.current
                && matrix.number == number
            {
                matrix.entries.push(entries);
            } else if let Some((
                _,
                StoredMatrix {
                    content: Content::Entries(blocks),
                    ..
                },
            )) = self.found.iter_mut().find(|(other, _)| *other == number)
            {
                blocks.push(entries);
            }
        }
        Ok(())
    }

    fn finish(mut self) -> Result<Vec<(usize, StoredMatrix)>, Error> {
        if let Some(matrix) = self.current.take() {
            let finished = matrix.finish();
            self.found.push(finished.map_err(|message| Error::File {
                path: self.path.into(),
                message: format!("{message}; the file is cut off"),
            })?);
        }
        Ok(self.found)
    }
}

impl Matrix {
    fn new(known: &Known) -> Result<Self, String> {
        let header = known.header.matrix.clone();
        header.size()?;
        Ok(Self {
            number: known.number,
            digits: known.header.format.digits,
            places: Places::new(&header),
            header,
            entries: Vec::new(),
            state: State::Between,
            words_each: None,
        })
    }

    /// Numbers at the beginning of a block, which belong to what stood before.
    fn carry(&mut self, numbers: &[f64]) -> Result<(), String> {
        if numbers.is_empty() {
            return Ok(());
        }
        let (first_row, got, keeps_zeros) = match self.state {
            State::Dense { first_row, got, .. } => (first_row, got, false),
            State::String { first_row, got, .. } => (first_row, got, true),
            State::Ended => return Ok(()),
            State::Between | State::Strings { .. } => return Err(no_head()),
        };
        self.numbers(numbers.len() as u64)?;
        let rows = first_row + got..;
        if first_row + got + numbers.len() as u64 > self.header.rows + 1 {
            return Err(self.beyond());
        }
        let mut entries = Entries::with_capacity(numbers.len()).unwrap_or_default();
        let column = self.places.column() as u32 - 1;
        for (row, &value) in rows.zip(numbers) {
            if value != 0.0 || keeps_zeros {
                let row = row as u32 - 1;
                entries.push(Triplet { row, column, value });
            }
        }
        entries.give_back_room();
        self.entries.push(entries);
        Ok(())
    }

    /// Entries of strings at the beginning of a block, which belong to the column that stood before.
    fn carry_strings(&mut self, found: &Entries) {
        let Some(column) = (self.places.column() as u32).checked_sub(1) else {
            return;
        };
        let mut entries = Entries::with_capacity(found.len()).unwrap_or_default();
        for Triplet { row, value, .. } in found.iter() {
            entries.push(Triplet { row, column, value });
        }
        self.entries.push(entries);
    }

    fn beyond(&self) -> String {
        format!(
            "column {} has numbers beyond row {}",
            self.places.column(),
            self.header.rows
        )
    }

    /// So many more numbers.
    fn numbers(&mut self, count: u64) -> Result<(), String> {
        match &mut self.state {
            State::Dense { got, .. } | State::String { got, .. } => *got += count,
            State::Ended => {}
            State::Between | State::Strings { .. } => return Err(no_head()),
        }
        Ok(())
    }

    /// The beginning of a column or string, and the numbers before it.
    fn head(&mut self, head: &Head) -> Result<(), String> {
        if head.numbers_before > 0 {
            self.numbers(u64::from(head.numbers_before))?;
        }
        self.close_run()?;
        match head.what {
            What::Column([column, first_row, length]) => {
                let (column, first_row) = (u64::from(column), u64::from(first_row));
                let length = u64::from(length);
                match self.state {
                    State::Between => {}
                    State::Ended => {
                        return Err("a column behind the end of the matrix".into());
                    }
                    _ => {
                        return Err(format!(
                            "column {} is {} words short of what it announces",
                            self.places.column(),
                            self.words_left()
                        ));
                    }
                }
                self.places.begin(column)?;
                self.state = if column > self.header.columns {
                    State::Ended
                } else if first_row == 0 {
                    State::Strings { words_left: length }
                } else {
                    State::Dense {
                        first_row,
                        length,
                        got: 0,
                    }
                };
                if matches!(self.state, State::Strings { words_left: 0 }) {
                    self.state = State::Between;
                }
            }
            What::Run { first_row, length } => {
                let State::Strings { words_left } = self.state else {
                    return Err("a string outside a column with strings".into());
                };
                let length = u64::from(length);
                let head_words = if self.header.is_bigmat { 2 } else { 1 };
                let Some(words_left) = words_left.checked_sub(length + head_words) else {
                    return Err(format!(
                        "a string of {length} words where column {} has {words_left} left",
                        self.places.column()
                    ));
                };
                self.state = State::String {
                    first_row: u64::from(first_row),
                    length,
                    got: 0,
                    words_left,
                };
            }
            What::Matrix(_) => {}
        }
        Ok(())
    }

    fn words_left(&self) -> u64 {
        match self.state {
            State::Strings { words_left } => words_left,
            _ => 0,
        }
    }

    /// Compares the numbers of a dense column or string with its length.
    fn close_run(&mut self) -> Result<(), String> {
        match self.state {
            State::Dense {
                first_row,
                length,
                got,
            } => {
                if got != length {
                    return Err(format!(
                        "column {} announces {length} numbers and has {got}",
                        self.places.column()
                    ));
                }
                self.places.take(first_row, got)?;
                self.state = State::Between;
            }
            State::String {
                first_row,
                length,
                got,
                words_left,
            } => {
                let words_each = length.checked_div(got).unwrap_or(0);
                let is_possible = match self.header.numbers.is_double() {
                    true => matches!(words_each, 1 | 2),
                    false => words_each == 1,
                };
                let is_same = self.words_each.is_none_or(|words| words == words_each);
                if !is_possible || !is_same || got * words_each != length {
                    return Err(format!(
                        "a string of column {} announces {length} words and has {got} numbers",
                        self.places.column()
                    ));
                }
                self.words_each = Some(words_each);
                self.places.take(first_row, got)?;
                self.state = match words_left {
                    0 => State::Between,
                    _ => State::Strings { words_left },
                };
            }
            State::Between | State::Strings { .. } | State::Ended => {}
        }
        Ok(())
    }

    /// The whole matrix.
    fn finish(self) -> Result<(usize, StoredMatrix), String> {
        if !matches!(self.state, State::Ended) {
            return Err(format!(
                "the matrix `{}` has no end: no column {} behind its last one",
                self.header.name,
                self.header.columns + 1
            ));
        }
        let matrix = StoredMatrix {
            size: self.header.size()? as usize,
            name: self.header.name,
            triangles: Triangles::Both,
            content: Content::Entries(self.entries),
            rows: Rows::Unlabelled,
            digits: Some(self.digits),
            notes: Vec::new(),
        };
        Ok((self.number, matrix))
    }
}

fn no_head() -> String {
    "numbers without the column or string that they belong to".into()
}
