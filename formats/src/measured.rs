//! Measured modes of a part: a CSV file with a row for each mode.
//!
//! ```text
//! frequency [Hz],damping,tip.uz,12.ux
//! 231.4,0.0041,0.82,-0.11
//! ```
//! The first line names the columns: `frequency`, `damping` (ratio to critical, or `damping [%]`), and places of the shapes as `NODE.DIRECTION` or
//! `INTERFACE.DIRECTION`. Shapes are real and of any size.

use std::path::Path;

use crate::Error;
use crate::component::Source;
use crate::description::suggestion;
use crate::mesh::Direction;
use crate::snapshot::read_small;
use crate::terminal::shortened;
use crate::units::si_factor;

/// Bytes of a file of measured modes, at most.
const LONGEST_FILE: u64 = 1 << 26;

/// Modes that were measured on a part.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasuredModes {
    /// Places of the shapes, in the order of their entries.
    pub places: Vec<MeasuredPlace>,
    /// By rising frequency.
    pub modes: Vec<MeasuredMode>,
    /// The file.
    pub source: Source,
}

/// A mode that was measured.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasuredMode {
    /// Cycles per unit of time of the part.
    pub frequency: f64,
    /// Ratio to critical; `None` where none was measured.
    pub damping: Option<f64>,
    /// One number for each place.
    pub shape: Vec<f64>,
}

/// Where a shape was measured, and along which direction.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct MeasuredPlace {
    /// A node's number, or the name of an interface.
    pub at: String,
    /// Direction, component axes.
    pub direction: Direction,
}

impl MeasuredPlace {
    /// As the file writes it.
    pub fn name(&self) -> String {
        format!("{}.{}", self.at, self.direction.name())
    }
}

/// What a column holds.
enum Column {
    /// Times this makes cycles per unit of time.
    Frequency(f64),
    /// Times this makes a ratio.
    Damping(f64),
    Shape(MeasuredPlace),
    /// Numbers the modes.
    Number,
}

/// Reads measured modes of a part whose unit of time is this one.
///
/// # Errors
/// [`Error::Io`]; [`Error::File`] and [`Error::Line`] for what isn't such a table.
pub fn read_measured(path: &Path, time: &str) -> Result<MeasuredModes, Error> {
    let (bytes, sha256) = read_small(path, LONGEST_FILE)?;
    let whole = |message: String| Error::File {
        path: path.to_owned(),
        message,
    };
    let at_line = |line: u64, message: String| Error::Line {
        path: path.to_owned(),
        line,
        message,
    };
    let mut reader = csv::ReaderBuilder::new()
        .trim(csv::Trim::All)
        .comment(Some(b'#'))
        .from_reader(bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&bytes));
    let failed = |error: csv::Error| {
        let line = error.position().map_or(1, csv::Position::line);
        let message = match error.kind() {
            csv::ErrorKind::UnequalLengths {
                expected_len, len, ..
            } => format!("has {len} entries; the first line names {expected_len} columns"),
            csv::ErrorKind::Utf8 { .. } => "isn't UTF-8".to_owned(),
            _ => "isn't a line of a CSV table".to_owned(),
        };
        at_line(line, message)
    };
    let heading = reader.headers().map_err(failed)?.clone();
    let mut columns = Vec::with_capacity(heading.len());
    for name in &heading {
        columns.push(column(name, time).map_err(|message| at_line(1, message))?);
    }
    let count = |wanted: fn(&Column) -> bool| columns.iter().filter(|of| wanted(of)).count();
    if count(|of| matches!(of, Column::Frequency(_))) != 1 {
        return Err(at_line(
            1,
            "one column must be `frequency`; write for example frequency [Hz],damping,12.ux,tip.uz"
                .to_owned(),
        ));
    }
    if count(|of| matches!(of, Column::Damping(_))) > 1 {
        return Err(at_line(
            1,
            "has two columns of damping; keep one".to_owned(),
        ));
    }
    let places: Vec<MeasuredPlace> = (columns.iter())
        .filter_map(|column| match column {
            Column::Shape(place) => Some(place.clone()),
            _ => None,
        })
        .collect();
    let mut sorted = places.clone();
    sorted.sort();
    if let Some(pair) = sorted.windows(2).find(|pair| pair[0] == pair[1]) {
        return Err(at_line(1, format!("{} stands twice", pair[0].name())));
    }
    let mut modes = Vec::new();
    for record in reader.records() {
        let record = record.map_err(failed)?;
        let line = record.position().map_or(0, csv::Position::line);
        let mut mode = MeasuredMode {
            frequency: 0.0,
            damping: None,
            shape: Vec::with_capacity(places.len()),
        };
        for (column, text) in columns.iter().zip(&record) {
            let number = || {
                let value = text.parse::<f64>().ok().filter(|value| value.is_finite());
                value.ok_or_else(|| {
                    at_line(line, format!("{:?} is no finite number", shortened(text)))
                })
            };
            match column {
                Column::Number => {}
                Column::Frequency(unit) => mode.frequency = unit * number()?,
                Column::Damping(_) if text.is_empty() => {}
                Column::Damping(unit) => mode.damping = Some(unit * number()?),
                Column::Shape(_) => mode.shape.push(number()?),
            }
        }
        check(&mode).map_err(|message| at_line(line, message))?;
        modes.push(mode);
    }
    if modes.is_empty() {
        return Err(whole(
            "has no mode; expected a line for each below the names".to_owned(),
        ));
    }
    if !places.is_empty() && places.len() < modes.len() {
        return Err(whole(format!(
            "has {} modes, but shapes at {} places only: so few can't tell the modes apart; give at least as many places as modes, or no shapes",
            modes.len(),
            places.len()
        )));
    }
    modes.sort_by(|a, b| a.frequency.total_cmp(&b.frequency));
    let file_name = path.file_name().unwrap_or_default().to_string_lossy();
    Ok(MeasuredModes {
        places,
        modes,
        source: Source {
            role: "measured".to_owned(),
            file_name: file_name.into_owned(),
            sha256,
        },
    })
}

fn check(mode: &MeasuredMode) -> Result<(), String> {
    if mode.frequency <= 0.0 {
        return Err(format!(
            "the frequency is {}; it must be positive: leave rigid motions out",
            mode.frequency
        ));
    }
    if let Some(damping) = mode.damping.filter(|damping| !(0.0..1.0).contains(damping)) {
        return Err(format!(
            "the damping is {damping} of critical; expected at least 0 and less than 1, or a column `damping [%]`"
        ));
    }
    if !mode.shape.is_empty() && mode.shape.iter().all(|entry| *entry == 0.0) {
        return Err("the shape is zero everywhere".to_owned());
    }
    Ok(())
}

fn column(name: &str, time: &str) -> Result<Column, String> {
    let (word, unit) = match name.strip_suffix(']').and_then(|name| name.split_once('[')) {
        Some((word, unit)) => (word.trim(), Some(unit.trim())),
        None => (name, None),
    };
    match (word, unit) {
        ("mode", None) => Ok(Column::Number),
        ("frequency", None) => Ok(Column::Frequency(1.0)),
        ("frequency", Some("Hz")) => match si_factor(time) {
            Some(seconds) => Ok(Column::Frequency(seconds)),
            None => Err(format!(
                "the part's unit of time is {time:?}, whose seconds aren't known; give the column `frequency` in cycles per {time}"
            )),
        },
        ("damping", None | Some("1")) => Ok(Column::Damping(1.0)),
        ("damping", Some("%")) => Ok(Column::Damping(0.01)),
        ("frequency" | "damping", Some(unit)) => Err(format!(
            "{word} in {unit:?} isn't known; write frequency [Hz], damping or damping [%]"
        )),
        _ => {
            let place = name.rsplit_once('.').and_then(|(at, direction)| {
                Some(MeasuredPlace {
                    at: at.to_owned(),
                    direction: Direction::from_name(direction)?,
                })
            });
            place.map(Column::Shape).ok_or_else(|| {
                format!(
                    "column {:?} isn't known{}; expected frequency, damping, or a place such as 12.ux or tip.uz",
                    shortened(name),
                    suggestion(name, ["frequency", "damping", "mode"])
                )
            })
        }
    }
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test says what went wrong by failing")]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<MeasuredModes, String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("modes.csv");
        std::fs::write(&path, text).unwrap();
        read_measured(&path, "ms").map_err(|error| error.to_string())
    }

    #[test]
    fn units_and_places_are_read() {
        let read = read("# by hand\nmode,frequency [Hz], damping [%],7.uz,big end.rx\n1,500,0.4,1,-2\n2,250,,0.5,3\n").unwrap();
        let frequencies: Vec<f64> = read.modes.iter().map(|mode| mode.frequency).collect();
        assert_eq!(frequencies, [0.25, 0.5]);
        assert_eq!(read.modes[0].damping, None);
        assert!((read.modes[1].damping.unwrap() - 0.004).abs() < 1e-18);
        assert_eq!(read.modes[1].shape, [1.0, -2.0]);
        let names: Vec<String> = read.places.iter().map(MeasuredPlace::name).collect();
        assert_eq!(names, ["7.uz", "big end.rx"]);
    }

    #[test]
    fn mistakes_are_named() {
        for (text, told) in [
            ("frequncy\n1\n", "did you mean `frequency`"),
            ("frequency [rpm]\n1\n", "isn't known"),
            ("damping\n0.1\n", "one column must be `frequency`"),
            ("frequency,1.ux,1.ux\n1,1,1\n", "1.ux stands twice"),
            ("frequency,1.ux\n1,x\n", "no finite number"),
            ("frequency,1.ux\n1,0\n", "zero everywhere"),
            ("frequency\n-3\n", "must be positive"),
            ("frequency,damping\n3,2\n", "damping [%]"),
            ("frequency,damping\n3\n", "names 2 columns"),
            ("frequency\n", "has no mode"),
            (
                "frequency,1.ux\n1,1\n2,1\n",
                "2 modes, but shapes at 1 places",
            ),
        ] {
            let error = read(text).unwrap_err();
            assert!(error.contains(told), "{text:?}: {error}");
        }
    }
}
