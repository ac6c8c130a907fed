//! One part in the files of many programs: each gives the component of the Matrix Market files, number for number.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::float_cmp)]

mod orders;

use std::path::{Path, PathBuf};

use dcb_formats::component::{Component, Units};
use dcb_formats::component_files::{ComponentFiles, Overrides, read_component};
use dcb_import::{Import, Imported, LostOrder, NamedFile, NodeOrder, import};

fn data(name: &str) -> PathBuf {
    Path::new("../../tests/data/exchange").join(name)
}

fn named(name: &str) -> NamedFile {
    NamedFile::of(&data(name))
}

fn request(stiffness: &str, mass: Option<&str>, mesh: &str) -> Import {
    Import {
        stiffness: named(stiffness),
        mass: mass.map(named),
        mesh: Some(data(mesh)),
        dofs: None,
        node_order: NodeOrder::Label,
        lost_order: LostOrder::Refuse,
        interfaces: None,
        units: Some(Units {
            length: "mm".into(),
            mass: "t".into(),
            time: "s".into(),
        }),
        name: None,
    }
}

fn plain() -> Component {
    let files = ComponentFiles::beside(&data("bracket.mtx"), &Overrides::default()).unwrap();
    read_component(&files, None).unwrap()
}

/// Equal but for names of files, sets and notes, and but for how exactly the mesh prints its coordinates.
fn assert_same(of: &str, found: &Component, expected: &Component, coordinate_tolerance: f64) {
    for (name, found, expected) in [
        ("stiffness", &found.stiffness, &expected.stiffness),
        ("mass", &found.mass, &expected.mass),
    ] {
        assert_eq!(found.col_ptr(), expected.col_ptr(), "{of}: {name}");
        assert_eq!(found.row_idx(), expected.row_idx(), "{of}: {name}");
        let bits = |values: &[f64]| {
            values
                .iter()
                .map(|value| value.to_bits())
                .collect::<Vec<_>>()
        };
        assert!(bits(found.val()) == bits(expected.val()), "{of}: {name}");
    }
    let pairs = found
        .mesh
        .coordinates
        .iter()
        .zip(&expected.mesh.coordinates);
    let farthest = pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(farthest <= coordinate_tolerance, "{of}: {farthest}");
    // Gmsh's named faces are cells too.
    let solids = |component: &Component| {
        let cells = component.mesh.cells.iter();
        cells
            .filter(|cells| cells.cell_type != "quad8")
            .cloned()
            .collect::<Vec<_>>()
    };
    assert_eq!(solids(found), solids(expected), "{of}");
    assert_eq!(found.dofs, expected.dofs, "{of}");
    for (found, expected) in found.interfaces.iter().zip(&expected.interfaces) {
        // Nastran's sets have numbers for names.
        let is_number = found.name.bytes().any(|byte| byte.is_ascii_digit());
        assert!(
            is_number || found.name.eq_ignore_ascii_case(&expected.name),
            "{of}"
        );
        assert_eq!(found.nodes, expected.nodes, "{of}");
    }
    // VTU has no sets.
    if !of.ends_with(".vtu") {
        assert_eq!(found.interfaces.len(), expected.interfaces.len(), "{of}");
    }
}

/// With the mesh of the component file nothing is rounded: the component, and so its superelement, is the same to the last bit.
#[test]
fn every_lossless_form_is_the_same_component() {
    let expected = plain();
    for (stiffness, mass) in LOSSLESS {
        let request = Import {
            node_order: NodeOrder::File,
            ..request(stiffness, *mass, "bracket.json")
        };
        let Imported { component, report } = import(&request).unwrap();
        assert!(report.resistance < 1e-12, "{stiffness}: {}", report.text());
        assert_same(stiffness, &component, &expected, 0.0);
    }
}

/// Stiffness, and mass where it isn't found by itself.
const LOSSLESS: &[(&str, Option<&str>)] = &[
    ("bracket.mtx", None),
    ("matlab/bracket_v5.mat", None),
    ("matlab/bracket_v5_compressed.mat", None),
    ("matlab/bracket_v73.mat", None),
    ("petsc/bracket_K.petsc", None),
    ("nastran/bracket_bigmat_ascii.op4", None),
    ("nastran/bracket_bigmat_be.op4", None),
    ("nastran/bracket_dense_le.op4", None),
    ("nastran/bracket_nonbigmat_le.op4", None),
    ("scipy/bracket_dense.npz", None),
    ("scipy/bracket_dof_ref.npz", None),
    ("abaqus/bracket_STIF1.mtx", None),
    ("abaqus/bracket_STIF1_coordinate.mtx", None),
    ("ansys/bracket_stiff.matrix", None),
    ("calculix/bracket.sti", None),
    ("scipy/bracket_K_csr.npz", None),
    ("scipy/bracket_K_coo.npz", Some("scipy/bracket_M_csr.npz")),
    ("scipy/bracket_K_bsr.npz", Some("scipy/bracket_M_array.npz")),
    (
        "scipy/bracket_K_csc_stored.npz",
        Some("scipy/bracket_M_csr.npz"),
    ),
];

/// The same matrices on every mesh.
#[test]
fn every_mesh_is_the_same_part() {
    let expected = plain();
    for mesh in [
        "calculix/bracket.inp",
        "calculix/bracket_transform.inp",
        "mesh/bracket.bdf",
        "mesh/bracket_ascii.msh",
        "mesh/bracket_binary.msh",
        "mesh/bracket.unv",
        "mesh/bracket_zlib.vtu",
    ] {
        let Imported { component, .. } =
            import(&request("matlab/bracket_v5.mat", None, mesh)).unwrap();
        assert_same(mesh, &component, &expected, 1e-12);
    }
}

/// In the order of the file the rows don't fit, and the message says which order does.
#[test]
fn the_other_order_of_nodes_is_named() {
    let request = Import {
        node_order: NodeOrder::File,
        ..request("matlab/bracket_v5.mat", None, "calculix/bracket.inp")
    };
    let error = import(&request).unwrap_err().to_string();
    assert!(error.contains("add --node-order label"), "{error}");
}

/// Also where nobody says the order.
#[test]
fn a_lost_order_is_found_from_the_stiffness() {
    let request = Import {
        node_order: NodeOrder::File,
        lost_order: LostOrder::Repair,
        ..request("matlab/bracket_v5.mat", None, "calculix/bracket.inp")
    };
    let Imported { component, report } = import(&request).unwrap();
    assert_same("repaired", &component, &plain(), 1e-12);
    let notes = component.notes.join("\n");
    assert!(notes.contains("was found from the stiffness"), "{notes}");
    assert!(report.resistance < 1e-12);
}

/// Printed with fewer digits: as close as these are, and refused where they are too few.
#[test]
fn punched_matrices_are_as_good_as_their_digits() {
    let expected = plain();
    let double = request("nastran/bracket_double.pch", None, "mesh/bracket.bdf");
    let Imported { component, report } = import(&double).unwrap();
    let largest = |values: &[f64]| {
        values
            .iter()
            .fold(0.0_f64, |most, value| most.max(value.abs()))
    };
    for (found, expected) in [
        (&component.stiffness, &expected.stiffness),
        (&component.mass, &expected.mass),
    ] {
        assert_eq!(found.row_idx(), expected.row_idx());
        let most = largest(expected.val());
        for (a, b) in found.val().iter().zip(expected.val()) {
            assert!((a - b).abs() <= 1e-10 * most, "{a} {b}");
        }
    }
    assert!(report.resistance < 1e-9, "{}", report.text());

    let small = request("nastran/bracket_small_field.pch", None, "mesh/bracket.bdf");
    let error = import(&small).map(drop).unwrap_err().to_string();
    assert!(
        error.contains("significant digits") && error.contains("export more digits"),
        "{error}"
    );
}
