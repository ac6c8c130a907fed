//! Cells of a mesh in the node order and with the type numbers of VTK.

use crate::description::{listed, suggestion};
use crate::mesh::Mesh;

/// meshio's name, VTK's number, and the number of nodes of each cell that can be shown.
const CELL_TYPES: [(&str, u8, usize); 17] = [
    ("vertex", 1, 1),
    ("line", 3, 2),
    ("triangle", 5, 3),
    ("quad", 9, 4),
    ("tetra", 10, 4),
    ("hexahedron", 12, 8),
    ("wedge", 13, 6),
    ("pyramid", 14, 5),
    ("line3", 21, 3),
    ("triangle6", 22, 6),
    ("quad8", 23, 8),
    ("tetra10", 24, 10),
    ("hexahedron20", 25, 20),
    ("wedge15", 26, 15),
    ("pyramid13", 27, 13),
    ("quad9", 28, 9),
    ("hexahedron27", 29, 27),
];
/// VTK's number of a cell that is a point.
const VERTEX: u8 = 1;
/// meshio takes the nodes of most cells as VTK does, but turns the linear wedge over.
const WEDGE_ORDER: [usize; 6] = [0, 2, 1, 3, 5, 4];

/// Cells as VTK wants them.
#[derive(Clone, Debug, Default)]
pub struct Cells {
    /// Nodes of all cells.
    pub(super) nodes: Vec<i64>,
    /// Place in `nodes` behind each cell.
    pub(super) ends: Vec<i64>,
    /// VTK's number of each.
    pub(super) types: Vec<u8>,
}

impl Cells {
    /// Of a mesh; one without cells has a vertex at every node.
    ///
    /// # Errors
    /// A cell that VTK has no type for, in words that follow the name of what has the mesh.
    pub fn of(mesh: &Mesh) -> Result<Self, String> {
        let mut all = Self::default();
        for block in &mesh.cells {
            let name = block.cell_type.as_str();
            let names = || CELL_TYPES.iter().map(|(name, ..)| *name);
            let known = CELL_TYPES.iter().find(|(known, ..)| *known == name);
            let Some(&(_, vtk_type, node_count)) = known else {
                return Err(format!(
                    "its mesh has cells of type `{name}`, which can't be shown{} (known here: {})",
                    suggestion(name, names()),
                    listed(names())
                ));
            };
            if block.nodes_per_cell != node_count {
                return Err(format!(
                    "its mesh has cells of type `{name}` with {} nodes; they must have {node_count}",
                    block.nodes_per_cell
                ));
            }
            for cell in block.cells() {
                match name {
                    "wedge" => all
                        .nodes
                        .extend(WEDGE_ORDER.map(|index| i64::from(cell[index]))),
                    _ => all.nodes.extend(cell.iter().map(|&node| i64::from(node))),
                }
                all.ends.push(all.nodes.len() as i64);
                all.types.push(vtk_type);
            }
        }
        if all.types.is_empty() {
            // A grid without cells shows nothing in ParaView, and meshio doesn't read it.
            all.nodes = (0..mesh.node_count() as i64).collect();
            all.ends = (1..=mesh.node_count() as i64).collect();
            all.types = vec![VERTEX; mesh.node_count()];
        }
        Ok(all)
    }
}
