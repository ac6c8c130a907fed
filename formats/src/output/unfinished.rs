//! Where files are while they are written: in a folder of their own beside the target, which nobody else can look into.
//!
//! ```text
//! FOLDER/.NAME.RANDOM.partial/NAME     unfinished
//! FOLDER/NAME                          finished: renamed
//! ```
//!
//! The folder has an unpredictable name and is made exclusively, so that two programs never share one, not even in two
//! containers that give them the same process number. It is locked while its program lives; the system lets go of the
//! lock however the program ends. What is there without a lock was left by a killed program: the next one that writes
//! `NAME` removes it. Where a file system has no locks, nothing is removed.

use std::ffi::OsStr;
use std::fs::{self, File, Metadata};
use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Ending of the folders' names.
const ENDING: &str = ".partial";
/// Letters and digits of a name that are random: 71 bits.
const RANDOM: usize = 12;
/// Bytes of the target's name in that of the folder, at most: names may have 255.
const LONGEST_NAME: usize = 200;
/// How often a folder is made anew that somebody took for a leftover before it was locked.
const TRIES: usize = 100;

/// The folders of this process.
static OPEN: Mutex<Open> = Mutex::new(Open {
    is_ended: false,
    folders: Vec::new(),
});

struct Open {
    /// Nothing may be written any more.
    is_ended: bool,
    folders: Vec<PathBuf>,
}

fn open() -> MutexGuard<'static, Open> {
    OPEN.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Removes everything unfinished of this process, which is about to end: from now on it puts nothing in its place.
pub fn remove_unfinished() {
    let mut open = open();
    open.is_ended = true;
    for folder in open.folders.drain(..) {
        remove_folder(&folder);
    }
}

/// A folder for unfinished files. Removed when dropped, with all that is still in it.
#[derive(Debug)]
pub struct UnfinishedFolder {
    path: PathBuf,
    _lock: Option<File>,
}

impl UnfinishedFolder {
    /// Makes one beside what will be called `name` in `place`, and removes what killed programs left of that name.
    ///
    /// # Errors
    /// It can't be made, or this process is about to end ([`remove_unfinished`]).
    pub fn within(place: &Path, name: &OsStr) -> io::Result<Self> {
        let start = start(name);
        remove_those(place, &start);
        let mut builder = tempfile::Builder::new();
        builder.prefix(&start).suffix(ENDING).rand_bytes(RANDOM);
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o700));
        for _ in 0..TRIES {
            let path = {
                let mut open = open();
                if open.is_ended {
                    return Err(io::Error::other("the program is about to end"));
                }
                let path = builder.tempdir_in(place)?.keep();
                open.folders.push(path.clone());
                path
            };
            let made = Self {
                _lock: File::open(&path).ok(),
                path,
            };
            if made.is_locked_or_cannot_be() {
                return Ok(made);
            }
        }
        Err(io::Error::other("it is removed as soon as it is made"))
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Between making and locking, another program may take it for a leftover.
    fn is_locked_or_cannot_be(&self) -> bool {
        let Some(lock) = &self._lock else {
            return self.path.is_dir();
        };
        match lock.try_lock() {
            Err(fs::TryLockError::WouldBlock) => false,
            Ok(()) | Err(fs::TryLockError::Error(_)) => {
                let seen = (lock.metadata(), fs::symlink_metadata(&self.path));
                matches!(seen, (Ok(held), Ok(there)) if is_same(&held, &there))
            }
        }
    }

    /// Gives a finished file its name, unless this process is about to end.
    pub(super) fn release(&self, rename: impl FnOnce() -> io::Result<()>) -> io::Result<()> {
        match open().is_ended {
            true => Err(io::Error::other("the program is about to end")),
            false => rename(),
        }
    }
}

impl Drop for UnfinishedFolder {
    fn drop(&mut self) {
        open().folders.retain(|path| *path != self.path);
        remove_folder(&self.path);
    }
}

/// Removes what killed programs left of `target`.
pub fn remove_leftovers(target: &Path) {
    if let Some(name) = target.file_name() {
        remove_those(super::whole_file::folder_of(target), &start(name));
    }
}

/// Removes something unfinished unless its program still lives; does nothing to what has another kind of name.
pub fn remove_leftover(path: &Path) {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    if !(name.starts_with('.') && name.ends_with(ENDING)) {
        return;
    }
    // Links, pipes and devices are nobody's unfinished files. Older versions wrote files in place of folders.
    let kind = match fs::symlink_metadata(path) {
        Ok(there) if there.is_dir() || there.is_file() => there.file_type(),
        _ => return,
    };
    let Ok(lock) = File::open(path) else { return };
    if lock.try_lock().is_ok() {
        match kind.is_dir() {
            true => remove_folder(path),
            false => drop(fs::remove_file(path)),
        }
    }
}

fn remove_those(place: &Path, start: &str) {
    let Ok(listing) = fs::read_dir(place) else {
        return;
    };
    for entry in listing.flatten() {
        let name = entry.file_name();
        let name = name.to_string_lossy();
        let random = name
            .strip_prefix(start)
            .and_then(|rest| rest.strip_suffix(ENDING));
        if random.is_some_and(|random| !random.is_empty() && !random.contains('.')) {
            remove_leftover(&entry.path());
        }
    }
}

/// How the names of a target's folders begin.
fn start(name: &OsStr) -> String {
    let name = name.to_string_lossy();
    let mut end = name.len().min(LONGEST_NAME);
    while !name.is_char_boundary(end) {
        end -= 1;
    }
    format!(".{}.", &name[..end])
}

/// Removes a folder, also while another thread still writes into it.
fn remove_folder(folder: &Path) {
    let gone = |_: &u32| match fs::remove_dir_all(folder) {
        Ok(()) => true,
        Err(error) => error.kind() == ErrorKind::NotFound,
    };
    let _ = (0..100).find(gone);
}

/// Whether both are of one file or folder.
#[cfg(unix)]
pub(super) fn is_same(a: &Metadata, b: &Metadata) -> bool {
    use std::os::unix::fs::MetadataExt;
    (a.dev(), a.ino()) == (b.dev(), b.ino())
}

/// As far as can be told here.
#[cfg(not(unix))]
pub(super) fn is_same(a: &Metadata, b: &Metadata) -> bool {
    (a.file_type(), a.len(), a.created().ok()) == (b.file_type(), b.len(), b.created().ok())
}
