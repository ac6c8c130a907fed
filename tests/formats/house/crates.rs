//! Crates know those that docs/architecture.md says, in its order.

use std::collections::BTreeSet;
use std::fs;

use super::{members, root};

#[test]
fn crates_know_what_the_page_says() {
    let page = fs::read_to_string(root().join("docs/architecture.md")).unwrap();
    let rows = page
        .lines()
        .skip_while(|line| !line.starts_with("| crate |"));
    let rows = rows.skip(2).take_while(|line| line.starts_with('|'));
    let mut above: BTreeSet<String> = BTreeSet::new();
    let mut folders = BTreeSet::new();
    for row in rows {
        let cells: Vec<&str> = row.split('|').map(str::trim).collect();
        let [_, folder, _, knows, _] = cells[..] else {
            panic!("{row}: expected three cells");
        };
        let folder = folder.trim_matches('`');
        let said: BTreeSet<String> = knows
            .split('`')
            .skip(1)
            .step_by(2)
            .map(str::to_owned)
            .collect();
        let manifest = fs::read_to_string(root().join(folder).join("Cargo.toml")).unwrap();
        let known = known(&manifest);
        assert_eq!(said, known, "{folder}: the page and Cargo.toml");
        assert!(
            known.is_subset(&above),
            "{folder} knows one below it: {known:?}"
        );
        above.insert(folder.rsplit('/').next().unwrap().to_owned());
        folders.insert(folder.to_owned());
    }
    assert_eq!(folders, members(), "the page and the workspace");
}

/// Crates of this workspace among a crate's dependencies, without `dcb-`.
fn known(manifest: &str) -> BTreeSet<String> {
    let lines = manifest
        .lines()
        .skip_while(|line| *line != "[dependencies]");
    let lines = lines.skip(1).take_while(|line| !line.starts_with('['));
    let names = lines.filter_map(|line| line.strip_prefix("dcb-"));
    names
        .map(|name| name.split(['.', ' ', '=']).next().unwrap().to_owned())
        .collect()
}
