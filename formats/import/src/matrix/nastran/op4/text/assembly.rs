//! A matrix of an ASCII file while its blocks are looked through in file order: lengths are compared with what follows them.

use dcb_formats::matrix::blocks::{Entries, Gathered, Triplet};

use super::block::{Known, What};
use crate::matrix::nastran::op4::{Header, Places};
use crate::stored::{Content, Rows, StoredMatrix, Triangles};

/// A matrix of which some blocks were seen.
pub(super) struct Matrix {
    pub(super) number: usize,
    header: Header,
    digits: u32,
    places: Places,
    entries: Gathered,
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

impl Matrix {
    pub(super) fn new(known: &Known) -> Result<Self, String> {
        let header = known.header.matrix.clone();
        header.size()?;
        Ok(Self {
            number: known.number,
            digits: known.header.format.digits,
            places: Places::new(&header),
            header,
            entries: Gathered::default(),
            state: State::Between,
            words_each: None,
        })
    }

    /// Numbers at the beginning of a block, which belong to what stood before.
    pub(super) fn carry(&mut self, numbers: &[f64]) -> Result<(), String> {
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
    pub(super) fn carry_strings(&mut self, found: &Entries) {
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
    pub(super) fn numbers(&mut self, count: u64) -> Result<(), String> {
        match &mut self.state {
            State::Dense { got, .. } | State::String { got, .. } => *got += count,
            State::Ended => {}
            State::Between | State::Strings { .. } => return Err(no_head()),
        }
        Ok(())
    }

    /// The beginning of a column or string, and the numbers before it.
    pub(super) fn head(&mut self, numbers_before: u32, what: What) -> Result<(), String> {
        if numbers_before > 0 {
            self.numbers(u64::from(numbers_before))?;
        }
        self.close_run()?;
        match what {
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

    /// Entries of the next block.
    pub(super) fn add(&mut self, entries: Entries) {
        self.entries.push(entries);
    }

    /// Compares what came with the header, behind which nothing may be missing.
    pub(super) fn check_end(&self) -> Result<(), String> {
        if !matches!(self.state, State::Ended) {
            return Err(format!(
                "the matrix `{}` has no end: no column {} behind its last one",
                self.header.name,
                self.header.columns + 1
            ));
        }
        self.header.size().map(|_| ())
    }

    /// The whole matrix, with its number.
    pub(super) fn stored(self) -> Result<(usize, StoredMatrix), String> {
        let matrix = StoredMatrix {
            size: self.header.size()? as usize,
            name: self.header.name,
            triangles: Triangles::Both,
            content: Content::Entries(self.entries.into_blocks()),
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
