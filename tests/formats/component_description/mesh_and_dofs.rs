//! Points, cells, dofs, units and damping.

use std::path::{Path, PathBuf};

use dcb_formats::component::Damping;
use dcb_formats::mesh::{Dimension, Direction, Dof};
use serde_json::{Value, json};

use super::*;

fn test_data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("data")
        .join(name)
}

/// EXUDYN's test meshes as a meshio script wrote them; their origin is in `tests/data/exudyn/SOURCES.md`.
#[test]
fn meshes_of_fe_codes_are_read() {
    for (name, nodes, cell_type, cells) in [
        ("rotorAnsys", 115, "hexahedron", 48),
        ("blockC3D10", 257, "tetra10", 122),
    ] {
        let bytes = std::fs::read(test_data(&format!("exudyn/{name}.mesh.json"))).unwrap();
        assert_says(
            &refusal(&bytes),
            &[
                "component: is missing",
                "\"units\": {\"length\": \"m\"",
                "\"interfaces\"",
            ],
        );

        let mut file: Value = serde_json::from_slice(&bytes).unwrap();
        file["component"] = pyramid()["component"].clone();
        file["component"]["interfaces"] =
            json!([{"name": "a", "nodes": [0, 1, 2, 3, 4], "kind": "average", "weights": "area"}]);
        let component = read(&file).unwrap();
        assert_eq!(component.mesh.node_count(), nodes);
        assert_eq!(component.mesh.cells[0].cell_type, cell_type);
        assert_eq!(component.mesh.cells[0].cell_count(), cells);
        assert_eq!(
            component.dof_map(3 * nodes, Path::new(name)).unwrap().len(),
            3 * nodes
        );
    }
}

#[test]
fn coordinates_keep_every_bit() {
    let mut file = triangle();
    file["points"] = json!([
        [0.1 + 0.2, 1.0 / 3.0],
        [9.007199254740993e15, 5e-324],
        [1.7976931348623157e308, -0.0]
    ]);
    let expected: [f64; 6] = [
        0.1 + 0.2,
        1.0 / 3.0,
        9.007199254740993e15,
        5e-324,
        1.7976931348623157e308,
        -0.0,
    ];
    let read = read(&file).unwrap().mesh.coordinates;
    assert_eq!(
        read.iter().map(|x| x.to_bits()).collect::<Vec<_>>(),
        expected.map(f64::to_bits)
    );
}

#[test]
fn planar_components_are_told_by_points_and_dofs() {
    let plate = read(&triangle()).unwrap();
    assert_eq!(plate.mesh.dimension, Dimension::Planar);
    assert_eq!(plate.mesh.coordinates, [0.0, 0.0, 1.0, 0.0, 0.0, 1.0]);

    let in_plane = with(
        triangle(),
        "/points",
        json!([[0, 0, 0], [1, 0, 0.0], [0, 1, -0.0]]),
    );
    let plate = read(&in_plane).unwrap();
    assert_eq!(plate.mesh.dimension, Dimension::Planar);
    assert_eq!(plate.mesh.coordinates, [0.0, 0.0, 1.0, 0.0, 0.0, 1.0]);
    assert!(plate.notes[0].contains("planar"), "{:?}", plate.notes);

    assert_refused(
        &with(
            triangle(),
            "/points",
            json!([[0, 0, 0], [1, 0, 2.5], [0, 1, 0]]),
        ),
        &["component.dofs: ", "point 1 has z = 2.5", "add uz"],
    );
    assert_refused(
        &with(triangle(), "/component/dofs", json!(["ux", "uy", "rx"])),
        &["component.dofs[2]: is rx", "two coordinates", "ux uy rz"],
    );
    assert_refused(
        &with(triangle(), "/component/dofs", json!(["ux", "rz"])),
        &["has no uy", "ux uy"],
    );
    assert_refused(
        &with(pyramid(), "/component/dofs", json!(["uz", "rx", "ry"])),
        &["has no ux", "ux uy uz"],
    );
}

#[test]
fn matrix_rows_and_dofs_must_be_as_many() {
    let pyramid = read(&pyramid()).unwrap();
    let path = Path::new("part.json");
    assert_eq!(
        pyramid.dof_map(15, path).unwrap().dof(4).unwrap(),
        Dof {
            node: 1,
            direction: Direction::Uy
        }
    );
    let message = pyramid.dof_map(14, path).unwrap_err().to_string();
    assert_says(
        &message,
        &[
            "part.json: component.dofs: ",
            "14 rows",
            "5 nodes x 3 dofs (ux uy uz) make 15",
            "table",
        ],
    );
    let message = pyramid.dof_map(30, path).unwrap_err().to_string();
    assert_says(&message, &["30 rows", "make 15", "30 = 5 nodes x 6"]);
    assert!(pyramid.dof_map(0, path).is_err());
}

#[test]
fn a_dof_table_lists_every_row() {
    let table = json!([[4, "uz"], [0, "ux"], [0, "uy"], [4, "rx"]]);
    let part = read(&with(pyramid(), "/component/dofs", table)).unwrap();
    let path = Path::new("part.json");
    let map = part.dof_map(4, path).unwrap();
    assert_eq!(
        (
            map.row(4, Direction::Uz),
            map.row(4, Direction::Rx),
            map.row(1, Direction::Ux)
        ),
        (Some(0), Some(3), None)
    );
    assert_says(
        &part.dof_map(5, path).unwrap_err().to_string(),
        &["5 rows", "lists 4 dofs"],
    );

    for (table, parts) in [
        (
            json!([[0, "ux"], [5, "uy"]]),
            &["component.dofs[1]: ", "node 5", "5 nodes"][..],
        ),
        (
            json!([[0, "ux"], [1, "uy"], [0, "ux"]]),
            &["component.dofs[2]: ", "node 0 ux again", "row 0"],
        ),
        (json!([[0, "ux"], "uy"]), &["dofs[1]", "can't be mixed"]),
        (json!([[0, "ux"], [0]]), &["dofs[1]", "a pair [node, name]"]),
        (json!([[0, "ux", 1]]), &["dofs[0]", "more than two"]),
        (json!([[0.5, "ux"]]), &["dofs[0]", "`0.5`", "a node id"]),
        (json!([[-1, "ux"]]), &["dofs[0]", "`-1`", "a node id"]),
        (
            json!(["ux", "uy", "ux"]),
            &["component.dofs[2]", "ux twice"],
        ),
        (
            json!(["ux", "uy", "UZ"]),
            &["dofs[2]", "unknown value `UZ`; did you mean `uz`?"],
        ),
        (
            json!([]),
            &["component.dofs: is empty", "[\"ux\", \"uy\", \"uz\"]"],
        ),
        (json!("ux"), &["\"ux\"", "a pattern such as"]),
    ] {
        assert_refused(&with(pyramid(), "/component/dofs", table), parts);
    }
}

#[test]
fn meshes_that_do_not_hold_together_are_refused() {
    for (pointer, value, parts) in [
        ("/points", json!([]), &["points: is empty"][..]),
        (
            "/points",
            json!([[1], [2]]),
            &["points[0]: has 1 coordinates", "3"],
        ),
        ("/points", json!([[]]), &["point 0 is empty"]),
        (
            "/points",
            json!([[0, 0, 0], [1, 0]]),
            &["point 1 has 2 coordinates, but point 0 has 3"],
        ),
        ("/points", json!({"0": [0, 0]}), &["a list of points"]),
        ("/points/2", json!(7), &["point 2: ", "`7`", "[x, y, z]"]),
        (
            "/format",
            json!("gmsh"),
            &["format: found \"gmsh\"", "meshio-json"],
        ),
        ("/version", json!(2), &["version: found 2", "version 1"]),
        (
            "/cells/0/data",
            json!([[0, 1, 2, 3]]),
            &["cells[0].data: has 4 nodes per cell, but a pyramid has 5"],
        ),
        (
            "/cells/0/data",
            json!([[0, 1, 2, 3, 4], [0, 1]]),
            &["cell 1 has 2 nodes, but cell 0 has 5"],
        ),
        (
            "/cells/0/data",
            json!([[0, 1, 2, 3, 4], [0, 1, 2, 3, 5]]),
            &["cells[0].data[1][4]: ", "node 5", "5 nodes", "1-based?"],
        ),
        (
            "/cells/0/data",
            json!([[0, 1, 2, 3, -1]]),
            &["cell 0: ", "`-1`", "a node id"],
        ),
        (
            "/cells/0/data",
            json!([[0, 1, 2, 3, 1.5]]),
            &["cell 0: ", "`1.5`"],
        ),
        (
            "/cells/0/data",
            json!([[0, 1, 2, 3, 4294967296u64]]),
            &["cell 0: ", "`4294967296`"],
        ),
        ("/cells/0/data", json!([[]]), &["cell 0 is empty"]),
        (
            "/cells/0",
            json!(["pyramid", [[0, 1, 2, 3, 4]]]),
            &["expected an object"],
        ),
        (
            "/point_sets/base",
            json!([0, 9]),
            &["point_sets.base[1]: is node 9", "5 nodes", "up to 4"],
        ),
        ("/point_sets/base", json!(3), &["a list of node ids"]),
    ] {
        assert_refused(&with(pyramid(), pointer, value), parts);
    }
    assert_refused(
        &without(pyramid(), "", "points"),
        &["missing field `points`", "[[0, 0, 0], [1, 0, 0]]"],
    );
    let twice = pyramid()
        .to_string()
        .replacen("\"empty\":[]", "\"base\":[]", 1);
    assert_says(
        &refusal(twice.as_bytes()),
        &["point set \"base\" stands twice"],
    );
    let twice = pyramid()
        .to_string()
        .replacen("\"cells\":", "\"points\":[],\"cells\":", 1);
    assert_says(&refusal(twice.as_bytes()), &["duplicate field `points`"]);
}

#[test]
fn unknown_cell_types_are_kept_with_a_note() {
    let part = read(&with(pyramid(), "/cells/0/type", json!("pyramide"))).unwrap();
    assert_eq!(
        (
            part.mesh.cells[0].cell_type.as_str(),
            part.mesh.cells[0].nodes_per_cell
        ),
        ("pyramide", 5)
    );
    assert_says(
        &part.notes[0],
        &["cells[0]", "`pyramide`", "did you mean `pyramid`?"],
    );
    let part = read(&with(pyramid(), "/cells/0/data", json!([]))).unwrap();
    assert_eq!(
        (
            part.mesh.cells[0].cell_count(),
            part.mesh.cells[0].nodes_per_cell
        ),
        (0, 5)
    );
}

#[test]
fn skipped_parts_may_hold_anything() {
    let mut file = pyramid();
    file["$schema"] = json!("component.schema.json");
    file["format"] = json!("meshio-json");
    file["version"] = json!(1);
    file["point_data"] = json!({"T": [1, [2, {"x": null}]]});
    file["cell_data"] = json!({});
    file["field_data"] = json!({"steel": [1, 3]});
    assert!(read(&file).is_ok());
}

#[test]
fn units_and_damping_are_checked() {
    for (pointer, value, parts) in [
        (
            "/component/units/mass",
            json!(" "),
            &["component.units.mass: is empty"][..],
        ),
        (
            "/component/units",
            json!(["m", "kg", "s"]),
            &["expected an object"],
        ),
        (
            "/component/units",
            json!({"length": "m", "mass": "kg"}),
            &["missing field `time`"],
        ),
        ("/component/name", json!(""), &["component.name: is empty"]),
        ("/component", json!([]), &["expected an object"]),
        ("/component", json!(null), &["component: is missing"]),
        (
            "/component/damping",
            json!({}),
            &["component.damping: is empty", "{\"modal\": 0.01}"],
        ),
        (
            "/component/damping",
            json!({"modal": 0.1, "rayleigh": [0, 0]}),
            &["has both"],
        ),
        (
            "/component/damping",
            json!({"modal": -0.1}),
            &["damping.modal: is -0.1", ">= 0"],
        ),
        (
            "/component/damping",
            json!({"modal": [0.1, -0.2]}),
            &["damping.modal[1]: is -0.2"],
        ),
        (
            "/component/damping",
            json!({"modal": []}),
            &["damping.modal: is an empty list"],
        ),
        (
            "/component/damping",
            json!({"modal": "1 %"}),
            &["a damping ratio or a list"],
        ),
        (
            "/component/damping",
            json!({"rayleigh": [1]}),
            &["rayleigh: has 1 numbers, expected 2"],
        ),
        (
            "/component/damping",
            json!({"rayleigh": [1, -1e-5]}),
            &["rayleigh[1]: is -0.00001"],
        ),
        (
            "/component/damping",
            json!({"rayleigh": {"frequencies": [1, 10, 20], "ratios": [0.01, 0.02]}}),
            &["damping.rayleigh.frequencies: has 3 numbers, expected 2"],
        ),
        (
            "/component/damping",
            json!({"rayleigh": {"frequencies": [1, 1], "ratios": [0.01, 0.02]}}),
            &["damping.rayleigh: has the frequency 1 twice"],
        ),
        (
            "/component/damping",
            json!({"rayleigh": {"frequencies": [0, 1], "ratios": [0.01, 0.02]}}),
            &["damping.rayleigh: has the frequency 0, expected frequencies above 0"],
        ),
        (
            "/component/damping",
            json!({"rayleigh": {"frequencies": [2, 1], "ratios": [0.01, -0.02]}}),
            &["damping.rayleigh: has the ratio -0.02"],
        ),
        (
            "/component/damping",
            json!({"rayleigh": {"frequencies": [1, 10], "ratios": [0.01, 0.2]}}),
            &[
                "damping.rayleigh: needs alpha = -",
                "1.0000e-1 to 1.0000e1 of the first",
                "is 2.0000e1 of it",
            ],
        ),
        (
            "/component/damping",
            json!({"rayleigh": {"frequencies": [10, 1], "ratios": [0.01, 0.0001]}}),
            &["damping.rayleigh: needs alpha = -"],
        ),
        (
            "/component/damping",
            json!({"rayleigh": {"frequencies": [1, 10], "ratios": [0.2, 0.01]}}),
            &["damping.rayleigh: needs beta = -"],
        ),
        (
            "/component/damping",
            json!({"rayleigh": {"frequencies": [1, 10]}}),
            &["missing field `ratios`"],
        ),
        (
            "/component/damping",
            json!({"rayleigh": 3}),
            &["[alpha, beta]", "frequencies"],
        ),
    ] {
        assert_refused(&with(pyramid(), pointer, value), parts);
    }
    let damped = |damping| read(&with(pyramid(), "/component/damping", damping)).unwrap();
    assert_eq!(damped(json!({"modal": 0})).damping, Damping::Uniform(0.0));
    assert_eq!(
        damped(json!({"rayleigh": [2, 1e-5]})).damping,
        Damping::Rayleigh {
            alpha: 2.0,
            beta: 1e-5
        }
    );
    // 2 ζ ω = alpha + beta ω² at both frequencies, in either order; ratios as the frequencies need beta alone.
    for (frequencies, ratios) in [
        ([8.0, 80.0], [0.005, 0.02]),
        ([80.0, 8.0], [0.02, 0.005]),
        ([3.0, 6.0], [0.01, 0.02]),
    ] {
        let given = json!({"rayleigh": {"frequencies": frequencies, "ratios": ratios}});
        let Damping::Rayleigh { alpha, beta } = damped(given).damping else {
            panic!("no Rayleigh damping");
        };
        for (frequency, ratio) in frequencies.iter().zip(ratios) {
            let omega = std::f64::consts::TAU * frequency;
            let found = 0.5 * (alpha / omega + beta * omega);
            assert!((found / ratio - 1.0).abs() < 1e-12, "{found} {ratio}");
        }
        assert!(frequencies[0] != 3.0 || alpha == 0.0, "{alpha}");
    }
    assert_eq!(damped(json!(null)).damping, Damping::None);
    assert_says(
        &damped(json!({"modal": 2})).notes[0],
        &["component.damping.modal is 2", "percent"],
    );
}
