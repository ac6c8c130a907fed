//! The text of a matrix file in blocks of whole lines, read once, hashed as it is on disk and decompressed on the way.

use std::io::{BufReader, Chain, Cursor, ErrorKind, Read};
use std::path::{Path, PathBuf};

use flate2::bufread::MultiGzDecoder;
use memchr::{memchr_iter, memrchr};

use crate::Error;
use crate::snapshot::{Snapshot, cannot_read};

const GZIP_MAGIC: &[u8] = &[0x1f, 0x8b];
/// Bytes of a block, which a processor's cache holds; no line is longer.
pub(super) const BLOCK: usize = 1 << 18;
/// Bytes behind a file's end for which there is room.
const END_ROOM: usize = 1 << 12;
/// Compressed bytes that are read together.
const PACKED_BLOCK: usize = 1 << 16;
/// Text that is looked at for damage behind a bad line.
const LOOKED_THROUGH: u64 = 1 << 30;

/// What is wrong with a text without line feeds, and what helps.
pub const CR_ALONE: &str =
    "lines end in CR alone, as on old Macintoshes; save the file with LF line ends";

/// Bytes that are kept of a last line without an end.
const LONGEST_SHOWN: usize = 256;

/// The text of a matrix file.
pub struct TextBlocks {
    path: PathBuf,
    source: TextSource,
    /// Read, but not given out.
    pending: Vec<u8>,
    is_at_end: bool,
    /// Bytes of text so far.
    length: u64,
    /// Lines that may still be given out; `None` for all.
    lines_left: Option<u64>,
    /// What stands behind the last line end, once all is given out.
    open_end: Vec<u8>,
}

/// A file of which the first bytes, looked at already, come again.
type PutBack = Chain<Cursor<Vec<u8>>, BufReader<Snapshot>>;

enum TextSource {
    Plain(Snapshot),
    Gzip(Box<MultiGzDecoder<PutBack>>),
}

impl TextSource {
    fn snapshot(&self) -> &Snapshot {
        match self {
            Self::Plain(file) => file,
            Self::Gzip(decoder) => decoder.get_ref().get_ref().1.get_ref(),
        }
    }
}

impl TextBlocks {
    /// Opens a file. gzip is known by its first bytes, whatever the file's name; every member is read.
    ///
    /// # Errors
    /// As [`Snapshot::open`], and what [`TextBlocks::next_block`] says.
    pub fn open(path: &Path) -> Result<Self, Error> {
        Self::of(path, Snapshot::open(path)?)
    }

    /// As [`TextBlocks::open`], to look at the text: it has no digest.
    ///
    /// # Errors
    /// As [`TextBlocks::open`].
    pub fn open_to_look(path: &Path) -> Result<Self, Error> {
        Self::of(path, Snapshot::open_to_look(path)?)
    }

    fn of(path: &Path, mut file: Snapshot) -> Result<Self, Error> {
        let mut start = Vec::new();
        (&mut file)
            .take(PACKED_BLOCK as u64)
            .read_to_end(&mut start)
            .map_err(|source| cannot_read(path, source))?;
        let (source, pending) = if start.starts_with(GZIP_MAGIC) {
            let packed = Cursor::new(start).chain(BufReader::with_capacity(PACKED_BLOCK, file));
            let decoder = MultiGzDecoder::new(packed);
            (TextSource::Gzip(Box::new(decoder)), Vec::new())
        } else {
            (TextSource::Plain(file), start)
        };
        let mut blocks = Self {
            path: path.into(),
            source,
            length: pending.len() as u64,
            pending,
            is_at_end: false,
            lines_left: None,
            open_end: Vec::new(),
        };
        blocks.fill_to(blocks.room_for_block())?;
        Ok(blocks)
    }

    /// The text that isn't given out yet, as far as it is read.
    pub fn pending(&self) -> &[u8] {
        &self.pending
    }

    /// Whether nothing comes after what is pending.
    pub fn is_at_end(&self) -> bool {
        self.is_at_end
    }

    /// Bytes of text of the whole file; of a pipe or gzipped file they are known at the end.
    pub fn text_length(&self) -> Option<u64> {
        match &self.source {
            _ if self.is_at_end => Some(self.length),
            TextSource::Plain(file) => file.length(),
            TextSource::Gzip(_) => None,
        }
    }

    /// Bytes of text so far.
    pub fn length(&self) -> u64 {
        self.length
    }

    /// A last line without an end, once all is given out: where something follows its last character, the file is cut off.
    pub fn open_end(&self) -> &[u8] {
        self.open_end.trim_ascii()
    }

    /// Gives out so many bytes of what is pending.
    pub fn skip(&mut self, count: usize) {
        self.pending.drain(..count);
    }

    /// Reads until so many bytes are pending or the text ends.
    ///
    /// # Errors
    /// [`Error::Io`] if the file can't be read, [`Error::File`] for damaged or cut off gzip data.
    pub fn fill_to(&mut self, wanted: usize) -> Result<(), Error> {
        let mut pending = std::mem::take(&mut self.pending);
        let before = pending.len();
        if before < wanted {
            pending.resize(wanted, 0);
            let count = self.read_into(&mut pending[before..])?;
            pending.truncate(before + count);
        }
        self.pending = pending;
        Ok(())
    }

    /// Reads as much as there is room for or left.
    fn read_into(&mut self, room: &mut [u8]) -> Result<usize, Error> {
        let mut at = 0;
        while at < room.len() && !self.is_at_end {
            let read = match &mut self.source {
                TextSource::Plain(file) => file.read(&mut room[at..]),
                TextSource::Gzip(decoder) => decoder.read(&mut room[at..]),
            };
            match read {
                Ok(0) => self.is_at_end = true,
                Ok(count) => {
                    at += count;
                    self.length += count as u64;
                }
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => return Err(self.unreadable(error)),
            }
        }
        Ok(at)
    }

    fn unreadable(&self, source: std::io::Error) -> Error {
        match &self.source {
            _ if self.source.snapshot().is_changed() => self.source.snapshot().changed(),
            TextSource::Gzip(_)
                if matches!(
                    source.kind(),
                    ErrorKind::InvalidInput | ErrorKind::InvalidData | ErrorKind::UnexpectedEof
                ) =>
            {
                let decompressed = self.length;
                Error::File {
                    path: self.path.clone(),
                    message: format!(
                        "gzip data damaged or cut off after {decompressed} decompressed bytes: {source}"
                    ),
                }
            }
            _ => cannot_read(&self.path, source),
        }
    }

    /// Lets the text seem to end after so many further lines; `None` takes that back.
    pub fn end_after_lines(&mut self, count: Option<u64>) {
        self.lines_left = count;
    }

    /// Puts the next whole lines into the front of a buffer, as many as a block has, and tells how many bytes they are; 0 at the end.
    ///
    /// # Errors
    /// As [`TextBlocks::fill_to`], and [`Error::File`] for a line that is longer than a block.
    pub fn next_block(&mut self, buffer: &mut Vec<u8>) -> Result<usize, Error> {
        match self.lines_left {
            None => self.whole_block(buffer),
            Some(0) => Ok(0),
            Some(left) => {
                let used = self.whole_block(buffer)?;
                Ok(self.cut_after_lines(left, &buffer[..used]))
            }
        }
    }

    /// Puts back what comes behind so many lines; the bytes that are left.
    fn cut_after_lines(&mut self, left: u64, block: &[u8]) -> usize {
        let count = memchr_iter(b'\n', block).count() as u64;
        self.lines_left = Some(left.saturating_sub(count));
        if count <= left {
            return block.len();
        }
        let last = memchr_iter(b'\n', block).nth(left as usize - 1);
        let last = last.unwrap_or(block.len() - 1);
        self.pending.splice(0..0, block[last + 1..].iter().copied());
        last + 1
    }

    /// Bytes of a block: fewer where the file is known to have no more, and some to see its end, or that it grows.
    fn room_for_block(&self) -> usize {
        let length = self.text_length().unwrap_or(u64::MAX);
        let left = length.saturating_sub(self.length) as usize;
        left.saturating_add(self.pending.len() + END_ROOM)
            .min(BLOCK)
    }

    fn whole_block(&mut self, buffer: &mut Vec<u8>) -> Result<usize, Error> {
        // A buffer that was used before isn't cleared.
        buffer.resize(self.room_for_block(), 0);
        let carried = self.pending.len().min(buffer.len());
        buffer[..carried].copy_from_slice(&self.pending[..carried]);
        self.pending.drain(..carried);
        let used = carried + self.read_into(&mut buffer[carried..])?;
        if self.is_at_end && self.pending.is_empty() {
            let end = memrchr(b'\n', &buffer[..used]);
            let open = &buffer[end.map_or(0, |end| end + 1)..used];
            if used > 0 {
                self.open_end = open[..open.len().min(LONGEST_SHOWN)].to_vec();
            }
            return Ok(used);
        }
        let Some(last) = memrchr(b'\n', &buffer[..used]) else {
            return Err(Error::File {
                path: self.path.clone(),
                message: match buffer[..used].contains(&b'\r') {
                    true => CR_ALONE.into(),
                    false => {
                        format!("has a line of more than {BLOCK} bytes; expected one entry a line")
                    }
                },
            });
        };
        self.pending
            .splice(0..0, buffer[last + 1..used].iter().copied());
        Ok(last + 1)
    }

    /// Says what is wrong with the file as a whole, which may be why its text can't be used: that it was changed, or gzip data
    /// that turn out to be damaged.
    pub fn reason_or(&mut self, found: Error) -> Error {
        if let TextSource::Gzip(decoder) = &mut self.source {
            let mut rest = decoder.take(LOOKED_THROUGH);
            let mut buffer = vec![0; BLOCK];
            loop {
                match rest.read(&mut buffer) {
                    Ok(0) => break,
                    Ok(count) => self.length += count as u64,
                    Err(error) if error.kind() == ErrorKind::Interrupted => {}
                    Err(error) => return self.unreadable(error),
                }
            }
        }
        let file = self.source.snapshot();
        if file.is_changed() {
            return file.changed();
        }
        found
    }

    /// SHA-256 of the file as it is on disk, once all its text was given out.
    ///
    /// # Errors
    /// As [`Snapshot::finish`].
    pub fn finish(self) -> Result<String, Error> {
        match self.source {
            TextSource::Plain(file) => file.finish(),
            TextSource::Gzip(decoder) => decoder.into_inner().into_inner().1.into_inner().finish(),
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn lines_behind_an_end_come_when_it_is_taken_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("lines");
        let lines: Vec<String> = (0..90_000).map(|number| format!("{number}\n")).collect();
        std::fs::write(&path, lines.concat()).unwrap();
        let mut text = TextBlocks::open(&path).unwrap();
        let mut next = |count: Option<u64>| {
            text.end_after_lines(count);
            let (mut all, mut buffer) = (Vec::new(), Vec::new());
            loop {
                match text.next_block(&mut buffer).unwrap() {
                    0 => break String::from_utf8(all).unwrap(),
                    used => all.extend_from_slice(&buffer[..used]),
                }
            }
        };
        assert_eq!(next(Some(1)), "0\n");
        assert_eq!(next(Some(0)), "");
        assert_eq!(next(Some(80_000)), lines[1..80_001].concat());
        assert_eq!(next(Some(2)), lines[80_001..80_003].concat());
        assert_eq!(next(None), lines[80_003..].concat());
    }
}
