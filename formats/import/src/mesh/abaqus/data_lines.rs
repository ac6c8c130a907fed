//! Lines of data: the nodes of elements, which may go on in further lines, and coordinates.

use super::super::cells::Cells;
use super::super::fields;
use super::element_types::order_of;

/// Numbers in a line that may go on without a comma at its end.
const FULL_LINE: usize = 10;

/// Elements of one keyword.
#[derive(Debug)]
pub(super) struct Elements {
    pub element_type: String,
    /// Cell and nodes, if the type is known.
    pub cell: Option<(&'static str, usize)>,
    pub set: Option<usize>,
    /// Label and nodes of the element that is being read.
    pub pending: Vec<u32>,
}

/// A line of data between commas.
pub(super) struct Line<'a> {
    pub fields: &'a [&'a [u8]],
    pub goes_on: bool,
}

impl<'a> Line<'a> {
    /// The fields of a line, without empty ones at its end.
    ///
    /// # Errors
    /// They are more than there is room for.
    pub fn of(line: &'a [u8], room: &'a mut [&'a [u8]; 64]) -> Result<Self, String> {
        let mut count = 0;
        for field in line.split(|byte| *byte == b',') {
            let place = room.get_mut(count);
            *place.ok_or("has more than 64 fields")? = field.trim_ascii();
            count += 1;
        }
        while count > 0 && room[count - 1].is_empty() {
            count -= 1;
        }
        Ok(Self {
            fields: &room[..count],
            goes_on: line.last() == Some(&b','),
        })
    }
}

impl Elements {
    /// Takes numbers of a line; whether the element is complete.
    pub fn take(&mut self, line: &Line) -> Result<bool, String> {
        for field in line.fields {
            let number = fields::label(field);
            self.pending
                .push(number.map_err(|message| match self.pending.first() {
                    Some(label) => format!("element {label}: {message}"),
                    None => format!("element: {message}"),
                })?);
        }
        let is_full = line.goes_on || line.fields.len() >= FULL_LINE;
        Ok(match self.cell {
            Some((_, wanted)) => self.pending.len() > wanted || !is_full,
            None => !line.goes_on,
        })
    }

    /// Makes a cell of the element that is being read; gives its label.
    pub fn end(&mut self, cells: &mut Cells) -> Result<Option<u32>, String> {
        let Some((label, nodes)) = self.pending.split_first() else {
            return Ok(None);
        };
        let (label, element_type) = (*label, &self.element_type);
        let expected = |wanted: usize| {
            format!(
                "element {label} of type {element_type} has {} nodes, expected {wanted}",
                nodes.len()
            )
        };
        match self.cell {
            Some((_, wanted)) if nodes.len() < wanted => {
                return Err(expected(wanted) + "; a line that goes on ends with a comma");
            }
            // Beams name a node for their orientation behind their own.
            Some(("line" | "line3", _)) => {}
            Some((_, wanted)) if nodes.len() > wanted => return Err(expected(wanted)),
            None if nodes.is_empty() => return Err(format!("element {label} has no nodes")),
            _ => {}
        }
        let (cell, count) = self.cell.unwrap_or((element_type, nodes.len()));
        let block = cells.block(cell, count);
        match order_of(cell) {
            Some(order) => cells.push(block, label, order.iter().map(|at| nodes[*at])),
            None => cells.push(block, label, nodes[..count].iter().copied()),
        }
        self.pending.clear();
        Ok(Some(label))
    }
}

/// Coordinates; those that aren't there are 0. Behind them may stand a normal of unit length.
pub(super) fn point(fields: &[&[u8]]) -> Result<[f64; 3], String> {
    let mut numbers = [0.0; 6];
    if fields.len() > numbers.len() {
        return Err(format!(
            "has {} numbers behind the label, expected three coordinates; decimals have a point, not a comma",
            fields.len()
        ));
    }
    for (number, field) in numbers.iter_mut().zip(fields) {
        if !field.is_empty() {
            *number = fields::real(field)?;
        }
    }
    let [x, y, z, normal @ ..] = numbers;
    let length = normal.iter().map(|n| n * n).sum::<f64>();
    if fields.len() > 3 && length != 0.0 && (length - 1.0).abs() > 1e-2 {
        return Err(format!(
            "has {} numbers behind the label that are no coordinates and unit normal; decimals have a point, not a comma",
            fields.len()
        ));
    }
    Ok([x, y, z])
}
