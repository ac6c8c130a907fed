//! Files that real programs wrote, against their references.
#![allow(clippy::unwrap_used, clippy::expect_used)]

use std::path::{Path, PathBuf};

use dcb_formats::component::Units;
use dcb_import::{Import, Imported, LostOrder, NamedFile, NodeOrder, RowSource, import};

fn data(name: &str) -> PathBuf {
    Path::new("../../tests/data/exchange").join(name)
}

fn request(stiffness: &str, mass: Option<&str>, mesh: Option<&str>) -> Import {
    Import {
        stiffness: NamedFile::of(&data(stiffness)),
        mass: mass.map(|mass| NamedFile::of(&data(mass))),
        mesh: mesh.map(data),
        dofs: None,
        node_order: NodeOrder::File,
        lost_order: LostOrder::Refuse,
        interfaces: None,
        units: Some(Units {
            length: "m".into(),
            mass: "kg".into(),
            time: "s".into(),
        }),
        name: None,
    }
}

/// Abaqus' substructure has no coordinates: they follow from K's null space. Reference: the same by SciPy, which shares no code.
#[test]
fn a_substructure_without_coordinates_has_them_in_its_stiffness() {
    let mut of_both = Vec::new();
    for file in [
        "abaqus/substructure/inner.mtx",
        "abaqus/substructure/inner_unsymmetric.mtx",
    ] {
        let Imported { component, report } = import(&request(file, None, None)).unwrap();
        let expected = [
            [0.0, 0.0, 0.0],
            [-1.0, 0.0, 0.0],
            [-0.5, 0.5, 0.0],
            [-0.5, -0.5, 0.0],
            [-0.5, 0.0, 0.5],
            [-0.5, 0.0, -0.5],
        ];
        let found = component.mesh.coordinates.as_chunks::<3>().0;
        for (found, expected) in found.iter().zip(expected) {
            for axis in 0..3 {
                assert!(
                    (found[axis] - expected[axis]).abs() < 1e-12,
                    "{file}: {found:?}"
                );
            }
        }
        assert_eq!(found.len(), 6);
        assert!(report.resistance < 1e-12, "{}", report.text());
        assert!((report.mass_centre.mass / 1.849_612_674_800_982e-8 - 1.0).abs() < 1e-12);
        of_both.push(component.stiffness.clone());
    }
    let (symmetric, full) = (&of_both[0], &of_both[1]);
    let largest = symmetric
        .val()
        .iter()
        .fold(0.0_f64, |most, value| most.max(value.abs()));
    for (a, b) in symmetric.val().iter().zip(full.val()) {
        assert!((a - b).abs() <= 1e-14 * largest);
    }
}

/// The map of the solver's order as APDL Math writes it fits the list of nodes. Read the other way round, as a place for each node, it doesn't; nor
/// do the rows in the order of the list. Both are found out, and the order is in the stiffness.
#[test]
fn a_wrong_order_is_found_out_and_the_right_one_is_in_the_stiffness() {
    let rotor = request(
        "ansys/rotor_stiffness.txt",
        Some("ansys/rotor_mass.txt"),
        Some("ansys/rotor_nodes.txt"),
    );
    let with_table = |table: &Path| Import {
        dofs: Some(RowSource::Table(NamedFile::of(table))),
        ..rotor.clone()
    };
    let right = import(&with_table(&data("ansys/rotor_map.txt"))).unwrap();
    assert!(right.report.resistance < 1e-12, "{}", right.report.text());

    let folder = tempfile::tempdir().unwrap();
    let wrong = folder.path().join("wrong_map.txt");
    std::fs::write(&wrong, inverted(&data("ansys/rotor_map.txt"))).unwrap();
    for request in [with_table(&wrong), rotor.clone()] {
        let error = import(&request).map(drop).unwrap_err().to_string();
        assert!(error.contains("K R = 1."), "{error}");
        let repaired = Import {
            lost_order: LostOrder::Repair,
            ..request
        };
        let Imported { component, report } = import(&repaired).unwrap();
        assert!(report.resistance < 1e-12, "{}", report.text());
        // Published with the files: 77.97 kg, and the centre on the axis.
        assert!((report.mass_centre.mass - 77.966_047_05).abs() < 1e-6);
        let [x, y, z] = report.mass_centre.centre;
        assert!(x.abs() < 1e-9 && y.abs() < 1e-9 && (z - 0.187_928_033_2).abs() < 1e-8);
        assert_eq!(component.dofs.len(), 345);
    }
}

/// A map of places in place of one of nodes.
fn inverted(map: &Path) -> String {
    let text = std::fs::read_to_string(map).unwrap();
    let numbers: Vec<&str> = text.lines().filter(|line| !line.starts_with('%')).collect();
    let numbers = numbers.join(" ");
    let mut numbers = numbers
        .split_whitespace()
        .map(|word| word.parse::<usize>().unwrap());
    let count = numbers.next().unwrap();
    let nodes: Vec<usize> = numbers.skip(1).collect();
    assert_eq!(nodes.len(), count);
    let mut places = vec![0; count];
    for (place, node) in nodes.iter().enumerate() {
        places[node - 1] = place + 1;
    }
    let lines: Vec<String> = places.iter().map(usize::to_string).collect();
    format!(
        "%%MatrixMarket matrix array integer general\n{count} 1\n{}\n",
        lines.join("\n")
    )
}

/// The rotations of CalculiX's rigid body are found by the deck and proven by K.
#[test]
fn rotation_nodes_of_rigid_bodies_are_rotations() {
    let Imported { component, report } = import(&request(
        "calculix/bracket_rigid.sti",
        None,
        Some("calculix/bracket_rigid.inp"),
    ))
    .unwrap();
    assert_eq!(component.dofs.len(), 222);
    assert!(component.dofs.has_rotations());
    assert!(report.resistance < 1e-12, "{}", report.text());
    assert!((report.mass_centre.mass / 1.927_332_000_000_078_5e-4 - 1.0).abs() < 1e-12);
    let notes = report.notes.join("\n");
    assert!(
        notes.contains("the rows of node 9002 are rotations of node 9001"),
        "{notes}"
    );
}

/// C3D8I's incompatible modes, B33's internal node and modal amplitudes of an external superelement are rows that belong to no node.
#[test]
fn internal_rows_are_kept() {
    for (stiffness, mesh, rows, internal, mass) in [
        (
            "calculix/plate_incompatible.sti",
            "calculix/plate_incompatible.inp",
            162,
            72,
            1.130_400_000_000_003_4e-4,
        ),
        (
            "abaqus/fembeam/model_STIF1.mtx",
            "abaqus/fembeam/model.inp",
            14,
            2,
            75.0,
        ),
        (
            "nastran/pyyeti/outboard.op4#KXX",
            "nastran/pyyeti/outboard.pch",
            46,
            22,
            1.590_383_800_923_469_9,
        ),
    ] {
        let Imported { component, report } = import(&request(stiffness, None, Some(mesh))).unwrap();
        assert_eq!(
            (component.dofs.len(), component.dofs.internal_count()),
            (rows, internal),
            "{stiffness}"
        );
        assert!(report.resistance < 1e-13, "{stiffness}: {}", report.text());
        assert!(
            (report.mass_centre.mass / mass - 1.0).abs() < 1e-9,
            "{stiffness}: {}",
            report.text()
        );
    }
}
