//! A new HDF5 file, and what HDF5 does when the disk is full.

use std::ffi::CString;
use std::os::unix::ffi::OsStrExt;
use std::path::Path;

use hdf5::file::{FileAccess, FileCreate, LibraryVersion};
use hdf5_sys::h5f::{H5F_ACC_EXCL, H5Fcreate};
use hdf5_sys::h5p::H5Pset_link_phase_change;

use super::sink::MOST_COMPACT;
use crate::Error;

/// HDF5 tells the system's answer only as text in its error stack.
pub(super) fn told(target: &Path, error: &hdf5::Error) -> Error {
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
        Some(errno) => Error::Io {
            path,
            action: "cannot write",
            source: std::io::Error::from_raw_os_error(errno),
        },
        None => Error::File {
            path,
            message: format!("cannot write: {error}"),
        },
    }
}

/// A new file whose metadata are as the reader wants them: format of HDF5 1.10 (the earlier ones have no checksums
/// on metadata), and all links in the headers of their groups, the root's included.
pub(super) fn create(path: &Path) -> hdf5::Result<hdf5::File> {
    let access = FileAccess::build()
        .libver_bounds(LibraryVersion::V110, LibraryVersion::V110)
        .finish()?;
    let creation = FileCreate::build().obj_track_times(false).finish()?;
    let name = CString::new(path.as_os_str().as_bytes())
        .map_err(|_| hdf5::Error::from("the path contains a zero byte"))?;
    // The safe builder has no way to say this of the root group.
    hdf5::sync::sync(|| {
        // SAFETY: both property lists and the name outlive the calls, the lock is held, and the new id is handed
        // to its only owner.
        unsafe {
            let set = H5Pset_link_phase_change(creation.id(), MOST_COMPACT, 0);
            let id = if set < 0 {
                -1
            } else {
                H5Fcreate(name.as_ptr(), H5F_ACC_EXCL, creation.id(), access.id())
            };
            if id < 0 {
                Err(hdf5::Error::query().unwrap_or_else(|error| error))
            } else {
                hdf5::from_id(id)
            }
        }
    })
}

/// Gives the disk space of a failed write back before HDF5 closes the file, which has to write once more.
pub(super) fn abandon(partial: &Path) {
    if let Ok(file) = std::fs::OpenOptions::new().write(true).open(partial) {
        let _ = file.set_len(0);
    }
}
