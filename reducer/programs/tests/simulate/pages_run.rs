//! Pages with commands and what these say: the first page and how-tos. The programs still say it.

use std::fs;

use crate::printed::{Block, blocks, folder_with_samples, says_the_same, shell};
use crate::support::stored;

/// Runs a page's commands one block after the other, in a folder beside the samples; a block of text behind one shows lines of its output.
fn runs_as_printed(page: &str, inside: &str) {
    let text = fs::read_to_string(stored(page)).unwrap();
    let folder = folder_with_samples();
    let place = folder.path(inside);
    fs::create_dir_all(&place).unwrap();
    let mut said = None;
    let mut compared = 0;
    for Block { language, text } in blocks(&text) {
        match language.as_str() {
            "sh" => {
                // How the programs are called before anything is built.
                let mut commands = text;
                for program in ["reduce", "simulate"] {
                    let built = format!(".ci/setup run --release --bin {program} --");
                    commands = commands.replace(&built, program);
                }
                let answer = shell(&place, &commands);
                assert!(answer.is_good, "{page}: {commands}\n{}", answer.text);
                said = Some(answer.text);
            }
            "text" => {
                let Some(said) = &said else { continue };
                for line in text.lines().filter(|line| line.trim() != "…") {
                    assert!(
                        said.lines().any(|other| says_the_same(line, other)),
                        "{page}: no longer said: {line}\nbut:\n{said}"
                    );
                    compared += 1;
                }
            }
            _ => {}
        }
    }
    assert!(compared > 0, "{page} shows no output");
}

#[test]
fn the_first_page_runs_as_it_is_printed() {
    runs_as_printed("README.md", "");
}

#[test]
fn damping_runs_as_it_is_printed() {
    runs_as_printed("docs/damping.md", "tutorial");
}

#[test]
fn choosing_modes_runs_as_it_is_printed() {
    runs_as_printed("docs/choosing-modes.md", "tutorial");
}

#[test]
fn redundant_joints_run_as_they_are_printed() {
    runs_as_printed("docs/redundant-joints.md", "tutorial");
}

#[test]
fn assemblies_run_as_they_are_printed() {
    runs_as_printed("docs/assemblies.md", "tutorial");
}

#[test]
fn frequency_responses_run_as_they_are_printed() {
    runs_as_printed("docs/frequency-response.md", "tutorial");
}

#[test]
fn stresses_run_as_they_are_printed() {
    runs_as_printed("docs/stress.md", "tutorial");
}

#[test]
fn measured_parts_run_as_they_are_printed() {
    runs_as_printed("docs/measured.md", "tutorial");
}

#[test]
fn rotors_run_as_they_are_printed() {
    runs_as_printed("docs/rotors.md", "tutorial");
}
