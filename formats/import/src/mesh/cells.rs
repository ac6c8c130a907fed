//! Cells on their way from labels to places, a block for each type.

use std::collections::HashSet;
use std::path::Path;

use dcb_formats::Error;
use dcb_formats::mesh::CellBlock;
use indexmap::IndexMap;

use super::nodes::LabelIndex;

/// Cells whose nodes are named by labels.
#[derive(Debug, Default)]
pub(super) struct Cells {
    blocks: IndexMap<(String, usize), Block>,
}

#[derive(Debug, Default)]
struct Block {
    /// Label of each cell.
    labels: Vec<u32>,
    /// Nodes, cell after cell: labels, places at the end.
    nodes: Vec<u32>,
}

impl Cells {
    /// The block of a type with so many nodes each.
    pub fn block(&mut self, cell_type: &str, nodes_per_cell: usize) -> usize {
        // Most cells follow one of the same type.
        if let Some((last, ((name, count), _))) = self.blocks.iter().enumerate().next_back()
            && *count == nodes_per_cell
            && name == cell_type
        {
            return last;
        }
        let key = (cell_type.to_owned(), nodes_per_cell);
        let entry = self.blocks.entry(key);
        let at = entry.index();
        entry.or_default();
        at
    }

    /// One more cell, its nodes in meshio's order.
    pub fn push(&mut self, block: usize, label: u32, nodes: impl IntoIterator<Item = u32>) {
        let block = &mut self.blocks[block];
        block.labels.push(label);
        block.nodes.extend(nodes);
    }

    /// Number of cells.
    pub fn len(&self) -> usize {
        self.blocks.values().map(|block| block.labels.len()).sum()
    }

    /// Number of cells in a block.
    pub fn block_len(&self, block: usize) -> usize {
        self.blocks[block].labels.len()
    }

    /// Nodes of cells of a block, from one to before another.
    pub fn nodes(&self, block: usize, first: usize, end: usize) -> &[u32] {
        match self.blocks.get_index(block) {
            Some(((_, count), block)) => &block.nodes[first * count..end * count],
            None => &[],
        }
    }

    /// Cells with the same nodes in the same order stay once.
    pub fn drop_repeated(&mut self) {
        for ((_, count), block) in &mut self.blocks {
            let cells = std::mem::take(&mut block.nodes);
            let mut seen = HashSet::new();
            let mut kept = Vec::with_capacity(cells.len());
            for cell in cells.chunks_exact(*count) {
                if seen.insert(cell) {
                    kept.extend_from_slice(cell);
                }
            }
            block.nodes = kept;
            block.labels.clear();
        }
    }

    /// Labels become places.
    ///
    /// # Errors
    /// [`Error::Location`] with the cell and the label of a node that isn't there.
    pub fn tie(&mut self, path: &Path, index: &LabelIndex) -> Result<(), Error> {
        for ((cell_type, nodes_per_cell), block) in &mut self.blocks {
            for (at, node) in block.nodes.iter_mut().enumerate() {
                *node = index.place(*node).ok_or_else(|| Error::Location {
                    path: path.into(),
                    location: format!("element {}", block.labels[at / nodes_per_cell]),
                    message: format!("of type {cell_type} names node {node}, which isn't there"),
                })?;
            }
        }
        Ok(())
    }

    /// Places of cells by their labels: block and cell in it.
    ///
    /// # Errors
    /// [`Error::Location`] for a label that stands twice.
    pub fn by_label(&self, path: &Path) -> Result<CellIndex, Error> {
        let mut labels = Vec::with_capacity(self.len());
        let mut starts = Vec::with_capacity(self.blocks.len());
        for block in self.blocks.values() {
            starts.push(labels.len());
            labels.extend(&block.labels);
        }
        let index = LabelIndex::of(&labels);
        if let Some((first, _)) = index.repeated().first() {
            return Err(Error::Location {
                path: path.into(),
                location: format!("element {}", labels[*first as usize]),
                message: "stands twice; every element needs a label of its own".into(),
            });
        }
        Ok(CellIndex { index, starts })
    }

    /// Nodes of a cell, and what the cell is.
    pub fn cell(&self, index: &CellIndex, place: u32) -> (&str, &[u32]) {
        let block = index
            .starts
            .partition_point(|start| *start <= place as usize)
            - 1;
        let cell = place as usize - index.starts[block];
        match self.blocks.get_index(block) {
            Some(((cell_type, count), block)) => {
                (cell_type, &block.nodes[cell * count..(cell + 1) * count])
            }
            None => ("", &[]),
        }
    }

    /// The blocks; those without cells are left out.
    pub fn finish(self) -> Vec<CellBlock> {
        self.blocks
            .into_iter()
            .filter(|(_, block)| !block.nodes.is_empty())
            .map(|((cell_type, nodes_per_cell), block)| CellBlock {
                cell_type,
                nodes_per_cell,
                nodes: block.nodes,
            })
            .collect()
    }
}

/// Cells by their labels.
#[derive(Debug)]
pub(super) struct CellIndex {
    pub index: LabelIndex,
    starts: Vec<usize>,
}

/// Whether a cell of meshio's name has a volume, so that it isn't a face, an edge or a point.
pub(super) fn has_volume(cell_type: &str) -> bool {
    !["vertex", "line", "triangle", "quad"]
        .iter()
        .any(|flat| cell_type.starts_with(flat))
}
