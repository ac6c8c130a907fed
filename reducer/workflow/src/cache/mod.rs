//! Superelements that were made before, on disk, under the digests of all that decides them.
//!
//! ```text
//! FOLDER/KEY.dcb.h5     the superelement with its nodal fields, as the writer makes it
//! FOLDER/KEY.json       what was asked for, what it took; its time of change is the last use
//! FOLDER/KEY.lock       empty; stays
//! ```
//!
//! An entry is there once its `KEY.json` is, which is written last. Who makes an entry holds `KEY.lock` alone, who reads one shares it:
//! a second process that wants the same waits for the first, and nothing is removed while it is read. The system lets go of the
//! locks of a process however it ends; what it left unfinished is removed by the next one.

pub(crate) mod claim;
pub(crate) mod entry;
pub mod eviction;
pub mod folder;
pub(crate) mod request;

use std::io;
use std::path::{Path, PathBuf};

use dcb_formats::output::write_text;

pub use claim::{Claim, Reservation, Stored};
pub use entry::{Entry, Listed, Record};
pub use request::{Key, Request};

pub use dcb_reducer::mode_selection::ModeRequest;

/// Ending of superelements.
const SUPERELEMENT: &str = ".dcb.h5";
/// Ending of records.
const RECORD: &str = ".json";
/// Says to backup programs what kind of folder it is (bford.info/cachedir).
const TAG: (&str, &str) = (
    "CACHEDIR.TAG",
    "Signature: 8a477f597d28d172789f06886806bc55\n# Superelements kept by `reduce`; see `reduce cache`.\n",
);

/// A folder of superelements.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Cache {
    folder: PathBuf,
    limit: u64,
}

impl Cache {
    /// The cache in a folder, made if it isn't there. `limit` is how many bytes it may keep.
    ///
    /// # Errors
    /// The folder can't be made or written.
    pub fn at(folder: &Path, limit: u64) -> io::Result<Self> {
        std::fs::create_dir_all(folder)?;
        let (name, text) = TAG;
        if !folder.join(name).exists() {
            write_text(&folder.join(name), text).map_err(io::Error::other)?;
        }
        Ok(Self::existing(folder, limit))
    }

    /// The cache in a folder that is there already, or is taken to be empty.
    pub fn existing(folder: &Path, limit: u64) -> Self {
        Self {
            folder: folder.to_owned(),
            limit,
        }
    }

    /// Where it is.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// How many bytes it may keep.
    pub fn limit(&self) -> u64 {
        self.limit
    }

    /// Where the superelement of an entry is, or would be.
    pub fn superelement_path(&self, key: &Key) -> PathBuf {
        self.folder.join(format!("{key}{SUPERELEMENT}"))
    }

    fn record_path(&self, key: &Key) -> PathBuf {
        self.folder.join(format!("{key}{RECORD}"))
    }

    fn lock_path(&self, key: &Key) -> PathBuf {
        self.folder.join(format!("{key}.lock"))
    }
}
