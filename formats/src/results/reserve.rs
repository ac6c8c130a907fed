//! Disk space taken before HDF5 needs it.
//!
//! A disk that fills while HDF5 writes leaves a file that nobody can read: some of its tables are new, some old. So
//! the space for a block is taken first, by writing zeros behind the end of the file; where that fails, HDF5 hasn't
//! begun. HDF5 doesn't mind what is behind its own end.

use std::fs::{File, OpenOptions};
use std::io::{self, Seek as _, SeekFrom, Write as _};
use std::path::Path;

const ZEROS: [u8; 1 << 14] = [0; 1 << 14];

/// The space behind the end of a file.
#[derive(Debug)]
pub(super) struct Reserve {
    file: File,
}

impl Reserve {
    /// That of a file which exists.
    pub(super) fn behind(path: &Path) -> io::Result<Self> {
        let file = OpenOptions::new().write(true).open(path)?;
        Ok(Self { file })
    }

    /// Takes `bytes` behind `end`; if there isn't that much, the file is as long as before.
    pub(super) fn take(&mut self, end: u64, bytes: u64) -> io::Result<()> {
        let length = self.file.metadata()?.len();
        let mut missing = (end + bytes).saturating_sub(length);
        self.file.seek(SeekFrom::Start(length))?;
        while missing > 0 {
            let count = missing.min(ZEROS.len() as u64);
            if let Err(error) = self.file.write_all(&ZEROS[..count as usize]) {
                self.give_back(length)?;
                return Err(error);
            }
            missing -= count;
        }
        Ok(())
    }

    /// Gives back what is behind `end`.
    pub(super) fn give_back(&self, end: u64) -> io::Result<()> {
        if self.file.metadata()?.len() > end {
            self.file.set_len(end)?;
        }
        Ok(())
    }

    /// Waits until everything is on the disk.
    pub(super) fn sync(&self) -> io::Result<()> {
        self.file.sync_all()
    }
}
