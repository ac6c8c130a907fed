//! Element types of Abaqus and CalculiX as cells.

/// Digits of a type's name, meshio's cell and its number of nodes.
type Cell = (&'static str, &'static str, usize);

/// Solids by the digits behind `C3D`; edges follow in the order of meshio.
const SOLIDS: [Cell; 8] = [
    ("4", "tetra", 4),
    ("5", "pyramid", 5),
    ("6", "wedge", 6),
    ("8", "hexahedron", 8),
    ("10", "tetra10", 10),
    ("13", "pyramid13", 13),
    ("15", "wedge15", 15),
    ("20", "hexahedron20", 20),
];
const FACES: [Cell; 5] = [
    ("3", "triangle", 3),
    ("4", "quad", 4),
    ("6", "triangle6", 6),
    ("8", "quad8", 8),
    ("9", "quad9", 9),
];
/// Beginnings of types, longest first where one begins another, and what the digits behind mean.
const FAMILIES: [(&str, &[Cell]); 22] = [
    ("DCC3D", &SOLIDS),
    ("DC3D", &SOLIDS),
    ("AC3D", &SOLIDS),
    ("C3D", &SOLIDS),
    ("SC", &SOLIDS),
    ("CPEG", &FACES),
    ("CPE", &FACES),
    ("CPS", &FACES),
    ("CGAX", &FACES),
    ("CAX", &FACES),
    ("DC2D", &FACES),
    ("AC2D", &FACES),
    ("SFM3D", &FACES),
    ("M3D", &FACES),
    ("R3D", &FACES),
    ("DS", &FACES),
    ("STRI", &[("3", "triangle", 3), ("65", "triangle6", 6)]),
    ("S", &FACES),
    ("PIPE", &BEAMS),
    ("B", &BEAMS),
    ("T3D", &[("2", "line", 2), ("3", "line3", 3)]),
    ("T2D", &[("2", "line", 2), ("3", "line3", 3)]),
];
const BEAMS: [Cell; 6] = [
    ("21", "line", 2),
    ("22", "line3", 3),
    ("23", "line", 2),
    ("31", "line", 2),
    ("32", "line3", 3),
    ("33", "line", 2),
];
const POINTS: [&str; 5] = ["MASS", "ROTARYI", "SPRING1", "DASHPOT1", "HEATCAP"];
const LINKS: [&str; 7] = [
    "SPRINGA", "SPRING2", "DASHPOTA", "DASHPOT2", "CONN3D2", "CONN2D2", "GAPUNI",
];

/// Cell and number of nodes of a type, in capitals; `None` for one that isn't known, or whose number of nodes varies.
pub(super) fn cell_of(element_type: &str) -> Option<(&'static str, usize)> {
    if POINTS.contains(&element_type) {
        return Some(("vertex", 1));
    }
    if LINKS.contains(&element_type) {
        return Some(("line", 2));
    }
    FAMILIES.iter().find_map(|(family, cells)| {
        let rest = element_type.strip_prefix(family)?;
        let digits = rest.len() - rest.trim_start_matches(|c: char| c.is_ascii_digit()).len();
        let (digits, letters) = rest.split_at(digits);
        // Variable numbers of nodes (C3D15V); other letters are about integration, hybrids, temperature.
        let is_fixed = letters.chars().all(|c| c.is_ascii_alphanumeric()) && letters != "V";
        let (_, cell, nodes) = cells.iter().find(|(known, ..)| *known == digits)?;
        is_fixed.then_some((*cell, *nodes))
    })
}

/// Places in the element of the nodes of the cell, where the orders differ: beams have the middle between the ends.
pub(super) fn order_of(cell: &str) -> Option<&'static [usize]> {
    (cell == "line3").then_some(&[0, 2, 1])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn letters_behind_the_number_of_nodes_do_not_matter() {
        for (names, cell) in [
            (["C3D20", "C3D20R", "C3D20RH"], ("hexahedron20", 20)),
            (["C3D8I", "C3D8R", "SC8R"], ("hexahedron", 8)),
            (["C3D10M", "C3D10MH", "DC3D10"], ("tetra10", 10)),
            (["C3D15", "C3D15H", "C3D15E"], ("wedge15", 15)),
            (["S4R", "S4R5", "CPS4R"], ("quad", 4)),
            (["S8R", "CPE8RH", "M3D8R"], ("quad8", 8)),
            (["STRI65", "S6", "CAX6M"], ("triangle6", 6)),
            (["B31", "B33H", "T3D2"], ("line", 2)),
            (["B32", "B32R", "T3D3"], ("line3", 3)),
            (["MASS", "ROTARYI", "SPRING1"], ("vertex", 1)),
        ] {
            for name in names {
                assert_eq!(cell_of(name), Some(cell), "{name}");
            }
        }
        for name in ["C3D27", "C3D15V", "U1", "F3D8", "", "C3D", "C3D200", "BX1"] {
            assert_eq!(cell_of(name), None, "{name}");
        }
    }
}
