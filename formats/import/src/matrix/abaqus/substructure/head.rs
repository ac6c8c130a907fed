//! The lines before the first matrix: nodes and their degrees of freedom.

use std::path::Path;

use dcb_formats::Error;
use dcb_formats::matrix::blocks::{TextBlocks, shown};
use rustc_hash::FxHashSet;

use crate::stored::LARGEST_LABEL;
use crate::stored::row_key::{RowKey, direction, no_direction};

/// Longest text before the first matrix.
const LONGEST: usize = 1 << 26;
/// Text that is looked at first; no line is longer.
const FIRST: usize = 1 << 18;
/// Rows of any file: their triangle would have two thousand million numbers.
const MOST_ROWS: u64 = 1 << 16;

/// What stands before the first matrix.
pub(super) struct Head {
    /// Rows in the order of the matrices. Without labels the nodes are numbered.
    pub(super) rows: Vec<RowKey>,
    /// Whether the file has labels of the nodes.
    pub(super) has_labels: bool,
    /// Lines of the head.
    pub(super) line_count: u64,
}

/// Whether a line is a keyword, without regard to case and blanks.
pub(super) fn is_keyword(line: &[u8], keyword: &[u8]) -> bool {
    let is_letter = |byte: &&u8| !matches!(byte, b' ' | b'\t');
    let first = line.split(|&byte| byte == b',').next().unwrap_or_default();
    let first = first.iter().filter(is_letter).map(u8::to_ascii_uppercase);
    first.eq(keyword.iter().filter(is_letter).copied())
}

/// A parameter of a keyword line, `NODES=6`.
pub(super) fn parameter<'a>(line: &'a [u8], name: &str) -> Option<&'a [u8]> {
    line.split(|&byte| byte == b',').find_map(|part| {
        let at = part.iter().position(|&byte| byte == b'=')?;
        let is_named = part[..at]
            .trim_ascii()
            .eq_ignore_ascii_case(name.as_bytes());
        is_named.then(|| part[at + 1..].trim_ascii())
    })
}

impl Head {
    /// Reads up to the first `*MATRIX`.
    ///
    /// # Errors
    /// [`Error::Line`] for what a head can't have, [`Error::File`] where none is.
    pub(super) fn read(path: &Path, text: &mut TextBlocks) -> Result<Self, Error> {
        let mut wanted = FIRST;
        let length = loop {
            text.fill_to(wanted)?;
            if let Some(length) = first_matrix(text.pending()) {
                break length;
            }
            if text.is_at_end() || wanted >= LONGEST {
                return Err(Error::File {
                    path: path.into(),
                    message: "has no line `*MATRIX, TYPE=...` behind *USER ELEMENT; it is cut off, or a substructure without matrices".into(),
                });
            }
            wanted *= 2;
        };
        // A lower triangle of n rows takes n² bytes at least.
        let length_of_file = text.text_length().unwrap_or(u64::MAX);
        let mut draft = Draft::new(length_of_file.isqrt().min(MOST_ROWS) as usize);
        let mut line_count = 0;
        for line in text.pending()[..length].split_inclusive(|&byte| byte == b'\n') {
            line_count += 1;
            draft
                .take(line.trim_ascii())
                .map_err(|message| Error::Line {
                    path: path.into(),
                    line: line_count,
                    message,
                })?;
        }
        text.skip(length);
        let bad = |message| Error::Line {
            path: path.into(),
            line: line_count,
            message,
        };
        let (rows, has_labels) = draft.rows().map_err(bad)?;
        Ok(Self {
            rows,
            has_labels,
            line_count,
        })
    }
}

/// Where the first line with a matrix begins.
fn first_matrix(text: &[u8]) -> Option<usize> {
    let mut at = 0;
    for line in text.split_inclusive(|&byte| byte == b'\n') {
        if line.ends_with(b"\n") && is_keyword(line.trim_ascii(), b"*MATRIX") {
            return Some(at);
        }
        at += line.len();
    }
    None
}

/// What the lines so far say.
struct Draft {
    /// Rows that the file can hold the numbers of.
    most_rows: usize,
    node_count: Option<usize>,
    /// Whether comment lines hold labels here.
    is_in_labels: bool,
    /// Negative ones are internal nodes.
    labels: Vec<i64>,
    /// 1-based node that directions begin with, and those.
    directions: Vec<(usize, Vec<u64>)>,
}

impl Draft {
    fn new(most_rows: usize) -> Self {
        Self {
            most_rows,
            node_count: None,
            is_in_labels: false,
            labels: Vec::new(),
            directions: Vec::new(),
        }
    }

    fn take(&mut self, line: &[u8]) -> Result<(), String> {
        if let Some(comment) = line.strip_prefix(b"**") {
            let comment = comment.trim_ascii();
            if comment.eq_ignore_ascii_case(b"ELEMENT NODES") {
                self.is_in_labels = true;
            } else if self.is_in_labels {
                self.labels.extend(integers(comment)?);
            }
            return self.within(self.labels.len());
        }
        self.is_in_labels = false;
        if line.is_empty() {
            return Ok(());
        }
        if is_keyword(line, b"*USER ELEMENT") {
            return self.begin(line);
        }
        if line.starts_with(b"*") {
            return Err(format!(
                "`{}`; expected *USER ELEMENT and *MATRIX",
                shown(line)
            ));
        }
        if self.node_count.is_none() {
            return Err(format!("`{}`; expected *USER ELEMENT first", shown(line)));
        }
        let bad = || {
            format!(
                "`{}`; expected the number of a node of the element and its degrees of freedom, by rising numbers",
                shown(line)
            )
        };
        let numbers = integers(line)?.into_iter().map(u64::try_from);
        let mut numbers: Vec<u64> = numbers.collect::<Result<_, _>>().map_err(|_| bad())?;
        let mut node = 1;
        if let Some((before, _)) = self.directions.last() {
            // The first line has the degrees of freedom of node 1 alone, the others a node in front.
            node = numbers.remove(0) as usize;
            if node <= *before || numbers.is_empty() {
                return Err(bad());
            }
        }
        self.directions.push((node, numbers));
        self.within(self.directions.len())
    }

    /// Refuses more rows than the file can hold the matrices of.
    fn within(&self, rows: usize) -> Result<(), String> {
        match rows > self.most_rows {
            true => Err(format!(
                "more than {} rows, of which the file can't hold a matrix; it is cut off or damaged",
                self.most_rows
            )),
            false => Ok(()),
        }
    }

    fn begin(&mut self, line: &[u8]) -> Result<(), String> {
        if self.node_count.is_some() {
            return Err("a second *USER ELEMENT; expected one substructure in a file".into());
        }
        let count = parameter(line, "NODES").map(integers).transpose()?;
        match count.as_deref() {
            Some([count]) if *count >= 1 => {
                self.node_count = Some(count.unsigned_abs() as usize);
                Ok(())
            }
            _ => Err(format!("`{}`; expected NODES= and a number", shown(line))),
        }
    }

    /// The rows, and whether they have labels.
    fn rows(mut self) -> Result<(Vec<RowKey>, bool), String> {
        let has_labels = !self.labels.is_empty();
        let Some(count) = self.node_count.filter(|_| !self.directions.is_empty()) else {
            return Err("*MATRIX before *USER ELEMENT with its degrees of freedom".into());
        };
        if !has_labels {
            self.within(count)?;
            self.labels = (1..=count as i64).collect();
        }
        if self.labels.len() != count {
            return Err(format!(
                "NODES={count}, but {} labels stand behind `** ELEMENT NODES`",
                self.labels.len()
            ));
        }
        if let Some((node, _)) = self.directions.last().filter(|(node, _)| *node > count) {
            return Err(format!("degrees of freedom of node {node} of {count}"));
        }
        let mut rows = Vec::new();
        let mut known = FxHashSet::default();
        let mut parts = self.directions.iter().peekable();
        while let Some((first, directions)) = parts.next() {
            let end = parts.peek().map_or(count, |(next, _)| next - 1);
            for label in &self.labels[first - 1..end] {
                for number in directions {
                    let key = row(*label, *number)?;
                    if !known.insert(key) {
                        return Err(format!("{key} is there twice"));
                    }
                    rows.push(key);
                    self.within(rows.len())?;
                }
            }
        }
        Ok((rows, has_labels))
    }
}

fn row(label: i64, number: u64) -> Result<RowKey, String> {
    let node = u32::try_from(label.unsigned_abs())
        .ok()
        .filter(|node| (1..=LARGEST_LABEL).contains(node))
        .ok_or_else(|| format!("node {label}; expected labels from 1 to {LARGEST_LABEL}"))?;
    match (label > 0, direction(number), u32::try_from(number)) {
        (true, Some(direction), _) => Ok(RowKey::nodal(node, direction)),
        (false, _, Ok(number @ 1..)) => Ok(RowKey::internal(node, number)),
        _ => Err(no_direction(node, number)),
    }
}

/// Integers with commas between them; one may stand at the end too.
fn integers(line: &[u8]) -> Result<Vec<i64>, String> {
    let line = line.trim_ascii();
    if line.len() > FIRST {
        return Err(format!("a line of more than {FIRST} bytes"));
    }
    let line = line.strip_suffix(b",").unwrap_or(line);
    let fields = line.split(|&byte| byte == b',').map(<[u8]>::trim_ascii);
    let integer = |field: &[u8]| {
        let text = std::str::from_utf8(field).ok();
        let number = text.and_then(|text| text.parse().ok());
        number.ok_or_else(|| {
            format!(
                "`{}`; expected integers with commas between them",
                shown(line)
            )
        })
    };
    fields.map(integer).collect()
}
