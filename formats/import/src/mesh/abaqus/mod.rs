//! Input decks of Abaqus and CalculiX (`.inp`): nodes, elements, sets, and which nodes aren't free.
//!
//! Keywords that make nodes without listing them, and coordinates in systems of their own, are refused. Steps, materials, loads are skipped.
//! Unknown element types keep their nodes under their own name.

mod constraints;
mod data_lines;
mod element_types;
mod finish;
mod keyword;
mod model;

use std::path::Path;

use dcb_formats::Error;

use super::FoundMesh;
use super::deck::Deck;
use super::fields::shown;
use keyword::Keyword;
use model::Model;

/// Whether a text is such a deck: keywords, among them one that a mesh begins with.
pub(crate) fn recognises(start: &[u8]) -> bool {
    let lines = start.split(|byte| *byte == b'\n').map(<[u8]>::trim_ascii);
    let mut lines = lines.filter(|line| !line.is_empty() && !line.starts_with(b"**"));
    let is_keyword = |line: &[u8]| {
        line.first() == Some(&b'*')
            && line[1..]
                .trim_ascii_start()
                .first()
                .is_some_and(u8::is_ascii_alphabetic)
    };
    let Some(first) = lines.next().filter(|line| is_keyword(line)) else {
        return false;
    };
    let begins_mesh = |line: &[u8]| {
        let name = Keyword::parse(&String::from_utf8_lossy(line)).name;
        let names = ["NODE", "ELEMENT", "INCLUDE", "PART", "INSTANCE", "HEADING"];
        names.contains(&name.as_str())
    };
    begins_mesh(first) || lines.any(|line| is_keyword(line) && begins_mesh(line))
}

/// Reads a deck and what it includes.
///
/// # Errors
/// [`Error::Line`] for what can't be read, [`Error::Location`] for elements and nodes that don't fit each other.
pub(crate) fn read(path: &Path) -> Result<(FoundMesh, String), Error> {
    let mut deck = Deck::open(path)?;
    let mut model = Model::default();
    // A keyword line that ends with a comma goes on in the next one.
    let mut unfinished: Option<String> = None;
    while deck.advance()? {
        let line = deck.line().trim_ascii();
        if line.is_empty() || line.starts_with(b"**") {
            continue;
        }
        let is_keyword = line.first() == Some(&b'*');
        if !is_keyword {
            deck.refuse_open_end()?;
        }
        let mut include = None;
        let done = if is_keyword || unfinished.is_some() {
            let text = String::from_utf8_lossy(line);
            let whole = match unfinished.take() {
                Some(before) if !is_keyword => before + &text,
                Some(before) => {
                    return Err(deck.refused(format!(
                        "a keyword before it ends with a comma: {}",
                        shown(before.as_bytes())
                    )));
                }
                None => text.into_owned(),
            };
            if whole.ends_with(',') && whole.len() < LONGEST_KEYWORD {
                unfinished = Some(whole);
                continue;
            }
            model
                .keyword(&Keyword::parse(&whole))
                .map(|name| include = name)
        } else {
            model.data(line)
        };
        if let Err(message) = done {
            return Err(deck.refused(message));
        }
        if let Some(name) = include {
            deck.include(&name)?;
        }
    }
    if let Some(before) = unfinished {
        return Err(deck.refused(format!(
            "a keyword at the end ends with a comma: {}",
            shown(before.as_bytes())
        )));
    }
    model.end_data().map_err(|message| deck.refused(message))?;
    let bytes = deck.bytes();
    let (sha256, included) = deck.finish()?;
    let mesh = model.finish(path, bytes)?;
    Ok((FoundMesh { included, ..mesh }, sha256))
}

/// Bytes of a keyword with its continuation lines, at most.
const LONGEST_KEYWORD: usize = 1 << 16;
