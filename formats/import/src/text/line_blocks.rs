//! Text files that are read in blocks of lines by all threads, and what is wrong with a line by its number in the file.

use std::path::Path;

use dcb_formats::Error;
use dcb_formats::matrix::blocks::{
    Entries, Rest, TextBlocks, likely_line_count, read_blocks_in_context,
};

use crate::text::cursor::{Cursor, Stopped};

/// What was made of a block of lines.
#[derive(Debug, Default)]
pub struct LineBlock<T> {
    /// What was made of it.
    pub content: T,
    /// 1-based number of its first line in the file.
    pub first_line: u64,
    line_count: u64,
    /// Something stands behind its last line end.
    is_open: bool,
    stopped: Option<Stopped>,
}

/// UTF-8's, which some editors put in front.
pub const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

/// Whether a text begins with the mark of UTF-16, which isn't read.
pub fn is_utf16(start: &[u8]) -> bool {
    start.starts_with(b"\xff\xfe") || start.starts_with(b"\xfe\xff")
}

/// Reads a text file, plain or gzipped, and tells the SHA-256 of its bytes. A bad line that comes of a file that is damaged or was changed
/// meanwhile is told as that.
///
/// # Errors
/// As [`TextBlocks::open`] and [`TextBlocks::finish`], and those of `read`.
pub fn read_text<R>(
    path: &Path,
    read: impl FnOnce(&mut TextBlocks) -> Result<R, Error>,
) -> Result<(R, String), Error> {
    let mut text = TextBlocks::open(path)?;
    let found = read_all(&mut text, read)?;
    Ok((found, text.finish()?))
}

/// As [`read_text`], for a text of which only a part is wanted, and no digest.
///
/// # Errors
/// As [`TextBlocks::open_to_look`], and those of `look`.
pub fn look_at_text<R>(
    path: &Path,
    look: impl FnOnce(&mut TextBlocks) -> Result<R, Error>,
) -> Result<R, Error> {
    read_all(&mut TextBlocks::open_to_look(path)?, look)
}

fn read_all<R>(
    text: &mut TextBlocks,
    read: impl FnOnce(&mut TextBlocks) -> Result<R, Error>,
) -> Result<R, Error> {
    if text.pending().starts_with(BYTE_ORDER_MARK) {
        text.skip(BYTE_ORDER_MARK.len());
    }
    match read(text) {
        Err(error @ Error::Line { .. }) => Err(text.reason_or(error)),
        found => found,
    }
}

/// Makes something of every block of lines, in file order; `lines_before` of the file are read already.
///
/// # Errors
/// [`Error::Line`] for the first line in file order that `work` refuses, [`Error::NotEnoughMemory`], and as
/// [`read_blocks_in_context`].
pub fn read_line_blocks<T: Default + Send>(
    path: &Path,
    text: &mut TextBlocks,
    lines_before: u64,
    work: impl Fn(&mut Cursor<'_>, &mut T) -> Result<(), Stopped> + Sync,
) -> Result<Vec<LineBlock<T>>, Error> {
    let work = |cursor: &mut Cursor<'_>, (), content: &mut T| work(cursor, content);
    read_line_blocks_in_context(path, text, lines_before, |_| (), work, |_| Ok(()))
}

/// As [`read_line_blocks`]; `look` sees each block before it is worked on, in file order, and tells `work` of what stands before it. `take` may
/// take out what was made of a block, in file order too, while further ones are read.
///
/// # Errors
/// As [`read_line_blocks`], and those of `take`.
pub fn read_line_blocks_in_context<T: Default + Send, C: Send>(
    path: &Path,
    text: &mut TextBlocks,
    lines_before: u64,
    look: impl FnMut(&[u8]) -> C + Send,
    work: impl Fn(&mut Cursor<'_>, C, &mut T) -> Result<(), Stopped> + Sync,
    mut take: impl FnMut(&mut LineBlock<T>) -> Result<(), Error> + Send,
) -> Result<Vec<LineBlock<T>>, Error> {
    let work = |text: &[u8], context: C| {
        let mut cursor = Cursor::new(text);
        let mut block = LineBlock::default();
        block.stopped = work(&mut cursor, context, &mut block.content).err();
        block.line_count = u64::from(cursor.line());
        let end = text.iter().rposition(|&byte| byte == b'\n');
        block.is_open = !text[end.map_or(0, |end| end + 1)..].trim_ascii().is_empty();
        block
    };
    let mut line = lines_before + 1;
    let took = |block: &mut LineBlock<T>, _| {
        block.first_line = line;
        line += block.line_count;
        match block.stopped.take() {
            None => take(block).map(|()| Rest::Wanted),
            Some(Stopped::BadLine { line, message }) => Err(block.refused(path, line, message)),
            Some(Stopped::NoMemory { bytes }) => Err(Error::NotEnoughMemory {
                path: path.into(),
                needed: bytes,
                allowed: None,
            }),
        }
    };
    read_blocks_in_context(text, look, work, took)
}

impl<T> LineBlock<T> {
    /// Refuses a line, 0-based in the block.
    pub fn refused(&self, path: &Path, line: u32, message: impl Into<String>) -> Error {
        Error::Line {
            path: path.into(),
            line: self.first_line + u64::from(line),
            message: message.into(),
        }
    }
}

/// Refuses a text whose last line has no end: where nothing says how many lines there are, that shows that some are missing.
///
/// # Errors
/// [`Error::Line`].
pub fn refuse_open_end<T>(path: &Path, blocks: &[LineBlock<T>]) -> Result<(), Error> {
    match blocks.last() {
        Some(block) if block.is_open => Err(Error::Line {
            path: path.into(),
            line: block.first_line + block.line_count,
            message: "the file ends within this line, as one that is cut off; write it anew, or add a line end if it is whole".into(),
        }),
        _ => Ok(()),
    }
}

/// Room for an entry a line.
///
/// # Errors
/// [`Stopped::NoMemory`].
pub fn room_for_entries(cursor: &Cursor<'_>) -> Result<Entries, Stopped> {
    let count = likely_line_count(cursor.text());
    Entries::with_capacity(count).ok_or(Stopped::NoMemory {
        bytes: Entries::bytes_of(count),
    })
}

/// Lines of the first bytes of a file with something on them, without blanks around; the last one may be cut off. A byte order mark is
/// left out, and CR alone ends a line too.
pub fn filled_lines(start: &[u8]) -> impl Iterator<Item = &[u8]> {
    let start = start.strip_prefix(BYTE_ORDER_MARK).unwrap_or(start);
    let lines = start.split(|&byte| byte == b'\n' || byte == b'\r');
    lines
        .map(<[u8]>::trim_ascii)
        .filter(|line| !line.is_empty())
}
