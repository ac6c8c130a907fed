//! The numbers of the matrices, read in blocks of lines.

use std::path::Path;

use dcb_formats::Error;
use dcb_formats::matrix::blocks::{NotANumber, TextBlocks, likely_line_count, shown};

use super::head::{is_keyword, parameter};
use crate::text::cursor::{Cursor, Stopped};
use crate::text::line_blocks::{LineBlock, read_line_blocks, refuse_open_end};
use crate::text::real::Digits;

/// A dense matrix of the file: its numbers one after the other.
pub(super) struct Dense {
    /// As its type is called.
    pub(super) name: String,
    /// 1-based line of its keyword.
    pub(super) line: u64,
    pub(super) digits: Digits,
    pub(super) parts: Vec<Part>,
}

impl Dense {
    /// Numbers that it has.
    pub(super) fn count(&self) -> usize {
        self.parts.iter().map(|part| part.values.len()).sum()
    }
}

/// Numbers of one block of lines.
#[derive(Debug, Default)]
pub(super) struct Part {
    pub(super) values: Vec<f64>,
    /// Numbers in each line; none in comments.
    pub(super) line_counts: Vec<u8>,
    /// 1-based line of the first count; 0-based in the block while that is read.
    pub(super) first_line: u64,
}

/// Lines behind a keyword, in one block.
#[derive(Debug, Default)]
struct Section {
    /// None where the block before has it.
    keyword: Option<Keyword>,
    part: Part,
    digits: Digits,
}

#[derive(Debug)]
enum Keyword {
    /// With its type.
    Matrix(String),
    /// Its lines are passed over.
    Other,
    /// Another substructure.
    Element,
}

/// Types of the matrices; numbers are passed over.
pub(super) fn types(
    path: &Path,
    text: &mut TextBlocks,
    lines_before: u64,
) -> Result<Vec<String>, Error> {
    let work = |cursor: &mut Cursor<'_>, found: &mut Vec<String>| {
        while cursor.advance(b"**") {
            if cursor.byte() == Some(b'*')
                && let Keyword::Matrix(name) = keyword(cursor)?
            {
                found.push(name);
            }
            cursor.pass_line();
        }
        Ok(())
    };
    let blocks = read_line_blocks(path, text, lines_before, work)?;
    Ok(blocks.into_iter().flat_map(|block| block.content).collect())
}

/// Numbers of all matrices, in file order.
pub(super) fn read_matrices(
    path: &Path,
    text: &mut TextBlocks,
    lines_before: u64,
) -> Result<Vec<Dense>, Error> {
    let blocks: Vec<LineBlock<Vec<Section>>> =
        read_line_blocks(path, text, lines_before, read_block)?;
    refuse_open_end(path, &blocks)?;
    let mut matrices: Vec<Dense> = Vec::new();
    let mut is_in_matrix = false;
    for block in blocks {
        let first_line = block.first_line;
        for mut section in block.content {
            section.part.first_line += first_line;
            let line = section.part.first_line;
            match section.keyword {
                Some(Keyword::Element) => {
                    return Err(Error::Line {
                        path: path.into(),
                        line,
                        message: "a second *USER ELEMENT; expected one substructure in a file"
                            .into(),
                    });
                }
                Some(Keyword::Other) => is_in_matrix = false,
                Some(Keyword::Matrix(name)) => {
                    is_in_matrix = true;
                    matrices.push(Dense {
                        name,
                        line,
                        digits: Digits::default(),
                        parts: Vec::new(),
                    });
                }
                None => {}
            }
            if let Some(matrix) = matrices.last_mut().filter(|_| is_in_matrix) {
                matrix.digits.join(section.digits);
                matrix.parts.push(section.part);
            }
        }
    }
    Ok(matrices)
}

/// Numbers that most lines have.
const LINE_NUMBERS: usize = 4;

fn read_block(cursor: &mut Cursor<'_>, sections: &mut Vec<Section>) -> Result<(), Stopped> {
    let mut section = Section::default();
    let count = likely_line_count(cursor.text());
    let values = &mut section.part.values;
    if values.try_reserve_exact(LINE_NUMBERS * count).is_err() {
        return Err(Stopped::NoMemory {
            bytes: (LINE_NUMBERS * count * size_of::<f64>()) as u64,
        });
    }
    section.part.line_counts.reserve_exact(count);
    while cursor.advance(b"**") {
        if cursor.byte() == Some(b'*') {
            let next = Section {
                keyword: Some(keyword(cursor)?),
                part: Part {
                    first_line: u64::from(cursor.line()),
                    ..Part::default()
                },
                digits: Digits::default(),
            };
            sections.push(std::mem::replace(&mut section, next));
            cursor.pass_line();
            continue;
        }
        let line = (u64::from(cursor.line()) - section.part.first_line) as usize;
        let is_skipped = matches!(section.keyword, Some(Keyword::Other));
        let count = match is_skipped {
            true => {
                cursor.pass_line();
                0
            }
            false => numbers_of_line(cursor, &mut section)?,
        };
        // Comments and blank lines in between.
        section.part.line_counts.resize(line, 0);
        section.part.line_counts.push(count);
    }
    section.part.values.shrink_to_fit();
    sections.push(section);
    Ok(())
}

/// How many there are.
fn numbers_of_line(cursor: &mut Cursor<'_>, section: &mut Section) -> Result<u8, Stopped> {
    let mut count = 0u8;
    loop {
        match cursor.real(&mut section.digits) {
            Ok(value) => section.part.values.push(value),
            Err(NotANumber::NotFinite) => return Err(cursor.expected("finite numbers")),
            Err(_) => return Err(cursor.expected(NUMBERS)),
        }
        count = match count.checked_add(1) {
            Some(count) => count,
            None => return Err(cursor.expected(NUMBERS)),
        };
        cursor.pass_blanks();
        let has_comma = cursor.pass(b',');
        cursor.pass_blanks();
        match (cursor.is_line_end(), has_comma) {
            (true, _) => return Ok(count),
            (false, true) => {}
            (false, false) => return Err(cursor.expected(NUMBERS)),
        }
    }
}

const NUMBERS: &str = "numbers with commas between them, four in a line";

fn keyword(cursor: &Cursor<'_>) -> Result<Keyword, Stopped> {
    let line = cursor.whole_line();
    if is_keyword(line, b"*USER ELEMENT") {
        return Ok(Keyword::Element);
    }
    if !is_keyword(line, b"*MATRIX") {
        return Ok(Keyword::Other);
    }
    match parameter(line, "TYPE") {
        Some(name) if !name.is_empty() => Ok(Keyword::Matrix(shown(name))),
        _ => Err(cursor.expected("*MATRIX, TYPE=STIFFNESS or another type")),
    }
}
