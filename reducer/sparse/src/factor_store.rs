//! Where the entries of a factor are kept: in double or single precision, in memory or in a file that is mapped into memory; or by other
//! processes (`crate::ranks`).
//!
//! A mapped file belongs to the system's cache: what doesn't fit the memory is written to the disk and read again when it is
//! needed. The file has no name, so nothing is left of it however the program ends.

use std::fs::File;
use std::marker::PhantomData;
use std::ops::{Deref, DerefMut};
use std::path::{Path, PathBuf};

use memmap2::MmapMut;

use crate::multifrontal::Real;
use crate::{Error, zeros};

/// How many digits of each entry are kept. All arithmetic is in double precision.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Precision {
    /// 8 bytes an entry.
    #[default]
    Double,
    /// 4 bytes an entry; solutions are refined with the matrices themselves (`crate::refinement`).
    Single,
}

/// What holds the entries.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Place {
    /// Memory.
    #[default]
    Memory,
    /// A file without name in a folder.
    Disk {
        /// The folder.
        folder: PathBuf,
    },
    /// Memory of other processes, in double precision.
    #[cfg(feature = "ranks")]
    Ranks(crate::ranks::RanksRun),
}

/// How and where a factor is kept.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FactorStorage {
    /// Precision of the entries.
    pub precision: Precision,
    /// Memory or file that holds them.
    pub place: Place,
}

impl FactorStorage {
    /// Bytes of an entry.
    pub fn entry_bytes(&self) -> usize {
        match self.precision {
            Precision::Double => size_of::<f64>(),
            Precision::Single => size_of::<f32>(),
        }
    }
}

/// The entries of a factor.
pub enum FactorValues {
    /// In double precision.
    Double(Entries<f64>),
    /// Rounded to single precision.
    Single(Entries<f32>),
}

impl FactorValues {
    /// Room for so many entries, zeros.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`], or [`Error::File`] if the folder can't hold them.
    pub fn zeros(storage: &FactorStorage, length: usize) -> Result<Self, Error> {
        Ok(match storage.precision {
            Precision::Double => Self::Double(Entries::zeros(&storage.place, length)?),
            Precision::Single => Self::Single(Entries::zeros(&storage.place, length)?),
        })
    }
}

/// Entries in memory or in a mapped file.
pub enum Entries<T> {
    /// In memory.
    Memory(Vec<T>),
    /// In a file.
    Mapped(MappedEntries<T>),
}

impl<T: Real> Entries<T> {
    fn zeros(place: &Place, length: usize) -> Result<Self, Error> {
        match place {
            Place::Memory => zeros_in_memory(length).map(Self::Memory),
            Place::Disk { folder } => MappedEntries::zeros(folder, length).map(Self::Mapped),
            // The ranks make room for themselves.
            #[cfg(feature = "ranks")]
            Place::Ranks(_) => zeros_in_memory(0).map(Self::Memory),
        }
    }
}

impl<T: Real> Deref for Entries<T> {
    type Target = [T];

    fn deref(&self) -> &[T] {
        match self {
            Self::Memory(values) => values,
            Self::Mapped(values) => pulp::bytemuck::cast_slice(&values.map[..values.bytes]),
        }
    }
}

impl<T: Real> DerefMut for Entries<T> {
    fn deref_mut(&mut self) -> &mut [T] {
        match self {
            Self::Memory(values) => values,
            Self::Mapped(values) => pulp::bytemuck::cast_slice_mut(&mut values.map[..values.bytes]),
        }
    }
}

fn zeros_in_memory<T: Real>(length: usize) -> Result<Vec<T>, Error> {
    // Asked for first, because a failing `vec!` ends the program.
    let mut values: Vec<T> = Vec::new();
    values
        .try_reserve_exact(length)
        .map_err(|_| Error::OutOfMemory { what: "the factor" })?;
    zeros::extend(&mut values, length);
    Ok(values)
}

/// Entries in a file without name that is mapped into memory.
pub struct MappedEntries<T> {
    map: MmapMut,
    bytes: usize,
    entries: PhantomData<T>,
}

impl<T: Real> MappedEntries<T> {
    /// # Errors
    /// [`Error::File`] if the folder can't hold so many entries.
    fn zeros(folder: &Path, length: usize) -> Result<Self, Error> {
        let bytes = length
            .checked_mul(size_of::<T>())
            .filter(|bytes| i64::try_from(*bytes).is_ok())
            .ok_or(Error::OutOfMemory { what: "the factor" })?;
        let refused = |source: std::io::Error| {
            Error::File(dcb_formats::Error::File {
                path: folder.to_path_buf(),
                message: format!(
                    "cannot keep the factor here, which needs {:.1} MB: {source}; make room or name another folder with --scratch",
                    bytes as f64 / 1e6
                ),
            })
        };
        let file = tempfile::tempfile_in(folder).map_err(refused)?;
        // A mapping of nothing is refused.
        reserve(&file, bytes.max(1) as u64).map_err(refused)?;
        // SAFETY: the file has no name and its room is reserved: nobody else changes or shortens it.
        let map = unsafe { MmapMut::map_mut(&file) }.map_err(refused)?;
        Ok(Self {
            map,
            bytes,
            entries: PhantomData,
        })
    }
}

/// Makes a file so long and claims the disk's room for it: a disk that runs full later would end the program without a word.
fn reserve(file: &File, bytes: u64) -> std::io::Result<()> {
    #[cfg(target_os = "linux")]
    {
        use std::os::fd::AsRawFd;
        let length = libc::off_t::try_from(bytes)
            .map_err(|_| std::io::Error::from_raw_os_error(libc::EFBIG))?;
        // SAFETY: an open file and plain numbers.
        match unsafe { libc::posix_fallocate(file.as_raw_fd(), 0, length) } {
            0 => return Ok(()),
            // The file system can't; zeros claim the room as well.
            libc::EOPNOTSUPP | libc::EINVAL => {}
            code => return Err(std::io::Error::from_raw_os_error(code)),
        }
    }
    write_zeros(file, bytes)
}

fn write_zeros(mut file: &File, bytes: u64) -> std::io::Result<()> {
    use std::io::Write;
    const CHUNK: usize = 1 << 20;
    let zeros = vec![0_u8; CHUNK];
    let mut left = bytes;
    while left > 0 {
        let now = left.min(CHUNK as u64);
        file.write_all(&zeros[..now as usize])?;
        left -= now;
    }
    file.flush()
}
