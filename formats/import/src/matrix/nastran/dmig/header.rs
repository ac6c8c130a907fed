//! The card that announces a matrix, and how a file is looked through for such cards.

use std::borrow::Cow;
use std::sync::Arc;

use dcb_formats::matrix::blocks::shown;
use memchr::memchr2_iter;

use super::card_line::{CardLine, bare, is_continuation, is_dmig};
use super::field::integer;
use crate::stored::Triangles;
use crate::text::cursor::Cursor;

/// Loads on enforced motion have this name; they are no matrix.
const NO_MATRIX: &[u8] = b"UACCEL";

/// The card `DMIG name 0 form tin tout polar - ncol`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Header {
    pub(super) name: String,
    form: u64,
    /// Type of the numbers as they are written.
    kind: u64,
    pub(super) is_polar: bool,
}

/// What a card that begins with DMIG is.
#[derive(Debug)]
pub(super) enum Dmig<'a> {
    Header(Header),
    /// Name, label and component of a column.
    Column([&'a [u8]; 3]),
    NoMatrix,
}

impl<'a> Dmig<'a> {
    /// Of the first line of a card.
    ///
    /// # Errors
    /// It is neither a header nor a column.
    pub(super) fn of(line: &CardLine<'a>) -> Result<Self, String> {
        let [name, label, component, fourth] = line.group(0);
        if name.eq_ignore_ascii_case(NO_MATRIX) {
            return Ok(Self::NoMatrix);
        }
        if name.is_empty() || name.len() > 8 || !name[0].is_ascii_alphabetic() {
            return Err(format!(
                "`{}`; expected the name of a matrix, up to 8 letters and digits",
                shown(name)
            ));
        }
        if label != b"0" {
            return Ok(Self::Column([name, label, component]));
        }
        let number = |field: &[u8], what: &str| {
            integer(field).ok_or_else(|| format!("`{}`; expected {what}", shown(field)))
        };
        let header = Header {
            name: name_of(name).into_owned(),
            form: number(component, "the form of the matrix: 1, 2, 6 or 9")?,
            kind: number(fourth, "the type of the numbers: 1 to 4")?,
            is_polar: line.group_count() == 2 && is_polar(line.group(1)),
        };
        Ok(Self::Header(header))
    }
}

/// Letters of names are capitals.
pub(super) fn name_of(field: &[u8]) -> Cow<'static, str> {
    String::from_utf8_lossy(field).to_ascii_uppercase().into()
}

/// Whether numbers are amplitudes and phases, by the second four fields of a header.
pub(super) fn is_polar([_, polar, ..]: [&[u8]; 4]) -> bool {
    !matches!(polar, b"" | b"0")
}

impl Header {
    /// Why this is no stiffness or mass matrix.
    pub(super) fn obstacle(&self) -> Option<String> {
        match (self.form, self.kind) {
            (_, 3 | 4) if self.is_polar => Some("complex, amplitudes and phases".into()),
            (_, 3 | 4) => Some("complex".into()),
            (1 | 6, 1 | 2) => None,
            (2 | 9, 1 | 2) => Some(format!("rectangular (form {})", self.form)),
            (form, 1 | 2) => Some(format!(
                "of form {form}; stiffness and mass have form 1 or 6"
            )),
            (_, kind) => Some(format!("of numbers of type {kind}; types are 1 to 4")),
        }
    }

    /// Triangles that are written.
    pub(super) fn triangles(&self) -> Triangles {
        match self.form {
            6 => Triangles::One,
            _ => Triangles::Both,
        }
    }
}

/// What stands before a block: the headers, and the first line of the card that the last lines belong to.
#[derive(Clone, Debug, Default)]
pub(super) struct Context {
    pub(super) headers: Arc<Vec<Header>>,
    pub(super) card: Vec<u8>,
}

impl Context {
    /// Takes a block in.
    pub(super) fn look(&mut self, block: &[u8]) {
        if self.is_header() {
            self.look_behind_header(block);
        }
        for start in dmig_starts(block) {
            let mut cursor = Cursor::new(&block[start..]);
            let line = cursor.take_line().unwrap_or_default();
            if self.look_at_dmig(line) {
                self.look_behind_header(cursor.rest());
            }
        }
        let mut lines = block.rsplit(|&byte| byte == b'\n');
        if let Some(card) = lines
            .find(|line| !is_continuation(line.trim_ascii_end()) && line.first() != Some(&b'$'))
        {
            self.card.clear();
            self.card.extend_from_slice(card.trim_ascii_end());
        }
    }

    /// Large fields of a header go on in a further line, if there is one.
    fn look_behind_header(&mut self, text: &[u8]) {
        let mut cursor = Cursor::new(text);
        while let Some(line) = cursor.take_line() {
            match line.first() {
                None | Some(b'$') => {}
                _ if is_continuation(line) => return self.look_at_second_line(line),
                _ => return,
            }
        }
    }

    /// Whether the last card is a header.
    fn is_header(&self) -> bool {
        let card = bare(&self.card).filter(|card| is_dmig(card));
        card.is_some_and(|card| {
            let dmig =
                CardLine::of(&card).map(|line| matches!(Dmig::of(&line), Ok(Dmig::Header(_))));
            dmig.unwrap_or(false)
        })
    }

    /// Takes a header in, if it is one.
    fn look_at_dmig(&mut self, line: &[u8]) -> bool {
        let Some(line) = bare(line) else { return false };
        let card = CardLine::of(&line);
        let Ok(Ok(Dmig::Header(header))) = card.map(|card| Dmig::of(&card)) else {
            return false;
        };
        Arc::make_mut(&mut self.headers).push(header);
        true
    }

    /// The second line tells whether numbers are polar.
    fn look_at_second_line(&mut self, line: &[u8]) {
        let Some(line) = bare(line) else { return };
        if let Ok(card) = CardLine::of(&line)
            && let Some(header) = Arc::make_mut(&mut self.headers).last_mut()
        {
            header.is_polar |= is_polar(card.group(0));
        }
    }
}

/// Where lines that begin with DMIG start. Hardly anything else has an M.
fn dmig_starts(block: &[u8]) -> impl Iterator<Item = usize> {
    let starts = memchr2_iter(b'M', b'm', block).filter_map(|at| at.checked_sub(1));
    starts.filter(|&start| {
        let is_line = start == 0 || block[start - 1] == b'\n';
        is_line && is_dmig(&block[start..])
    })
}
