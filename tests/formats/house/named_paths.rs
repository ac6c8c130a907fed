//! Sources that pages and comments name are there.

use std::fs;

use super::{root, sources};

/// Where paths begin.
const FOLDERS: [&str; 5] = ["formats/", "reducer/", "runtime/", "samples/", "tests/"];

#[test]
fn sources_that_pages_and_comments_name_are_there() {
    let root = root();
    let pages = fs::read_dir(root.join("docs")).unwrap();
    let mut texts: Vec<_> = pages
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "md"))
        .collect();
    texts.push(root.join("README.md"));
    for folder in FOLDERS {
        let is_input = |path: &std::path::PathBuf| {
            !path
                .components()
                .any(|part| part.as_os_str() == "target" || part.as_os_str() == "data")
        };
        texts.extend(sources(&root.join(folder)).into_iter().filter(is_input));
    }
    let mut named = 0;
    for path in texts {
        let text = fs::read_to_string(&path).unwrap();
        for quoted in text.split('`').skip(1).step_by(2) {
            let source = quoted.split("::").next().unwrap();
            let is_path = FOLDERS.iter().any(|folder| source.starts_with(folder))
                && source.ends_with(".rs")
                && !source.contains(['<', '*', ' ']);
            if is_path {
                named += 1;
                assert!(
                    root.join(source).is_file(),
                    "{}: `{source}` is not there",
                    path.display()
                );
            }
        }
    }
    assert!(named > 20, "only {named} paths found");
}
