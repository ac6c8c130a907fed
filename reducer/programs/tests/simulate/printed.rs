//! Commands that pages print, run as they are printed, and what the pages say of their output.

use std::path::Path;
use std::process::Command;

use crate::support::{Folder, stored};

/// A block of code in a page.
pub struct Block {
    pub language: String,
    pub text: String,
}

/// Blocks of a page, in their order.
pub fn blocks(page: &str) -> Vec<Block> {
    let mut found: Vec<Block> = Vec::new();
    let mut is_inside = false;
    for line in page.lines() {
        if let Some(language) = line.trim_start().strip_prefix("```") {
            is_inside = !is_inside;
            if is_inside {
                found.push(Block {
                    language: language.to_owned(),
                    text: String::new(),
                });
            }
        } else if let Some(block) = found.last_mut().filter(|_| is_inside) {
            block.text += line;
            block.text.push('\n');
        }
    }
    found
}

/// How commands ended, and all that they said.
pub struct Said {
    pub is_good: bool,
    pub text: String,
}

/// Runs commands in a folder, with the programs of this build in the path.
pub fn shell(folder: &Path, commands: &str) -> Said {
    let programs = Path::new(env!("CARGO_BIN_EXE_simulate")).parent().unwrap();
    assert!(
        programs.join("samples").is_file(),
        "pages need the program `samples`: cargo build --release -p dcb-samples"
    );
    let path = format!("{}:{}", programs.display(), std::env::var("PATH").unwrap());
    let answer = Command::new("bash")
        .args(["-euo", "pipefail", "-c", &format!("exec 2>&1\n{commands}")])
        .current_dir(folder)
        .env("PATH", path)
        .output()
        .unwrap();
    let text = String::from_utf8_lossy(&answer.stdout).into_owned();
    assert!(!text.contains("panicked"), "{text}");
    Said {
        is_good: answer.status.success(),
        text,
    }
}

/// An empty folder from which the stored samples can be reached.
pub fn folder_with_samples() -> Folder {
    let folder = Folder::empty();
    std::os::unix::fs::symlink(stored("samples"), folder.path("samples")).unwrap();
    folder
}

/// Whether a line says the same as a printed one: the same words, numbers within 1 %, and rounding errors and times as they come.
pub fn says_the_same(printed: &str, said: &str) -> bool {
    let is_timed = printed.contains(" us a step") || printed.contains(" unknowns, ");
    let words = |line: &str| -> Vec<String> {
        let words = line.split_whitespace();
        words
            .map(|word| word.trim_matches(|c| ",;:()".contains(c)).to_owned())
            .collect()
    };
    let (printed, said) = (words(printed), words(said));
    printed.len() == said.len()
        && printed.iter().zip(&said).all(|(printed, said)| {
            match (printed.parse::<f64>(), said.parse::<f64>()) {
                (Ok(a), Ok(b)) => {
                    let size = a.abs().max(b.abs());
                    is_timed || size < 1e-8 || (a - b).abs() <= 0.01 * size
                }
                _ => printed == said,
            }
        })
}

#[test]
fn lines_are_compared_by_words_and_numbers() {
    assert!(says_the_same(
        "right within 3.86e-03,",
        "right within 0.00385"
    ));
    assert!(!says_the_same(
        "right within 3.86e-03",
        "right within 3.96e-03"
    ));
    assert!(!says_the_same("12 modes", "12 nodes"));
    assert!(says_the_same("residual 1.42e-10", "residual 3.1e-11"));
}
