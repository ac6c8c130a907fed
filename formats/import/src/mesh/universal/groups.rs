//! Groups of nodes and elements.

use dcb_formats::Error;
use indexmap::IndexMap;

use super::super::FoundMesh;
use super::super::cells::{CellIndex, Cells, has_volume};
use super::super::fields;
use super::super::node_sets::{Marks, TooMuch};
use super::super::nodes::LabelIndex;
use super::Datasets;

/// Kinds of members.
const NODE: i64 = 7;
const ELEMENT: i64 = 8;

/// Labels in a group.
#[derive(Debug, Default)]
struct Group {
    nodes: Vec<u32>,
    elements: Vec<u32>,
}

/// Groups by their names; those of the same name are one.
#[derive(Debug, Default)]
pub(super) struct Groups(IndexMap<String, Group>);

impl Groups {
    /// Reads groups whose members have so many numbers each, the first two a kind and a label.
    pub fn read(&mut self, source: &mut Datasets, width: usize) -> Result<(), Error> {
        while let Some(numbers) = source.record()? {
            // The last number is how many members there are.
            let (Some(number), Some(count)) = (numbers.first().copied(), numbers.last().copied())
            else {
                return Err(source
                    .lines
                    .refused("is empty; expected the head of a group"));
            };
            let name = String::from_utf8_lossy(source.needed_line()?)
                .trim()
                .to_owned();
            if name.contains(char::is_control) {
                return Err(source
                    .lines
                    .refused("is no name of a group: it has a control character"));
            }
            let name = match name.is_empty() {
                true => format!("group_{number}"),
                false => name,
            };
            let group = self.0.entry(name).or_default();
            let mut found = 0;
            while found < count {
                for member in source.integers()?.to_vec().chunks(width) {
                    let &[kind, label, ..] = member else {
                        return Err(source.lines.refused("a member of a group has no label"));
                    };
                    let members = match kind {
                        NODE => &mut group.nodes,
                        ELEMENT => &mut group.elements,
                        _ => {
                            found += 1;
                            continue;
                        }
                    };
                    let label = fields::as_label(label);
                    members.push(label.map_err(|message| source.lines.refused(message))?);
                    found += 1;
                }
            }
            if found > count {
                return Err(source
                    .lines
                    .refused(format!("has more members than the {count} announced")));
            }
        }
        Ok(())
    }

    /// Groups as sets; those with a volume's elements are sets of cells.
    pub fn into_sets(
        self,
        nodes: &LabelIndex,
        cells: &Cells,
        cell_index: &CellIndex,
        marks: &mut Marks,
        mesh: &mut FoundMesh,
    ) -> Result<(), TooMuch> {
        for (name, group) in self.0 {
            let mut members = Vec::new();
            let mut unknown = 0;
            let mut is_of_cells = false;
            marks.start();
            for label in &group.nodes {
                match nodes.place(*label) {
                    Some(node) => marks.put(&mut members, node)?,
                    None => unknown += 1,
                }
            }
            for label in &group.elements {
                let Some(place) = cell_index.index.place(*label) else {
                    unknown += 1;
                    continue;
                };
                let (cell_type, cell) = cells.cell(cell_index, place);
                is_of_cells |= has_volume(cell_type);
                for node in cell {
                    marks.put(&mut members, *node)?;
                }
            }
            if unknown > 0 {
                mesh.notes.push(format!(
                    "group {name}: {unknown} labels that no node and no element has are left out"
                ));
            }
            match is_of_cells {
                true => mesh.cell_sets.push((name, members)),
                false => mesh.sets.push((name, members)),
            }
        }
        Ok(())
    }
}
