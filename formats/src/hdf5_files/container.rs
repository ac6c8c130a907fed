//! The HDF5 file underneath: its bytes are read where and when they are needed, and never more of them than the
//! file can have asked for honestly.

use std::collections::HashMap;
use std::fmt;
use std::fs::File;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::sync::{Arc, Mutex, PoisonError};

use hdf5_pure::{FormatError, ReadSeekSource, Source};

/// Bytes that one step may read beyond the file's own length: metadata of a small file is read many times.
pub(crate) const SPARE_BYTES: u64 = 1 << 24;
/// The pages of the file that are kept, 1 MiB in all.
const PAGE_BYTES: u64 = 1 << 12;
const MOST_PAGES: usize = 256;
/// First bytes of the header of every extensible array, an index of chunks, as HDF5 writes them: bits of the number of elements,
/// elements in the index, elements of the smallest block, blocks in the index, bits of the elements of a page.
const EXTENSIBLE_ARRAY: [u8; 5] = [32, 4, 16, 4, 10];
/// Enough for the deepest element type that HDF5 can describe (64 KiB, 8 bytes a level), which the library
/// follows by recursion.
const STACK_BYTES: usize = 1 << 26;

/// An open HDF5 file.
pub struct Container {
    file: hdf5_pure::File,
    source: Shared,
    length: u64,
}

impl fmt::Debug for Container {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Container of {} bytes", self.length)
    }
}

impl Container {
    /// Opens a file whose length is known; `meant` says which program writes the kind of file that was expected.
    ///
    /// # Errors
    /// It isn't HDF5, or not all of it.
    pub fn open(file: File, length: u64, meant: &str) -> Result<Self, String> {
        let told = |error: hdf5_pure::Error| match error {
            hdf5_pure::Error::Format(FormatError::SignatureNotFound) => {
                format!("isn't an HDF5 file; {meant}")
            }
            other => format!("is an HDF5 file that can't be opened: {other}"),
        };
        let source = Shared(Arc::new(MeteredSource {
            bytes: ReadSeekSource::new(file).map_err(|error| told(error.into()))?,
            pages: Mutex::default(),
            allowance: AtomicU64::new(SPARE_BYTES),
        }));
        let file = hdf5_pure::File::from_source(source.clone()).map_err(told)?;
        let end = file.superblock().eof_address;
        if end > length {
            return Err(format!(
                "has {length} bytes, but was written with {end}: it is truncated or damaged"
            ));
        }
        Ok(Self {
            file,
            source,
            length,
        })
    }

    /// The root group.
    pub fn root(&self) -> hdf5_pure::Group {
        self.file.root()
    }

    /// Number of bytes.
    pub fn length(&self) -> u64 {
        self.length
    }

    /// Lets the next step read the whole file once, and a little more. A file whose objects refer to each other in
    /// circles, or to the same bytes again and again, runs out of this.
    pub fn allow_reading(&self) {
        let allowance = self.length.saturating_add(SPARE_BYTES);
        self.source.0.allowance.store(allowance, Relaxed);
    }

    /// Little-endian reals from a place in the file.
    ///
    /// # Errors
    /// They can't be read, or the allowance is used up.
    pub(crate) fn reals_at(&self, offset: u64, count: usize) -> Result<Vec<f64>, String> {
        let mut bytes = vec![0; count * size_of::<f64>()];
        self.source
            .read_at(offset, &mut bytes)
            .map_err(|error| error.to_string())?;
        let (reals, _) = bytes.as_chunks();
        Ok(reals.iter().map(|real| f64::from_le_bytes(*real)).collect())
    }
}

/// Opens a file on a stack that no file can exhaust: an overflow would end the whole program. Should the library
/// panic nevertheless, that is an error here.
///
/// # Errors
/// There is no thread for it, or the library gave up.
pub fn on_large_stack<T: Send>(open: impl FnOnce() -> T + Send) -> std::io::Result<T> {
    std::thread::scope(|scope| {
        std::thread::Builder::new()
            .stack_size(STACK_BYTES)
            .spawn_scoped(scope, open)
            .map_err(|error| {
                let message = format!(
                    "out of memory or threads: it takes a thread with a stack of {} MB ({error}); allow more (ulimit -v, ulimit -u, or \
                     pids.max of a container)",
                    STACK_BYTES >> 20
                );
                std::io::Error::new(std::io::ErrorKind::OutOfMemory, message)
            })?
            .join()
            .map_err(|_| std::io::Error::other("the HDF5 library gave up on this file"))
    })
}

/// Bytes of a file, until the allowance is used up. Small reads are many and close to each other: whole pages of
/// the file are kept for them.
struct MeteredSource {
    bytes: ReadSeekSource<File>,
    pages: Mutex<HashMap<u64, Vec<u8>>>,
    allowance: AtomicU64,
}

/// One source for the HDF5 library and for reading beside it.
#[derive(Clone)]
struct Shared(Arc<MeteredSource>);

impl Source for Shared {
    fn len(&self) -> u64 {
        self.0.len()
    }

    fn read_at(&self, offset: u64, buffer: &mut [u8]) -> Result<(), FormatError> {
        self.0.read_at(offset, buffer)
    }
}

impl MeteredSource {
    fn read_from_pages(&self, offset: u64, buffer: &mut [u8]) -> Result<(), FormatError> {
        let mut pages = self.pages.lock().unwrap_or_else(PoisonError::into_inner);
        let (mut offset, mut buffer) = (offset, buffer);
        while !buffer.is_empty() {
            let start = offset - offset % PAGE_BYTES;
            if !pages.contains_key(&start) {
                if pages.len() >= MOST_PAGES {
                    pages.clear();
                }
                let count = self.len().saturating_sub(start).min(PAGE_BYTES);
                let page = self.bytes.read_exact_at(start, count as usize)?;
                pages.insert(start, page);
            }
            let page = pages
                .get(&start)
                .and_then(|page| page.get((offset - start) as usize..))
                .filter(|rest| !rest.is_empty())
                .ok_or_else(|| FormatError::Source("it ends too early".to_owned()))?;
            let count = page.len().min(buffer.len());
            let (now, later) = buffer.split_at_mut(count);
            now.copy_from_slice(&page[..count]);
            (offset, buffer) = (offset + count as u64, later);
        }
        Ok(())
    }
}

/// From the numbers in an extensible array's header, powers of two, the library takes memory without comparing them
/// with anything.
fn check_extensible_array(bytes: &[u8]) -> Result<(), FormatError> {
    let [b'E', b'A', b'H', b'D', 0, _, _, numbers @ ..] = bytes else {
        return Ok(());
    };
    let mut pairs = numbers.iter().zip(&EXTENSIBLE_ARRAY);
    match pairs.any(|(found, usual)| found > usual) {
        true => Err(FormatError::Source(format!(
            "an extensible array of chunks has the sizes {:?}; HDF5 writes {EXTENSIBLE_ARRAY:?}",
            &numbers[..EXTENSIBLE_ARRAY.len().min(numbers.len())]
        ))),
        false => Ok(()),
    }
}

impl Source for MeteredSource {
    fn len(&self) -> u64 {
        self.bytes.len()
    }

    fn read_at(&self, offset: u64, buffer: &mut [u8]) -> Result<(), FormatError> {
        let count = buffer.len() as u64;
        self.allowance
            .fetch_update(Relaxed, Relaxed, |left| left.checked_sub(count))
            .map_err(|_| {
                FormatError::Source("its parts refer to more than the file can hold".to_owned())
            })?;
        if count < PAGE_BYTES {
            self.read_from_pages(offset, buffer)?;
        } else {
            self.bytes.read_at(offset, buffer)?;
        }
        check_extensible_array(buffer)
    }
}
