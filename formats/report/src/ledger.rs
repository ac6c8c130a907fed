//! The rows of a study as they are made: one line of JSON each, on disk before the next one is begun.
//!
//! ```text
//! {"study":"reduction","settings":{…}}        what all rows have in common: inputs with their digests, options
//! {"key":"strong/20","row":{…}}               one row, under a key that says what it is a row of
//! ```
//!
//! A run that is stopped, even in the middle of a line, loses the row it was at and no other. A later run with the same settings
//! finds the finished rows by their keys; other settings are refused, because their rows don't compare. Several processes may add to one
//! ledger, on one machine or on several with a common file system that has locks: each line is written under a lock of the file.

use std::collections::BTreeMap;
use std::fs::{File, OpenOptions};
use std::io::{self, Read as _, Seek as _, SeekFrom, Write as _};
use std::path::{Path, PathBuf};

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use dcb_formats::Error;

/// Treatment of rows that are there already.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Start {
    /// Keep them if their settings are the same, refuse otherwise.
    Continue,
    /// Discard them.
    Anew,
}

/// Rows of type `R` under their keys, and the file that has them. `R` should write what may be infinite or undefined as an
/// `Option`: JSON has no such numbers.
#[derive(Debug)]
pub struct Ledger<R> {
    path: PathBuf,
    file: File,
    rows: BTreeMap<String, R>,
    /// Bytes that were read or written: whole lines.
    known: u64,
    /// Lines among them.
    lines: u64,
}

#[derive(Serialize, Deserialize)]
struct Head {
    study: String,
    settings: Value,
}

#[derive(Serialize)]
struct Line<'a, R> {
    key: &'a str,
    row: &'a R,
}

#[derive(Deserialize)]
struct OwnedLine<R> {
    key: String,
    row: R,
}

impl<R: Serialize + DeserializeOwned> Ledger<R> {
    /// Opens the ledger of a study of this kind, with the rows that it has; makes it if it isn't there.
    ///
    /// # Errors
    /// [`Error::File`] naming the setting that differs, or saying that the file is something else; [`Error::Line`] for a
    /// complete line that isn't a row; [`Error::Io`].
    pub fn open(path: &Path, study: &str, settings: &Value, start: Start) -> Result<Self, Error> {
        let head = Head {
            study: study.to_owned(),
            settings: settings.clone(),
        };
        let file = OpenOptions::new()
            .read(true)
            .write(true)
            .create(true)
            .truncate(false)
            .open(path)
            .map_err(|error| Error::io(path, "cannot write", error))?;
        let mut ledger = Self {
            path: path.to_owned(),
            file,
            rows: BTreeMap::new(),
            known: 0,
            lines: 0,
        };
        ledger.alone(|ledger| ledger.begin(&head, start))?;
        Ok(ledger)
    }

    /// Reads the rows that are there, or writes the first line.
    fn begin(&mut self, head: &Head, start: Start) -> Result<(), Error> {
        let text = match start {
            Start::Continue => self.unread()?,
            Start::Anew => String::new(),
        };
        match text.split_once('\n') {
            Some((first, _)) => {
                check_head(&self.path, first, head)?;
                (self.known, self.lines) = (first.len() as u64 + 1, 1);
                self.refresh_alone()
            }
            None => {
                let line = serde_json::to_string(head).map_err(|e| not_json(&self.path, &e))?;
                if !line.starts_with(&text) {
                    check_head(&self.path, &text, head)?;
                }
                self.append(&line)
            }
        }
    }

    /// Reads the rows that other processes have added.
    ///
    /// # Errors
    /// [`Error::Line`] for a complete line that isn't a row; [`Error::Io`].
    pub fn refresh(&mut self) -> Result<(), Error> {
        self.alone(Self::refresh_alone)
    }

    /// Does something that no other process does at the same time.
    fn alone<T>(&mut self, work: impl FnOnce(&mut Self) -> Result<T, Error>) -> Result<T, Error> {
        match self.file.lock() {
            // A file system without locks has one process at a time.
            Err(error) if error.kind() != io::ErrorKind::Unsupported => {
                return Err(Error::io(&self.path, "cannot lock", error));
            }
            _ => {}
        }
        let done = work(self);
        // The lock ends with the file at the latest.
        let _ = self.file.unlock();
        done
    }

    fn refresh_alone(&mut self) -> Result<(), Error> {
        let text = self.unread()?;
        // Only what ends in a line break was written completely.
        for line in text.split_inclusive('\n') {
            let Some(whole) = line.strip_suffix('\n') else {
                break;
            };
            let found: OwnedLine<R> = serde_json::from_str(whole).map_err(|error| Error::Line {
                path: self.path.clone(),
                line: self.lines + 1,
                message: format!(
                    "is no row of this study ({error}); remove the line, or start anew with --force"
                ),
            })?;
            self.rows.insert(found.key, found.row);
            self.known += line.len() as u64;
            self.lines += 1;
        }
        Ok(())
    }

    /// The text after what is known.
    fn unread(&mut self) -> Result<String, Error> {
        let mut text = Vec::new();
        (self.file.seek(SeekFrom::Start(self.known)))
            .and_then(|_| self.file.read_to_end(&mut text))
            .and_then(|_| String::from_utf8(text).map_err(|_| io::ErrorKind::InvalidData.into()))
            .map_err(|error| Error::io(&self.path, "cannot read", error))
    }

    /// Writes a line after what is known, in the place of half a line that a killed process left there.
    fn append(&mut self, line: &str) -> Result<(), Error> {
        let written = (self.file.set_len(self.known))
            .and_then(|()| self.file.seek(SeekFrom::Start(self.known)))
            .and_then(|_| self.file.write_all(format!("{line}\n").as_bytes()))
            .and_then(|()| self.file.sync_data());
        let size = line.len() as u64 + 1;
        if let Err(error) = written {
            // Half a line must not stand before the next one.
            let _ = self.file.set_len(self.known);
            return Err(Error::not_written(&self.path, size, error));
        }
        self.known += size;
        self.lines += 1;
        Ok(())
    }

    /// The row under a key, if it is there.
    pub fn row(&self, key: &str) -> Option<&R> {
        self.rows.get(key)
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.rows.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// Adds a row and waits until the disk has it; a row under the same key is superseded.
    ///
    /// # Errors
    /// [`Error::Io`]: a full disk, for example. What was in the ledger stays in it.
    pub fn add(&mut self, key: &str, row: R) -> Result<(), Error> {
        let line = Line { key, row: &row };
        let text = serde_json::to_string(&line).map_err(|error| not_json(&self.path, &error))?;
        self.alone(|ledger| {
            ledger.refresh_alone()?;
            ledger.append(&text)
        })?;
        self.rows.insert(key.to_owned(), row);
        Ok(())
    }
}

fn check_head(path: &Path, line: &str, expected: &Head) -> Result<(), Error> {
    let refused = |message: String| Error::File {
        path: path.to_owned(),
        message,
    };
    let found: Head = serde_json::from_str(line).map_err(|_| {
        refused(
            "is there already and holds no study; name another folder, or replace it with --force"
                .into(),
        )
    })?;
    if found.study != expected.study {
        return Err(refused(format!(
            "holds a study of another kind ({:?}, not {:?}); name another folder, or replace it with --force",
            found.study, expected.study
        )));
    }
    match difference("", &found.settings, &expected.settings) {
        None => Ok(()),
        Some((place, there, here)) => Err(refused(format!(
            "holds rows made with other settings: `{place}` is {there} there and {here} now; name another folder, or start anew with --force"
        ))),
    }
}

/// The first place at which two values differ, with what stands there.
fn difference(place: &str, a: &Value, b: &Value) -> Option<(String, String, String)> {
    let inner = |key: &str| match place.is_empty() {
        true => key.to_owned(),
        false => format!("{place}.{key}"),
    };
    match (a, b) {
        (Value::Object(a), Value::Object(b)) => {
            let keys = a.keys().chain(b.keys().filter(|key| !a.contains_key(*key)));
            let null = Value::Null;
            keys.map(|key| {
                (
                    key,
                    a.get(key).unwrap_or(&null),
                    b.get(key).unwrap_or(&null),
                )
            })
            .find_map(|(key, a, b)| difference(&inner(key), a, b))
        }
        _ if a == b => None,
        _ => Some((place.to_owned(), a.to_string(), b.to_string())),
    }
}

fn not_json(path: &Path, error: &serde_json::Error) -> Error {
    Error::File {
        path: path.to_owned(),
        message: format!("cannot be written as JSON: {error}"),
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used, clippy::unwrap_in_result)]
mod tests {
    use serde_json::json;

    use super::*;

    fn open(path: &Path, settings: &Value, start: Start) -> Result<Ledger<f64>, Error> {
        Ledger::open(path, "trial", settings, start)
    }

    #[test]
    fn a_torn_line_costs_one_row() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("rows.jsonl");
        let settings = json!({ "inputs": { "stiffness": "ab" }, "points": 40 });
        let mut ledger = open(&path, &settings, Start::Continue).unwrap();
        ledger.add("one", 1.0 / 3.0).unwrap();
        ledger.add("two", 2.0).unwrap();
        drop(ledger);
        let whole = std::fs::read(&path).unwrap();
        for cut in 0..=whole.len() {
            std::fs::write(&path, &whole[..cut]).unwrap();
            let mut ledger = open(&path, &settings, Start::Continue).unwrap();
            let complete = whole[..cut].iter().filter(|byte| **byte == b'\n').count();
            assert_eq!(ledger.len(), complete.saturating_sub(1), "cut at {cut}");
            assert_eq!(
                ledger.row("one").copied(),
                (complete > 1).then_some(1.0 / 3.0)
            );
            ledger.add("three", 3.0).unwrap();
            drop(ledger);
            let again = open(&path, &settings, Start::Continue).unwrap();
            assert_eq!(again.row("three"), Some(&3.0), "cut at {cut}");
        }
    }

    #[test]
    fn several_hands_write_one_ledger() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("rows.jsonl");
        let settings = json!({ "points": 40 });
        std::thread::scope(|scope| {
            for hand in 0..4 {
                let (path, settings) = (&path, &settings);
                scope.spawn(move || {
                    let mut ledger = open(path, settings, Start::Continue).unwrap();
                    for row in 0..25 {
                        ledger
                            .add(&format!("{hand}/{row}"), f64::from(row))
                            .unwrap();
                    }
                });
            }
        });
        let mut early = open(&path, &settings, Start::Continue).unwrap();
        assert_eq!(early.len(), 100);
        let mut late = open(&path, &settings, Start::Continue).unwrap();
        late.add("late", 1.0).unwrap();
        assert_eq!(early.row("late"), None);
        early.refresh().unwrap();
        assert_eq!(early.row("late"), Some(&1.0));
    }

    #[test]
    fn other_settings_are_refused_by_name() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("rows.jsonl");
        let settings = |points: usize| json!({ "inputs": { "mass": "ab" }, "points": points });
        (open(&path, &settings(40), Start::Continue).unwrap())
            .add("one", 1.0)
            .unwrap();
        let refused = open(&path, &settings(60), Start::Continue).unwrap_err();
        let message = refused.to_string();
        assert!(
            message.contains("`points` is 40 there and 60 now") && message.contains("--force"),
            "{message}"
        );
        assert!(open(&path, &settings(60), Start::Anew).unwrap().is_empty());
        for other in ["modes,error\n", "notes"] {
            std::fs::write(&path, other).unwrap();
            let refused = open(&path, &settings(60), Start::Continue).unwrap_err();
            assert!(refused.to_string().contains("holds no study"), "{refused}");
            assert_eq!(std::fs::read_to_string(&path).unwrap(), other);
        }
    }
}
