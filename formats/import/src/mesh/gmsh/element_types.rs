//! Element types of Gmsh by their numbers, as meshio's cells.

/// A type of elements.
#[derive(Clone, Copy, Debug)]
pub(super) struct ElementType {
    /// meshio's name; `None` for cells that only have their number.
    pub cell: Option<&'static str>,
    pub dimension: u8,
    pub nodes: usize,
    /// Places in the element of the cell's nodes, where the order differs.
    pub order: Option<&'static [usize]>,
}

const TETRA10: [usize; 10] = [0, 1, 2, 3, 4, 5, 6, 7, 9, 8];
const HEXAHEDRON20: [usize; 20] = [
    0, 1, 2, 3, 4, 5, 6, 7, 8, 11, 13, 9, 16, 18, 19, 17, 10, 12, 14, 15,
];
const HEXAHEDRON27: [usize; 27] = [
    0, 1, 2, 3, 4, 5, 6, 7, 8, 11, 13, 9, 16, 18, 19, 17, 10, 12, 14, 15, 22, 23, 21, 24, 20, 25,
    26,
];
const WEDGE15: [usize; 15] = [0, 1, 2, 3, 4, 5, 6, 9, 7, 12, 14, 13, 8, 10, 11];
const WEDGE18: [usize; 18] = [0, 1, 2, 3, 4, 5, 6, 9, 7, 12, 14, 13, 8, 10, 11, 15, 17, 16];
const PYRAMID13: [usize; 13] = [0, 1, 2, 3, 4, 5, 8, 10, 6, 7, 9, 11, 12];
const PYRAMID14: [usize; 14] = [0, 1, 2, 3, 4, 5, 8, 10, 6, 7, 9, 11, 12, 13];

/// What a number stands for; `None` for types that aren't known.
pub(super) fn element_type(number: i64) -> Option<ElementType> {
    let of = |cell, dimension, nodes, order| ElementType {
        cell,
        dimension,
        nodes,
        order,
    };
    let same = |cell, dimension, nodes| of(Some(cell), dimension, nodes, None);
    let nameless = |dimension, nodes| of(None, dimension, nodes, None);
    Some(match number {
        1 => same("line", 1, 2),
        2 => same("triangle", 2, 3),
        3 => same("quad", 2, 4),
        4 => same("tetra", 3, 4),
        5 => same("hexahedron", 3, 8),
        6 => same("wedge", 3, 6),
        7 => same("pyramid", 3, 5),
        8 => same("line3", 1, 3),
        9 => same("triangle6", 2, 6),
        10 => same("quad9", 2, 9),
        11 => of(Some("tetra10"), 3, 10, Some(&TETRA10)),
        12 => of(Some("hexahedron27"), 3, 27, Some(&HEXAHEDRON27)),
        13 => of(Some("wedge18"), 3, 18, Some(&WEDGE18)),
        14 => of(Some("pyramid14"), 3, 14, Some(&PYRAMID14)),
        15 => same("vertex", 0, 1),
        16 => same("quad8", 2, 8),
        17 => of(Some("hexahedron20"), 3, 20, Some(&HEXAHEDRON20)),
        18 => of(Some("wedge15"), 3, 15, Some(&WEDGE15)),
        19 => of(Some("pyramid13"), 3, 13, Some(&PYRAMID13)),
        // Higher orders keep Gmsh's order of nodes.
        20 => nameless(2, 9),
        21 => nameless(2, 10),
        22 => nameless(2, 12),
        23 | 24 => nameless(2, 15),
        25 => nameless(2, 21),
        26 => nameless(1, 4),
        27 => nameless(1, 5),
        28 => nameless(1, 6),
        29 => nameless(3, 20),
        30 => nameless(3, 35),
        31 => nameless(3, 56),
        36 => nameless(2, 16),
        37 => nameless(2, 25),
        38 => nameless(2, 36),
        90 => nameless(3, 40),
        91 => nameless(3, 75),
        92 => nameless(3, 64),
        93 => nameless(3, 125),
        _ => return None,
    })
}
