//! Meshes of Gmsh (`.msh`), versions 2 and 4.1, text and binary of both byte orders; physical groups become sets.
//!
//! Partitions are put together again, periodic links, ghosts and data left out.

mod element_types;
mod groups;
mod source;
mod version2;
mod version4;

use std::path::Path;

use dcb_formats::Error;

use super::FoundMesh;
use super::cells::Cells;
use super::node_sets::Marks;
use super::nodes::Nodes;
use element_types::{ElementType, element_type};
use groups::Groups;
use source::{Encoding, Source};

/// Whether a file begins as such a mesh does.
pub(crate) fn recognises(start: &[u8]) -> bool {
    let start = start.trim_ascii_start();
    let names: [&[u8]; 4] = [b"$MeshFormat", b"$Comments", b"$PhysicalNames", b"$NOD"];
    names.iter().any(|name| start.starts_with(name))
}

/// Reads a mesh.
///
/// # Errors
/// [`Error::Line`] or [`Error::File`] for what can't be read, [`Error::Location`] for elements and nodes that don't fit each other.
pub(crate) fn read(path: &Path) -> Result<(FoundMesh, String), Error> {
    let (mut source, sha256) = Source::open(path)?;
    let mut model = Model::default();
    let mut version = None;
    while let Some(name) = source.section()? {
        match (name.as_str(), version) {
            ("MeshFormat", None) => version = Some(format(&mut source)?),
            ("NOD", _) => return Err(other_version(&source, "1")),
            ("PhysicalNames", _) => model.physical_names(&mut source)?,
            ("Nodes", Some(Version::Two)) => version2::nodes(&mut source, &mut model)?,
            ("ParametricNodes", Some(Version::Two)) => {
                version2::parametric_nodes(&mut source, &mut model)?
            }
            ("Elements", Some(Version::Two)) => version2::elements(&mut source, &mut model)?,
            ("Entities", Some(Version::Four)) => version4::entities(&mut source, &mut model)?,
            ("PartitionedEntities", Some(Version::Four)) => {
                version4::partitioned_entities(&mut source, &mut model)?
            }
            ("Nodes", Some(Version::Four)) => version4::nodes(&mut source, &mut model)?,
            ("Elements", Some(Version::Four)) => version4::elements(&mut source, &mut model)?,
            ("Nodes" | "Elements", None) => return Err(source.refused("has no $MeshFormat before")),
            _ => {
                source.skip_section(&name)?;
                continue;
            }
        }
        source.end_section(&name)?;
    }
    let mesh = model.finish(path, source.len())?;
    Ok((mesh, sha256))
}

/// Layouts of the sections.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Version {
    Two,
    Four,
}

/// `4.1 1 8`, and in binary files the number 1.
fn format(source: &mut Source) -> Result<Version, Error> {
    let line = source.line().unwrap_or_default();
    let text = String::from_utf8_lossy(line).into_owned();
    let words: Vec<&str> = text.split_ascii_whitespace().collect();
    let [version, file_type, size] = words[..] else {
        return Err(source.refused("expected the version, 0 or 1 for text or binary, and 8"));
    };
    // NGSolve writes 2.000000.
    let layout = match version.parse::<f64>() {
        Ok(number) if (2.0..3.0).contains(&number) => Version::Two,
        Ok(4.1) => Version::Four,
        _ => return Err(other_version(source, version)),
    };
    match (file_type, size) {
        ("0", _) => {}
        ("1", "4" | "8") => {
            let order = source.byte_order()?;
            let size = if size == "4" { 4 } else { 8 };
            source.encoding = Encoding::Binary { order, size };
        }
        _ => {
            return Err(source.refused(format!(
                "{} {}; expected 0 or 1 for text or binary, and 8 bytes a number",
                super::fields::shown(file_type.as_bytes()),
                super::fields::shown(size.as_bytes())
            )));
        }
    }
    Ok(layout)
}

fn other_version(source: &Source, version: &str) -> Error {
    source.refused(format!(
        "version {} of .msh isn't read; save it as 4.1: gmsh FILE -save -format msh41 -o part.msh",
        super::fields::shown(version.as_bytes())
    ))
}

/// A mesh as far as it is read.
#[derive(Default)]
struct Model {
    nodes: Nodes,
    cells: Cells,
    groups: Groups,
    entities: version4::Entities,
    seen: version2::Seen,
    /// Elements of a type that stands only by its number.
    nameless: usize,
}

impl Model {
    /// `dimension number "name"`, as text in binary files too.
    fn physical_names(&mut self, source: &mut Source) -> Result<(), Error> {
        let line = source.line().unwrap_or_default();
        let count = super::fields::integer(line).map_err(|message| source.refused(message))?;
        for _ in 0..count {
            let line = String::from_utf8_lossy(source.line().unwrap_or_default()).into_owned();
            let mut parts = line.splitn(3, ' ').map(str::trim);
            let (dimension, number, name) = (parts.next(), parts.next(), parts.next());
            let dimension = dimension
                .and_then(|text| text.parse().ok())
                .filter(|d| *d <= 3);
            let number = number.and_then(|text| text.parse().ok());
            let name = name.and_then(|text| text.strip_prefix('"')?.strip_suffix('"'));
            let (Some(dimension), Some(number), Some(name)) = (dimension, number, name) else {
                return Err(
                    source.refused("expected dimension, number and \"name\" of a physical group")
                );
            };
            let name = name.trim();
            if !name.is_empty() && !name.contains(char::is_control) {
                self.groups.name((dimension, number), name.to_owned());
            }
        }
        Ok(())
    }

    /// The block of an element type.
    fn block(&mut self, number: i64, kind: &ElementType) -> usize {
        match kind.cell {
            Some(cell) => self.cells.block(cell, kind.nodes),
            None => self.cells.block(&format!("gmsh_type_{number}"), kind.nodes),
        }
    }

    /// Reads the nodes of an element and makes a cell of it.
    fn cell(&mut self, block: usize, label: u32, nodes: &[u32], kind: &ElementType) {
        self.nameless += usize::from(kind.cell.is_none());
        match kind.order {
            Some(order) => (self.cells).push(block, label, order.iter().map(|at| nodes[*at])),
            None => self.cells.push(block, label, nodes.iter().copied()),
        }
    }

    fn finish(mut self, path: &Path, bytes: u64) -> Result<FoundMesh, Error> {
        let mut mesh = FoundMesh::default();
        let index = self.nodes.indexed(path, &mut mesh.notes)?;
        self.cells.tie(path, &index)?;
        let mut marks = Marks::new(self.nodes.labels.len(), bytes);
        (self.groups.into_sets(&self.cells, &mut marks, &mut mesh)).map_err(|error| {
            Error::File {
                path: path.into(),
                message: error.message(),
            }
        })?;
        if self.seen.has_repeats() {
            self.cells.drop_repeated();
        }
        if self.nameless > 0 {
            mesh.notes.push(format!(
                "{} elements are of high order: kept with Gmsh's own order of their nodes",
                self.nameless
            ));
        }
        mesh.points = self.nodes.points;
        mesh.labels = Some(self.nodes.labels);
        mesh.cells = self.cells.finish();
        Ok(mesh)
    }
}

/// A known element type.
fn known_type(source: &Source, number: i64) -> Result<ElementType, Error> {
    element_type(number).ok_or_else(|| {
        source.refused(format!(
            "element type {number} isn't known; save the mesh with elements of first or second order"
        ))
    })
}

/// Nodes of the largest element.
const MOST_NODES: usize = 125;
