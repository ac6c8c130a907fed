//! Several files that belong together, all of them or none.

use std::io;
use std::path::PathBuf;

use super::whole_file::{Filled, Stream};
use super::{Replace, UnfinishedFolder};
use crate::error::Error;

/// Content of a file.
type Fill<'a> = Box<dyn FnOnce(&mut Stream<'_>) -> io::Result<()> + 'a>;

/// A file to be written.
pub struct WholeFile<'a> {
    /// Its name.
    pub target: PathBuf,
    /// Writes its content.
    pub fill: Fill<'a>,
}

/// Writes files in one folder. None gets its name before all are complete and durable; the first one gets it last.
///
/// # Errors
/// As [`write_stream`](super::write_stream). Files that weren't there before aren't there afterwards.
pub fn write_together(files: Vec<WholeFile<'_>>, replace: Replace) -> Result<(), Error> {
    let mut filled: Vec<(PathBuf, UnfinishedFolder, Filled)> = Vec::new();
    for WholeFile { target, fill } in files {
        let folder = UnfinishedFolder::of(&target, replace)?;
        let file = folder.fill_stream(&target, replace, fill)?;
        filled.push((target, folder, file));
    }
    let mut new = Vec::new();
    for (target, folder, file) in filled.into_iter().rev() {
        let was_there = target.exists();
        if let Err(error) = folder.place(file, &target, replace) {
            for path in new {
                // Whatever can't be removed is at least complete.
                let _ = std::fs::remove_file(path);
            }
            return Err(error);
        }
        if !was_there {
            new.push(target);
        }
    }
    Ok(())
}
