//! What a picture of a mesh shows.

use dcb_formats::mesh::{CellBlock, Mesh};

use crate::surface::Surface;

/// What is drawn: triangles, else lines, else points.
pub struct Drawing {
    /// Nodes of the mesh, ascending.
    pub nodes: Vec<u32>,
    /// Places in `nodes`.
    pub cells: Vec<u32>,
    /// Nodes of a cell: 3, 2 or 1.
    pub corners: usize,
    /// Cells that aren't drawn, by type.
    pub others: Vec<String>,
}

impl Drawing {
    /// What is drawn of a mesh.
    pub fn of(mesh: &Mesh) -> Self {
        let surface = Surface::of(mesh);
        let lines = || -> Vec<u32> {
            let blocks = mesh.cells.iter();
            let blocks =
                blocks.filter(|block| matches!(block.cell_type.as_str(), "line" | "line3"));
            let ends = blocks.flat_map(|block| block.cells().filter_map(|cell| cell.get(..2)));
            ends.flatten().copied().collect()
        };
        let (corners, cells, others) = match surface.triangles.is_empty() {
            false => (3, surface.triangles.into_flattened(), surface.others),
            true => match lines() {
                cells if cells.is_empty() => {
                    (1, (0..mesh.node_count() as u32).collect(), Vec::new())
                }
                cells => (2, cells, Vec::new()),
            },
        };
        let mut nodes = cells.clone();
        nodes.sort_unstable();
        nodes.dedup();
        let place = |node: &u32| nodes.partition_point(|known| known < node) as u32;
        Self {
            cells: cells.iter().map(place).collect(),
            nodes,
            corners,
            others,
        }
    }

    /// The same through the corners of cells alone: fewer nodes where the mesh has mid-edge nodes.
    pub fn of_corners(mesh: &Mesh) -> Self {
        let mut linear = mesh.clone();
        for block in &mut linear.cells {
            let kind = block
                .cell_type
                .trim_end_matches(|letter: char| letter.is_ascii_digit());
            let corners = match kind {
                "tetra" | "quad" => 4,
                "hexahedron" => 8,
                "wedge" => 6,
                "pyramid" => 5,
                "triangle" => 3,
                "line" => 2,
                _ => continue,
            };
            if block.nodes_per_cell <= corners {
                continue;
            }
            let kept = block
                .cells()
                .flat_map(|cell| cell.iter().take(corners).copied());
            *block = CellBlock {
                cell_type: kind.to_owned(),
                nodes_per_cell: corners,
                nodes: kept.collect(),
            };
        }
        Self::of(&linear)
    }

    /// What the cells are called.
    pub fn what(&self) -> &'static str {
        match self.corners {
            3 => "triangles",
            2 => "lines",
            _ => "points",
        }
    }
}
