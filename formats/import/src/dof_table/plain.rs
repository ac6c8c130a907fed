//! Tables of one row a line, in blanks, tabs, commas or semicolons: `label direction`, or the mapping table of Ansys' HBMAT,
//! `equation label direction`.
//!
//! Directions are names or numbers. Heads in any language come before the first row. The table of HBMAT is a listing, in which heads may come
//! again, and its equations may come in any order; each has one line.

use std::path::Path;

use dcb_formats::Error;
use dcb_formats::matrix::blocks::shown;
use dcb_formats::mesh::Direction;

use super::direction::{label, named};
use super::lines::TableLines;
use super::{DofTable, KINDS, RowList};
use crate::stored::row_key::{RowKey, direction, no_direction};
use crate::text::real::whole_real;

/// A line of a table.
#[derive(Clone, Debug)]
struct Row {
    /// 1-based.
    equation: Option<u32>,
    node: u32,
    direction: Told,
    line: u64,
}

/// A direction as a table tells it.
#[derive(Clone, Debug)]
enum Told {
    Named(Direction),
    /// From 0 or from 1.
    Number(u64),
}

/// Reads the file.
pub(super) fn read(path: &Path, row_count: usize) -> Result<DofTable, Error> {
    let mut lines = TableLines::open(path)?;
    let mut rows: Vec<Row> = Vec::new();
    while let Some(line) = lines.next_filled()? {
        let fields = fields(&line);
        let is_listing = rows.first().is_some_and(|row| row.equation.is_some());
        let is_row = match (rows.first(), &fields[..]) {
            (_, [equation, node, _]) => {
                (rows.is_empty() || is_listing) && are_integers(&[equation, node])
            }
            (_, [node, _]) => !is_listing && are_integers(&[node]),
            _ => false,
        };
        if is_row {
            if rows.len() == row_count {
                return Err(lines.refused(format!(
                    "one row more than the {row_count} of the matrix; this table belongs to another one"
                )));
            }
            let row = row(&fields, lines.number()).map_err(|message| lines.refused(message))?;
            rows.push(row);
        } else if !rows.is_empty() && !is_listing {
            return Err(lines.refused(format!("`{}`; expected `label direction`", shown(&line))));
        }
    }
    let sha256 = lines.finish()?;
    if rows.is_empty() {
        return Err(Error::File {
            path: path.into(),
            message: format!("has no row of a table of degrees of freedom; expected {KINDS}"),
        });
    }
    let bad = |(line, message)| Error::Line {
        path: path.into(),
        line,
        message,
    };
    let notes = count_from_one(&mut rows).map_err(bad)?;
    in_order_of_equations(&mut rows, row_count).map_err(bad)?;
    let mut list = RowList::new(row_count);
    for row in rows {
        let key = key(&row).map_err(|message| bad((row.line, message)))?;
        list.push(key, row.line)
            .map_err(|message| bad((row.line, message)))?;
    }
    Ok(DofTable {
        rows: list.finish(path, "every row has a node and direction of its own")?,
        sha256,
        notes,
    })
}

/// Fields without quotation marks.
fn fields(line: &[u8]) -> Vec<&[u8]> {
    let is_separator = |byte: &u8| matches!(byte, b',' | b';') || byte.is_ascii_whitespace();
    line.split(is_separator)
        .map(|field| field.strip_prefix(b"\"").unwrap_or(field))
        .map(|field| field.strip_suffix(b"\"").unwrap_or(field))
        .filter(|field| !field.is_empty())
        .collect()
}

/// An integer, which may be printed as a real number.
fn integer(field: &[u8]) -> Option<u64> {
    let value = whole_real(field).ok()?;
    let is_integer = (0.0..1e15).contains(&value) && value.fract() == 0.0;
    is_integer.then_some(value as u64)
}

fn are_integers(fields: &[&[u8]]) -> bool {
    fields.iter().all(|field| integer(field).is_some())
}

/// The row of a line whose fields are two or three.
fn row(fields: &[&[u8]], line: u64) -> Result<Row, String> {
    let (direction, before) = fields.split_last().ok_or("an empty line")?;
    let (node, before) = before.split_last().ok_or("one field")?;
    let number = integer(node).unwrap_or_default();
    let node = label(number.to_string().as_bytes())?;
    let equation = before.first().and_then(|field| integer(field));
    Ok(Row {
        equation: equation.map(|equation| u32::try_from(equation).unwrap_or(u32::MAX)),
        node,
        direction: match integer(direction) {
            Some(number) => Told::Number(number),
            None => Told::Named(named(direction)?),
        },
        line,
    })
}

/// Directions that are counted from 0, as ansys-mapdl-reader does, are counted from 1; a note says so.
fn count_from_one(rows: &mut [Row]) -> Result<Vec<String>, (u64, String)> {
    let is_zero = |row: &&Row| matches!(row.direction, Told::Number(0));
    let Some(zero) = rows.iter().find(is_zero) else {
        return Ok(Vec::new());
    };
    let first = zero.line;
    for row in rows {
        match &mut row.direction {
            Told::Number(number @ 0..6) => *number += 1,
            Told::Number(6) => {
                return Err((
                    row.line,
                    format!(
                        "direction 6, but 0 in line {first}; expected numbers from 1 to 6, or from 0 to 5"
                    ),
                ));
            }
            _ => {}
        }
    }
    Ok(vec![format!(
        "direction 0 in line {first}: directions are taken as counted from 0, 0 to 5 for ux, uy, uz, rx, ry, rz"
    )])
}

/// Sorts a listing by its equations, which are those of all rows, each once.
fn in_order_of_equations(rows: &mut [Row], row_count: usize) -> Result<(), (u64, String)> {
    rows.sort_by_key(|row| row.equation);
    for (place, row) in rows.iter().enumerate() {
        let expected = place as u64 + 1;
        match row.equation.map(u64::from) {
            None => return Ok(()),
            Some(equation) if equation == expected => {}
            Some(equation) if equation < expected => {
                return Err((
                    row.line,
                    format!("equation {equation}, which another line has already"),
                ));
            }
            Some(equation) => {
                return Err((
                    row.line,
                    format!(
                        "equation {equation}, but no line has equation {expected}; expected one line for each of the {row_count} rows"
                    ),
                ));
            }
        }
    }
    Ok(())
}

fn key(row: &Row) -> Result<RowKey, String> {
    match row.direction {
        Told::Named(direction) => Ok(RowKey::nodal(row.node, direction)),
        Told::Number(number) => direction(number)
            .map(|direction| RowKey::nodal(row.node, direction))
            .ok_or_else(|| no_direction(row.node, number)),
    }
}
