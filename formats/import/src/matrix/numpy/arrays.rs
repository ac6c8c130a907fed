//! The arrays of a NumPy archive (`.npz`, a zip archive), or the one of a file of its own (`.npy`).

use std::fs::File;
use std::io::{BufReader, ErrorKind, Read};
use std::path::{Path, PathBuf};

use dcb_formats::Error;
use dcb_formats::terminal::shortened;
use zip::result::ZipError;
use zip::{CompressionMethod, ZipArchive};

use super::header::{Element, Header};
use crate::binary::file::{BinaryFile, regular};
use crate::matrix::storage::number::{Kind, Number};
use crate::matrix::storage::stream::{Stream, integers};

/// Members of an archive, at most.
const MOST_MEMBERS: usize = 10_000;
/// Deflate can't do better than 1:1032.
const LARGEST_DEFLATE_RATIO: u64 = 1032;
/// Letters and numbers that are read of a small array, such as the shape of a matrix.
const SMALL: u64 = 64;
/// Bytes that are read together.
const READ_TOGETHER: usize = 1 << 16;

/// An array.
#[derive(Clone, Debug)]
pub(super) struct Array {
    /// Empty for that of a file of its own.
    pub(super) name: String,
    pub(super) header: Header,
    /// Number of the member.
    member: usize,
}

/// All arrays of a file.
pub(super) struct Arrays {
    path: PathBuf,
    is_archive: bool,
    pub(super) list: Vec<Array>,
}

/// Opens an archive anew, so that several members can be read side by side.
fn open(path: &Path) -> Result<ZipArchive<BufReader<File>>, Error> {
    regular(path)?;
    let file = File::open(path).map_err(|source| Error::io(path, "cannot read", source))?;
    let reader = BufReader::with_capacity(READ_TOGETHER, file);
    ZipArchive::new(reader).map_err(|error| unreadable(path, error))
}

fn unreadable(path: &Path, error: ZipError) -> Error {
    match error {
        ZipError::Io(source) if source.raw_os_error().is_some() => {
            Error::io(path, "cannot read", source)
        }
        other => Error::File {
            path: path.into(),
            message: format!("is a zip archive that is damaged or cut off: {other}"),
        },
    }
}

impl Arrays {
    /// Looks at the headers of all arrays. Pickled ones are refused before anything else is read.
    pub(super) fn of(path: &Path, is_archive: bool) -> Result<Self, Error> {
        let mut arrays = Self {
            path: path.into(),
            is_archive,
            list: Vec::new(),
        };
        match is_archive {
            true => arrays.look_through()?,
            false => {
                let mut file = BinaryFile::open_parts(path)?;
                let length = file.remaining();
                let header = Header::read(&mut file)?;
                arrays.add("", 0, header, length)?;
            }
        }
        Ok(arrays)
    }

    /// Whether the arrays have names.
    pub(super) fn is_archive(&self) -> bool {
        self.is_archive
    }

    /// An error of an array.
    pub(super) fn refused(&self, name: &str, message: impl Into<String>) -> Error {
        refused(&self.path, name, message.into())
    }

    fn look_through(&mut self) -> Result<(), Error> {
        let path = self.path.clone();
        let mut archive = open(&path)?;
        let file = |message: String| Error::File {
            path: path.clone(),
            message,
        };
        if archive.len() > MOST_MEMBERS {
            return Err(file(format!(
                "has {} members; at most {MOST_MEMBERS} are supported",
                archive.len()
            )));
        }
        let overlaps = archive
            .has_overlapping_entries()
            .map_err(|error| unreadable(&path, error))?;
        if overlaps || archive.has_duplicate_names() {
            return Err(file(
                "has members of the same name or the same bytes; the archive is damaged".into(),
            ));
        }
        for number in 0..archive.len() {
            let member = archive
                .by_index_data(number)
                .map_err(|error| unreadable(&path, error))?;
            let name = member.name().map_err(|error| unreadable(&path, error))?;
            let Some(name) = name.strip_suffix(".npy").map(str::to_owned) else {
                continue;
            };
            let (packed, size) = (member.compressed_size(), member.size());
            let possible = match member.compression() {
                _ if member.encrypted() => {
                    return Err(self.refused(&name, "is encrypted; save it without a password"));
                }
                CompressionMethod::Stored => packed,
                CompressionMethod::Deflated => packed.saturating_mul(LARGEST_DEFLATE_RATIO),
                other => {
                    return Err(self.refused(
                        &name,
                        format!("is compressed with {other}; NumPy writes deflate (np.savez_compressed) or nothing (np.savez)"),
                    ));
                }
            };
            if size > possible {
                return Err(self.refused(
                    &name,
                    format!("should have {size} bytes, which {packed} in the archive can't hold; the archive is damaged"),
                ));
            }
            let mut member = Member::of(&path, &name, &mut archive, number)?;
            let header = Header::read(&mut member)?;
            self.add(&name, number, header, size)?;
        }
        Ok(())
    }

    /// Adds an array whose file has so many bytes.
    fn add(&mut self, name: &str, member: usize, header: Header, bytes: u64) -> Result<(), Error> {
        if header.element == Element::Object {
            return Err(self.pickled(name, &header));
        }
        let needed = header.file_bytes();
        let fits = match header.element {
            Element::Number(_) | Element::Text { .. } => needed == Some(bytes),
            _ => true,
        };
        if !fits {
            return Err(self.refused(
                name,
                format!(
                    "of shape {:?} doesn't fit its {bytes} bytes, of which the header has {}; the file is cut off or damaged",
                    header.shape, header.length
                ),
            ));
        }
        self.list.push(Array {
            name: name.into(),
            header,
            member,
        });
        Ok(())
    }

    fn pickled(&self, name: &str, header: &Header) -> Error {
        let remedy = match header.shape[..] {
            [] => {
                "np.savez pickles SciPy matrices; save each with `scipy.sparse.save_npz(\"K.npz\", K)` and a table of dofs with \
                 `np.save(\"dof_ref.npy\", dof_ref)`"
            }
            _ => {
                "leave it out, or give its elements a type of their own, as `.astype(str)` does for names"
            }
        };
        self.refused(
            name,
            format!("is a pickled Python object, which is never read; {remedy}"),
        )
    }

    /// An array by its name.
    pub(super) fn named(&self, name: &str) -> Option<usize> {
        self.list.iter().position(|array| array.name == name)
    }

    /// Does something with the data of an array; afterwards the member is read to its end, where its checksum is.
    pub(super) fn with_data<T>(
        &self,
        array: usize,
        work: impl FnOnce(&mut dyn Stream) -> Result<T, Error>,
    ) -> Result<T, Error> {
        let array = &self.list[array];
        if !self.is_archive {
            let mut file = BinaryFile::open_parts(&self.path)?;
            file.pass_over(array.header.length)?;
            return work(&mut file);
        }
        let mut archive = open(&self.path)?;
        let mut member = Member::of(&self.path, &array.name, &mut archive, array.member)?;
        member.fill(&mut vec![0; array.header.length as usize])?;
        let done = work(&mut member)?;
        member.finish()?;
        Ok(done)
    }

    /// The integers of a small array.
    pub(super) fn small_integers(&self, array: usize) -> Result<Vec<i64>, Error> {
        let header = &self.list[array].header;
        let (Some(number), Some(count @ 0..=SMALL)) = (header.number(), header.count()) else {
            return Err(self.refused(&self.list[array].name, "should have a few integers"));
        };
        self.with_data(array, |stream| integers(stream, number, count))
    }

    /// The letters of an array with one word.
    pub(super) fn word(&self, array: usize) -> Result<String, Error> {
        let Array { name, header, .. } = &self.list[array];
        let (
            Element::Text {
                letters: letters @ 0..=SMALL,
                bytes_each,
                order,
            },
            Some(1),
        ) = (&header.element, header.count())
        else {
            return Err(self.refused(name, "should be one short word"));
        };
        let kind = match bytes_each {
            1 => Kind::U8,
            _ => Kind::U32,
        };
        let number = Number {
            kind,
            order: *order,
        };
        let codes = self.with_data(array, |stream| integers(stream, number, *letters))?;
        let letters = codes
            .iter()
            .map(|code| u32::try_from(*code).ok().and_then(char::from_u32));
        let word: Option<String> = letters.collect();
        Ok(word.unwrap_or_default().trim_end_matches('\0').to_owned())
    }
}

fn refused(path: &Path, name: &str, message: String) -> Error {
    match name {
        "" => Error::File {
            path: path.into(),
            message: format!("the array {message}"),
        },
        _ => Error::Location {
            path: path.into(),
            location: shortened(name),
            message,
        },
    }
}

/// The bytes of a member while they are read.
struct Member<'a> {
    path: &'a Path,
    name: &'a str,
    file: zip::read::ZipFile<'a, BufReader<File>>,
    /// Bytes in the archive, at most those that are left.
    held: u64,
}

impl<'a> Member<'a> {
    fn of(
        path: &'a Path,
        name: &'a str,
        archive: &'a mut ZipArchive<BufReader<File>>,
        number: usize,
    ) -> Result<Self, Error> {
        let file = archive
            .by_index(number)
            .map_err(|error| unreadable(path, error))?;
        Ok(Self {
            path,
            name,
            held: file.compressed_size(),
            file,
        })
    }

    fn unreadable(&self, error: std::io::Error) -> Error {
        match error.kind() {
            _ if error.raw_os_error().is_some() => Error::io(self.path, "cannot read", error),
            ErrorKind::UnexpectedEof => {
                self.refused("ends too early; the archive is cut off or damaged".into())
            }
            _ => self.refused(format!(
                "can't be decompressed: {error}; the archive is damaged"
            )),
        }
    }

    fn finish(mut self) -> Result<(), Error> {
        let mut rest = [0; 1 << 12];
        loop {
            match self.file.read(&mut rest) {
                Ok(0) => return Ok(()),
                Ok(_) => {}
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => return Err(self.unreadable(error)),
            }
        }
    }
}

impl Stream for Member<'_> {
    fn fill(&mut self, buffer: &mut [u8]) -> Result<(), Error> {
        let filled = self.file.read_exact(buffer);
        filled.map_err(|error| self.unreadable(error))
    }

    fn held(&self) -> u64 {
        self.held
    }

    fn refused(&self, message: String) -> Error {
        refused(self.path, self.name, message)
    }
}
