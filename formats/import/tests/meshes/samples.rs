//! Files of the tests.

use std::path::{Path, PathBuf};

use dcb_import::mesh::{FoundMesh, ReadMesh, read_mesh};

/// A file of another tool.
pub fn sample(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../../tests/data/exchange")
        .join(name)
}

/// A sample that is read.
pub fn read(name: &str) -> ReadMesh {
    read_mesh(&sample(name)).unwrap_or_else(|error| panic!("{error}"))
}

/// The mesh that a text makes.
pub fn read_text(text: impl AsRef<[u8]>) -> Result<FoundMesh, String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("part");
    std::fs::write(&path, text).unwrap();
    match read_mesh(&path) {
        Ok(read) => Ok(read.mesh),
        Err(error) => Err(error
            .to_string()
            .replace(&path.display().to_string(), "part")),
    }
}

/// Labels of nodes that are named by their places.
pub fn labels(mesh: &FoundMesh, nodes: &[u32]) -> Vec<u32> {
    let all = mesh.labels.as_ref().unwrap();
    nodes.iter().map(|node| all[*node as usize]).collect()
}

/// Labels of the nodes of a set.
pub fn set(mesh: &FoundMesh, name: &str) -> Vec<u32> {
    let all = mesh.sets.iter().chain(&mesh.cell_sets);
    let names: Vec<&str> = all.clone().map(|(name, _)| name.as_str()).collect();
    match all.clone().find(|(known, _)| known == name) {
        Some((_, nodes)) => labels(mesh, nodes),
        None => panic!("no set {name} in {names:?}"),
    }
}
