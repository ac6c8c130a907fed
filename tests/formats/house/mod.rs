//! Rules that hold in all sources and pages: how they lie in folders, who looks at whom, who writes files, where links lead.

mod book;
mod circles;
mod crates;
mod named_paths;
mod one_writer;
mod top_level;

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

/// The folder of the workspace.
fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// Folders of the crates, as the workspace lists them.
fn members() -> BTreeSet<String> {
    let manifest = fs::read_to_string(root().join("Cargo.toml")).unwrap();
    let members = manifest.split_once("members = [").unwrap().1;
    let members = members.split_once(']').unwrap().0.split(',');
    members
        .map(|name| name.trim().trim_matches('"').to_owned())
        .collect()
}

/// Folders of the crates but this one: its sources are tests.
fn crates() -> BTreeSet<String> {
    let mut found = members();
    assert!(found.remove("tests") && found.len() > 5, "{found:?}");
    found
}

/// Rust files below a folder.
fn sources(folder: &Path) -> Vec<PathBuf> {
    files(folder, "rs")
}

/// Files with an extension below a folder.
fn files(folder: &Path, wanted: &str) -> Vec<PathBuf> {
    let mut all = Vec::new();
    for entry in fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            all.extend(files(&path, wanted));
        } else if path
            .extension()
            .is_some_and(|extension| extension == wanted)
        {
            all.push(path);
        }
    }
    all
}

/// Numbered lines up to the tests, without comments.
fn program(text: &str) -> Vec<(usize, &str)> {
    let lines = text.lines().enumerate();
    let lines = lines.take_while(|(_, line)| {
        !line.starts_with("#[cfg(test)]") && !line.starts_with("#[cfg(all(test")
    });
    lines
        .filter(|(_, line)| !line.trim_start().starts_with("//"))
        .map(|(index, line)| (index + 1, line))
        .collect()
}
