//! Lines of a table.

use std::path::Path;

use dcb_formats::Error;

use crate::text::line_blocks::BYTE_ORDER_MARK;
use crate::text::lines::Lines;

/// Lines of a table.
pub(super) struct TableLines {
    lines: Lines,
}

impl TableLines {
    pub(super) fn open(path: &Path) -> Result<Self, Error> {
        Ok(Self {
            lines: Lines::open(path)?,
        })
    }

    /// The next line with something on it that is no comment, without blanks around it.
    pub(super) fn next_filled(&mut self) -> Result<Option<Vec<u8>>, Error> {
        loop {
            let Some(line) = self.lines.next_line()? else {
                return Ok(None);
            };
            let line = line
                .strip_prefix(BYTE_ORDER_MARK)
                .unwrap_or(line)
                .trim_ascii();
            let is_comment = matches!(
                line,
                [b'#' | b'%' | b'$' | b'!', ..] | [b'*', b'*', ..] | [b'/', b'/', ..]
            );
            if !line.is_empty() && !is_comment {
                return Ok(Some(line.to_vec()));
            }
        }
    }

    /// 1-based number of the line.
    pub(super) fn number(&self) -> u64 {
        self.lines.number()
    }

    /// Whether the line has an end; only that of a file that is cut off needs none.
    pub(super) fn is_ended(&self) -> bool {
        self.lines.is_ended()
    }

    pub(super) fn refused(&self, message: impl Into<String>) -> Error {
        self.lines.refused(message)
    }

    /// SHA-256 of the file.
    pub(super) fn finish(self) -> Result<String, Error> {
        self.lines.finish()
    }
}
