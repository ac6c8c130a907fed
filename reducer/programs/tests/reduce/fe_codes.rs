//! The pages "from your FE code": every `reduce` command on them works on the samples that they name.

use std::fs;

use crate::support::{Folder, stored};

#[test]
fn the_commands_of_the_pages_work() {
    let mut pages: Vec<_> = fs::read_dir(stored("docs/fe-codes"))
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .collect();
    pages.sort();
    assert!(pages.len() >= 7, "{pages:?}");
    for page in pages {
        let text = fs::read_to_string(&page).unwrap();
        let samples = text
            .split_once("<!-- samples: ")
            .and_then(|(_, rest)| rest.split_once(" -->"))
            .unwrap_or_else(|| panic!("{} names no samples", page.display()));
        let names: Vec<&str> = samples.0.split_whitespace().collect();
        let folder = Folder::exchange(&names);
        let mut is_shell = false;
        let mut commands = 0;
        for line in text.lines() {
            if let Some(language) = line.strip_prefix("```") {
                is_shell = language == "sh";
            } else if let Some(arguments) = line.strip_prefix("reduce ").filter(|_| is_shell) {
                let answer = folder.run(arguments);
                assert_eq!(
                    answer.code,
                    Some(0),
                    "{}: {line}\n{answer:?}",
                    page.display()
                );
                commands += 1;
            }
        }
        assert!(commands > 0, "{} has no command", page.display());
    }
}
