//! The mesh of a part, with the file that it comes from.

use std::io::Read;
use std::path::{Path, PathBuf};

use dcb_formats::component::Source;
use dcb_formats::description::{JsonMesh, read_json_mesh};
use dcb_formats::snapshot::Snapshot;
use dcb_formats::{Description, Error};

use crate::matrix_file::beginning;
use crate::mesh::{FoundMesh, MeshFormat, ReadMesh, json, read_mesh};
use crate::source_files::source;

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
        if !is_component_file(path)? {
            let ReadMesh {
                format,
                mesh,
                sha256,
            } = read_mesh(path)?;
            let of_mesh = source("mesh", path, &sha256);
            let included = mesh.included.iter().map(|(name, sha256)| Source {
                role: "mesh.include".into(),
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

/// Endings of meshes that stand beside a stiffness file of the same stem, in the order in which they are looked for.
const ENDINGS: [&str; 2] = ["json", "inp"];

/// The mesh beside a stiffness file: `part.json`, or the deck `part.inp`.
pub fn mesh_beside(stiffness: &Path) -> Option<PathBuf> {
    let paths = ENDINGS
        .iter()
        .map(|ending| stiffness.with_extension(ending));
    paths.into_iter().find(|path| path.exists())
}

/// Whether a file is a component file: JSON with the key `component`.
///
/// # Errors
/// It can't be read.
pub fn is_component_file(path: &Path) -> Result<bool, Error> {
    const KEY: &[u8] = b"\"component\"";
    const READ_TOGETHER: usize = 1 << 16;
    if !beginning(path)?.trim_ascii_start().starts_with(b"{") {
        return Ok(false);
    }
    let mut file = Snapshot::open(path)?;
    let mut window = Vec::with_capacity(READ_TOGETHER + KEY.len());
    loop {
        // The key may begin in what was read before.
        let kept = window.len().min(KEY.len() - 1);
        window.drain(..window.len() - kept);
        let mut part = (&mut file).take(READ_TOGETHER as u64);
        let read = part
            .read_to_end(&mut window)
            .map_err(|source| Error::io(path, "cannot read", source))?;
        if memchr::memmem::find(&window, KEY).is_some() {
            return Ok(true);
        }
        if read == 0 {
            return Ok(false);
        }
    }
}
