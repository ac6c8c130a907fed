//! Elements of bulk data as cells.

/// Cell of an element card.
pub(super) struct Shape {
    /// Field of the first node.
    pub first: usize,
    pub linear: (&'static str, usize),
    /// With its mid-side nodes.
    pub quadratic: Option<(&'static str, usize)>,
    /// Places in the card of the cell's nodes, where the order differs.
    pub order: Option<&'static [usize]>,
}

/// Vertical edges stand before the upper ones.
const HEXAHEDRON: [usize; 20] = [
    0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 16, 17, 18, 19, 12, 13, 14, 15,
];
const WEDGE: [usize; 15] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 13, 14, 9, 10, 11];

/// Shape of an element card; `None` for cards that are no cells.
pub(super) fn shape(name: &str) -> Option<Shape> {
    let solid = |linear, quadratic, order| Shape {
        first: 2,
        linear,
        quadratic,
        order,
    };
    Some(match name {
        "CTETRA" => solid(("tetra", 4), Some(("tetra10", 10)), None),
        "CHEXA" => solid(
            ("hexahedron", 8),
            Some(("hexahedron20", 20)),
            Some(&HEXAHEDRON),
        ),
        "CPENTA" => solid(("wedge", 6), Some(("wedge15", 15)), Some(&WEDGE)),
        "CPYRAM" | "CPYRA" => solid(("pyramid", 5), Some(("pyramid13", 13)), None),
        "CTRIA3" | "CTRIAR" => solid(("triangle", 3), None, None),
        "CTRIA6" => solid(("triangle", 3), Some(("triangle6", 6)), None),
        "CQUAD4" | "CQUADR" | "CSHEAR" => solid(("quad", 4), None, None),
        "CQUAD8" => solid(("quad", 4), Some(("quad8", 8)), None),
        "CBAR" | "CBEAM" | "CBEND" | "CROD" | "CTUBE" => solid(("line", 2), None, None),
        "CBEAM3" => solid(("line", 2), Some(("line3", 3)), None),
        "CONROD" => Shape {
            first: 1,
            ..solid(("line", 2), None, None)
        },
        _ => return None,
    })
}
