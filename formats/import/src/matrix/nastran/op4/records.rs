//! Fortran's unformatted records: each stands between two copies of its length in bytes, which are 32-bit integers. Integers in them have
//! 32 or 64 bits.

use std::path::Path;

use dcb_formats::Error;

use crate::binary::file::{BinaryFile, ByteOrder};

/// Bytes that are read together, which a processor's cache holds.
const BATCH: usize = 1 << 16;
/// Bytes that are read together after some were left out: most of what follows may be left out too.
const SMALL_BATCH: usize = 1 << 10;

/// Bytes of an integer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Word {
    /// Four.
    Short,
    /// Eight.
    Long,
}

impl Word {
    pub(super) fn bytes(self) -> u64 {
        match self {
            Self::Short => 4,
            Self::Long => 8,
        }
    }
}

/// Bytes of a real.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Precision {
    /// Four.
    Single,
    /// Eight.
    Double,
}

/// Records, one after the other.
pub(super) struct Records {
    file: BinaryFile,
    order: ByteOrder,
    word: Word,
    buffer: Vec<u8>,
    /// Bytes of the buffer that were given out.
    used: usize,
    batch: usize,
    /// Bytes of this record, and those that are left of it.
    length: u64,
    left: u64,
}

impl Records {
    /// Opens a file; its byte order and the size of its integers must be known.
    pub(super) fn open(path: &Path, order: ByteOrder, word: Word) -> Result<Self, Error> {
        Ok(Self {
            file: BinaryFile::open_parts(path)?,
            order,
            word,
            buffer: Vec::new(),
            used: 0,
            batch: SMALL_BATCH,
            length: 0,
            left: 0,
        })
    }

    pub(super) fn word(&self) -> Word {
        self.word
    }

    /// Whether no record follows.
    pub(super) fn is_at_end(&self) -> bool {
        self.remaining() == 0
    }

    /// Bytes that are left of the record.
    pub(super) fn left(&self) -> u64 {
        self.left
    }

    /// Bytes that are left of the file.
    fn remaining(&self) -> u64 {
        self.file.remaining() + self.buffered() as u64
    }

    fn buffered(&self) -> usize {
        self.buffer.len() - self.used
    }

    /// An error at the place that was reached.
    pub(super) fn refused(&self, message: impl Into<String>) -> Error {
        let at = self.file.position() - self.buffered() as u64;
        self.file.refused_at(at, message)
    }

    /// Reads so many bytes ahead, or more.
    #[inline(always)]
    fn read_ahead(&mut self, count: usize) -> Result<(), Error> {
        match self.buffered() >= count {
            true => Ok(()),
            false => self.read_batch(count),
        }
    }

    #[cold]
    fn read_batch(&mut self, count: usize) -> Result<(), Error> {
        if count as u64 > self.remaining() {
            return Err(self.refused("the file ends within a record; it is cut off"));
        }
        self.buffer.drain(..self.used);
        self.used = 0;
        let before = self.buffer.len();
        let most = usize::try_from(self.file.remaining()).unwrap_or(usize::MAX);
        self.buffer
            .resize(self.batch.max(count).min(before.saturating_add(most)), 0);
        self.batch = (2 * self.batch).min(BATCH);
        self.file.fill(&mut self.buffer[before..])
    }

    #[inline(always)]
    fn bytes<const N: usize>(&mut self) -> Result<[u8; N], Error> {
        self.read_ahead(N)?;
        let bytes = match self.buffer[self.used..].first_chunk::<N>() {
            Some(bytes) => *bytes,
            None => return Err(self.refused("the file ends within a record; it is cut off")),
        };
        self.used += N;
        Ok(bytes)
    }

    fn length(&mut self) -> Result<u32, Error> {
        let bytes = self.bytes()?;
        Ok(match self.order {
            ByteOrder::Little => u32::from_le_bytes(bytes),
            ByteOrder::Big => u32::from_be_bytes(bytes),
        })
    }

    /// Begins the next record and tells its length.
    pub(super) fn begin(&mut self) -> Result<u64, Error> {
        let length = self.length()?;
        let room = self.remaining().saturating_sub(4);
        if u64::from(length) > room {
            let other = u64::from(length.swap_bytes());
            return Err(match other <= room {
                true => self.refused(
                    "the byte order changes here; the file was put together on different machines, write it anew on one",
                ),
                false => self.refused(format!(
                    "a record of {length} bytes is announced, but {room} are left; the file is cut off or damaged"
                )),
            });
        }
        self.length = u64::from(length);
        self.left = self.length;
        Ok(self.length)
    }

    /// Passes what is left of the record, and compares its length at both ends.
    pub(super) fn end(&mut self) -> Result<(), Error> {
        self.pass(self.left)?;
        let length = u64::from(self.length()?);
        match length == self.length {
            true => Ok(()),
            false => Err(self.refused(format!(
                "a record of {} bytes ends with the length {length}; the file is damaged, or was sent as text",
                self.length
            ))),
        }
    }

    /// Leaves bytes of the record out without reading them.
    fn pass(&mut self, count: u64) -> Result<(), Error> {
        self.take_from_record(count)?;
        let here = self.buffered() as u64;
        if count <= here {
            self.used += count as usize;
            return Ok(());
        }
        self.used = self.buffer.len();
        self.batch = SMALL_BATCH;
        self.file.pass_over(count - here)
    }

    fn take_from_record(&mut self, count: u64) -> Result<(), Error> {
        match self.left.checked_sub(count) {
            Some(left) => {
                self.left = left;
                Ok(())
            }
            None => Err(self.refused(format!(
                "a record of {} bytes is too short for what it should hold; the file is damaged",
                self.length
            ))),
        }
    }

    /// The next integer of the record.
    pub(super) fn integer(&mut self) -> Result<i64, Error> {
        self.take_from_record(self.word.bytes())?;
        Ok(match (self.word, self.order) {
            (Word::Short, ByteOrder::Little) => i32::from_le_bytes(self.bytes()?).into(),
            (Word::Short, ByteOrder::Big) => i32::from_be_bytes(self.bytes()?).into(),
            (Word::Long, ByteOrder::Little) => i64::from_le_bytes(self.bytes()?),
            (Word::Long, ByteOrder::Big) => i64::from_be_bytes(self.bytes()?),
        })
    }

    /// The next eight bytes of the record.
    pub(super) fn text(&mut self) -> Result<[u8; 8], Error> {
        self.take_from_record(8)?;
        self.bytes()
    }

    /// Gives out the next reals of the record.
    pub(super) fn reals(
        &mut self,
        precision: Precision,
        count: u64,
        take: impl FnMut(f64) -> Result<(), String>,
    ) -> Result<(), Error> {
        match (precision, self.order) {
            (Precision::Single, ByteOrder::Little) => {
                self.each(count, |bytes| f32::from_le_bytes(bytes).into(), take)
            }
            (Precision::Single, ByteOrder::Big) => {
                self.each(count, |bytes| f32::from_be_bytes(bytes).into(), take)
            }
            (Precision::Double, ByteOrder::Little) => self.each(count, f64::from_le_bytes, take),
            (Precision::Double, ByteOrder::Big) => self.each(count, f64::from_be_bytes, take),
        }
    }

    #[inline(always)]
    fn each<const N: usize>(
        &mut self,
        count: u64,
        of: impl Fn([u8; N]) -> f64,
        mut take: impl FnMut(f64) -> Result<(), String>,
    ) -> Result<(), Error> {
        self.take_from_record(count.saturating_mul(N as u64))?;
        let mut rest = count;
        while rest > 0 {
            self.read_ahead(N)?;
            let (numbers, _) = self.buffer[self.used..].as_chunks::<N>();
            let part = numbers
                .len()
                .min(usize::try_from(rest).unwrap_or(usize::MAX));
            for (before, bytes) in numbers[..part].iter().enumerate() {
                if let Err(message) = take(of(*bytes)) {
                    self.used += N * before;
                    return Err(self.refused(message));
                }
            }
            self.used += N * part;
            rest -= part as u64;
        }
        Ok(())
    }
}
