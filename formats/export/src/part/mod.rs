//! The superelement that is exported.

pub(crate) mod basis;
pub(crate) mod frames;
pub(crate) mod left_out;
mod names;
pub(crate) mod primal;

use std::path::{Path, PathBuf};

use dcb_formats::component::Role;
use dcb_formats::dcb::SuperelementFile;
use dcb_formats::mesh::{Dimension, Mesh};
use dcb_formats::{Error, RecoveryBasis, Superelement};

use crate::Request;
use crate::part::basis::Basis;
use crate::part::frames::{Frame, frames};
use crate::part::names::listed;

/// A superelement's file, open.
#[derive(Debug)]
pub struct Source {
    path: PathBuf,
    file: SuperelementFile,
    superelement: Superelement,
}

impl Source {
    /// Opens one, and reads all but the nodal fields.
    ///
    /// # Errors
    /// As [`SuperelementFile::open`] and [`SuperelementFile::for_dynamics`].
    pub fn open(path: &Path) -> Result<Self, Error> {
        let file = SuperelementFile::open(path)?;
        let superelement = file.for_dynamics()?;
        Ok(Self {
            path: path.to_owned(),
            file,
            superelement,
        })
    }

    /// The superelement.
    pub fn superelement(&self) -> &Superelement {
        &self.superelement
    }

    /// Its file.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Its digest.
    pub(crate) fn digest(&self) -> &str {
        self.file.digest()
    }

    /// Whether it has nodal fields.
    pub(crate) fn has_fields(&self) -> Result<bool, Error> {
        Ok(self.file.recovery_of(&[])?.is_some())
    }

    /// Nodal fields and mesh, where it has both.
    pub(crate) fn fields(&self) -> Result<Option<(RecoveryBasis, Mesh)>, Error> {
        let fields = self.file.recovery()?;
        Ok(fields.zip(self.file.mesh()?))
    }

    /// Refuses it.
    pub(crate) fn refused(&self, message: String) -> Error {
        Error::File {
            path: self.path.clone(),
            message,
        }
    }

    /// Where it comes from, in one line of plain letters.
    pub(crate) fn origin_line(&self) -> String {
        let name: String = self.superelement.name.chars().map(printable).collect();
        let units = &self.superelement.units;
        let units = [&units.length, &units.mass, &units.time]
            .map(String::as_str)
            .join(" ");
        let units: String = units.chars().map(printable).collect();
        format!(
            "{name}, units {units}, from a superelement with digest {}",
            self.digest()
        )
    }
}

/// Letters that every program reads.
fn printable(character: char) -> char {
    match character {
        ' '..='~' => character,
        _ => '_',
    }
}

/// A spatial superelement over its strong coordinates.
pub(crate) struct Part<'a> {
    pub source: &'a Source,
    pub superelement: &'a Superelement,
    pub basis: Basis,
    pub frames: Vec<Frame>,
    /// Rows that have no place.
    pub placeless: Vec<usize>,
}

impl<'a> Part<'a> {
    /// Of a source for a target that knows space only.
    ///
    /// # Errors
    /// [`Error::File`] for a planar part, or one without coordinates.
    pub(crate) fn spatial(source: &'a Source, request: &Request<'_>) -> Result<Self, Error> {
        let superelement = &source.superelement;
        if superelement.dimension == Dimension::Planar {
            return Err(source.refused(format!(
                "is the planar part {:?}, and `{}` takes spatial parts only; reduce a spatial model of it",
                superelement.name, request.target.name
            )));
        }
        let basis = Basis::of(superelement, request.axes)
            .map_err(|error| source.refused(error.to_string()))?;
        let (frames, placeless) = frames(superelement, request.axes);
        Ok(Self {
            source,
            superelement,
            basis,
            frames,
            placeless,
        })
    }

    /// Refuses it.
    pub(crate) fn refused(&self, message: String) -> Error {
        self.source.refused(message)
    }

    /// Coordinates, for people.
    pub(crate) fn coordinates(&self) -> String {
        let modes = self.basis.mode_count;
        let others = self.basis.count() - modes;
        format!("{modes} free modes and {others} attachments")
    }

    /// Frames that become nodes, and what is to be known of them.
    pub(crate) fn nodes(&self) -> Result<(Vec<&Frame>, Vec<String>), Error> {
        let mut notes = Vec::new();
        let mut nodes = Vec::new();
        for frame in &self.frames {
            let missing = frame.missing().join(", ");
            match (frame.has_translations(), frame.role) {
                (true, _) => nodes.push(frame),
                (false, Role::Attachment) => {
                    return Err(self.refused(format!(
                        "interface {:?} has no row for {missing}, and this target wants all displacements of its nodes; reduce it with that interface as `average` or `rigid`, without `dofs`",
                        frame.name
                    )));
                }
                (false, Role::Output) => notes.push(format!(
                    "interface {:?} has no row for {missing}: it stays out",
                    frame.name
                )),
            }
            if frame.has_translations() && !missing.is_empty() {
                notes.push(format!("interface {:?} has no row for {missing}: there it turns with the body frame alone; use it where nothing holds its rotation", frame.name));
            }
        }
        let element = self.superelement;
        let placeless: Vec<String> = self
            .placeless
            .iter()
            .map(|row| element.row_name(*row))
            .collect();
        let is_loaded = |row: &&usize| {
            element.interfaces[element.rows[**row].interface].role == Role::Attachment
        };
        if self.placeless.iter().any(|row| is_loaded(&row)) {
            return Err(self.refused(format!(
                "has rows without a place, {}, and this target wants nodes; reduce it with interfaces of kind `nodes`, `average` or `rigid`",
                listed(&placeless)
            )));
        }
        if !placeless.is_empty() {
            notes.push(format!(
                "rows without a place stay out: {}",
                listed(&placeless)
            ));
        }
        match nodes.is_empty() {
            true => Err(self.refused(
                "has no interface with displacements along x, y and z: there is nothing to attach to"
                    .to_owned(),
            )),
            false => Ok((nodes, notes)),
        }
    }
}
