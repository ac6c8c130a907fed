//! Meshes of Gmsh: one cell of every kind in every form, curved parts, partitions.

use std::collections::BTreeSet;

use dcb_import::mesh::{FoundMesh, MeshFormat};

use crate::cell_shapes::assert_middles_are_in_place;
use crate::samples::{read, read_text, sample};

/// Places of nodes in thousandths, so that they can be compared as sets.
fn places(mesh: &FoundMesh, nodes: &[u32]) -> BTreeSet<[i64; 3]> {
    nodes
        .iter()
        .map(|node| mesh.points[*node as usize].map(|x| (1000.0 * x).round() as i64))
        .collect()
}

fn set(mesh: &FoundMesh, name: &str) -> BTreeSet<[i64; 3]> {
    let found = mesh
        .sets
        .iter()
        .chain(&mesh.cell_sets)
        .find(|(known, _)| known == name);
    places(mesh, &found.unwrap_or_else(|| panic!("no set {name}")).1)
}

fn cell_types(mesh: &FoundMesh) -> BTreeSet<&str> {
    assert!(
        mesh.cells.iter().all(|cells| cells.cell_count() == 1),
        "a cell stands twice"
    );
    mesh.cells
        .iter()
        .map(|cells| cells.cell_type.as_str())
        .collect()
}

#[test]
fn every_cell_in_every_version_has_its_middles_where_vtk_has_them() {
    let kinds = [
        (
            "linear",
            [
                "vertex",
                "line",
                "triangle",
                "quad",
                "tetra",
                "pyramid",
                "wedge",
                "hexahedron",
            ],
        ),
        (
            "edges",
            [
                "vertex",
                "line3",
                "triangle6",
                "quad8",
                "tetra10",
                "pyramid13",
                "wedge15",
                "hexahedron20",
            ],
        ),
        (
            "full",
            [
                "vertex",
                "line3",
                "triangle6",
                "quad9",
                "tetra10",
                "pyramid14",
                "wedge18",
                "hexahedron27",
            ],
        ),
    ];
    for (name, kinds) in kinds {
        for version in ["41", "41_binary", "22", "22_binary", "41_big", "41_size4"] {
            let file = format!("mesh/cells/{name}_{version}.msh");
            if !sample(&file).exists() {
                assert!(
                    matches!(
                        (name, version),
                        ("full", "41_big") | ("linear" | "full", "41_size4")
                    ),
                    "{file}"
                );
                continue;
            }
            let read = read(&file);
            assert_eq!(read.format, MeshFormat::Gmsh);
            let mesh = read.mesh;
            assert_eq!(cell_types(&mesh), BTreeSet::from(kinds), "{file}");
            assert_middles_are_in_place(&mesh);
            // Corners, in the order of the script that made the files.
            let wedge = mesh
                .cells
                .iter()
                .find(|cells| cells.cell_type.starts_with("wedge"))
                .unwrap();
            let corners: Vec<[f64; 3]> = wedge.nodes[..6]
                .iter()
                .map(|node| mesh.points[*node as usize])
                .collect();
            let known = [
                [2, 0, 0],
                [4, 0, 0],
                [2, 1, 0],
                [2, 0, 3],
                [4, 0, 3],
                [2, 1, 3],
            ];
            assert_eq!(corners, known.map(|point| point.map(f64::from)));
        }
    }
}

#[test]
fn physical_groups_are_sets_in_every_version() {
    for version in ["41", "41_binary", "22", "22_binary", "41_big", "41_size4"] {
        let mesh = read(&format!("mesh/cells/edges_{version}.msh")).mesh;
        let names: BTreeSet<&str> = mesh.sets.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(
            names,
            BTreeSet::from(["left", "both faces", "both ends", "curve_7"]),
            "{version}"
        );
        assert_eq!(mesh.cell_sets.len(), 1);
        let left = places(&mesh, &(0..mesh.points.len() as u32).collect::<Vec<_>>());
        let left: BTreeSet<_> = left.into_iter().filter(|point| point[0] == 0).collect();
        assert_eq!(left.len(), 8);
        assert_eq!(set(&mesh, "left"), left, "{version}");
        let triangle = [
            [4000, 0, 0],
            [2000, 1000, 0],
            [5000, 2000, 1000],
            [3000, 500, 0],
            [3500, 1500, 500],
            [4500, 1000, 500],
        ];
        let both: BTreeSet<_> = left.iter().copied().chain(triangle).collect();
        assert_eq!(set(&mesh, "both faces"), both, "{version}");
        let curve = BTreeSet::from([[1000, 400, 5000], [0, 0, 3000], [500, 200, 4000]]);
        assert_eq!(set(&mesh, "curve_7"), curve, "{version}");
        let with_point: BTreeSet<_> = curve.into_iter().chain([[5000, 2000, 1000]]).collect();
        assert_eq!(set(&mesh, "both ends"), with_point, "{version}");
        assert_eq!(set(&mesh, "the part").len(), mesh.points.len(), "{version}");
    }
}

#[test]
fn parameters_and_partitions_change_nothing() {
    let plain = read("mesh/cells/curved_41.msh").mesh;
    let mantle = set(&plain, "mantle");
    let all = |mesh: &FoundMesh| places(mesh, &(0..mesh.points.len() as u32).collect::<Vec<_>>());
    let tetrahedra = |mesh: &FoundMesh| -> BTreeSet<BTreeSet<[i64; 3]>> {
        let cells = mesh.cells.iter().filter(|cells| cells.cell_type == "tetra");
        cells
            .flat_map(|cells| cells.cells())
            .map(|cell| places(mesh, cell))
            .collect()
    };
    for name in [
        "22",
        "22_binary",
        "22_parameters",
        "22_binary_parameters",
        "41_binary",
        "41_parameters",
        "41_binary_parameters",
        "41_partitioned",
        "41_binary_partitioned",
    ] {
        let mesh = read(&format!("mesh/cells/curved_{name}.msh")).mesh;
        assert_eq!(all(&mesh), all(&plain), "{name}");
        assert_eq!(tetrahedra(&mesh), tetrahedra(&plain), "{name}");
        assert_eq!(set(&mesh, "mantle"), mantle, "{name}");
        assert_eq!(set(&mesh, "part").len(), plain.points.len(), "{name}");
    }
}

#[test]
fn other_versions_are_refused_with_what_to_save_as() {
    for (name, version) in [("edges_40", "4"), ("edges_1", "1")] {
        let error = dcb_import::mesh::read_mesh(&sample(&format!("mesh/cells/{name}.msh")))
            .unwrap_err()
            .to_string();
        let said = format!("version `{version}` of .msh isn't read; save it as 4.1");
        assert!(error.contains(&said), "{error}");
    }
}

#[test]
fn what_cannot_be_right_is_refused_with_its_line() {
    let head = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n";
    let head4 = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n";
    for (text, said) in [
        (
            format!("{head}$Nodes\n2\n1 0 0 0\n$EndNodes\n"),
            "part:7: `$EndNodes` is no whole number",
        ),
        (
            format!("{head}$Nodes\n1000000000000\n1 0 0 0\n$EndNodes\n"),
            "part:5: 1000000000000 nodes are announced, but only 18 bytes are left",
        ),
        (
            format!("{head}$Nodes\n1\n1 0 0 0\n2 0 0 0\n$EndNodes\n"),
            "part:7: $EndNodes isn't where the counts of $Nodes end",
        ),
        (
            format!("{head}$Nodes\n1\n1 0 0 inf\n$EndNodes\n"),
            "part:6: `inf` is not finite",
        ),
        (
            format!("{head}$Nodes\n1\n3000000000 0 0 0\n$EndNodes\n"),
            "part:6: 3000000000 is no label",
        ),
        (
            format!("{head}$Nodes\n1\n1 0 0 0\n$EndNodes\n$Elements\n1\n1 15 0 2\n$EndElements\n"),
            "part: element 1: of type vertex names node 2",
        ),
        (
            format!(
                "{head}$Nodes\n1\n1 0 0 0\n$EndNodes\n$Elements\n1\n1 1500 0 1\n$EndElements\n"
            ),
            "part:10: element type 1500 isn't known",
        ),
        (
            format!("{head}$Nodes\n2\n1 0 0 0\n1 0 0 1\n$EndNodes\n"),
            "part: node 1: stands twice",
        ),
        (
            format!("{head}$Periodic\n1\n"),
            "part:4: $Periodic has no end",
        ),
        (
            format!("{head4}$Nodes\n1 5 1 5\n3 1 0 1\n1\n0 0 0\n$EndNodes\n"),
            "part:8: 5 nodes are announced, but the blocks have 1",
        ),
        (
            format!("{head4}$Nodes\n1 1 1 1\n3 1 7 1\n1\n0 0 0\n$EndNodes\n"),
            "part:6: 7 where 0 or 1 tells of parameters",
        ),
        (
            "$Nodes\n1\n1 0 0 0\n$EndNodes\n".into(),
            "part: is no mesh of a known format",
        ),
        (
            "$PhysicalNames\n0\n$EndPhysicalNames\n$Nodes\n".into(),
            "part:4: has no $MeshFormat before",
        ),
        (
            "$MeshFormat\n2.2 1 8\nabcd\n".into(),
            "part:3: the number 1 that tells the byte order isn't there",
        ),
        (head.into(), "part: has no nodes"),
    ] {
        let error = read_text(&text).unwrap_err();
        assert!(error.starts_with(said), "{error}\nexpected {said}");
    }
}

#[test]
fn decimal_commas_are_read() {
    let mesh =
        read_text("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n1\n1 0,5 1,5 -2,5\n$EndNodes\n")
            .unwrap();
    assert_eq!(mesh.points, [[0.5, 1.5, -2.5]]);
}
