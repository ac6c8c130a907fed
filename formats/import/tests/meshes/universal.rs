//! Universal files.

use std::collections::BTreeSet;

use dcb_import::mesh::MeshFormat;

use crate::cell_shapes::assert_middles_are_in_place;
use crate::samples::{labels, read, read_text, set};

/// A dataset with its lines.
fn dataset(number: u32, lines: &str) -> String {
    format!("    -1\n{number:6}\n{lines}    -1\n")
}

#[test]
fn every_cell_of_gmsh_has_its_middles_where_vtk_has_them() {
    // Gmsh writes no pyramids.
    for (name, kinds) in [
        (
            "linear",
            ["line", "triangle", "quad", "tetra", "wedge", "hexahedron"],
        ),
        (
            "edges",
            [
                "line3",
                "triangle6",
                "quad8",
                "tetra10",
                "wedge15",
                "hexahedron20",
            ],
        ),
    ] {
        let read = read(&format!("mesh/cells/{name}.unv"));
        assert_eq!(read.format, MeshFormat::Universal);
        let found: BTreeSet<&str> = read
            .mesh
            .cells
            .iter()
            .map(|cells| cells.cell_type.as_str())
            .collect();
        assert_eq!(found, BTreeSet::from(kinds), "{name}");
        assert_middles_are_in_place(&read.mesh);
        assert!(
            read.mesh.sets.iter().any(|(name, _)| name == "left"),
            "{:?}",
            read.mesh.sets
        );
    }
}

#[test]
fn older_nodes_elements_and_groups() {
    let text = dataset(151, "anything\n -1.5\n")
        + &dataset(
            15,
            "         1         0         0         8  0.00000E+00  0.00000E+00  1.50000D+00\n2147483647 0 0 8 1. 0. 0.\n",
        )
        + &dataset(
            781,
            "         3         0         0         8\n  1.0D+00 1.0D+00 0.0D+00\n",
        )
        + &dataset(
            780,
            "         1        21         1         1         1         1         7         2\n         0         1         1\n         12147483647\n",
        )
        + &dataset(
            2412,
            "         2       111         1         1         7         4\n         1         3         12147483647\n         3       136 1 1 7 2\n1 3\n",
        )
        + &dataset(
            2435,
            "         4         0         0         0         0         0         0         3\nnodes\n         7         1         0         0         72147483647         0         0\n         7        99         0         0\n",
        )
        + &dataset(
            2430,
            "         5         0         0         0         0         0         3\n\n         7         1         7         3         1         9\n",
        )
        + &dataset(
            2467,
            "         6         0         0         0         0         0         0         1\nsolid\n         8         2         0         0\n",
        );
    let mesh = read_text(text).unwrap();
    assert_eq!(mesh.labels.as_deref(), Some(&[1, 2_147_483_647, 3][..]));
    assert_eq!(
        mesh.points,
        [[0.0, 0.0, 1.5], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0]]
    );
    let cells: Vec<_> = mesh
        .cells
        .iter()
        .map(|cells| (cells.cell_type.as_str(), cells.nodes.as_slice()))
        .collect();
    assert_eq!(
        cells,
        [
            ("line", &[0, 1][..]),
            ("tetra", &[0, 2, 0, 1]),
            ("unv_type_136", &[0, 2])
        ]
    );
    assert_eq!(set(&mesh, "nodes"), [1, 2_147_483_647]);
    assert_eq!(set(&mesh, "group_5"), [1, 3]);
    assert_eq!(mesh.cell_sets.len(), 1);
    assert_eq!(labels(&mesh, &mesh.cell_sets[0].1), [1, 3, 2_147_483_647]);
    assert_eq!(
        mesh.notes,
        ["group nodes: 1 labels that no node and no element has are left out"]
    );
}

#[test]
fn what_cannot_be_right_is_refused_with_its_line() {
    let node = "1 1 1 11\n0. 0. 0.\n";
    let turned = "1\nPart\n1 0 8\nglobal\n1. 0. 0.\n0. 1. 0.\n0. 0. 1.\n0. 0. 0.\n5 1 8\nround\n1. 0. 0.\n0. 1. 0.\n0. 0. 1.\n0. 0. 0.\n";
    for (text, said) in [
        (
            format!("    -1\n  2411\n{node}"),
            "part:4: the file ends in dataset 2411, which has no -1 at its end",
        ),
        (
            dataset(2411, "1 1 1 11\n"),
            "part:4: dataset 2411 ends too early",
        ),
        (
            dataset(2411, "1 1 1 11\n0. 0.\n"),
            "part:4: has no three coordinates",
        ),
        (
            dataset(2411, "1 1 1 11\n0. 0. x\n"),
            "part:4: `x` is no number",
        ),
        (
            dataset(2411, "2147483648 1 1 11\n0. 0. 0.\n"),
            "part:3: 2147483648 is no label",
        ),
        (
            dataset(2411, node) + "    -1\nword\n",
            "part:7: `word`; expected the number of a dataset",
        ),
        (
            dataset(2411, node) + "word\n",
            "part:6: `word`; expected -1 and a dataset",
        ),
        (
            dataset(2411, node) + &dataset(2412, "1 111 1 1 7 4\n1 1 1\n"),
            "part:10: dataset 2412 ends too early",
        ),
        (
            dataset(2411, node) + &dataset(2412, "1 111 1 1 7 5\n1 1 1 1 1\n"),
            "part:9: element 1 of type 111 has 5 nodes, expected 4",
        ),
        (
            dataset(2411, node) + &dataset(2412, "1 111 1 1 7 4\n1 1 1 2\n"),
            "part: element 1: of type tetra names node 2",
        ),
        (
            dataset(2411, node) + &dataset(2412, "1 111 1 1 4\n1 1 1 2\n"),
            "part:8: an element has 5 numbers, expected 6",
        ),
        (
            dataset(2411, node) + &dataset(2467, "1 0 0 0 0 0 0 9\nA\n7 1 0 0\n"),
            "part:11: dataset 2467 ends too early",
        ),
        (
            dataset(2411, "1 5 1 11\n0. 0. 0.\n") + &dataset(2420, turned),
            "part: has nodes in coordinate system 5",
        ),
        (
            dataset(2411, &format!("{node}1 1 1 11\n0. 0. 2.\n")),
            "part: node 1: stands twice",
        ),
        (dataset(164, "1\n"), "part: has no nodes"),
    ] {
        let error = read_text(&text).unwrap_err();
        assert!(error.starts_with(said), "{error}\nexpected {said}");
    }
}
