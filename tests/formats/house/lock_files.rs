//! The Python package is built of the same versions as the programs that the tests try.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;

use super::root;

/// Versions of each package in a lock file.
fn versions(path: &str) -> BTreeMap<String, BTreeSet<String>> {
    let text = fs::read_to_string(root().join(path)).unwrap();
    let value = |block: &str, key: &str| {
        let mut lines = block.lines();
        lines.find_map(|line| Some(line.strip_prefix(key)?.trim_matches('"').to_owned()))
    };
    let mut found = BTreeMap::new();
    for block in text.split("[[package]]").skip(1) {
        let (name, version) = (value(block, "name = "), value(block, "version = "));
        let versions: &mut BTreeSet<String> = found.entry(name.unwrap()).or_default();
        versions.insert(version.unwrap());
    }
    found
}

#[test]
fn both_lock_files_have_the_same_versions() {
    let (programs, python) = (versions("Cargo.lock"), versions("python/Cargo.lock"));
    assert!(python.contains_key("pyo3") && programs.len() > 200);
    let others: Vec<&String> = (python.iter())
        .filter(|(name, own)| {
            programs
                .get(*name)
                .is_some_and(|known| !own.is_subset(known))
        })
        .map(|(name, _)| name)
        .collect();
    assert!(
        others.is_empty(),
        "{others:?}: copy Cargo.lock over python/Cargo.lock and build the package once"
    );
}
