//! Readers of meshes, a file each, and what they find.

mod abaqus;
mod cells;
mod deck;
mod fields;
mod gmsh;
pub(crate) mod json;
mod label_sets;
mod nastran;
mod node_sets;
mod node_table;
mod nodes;
mod universal;
mod vtu;

use std::fmt;
use std::path::Path;

use dcb_formats::Error;
use dcb_formats::matrix::blocks::TextBlocks;
use dcb_formats::mesh::CellBlock;
use dcb_formats::snapshot::Snapshot;

use crate::binary::file::is_gzipped;
use crate::stored::RowLabel;
use crate::text::line_blocks::{BYTE_ORDER_MARK, is_utf16};

/// A mesh as a file lists it: nodes in file order. Nodes are named by their place in `points`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FoundMesh {
    /// Coordinates of each node.
    pub points: Vec<[f64; 3]>,
    /// Label of each node, all different; `None` where the format has none.
    pub labels: Option<Vec<u32>>,
    /// Cells in meshio's names and node order, a block for each type.
    pub cells: Vec<CellBlock>,
    /// Named sets of nodes, and the nodes of named faces and edges; in file order, each node once. Sets may be empty.
    pub sets: Vec<(String, Vec<u32>)>,
    /// Nodes of named groups of the part's own cells, such as those of one material: no interfaces unless somebody asks for them by name.
    pub cell_sets: Vec<(String, Vec<u32>)>,
    /// Nodes whose displacements are along axes of their own: three unit vectors, one a row, in the axes of the points.
    pub displacement_axes: Vec<(u32, [[f64; 3]; 3])>,
    /// Points without place that have a row each, by their label.
    pub scalar_points: Vec<u32>,
    /// Rows of matrices that go with this mesh but have no labels, where the file says their order.
    pub rows: Option<Vec<RowLabel>>,
    /// Nodes that move as one rigid body.
    pub rigid_bodies: Vec<RigidBody>,
    /// Nodes that are held in some direction, each once.
    pub held: Vec<u32>,
    /// Nodes of which some direction depends on other nodes, each once: those of rigid bodies, the first ones of equations.
    pub dependent: Vec<u32>,
    /// Files that this one includes: name as it is written there, and SHA-256 of the bytes, hexadecimal.
    pub included: Vec<(String, String)>,
    /// Remarks for the user, a sentence each.
    pub notes: Vec<String>,
}

/// Nodes that a deck makes one rigid body of.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RigidBody {
    /// Dependent nodes, in file order, each once.
    pub nodes: Vec<u32>,
    /// Node that carries the translations.
    pub reference: u32,
    /// Node whose translations stand for the rotations, where the deck names one.
    pub rotation: Option<u32>,
}

impl FoundMesh {
    /// Nodes that no cell has, in file order: reference points, forgotten geometry.
    pub fn nodes_without_cells(&self) -> Vec<u32> {
        let mut is_used = vec![false; self.points.len()];
        for node in self.cells.iter().flat_map(|cells| &cells.nodes) {
            if let Some(is_used) = is_used.get_mut(*node as usize) {
                *is_used = true;
            }
        }
        (0..self.points.len() as u32)
            .filter(|node| !is_used[*node as usize])
            .collect()
    }
}

/// A mesh, and the file that it comes from.
#[derive(Clone, Debug, PartialEq)]
pub struct ReadMesh {
    /// Format, told by the content.
    pub format: MeshFormat,
    /// What the file has.
    pub mesh: FoundMesh,
    /// SHA-256 of the file's bytes, hexadecimal.
    pub sha256: String,
}

/// Formats of meshes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeshFormat {
    /// Input deck of Abaqus or CalculiX.
    Abaqus,
    /// Gmsh, version 2 or 4.1, text or binary.
    Gmsh,
    /// JSON in the layout of component files.
    Json,
    /// I-DEAS universal file.
    Universal,
    /// VTK's unstructured grid in XML.
    Vtu,
    /// Nastran bulk data, with or without case control; punch and assembly files of an external superelement.
    Nastran,
    /// List of nodes, a label and a place on each line.
    NodeTable,
}

impl MeshFormat {
    /// All of them, in the order in which a file is tried.
    pub const ALL: [Self; 7] = [
        Self::Json,
        Self::Gmsh,
        Self::Vtu,
        Self::Universal,
        Self::Abaqus,
        Self::Nastran,
        Self::NodeTable,
    ];

    fn recognises(self, start: &[u8]) -> bool {
        match self {
            Self::Abaqus => abaqus::recognises(start),
            Self::Gmsh => gmsh::recognises(start),
            Self::Json => json::recognises(start),
            Self::Universal => universal::recognises(start),
            Self::Vtu => vtu::recognises(start),
            Self::Nastran => nastran::recognises(start),
            Self::NodeTable => node_table::recognises(start),
        }
    }

    fn read(self, path: &Path) -> Result<(FoundMesh, String), Error> {
        match self {
            Self::Abaqus => abaqus::read(path),
            Self::Gmsh => gmsh::read(path),
            Self::Json => json::read(path),
            Self::Universal => universal::read(path),
            Self::Vtu => vtu::read(path),
            Self::Nastran => nastran::read(path),
            Self::NodeTable => node_table::read(path),
        }
    }
}

impl fmt::Display for MeshFormat {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(match self {
            Self::Abaqus => "Abaqus or CalculiX input deck",
            Self::Gmsh => "Gmsh .msh 2 or 4.1",
            Self::Json => "JSON",
            Self::Universal => "I-DEAS universal file (UNV)",
            Self::Vtu => "VTU",
            Self::Nastran => "Nastran bulk data",
            Self::NodeTable => "list of nodes",
        })
    }
}

/// Beginning of a file that its format is told by.
const LOOKED_AT: usize = 1 << 20;

/// Reads a mesh. Its format is told by its content; the name doesn't matter.
///
/// # Errors
/// [`Error::File`] for a pipe and for an unknown format, with those that are read; [`Error::Io`]; [`Error::Line`], [`Error::Location`] for
/// what is wrong in the file.
pub fn read_mesh(path: &Path) -> Result<ReadMesh, Error> {
    let refused = |message: String| Error::File {
        path: path.into(),
        message,
    };
    if Snapshot::open(path)?.length().is_none() {
        return Err(refused(
            "is a pipe; meshes are read from files, which are looked at twice".into(),
        ));
    }
    let mut text = TextBlocks::open(path)?;
    text.fill_to(LOOKED_AT)?;
    let start = &text.pending()[..text.pending().len().min(LOOKED_AT)];
    let start = start.strip_prefix(BYTE_ORDER_MARK).unwrap_or(start);
    let found = MeshFormat::ALL
        .into_iter()
        .find(|format| format.recognises(start));
    let Some(format) = found else {
        return Err(refused(unknown(start)));
    };
    drop(text);
    if matches!(format, MeshFormat::Gmsh | MeshFormat::Vtu) && is_gzipped(path)? {
        return Err(refused(format!(
            "is gzipped, and {format} is read unpacked only; unpack it first, gunzip FILE"
        )));
    }
    let (mesh, sha256) = format.read(path)?;
    Ok(ReadMesh {
        format,
        mesh,
        sha256,
    })
}

/// Why a file isn't read, and what helps.
fn unknown(start: &[u8]) -> String {
    let names: Vec<String> = (MeshFormat::ALL.iter())
        .map(MeshFormat::to_string)
        .collect();
    let ends = |end: u8| start.contains(&end);
    if is_utf16(start) {
        return "is UTF-16 text; save it as UTF-8 or ASCII".into();
    }
    let what = if start.is_empty() {
        "is empty"
    } else if ends(b'\r') && !ends(b'\n') {
        return "has line ends of a carriage return alone; save it with line ends of Unix or Windows".into();
    } else {
        "is no mesh of a known format"
    };
    format!(
        "{what}; read are: {}. Others become one of these with meshio (`pip install meshio`): meshio convert FILE part.vtu",
        names.join(", ")
    )
}
