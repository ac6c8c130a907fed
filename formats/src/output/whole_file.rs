//! Writing whole or not at all: an unfinished file beside the target, made durable, looked at, then renamed.
//!
//! A target that is a symbolic link is replaced itself; what it leads to stays as it is. Permissions are those that
//! the system gives to new files (`umask`), not those of a file that is replaced.

use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use tempfile::TempPath;

use super::Replace;
use super::unfinished::{UnfinishedFolder, is_same};
use crate::Error;

/// Bytes that are written at a time.
const BUFFER: usize = 1 << 18;

/// Whether `target` could be written: a cheap look before hours of work. Leftovers of killed programs are removed.
///
/// # Errors
/// [`Error::OutputExists`] if it is there and may not be replaced; otherwise what is wrong with the path or its folder.
pub fn check_output(target: &Path, replace: Replace) -> Result<(), Error> {
    check_path(target, replace)?;
    let name = target.file_name().unwrap_or_default();
    UnfinishedFolder::within(folder_of(target), name)
        .map(drop)
        .map_err(|source| Error::io(folder_of(target), "cannot write in this folder", source))
}

/// Whether two paths lead to one file, through whatever links, or would: they have one name in one folder.
pub fn is_same_file(a: &Path, b: &Path) -> bool {
    let place = |path: &Path| -> Option<PathBuf> {
        Some(folder_of(path).canonicalize().ok()?.join(path.file_name()?))
    };
    match (fs::metadata(a), fs::metadata(b)) {
        (Ok(there), Ok(other)) => is_same(&there, &other),
        _ => place(a).is_some() && place(a) == place(b),
    }
}

/// The folder that a file is in.
pub(super) fn folder_of(target: &Path) -> &Path {
    match target.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

/// Checks everything that needs no writing.
fn check_path(target: &Path, replace: Replace) -> Result<(), Error> {
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
    let folder = folder_of(target);
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
        _ => Ok(()),
    }
}

/// Copies a file that is known to be right: complete and durable under its new name, or not at all.
///
/// # Errors
/// [`Error::OutputExists`]; [`Error::NoRoom`] on a full disk; [`Error::Io`] where the system refuses.
pub fn copy_whole(from: &Path, target: &Path, replace: Replace) -> Result<(), Error> {
    write_whole(target, replace, |_, mut file| {
        let told = |source| Error::io(from, "cannot read", source);
        let mut source = File::open(from).map_err(told)?;
        let bytes = source.metadata().map_err(told)?.len();
        io::copy(&mut source, &mut file)
            .map(drop)
            .map_err(|source| Error::not_written(target, bytes, source))
    })
}

/// Writes a file, complete and durable under its name, or not at all.
///
/// # Errors
/// [`Error::OutputExists`]; [`Error::NoRoom`] on a full disk; [`Error::File`] and [`Error::Io`] where no file can be written.
pub fn write_stream(
    target: &Path,
    replace: Replace,
    fill: impl FnOnce(&mut Stream<'_>) -> io::Result<()>,
) -> Result<(), Error> {
    UnfinishedFolder::of(target, replace)?.write_stream(target, replace, fill)
}

/// Lets `fill` write the unfinished file, which is empty, then puts it in the target's place. On any error the target
/// is as before and nothing else is left.
pub(crate) fn write_whole(
    target: &Path,
    replace: Replace,
    fill: impl FnOnce(&Path, &File) -> Result<(), Error>,
) -> Result<(), Error> {
    UnfinishedFolder::of(target, replace)?.write(target, replace, fill)
}

/// Writer of a file.
pub type Stream<'a> = BufWriter<Counted<'a>>;

/// A file, and how many bytes were to be in it.
#[derive(Debug)]
pub struct Counted<'a> {
    file: &'a File,
    wanted: u64,
    written: u64,
}

impl Write for Counted<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.wanted = self.written + bytes.len() as u64;
        let count = self.file.write(bytes)?;
        self.written += count as u64;
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

/// A file that is complete and durable, but has no name yet. Removed when dropped.
pub(super) struct Filled {
    file: File,
    partial: TempPath,
}

impl UnfinishedFolder {
    /// One for a target that can be written.
    pub(super) fn of(target: &Path, replace: Replace) -> Result<Self, Error> {
        check_path(target, replace)?;
        Self::within(folder_of(target), target.file_name().unwrap_or_default())
            .map_err(|source| Error::not_written(target, 0, source))
    }

    /// Writes a file of this folder and gives it its name.
    ///
    /// # Errors
    /// As [`write_stream`].
    pub fn write_stream(
        &self,
        target: &Path,
        replace: Replace,
        fill: impl FnOnce(&mut Stream<'_>) -> io::Result<()>,
    ) -> Result<(), Error> {
        let filled = self.fill_stream(target, replace, fill)?;
        self.place(filled, target, replace)
    }

    /// Writes a file of this folder that has no name yet.
    pub(super) fn fill_stream(
        &self,
        target: &Path,
        replace: Replace,
        fill: impl FnOnce(&mut Stream<'_>) -> io::Result<()>,
    ) -> Result<Filled, Error> {
        self.fill(target, replace, |_, file| {
            let counted = Counted {
                file,
                wanted: 0,
                written: 0,
            };
            let mut out = BufWriter::with_capacity(BUFFER, counted);
            let filled = fill(&mut out).and_then(|()| out.flush());
            // What couldn't be written isn't tried again.
            let (counted, _) = out.into_parts();
            filled.map_err(|source| Error::not_written(target, counted.wanted, source))
        })
    }

    /// Lets `fill` write an empty file of this folder, and gives it its name.
    ///
    /// # Errors
    /// As [`write_stream`], and those of `fill`.
    pub fn write(
        &self,
        target: &Path,
        replace: Replace,
        fill: impl FnOnce(&Path, &File) -> Result<(), Error>,
    ) -> Result<(), Error> {
        let filled = self.fill(target, replace, fill)?;
        self.place(filled, target, replace)
    }

    fn fill(
        &self,
        target: &Path,
        replace: Replace,
        fill: impl FnOnce(&Path, &File) -> Result<(), Error>,
    ) -> Result<Filled, Error> {
        check_path(target, replace)?;
        let told = |source| Error::not_written(target, 0, source);
        // HDF5 wants UTF-8; nothing else is in this folder, so the name need not be the target's.
        let name = target.file_name().and_then(|name| name.to_str());
        let path = self.path().join(name.unwrap_or("output"));
        let file = File::create_new(&path).map_err(told)?;
        let partial = TempPath::try_from_path(path).map_err(told)?; // removed when dropped
        fill(&partial, &file)?;
        file.sync_all()
            .map_err(|source| Error::not_written(target, length(&file), source))?;
        Ok(Filled { file, partial })
    }

    /// Gives a file of this folder its name.
    pub(super) fn place(
        &self,
        filled: Filled,
        target: &Path,
        replace: Replace,
    ) -> Result<(), Error> {
        let Filled { file, partial } = filled;
        let told = |source| Error::not_written(target, 0, source);
        self.check(&partial, &file, target)?;
        self.release(|| match replace {
            Replace::Overwrite => partial.persist(target).map_err(|failed| failed.error),
            Replace::Refuse => partial
                .persist_noclobber(target)
                .map_err(|failed| failed.error),
        })
        .map_err(|source| match source.kind() {
            io::ErrorKind::AlreadyExists => Error::OutputExists {
                path: target.to_owned(),
            },
            _ => told(source),
        })?;
        // The rename itself is durable once the folder is; not every system can open folders.
        if let Ok(folder) = File::open(folder_of(target)) {
            let _ = folder.sync_all();
        }
        Ok(())
    }

    /// Whether what would be renamed is what was written.
    fn check(&self, partial: &Path, file: &File, target: &Path) -> Result<(), Error> {
        let is_ours = match (file.metadata(), fs::symlink_metadata(partial)) {
            (Ok(ours), Ok(there)) => is_same(&ours, &there) && ours.len() == there.len(),
            _ => false,
        };
        match is_ours {
            true => Ok(()),
            false => Err(Error::File {
                path: target.to_owned(),
                message: format!(
                    "isn't written: another program removed or replaced the unfinished file {}; start again",
                    partial.display()
                ),
            }),
        }
    }
}

/// Bytes that a file has, as far as can be told.
fn length(file: &File) -> u64 {
    file.metadata().map_or(0, |data| data.len())
}

#[cfg(all(test, unix))]
#[expect(clippy::unwrap_used, reason = "a test says what went wrong by failing")]
mod tests {
    use std::os::unix::fs::PermissionsExt;

    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap();
        let mut names: Vec<String> = entries
            .map(|entry| entry.unwrap().file_name().into_string().unwrap())
            .collect();
        names.sort();
        names
    }

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
            assert!(write_whole(target, Replace::Overwrite, |_, _| Ok(())).is_err());
            assert!(!fs::metadata(target).unwrap().is_file());
        }
    }

    #[test]
    fn what_another_program_did_to_the_unfinished_file_is_noticed() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("part.dcb.h5");
        fs::write(&target, "old").unwrap();
        for replaced in [true, false] {
            let told = write_whole(&target, Replace::Overwrite, |partial, mut file| {
                file.write_all(b"new").unwrap();
                fs::remove_file(partial).unwrap();
                if replaced {
                    fs::write(partial, "not").unwrap();
                }
                Ok(())
            });
            let told = told.unwrap_err().to_string();
            assert!(told.contains("part.dcb.h5: isn't written"), "{told}");
            assert_eq!(fs::read(&target).unwrap(), b"old");
            assert_eq!(names(folder.path()), ["part.dcb.h5"]);
        }
    }

    #[test]
    fn what_appears_meanwhile_stays_without_force() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("part.csv");
        let told = write_stream(&target, Replace::Refuse, |out| {
            fs::write(&target, "another's").unwrap();
            out.write_all(b"ours")
        });
        assert!(matches!(told, Err(Error::OutputExists { .. })), "{told:?}");
        assert_eq!(fs::read(&target).unwrap(), b"another's");
        assert_eq!(names(folder.path()), ["part.csv"]);
    }

    #[test]
    fn a_new_file_has_the_permissions_that_the_system_gives() {
        let folder = tempfile::tempdir().unwrap();
        let plain = folder.path().join("plain");
        fs::write(&plain, "").unwrap();
        let target = folder.path().join("x".repeat(250));
        write_stream(&target, Replace::Refuse, |out| out.write_all(b"x")).unwrap();
        let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode();
        assert_eq!(mode(&target), mode(&plain));
    }

    #[test]
    fn a_link_is_replaced_and_what_it_leads_to_stays() {
        let folder = tempfile::tempdir().unwrap();
        let (mine, link) = (folder.path().join("mine"), folder.path().join("link"));
        fs::write(&mine, "mine").unwrap();
        std::os::unix::fs::symlink(&mine, &link).unwrap();
        assert!(is_same_file(&mine, &link));
        write_stream(&link, Replace::Overwrite, |out| out.write_all(b"new")).unwrap();
        assert_eq!(fs::read(&mine).unwrap(), b"mine");
        assert_eq!(fs::read(&link).unwrap(), b"new");
        assert!(!is_same_file(&mine, &link));
        fs::hard_link(&mine, folder.path().join("hard")).unwrap();
        assert!(is_same_file(&mine, &folder.path().join("hard")));
    }

    #[test]
    fn leftovers_are_removed_unless_their_program_lives() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("part.dcb.h5");
        let file = folder.path().join(".part.dcb.h5.77.partial");
        fs::write(&file, "left by an older version").unwrap();
        let left = folder.path().join(".part.dcb.h5.abcdefghijkl.partial");
        fs::create_dir(&left).unwrap();
        fs::write(left.join("part.dcb.h5"), "left").unwrap();
        let elsewhere = folder.path().join(".other.dcb.h5.77.partial");
        fs::write(&elsewhere, "another's").unwrap();
        let living = UnfinishedFolder::within(folder.path(), target.file_name().unwrap()).unwrap();
        check_output(&target, Replace::Refuse).unwrap();
        let found = names(folder.path());
        assert_eq!(found.len(), 2, "{found:?}");
        assert!(living.path().is_dir() && elsewhere.exists());
        write_stream(&target, Replace::Refuse, |out| out.write_all(b"new")).unwrap();
        drop(living);
        assert_eq!(
            names(folder.path()),
            [".other.dcb.h5.77.partial", "part.dcb.h5"]
        );
    }

    #[test]
    fn a_disk_without_room_is_told_with_what_is_needed() {
        let Ok(full) = File::options().write(true).open("/dev/full") else {
            return println!("SKIPPED: no /dev/full here");
        };
        let mut counted = Counted {
            file: &full,
            wanted: 0,
            written: 0,
        };
        let failed = counted.write_all(&[0; 4096]).unwrap_err();
        let told = Error::not_written(Path::new("part.csv"), counted.wanted, failed).to_string();
        assert!(
            told.starts_with("part.csv: disk full: needs 4096 bytes"),
            "{told}"
        );
    }
}
