//! Text files that are read line after line.

use std::path::{Path, PathBuf};

use dcb_formats::Error;
use dcb_formats::matrix::blocks::TextBlocks;

/// A text file, one line after the other; `\n` and `\r\n` end lines. Plain or gzipped.
pub struct Lines {
    path: PathBuf,
    text: TextBlocks,
    block: Vec<u8>,
    used: usize,
    at: usize,
    /// 1-based number of the line that was given out last.
    number: u64,
}

impl Lines {
    /// Opens a file.
    ///
    /// # Errors
    /// As [`TextBlocks::open`].
    pub fn open(path: &Path) -> Result<Self, Error> {
        Ok(Self {
            path: path.into(),
            text: TextBlocks::open(path)?,
            block: Vec::new(),
            used: 0,
            at: 0,
            number: 0,
        })
    }

    /// The next line without its end; `None` at the end of the text.
    ///
    /// # Errors
    /// As [`TextBlocks::next_block`].
    pub fn next(&mut self) -> Result<Option<&[u8]>, Error> {
        if self.at == self.used {
            self.used = self.text.next_block(&mut self.block)?;
            self.at = 0;
            if self.used == 0 {
                return Ok(None);
            }
        }
        let rest = &self.block[self.at..self.used];
        let length = rest.iter().position(|byte| *byte == b'\n');
        let line = &rest[..length.unwrap_or(rest.len())];
        self.at += line.len() + usize::from(length.is_some());
        self.number += 1;
        Ok(Some(line.strip_suffix(b"\r").unwrap_or(line)))
    }

    /// 1-based number of the line that was given out last.
    pub fn number(&self) -> u64 {
        self.number
    }

    /// An error in the line that was given out last.
    pub fn refused(&self, message: impl Into<String>) -> Error {
        Error::Line {
            path: self.path.clone(),
            line: self.number,
            message: message.into(),
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
