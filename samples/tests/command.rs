//! The program `samples`: names, files and refusals.

#![allow(clippy::unwrap_used)]

use std::fs;
use std::process::{Command, Output};

use dcb_samples::catalogue::CATALOGUE;

fn samples(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_samples"))
        .args(arguments)
        .output()
        .unwrap()
}

#[test]
fn the_list_names_every_sample() {
    let answer = samples(&["list"]);
    assert!(answer.status.success());
    let text = String::from_utf8(answer.stdout).unwrap();
    assert_eq!(text.lines().count(), CATALOGUE.len());
    for sample in CATALOGUE {
        assert!(text.contains(sample.name), "{}", sample.name);
    }
}

#[test]
fn a_sample_is_written_where_it_was_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("new/folder");
    let answer = samples(&["write", "beam", "--out", out.to_str().unwrap()]);
    assert!(answer.status.success());
    for name in ["beam.mtx", "beam.mass.mtx", "beam.json"] {
        assert!(out.join(name).is_file(), "{name}");
    }
    let header = fs::read_to_string(out.join("beam.mtx")).unwrap();
    assert!(header.starts_with("%%MatrixMarket matrix coordinate real symmetric"));
}

#[test]
fn a_name_that_is_unknown_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let answer = samples(&["write", "sofa", "--out", folder.path().to_str().unwrap()]);
    assert_eq!(answer.status.code(), Some(2));
    let told = String::from_utf8(answer.stderr).unwrap();
    assert!(
        told.contains("sofa") && told.contains("samples list"),
        "{told}"
    );
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
}
