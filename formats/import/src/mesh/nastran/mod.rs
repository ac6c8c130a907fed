//! Nastran decks (`.bdf`, `.dat`, `.nas`) and the files of external superelements (`.asm`, `.pch`): grids in their coordinate systems, elements,
//! scalar points, sets, and the order of a superelement's rows.
//!
//! Cards that aren't known are skipped. Continuation lines must follow their card.

mod cards;
mod case_control;
mod coordinate_systems;
mod elements;
mod model;
mod set_text;

use std::path::Path;

use dcb_formats::Error;

use super::FoundMesh;
use super::deck::Deck;
use cards::{Card, CardLine, plain};
use case_control::CaseControl;
use model::{Model, is_wanted};

/// Whether a text is a Nastran deck: it has grids, or the words around the bulk data.
pub(crate) fn recognises(start: &[u8]) -> bool {
    let begins = |line: &[u8], word: &[u8]| {
        line.get(..word.len())
            .is_some_and(|head| head.eq_ignore_ascii_case(word))
            && !matches!(line.get(word.len()), Some(byte) if byte.is_ascii_alphanumeric() || matches!(byte, b'_' | b'/' | b':'))
    };
    let mut lines = start.split(|byte| *byte == b'\n');
    !start.iter().take(1024).any(|byte| *byte == 0)
        && lines.any(|line| {
            let words: [&[u8]; 6] = [
                b"GRID",
                b"GRID*",
                b"CEND",
                b"BEGIN BULK",
                b"BEGIN SUPER",
                b"ENDDATA",
            ];
            words
                .iter()
                .any(|word| begins(line.trim_ascii_start(), word))
        })
}

/// Reads a deck and what it includes.
///
/// # Errors
/// [`Error::Line`] for what can't be read, [`Error::Location`] for elements and grids that don't fit each other.
pub(crate) fn read(path: &Path) -> Result<(FoundMesh, String), Error> {
    let mut deck = Deck::open(path)?;
    let mut reading = Reading::default();
    let mut text = Vec::new();
    while deck.advance()? {
        plain(deck.line(), &mut text);
        let is_end = text.trim_ascii().eq_ignore_ascii_case(b"ENDDATA");
        if !is_end && !text.trim_ascii().is_empty() {
            deck.refuse_open_end()?;
        }
        match reading.take(&text) {
            Ok(Next::Line) => {}
            Ok(Next::End) => break,
            Ok(Next::File(name)) => deck.include(&name)?,
            Err(message) => return Err(deck.refused(message)),
        }
    }
    reading
        .end_card()
        .map_err(|message| deck.refused(message))?;
    let bytes = deck.bytes();
    let (sha256, included) = deck.finish()?;
    let mesh = reading.model.finish(path, bytes, reading.control)?;
    Ok((FoundMesh { included, ..mesh }, sha256))
}

/// What to go on with.
enum Next {
    Line,
    File(String),
    End,
}

/// A deck as far as it is read.
#[derive(Default)]
struct Reading {
    model: Model,
    control: CaseControl,
    card: Card,
    /// Whether `card` is one that counts, and may go on.
    is_in_card: bool,
    /// A quoted name of a file that goes on in the next line.
    include: Option<String>,
}

impl Reading {
    /// Takes a line without comment.
    fn take(&mut self, text: &[u8]) -> Result<Next, String> {
        if let Some(before) = self.include.take() {
            return self.include(before + &String::from_utf8_lossy(text.trim_ascii()));
        }
        if text.is_empty() {
            return Ok(Next::Line);
        }
        if self.control.takes(text)? {
            self.end_card()?;
            return Ok(Next::Line);
        }
        let line = CardLine::of(text);
        if line.is_continuation() {
            if self.is_in_card {
                self.card.go_on(&line)?;
            }
            return Ok(Next::Line);
        }
        self.end_card()?;
        let head = String::from_utf8_lossy(line.head).to_ascii_uppercase();
        let name = head.strip_suffix('*').unwrap_or(&head).trim_end();
        if is_wanted(name) {
            self.card.begin(&line)?;
            self.is_in_card = true;
            return Ok(Next::Line);
        }
        let first = head.split_ascii_whitespace().next().unwrap_or_default();
        if first.len() < head.len()
            && is_wanted(first.trim_end_matches('*'))
            && text.contains(&b',')
        {
            return Err(format!(
                "{first} has commas between its columns; fields stand in columns or between commas, and decimals have a point"
            ));
        }
        match first.trim_end_matches('\'') {
            "ENDDATA" => return Ok(Next::End),
            "BEGIN" => self.model.begin_section(),
            "INCLUDE" => {
                let rest = text.trim_ascii_start().get("INCLUDE".len()..);
                let name = String::from_utf8_lossy(rest.unwrap_or_default());
                return self.include(name.trim().to_owned());
            }
            _ => {}
        }
        Ok(Next::Line)
    }

    /// A name in quotes may go on in further lines.
    fn include(&mut self, name: String) -> Result<Next, String> {
        let quote = name.chars().next().filter(|c| matches!(c, '\'' | '"'));
        let Some(quote) = quote else {
            return match name.is_empty() {
                true => Err("INCLUDE names no file".into()),
                false => Ok(Next::File(name)),
            };
        };
        match name[1..].split_once(quote) {
            Some((name, _)) => Ok(Next::File(name.to_owned())),
            None if name.len() > LONGEST_NAME => Err("INCLUDE has a quote that doesn't end".into()),
            None => {
                self.include = Some(name);
                Ok(Next::Line)
            }
        }
    }

    fn end_card(&mut self) -> Result<(), String> {
        if std::mem::take(&mut self.is_in_card) {
            self.model.card(&self.card)?;
        }
        Ok(())
    }
}

/// Bytes of a file's name.
const LONGEST_NAME: usize = 4096;
