//! One entry of a Matrix Market file, as its line has it.

use super::entries::Triplet;
use super::header::{Field, Layout, MatrixHeader, Symmetry, shown};
use super::number::{self, NotANumber};

/// A bad place: its line in the block, 0-based.
#[derive(Debug)]
pub(super) struct BadEntry {
    pub(super) line: u32,
    pub(super) message: String,
}

/// A place in the text of a block.
pub(super) struct EntryReader<'a> {
    text: &'a [u8],
    at: usize,
    /// 0-based.
    pub(super) line: u32,
}

impl<'a> EntryReader<'a> {
    /// At the beginning of a text.
    pub(super) fn new(text: &'a [u8]) -> Self {
        Self {
            text,
            at: 0,
            line: 0,
        }
    }

    /// Skips blanks, line ends and comment lines; false at the end.
    #[inline(always)]
    pub(super) fn advance_to_entry(&mut self) -> bool {
        while let Some(&byte) = self.text.get(self.at) {
            match byte {
                b' ' | b'\t' | b'\r' => self.at += 1,
                b'\n' => {
                    self.at += 1;
                    self.line += 1;
                }
                b'%' => self.at += self.rest_of_line().len(),
                _ => return true,
            }
        }
        false
    }

    /// The entry that begins here, up to the end of its line.
    #[inline(always)]
    pub(super) fn entry(&mut self, header: &MatrixHeader) -> Result<Triplet, BadEntry> {
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
            _ if self.word().contains(&b',') => Err(self.refuse(format!(
                "`{}`; expected a number with a decimal point, not a comma",
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
            line: self.line,
            message,
        }
    }
}
