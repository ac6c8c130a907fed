//! `docs/tutorial.md`: its commands run in their order, and its change of the scene does what it says.

use std::fs;
use std::path::Path;
use std::process::Command;

use crate::support::{Folder, stored};

/// Blocks of a language in a page.
fn blocks(page: &str, language: &str) -> Vec<String> {
    let fence = format!("```{language}\n");
    page.split(&fence)
        .skip(1)
        .map(|block| block.split("```").next().unwrap().to_owned())
        .collect()
}

/// Runs commands with the programs of this build in the path.
fn shell(folder: &Folder, commands: &str) {
    let programs = Path::new(env!("CARGO_BIN_EXE_simulate")).parent().unwrap();
    assert!(
        programs.join("samples").is_file(),
        "the tutorial needs the program `samples`: cargo build --release -p dcb-samples"
    );
    let path = format!("{}:{}", programs.display(), std::env::var("PATH").unwrap());
    let answer = Command::new("bash")
        .args(["-euo", "pipefail", "-c", commands])
        .current_dir(folder.path(""))
        .env("PATH", path)
        .output()
        .unwrap();
    let told = String::from_utf8_lossy(&answer.stderr);
    assert!(answer.status.success(), "{commands}\n{told}");
    assert!(!told.contains("warning"), "{told}");
}

#[test]
fn the_tutorial_runs_as_it_is_printed() {
    let page = fs::read_to_string(stored("docs/tutorial.md")).unwrap();
    let folder = Folder::empty();
    let commands = blocks(&page, "sh");
    // The first builds the programs.
    assert!(commands[0].contains(".ci/setup build"));
    for block in &commands[1..] {
        shell(&folder, block);
    }
    for made in ["arm.html", "tip.svg", "tip.csv", "upper-arm.html"] {
        assert!(folder.path(made).is_file(), "{made}");
    }
    let text = folder.read("arm.json");
    let joints = text.find("\"joints\"").unwrap();
    let behind = joints + text[joints..].find("\n  },\n").unwrap() + 6;
    let line = &blocks(&page, "json")[0];
    folder.write(
        "arm.json",
        format!("{}{line}{}", &text[..behind], &text[behind..]),
    );
    shell(
        &folder,
        "simulate arm.json --end 0.3 --force --csv driven.csv",
    );
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
