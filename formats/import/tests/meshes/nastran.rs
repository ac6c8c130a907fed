//! Nastran decks, against pyNastran's reading of them.

use dcb_formats::mesh::Direction;
use dcb_import::mesh::MeshFormat;
use dcb_import::stored::RowLabel;
use serde_json::Value;

use crate::samples::{labels, read, read_text, sample, set};

fn numbers(value: &Value) -> Vec<f64> {
    value
        .as_array()
        .unwrap()
        .iter()
        .map(|number| number.as_f64().unwrap())
        .collect()
}

#[test]
fn an_ugly_deck_is_what_pynastran_reads() {
    let text = std::fs::read_to_string(sample("nastran/ugly.json")).unwrap();
    let expected: Value = serde_json::from_str(&text).unwrap();
    let read = read("nastran/ugly.bdf");
    assert_eq!(read.format, MeshFormat::Nastran);
    let mesh = read.mesh;
    let all = mesh.labels.as_ref().unwrap();
    assert_eq!(all.len(), expected["grids"].as_object().unwrap().len());
    for (label, point) in all.iter().zip(&mesh.points) {
        for (found, known) in point
            .iter()
            .zip(numbers(&expected["grids"][label.to_string()]))
        {
            assert!((found - known).abs() < 1e-13, "GRID {label}: {point:?}");
        }
    }
    let axes = expected["axes"].as_object().unwrap();
    assert_eq!(mesh.displacement_axes.len(), axes.len());
    for (node, found) in &mesh.displacement_axes {
        let label = all[*node as usize].to_string();
        for (row, known) in found.iter().zip(axes[&label].as_array().unwrap()) {
            for (part, known) in row.iter().zip(numbers(known)) {
                // pyNastran's are differences.
                assert!((part - known).abs() < 1e-8, "GRID {label}: {found:?}");
            }
        }
        let right_handed = nalgebra::Matrix3::from_fn(|row, column| found[row][column]);
        assert!((right_handed.determinant() - 1.0).abs() < 1e-14);
    }
    assert_eq!(mesh.scalar_points, [1001, 1002, 1003, 1005, 1010]);
    assert!(
        expected["scalar_points"]
            .as_array()
            .unwrap()
            .iter()
            .map(|point| point.as_u64().unwrap())
            .eq([1001, 1002, 1003, 1005, 1010])
    );
}

#[test]
fn cells_of_the_ugly_deck_have_the_nodes_that_pynastran_reads() {
    let text = std::fs::read_to_string(sample("nastran/ugly.json")).unwrap();
    let expected: Value = serde_json::from_str(&text).unwrap();
    let mesh = read("nastran/ugly.bdf").mesh;
    // Elements by type in the order of the file; nodes of the corners and of all, which both programs have in different orders.
    for (cell_type, elements) in [
        ("hexahedron20", &[1, 2][..]),
        ("hexahedron", &[3]),
        ("wedge15", &[4]),
        ("tetra10", &[5]),
        ("pyramid13", &[6]),
        ("quad8", &[7]),
        ("triangle6", &[8]),
        ("line", &[9, 10]),
        ("tetra", &[11]),
    ] {
        let block = mesh.cells.iter().find(|cells| cells.cell_type == cell_type);
        let block = block.unwrap_or_else(|| panic!("no {cell_type}"));
        assert_eq!(block.cell_count(), elements.len(), "{cell_type}");
        for (cell, element) in block.cells().zip(elements) {
            let mut known: Vec<u32> = (expected["cells"][element.to_string()]
                .as_array()
                .unwrap()
                .iter())
            .filter_map(|node| Some(node.as_u64()? as u32))
            .collect();
            known.truncate(block.nodes_per_cell);
            let mut found = labels(&mesh, cell);
            known.sort_unstable();
            found.sort_unstable();
            assert_eq!(found, known, "{cell_type} {element}");
        }
    }
    // The grid of the hexahedra is a cube: middles of edges are where VTK has them.
    let hexahedra = mesh
        .cells
        .iter()
        .find(|cells| cells.cell_type == "hexahedron20")
        .unwrap();
    let edges = [
        [0, 1],
        [1, 2],
        [2, 3],
        [3, 0],
        [4, 5],
        [5, 6],
        [6, 7],
        [7, 4],
        [0, 4],
        [1, 5],
        [2, 6],
        [3, 7],
    ];
    for cell in hexahedra.cells() {
        for (middle, [a, b]) in cell[8..].iter().zip(edges) {
            let [a, b, middle] = [cell[a], cell[b], *middle].map(|node| mesh.points[node as usize]);
            assert_eq!(middle, [0, 1, 2].map(|axis| 0.5 * (a[axis] + b[axis])));
        }
    }
    assert!(
        mesh.notes
            .iter()
            .any(|note| note.contains("1 elements have some of their mid-side nodes")),
        "{:?}",
        mesh.notes
    );
}

#[test]
fn sets_of_case_control_and_bulk_data() {
    let mesh = read("nastran/ugly.bdf").mesh;
    let names: Vec<&str> = mesh.sets.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, ["set_1", "set1_6", "set3_7"]);
    assert_eq!(set(&mesh, "set_1"), [1, 2, 5, 6, 8, 10, 11, 12]);
    assert_eq!(set(&mesh, "set1_6"), [10, 11, 12, 13, 20]);
    assert_eq!(set(&mesh, "set3_7"), [1, 2, 3, 4, 5, 6, 7, 8, 9]);
    for said in [
        "set_2 has 1 labels that are no grids, the first is 99",
        "SET 4 is used for elements",
    ] {
        assert!(
            mesh.notes.iter().any(|note| note.contains(said)),
            "{:?}",
            mesh.notes
        );
    }
}

#[test]
fn an_external_superelement_tells_its_rows_and_axes() {
    let mesh = read("nastran/pyyeti/outboard.pch").mesh;
    assert_eq!(mesh.labels.as_deref(), Some(&[3, 11, 19, 27][..]));
    assert_eq!(mesh.points[1], [600.0, 300.0, 300.0]);
    assert_eq!(
        mesh.scalar_points,
        (1_995_001..=1_995_022).collect::<Vec<u32>>()
    );
    // Axes of system 10: its third one is the basic x, its first one the basic y.
    assert_eq!(
        mesh.displacement_axes,
        [(1, [[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])]
    );
    let rows = mesh.rows.clone().unwrap();
    assert_eq!(rows.len(), 4 * 6 + 22);
    let nodal = |node, direction| RowLabel::Nodal { node, direction };
    assert_eq!(rows[0], nodal(3, Direction::Ux));
    assert_eq!(rows[11], nodal(11, Direction::Rz));
    assert_eq!(
        rows[24],
        RowLabel::Internal {
            point: 1_995_001,
            number: 0
        }
    );
    // The file for the assembly has the same points, but not their rows.
    let assembly = read("nastran/pyyeti/outboard.asm").mesh;
    assert_eq!(assembly.rows, None);
    assert_eq!(
        (
            assembly.points,
            assembly.scalar_points,
            assembly.displacement_axes
        ),
        (mesh.points, mesh.scalar_points, mesh.displacement_axes)
    );
}

#[test]
fn what_cannot_be_right_is_refused_with_its_line() {
    for (text, said) in [
        (
            "GRID,1,,0.,0.,0.\nGRID,1,,0.,0.,1.\n",
            "part: node 1: stands twice, at",
        ),
        (
            "GRID,1,,0.,0.,0.\nGRID,1,,0.,0.,0.,2\nCORD2R,2,0,0.,0.,0.,0.,0.,1.\n,1.,0.,0.\n",
            "part: node 1: stands twice, with different coordinate systems",
        ),
        (
            "GRID,2147483648,,0.,0.,0.\n\n",
            "part:2: GRID, field 2: 2147483648 is no label",
        ),
        (
            "GRID,1,5,0.,0.,0.\n",
            "part: GRID 1: coordinate system 5 is named, but isn't there",
        ),
        (
            "GRID,1,,0.,0.,0.,5\n",
            "part: GRID 1: coordinate system 5 is named, but isn't there",
        ),
        (
            "GRID,1,,0.,0.,x\n",
            "part:1: GRID, field 6: `x` is no number",
        ),
        (
            "GRID           1              0,     1,5      2\n",
            "part:1: GRID has commas between its columns",
        ),
        (
            "GRID,1,,0,5,1,5,2,5,3,0\n",
            "part:1: has more than 8 fields between commas",
        ),
        (
            "GRID,1\nCORD2R,1,2,0.,0.,0.,0.,0.,1.\n,1.,0.,0.\nCORD2R,2,1,0.,0.,0.,0.,0.,1.\n,1.,0.,0.\n",
            "part: coordinate system",
        ),
        (
            "GRID,1\nCORD2R,1,0,0.,0.,0.,0.,0.,1.\n,0.,0.,2.\n",
            "part: the three points of coordinate system 1 are on a line",
        ),
        (
            "GRID,1\nCORD1R,1,1,2,3\n",
            "part: coordinate system 1 names grid 2, which isn't there",
        ),
        (
            "GRID,1,1\nGRID,2\nGRID,3\nCORD1R,1,1,2,3\n",
            "part: coordinate system 1 is defined by itself",
        ),
        (
            "GRID,1\nCBAR,1,1,1,2\n",
            "part: element 1: of type line names node 2, which isn't there",
        ),
        (
            "GRID,1\nCHEXA,1,1,1,1,1,1,1,1\n",
            "part:2: CHEXA, field 10: `` is no whole number",
        ),
        (
            "GRID,1\nEXTRN,2,123\n",
            "part: EXTRN names grid 2, which isn't there",
        ),
        (
            "GRID,1\nEXTRN,1,127\n",
            "part: EXTRN: 127 of grid 1 are no components",
        ),
        (
            "GRID,1\nEXTRN,1,123,7,0\n",
            "part: EXTRN names the scalar point 7, which isn't there",
        ),
        (
            "GRID,1\nSPOINT,2,THRU,2000000000\n",
            "part: has 1999999999 scalar points",
        ),
        ("GRID,1\nSPOINT,1\n", "part: 1 is a grid and a scalar point"),
        (
            "GRID,1\nSET1,4,9,THRU,2\n",
            "part:2: SET1: goes from 9 to 2",
        ),
        (
            "GRID,1\nINCLUDE '../other.bdf'\n",
            "part:2: includes `../other.bdf`; only files in or below",
        ),
        (
            "GRID*,1\nINCLUDE 'par\nt'\n",
            "part:3: includes `part` a second time",
        ),
        ("ENDDATA\n", "part: has no nodes"),
    ] {
        let error = read_text(text).unwrap_err();
        assert!(error.starts_with(said), "{error}\nexpected {said}");
    }
}

#[test]
fn a_chain_of_many_systems_is_no_deep_recursion() {
    let mut text = String::from("GRID,1,100000,1.,2.,3.\n");
    for system in 1..=100_000 {
        text += &format!(
            "CORD2R,{system},{},0.,0.,1.,0.,0.,2.\n,1.,0.,0.\n",
            system - 1
        );
    }
    let mesh = read_text(text).unwrap();
    assert_eq!(mesh.points, [[1.0, 2.0, 100_003.0]]);
}

#[test]
fn permanently_held_grids_are_told() {
    let mesh = read_text("GRDSET,,,,,,,123\nGRID,1\nGRID,2,,,,,,6\nGRID,3,,,,,,0\n").unwrap();
    assert_eq!(labels(&mesh, &mesh.held), [2, 1]);
}
