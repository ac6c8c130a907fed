//! The instantiation token: it ties a model description to the scene and the superelements that it was made of.

use dcb_runtime::model::LoadedFile;
use sha2::{Digest, Sha256};

/// Marks libraries and programs that make the same variables of the same scene. It stands in the library as text, so that a program can see
/// whether a library is the one that belongs to it.
pub const MARK: &str = concat!(
    "dcb co-simulation unit, ",
    env!("CARGO_PKG_VERSION"),
    ", variables 1"
);

/// The token of a scene, as its text stands, and the superelements that it names.
pub(crate) fn token(scene: &str, files: &[LoadedFile]) -> String {
    let mut hash = Sha256::new();
    for part in [MARK, scene]
        .into_iter()
        .chain(files.iter().map(|file| file.digest.as_str()))
    {
        hash.update((part.len() as u64).to_le_bytes());
        hash.update(part.as_bytes());
    }
    hexadecimal(&hash.finalize())
}

fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}
