//! Lines of bulk data, in their form: a head and fields of 8 or 16 columns, or fields between commas.

use std::borrow::Cow;

use memchr::{memchr, memchr2};

/// Columns of the head, of a small field, and of a tabulator.
const COLUMN: usize = 8;
/// Columns of a line that hold fields.
const COLUMNS: usize = 72;

/// A line that isn't a comment.
pub(super) struct CardLine<'a> {
    form: Form<'a>,
    /// Columns, or characters between commas, that a field has; `None` where commas end it.
    pub(super) width: Option<usize>,
}

enum Form<'a> {
    Fixed(&'a [u8], usize),
    Free([&'a [u8]; 8], usize),
}

/// Line without comment and without tabulators; `None` where nothing is left.
pub(super) fn bare(line: &[u8]) -> Option<Cow<'_, [u8]>> {
    if line.first() == Some(&b'$') {
        return None;
    }
    // Hardly any line has one of them.
    let Some(first) = memchr2(b'$', b'\t', line) else {
        let line = line.trim_ascii_end();
        return (!line.is_empty()).then_some(Cow::Borrowed(line));
    };
    let end = memchr(b'$', &line[first..]).map_or(line.len(), |at| first + at);
    let line = line[..end].trim_ascii_end();
    match line.contains(&b'\t') {
        _ if line.is_empty() => None,
        false => Some(Cow::Borrowed(line)),
        true => Some(Cow::Owned(without_tabs(line))),
    }
}

/// Each tabulator goes on to the next field.
fn without_tabs(line: &[u8]) -> Vec<u8> {
    let mut columns = Vec::with_capacity(line.len());
    for &byte in line {
        match byte {
            b'\t' => columns.resize((columns.len() / COLUMN + 1) * COLUMN, b' '),
            _ => columns.push(byte),
        }
    }
    columns
}

/// Whether a line goes on with the card before.
#[inline(always)]
pub(super) fn is_continuation(line: &[u8]) -> bool {
    matches!(line.first(), None | Some(b' ' | b'+' | b'*' | b',' | b'\t'))
}

/// Whether a line begins a DMIG card.
#[inline(always)]
pub(super) fn is_dmig(line: &[u8]) -> bool {
    line.get(..4)
        .is_some_and(|name| name.eq_ignore_ascii_case(b"DMIG"))
        && matches!(
            line.get(4),
            None | Some(b' ' | b'*' | b',' | b'\t' | b'\r' | b'\n')
        )
}

impl<'a> CardLine<'a> {
    /// Of a line that is bare.
    ///
    /// # Errors
    /// More fields between commas than a line has, commas between fields of fixed width.
    #[inline]
    pub(super) fn of(line: &'a [u8]) -> Result<Self, String> {
        if memchr(b',', line).is_some() {
            return Self::free(line);
        }
        let head = &line[..line.len().min(COLUMN)];
        let width = match head.contains(&b'*') {
            true => 2 * COLUMN,
            false => COLUMN,
        };
        Ok(Self {
            form: Form::Fixed(&line[..line.len().min(COLUMNS)], width),
            width: Some(width),
        })
    }

    fn free(line: &'a [u8]) -> Result<Self, String> {
        let mut parts = line.split(|&byte| byte == b',').map(<[u8]>::trim_ascii);
        let head = parts.next().unwrap_or_default();
        if head.contains(&b' ') {
            return Err(
                "commas in fields of fixed width; numbers have a decimal point, not a comma".into(),
            );
        }
        let is_large = head.contains(&b'*');
        let count = if is_large { 4 } else { 8 };
        let mut fields = [&b""[..]; 8];
        for (number, part) in parts.enumerate() {
            match fields[..count].get_mut(number) {
                Some(field) => *field = part,
                // Field 10 may have a mark.
                None if number == count && !part.first().is_some_and(u8::is_ascii_digit) => {}
                None if part.is_empty() => {}
                None => {
                    return Err(format!(
                        "more than {count} fields between commas; the rest goes on in a further line, and decimals have a point"
                    ));
                }
            }
        }
        Ok(Self {
            form: Form::Free(fields, count),
            width: None,
        })
    }

    /// Groups of four fields in a line.
    #[inline(always)]
    pub(super) fn group_count(&self) -> usize {
        match self.form {
            Form::Fixed(_, COLUMN) | Form::Free(_, 8) => 2,
            _ => 1,
        }
    }

    /// Four fields without the blanks around them.
    #[inline(always)]
    pub(super) fn group(&self, number: usize) -> [&'a [u8]; 4] {
        let first = 4 * number;
        std::array::from_fn(|field| match &self.form {
            Form::Fixed(line, width) => {
                let start = COLUMN + (first + field) * width;
                let end = line.len().min(start + width);
                line.get(start..end).unwrap_or_default().trim_ascii()
            }
            Form::Free(fields, _) => fields[first + field],
        })
    }
}
