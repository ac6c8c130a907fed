//! Harwell-Boeing files, as Ansys' HBMAT writes them: compressed columns in fixed columns of text, by Fortran formats in the head.
//!
//! Symmetric files (RSA) hold the lower triangle, unsymmetric ones (RUA) all. The file says how many lines and numbers there are; each count
//! is compared with what comes. Right-hand sides are passed over. Zeros are left out.

mod columns;
mod format;
mod head;

use std::path::Path;

use dcb_formats::Error;
use dcb_formats::matrix::blocks::{Entries, TextBlocks, shown, unsigned};

use self::columns::read_numbers;
use self::head::Head;
use crate::stored::{Content, Listed, Reading, Rows, StoredMatrix, Triangles};
use crate::text::line_blocks::{filled_lines, look_at_text, read_text};
use crate::text::real::whole_real;

/// The one matrix of the file, called as its key or title.
///
/// # Errors
/// [`Error::Line`] for a head that is none.
pub fn list(path: &Path) -> Result<Vec<Listed>, Error> {
    let head = look_at_text(path, |text| Head::read(path, text))?;
    Ok(vec![Listed {
        name: head.title,
        shape: Some((head.rows, head.columns)),
        obstacle: head.kind.obstacle(head.rows == head.columns),
    }])
}

/// Whether the third line is a type such as `RSA` with counts, and the fourth a format in parentheses.
pub fn recognises(start: &[u8]) -> bool {
    let start = start
        .strip_prefix(crate::text::line_blocks::BYTE_ORDER_MARK)
        .unwrap_or(start);
    let mut lines = start.split(|&byte| byte == b'\n').skip(2);
    let (Some(third), Some(fourth)) = (lines.next(), lines.next()) else {
        // Where CR alone ends lines the whole is one line; the reader says so.
        return start.contains(&b'\r')
            && {
                let mut lines = filled_lines(start).skip(2);
                matches!((lines.next(), lines.next()), (Some(third), Some(fourth)) if is_head(third, fourth))
            };
    };
    is_head(third, fourth)
}

fn is_head(third: &[u8], fourth: &[u8]) -> bool {
    let is_index = |word: &[u8]| matches!(unsigned(word), Ok((_, length)) if length == word.len());
    let mut words = third
        .split(u8::is_ascii_whitespace)
        .filter(|word| !word.is_empty());
    words
        .next()
        .is_some_and(|word| head::Kind::of(word).is_some())
        && words.all(is_index)
        && fourth.trim_ascii_start().starts_with(b"(")
}

/// Reads the matrix, number 0 of the list.
///
/// # Errors
/// [`Error::Line`] for a line that isn't as its format says, counts that don't fit each other, pointers that fall; [`Error::File`] for
/// complex, rectangular, elemental, skew-symmetric matrices, patterns without numbers, and files that end too early; and what reading a text meets.
pub fn read(path: &Path, wanted: &[usize]) -> Result<Reading, Error> {
    let (matrix, sha256) = read_text(path, |text| {
        let head = Head::read(path, text)?;
        if let Some(obstacle) = head.kind.obstacle(head.rows == head.columns) {
            return Err(Error::File {
                path: path.into(),
                message: format!(
                    "a Harwell-Boeing matrix of type {}, {} x {}: {obstacle}; expected a real, square, assembled one (RSA or RUA)",
                    head.kind.name(),
                    head.rows,
                    head.columns
                ),
            });
        }
        head.check_length(path, text.text_length())?;
        stored(path, text, head)
    })?;
    Ok(Reading::of_one(wanted, matrix, sha256))
}

fn stored(path: &Path, text: &mut TextBlocks, head: Head) -> Result<StoredMatrix, Error> {
    let index = |most: u64| {
        move |field: &[u8]| match unsigned(field) {
            Ok((value, length)) if length == field.len() && (1..=most).contains(&value) => {
                Ok(value as u32)
            }
            _ => Err(format!(
                "`{}`; expected an integer from 1 to {most}",
                shown(field)
            )),
        }
    };
    let starts = read_numbers(path, text, &head.pointers, index(head.entries + 1))?.values;
    refuse_falling(path, &head, &starts)?;
    let rows = read_numbers(path, text, &head.indices, index(head.rows))?.values;
    let format = head.values.format;
    let value = move |field: &[u8]| format.check(field).and_then(|()| real(field));
    let values = read_numbers(path, text, &head.values, value)?;
    let entries = Entries::in_columns(&starts, rows, values.values);
    Ok(StoredMatrix {
        name: head.title,
        size: head.rows as usize,
        triangles: match head.kind.is_symmetric() {
            true => Triangles::One,
            false => Triangles::Both,
        },
        content: Content::Entries(vec![entries]),
        rows: Rows::Unlabelled,
        digits: values.digits.count(),
        notes: Vec::new(),
    })
}

fn real(field: &[u8]) -> Result<f64, String> {
    whole_real(field).map_err(|_| format!("`{}`; expected a finite number", shown(field)))
}

/// Pointers rise from 1 to one more than the entries.
fn refuse_falling(path: &Path, head: &Head, starts: &[u32]) -> Result<(), Error> {
    let falls = starts.windows(2).position(|pair| pair[1] < pair[0]);
    let ends = (starts.first().copied(), starts.last().copied());
    let message = match (falls, ends) {
        (Some(column), _) => format!(
            "column {} begins at entry {}, the one before at {}; expected rising pointers",
            column + 2,
            starts[column + 1],
            starts[column]
        ),
        (None, (Some(1), Some(last))) if u64::from(last) == head.entries + 1 => return Ok(()),
        (None, (first, last)) => format!(
            "pointers of columns go from {} to {}; expected from 1 to {}, one more than the entries",
            first.unwrap_or(0),
            last.unwrap_or(0),
            head.entries + 1
        ),
    };
    Err(Error::File {
        path: path.into(),
        message,
    })
}
