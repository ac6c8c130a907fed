//! A place in a block of lines that numbers are read from.

use dcb_formats::matrix::blocks::{CR_ALONE, NotANumber, real, shown, unsigned};

use crate::text::real::Digits;

/// Why the work on a block ended before the block.
#[derive(Debug)]
pub enum Stopped {
    /// A line can't be used.
    BadLine {
        /// 0-based in the block.
        line: u32,
        /// Found and expected.
        message: String,
    },
    /// The system gave no memory.
    NoMemory {
        /// Asked for.
        bytes: u64,
    },
}

/// A place in a block of lines.
#[derive(Clone, Copy)]
pub struct Cursor<'a> {
    text: &'a [u8],
    at: usize,
    line: u32,
}

impl<'a> Cursor<'a> {
    /// At the beginning of a block.
    pub fn new(text: &'a [u8]) -> Self {
        Self {
            text,
            at: 0,
            line: 0,
        }
    }

    /// The whole block.
    pub fn text(&self) -> &'a [u8] {
        self.text
    }

    /// 0-based line in the block.
    pub fn line(&self) -> u32 {
        self.line
    }

    /// The byte here; `None` at the end of the block.
    #[inline(always)]
    pub fn byte(&self) -> Option<u8> {
        self.text.get(self.at).copied()
    }

    /// Passes blanks, line ends and lines that begin with `comment`; false at the end of the block.
    #[inline(always)]
    pub fn advance(&mut self, comment: &[u8]) -> bool {
        while let Some(byte) = self.byte() {
            match byte {
                b' ' | b'\t' => self.at += 1,
                b'\n' => {
                    self.at += 1;
                    self.line += 1;
                }
                b'\r' if self.is_line_end() => self.at += 1,
                _ if byte == comment[0] && self.text[self.at..].starts_with(comment) => {
                    self.pass_line();
                }
                _ => return true,
            }
        }
        false
    }

    /// Goes to the end of the line.
    pub fn pass_line(&mut self) {
        self.at += self.rest_of_line().len();
    }

    /// Passes the rest of the line, which is returned with its end; `None` at the end of the block.
    #[inline]
    pub fn pass_whole_line(&mut self) -> Option<&'a [u8]> {
        let rest = self.text.get(self.at..).filter(|rest| !rest.is_empty())?;
        let end = memchr::memchr(b'\n', rest);
        let length = end.map_or(rest.len(), |end| end + 1);
        self.at += length;
        self.line += u32::from(end.is_some());
        Some(&rest[..length])
    }

    /// As [`Cursor::pass_whole_line`], without the line's end.
    #[inline]
    pub fn take_line(&mut self) -> Option<&'a [u8]> {
        let line = self.pass_whole_line()?;
        let line = line.strip_suffix(b"\n").unwrap_or(line);
        Some(line.strip_suffix(b"\r").unwrap_or(line))
    }

    /// Passes blanks; whether there were some.
    #[inline(always)]
    pub fn pass_blanks(&mut self) -> bool {
        let before = self.at;
        while matches!(self.byte(), Some(b' ' | b'\t')) {
            self.at += 1;
        }
        self.at > before
    }

    /// Passes a byte if it is here.
    #[inline(always)]
    pub fn pass(&mut self, byte: u8) -> bool {
        let is_here = self.byte() == Some(byte);
        self.at += usize::from(is_here);
        is_here
    }

    /// Whether nothing is left of the line.
    #[inline(always)]
    pub fn is_line_end(&self) -> bool {
        match self.byte() {
            None | Some(b'\n') => true,
            Some(b'\r') => matches!(self.text.get(self.at + 1), None | Some(b'\n')),
            _ => false,
        }
    }

    /// The unsigned integer here, which is passed.
    ///
    /// # Errors
    /// As [`unsigned`].
    #[inline(always)]
    pub fn unsigned(&mut self) -> Result<u64, NotANumber> {
        let (value, length) = unsigned(&self.text[self.at..])?;
        self.at += length;
        Ok(value)
    }

    /// The real number here, which is passed; its digits are counted.
    ///
    /// # Errors
    /// As [`real`].
    #[inline(always)]
    pub fn real(&mut self, digits: &mut Digits) -> Result<f64, NotANumber> {
        let rest = &self.text[self.at..];
        let (value, length) = real(rest)?;
        digits.see(&rest[..length]);
        self.at += length;
        Ok(value)
    }

    /// What is left of the block.
    pub fn rest(&self) -> &'a [u8] {
        &self.text[self.at..]
    }

    /// What is left of the line.
    pub fn rest_of_line(&self) -> &'a [u8] {
        let rest = &self.text[self.at..];
        let end = rest.iter().position(|&byte| byte == b'\n');
        &rest[..end.unwrap_or(rest.len())]
    }

    /// The whole line, without blanks around it.
    pub fn whole_line(&self) -> &'a [u8] {
        let before = self.text[..self.at].iter().rposition(|&byte| byte == b'\n');
        let line = &self.text[before.map_or(0, |end| end + 1)..];
        let end = line.iter().position(|&byte| byte == b'\n');
        line[..end.unwrap_or(line.len())].trim_ascii()
    }

    /// Refuses the line for what it should be.
    #[cold]
    pub fn expected(&self, expected: &str) -> Stopped {
        let line = shown(self.whole_line());
        self.refused(format!("`{line}`; expected {expected}"))
    }

    /// Refuses the line.
    #[cold]
    pub fn refused(&self, message: impl Into<String>) -> Stopped {
        let message = match self.whole_line().contains(&b'\r') {
            true => CR_ALONE.into(),
            false => message.into(),
        };
        Stopped::BadLine {
            line: self.line,
            message,
        }
    }
}
