//! The rows of a study as they are made: one line of JSON each, on disk before the next one is begun.
//!
//! ```text
//! {"study":"reduction","settings":{…}}        what all rows have in common: inputs with their digests, options
//! {"key":"strong/20","row":{…}}               one row, under a key that says what it is a row of
//! ```
//!
//! A run that is stopped, even in the middle of a line, loses the row it was at and no other. A later run with the same settings
//! finds the finished rows by their keys; other settings are refused, because their rows don't compare.

use std::collections::BTreeMap;
use std::fs::{File, OpenOptions};
use std::io::{Seek as _, SeekFrom, Write as _};
use std::path::{Path, PathBuf};

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use dcb_formats::Error;
use dcb_formats::output::write_text;

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
        let text = match (std::fs::read_to_string(path), start) {
            (Ok(text), Start::Continue) => text,
            (Err(error), Start::Continue) if error.kind() != std::io::ErrorKind::NotFound => {
                return Err(Error::io(path, "cannot read", error));
            }
            _ => String::new(),
        };
        // Only what ends in a line break was written completely.
        let whole = text.rfind('\n').map_or(0, |end| end + 1);
        let mut rows = BTreeMap::new();
        if whole == 0 {
            let line = serde_json::to_string(&head).map_err(|error| not_json(path, &error))?;
            if !line.starts_with(&text) {
                check_head(path, &text, &head)?;
            }
            write_text(path, &(line + "\n"))?;
        } else {
            let mut lines = text[..whole].lines();
            check_head(path, lines.next().unwrap_or(""), &head)?;
            for (index, line) in lines.enumerate() {
                let found: OwnedLine<R> =
                    serde_json::from_str(line).map_err(|error| Error::Line {
                        path: path.to_owned(),
                        line: index as u64 + 2,
                        message: format!(
                            "is no row of this study ({error}); remove the line, or start anew with --force"
                        ),
                    })?;
                rows.insert(found.key, found.row);
            }
        }
        let mut file = (OpenOptions::new().read(true).write(true).open(path))
            .map_err(|error| Error::io(path, "cannot write", error))?;
        if whole > 0 {
            file.set_len(whole as u64)
                .map_err(|error| Error::io(path, "cannot write", error))?;
        }
        file.seek(SeekFrom::End(0))
            .map_err(|error| Error::io(path, "cannot write", error))?;
        Ok(Self {
            path: path.to_owned(),
            file,
            rows,
        })
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
        let line = text + "\n";
        let before = (self.file.metadata())
            .map_err(|error| Error::io(&self.path, "cannot write", error))?
            .len();
        let added = (self.file.write_all(line.as_bytes())).and_then(|()| self.file.sync_data());
        if let Err(error) = added {
            // Half a line must not stand before the next one.
            let _ = self.file.set_len(before);
            let _ = self.file.seek(SeekFrom::End(0));
            return Err(Error::not_written(&self.path, line.len() as u64, error));
        }
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
