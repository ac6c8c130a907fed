//! Lists of nodes: a line `label x y z` for each, with blanks, tabs, semicolons or commas between, as programs and spreadsheets save them.
//!
//! Ansys' `NLIST` may have three angles behind the place, in degrees: the node's own axes, turned about z, then about the new x, then about the
//! new y (THXY, THYZ, THZX). Its pages repeat the head.
//!
//! Decimal commas are read where fields are separated by something else; a head of words in any language is skipped. There are no cells and
//! no sets.

use std::path::Path;

use dcb_formats::Error;
use nalgebra::{Rotation3, Vector3};
use rustc_hash::FxHashMap;

use super::FoundMesh;
use crate::stored::LARGEST_LABEL;
use crate::text::lines::Lines;
use crate::text::real::whole_real;

/// Lines of a head that are skipped.
const LONGEST_HEAD: usize = 20;
/// Lines that must be of nodes for a text to be a list of them.
const LOOKED_AT: usize = 4;

/// Lines of nodes, behind a head of words.
pub(super) fn recognises(start: &[u8]) -> bool {
    let lines = start.split(|byte| *byte == b'\n').map(<[u8]>::trim_ascii);
    let mut nodes = 0;
    for (number, line) in lines.filter(|line| !line.is_empty()).enumerate() {
        match node(line) {
            Ok(Some(_)) => nodes += 1,
            Ok(None) if nodes == 0 && number < LONGEST_HEAD => {}
            _ => return nodes >= LOOKED_AT,
        }
        if nodes == LOOKED_AT {
            return true;
        }
    }
    nodes > 0
}

/// A line of the list.
struct Node {
    label: u64,
    place: [f64; 3],
    /// About z, x and y, in degrees.
    angles: [f64; 3],
}

/// The node of a line; `None` for a line of words, or what is wrong with its numbers.
fn node(line: &[u8]) -> Result<Option<Node>, String> {
    let is_blank = |byte: &u8| matches!(byte, b' ' | b'\t' | b';');
    let by_blanks: Vec<&[u8]> = line
        .split(is_blank)
        .filter(|field| !field.is_empty())
        .collect();
    let fields = match by_blanks.len() {
        1 => line
            .split(|byte| *byte == b',')
            .map(<[u8]>::trim_ascii)
            .collect(),
        _ => by_blanks
            .iter()
            .map(|field| field.strip_suffix(b",").unwrap_or(field))
            .collect::<Vec<_>>(),
    };
    let (label, places, turns) = match fields[..] {
        [label, x, y, z] => (label, [x, y, z], None),
        [label, x, y, z, about_z, about_x, about_y] => {
            (label, [x, y, z], Some([about_z, about_x, about_y]))
        }
        _ => return Ok(None),
    };
    if label.is_empty() || !label.iter().all(u8::is_ascii_digit) {
        return Ok(None);
    }
    let text = |field: &[u8]| String::from_utf8_lossy(field).into_owned();
    let label = std::str::from_utf8(label)
        .ok()
        .and_then(|label| label.parse().ok());
    let label = label.ok_or_else(|| "the label has too many digits".to_owned())?;
    let (mut place, mut angles) = ([0.0; 3], [0.0; 3]);
    let turns = turns.iter().flatten();
    let numbers = place.iter_mut().chain(&mut angles);
    for (number, field) in numbers.zip(places.iter().chain(turns)) {
        if field.contains(&b',') && field.contains(&b'.') {
            return Err(format!(
                "`{}` has both a comma and a point; expected one of them as decimal mark and no marks of thousands",
                text(field)
            ));
        }
        *number = whole_real(field)
            .map_err(|_| format!("`{}`; expected a finite coordinate", text(field)))?;
    }
    Ok(Some(Node {
        label,
        place,
        angles,
    }))
}

/// The axes of a node that is turned by angles in degrees, in the axes of the places, one a row: Rz Rx Ry has them in its columns.
fn own_axes([about_z, about_x, about_y]: [f64; 3]) -> [[f64; 3]; 3] {
    let turn = |axis, degrees: f64| Rotation3::from_axis_angle(&axis, degrees.to_radians());
    let turned = turn(Vector3::z_axis(), about_z)
        * turn(Vector3::x_axis(), about_x)
        * turn(Vector3::y_axis(), about_y);
    let column = |axis: usize| turned.matrix().column(axis).into_owned();
    [0, 1, 2].map(|axis| column(axis).into())
}

pub(super) fn read(path: &Path) -> Result<(FoundMesh, String), Error> {
    let mut lines = Lines::open(path)?;
    let (mut points, mut labels) = (Vec::new(), Vec::new());
    let mut displacement_axes = Vec::new();
    let mut head: Vec<Vec<u8>> = Vec::new();
    let mut first: FxHashMap<u32, u64> = FxHashMap::default();
    let mut has_comma = false;
    while let Some(line) = lines.next_line()? {
        let line = line.trim_ascii();
        if line.is_empty() {
            continue;
        }
        let is_decimal = line.contains(&b',');
        let read = node(line);
        let is_known = head.iter().any(|known| known == line);
        let words = matches!(read, Ok(None)).then(|| line.to_vec());
        if matches!(read, Ok(Some(_))) {
            lines.refuse_open_end()?;
        }
        let Node {
            label,
            place,
            angles,
        } = match read {
            Ok(Some(node)) => node,
            Ok(None) if is_known => continue,
            Ok(None) if points.is_empty() && head.len() < LONGEST_HEAD => {
                head.extend(words);
                continue;
            }
            Ok(None) => {
                return Err(lines.refused("expected `label x y z`, the label and place of a node"));
            }
            Err(message) => return Err(lines.refused(message)),
        };
        has_comma |= is_decimal;
        let label = match u32::try_from(label) {
            Ok(label) if (1..=LARGEST_LABEL).contains(&label) => label,
            _ => {
                return Err(lines.refused(format!(
                    "label {label}; expected labels from 1 to {LARGEST_LABEL}"
                )));
            }
        };
        if let Some(before) = first.insert(label, lines.number()) {
            return Err(lines.refused(format!("node {label} is in line {before} already")));
        }
        if angles != [0.0; 3] {
            displacement_axes.push((points.len() as u32, own_axes(angles)));
        }
        points.push(place);
        labels.push(label);
    }
    let mut notes = vec![
        "a list of nodes has no cells and no sets: interfaces need nodes named in the component file, or another mesh".to_owned(),
    ];
    if has_comma {
        notes.push("commas in numbers were read as decimal marks".to_owned());
    }
    let found = FoundMesh {
        points,
        labels: Some(labels),
        displacement_axes,
        notes,
        ..FoundMesh::default()
    };
    Ok((found, lines.finish()?))
}
