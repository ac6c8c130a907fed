//! The folder of the repository has what a stranger expects there, and nothing else.

use std::collections::BTreeSet;
use std::process::Command;

use super::root;

/// Everything at the top, hidden files of tools included.
const EXPECTED: [&str; 15] = [
    ".ci",
    ".gitignore",
    "CITATION.cff",
    "Cargo.lock",
    "Cargo.toml",
    "LICENSE-APACHE",
    "LICENSE-MIT",
    "README.md",
    "docs",
    "formats",
    "python",
    "reducer",
    "runtime",
    "samples",
    "tests",
];

#[test]
fn nothing_unexpected_lies_at_the_top() {
    let listed = Command::new("git")
        .args(["-c", "safe.directory=*", "ls-files", "--full-name"])
        .current_dir(root())
        .output();
    // A copy without its history has no list.
    let Some(listed) = listed.ok().filter(|listed| listed.status.success()) else {
        return;
    };
    let listed = String::from_utf8(listed.stdout).unwrap();
    let top = listed.lines().map(|path| path.split('/').next().unwrap());
    let unexpected: BTreeSet<&str> = top.filter(|name| !EXPECTED.contains(name)).collect();
    assert!(unexpected.is_empty(), "{unexpected:?}");
}
