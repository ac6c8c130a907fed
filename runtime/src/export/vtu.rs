//! Nodal fields as VTK files, for ParaView: one `BODY_000000.vtu` (unstructured grid) for each time shown, and
//! `BODY.pvd`, which gives the files their times.
//!
//! What an interrupted run has written can be opened: the
//! `.pvd` lists finished files only, and each file is written whole or not at all.

use std::fs::File;
use std::io::{self, Seek as _, SeekFrom, Write};
use std::path::{Path, PathBuf};

use dcb_formats::mesh::Mesh;
use dcb_formats::output::{Replace, UnfinishedFolder};
use dcb_formats::vtk::{Cells, Grid, Numbers};
use nalgebra::Vector3;
use quick_xml::Writer;

use crate::error::Error;

/// A body at one time.
#[derive(Clone, Debug, PartialEq)]
pub struct FieldSnapshot<'a> {
    /// Time, in the scene's unit.
    pub time: f64,
    /// Where the nodes are drawn, world axes: deformed, or moved by the frame alone.
    pub positions_world: &'a [Vector3<f64>],
    /// Vectors at the nodes with their names, world axes.
    pub vectors: &'a [(&'a str, &'a [Vector3<f64>])],
    /// Numbers at the nodes.
    pub numbers: &'a [Numbers<'a>],
    /// Marks at the nodes with their names.
    pub marks: &'a [(&'a str, &'a [u8])],
}

/// The files of one body.
#[derive(Debug)]
pub struct FieldSeries {
    body: String,
    folder: PathBuf,
    stem: String,
    node_count: usize,
    cells: Cells,
    replace: Replace,
    unfinished: UnfinishedFolder,
    list: File,
    list_path: PathBuf,
    /// Where the next entry of the list goes: over the tags that end it.
    entry_at: u64,
    written: usize,
}

const LIST_START: &str =
    "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\">\n<Collection>\n";
const LIST_END: &str = "</Collection>\n</VTKFile>\n";

impl FieldSeries {
    /// Starts the list of a body's files in a folder that exists.
    ///
    /// # Errors
    /// [`Error::Field`] for cells that VTK has no type for; [`Error::File`] for a list that is there and may not be replaced, and
    /// where the system refuses, also on a full disk.
    pub fn create(folder: &Path, body: &str, mesh: &Mesh, replace: Replace) -> Result<Self, Error> {
        let cells = Cells::of(mesh).map_err(|message| Error::Field {
            body: body.to_owned(),
            message,
        })?;
        let stem = file_stem(body);
        let list_path = Self::list_path(folder, body);
        let list_name = list_path.file_name().unwrap_or_default();
        let unfinished = UnfinishedFolder::within(folder, list_name)
            .map_err(|source| cannot_write(&list_path, source))?;
        let mut list = None;
        unfinished.write(&list_path, replace, |_, mut file| {
            let text = [LIST_START, LIST_END].concat();
            let started = file
                .write_all(text.as_bytes())
                .and_then(|()| file.try_clone());
            list = Some(started.map_err(|source| {
                dcb_formats::Error::not_written(&list_path, text.len() as u64, source)
            })?);
            Ok(())
        })?;
        let list = list.ok_or_else(|| cannot_write(&list_path, io::Error::other("no file")))?;
        Ok(Self {
            body: body.to_owned(),
            folder: folder.to_owned(),
            stem,
            node_count: mesh.node_count(),
            cells,
            replace,
            unfinished,
            list,
            list_path,
            entry_at: LIST_START.len() as u64,
            written: 0,
        })
    }

    /// The list of a body's files.
    pub fn list_path(folder: &Path, body: &str) -> PathBuf {
        folder.join(format!("{}.pvd", file_stem(body)))
    }

    /// Files of a body that are in a folder already, list included.
    pub fn existing(folder: &Path, body: &str) -> Vec<PathBuf> {
        let stem = file_stem(body);
        let is_picture = |name: &str| {
            let number = (name.strip_prefix(&stem))
                .and_then(|rest| rest.strip_prefix('_')?.strip_suffix(".vtu"));
            number.is_some_and(|digits| {
                digits.len() >= 6 && digits.bytes().all(|digit| digit.is_ascii_digit())
            })
        };
        let listing = std::fs::read_dir(folder).into_iter().flatten().flatten();
        let pictures = listing.map(|entry| entry.path()).filter(|path| {
            path.file_name()
                .is_some_and(|name| is_picture(&name.to_string_lossy()))
        });
        let list = Self::list_path(folder, body);
        let list = list.symlink_metadata().is_ok().then_some(list);
        list.into_iter().chain(pictures).collect()
    }

    /// Writes the file of one time, then lists it. Returns its path.
    ///
    /// # Errors
    /// [`Error::Field`] if something isn't given for every node; [`Error::File`] where the system refuses, also on a full disk.
    pub fn write(&mut self, snapshot: &FieldSnapshot) -> Result<PathBuf, Error> {
        let positions = ("positions", snapshot.positions_world.len());
        let vectors = snapshot.vectors.iter().map(|(name, of)| (*name, of.len()));
        let marks = snapshot.marks.iter().map(|(name, of)| (*name, of.len()));
        let numbers =
            (snapshot.numbers.iter()).map(|of| (of.name, of.values.len() / of.count.max(1)));
        let mut all = std::iter::once(positions)
            .chain(vectors)
            .chain(numbers)
            .chain(marks);
        if let Some((name, count)) = all.find(|(_, count)| *count != self.node_count) {
            return Err(Error::Field {
                body: self.body.clone(),
                message: format!(
                    "{name:?} is given for {count} nodes, but the mesh has {}",
                    self.node_count
                ),
            });
        }
        let name = format!("{}_{:06}.vtu", self.stem, self.written);
        let path = self.folder.join(&name);
        let grid = Grid {
            cells: &self.cells,
            points: snapshot.positions_world,
            vectors: snapshot.vectors,
            numbers: snapshot.numbers,
            marks: snapshot.marks,
        };
        self.unfinished
            .write_stream(&path, self.replace, |out| grid.write(out))?;
        self.list(&name, snapshot.time).map_err(|source| {
            dcb_formats::Error::not_written(&self.list_path, self.entry_at, source)
        })?;
        self.written += 1;
        Ok(path)
    }

    fn list(&mut self, name: &str, time: f64) -> io::Result<()> {
        let mut entry = Writer::new(Vec::new());
        entry
            .create_element("DataSet")
            .with_attribute(("timestep", format!("{time:?}").as_str()))
            .with_attribute(("file", name))
            .write_empty()?;
        let mut text = entry.into_inner();
        text.push(b'\n');
        let next = self.entry_at + text.len() as u64;
        text.extend_from_slice(LIST_END.as_bytes());
        self.list.seek(SeekFrom::Start(self.entry_at))?;
        if let Err(error) = self.list.write_all(&text) {
            // The list as it was has its room already.
            self.list.seek(SeekFrom::Start(self.entry_at))?;
            self.list.write_all(LIST_END.as_bytes())?;
            self.list.set_len(self.entry_at + LIST_END.len() as u64)?;
            return Err(error);
        }
        self.entry_at = next;
        Ok(())
    }
}

/// A file name for a body of any name: letters, digits, `-`, `_` and inner dots stay, everything else becomes `~` and
/// its code, so that different bodies have different files.
fn file_stem(body: &str) -> String {
    if body.is_empty() {
        return "~".to_owned();
    }
    let mut stem = String::with_capacity(body.len());
    for (at, character) in body.char_indices() {
        let is_plain = character.is_ascii_alphanumeric()
            || matches!(character, '-' | '_')
            || (character == '.' && at > 0);
        if is_plain {
            stem.push(character);
        } else {
            stem += &format!("~{:x}~", character as u32);
        }
    }
    stem
}

fn cannot_write(path: &Path, source: io::Error) -> Error {
    Error::CannotWrite {
        path: path.to_owned(),
        source,
    }
}

#[cfg(test)]
mod tests {
    use super::file_stem;

    #[test]
    fn different_bodies_have_different_files_inside_the_folder() {
        let names = [
            "rod", "a/b", "a_b", "a~2f~b", "..", ".", "", "~", "über", "a b",
        ];
        let stems: std::collections::BTreeSet<_> =
            names.iter().map(|name| file_stem(name)).collect();
        assert_eq!(stems.len(), names.len());
        for stem in stems {
            assert!(
                !stem.starts_with('.') && !stem.contains(['/', '\\', ' ']),
                "{stem}"
            );
        }
        assert_eq!(file_stem("rod-2.left"), "rod-2.left");
    }
}
