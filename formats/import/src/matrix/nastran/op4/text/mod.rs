//! Nastran's OUTPUT4, ASCII: integers and numbers in fields of fixed width.
//!
//! A header has columns, rows (negative: *bigmat*), form, type, a name of eight characters and the format of the numbers, such as
//! `1P,3E23.16`; behind `|I16` the sizes have 16 characters instead of 8. A column has its number, its first row (0: strings) and a length:
//! numbers in a dense column, words of 4 or of 8 bytes in one with strings. Nothing says how long words are, but numbers and lengths do.
//!
//! A line says by itself what it is: numbers have a point, headers four integers at least. So blocks of lines are read side by side; what the first
//! numbers of a block belong to is known when the blocks before are there.

mod assembly;
mod block;
mod format;

use std::path::Path;

use dcb_formats::Error;
use dcb_formats::matrix::blocks::TextBlocks;

use crate::matrix::wanted::Wanted;
use crate::stored::{Listed, Reading, StoredMatrix};
use crate::text::cursor::Cursor;
use crate::text::line_blocks::{LineBlock, look_at_text, read_line_blocks_in_context, read_text};
use assembly::Matrix;
use block::{Block, Context, Known, What};
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
    look_at_text(path, |text| {
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
    })
}

/// Reads matrices by their place in the list.
///
/// # Errors
/// [`Error::Line`] for what isn't OUTPUT4: numbers missing or left over, places outside, values that aren't finite; [`Error::File`] for
/// matrices that aren't real and square, and files that are cut off; [`Error::Io`].
pub fn read(path: &Path, wanted: &[usize]) -> Result<Reading, Error> {
    let wanted = Wanted::new(wanted);
    let (matrices, sha256) = read_text(path, |text| {
        let mut matrices = Matrices {
            path,
            current: None,
            ended: Vec::new(),
        };
        read_blocks(path, text, &wanted, &mut matrices)?;
        matrices.finish()
    })?;
    wanted.reading(path, matrices, sha256)
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
    matrices: &mut Matrices<'_>,
) -> Result<(), Error> {
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
    let take = |block: &mut LineBlock<Block>| matrices.take(std::mem::take(block));
    read_line_blocks_in_context(path, text, 0, look, work, take).map(|_| ())
}

/// Matrices on their way, while their blocks are looked through in file order.
struct Matrices<'a> {
    path: &'a Path,
    current: Option<Matrix>,
    /// Those that are whole.
    ended: Vec<Matrix>,
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
            let what = content.what(head);
            if let What::Matrix(place) = what {
                if let Some(matrix) = self.current.take() {
                    matrix.check_end().map_err(at_line)?;
                    self.ended.push(matrix);
                }
                let known: &Known = &content.headers[place as usize];
                self.current = match known.is_wanted {
                    true => Some(Matrix::new(known).map_err(at_line)?),
                    false => None,
                };
            } else if let Some(matrix) = &mut self.current {
                let taken = matrix.head(head.numbers_before(), what);
                taken.map_err(at_line)?;
            }
        }
        if let (Some(matrix), true) = (&mut self.current, content.numbers > 0) {
            let taken = matrix.numbers(u64::from(content.numbers));
            let line = content.heads.last().map_or(0, |head| head.line);
            taken.map_err(|message| refused(line, message))?;
        }
        for (number, entries) in block.content.parts {
            let mut matrices = self.current.iter_mut().chain(&mut self.ended);
            if let Some(matrix) = matrices.find(|matrix| matrix.number == number) {
                matrix.add(entries);
            }
        }
        Ok(())
    }

    fn finish(self) -> Result<Vec<(usize, StoredMatrix)>, Error> {
        let refused = |message: String| Error::File {
            path: self.path.into(),
            message,
        };
        if let Some(matrix) = &self.current {
            let ends = matrix.check_end();
            ends.map_err(|message| refused(format!("{message}; the file is cut off")))?;
        }
        let matrices = self.ended.into_iter().chain(self.current);
        matrices
            .map(|matrix| matrix.stored().map_err(refused))
            .collect()
    }
}
