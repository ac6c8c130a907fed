//! The mesh of a part, with the file that it comes from.

use std::path::{Path, PathBuf};

use dcb_formats::component::Source;
use dcb_formats::description::{JsonMesh, read_json_mesh};
use dcb_formats::{Description, Error};

use crate::mesh::{FoundMesh, MeshFormat, ReadMesh, json, read_mesh};
use crate::source::matrices::source;
use crate::source::matrix_file::beginning;

/// A mesh, and what its file says besides.
pub(crate) struct PartMesh {
    pub found: FoundMesh,
    /// Name of the format.
    pub format: String,
    /// Of a component file: units, dofs, interfaces, damping.
    pub description: Option<Description>,
    /// Of the file, and of those that it includes.
    pub sources: Vec<Source>,
}

impl PartMesh {
    /// Reads a mesh of any format, or a component file.
    ///
    /// # Errors
    /// What is wrong with the file.
    pub fn read(path: &Path) -> Result<Self, Error> {
        if !is_json(path)? {
            let ReadMesh {
                format,
                mesh,
                sha256,
            } = read_mesh(path)?;
            let of_mesh = source("mesh", path, &sha256);
            let included = mesh.included.iter().zip(1..);
            let included = included.map(|((name, sha256), number)| Source {
                role: format!("mesh.include.{number}"),
                file_name: name.clone(),
                sha256: sha256.clone(),
            });
            return Ok(Self {
                sources: [of_mesh].into_iter().chain(included).collect(),
                format: format.to_string(),
                description: None,
                found: mesh,
            });
        }
        let description = match read_json_mesh(path)? {
            JsonMesh::Component(description) => description,
            JsonMesh::Alone {
                mesh,
                sha256,
                notes,
            } => {
                return Ok(Self {
                    found: json::found(&mesh, notes),
                    format: MeshFormat::Json.to_string(),
                    description: None,
                    sources: vec![source("mesh", path, &sha256)],
                });
            }
        };
        let found = json::found(&description.mesh, description.notes.clone());
        Ok(Self {
            found,
            format: "component file".into(),
            sources: vec![source("mesh", path, &description.sha256)],
            description: Some(*description),
        })
    }
}

impl PartMesh {
    /// A mesh that no file has.
    pub fn without_file(found: FoundMesh) -> Self {
        Self {
            found,
            format: "none".into(),
            description: None,
            sources: Vec::new(),
        }
    }
}

/// Endings of meshes that stand beside a stiffness file of the same stem, in the order in which they are looked for. A deck has the labels of its
/// nodes, which tie rows to nodes; a component file, one drafted from that deck for example, has lost them.
const ENDINGS: [&str; 2] = ["inp", "json"];

/// Meshes beside a stiffness file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct MeshBeside {
    /// The one to read: the deck `part.inp`, or `part.json`.
    pub path: PathBuf,
    /// Another that is there, and isn't read.
    pub unread: Option<PathBuf>,
}

/// The mesh beside a stiffness file: the deck `part.inp`, or `part.json`.
pub fn mesh_beside(stiffness: &Path) -> Option<MeshBeside> {
    let paths = ENDINGS
        .iter()
        .map(|ending| stiffness.with_extension(ending));
    let mut found = paths.filter(|path| path.exists());
    let path = found.next()?;
    let unread = found.next();
    Some(MeshBeside { path, unread })
}

/// Whether a file is JSON, as component files are, and meshes in their layout.
///
/// # Errors
/// It can't be read.
pub fn is_json(path: &Path) -> Result<bool, Error> {
    Ok(json::recognises(&beginning(path)?))
}
