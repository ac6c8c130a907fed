//! Superelement files, each opened and read once however often a scene is looked at.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use dcb_formats::dcb::SuperelementFile;
use dcb_formats::superelement::Superelement;

use crate::Error;

/// A file that is open, and what its dynamics needs.
#[derive(Debug)]
pub struct OpenSuperelement {
    /// For nodal fields, which are read when they are asked for.
    pub file: SuperelementFile,
    /// Everything else.
    pub superelement: Superelement,
}

/// Files that are open, by their paths. Clones share them, and they stay open until the last is dropped.
#[derive(Clone, Debug, Default)]
pub struct SuperelementFiles {
    open: Arc<Mutex<BTreeMap<PathBuf, Arc<OpenSuperelement>>>>,
}

impl SuperelementFiles {
    /// The file at a path, opened now if it isn't open.
    ///
    /// # Errors
    /// [`Error::Formats`].
    pub fn at(&self, path: &Path) -> Result<Arc<OpenSuperelement>, Error> {
        let mut open = self.open.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = open.get(path) {
            return Ok(known.clone());
        }
        let file = SuperelementFile::open(path)?;
        let superelement = file.for_dynamics()?;
        let opened = Arc::new(OpenSuperelement { file, superelement });
        open.insert(path.to_owned(), opened.clone());
        Ok(opened)
    }
}
