//! Cells of VTK by their numbers, in meshio's names and order.

/// meshio's name, number of nodes, and the places of its nodes where the order differs.
type Cell = (&'static str, usize, Option<&'static [usize]>);

/// A cell; `None` for kinds that have no fixed number of nodes or no name.
pub(super) fn cell_of(kind: i64) -> Option<Cell> {
    Some(match kind {
        1 => ("vertex", 1, None),
        3 => ("line", 2, None),
        5 => ("triangle", 3, None),
        // Pixels and voxels count along the axes.
        8 => ("quad", 4, Some(&[0, 1, 3, 2])),
        9 => ("quad", 4, None),
        10 => ("tetra", 4, None),
        11 => ("hexahedron", 8, Some(&[0, 1, 3, 2, 4, 5, 7, 6])),
        12 => ("hexahedron", 8, None),
        // meshio turns the linear wedge over.
        13 => ("wedge", 6, Some(&[0, 2, 1, 3, 5, 4])),
        14 => ("pyramid", 5, None),
        21 => ("line3", 3, None),
        22 => ("triangle6", 6, None),
        23 => ("quad8", 8, None),
        24 => ("tetra10", 10, None),
        25 => ("hexahedron20", 20, None),
        26 => ("wedge15", 15, None),
        27 => ("pyramid13", 13, None),
        28 => ("quad9", 9, None),
        29 => ("hexahedron27", 27, None),
        32 => ("wedge18", 18, None),
        33 => ("hexahedron24", 24, None),
        _ => return None,
    })
}
