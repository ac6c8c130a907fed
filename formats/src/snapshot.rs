//! A file that is read once from beginning to end, so that its digest is that of the bytes that were used.
//!
//! Nothing is mapped: a file that another program cuts off meanwhile is an error, not the end of the process. Files, pipes and
//! standard input are read; devices are refused, because they may have no end.

use std::fs::{File, Metadata};
use std::io::{self, ErrorKind, Read};
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use crate::Error;
use crate::hdf5_files::digest::Hash;

/// Bytes that are read together: they are still in the processor's cache when they are hashed.
const READ_TOGETHER: usize = 1 << 18;

/// A file while it is read.
pub struct Snapshot {
    path: PathBuf,
    file: File,
    /// Of a file on a disk; a pipe has none.
    before: Option<Stamp>,
    read: u64,
    /// `None` of a file that is only looked at.
    hash: Option<Hash>,
}

/// Traces that a write leaves on a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Stamp {
    length: u64,
    modified: Option<SystemTime>,
}

impl Stamp {
    fn of(metadata: &Metadata) -> Self {
        Self {
            length: metadata.len(),
            modified: metadata.modified().ok(),
        }
    }
}

impl Snapshot {
    /// Opens a file or pipe.
    ///
    /// # Errors
    /// [`Error::Io`] for a missing or unreadable file and for a folder, [`Error::File`] for a device.
    pub fn open(path: &Path) -> Result<Self, Error> {
        let mut file = Self::open_to_look(path)?;
        file.hash = Some(Hash::default());
        Ok(file)
    }

    /// Opens a file to look at it, without a digest, which takes most of the time of reading.
    ///
    /// # Errors
    /// As [`Snapshot::open`].
    pub(crate) fn open_to_look(path: &Path) -> Result<Self, Error> {
        let refused = |source| cannot_read(path, source);
        // Opening a device can do something to it, so it is looked at before.
        refuse_device(path, &std::fs::metadata(path).map_err(refused)?)?;
        let file = File::open(path).map_err(refused)?;
        let metadata = file.metadata().map_err(refused)?;
        if metadata.is_dir() {
            return Err(refused(ErrorKind::IsADirectory.into()));
        }
        refuse_device(path, &metadata)?;
        Ok(Self {
            path: path.into(),
            before: metadata.is_file().then(|| Stamp::of(&metadata)),
            file,
            read: 0,
            hash: None,
        })
    }

    /// Bytes of a file on a disk; `None` of a pipe.
    pub fn length(&self) -> Option<u64> {
        self.before.map(|stamp| stamp.length)
    }

    /// Reads what is left and tells the SHA-256 of the whole file, hexadecimal.
    ///
    /// # Errors
    /// [`Error::File`] if the file was changed since it was opened, or was opened to look at it.
    pub fn finish(mut self) -> Result<String, Error> {
        let mut rest = vec![0; 1 << 16];
        let refused = |path: &Path, source| cannot_read(path, source);
        loop {
            match self.read(&mut rest) {
                Ok(0) => break,
                Ok(_) => {}
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => return Err(refused(&self.path, error)),
            }
        }
        if let Some(before) = self.before {
            let metadata = self.file.metadata();
            let now = Stamp::of(&metadata.map_err(|source| refused(&self.path, source))?);
            if now != before || self.read != before.length {
                return Err(changed(&self.path));
            }
        }
        let hash = self.hash.ok_or_else(|| Error::File {
            path: self.path,
            message: "was read without a digest".into(),
        })?;
        Ok(hash.finish())
    }

    /// Whether the file isn't as it was when it was opened.
    pub(crate) fn is_changed(&self) -> bool {
        let now = self.file.metadata().map(|metadata| Stamp::of(&metadata));
        self.before
            .is_some_and(|before| now.is_ok_and(|now| now != before))
    }

    /// The error of a file that was changed.
    pub(crate) fn changed(&self) -> Error {
        changed(&self.path)
    }
}

impl Read for Snapshot {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let room = buffer.len().min(READ_TOGETHER);
        let count = self.file.read(&mut buffer[..room])?;
        if let Some(hash) = &mut self.hash {
            hash.update(&buffer[..count]);
        }
        self.read += count as u64;
        Ok(count)
    }
}

/// Bytes and SHA-256 of a file that should be small.
///
/// # Errors
/// As [`Snapshot::open`] and [`Snapshot::finish`]; [`Error::File`] for more than `most` bytes, of which not more are read.
pub fn read_small(path: &Path, most: u64) -> Result<(Vec<u8>, String), Error> {
    let mut file = Snapshot::open(path)?;
    let too_long = || Error::File {
        path: path.into(),
        message: format!("is longer than {most} bytes; such a file isn't what is expected here"),
    };
    if file.length().is_some_and(|length| length > most) {
        return Err(too_long());
    }
    let mut bytes = Vec::new();
    (&mut file)
        .take(most.saturating_add(1))
        .read_to_end(&mut bytes)
        .map_err(|source| cannot_read(path, source))?;
    if bytes.len() as u64 > most {
        return Err(too_long());
    }
    Ok((bytes, file.finish()?))
}

/// SHA-256 of bytes, hexadecimal.
pub fn digest_of(bytes: &[u8]) -> String {
    let mut hash = Hash::default();
    hash.update(bytes);
    hash.finish()
}

pub(crate) fn cannot_read(path: &Path, source: io::Error) -> Error {
    Error::io(path, "cannot read", source)
}

/// The error of a file that was changed while it was read.
pub fn changed(path: &Path) -> Error {
    Error::File {
        path: path.into(),
        message: "was changed while it was read; run again when nothing writes to it any more"
            .into(),
    }
}

#[cfg(unix)]
fn refuse_device(path: &Path, metadata: &Metadata) -> Result<(), Error> {
    use std::os::unix::fs::FileTypeExt;
    let kind = metadata.file_type();
    if kind.is_char_device() || kind.is_block_device() {
        return Err(Error::File {
            path: path.into(),
            message: "is a device; expected a file or a pipe".into(),
        });
    }
    Ok(())
}

#[cfg(not(unix))]
fn refuse_device(_: &Path, _: &Metadata) -> Result<(), Error> {
    Ok(())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use std::io::Write;

    use super::*;

    fn scratch(content: &[u8]) -> tempfile::NamedTempFile {
        let mut file = tempfile::NamedTempFile::new().unwrap();
        file.write_all(content).unwrap();
        file
    }

    fn set_back(file: &tempfile::NamedTempFile) {
        let hour = std::time::Duration::from_secs(3600);
        let time = SystemTime::now() - hour;
        file.as_file().set_modified(time).unwrap();
    }

    #[test]
    fn the_digest_is_of_the_bytes_that_were_given_out() {
        let file = scratch(b"abc");
        let (bytes, digest) = read_small(file.path(), 3).unwrap();
        assert_eq!(bytes, b"abc");
        // FIPS 180-2, appendix B.1.
        assert_eq!(
            digest,
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"
        );
        let error = read_small(file.path(), 2).unwrap_err().to_string();
        assert!(error.contains("is longer than 2 bytes"), "{error}");
    }

    #[test]
    fn a_file_that_changes_between_two_reads_is_refused() {
        type Change = fn(&mut tempfile::NamedTempFile);
        let changes: [(&str, Change); 4] = [
            ("same length", |file| {
                let content = std::fs::read(file.path()).unwrap();
                std::fs::write(file.path(), content.to_ascii_uppercase()).unwrap();
            }),
            ("longer", |file| file.write_all(b"more").unwrap()),
            ("cut off", |file| file.as_file().set_len(70_000).unwrap()),
            ("emptied", |file| file.as_file().set_len(0).unwrap()),
        ];
        for (name, change) in changes {
            let mut file = scratch(&b"text".repeat(40_000));
            set_back(&file);
            let mut snapshot = Snapshot::open(file.path()).unwrap();
            snapshot.read_exact(&mut [0; 1000]).unwrap();
            change(&mut file);
            assert!(snapshot.is_changed(), "{name}");
            let error = snapshot.finish().unwrap_err().to_string();
            assert!(
                error.contains("was changed while it was read"),
                "{name}: {error}"
            );
        }
    }

    #[cfg(unix)]
    #[test]
    fn devices_are_refused() {
        for device in ["/dev/zero", "/dev/null", "/dev/urandom"] {
            let error = read_small(Path::new(device), 1 << 20).unwrap_err();
            assert_eq!(
                error.to_string(),
                format!("{device}: is a device; expected a file or a pipe")
            );
        }
    }
}
