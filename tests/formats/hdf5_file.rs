//! HDF5 files opened past this project's reader and writer.

use std::path::Path;
use std::time::{Duration, Instant};

use hdf5::file::LibraryVersion;
use hdf5::types::VarLenUnicode;

/// A process that another test starts inherits the files that are open at that moment, and with them their locks, until it ends.
const LONGEST_PROCESS: Duration = Duration::from_secs(60);

/// Opens a file as soon as no other process has a lock on it.
pub fn unlocked(open: impl Fn() -> hdf5::Result<hdf5::File>) -> hdf5::File {
    let start = Instant::now();
    loop {
        match open() {
            Err(error)
                if error.to_string().contains("lock") && start.elapsed() < LONGEST_PROCESS =>
            {
                std::thread::sleep(Duration::from_millis(20));
            }
            file => return file.unwrap(),
        }
    }
}

/// Changes a file; what is new in it has this version of HDF5's format.
pub fn edit(path: &Path, version: LibraryVersion, change: impl FnOnce(&hdf5::File)) {
    let file = unlocked(|| {
        hdf5::File::with_options()
            .with_fapl(|access| access.libver_bounds(version, version))
            .open_rw(path)
    });
    change(&file);
    file.close().unwrap();
}

/// Gives an object an attribute of text, or another text.
pub fn set_text(object: &hdf5::Location, name: &str, text: &str) {
    let _ = object.delete_attr(name);
    let attribute = object.new_attr::<VarLenUnicode>().create(name).unwrap();
    attribute
        .write_scalar(&text.parse::<VarLenUnicode>().unwrap())
        .unwrap();
}
