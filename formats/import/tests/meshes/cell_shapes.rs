//! Where VTK and meshio have the middles of cells whose edges are straight.

use dcb_import::mesh::FoundMesh;

/// Corners that each node behind the corners is in the middle of.
fn middles(cell_type: &str) -> (usize, Vec<&'static [usize]>) {
    const QUAD: [&[usize]; 5] = [&[0, 1], &[1, 2], &[2, 3], &[3, 0], &[0, 1, 2, 3]];
    const TETRA: [&[usize]; 6] = [&[0, 1], &[1, 2], &[2, 0], &[0, 3], &[1, 3], &[2, 3]];
    const PYRAMID: [&[usize]; 9] = [
        &[0, 1],
        &[1, 2],
        &[2, 3],
        &[3, 0],
        &[0, 4],
        &[1, 4],
        &[2, 4],
        &[3, 4],
        &[0, 1, 2, 3],
    ];
    const WEDGE: [&[usize]; 12] = [
        &[0, 1],
        &[1, 2],
        &[2, 0],
        &[3, 4],
        &[4, 5],
        &[5, 3],
        &[0, 3],
        &[1, 4],
        &[2, 5],
        &[0, 1, 3, 4],
        &[1, 2, 4, 5],
        &[0, 2, 3, 5],
    ];
    const HEXAHEDRON: [&[usize]; 19] = [
        &[0, 1],
        &[1, 2],
        &[2, 3],
        &[3, 0],
        &[4, 5],
        &[5, 6],
        &[6, 7],
        &[7, 4],
        &[0, 4],
        &[1, 5],
        &[2, 6],
        &[3, 7],
        &[0, 3, 4, 7],
        &[1, 2, 5, 6],
        &[0, 1, 4, 5],
        &[2, 3, 6, 7],
        &[0, 1, 2, 3],
        &[4, 5, 6, 7],
        &[0, 1, 2, 3, 4, 5, 6, 7],
    ];
    let letters = cell_type.trim_end_matches(|c: char| c.is_ascii_digit());
    let (corners, all): (usize, &[&'static [usize]]) = match letters {
        "line" => (2, &[&[0, 1]]),
        "triangle" => (3, &[&[0, 1], &[1, 2], &[2, 0]]),
        "quad" => (4, &QUAD),
        "tetra" => (4, &TETRA),
        "pyramid" => (5, &PYRAMID),
        "wedge" => (6, &WEDGE),
        "hexahedron" => (8, &HEXAHEDRON),
        _ => (1, &[]),
    };
    let count = cell_type[letters.len()..].parse().unwrap_or(corners);
    (corners, all[..count - corners].to_vec())
}

/// Every node of every cell is where it should be.
pub fn assert_middles_are_in_place(mesh: &FoundMesh) {
    for block in &mesh.cells {
        let (corners, middles) = middles(&block.cell_type);
        assert_eq!(
            block.nodes_per_cell,
            corners + middles.len(),
            "{}",
            block.cell_type
        );
        for cell in block.cells() {
            for (at, around) in middles.iter().enumerate() {
                let found = mesh.points[cell[corners + at] as usize];
                for (axis, found) in found.iter().enumerate() {
                    let sum: f64 = around
                        .iter()
                        .map(|corner| mesh.points[cell[*corner] as usize][axis])
                        .sum();
                    let middle = sum / around.len() as f64;
                    assert!(
                        (found - middle).abs() < 1e-12,
                        "{}: node {}",
                        block.cell_type,
                        corners + at
                    );
                }
            }
        }
    }
}
