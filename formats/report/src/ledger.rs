//! The rows of a study as they are made: one line of JSON each, on disk before the next one is begun.
//!
//! ```text
//! {"study":"reduction","settings":{…}}        what all rows have in common: inputs with their digests, options
//! {"key":"strong/20","row":{…}}               one row, under a key that says what it is a row of
//! ```
//!
//! A run that is stopped, even in the middle of a line, loses the row it was at and no other. A later run with the same settings
//! finds the finished rows by their keys; other settings are refused, because their rows don't compare. Several processes may add to one
//! ledger ([`SharedLines`]).

use std::collections::BTreeMap;
use std::path::Path;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use dcb_formats::Error;

use crate::SharedLines;

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
    lines: SharedLines,
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
        let (mut lines, mut rows) = (SharedLines::open(path)?, BTreeMap::new());
        let _alone = lines.alone()?;
        let mut half = String::new();
        if start == Start::Continue {
            lines.read(|number, line| match number {
                1 => check_head(path, line, &head),
                _ => add_row(&mut rows, path, number, line),
            })?;
            half = lines.rest()?;
        }
        if lines.count() == 0 {
            let line = serde_json::to_string(&head).map_err(|error| not_json(path, &error))?;
            if !line.starts_with(&half) {
                check_head(path, &half, &head)?;
            }
            lines.append(&line)?;
        }
        Ok(Self { lines, rows })
    }

    /// Reads the rows that other processes have added.
    ///
    /// # Errors
    /// [`Error::Line`] for a complete line that isn't a row; [`Error::Io`].
    pub fn refresh(&mut self) -> Result<(), Error> {
        let _alone = self.lines.alone()?;
        self.read_rows()
    }

    fn read_rows(&mut self) -> Result<(), Error> {
        let (path, rows) = (self.lines.path().to_owned(), &mut self.rows);
        (self.lines).read(|number, line| add_row(rows, &path, number, line))
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
        let path = self.lines.path();
        let text = serde_json::to_string(&line).map_err(|error| not_json(path, &error))?;
        let _alone = self.lines.alone()?;
        self.read_rows()?;
        self.lines.append(&text)?;
        self.rows.insert(key.to_owned(), row);
        Ok(())
    }
}

fn add_row<R: DeserializeOwned>(
    rows: &mut BTreeMap<String, R>,
    path: &Path,
    number: u64,
    line: &str,
) -> Result<(), Error> {
    let found: OwnedLine<R> = serde_json::from_str(line).map_err(|error| Error::Line {
        path: path.to_owned(),
        line: number,
        message: format!(
            "is no row of this study ({error}); remove the line, or start anew with --force"
        ),
    })?;
    rows.insert(found.key, found.row);
    Ok(())
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
