//! I-DEAS universal files (`.unv`): nodes, elements, groups. Other datasets are skipped.
//!
//! Nodes 15, 781, 2411; elements 780, 2412; groups 2429 to 2477; coordinate systems 2420, of which only the global one is taken.

mod elements;
mod groups;

use std::collections::HashSet;
use std::path::Path;

use dcb_formats::Error;

use super::FoundMesh;
use super::cells::Cells;
use super::fields;
use super::node_sets::Marks;
use super::nodes::Nodes;
use crate::text::lines::Lines;
use groups::Groups;

/// Whether a text begins as such a file does: a line with -1, a line with the number of a dataset.
pub(crate) fn recognises(start: &[u8]) -> bool {
    let lines = start.split(|byte| *byte == b'\n').map(<[u8]>::trim_ascii);
    let mut lines = lines.filter(|line| !line.is_empty());
    lines.next() == Some(b"-1") && lines.next().is_some_and(|line| dataset(line).is_some())
}

/// Number of a dataset; binary ones have a letter and further numbers behind it.
fn dataset(line: &[u8]) -> Option<u32> {
    let word = line.trim_ascii().split(u8::is_ascii_whitespace).next()?;
    let digits = word.strip_suffix(b"b").unwrap_or(word);
    std::str::from_utf8(digits).ok()?.parse().ok()
}

/// Reads a mesh.
///
/// # Errors
/// [`Error::Line`] for what can't be read, [`Error::Location`] for elements and nodes that don't fit each other.
pub(crate) fn read(path: &Path) -> Result<(FoundMesh, String), Error> {
    let mut source = Datasets::open(path)?;
    let mut model = Model::default();
    while let Some(number) = source.next_dataset()? {
        match number {
            15 => model.nodes_in_a_line(&mut source)?,
            781 | 2411 => model.nodes(&mut source)?,
            780 | 2412 => model.elements(&mut source, number)?,
            2420 => model.systems(&mut source)?,
            2417 | 2429 | 2430 | 2432 => model.groups.read(&mut source, 2)?,
            2435 | 2452 | 2467 | 2477 => model.groups.read(&mut source, 4)?,
            _ => while source.line()?.is_some() {},
        }
    }
    let bytes = source.bytes;
    let sha256 = source.lines.finish()?;
    Ok((model.finish(path, bytes)?, sha256))
}

/// The lines of datasets.
struct Datasets {
    lines: Lines,
    line: Vec<u8>,
    number: u32,
    bytes: u64,
    numbers: Vec<i64>,
}

impl Datasets {
    fn open(path: &Path) -> Result<Self, Error> {
        Ok(Self {
            lines: Lines::open(path)?,
            line: Vec::new(),
            number: 0,
            bytes: 0,
            numbers: Vec::new(),
        })
    }

    fn any_line(&mut self) -> Result<bool, Error> {
        let Some(line) = self.lines.next_line()? else {
            return Ok(false);
        };
        self.bytes += line.len() as u64 + 1;
        self.line.clear();
        self.line.extend_from_slice(line.trim_ascii_end());
        Ok(true)
    }

    /// Number of the next dataset; `None` at the end of the file.
    fn next_dataset(&mut self) -> Result<Option<u32>, Error> {
        while self.any_line()? {
            match self.line.trim_ascii() {
                b"" => continue,
                b"-1" => {}
                other => {
                    let shown = fields::shown(other);
                    return Err(self
                        .lines
                        .refused(format!("{shown}; expected -1 and a dataset")));
                }
            }
            if !self.any_line()? {
                break;
            }
            match dataset(&self.line) {
                Some(number) => self.number = number,
                None => {
                    let shown = fields::shown(&self.line);
                    return Err(self
                        .lines
                        .refused(format!("{shown}; expected the number of a dataset")));
                }
            }
            return Ok(Some(self.number));
        }
        Ok(None)
    }

    /// The next line of the dataset; `None` at its end.
    fn line(&mut self) -> Result<Option<&[u8]>, Error> {
        if !self.any_line()? {
            return Err(self.lines.refused(format!(
                "the file ends in dataset {}, which has no -1 at its end; it is cut off",
                self.number
            )));
        }
        Ok((self.line.trim_ascii() != b"-1").then_some(&self.line))
    }

    /// A line that the dataset must have.
    fn needed_line(&mut self) -> Result<&[u8], Error> {
        if self.line()?.is_none() {
            return Err(self
                .lines
                .refused(format!("dataset {} ends too early", self.number)));
        }
        Ok(&self.line)
    }

    /// Whole numbers of a further record; `None` at the end of the dataset.
    fn record(&mut self) -> Result<Option<&[i64]>, Error> {
        if self.line()?.is_none() {
            return Ok(None);
        }
        let parsed = integers(&self.line, &mut self.numbers);
        parsed.map_err(|message| self.lines.refused(message))?;
        Ok(Some(&self.numbers))
    }

    /// Whole numbers of a line that the dataset must have.
    fn integers(&mut self) -> Result<&[i64], Error> {
        if self.record()?.is_none() {
            return Err(self
                .lines
                .refused(format!("dataset {} ends too early", self.number)));
        }
        Ok(&self.numbers)
    }
}

/// Whole numbers between blanks; in columns of ten where they touch.
fn integers(line: &[u8], into: &mut Vec<i64>) -> Result<(), String> {
    into.clear();
    let words = || {
        line.split(u8::is_ascii_whitespace)
            .filter(|word| !word.is_empty())
    };
    if words().all(|word| word.len() <= 10) {
        for word in words() {
            into.push(fields::integer(word)?);
        }
    } else {
        for column in line.chunks(10) {
            let column = column.trim_ascii();
            if !column.is_empty() {
                into.push(fields::integer(column)?);
            }
        }
    }
    Ok(())
}

/// Three real numbers between blanks.
fn point<'a>(mut words: impl Iterator<Item = &'a [u8]>) -> Result<[f64; 3], String> {
    let mut point = [0.0; 3];
    for number in &mut point {
        let word = words.next().ok_or("has no three coordinates")?;
        *number = fields::real(word)?;
    }
    Ok(point)
}

/// A mesh as far as it is read.
#[derive(Default)]
struct Model {
    nodes: Nodes,
    cells: Cells,
    groups: Groups,
    /// Coordinate systems that nodes name.
    used: HashSet<i64>,
    /// Those that aren't the global one.
    turned: HashSet<i64>,
}

impl Model {
    /// `label system system color`, and the coordinates in a further line.
    fn nodes(&mut self, source: &mut Datasets) -> Result<(), Error> {
        while let Some(numbers) = source.record()? {
            let label = numbers.first().copied().unwrap_or(0);
            self.used.extend(numbers.iter().skip(1).take(2));
            let label = fields::as_label(label);
            let label = label.map_err(|message| source.lines.refused(message))?;
            let line = source.needed_line()?;
            let words = line
                .split(u8::is_ascii_whitespace)
                .filter(|word| !word.is_empty());
            let found = point(words);
            let found = found.map_err(|message| source.lines.refused(message))?;
            self.nodes.push(label, found);
        }
        Ok(())
    }

    /// `label system system color x y z`.
    fn nodes_in_a_line(&mut self, source: &mut Datasets) -> Result<(), Error> {
        while let Some(line) = source.line()? {
            let node = || -> Result<_, String> {
                let mut words = line
                    .split(u8::is_ascii_whitespace)
                    .filter(|word| !word.is_empty());
                let mut numbers = [0; 4];
                for number in &mut numbers {
                    *number = fields::integer(words.next().ok_or("has no four numbers")?)?;
                }
                Ok((fields::as_label(numbers[0])?, numbers, point(words)?))
            };
            let (label, numbers, point) =
                node().map_err(|message| source.lines.refused(message))?;
            self.used.extend(&numbers[1..3]);
            self.nodes.push(label, point);
        }
        Ok(())
    }

    /// Systems with their kind, axes and origin; 0 and the unit axes are the global one.
    fn systems(&mut self, source: &mut Datasets) -> Result<(), Error> {
        source.needed_line()?;
        source.needed_line()?;
        while let Some(numbers) = source.record()? {
            let (label, kind) = (
                numbers.first().copied().unwrap_or(0),
                numbers.get(1).copied().unwrap_or(0),
            );
            source.needed_line()?;
            let mut is_global = kind == 0;
            for row in 0..4 {
                let line = source.needed_line()?;
                let words = line
                    .split(u8::is_ascii_whitespace)
                    .filter(|word| !word.is_empty());
                let found = point(words);
                let found = found.map_err(|message| source.lines.refused(message))?;
                let global = [0, 1, 2].map(|axis| if axis == row { 1.0 } else { 0.0 });
                is_global &= found == global;
            }
            if !is_global {
                self.turned.insert(label);
            }
        }
        Ok(())
    }

    fn finish(mut self, path: &Path, bytes: u64) -> Result<FoundMesh, Error> {
        let refused = |message: String| Error::File {
            path: path.into(),
            message,
        };
        if let Some(system) = self.used.intersection(&self.turned).min() {
            return Err(refused(format!(
                "has nodes in coordinate system {system}, which isn't the global one; write the mesh in the global system"
            )));
        }
        let mut mesh = FoundMesh::default();
        let index = self.nodes.indexed(path, &mut mesh.notes)?;
        self.cells.tie(path, &index)?;
        let cell_index = self.cells.by_label(path)?;
        let mut marks = Marks::new(self.nodes.labels.len(), bytes);
        (self
            .groups
            .into_sets(&index, &self.cells, &cell_index, &mut marks, &mut mesh))
        .map_err(|error| refused(error.message()))?;
        mesh.points = self.nodes.points;
        mesh.labels = Some(self.nodes.labels);
        mesh.cells = self.cells.finish();
        Ok(mesh)
    }
}
