//! Meshes in JSON, in the layout of component files, with or without the key `component`.

use std::path::Path;

use dcb_formats::Error;
use dcb_formats::description::{JsonMesh, read_json_mesh};
use dcb_formats::mesh::Mesh;

use super::FoundMesh;

/// Whether a text is a JSON object.
pub(crate) fn recognises(start: &[u8]) -> bool {
    let text = start.strip_prefix(b"\xef\xbb\xbf").unwrap_or(start);
    text.trim_ascii_start().starts_with(b"{")
}

/// Reads a mesh.
///
/// # Errors
/// As [`read_json_mesh`].
pub(crate) fn read(path: &Path) -> Result<(FoundMesh, String), Error> {
    Ok(match read_json_mesh(path)? {
        JsonMesh::Component(file) => (found(&file.mesh, file.notes), file.sha256),
        JsonMesh::Alone {
            mesh,
            sha256,
            notes,
        } => (found(&mesh, notes), sha256),
    })
}

/// Nodes without labels; the third coordinate of planar ones is 0.
pub(crate) fn found(mesh: &Mesh, notes: Vec<String>) -> FoundMesh {
    FoundMesh {
        points: (0..mesh.node_count() as u32)
            .map(|node| mesh.position(node))
            .collect(),
        cells: mesh.cells.clone(),
        sets: mesh.point_sets.clone().into_iter().collect(),
        notes,
        ..FoundMesh::default()
    }
}
