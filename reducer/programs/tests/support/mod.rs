//! A folder for a program to run in, what the program answers, and what the folder holds afterwards.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};

use dcb_formats::component::{Component, InterfaceKind};
use dcb_formats::dcb::{Contents, WriteOptions, write_superelement};
use dcb_formats::output::Replace;
use dcb_formats::superelement::Superelement;
use dcb_tests::parts::{interface, with_interfaces};
use serde::Serialize;
use serde_json::{Value, json};
use tempfile::TempDir;

use crate::PROGRAM;

/// A file of the repository.
pub fn stored(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../..")
        .join(path)
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

    pub fn path(&self, name: &str) -> PathBuf {
        self.place.path().join(name)
    }

    pub fn read(&self, name: &str) -> String {
        fs::read_to_string(self.path(name)).unwrap()
    }

    pub fn json(&self, name: &str) -> Value {
        serde_json::from_str(&self.read(name)).unwrap()
    }

    pub fn bytes(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).unwrap()
    }

    pub fn size(&self, name: &str) -> u64 {
        fs::metadata(self.path(name)).unwrap().len()
    }

    pub fn write(&self, name: &str, contents: impl AsRef<[u8]>) {
        fs::write(self.path(name), contents).unwrap();
    }

    pub fn remove(&self, name: &str) {
        fs::remove_file(self.path(name)).unwrap();
    }

    /// Changes a JSON file.
    pub fn edit(&self, name: &str, change: impl FnOnce(&mut Value)) {
        let mut value = self.json(name);
        change(&mut value);
        self.write(name, serde_json::to_string_pretty(&value).unwrap());
    }

    /// Puts a value into a JSON file; its place is a path of keys and numbers.
    pub fn set(&self, name: &str, place: &str, value: impl Serialize) {
        self.edit(name, |all| *at(all, place) = json!(value));
    }

    /// Takes a key out of a JSON file.
    pub fn unset(&self, name: &str, place: &str) {
        let (parent, key) = place.rsplit_once('/').unwrap_or(("", place));
        self.edit(name, |all| {
            at(all, parent).as_object_mut().unwrap().remove(key);
        });
    }

    /// Writes a superelement without fields; replaces what is there.
    pub fn store_superelement(&self, name: &str, superelement: &Superelement) {
        let contents = Contents {
            superelement,
            recovery: None,
            mesh: None,
        };
        self.store_contents(name, &contents);
    }

    pub fn store_contents(&self, name: &str, contents: &Contents<'_>) {
        let options = WriteOptions {
            replace_existing: Replace::Overwrite,
            ..WriteOptions::default()
        };
        write_superelement(&self.path(name), contents, &options).unwrap();
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

    /// The names that have this in them.
    pub fn names_with(&self, text: &str) -> Vec<String> {
        let names = self.names().into_iter();
        names.filter(|name| name.contains(text)).collect()
    }

    /// The program with these arguments (separated by blanks), in this folder.
    pub fn command(&self, arguments: &str) -> Command {
        let mut command = Command::new(PROGRAM);
        command
            .args(arguments.split_whitespace())
            .current_dir(self.place.path())
            .env("DCB_CACHE", self.path("default-cache"))
            .env_remove("DCB_CACHE_LIMIT")
            .stdin(Stdio::null());
        command
    }

    /// The program as a shell runs it: `$0` stands for it.
    pub fn shell(&self, script: &str) -> Command {
        let mut command = Command::new("bash");
        command
            .args(["-c", script, PROGRAM])
            .current_dir(self.place.path())
            .stdin(Stdio::null());
        command
    }

    pub fn run(&self, arguments: &str) -> Answer {
        answer(&mut self.command(arguments))
    }

    /// The same where files may not have more than so many KiB.
    pub fn run_within(&self, kibibytes: u32, arguments: &str) -> Answer {
        answer(&mut self.shell(&format!("ulimit -f {kibibytes}; exec \"$0\" {arguments}")))
    }

    /// The same with so many kilobytes of address space.
    pub fn run_in_memory(&self, kilobytes: u64, arguments: &str) -> Output {
        let limits = format!("ulimit -v {kilobytes}; ulimit -c 0");
        let mut shell = self.shell(&format!("{limits}; exec \"$0\" {arguments}"));
        shell.output().unwrap()
    }

    /// Begins a run.
    pub fn start(&self, arguments: &str) -> Child {
        start(&mut self.command(arguments))
    }

    /// Runs what must be refused with status 2 and one message that says all this; the folder stays as it was.
    #[track_caller]
    pub fn refused(&self, arguments: &str, says: &[&str]) -> String {
        self.failed(2, arguments, says)
    }

    /// Each of several.
    #[track_caller]
    pub fn refused_each(&self, cases: &[(&str, &[&str])]) {
        for (arguments, says) in cases {
            self.refused(arguments, says);
        }
    }

    /// The same with another status.
    #[track_caller]
    pub fn failed(&self, code: i32, arguments: &str, says: &[&str]) -> String {
        let before = self.contents();
        let answer = self.run(arguments);
        answer.is_error(code, says);
        let after = self.contents();
        assert!(before.keys().eq(after.keys()), "{:?}", after.keys());
        assert!(before == after, "a file was changed: {answer:?}");
        answer.stderr
    }
}

/// The place of a value, made if it isn't there.
fn at<'a>(mut value: &'a mut Value, place: &str) -> &'a mut Value {
    for key in place.split('/').filter(|key| !key.is_empty()) {
        value = match key.parse::<usize>() {
            Ok(index) => &mut value[index],
            Err(_) => &mut value[key],
        };
    }
    value
}

/// The block with both ends as interfaces, and some of its nodes as a `lug`, if there are such.
pub fn with_ends(block: &Component, lug: impl Fn([f64; 3]) -> bool) -> Component {
    let frame = |name: &str, nodes| interface(name, InterfaceKind::Average, nodes);
    let set = |name: &str| block.mesh.point_sets[name].clone();
    let mut interfaces = vec![frame("left", set("x_min")), frame("right", set("x_max"))];
    let nodes = 0..block.mesh.node_count() as u32;
    let on_lug: Vec<u32> = nodes
        .filter(|node| lug(block.mesh.position(*node)))
        .collect();
    if !on_lug.is_empty() {
        interfaces.push(frame("lug", on_lug));
    }
    with_interfaces(block, interfaces)
}

/// The node that is nearest to a place.
pub fn node_at(component: &Component, place: [f64; 3]) -> u32 {
    let distance = |node: &u32| -> f64 {
        let pairs = component.mesh.position(*node).into_iter().zip(place);
        pairs.map(|(a, b)| (a - b).powi(2)).sum()
    };
    let nodes = 0..component.mesh.node_count() as u32;
    nodes
        .min_by(|a, b| distance(a).total_cmp(&distance(b)))
        .unwrap()
}

pub fn start(command: &mut Command) -> Child {
    command.stdout(Stdio::piped()).stderr(Stdio::piped());
    command.spawn().unwrap()
}

pub fn answer(command: &mut Command) -> Answer {
    Answer::of(command.output().unwrap())
}

/// Sends a signal, for example `INT`.
pub fn send(signal: &str, child: &Child) {
    let signal = format!("-{signal}");
    let sent = Command::new("kill")
        .args([signal, child.id().to_string()])
        .status();
    assert!(sent.is_ok());
}

/// Sends a signal, and waits for the end.
pub fn stopped(signal: &str, child: Child) -> Answer {
    send(signal, &child);
    Answer::at_end(child)
}

impl Answer {
    /// That of a run that was begun, once it is over.
    pub fn at_end(child: Child) -> Self {
        Self::of(child.wait_with_output().unwrap())
    }

    pub fn of(output: Output) -> Self {
        let answer = Self {
            code: output.status.code(),
            stdout: String::from_utf8(output.stdout).unwrap(),
            stderr: String::from_utf8(output.stderr).unwrap(),
        };
        // Words for programmers, and bars in a pipe.
        for odd in ["panicked", "unwrap", "RUST_BACKTRACE", "\r", "\u{1b}"] {
            assert!(!answer.stderr.contains(odd), "{odd:?} in {answer:?}");
        }
        answer
    }

    /// Exactly one message, with this status, saying all this on standard error.
    #[track_caller]
    pub fn is_error(&self, code: i32, texts: &[&str]) {
        assert_eq!(self.code, Some(code), "{self:?}");
        let errors = self
            .stderr
            .lines()
            .filter(|line| line.starts_with("error: "));
        assert_eq!(errors.count(), 1, "{self:?}");
        has_all(&self.stderr, texts);
    }
}

/// Asserts that a text has all of these in it.
macro_rules! says {
    ($text:expr, $($wanted:expr),+ $(,)?) => {
        $crate::support::has_all(&$text, &[$(&*$wanted),+])
    };
}
pub(crate) use says;

#[track_caller]
pub fn has_all(text: &str, texts: &[&str]) {
    for wanted in texts {
        assert!(text.contains(wanted), "no {wanted:?} in {text}");
    }
}

#[track_caller]
pub fn number(value: &Value) -> f64 {
    value
        .as_f64()
        .unwrap_or_else(|| panic!("{value} is no number"))
}

#[track_caller]
pub fn list(value: &Value) -> &Vec<Value> {
    value
        .as_array()
        .unwrap_or_else(|| panic!("{value} is no list"))
}

/// Clears the screen, colours, goes back to the beginning of the line, reverses the direction of reading.
pub const COMMANDS: &str = "x\u{1b}[2J\u{9b}31m\r\u{202e}y";

/// Whether a terminal would obey a part of the text.
pub fn commands_a_terminal(text: &str) -> bool {
    text.contains(|c: char| (c.is_control() && c != '\n') || ('\u{202a}'..='\u{202e}').contains(&c))
}
