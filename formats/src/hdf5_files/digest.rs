//! SHA-256 of datasets and the digest of a whole file, as `docs/format.md` defines them.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use sha2::{Digest as _, Sha256};

use super::attributes::Value;
use super::element::Element;

/// Hash of bytes that come in pieces.
#[derive(Clone, Default)]
pub(crate) struct Hash(Sha256);

impl Hash {
    /// More bytes.
    pub(crate) fn update(&mut self, bytes: &[u8]) {
        self.0.update(bytes);
    }

    /// More reals, little-endian.
    pub(crate) fn update_reals(&mut self, values: &[f64]) {
        // SAFETY: reals have no padding, and any byte is a `u8`.
        self.update(unsafe { bytes_of(values) });
    }

    /// Lower-case hexadecimal digits.
    pub(crate) fn finish(self) -> String {
        hexadecimal(&self.0.finalize())
    }
}

fn hexadecimal(bytes: &[u8]) -> String {
    bytes
        .iter()
        .fold(String::with_capacity(2 * bytes.len()), |mut text, byte| {
            let _ = write!(text, "{byte:02x}");
            text
        })
}

/// Whether contents have the hash that is claimed for them. Built for fuzzing they always have: no mutation could guess it.
pub(crate) fn is_right(claimed: &str, found: &str) -> bool {
    cfg!(fuzzing) || claimed == found
}

/// Hash of reals, little-endian.
pub(crate) fn of_reals(values: &[f64]) -> String {
    let mut hash = Hash::default();
    hash.update_reals(values);
    hash.finish()
}

/// Hash of integers, little-endian.
pub(crate) fn of_integers(values: &[i64]) -> String {
    let mut hash = Hash::default();
    // SAFETY: integers have no padding, and any byte is a `u8`.
    hash.update(unsafe { bytes_of(values) });
    hash.finish()
}

/// Numbers as they are in memory, which is little-endian (see `mod.rs`).
///
/// # Safety
/// `T` has no padding.
unsafe fn bytes_of<T>(values: &[T]) -> &[u8] {
    // SAFETY: the bytes of the slice, borrowed as long as it is; all of them are initialised, as the caller says.
    unsafe { std::slice::from_raw_parts(values.as_ptr().cast(), size_of_val(values)) }
}

/// Hash of strings, joined by line feeds.
pub(crate) fn of_texts(values: &[String]) -> String {
    let mut hash = Hash::default();
    hash.update(values.join("\n").as_bytes());
    hash.finish()
}

/// A dataset as the digest sees it.
#[derive(Clone, Debug)]
pub(crate) struct Line {
    pub(crate) element: Element,
    pub(crate) shape: Vec<usize>,
    pub(crate) sha256: String,
}

/// Attributes by the path of their object, then by name.
pub(crate) type Attributes = BTreeMap<String, BTreeMap<String, Value>>;

/// Whether the digest covers an attribute. Attributes that only people read stay outside.
pub(crate) fn covers(path: &str, is_dataset: bool, name: &str) -> bool {
    match path {
        "/" => name != "digest" && name != "generator",
        "/provenance" => false,
        _ if is_dataset => name != "description" && name != "sha256",
        _ => true,
    }
}

/// The digest of a file: its datasets by path, and the attributes that [`covers`] keeps.
pub(crate) fn of_file(datasets: &BTreeMap<String, Line>, attributes: &Attributes) -> String {
    let mut hash = Hash::default();
    for (path, line) in datasets {
        let sizes: Vec<String> = line.shape.iter().map(ToString::to_string).collect();
        let shape = format!("({})", sizes.join(","));
        hash.update(format!("{path} {} {shape} {}\n", line.element.name(), line.sha256).as_bytes());
    }
    let covered: BTreeMap<&str, BTreeMap<&str, serde_json::Value>> = attributes
        .iter()
        .map(|(path, values)| {
            let kept = values
                .iter()
                .filter(|(name, _)| covers(path, datasets.contains_key(path), name));
            (
                path.as_str(),
                kept.map(|(name, value)| (name.as_str(), value.canonical()))
                    .collect(),
            )
        })
        .filter(|(_, values): &(_, BTreeMap<_, _>)| !values.is_empty())
        .collect();
    // Maps with string keys and values without floats always serialise.
    hash.update(
        serde_json::to_string(&covered)
            .unwrap_or_default()
            .as_bytes(),
    );
    hash.finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hash_is_sha256() {
        let mut hash = Hash::default();
        hash.update(b"abc");
        assert_eq!(
            hash.finish(),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"
        );
    }
}
