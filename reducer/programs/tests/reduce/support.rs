//! A folder with a component in it, the program run there, and what both look like afterwards.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use dcb_formats::Component;
use serde_json::Value;
use tempfile::TempDir;

/// The program.
pub const REDUCE: &str = env!("CARGO_BIN_EXE_reduce");

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// A file of the repository.
pub fn stored(path: &str) -> PathBuf {
    repository().join(path)
}

/// A folder of its own for each test.
pub struct Folder {
    place: TempDir,
}

/// How a run ended.
#[derive(Debug)]
pub struct Answer {
    pub code: Option<i32>,
    pub stdout: String,
    pub stderr: String,
}

impl Folder {
    pub fn empty() -> Self {
        Self {
            place: tempfile::tempdir().unwrap(),
        }
    }

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
        dcb_samples::write(component, made.place.path(), "part").unwrap();
        made
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.place.path().join(name)
    }

    pub fn read(&self, name: &str) -> String {
        fs::read_to_string(self.path(name)).unwrap()
    }

    pub fn write(&self, name: &str, contents: impl AsRef<[u8]>) {
        fs::write(self.path(name), contents).unwrap();
    }

    pub fn remove(&self, name: &str) {
        fs::remove_file(self.path(name)).unwrap();
    }

    /// Changes a JSON file.
    pub fn edit(&self, name: &str, change: impl FnOnce(&mut Value)) {
        let mut value = serde_json::from_str(&self.read(name)).unwrap();
        change(&mut value);
        self.write(name, serde_json::to_string_pretty(&value).unwrap());
    }

    /// Replaces the value of the `number`th entry of a matrix on its diagonal; returns the line, from 1.
    pub fn set_diagonal(&self, name: &str, number: usize, new: impl Fn(f64) -> String) -> usize {
        let mut lines: Vec<String> = self.read(name).lines().map(str::to_owned).collect();
        let on_diagonal = |line: &String| {
            let words: Vec<&str> = line.split_whitespace().collect();
            words.len() == 3 && words[0] == words[1] && !line.starts_with('%')
        };
        let is_size = lines
            .iter()
            .position(|line| !line.starts_with('%'))
            .unwrap();
        let at = (is_size + 1..lines.len())
            .filter(|at| on_diagonal(&lines[*at]))
            .nth(number)
            .unwrap();
        let words: Vec<String> = lines[at].split_whitespace().map(str::to_owned).collect();
        lines[at] = format!(
            "{} {} {}",
            words[0],
            words[1],
            new(words[2].parse().unwrap())
        );
        self.write(name, lines.join("\n") + "\n");
        at + 1
    }

    /// Every file and folder with its bytes.
    pub fn contents(&self) -> BTreeMap<String, Option<Vec<u8>>> {
        let mut found = BTreeMap::new();
        let mut open = vec![self.place.path().to_owned()];
        while let Some(folder) = open.pop() {
            for entry in fs::read_dir(folder).unwrap() {
                let path = entry.unwrap().path();
                let name = path.strip_prefix(self.place.path()).unwrap();
                found.insert(name.display().to_string(), fs::read(&path).ok());
                if path.is_dir() {
                    open.push(path);
                }
            }
        }
        found
    }

    pub fn names(&self) -> Vec<String> {
        self.contents().into_keys().collect()
    }

    /// The program with these arguments (separated by blanks), in this folder.
    pub fn command(&self, arguments: &str) -> Command {
        let mut command = Command::new(REDUCE);
        command
            .args(arguments.split_whitespace())
            .current_dir(self.place.path())
            .env("DCB_CACHE", self.path("default-cache"))
            .env_remove("DCB_CACHE_LIMIT")
            .stdin(Stdio::null());
        command
    }

    pub fn run(&self, arguments: &str) -> Answer {
        answer(&mut self.command(arguments))
    }

    /// Runs what must succeed without a warning.
    pub fn done(&self, arguments: &str) -> String {
        let answer = self.run(arguments);
        assert_eq!(
            (answer.code, answer.stderr.as_str()),
            (Some(0), ""),
            "{arguments}"
        );
        answer.stdout
    }

    /// Runs what must be refused with status 2 and one message that says all this; the folder stays as it was.
    pub fn refused(&self, arguments: &str, says: &[&str]) -> String {
        self.failed(2, arguments, says)
    }

    /// The same with another status.
    pub fn failed(&self, code: i32, arguments: &str, says: &[&str]) -> String {
        let before = self.contents();
        let answer = self.run(arguments);
        answer.is_error(code, says);
        assert_eq!(
            before.keys().collect::<Vec<_>>(),
            self.contents().keys().collect::<Vec<_>>()
        );
        assert!(before == self.contents(), "a file was changed: {answer:?}");
        answer.stderr
    }

    /// Runs what must succeed with one warning that says all this.
    pub fn warned(&self, arguments: &str, says: &[&str]) -> Answer {
        let answer = self.run(arguments);
        assert_eq!(answer.code, Some(0), "{answer:?}");
        assert_eq!(answer.stderr.matches("warning: ").count(), 1, "{answer:?}");
        answer.mentions(says);
        answer
    }

    /// `inspect --json`.
    pub fn inspected(&self, name: &str) -> Value {
        serde_json::from_str(&self.done(&format!("inspect {name} --json"))).unwrap()
    }
}

pub fn answer(command: &mut Command) -> Answer {
    let output = command.output().unwrap();
    let answer = Answer {
        code: output.status.code(),
        stdout: String::from_utf8(output.stdout).unwrap(),
        stderr: String::from_utf8(output.stderr).unwrap(),
    };
    assert!(!answer.stderr.contains("panicked"), "{answer:?}");
    assert!(
        !answer.stderr.contains('\r') && !answer.stderr.contains('\u{1b}'),
        "bars in a pipe: {answer:?}"
    );
    answer
}

impl Answer {
    /// Exactly one message, with this status, saying all this on standard error.
    pub fn is_error(&self, code: i32, says: &[&str]) {
        assert_eq!(self.code, Some(code), "{self:?}");
        assert_eq!(self.stderr.matches("error: ").count(), 1, "{self:?}");
        assert!(self.stderr.starts_with("error: "), "{self:?}");
        self.mentions(says);
    }

    fn mentions(&self, says: &[&str]) {
        for words in says {
            assert!(
                self.stderr.contains(words),
                "`{words}` is missing: {}",
                self.stderr
            );
        }
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
