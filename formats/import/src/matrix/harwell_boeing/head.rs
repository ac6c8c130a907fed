//! The first four lines, five with right-hand sides.

use std::path::Path;

use dcb_formats::Error;
use dcb_formats::matrix::blocks::{TextBlocks, shown, unsigned};

use super::columns::Section;
use super::format::Format;
use crate::stored::LARGEST_LABEL;

/// Type of a matrix: kind of values, structure, storage.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Kind([u8; 3]);

impl Kind {
    /// `None` for words that are no type.
    pub(super) fn of(word: &[u8]) -> Option<Self> {
        let kind = <[u8; 3]>::try_from(word)
            .ok()?
            .map(|byte| byte.to_ascii_uppercase());
        let [value, structure, storage] = kind;
        let is_kind =
            b"RCPIQ".contains(&value) && b"SUHZR".contains(&structure) && b"AE".contains(&storage);
        is_kind.then_some(Self(kind))
    }

    pub(super) fn name(self) -> String {
        String::from_utf8_lossy(&self.0).into_owned()
    }

    pub(super) fn is_symmetric(self) -> bool {
        self.0[1] == b'S'
    }

    /// Why it can't be a stiffness or mass matrix.
    pub(super) fn obstacle(self, is_square: bool) -> Option<String> {
        let [value, structure, storage] = self.0;
        let obstacle = match (value, structure, storage) {
            (b'C', _, _) => "complex",
            (b'P' | b'Q', _, _) => "a pattern without numbers",
            (_, b'H', _) => "hermitian",
            (_, b'Z', _) => "skew-symmetric",
            (_, b'R', _) => "rectangular",
            (_, _, b'E') => "elemental, not assembled",
            _ if !is_square => "rectangular",
            _ => return None,
        };
        Some(obstacle.into())
    }
}

/// What the first lines say.
#[derive(Debug)]
pub(super) struct Head {
    pub(super) title: String,
    pub(super) kind: Kind,
    pub(super) rows: u64,
    pub(super) columns: u64,
    pub(super) entries: u64,
    pub(super) pointers: Section,
    pub(super) indices: Section,
    pub(super) values: Section,
}

/// Characters of the title.
const TITLE: usize = 72;

impl Head {
    /// Reads up to the first pointer.
    ///
    /// # Errors
    /// [`Error::Line`] for what can't be such lines.
    pub(super) fn read(path: &Path, text: &mut TextBlocks) -> Result<Self, Error> {
        let pending = text.pending();
        let refused = |line: u64, message: String| Error::Line {
            path: path.into(),
            line,
            message,
        };
        let mut lines = pending.split_inclusive(|&byte| byte == b'\n');
        let mut length = 0;
        let mut number = 0;
        let mut next = || {
            number += 1;
            let line = lines.next().filter(|line| line.ends_with(b"\n"));
            let ended = "the file ends within its head, or has no line ends with LF";
            let line = line.ok_or_else(|| refused(number, ended.into()))?;
            length += line.len();
            Ok(line.trim_ascii_end())
        };
        let title = next()?;
        let line_counts = counts(next()?).map_err(|message| refused(2, message))?;
        let [
            _,
            pointer_lines,
            index_lines,
            value_lines,
            ref right_hand @ ..,
        ] = line_counts[..]
        else {
            return Err(refused(2, "fewer than four counts of lines".into()));
        };
        let third = next()?;
        let (kind, sizes) = kind_and_sizes(third).map_err(|message| refused(3, message))?;
        let [rows, columns, entries] = sizes;
        let formats = formats(next()?).map_err(|message| refused(4, message))?;
        let has_right_hand = right_hand.first().is_some_and(|count| *count > 0);
        if has_right_hand {
            next()?;
        }
        let head_lines = number;
        let most = u64::from(LARGEST_LABEL);
        if rows > most || columns > most || entries >= u64::from(u32::MAX) {
            return Err(refused(
                3,
                format!(
                    "{rows} x {columns} with {entries} entries; at most {most} rows and {} entries are supported",
                    u32::MAX - 1
                ),
            ));
        }
        let is_real = kind.obstacle(rows == columns).is_none();
        let section = |name, line_count, numbers, lines_before, format: Option<Format>| {
            let format = match format {
                Some(format) => format,
                None if is_real => return Err(refused(4, format!("no format of {name}"))),
                None => Format::UNUSED,
            };
            Ok(Section {
                name,
                format,
                numbers,
                line_count,
                lines_before,
            })
        };
        let [pointer_format, index_format, value_format] = formats;
        let index_start = head_lines.saturating_add(pointer_lines);
        let value_start = index_start.saturating_add(index_lines);
        let head = Self {
            title: shown(title[..title.len().min(TITLE)].trim_ascii()),
            kind,
            rows,
            columns,
            entries,
            pointers: section(
                "pointers",
                pointer_lines,
                columns + 1,
                head_lines,
                pointer_format,
            )?,
            indices: section(
                "row numbers",
                index_lines,
                entries,
                index_start,
                index_format,
            )?,
            values: section("values", value_lines, entries, value_start, value_format)?,
        };
        if is_real {
            head.check_sections()
                .map_err(|(line, message)| refused(line, message))?;
        }
        text.skip(length);
        Ok(head)
    }

    /// Formats and counts of lines go with the numbers.
    fn check_sections(&self) -> Result<(), (u64, String)> {
        for (section, is_integer) in [
            (&self.pointers, true),
            (&self.indices, true),
            (&self.values, false),
        ] {
            let Section {
                name,
                format,
                numbers,
                line_count,
                ..
            } = section;
            if format.is_integer() != is_integer {
                return Err((4, format!("the format of the {name} is not one of {name}")));
            }
            let expected = numbers.div_ceil(format.fields as u64);
            if *line_count != expected {
                return Err((
                    2,
                    format!(
                        "{line_count} lines of {name} are announced; {numbers} of them, {} a line, take {expected}",
                        format.fields
                    ),
                ));
            }
        }
        Ok(())
    }

    /// Refuses counts that a file of so many bytes can't hold.
    pub(super) fn check_length(&self, path: &Path, length: Option<u64>) -> Result<(), Error> {
        // A number takes a digit, and a blank or line end.
        let least = 2 * (self.columns + 2 * self.entries);
        match length {
            Some(length) if length < least => Err(Error::Line {
                path: path.into(),
                line: 3,
                message: format!(
                    "{} columns and {} entries are announced, but the file has {length} bytes; it is cut off or damaged",
                    self.columns, self.entries
                ),
            }),
            _ => Ok(()),
        }
    }
}

fn counts(line: &[u8]) -> Result<Vec<u64>, String> {
    let words = line
        .split(u8::is_ascii_whitespace)
        .filter(|word| !word.is_empty());
    let count = |word: &[u8]| match unsigned(word) {
        Ok((count, length)) if length == word.len() => Ok(count),
        _ => Err(format!("`{}`; expected counts", shown(line.trim_ascii()))),
    };
    words.map(count).collect()
}

fn kind_and_sizes(line: &[u8]) -> Result<(Kind, [u64; 3]), String> {
    let bad = || {
        format!(
            "`{}`; expected a type such as RSA, then rows, columns and entries",
            shown(line.trim_ascii())
        )
    };
    let line = line.trim_ascii_start();
    let kind = line.get(..3).and_then(Kind::of).ok_or_else(bad)?;
    match counts(&line[3..]).map_err(|_| bad())?[..] {
        [rows, columns, entries, ..] => Ok((kind, [rows, columns, entries])),
        _ => Err(bad()),
    }
}

/// Formats of pointers, row numbers and values, one each in parentheses.
fn formats(line: &[u8]) -> Result<[Option<Format>; 3], String> {
    let mut formats = [None; 3];
    let mut rest = line;
    for format in &mut formats {
        let Some(begin) = rest.iter().position(|&byte| byte == b'(') else {
            break;
        };
        rest = &rest[begin..];
        let Some(end) = rest.iter().position(|&byte| byte == b')') else {
            break;
        };
        let text = &rest[..=end];
        *format = Some(Format::of(text).ok_or_else(|| {
            format!(
                "format `{}`; expected one such as (10I8) or (1P,3E25.16)",
                shown(text)
            )
        })?);
        rest = &rest[end + 1..];
    }
    Ok(formats)
}
