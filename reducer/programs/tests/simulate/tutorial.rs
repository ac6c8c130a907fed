//! `docs/tutorial.md`: its commands run in their order, and its change of the scene does what it says.

use std::fs;

use crate::printed::{Block, blocks, shell};
use crate::support::{Folder, stored};

#[test]
fn the_tutorial_runs_as_it_is_printed() {
    let page = fs::read_to_string(stored("docs/tutorial.md")).unwrap();
    let folder = Folder::empty();
    let all = blocks(&page);
    // Nothing but commands: what a reader is to type is run.
    assert!(all.iter().all(|block| block.language == "sh"));
    // The first builds the programs.
    assert!(all[0].text.contains(".ci/setup build"));
    for Block { text, .. } in &all[1..] {
        let said = shell(&folder.path(""), text);
        assert!(said.is_good, "{text}\n{}", said.text);
        assert!(!said.text.contains("warning"), "{}", said.text);
    }
    for made in [
        "arm.html",
        "tip.svg",
        "tip.csv",
        "upper-arm.html",
        "driven.html",
    ] {
        assert!(folder.path(made).is_file(), "{made}");
    }
    // From the hinge of the elbow, which turns by 1.2 rad against the upper arm, to the tip: closer to the first hinge than a straight arm.
    let table = folder.read("driven.csv");
    let names: Vec<&str> = table.lines().next().unwrap().split(',').collect();
    let last: Vec<f64> = table
        .lines()
        .last()
        .unwrap()
        .split(',')
        .map(|number| number.parse().unwrap())
        .collect();
    let at = |name: &str| {
        last[names
            .iter()
            .position(|column| column.starts_with(name))
            .unwrap()]
    };
    let reach = at("tip.x").hypot(at("tip.z"));
    let expected = (0.6_f64.powi(2) + 0.5_f64.powi(2) + 2.0 * 0.6 * 0.5 * 1.2_f64.cos()).sqrt();
    assert!((reach / expected - 1.0).abs() < 0.01, "{reach} {expected}");
}
