//! A folder with a component in it, and what `reduce` says there.

use std::fs;
use std::process::Command;

use dcb_formats::Component;
use serde_json::Value;

use crate::support::{Answer, Folder, has_all, list, stored};

impl Folder {
    /// `rotor.mtx`, `rotor.mass.mtx` and `rotor.json`: 115 nodes, 345 dofs, first elastic mode at 104.637 Hz.
    pub fn rotor() -> Self {
        Self::with_stored("samples/data/rotor", "rotor")
    }

    /// `rod.mtx` and its five siblings: planar, 15 dofs.
    pub fn rod() -> Self {
        Self::with_stored("samples/data/rod", "rod")
    }

    fn with_stored(folder: &str, stem: &str) -> Self {
        let made = Self::empty();
        for entry in fs::read_dir(stored(folder)).unwrap() {
            let path = entry.unwrap().path();
            let name = path.file_name().unwrap().to_str().unwrap().to_owned();
            if name.starts_with(stem) && !name.ends_with(".h5") {
                fs::copy(&path, made.path(&name)).unwrap();
            }
        }
        made
    }

    /// The component as `part.mtx` and its siblings.
    pub fn with(component: &Component) -> Self {
        let made = Self::empty();
        dcb_samples::write(component, &made.path("."), "part").unwrap();
        made
    }

    /// Replaces the value of the `number`th entry of a matrix on its diagonal; returns the line, from 1.
    pub fn set_diagonal(&self, name: &str, number: usize, new: impl Fn(f64) -> String) -> usize {
        let mut lines: Vec<String> = self.read(name).lines().map(str::to_owned).collect();
        let entry = |line: &String| -> Option<(String, f64)> {
            let words: Vec<&str> = line.split_whitespace().collect();
            let [row, column, value] = words[..] else {
                return None;
            };
            (row == column).then(|| Some((row.to_owned(), value.parse().ok()?)))?
        };
        let is_entry = |line: &String| !line.starts_with('%');
        let size = lines.iter().position(is_entry).unwrap();
        let mut on_diagonal =
            (size + 1..lines.len()).filter_map(|at| Some((at, entry(&lines[at])?)));
        let (at, (row, value)) = on_diagonal.nth(number).unwrap();
        lines[at] = format!("{row} {row} {}", new(value));
        self.write(name, lines.join("\n") + "\n");
        at + 1
    }

    /// Runs what must succeed without a warning.
    #[track_caller]
    pub fn done(&self, arguments: &str) -> String {
        let answer = self.run(arguments);
        assert_eq!((answer.code, answer.stderr.as_str()), (Some(0), ""));
        answer.stdout
    }

    /// Runs what must succeed with one warning that says all this.
    #[track_caller]
    pub fn warned(&self, arguments: &str, texts: &[&str]) -> Answer {
        let answer = self.run(arguments);
        assert_eq!(answer.code, Some(0), "{answer:?}");
        assert_eq!(answer.stderr.matches("warning: ").count(), 1, "{answer:?}");
        has_all(&answer.stderr, texts);
        answer
    }

    /// `inspect --json`.
    #[track_caller]
    pub fn inspected(&self, name: &str) -> Value {
        serde_json::from_str(&self.done(&format!("inspect {name} --json"))).unwrap()
    }

    #[track_caller]
    pub fn digest(&self, name: &str) -> String {
        self.inspected(name)["digest"].as_str().unwrap().to_owned()
    }

    #[track_caller]
    pub fn mode_count(&self, name: &str) -> usize {
        list(&self.inspected(name)["eigenvalues"]).len()
    }
}

/// Says that something could not be tested here.
pub fn skipped(why: &str) {
    println!("SKIPPED: {why}");
}

/// Whether the tests run as root, who may read and write everything.
pub fn is_root() -> bool {
    let output = Command::new("id").arg("-u").output();
    output.is_ok_and(|output| output.stdout == b"0\n")
}
