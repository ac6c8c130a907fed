//! Text files that are read line after line.

use std::path::{Path, PathBuf};

use dcb_formats::Error;
use dcb_formats::matrix::blocks::TextBlocks;

use crate::text::line_blocks::BYTE_ORDER_MARK;

/// A text file, one line after the other; `\n` and `\r\n` end lines. Plain or gzipped.
pub struct Lines {
    path: PathBuf,
    text: TextBlocks,
    block: Vec<u8>,
    used: usize,
    at: usize,
    /// 1-based number of the line that was given out last.
    number: u64,
    /// Whether that line has an end.
    is_ended: bool,
}

impl Lines {
    /// Opens a file.
    ///
    /// # Errors
    /// As [`TextBlocks::open`].
    pub fn open(path: &Path) -> Result<Self, Error> {
        let mut text = TextBlocks::open(path)?;
        if text.pending().starts_with(BYTE_ORDER_MARK) {
            text.skip(BYTE_ORDER_MARK.len());
        }
        Ok(Self {
            path: path.into(),
            text,
            block: Vec::new(),
            used: 0,
            at: 0,
            number: 0,
            is_ended: false,
        })
    }

    /// The next line without its end; `None` at the end of the text.
    ///
    /// # Errors
    /// As [`TextBlocks::next_block`], and [`Error::Line`] for lines that end with a carriage return alone.
    pub fn next_line(&mut self) -> Result<Option<&[u8]>, Error> {
        if self.at == self.used {
            self.used = self.text.next_block(&mut self.block)?;
            self.at = 0;
            if self.used == 0 {
                return Ok(None);
            }
        }
        self.number += 1;
        let rest = &self.block[self.at..self.used];
        let length =
            (rest.iter().position(|byte| matches!(byte, b'\n' | b'\r'))).unwrap_or(rest.len());
        let end = match &rest[length..] {
            [] => 0,
            [b'\n', ..] | [b'\r'] => 1,
            [b'\r', b'\n', ..] => 2,
            _ => {
                return Err(self.refused(
                    "has a carriage return that no line feed follows; save the file with line ends of Unix or Windows",
                ));
            }
        };
        self.is_ended = end > 0;
        self.at += length + end;
        Ok(Some(&self.block[self.at - length - end..self.at - end]))
    }

    /// 1-based number of the line that was given out last.
    pub fn number(&self) -> u64 {
        self.number
    }

    /// Whether the line that was given out last has an end; without one the file may be cut off.
    pub fn is_ended(&self) -> bool {
        self.is_ended
    }

    /// An error in the line that was given out last.
    pub fn refused(&self, message: impl Into<String>) -> Error {
        Error::Line {
            path: self.path.clone(),
            line: self.number,
            message: message.into(),
        }
    }

    /// Refuses a last line without an end: nothing else shows that some of it is missing.
    ///
    /// # Errors
    /// [`Error::Line`].
    pub fn refuse_open_end(&self) -> Result<(), Error> {
        match self.is_ended {
            true => Ok(()),
            false => Err(self.refused(
                "the file ends within this line, and may be cut off; if it is whole, end it with a line end",
            )),
        }
    }

    /// SHA-256 of the file as it is on disk, once all lines were given out.
    ///
    /// # Errors
    /// As [`TextBlocks::finish`].
    pub fn finish(self) -> Result<String, Error> {
        self.text.finish()
    }
}
