//! Physical groups as sets of nodes.

use indexmap::IndexMap;

use super::super::FoundMesh;
use super::super::cells::Cells;
use super::super::node_sets::{Marks, TooMuch};

/// A physical group: its dimension and number.
pub(super) type Group = (u8, i64);

/// Cells of a block: block, first, behind the last.
pub(super) type CellRange = (usize, usize, usize);

/// Names and cells of physical groups.
#[derive(Debug, Default)]
pub(super) struct Groups {
    names: IndexMap<Group, String>,
    cells: IndexMap<Group, Vec<CellRange>>,
}

impl Groups {
    /// A name of `$PhysicalNames`.
    pub fn name(&mut self, group: Group, name: String) {
        self.names.insert(group, name);
        self.cells.entry(group).or_default();
    }

    /// Cells that belong to a group.
    pub fn put(&mut self, group: Group, range: CellRange) {
        let ranges = self.cells.entry(group).or_default();
        match ranges.last_mut() {
            Some(last) if last.0 == range.0 && last.2 == range.1 => last.2 = range.2,
            _ => ranges.push(range),
        }
    }

    /// The nodes of each group. Those of the same name are one set; groups of volumes are apart.
    pub fn into_sets(
        self,
        cells: &Cells,
        marks: &mut Marks,
        mesh: &mut FoundMesh,
    ) -> Result<(), TooMuch> {
        let mut named: IndexMap<(bool, String), Vec<CellRange>> = IndexMap::new();
        for (group, ranges) in self.cells {
            let (dimension, number) = group;
            let kind = ["point", "curve", "surface", "volume"][usize::from(dimension.min(3))];
            let name = self.names.get(&group).cloned();
            let name = name.unwrap_or_else(|| format!("{kind}_{number}"));
            named
                .entry((dimension == 3, name))
                .or_default()
                .extend(ranges);
        }
        for ((is_volume, name), ranges) in named {
            let mut nodes = Vec::new();
            marks.start();
            for (block, first, end) in ranges {
                for node in cells.nodes(block, first, end) {
                    marks.put(&mut nodes, *node)?;
                }
            }
            match is_volume {
                true => mesh.cell_sets.push((name, nodes)),
                false => mesh.sets.push((name, nodes)),
            }
        }
        Ok(())
    }
}
