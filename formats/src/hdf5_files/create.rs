//! A new HDF5 file, and what HDF5 does when the disk is full.

use std::path::Path;

use hdf5::file::LibraryVersion;

use crate::Error;
use crate::out_of_memory::demand;
use crate::output::{Replace, write_whole};

/// Writes an HDF5 file, complete and durable under its name, or not at all. `needed`: its bytes, roughly, for whoever has to make room.
///
/// # Errors
/// [`Error::OutputExists`]; [`Error::NoRoom`] on a full disk; [`Error::File`] and [`Error::Io`] where no file can be written.
pub fn write_hdf5(
    target: &Path,
    replace: Replace,
    needed: u64,
    fill: impl FnOnce(&hdf5::File) -> hdf5::Result<()>,
) -> Result<(), Error> {
    write_whole(target, replace, |partial, _| {
        let write = || {
            let file = create(partial)?;
            let written = fill(&file).and_then(|()| file.flush());
            if written.is_err() {
                abandon(partial);
            }
            let closed = file.close();
            written.and(closed)
        };
        write().map_err(|error| told(target, needed, &error))
    })
}

/// HDF5 tells the system's answer only as text in its error stack. `needed`: bytes of the file, or what was to be added.
pub(crate) fn told(target: &Path, needed: u64, error: &hdf5::Error) -> Error {
    let path = target.to_owned();
    let frames = error.stack().map(|stack| {
        stack
            .iter()
            .map(|frame| frame.desc().to_owned())
            .collect::<Vec<_>>()
    });
    let errno = frames.into_iter().flatten().find_map(|text| {
        let (_, after) = text.split_once("errno = ")?;
        after
            .split(|c: char| !c.is_ascii_digit())
            .next()?
            .parse()
            .ok()
    });
    match errno {
        Some(errno) => Error::not_written(&path, needed, std::io::Error::from_raw_os_error(errno)),
        None => Error::File {
            path,
            message: format!("cannot write: {error}"),
        },
    }
}

/// Memory that must be left for the HDF5 library, bytes: it doesn't survive that there is none.
const ROOM: usize = 64 << 20;

/// An empty file becomes an HDF5 file that HDF5 1.8 and everything later reads. Nothing older will do: it limits an attribute to
/// 64 KiB, and the lists of units may be longer. Without times the same contents give the same bytes.
pub(crate) fn create(path: &Path) -> hdf5::Result<hdf5::File> {
    demand(ROOM);
    hdf5::File::with_options()
        .with_fapl(|access| access.libver_bounds(LibraryVersion::V18, LibraryVersion::V18))
        .with_fcpl(|creation| creation.obj_track_times(false))
        .create(path)
}

/// Gives the disk space of a failed write back before HDF5 closes the file, which has to write once more.
pub(crate) fn abandon(partial: &Path) {
    if let Ok(file) = std::fs::OpenOptions::new().write(true).open(partial) {
        let _ = file.set_len(0);
    }
}
