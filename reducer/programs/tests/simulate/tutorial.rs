//! `docs/tutorial.md`: its commands run in their order, and its change of the scene does what it says.

use std::fs;

use crate::printed::{Block, blocks, folder_with_samples, shell};
use crate::support::stored;

#[test]
fn the_tutorial_runs_as_it_is_printed() {
    let page = fs::read_to_string(stored("docs/tutorial.md")).unwrap();
    let folder = folder_with_samples();
    std::os::unix::fs::symlink(stored("tests"), folder.path("tests")).unwrap();
    fs::create_dir(folder.path("tutorial")).unwrap();
    let all = blocks(&page);
    // Nothing but commands: what a reader is to type is run.
    assert!(all.iter().all(|block| block.language == "sh"));
    // The first builds the programs.
    assert!(all[0].text.contains(".ci/setup build"));
    for Block { text, .. } in &all[1..] {
        let said = shell(&folder.path("tutorial"), text);
        assert!(said.is_good, "{text}\n{}", said.text);
        assert!(!said.text.contains("warning"), "{}", said.text);
    }
    for made in [
        "arm.html",
        "tip.svg",
        "tip.csv",
        "bracket.html",
        "robot.html",
    ] {
        assert!(folder.path("tutorial").join(made).is_file(), "{made}");
    }
    // From the shoulder to the middle of the bracket's tip: two arms with an angle of 1.2 rad, and the bracket on the second.
    let table = folder.read("tutorial/robot.csv");
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
    let (shoulder, elbow) = (-0.6_f64, 1.2_f64);
    let (along, across) = (500.0 + FROM_FOOT_TO_TIP[0], FROM_FOOT_TO_TIP[1]);
    let turned = shoulder + elbow;
    // Turns about y lead x to -z.
    let x = 600.0 * shoulder.cos() + along * turned.cos() + across * turned.sin();
    let z = -600.0 * shoulder.sin() - along * turned.sin() + across * turned.cos();
    let off = (at("tip.x") - x).hypot(at("tip.z") - z);
    assert!(
        off < 1.0,
        "{} {}, expected {x} {z}",
        at("tip.x"),
        at("tip.z")
    );
}

/// From the middle of the bracket's foot to that of its tip, along x and z, mm: means of the nodes of `bracket.inp`.
const FROM_FOOT_TO_TIP: [f64; 2] = [66.0, 43.5];
