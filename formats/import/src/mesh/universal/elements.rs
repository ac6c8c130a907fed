//! Elements of universal files as cells.

use dcb_formats::Error;

use super::super::fields;
use super::{Datasets, Model};

/// Nodes of an element, at most.
const MOST_NODES: i64 = 1000;

/// Corner, middle, corner round each face; meshio has the corners first.
const LINE3: [usize; 3] = [0, 2, 1];
const TRIANGLE6: [usize; 6] = [0, 2, 4, 1, 3, 5];
const QUAD8: [usize; 8] = [0, 2, 4, 6, 1, 3, 5, 7];
const TETRA10: [usize; 10] = [0, 2, 4, 9, 1, 3, 5, 6, 7, 8];
const WEDGE15: [usize; 15] = [0, 2, 4, 9, 11, 13, 1, 3, 5, 10, 12, 14, 6, 7, 8];
const HEXAHEDRON20: [usize; 20] = [
    0, 2, 4, 6, 12, 14, 16, 18, 1, 3, 5, 7, 13, 15, 17, 19, 8, 9, 10, 11,
];

/// Cell of a finite element by its descriptor, and the places of its nodes where the order differs.
fn cell_of(descriptor: i64) -> Option<(&'static str, usize, Option<&'static [usize]>)> {
    Some(match descriptor {
        11 | 21 | 22 => ("line", 2, None),
        24 => ("line3", 3, Some(&LINE3)),
        41 | 51 | 61 | 71 | 81 | 91 => ("triangle", 3, None),
        42 | 52 | 62 | 72 | 82 | 92 => ("triangle6", 6, Some(&TRIANGLE6)),
        44 | 54 | 64 | 74 | 84 | 94 => ("quad", 4, None),
        45 | 55 | 65 | 75 | 85 | 95 => ("quad8", 8, Some(&QUAD8)),
        111 => ("tetra", 4, None),
        112 => ("wedge", 6, None),
        113 => ("wedge15", 15, Some(&WEDGE15)),
        115 => ("hexahedron", 8, None),
        116 => ("hexahedron20", 20, Some(&HEXAHEDRON20)),
        118 => ("tetra10", 10, Some(&TETRA10)),
        _ => return None,
    })
}

impl Model {
    /// Label, descriptor, ..., number of nodes; one more line for beams; the nodes, eight a line.
    pub(super) fn elements(&mut self, source: &mut Datasets, dataset: u32) -> Result<(), Error> {
        let width = if dataset == 780 { 8 } else { 6 };
        let mut nodes = Vec::new();
        while let Some(numbers) = source.record()? {
            let numbers: [i64; 3] = match numbers {
                [label, descriptor, .., count] if numbers.len() == width => {
                    [*label, *descriptor, *count]
                }
                _ => {
                    let found = numbers.len();
                    return Err(source
                        .lines
                        .refused(format!("an element has {found} numbers, expected {width}")));
                }
            };
            let [label, descriptor, count] = numbers;
            let label = fields::as_label(label).map_err(|message| source.lines.refused(message))?;
            if matches!(descriptor, 11 | 21..=24) {
                source.needed_line()?;
            }
            if !(1..=MOST_NODES).contains(&count) {
                return Err(source
                    .lines
                    .refused(format!("element {label} has {count} nodes")));
            }
            nodes.clear();
            while nodes.len() < count as usize {
                for node in source.integers()?.to_vec() {
                    let node = fields::as_label(node);
                    nodes.push(node.map_err(|message| source.lines.refused(message))?);
                }
            }
            let cell = cell_of(descriptor);
            let expected = cell.map_or(count as usize, |(_, count, _)| count);
            if nodes.len() != count as usize || nodes.len() != expected {
                return Err(source.lines.refused(format!(
                    "element {label} of type {descriptor} has {} nodes, expected {expected}",
                    nodes.len()
                )));
            }
            match cell {
                Some((name, count, Some(order))) => {
                    let block = self.cells.block(name, count);
                    self.cells
                        .push(block, label, order.iter().map(|at| nodes[*at]));
                }
                Some((name, count, None)) => {
                    let block = self.cells.block(name, count);
                    self.cells.push(block, label, nodes.iter().copied());
                }
                None => {
                    let block = self
                        .cells
                        .block(&format!("unv_type_{descriptor}"), nodes.len());
                    self.cells.push(block, label, nodes.iter().copied());
                }
            }
        }
        Ok(())
    }
}
