//! Numbers that come one after the other from a file or out of its compressed parts. Memory grows as they come, never from a count
//! that is only claimed.

use dcb_formats::Error;

use crate::binary::file::BinaryFile;
use crate::matrix::storage::number::{Number, Unusable};

/// Bytes that are turned into numbers at a time, which a processor's cache holds.
const BATCH: usize = 1 << 16;

/// Bytes one after the other.
pub(crate) trait Stream {
    /// Fills a buffer with the next bytes.
    ///
    /// # Errors
    /// There are fewer, or they can't be read.
    fn fill(&mut self, buffer: &mut [u8]) -> Result<(), Error>;

    /// Bytes that the file holds for what is left; more can come only where they are compressed.
    fn held(&self) -> u64;

    /// An error at this place of the file.
    fn refused(&self, message: String) -> Error;
}

impl Stream for BinaryFile {
    fn fill(&mut self, buffer: &mut [u8]) -> Result<(), Error> {
        self.fill(buffer)
    }

    fn held(&self) -> u64 {
        self.remaining()
    }

    fn refused(&self, message: String) -> Error {
        Self::refused(self, message)
    }
}

/// A number that was refused by its place among all of them.
fn place_of(first: u64, refused: Unusable) -> String {
    let at = first + refused.at as u64;
    format!("number {} of the array: {}", at + 1, refused.message)
}

/// Gives out the bytes of so many numbers in batches, with the place of the first of each.
///
/// # Errors
/// Those of the stream, and of `take` as errors at this place.
pub(crate) fn each_batch(
    stream: &mut (impl Stream + ?Sized),
    number: Number,
    count: u64,
    mut take: impl FnMut(u64, &[u8]) -> Result<(), String>,
) -> Result<(), Error> {
    let each = number.size() as u64;
    let at_once = BATCH as u64 / each;
    let mut buffer = vec![0; (at_once.min(count) * each) as usize];
    let mut done = 0;
    while done < count {
        let part = &mut buffer[..(at_once.min(count - done) * each) as usize];
        stream.fill(part)?;
        take(done, part).map_err(|message| stream.refused(message))?;
        done += part.len() as u64 / each;
    }
    Ok(())
}

/// Room for so many numbers, as far as the file can hold them.
fn room<T>(stream: &(impl Stream + ?Sized), number: Number, count: u64) -> Vec<T> {
    let sure = count.min(stream.held() / number.size() as u64);
    Vec::with_capacity(usize::try_from(sure).unwrap_or(0))
}

/// So many indices; what can't be one is the largest of all.
pub(crate) fn indices(
    stream: &mut (impl Stream + ?Sized),
    number: Number,
    count: u64,
) -> Result<Vec<u32>, Error> {
    let mut found = room(stream, number, count);
    each_batch(stream, number, count, |_, bytes| {
        number.indices(bytes, &mut found);
        Ok(())
    })?;
    Ok(found)
}

/// So many integers.
pub(crate) fn integers(
    stream: &mut (impl Stream + ?Sized),
    number: Number,
    count: u64,
) -> Result<Vec<i64>, Error> {
    let mut found = room(stream, number, count);
    each_batch(stream, number, count, |first, bytes| {
        let read = number.integers(bytes, &mut found);
        read.map_err(|refused| place_of(first, refused))
    })?;
    Ok(found)
}

/// Gives out so many reals in batches, with the place of the first of each.
pub(crate) fn each_reals(
    stream: &mut (impl Stream + ?Sized),
    number: Number,
    count: u64,
    mut take: impl FnMut(u64, &[f64]) -> Result<(), String>,
) -> Result<(), Error> {
    let mut batch = Vec::new();
    each_batch(stream, number, count, |first, bytes| {
        batch.clear();
        let read = number.reals(bytes, &mut batch);
        read.map_err(|refused| place_of(first, refused))?;
        take(first, &batch)
    })
}
