//! The files of a component by their roles, and their digests.

use std::path::PathBuf;

use rayon::iter::{IntoParallelIterator, ParallelIterator};

use super::{ComponentFiles, file_name};
use crate::component::{ComponentMasses, Source};
use crate::error::Error;
use crate::mesh::Dimension;
use crate::snapshot::Snapshot;

impl ComponentFiles {
    /// Names and SHA-256 of every file, without reading what is in it: those of [`ComponentDraft::sources`](crate::component::ComponentDraft::sources), and of component masses that
    /// its dimension has no use for.
    ///
    /// # Errors
    /// As [`Snapshot::open`] and [`Snapshot::finish`].
    pub fn sources(&self) -> Result<Vec<Source>, Error> {
        self.by_role()
            .into_par_iter()
            .map(|(role, path)| {
                let sha256 = Snapshot::open(&path)?.finish()?;
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
        let names = ComponentMasses::names(Dimension::Spatial);
        let masses = (names.iter())
            .zip(self.component_masses(names))
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
            .chain(further("stress", &self.stresses))
            .chain(further("stiffening", &self.stiffening))
            .collect()
    }
}
