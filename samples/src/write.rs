//! Components as files, in folders that are made where they aren't there.

use std::fs::create_dir_all;
use std::path::{Path, PathBuf};

use dcb_formats::component_files::write_component;
use dcb_formats::output::Replace;
use dcb_formats::{Component, Error};

/// Writes the files of a component, `stem.mtx` and those beside it, and returns their paths. The folder is made if needed, files are replaced.
///
/// # Errors
/// As [`write_component`]; [`Error::Io`] where the folder can't be made.
pub fn write(component: &Component, folder: &Path, stem: &str) -> Result<Vec<PathBuf>, Error> {
    let refused = |source| Error::io(folder, "cannot make the folder", source);
    create_dir_all(folder).map_err(refused)?;
    write_component(component, &folder.join(stem), Replace::Overwrite)
}
