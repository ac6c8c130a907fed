//! Writing whole or not at all: a hidden file beside the target, made durable, then renamed.

use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

use tempfile::TempPath;

use super::Replace;
use crate::Error;

/// Where a write to `target` keeps its unfinished file: hidden, beside the target, with this process's id.
///
/// A program that is interrupted removes it.
pub fn partial_path(target: &Path) -> PathBuf {
    let name = target.file_name().unwrap_or_default().to_string_lossy();
    target.with_file_name(format!(".{name}.{}.partial", std::process::id()))
}

/// Whether `target` could be written: a cheap look before hours of work.
///
/// # Errors
/// [`Error::OutputExists`] if it is there and may not be replaced; otherwise what is wrong with the path or its folder.
pub fn check_output(target: &Path, replace: Replace) -> Result<(), Error> {
    let folder = check_path(target, replace)?;
    tempfile::Builder::new()
        .prefix(".writable")
        .tempfile_in(folder)
        .map(drop)
        .map_err(|source| Error::Io {
            path: folder.to_owned(),
            action: "cannot write in this folder",
            source,
        })
}

/// Checks everything that needs no writing; returns the target's folder.
fn check_path(target: &Path, replace: Replace) -> Result<&Path, Error> {
    let file = |message: &str| Error::File {
        path: target.to_owned(),
        message: message.to_owned(),
    };
    if target.is_dir() {
        return Err(file("is a folder; name a file in it as the output"));
    }
    // Followed through links: a link to a file may be replaced, one to a device or pipe says that a file is not wanted.
    if fs::metadata(target).is_ok_and(|there| !there.is_file()) {
        return Err(file(
            "is a device, pipe or socket, which a file would replace; name a regular file as the output",
        ));
    }
    if target.file_name().is_none() {
        return Err(file("doesn't name a file"));
    }
    let folder = match target.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    };
    if !folder.is_dir() {
        return Err(file(&format!(
            "the folder {} doesn't exist; make it first",
            folder.display()
        )));
    }
    match (fs::symlink_metadata(target), replace) {
        (Ok(_), Replace::Refuse) => Err(Error::OutputExists {
            path: target.to_owned(),
        }),
        _ => Ok(folder),
    }
}

/// Copies a file that is known to be right: complete and durable under its new name, or not at all.
///
/// # Errors
/// [`Error::OutputExists`]; [`Error::Io`] where the system refuses, a full disk included.
pub fn copy_whole(from: &Path, target: &Path, replace: Replace) -> Result<(), Error> {
    write_whole(target, replace, |partial| {
        let copied = fs::copy(from, partial).map(drop);
        copied.map_err(|source| Error::Io {
            path: target.to_owned(),
            action: "cannot write",
            source,
        })
    })
}

/// Lets `fill` write the unfinished file, then puts it in the target's place. On any error the target is as
/// before and nothing else is left.
pub(crate) fn write_whole(
    target: &Path,
    replace: Replace,
    fill: impl FnOnce(&Path) -> Result<(), Error>,
) -> Result<(), Error> {
    let folder = check_path(target, replace)?;
    let partial = partial_path(target);
    let told = |action| {
        move |source| Error::Io {
            path: target.to_owned(),
            action,
            source,
        }
    };
    match fs::remove_file(&partial) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => {
            return Err(told("cannot write beside it")(error));
        }
        _ => {}
    }
    let partial = TempPath::try_from_path(partial).map_err(told("cannot write beside it"))?; // removed when dropped
    fill(&partial)?;
    File::open(&partial)
        .and_then(|file| file.sync_all())
        .map_err(told("cannot write"))?;
    match replace {
        Replace::Overwrite => partial
            .persist(target)
            .map_err(|failed| told("cannot replace")(failed.error))?,
        Replace::Refuse => {
            partial
                .persist_noclobber(target)
                .map_err(|failed| match failed.error.kind() {
                    io::ErrorKind::AlreadyExists => Error::OutputExists {
                        path: target.to_owned(),
                    },
                    _ => told("cannot write")(failed.error),
                })?
        }
    }
    // The rename itself is durable once the folder is; not every system can open folders.
    if let Ok(folder) = File::open(folder) {
        let _ = folder.sync_all();
    }
    Ok(())
}

#[cfg(all(test, unix))]
#[expect(clippy::unwrap_used, reason = "a test says what went wrong by failing")]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_a_regular_file_is_never_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let socket = folder.path().join("socket");
        let _listener = std::os::unix::net::UnixListener::bind(&socket).unwrap();
        let link = folder.path().join("part.dcb.h5");
        std::os::unix::fs::symlink(&socket, &link).unwrap();
        for target in [Path::new("/dev/null"), &socket, &link] {
            for replace in [Replace::Overwrite, Replace::Refuse] {
                let refused = check_output(target, replace).unwrap_err().to_string();
                assert!(refused.contains("is a device, pipe or socket"), "{refused}");
            }
            assert!(write_whole(target, Replace::Overwrite, |_| Ok(())).is_err());
            assert!(!fs::metadata(target).unwrap().is_file());
        }
    }
}
