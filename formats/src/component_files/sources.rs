//! The files of a component by their roles, and their digests.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};

use rayon::iter::{IntoParallelIterator, ParallelIterator};

use super::{ComponentFiles, SPATIAL_MASSES, file_name};
use crate::component::Source;
use crate::dcb::digest::Hash;
use crate::error::Error;

/// Bytes of a file that are hashed together.
const HASHED_AT_ONCE: usize = 1 << 20;

impl ComponentFiles {
    /// Names and SHA-256 of every file, without reading what is in it: those of [`Component::sources`](crate::Component::sources), and of component masses that
    /// its dimension has no use for.
    ///
    /// # Errors
    /// [`Error::Io`] for a file that can't be read.
    pub fn sources(&self) -> Result<Vec<Source>, Error> {
        self.by_role()
            .into_par_iter()
            .map(|(role, path)| {
                let sha256 = sha256(&path).map_err(|source| Error::Io {
                    path: path.clone(),
                    action: "cannot read",
                    source,
                })?;
                Ok(Source {
                    role,
                    file_name: file_name(&path),
                    sha256,
                })
            })
            .collect()
    }

    pub(super) fn by_role(&self) -> Vec<(String, PathBuf)> {
        let named = [
            ("stiffness", Some(&self.stiffness)),
            ("mass", Some(&self.mass)),
            ("mesh", Some(&self.description)),
            ("boundary", self.boundary.as_ref()),
        ];
        let masses = SPATIAL_MASSES
            .into_iter()
            .zip(self.component_masses(&SPATIAL_MASSES))
            .filter(|(_, path)| path.exists())
            .map(|(name, path)| (format!("mass.{name}"), path));
        let further = |kind: &'static str, files: &[(String, PathBuf)]| {
            let role =
                move |(name, path): &(String, PathBuf)| (format!("{kind}.{name}"), path.clone());
            files.iter().map(role).collect::<Vec<_>>()
        };
        named
            .into_iter()
            .filter_map(|(role, path)| Some((role.to_owned(), path?.clone())))
            .chain(masses)
            .chain(further("load", &self.loads))
            .chain(further("stiffening", &self.stiffening))
            .collect()
    }
}

/// SHA-256 of a file, hexadecimal.
fn sha256(path: &Path) -> std::io::Result<String> {
    let mut file = File::open(path)?;
    let mut hash = Hash::default();
    let mut buffer = vec![0; HASHED_AT_ONCE];
    loop {
        match file.read(&mut buffer)? {
            0 => return Ok(hash.finish()),
            count => hash.update(&buffer[..count]),
        }
    }
}
