//! The component file: what is read from good ones, and what is said about bad ones.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use dcb_formats::component::{Damping, InterfaceKind, Role, Weights};
use dcb_formats::description::DofLayout;
use dcb_formats::mesh::{Dimension, Direction, Dof};
use dcb_formats::{Description, Error, component_schema, read_description};
use serde_json::{Value, json};

const DOCUMENTATION: &str = include_str!("../../docs/component.md");

fn read_bytes(bytes: &[u8]) -> Result<Description, Error> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("part.json");
    std::fs::write(&path, bytes).unwrap();
    read_description(&path)
}

fn read(file: &Value) -> Result<Description, Error> {
    read_bytes(file.to_string().as_bytes())
}

/// The message for a file that must be refused, without its folder.
fn refusal(bytes: &[u8]) -> String {
    let message = read_bytes(bytes).expect_err("a refusal").to_string();
    let at = message.find("part.json").unwrap();
    message[at..].to_owned()
}

#[track_caller]
fn assert_refused(file: &Value, parts: &[&str]) {
    assert_says(&refusal(file.to_string().as_bytes()), parts);
}

#[track_caller]
fn assert_says(message: &str, parts: &[&str]) {
    for part in parts {
        assert!(message.contains(part), "{part:?} is not in: {message}");
    }
}

fn test_data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("tests/data")
        .join(name)
}

/// The fenced block of this language in the documentation.
fn documented(language: &str) -> &'static str {
    let (_, after) = DOCUMENTATION
        .split_once(&format!("```{language}\n"))
        .unwrap();
    after.split_once("```").unwrap().0
}

/// Five nodes in space, one pyramid, one interface of every kind.
fn pyramid() -> Value {
    json!({
        "points": [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0.5, 0.5, 1]],
        "cells": [{"type": "pyramid", "data": [[0, 1, 2, 3, 4]]}],
        "point_sets": {"base": [0, 1, 2, 3], "empty": [], "twice": [4, 3, 4]},
        "cell_sets": {"solid": [[0]]},
        "component": {
            "name": "pyramid",
            "units": {"length": "mm", "mass": "t", "time": "s"},
            "dofs": ["ux", "uy", "uz"],
            "interfaces": [
                {"name": "foot", "point_set": "base", "kind": "average"},
                {"name": "tip", "nodes": [4], "kind": "nodes"}
            ]
        }
    })
}

fn triangle() -> Value {
    json!({
        "points": [[0, 0], [1, 0], [0, 1]],
        "component": {
            "name": "plate", "units": {"length": "m", "mass": "kg", "time": "s"}, "dofs": ["ux", "uy"],
            "interfaces": [{"name": "edge", "nodes": [1, 2], "kind": "average"}]
        }
    })
}

fn with(mut file: Value, pointer: &str, value: Value) -> Value {
    let (parent, key) = pointer.rsplit_once('/').unwrap();
    match file.pointer_mut(parent).unwrap() {
        Value::Array(list) => list[key.parse::<usize>().unwrap()] = value,
        object => object[key] = value,
    }
    file
}

fn without(mut file: Value, parent: &str, key: &str) -> Value {
    let removed = file
        .pointer_mut(parent)
        .unwrap()
        .as_object_mut()
        .unwrap()
        .remove(key);
    removed.expect("the key to remove");
    file
}

/// The pyramid with a changed first interface, whose kind is `average`.
fn with_foot(key: &str, value: Value) -> Value {
    with(pyramid(), &format!("/component/interfaces/0/{key}"), value)
}

#[test]
fn the_documented_example_gives_every_field() {
    let plate = read_bytes(documented("json").as_bytes()).unwrap();
    assert_eq!(plate.name, "plate");
    assert_eq!(
        (
            plate.units.length.as_str(),
            plate.units.mass.as_str(),
            plate.units.time.as_str()
        ),
        ("m", "kg", "s")
    );
    assert_eq!(plate.mesh.dimension, Dimension::Spatial);
    assert_eq!(plate.mesh.position(2), [0.1, 0.1, 0.0]);
    assert_eq!(
        plate.mesh.cells[0].cells().collect::<Vec<_>>(),
        [&[0, 1, 2, 3]]
    );
    assert_eq!(plate.mesh.point_sets["left_edge"], [0, 3]);
    assert_eq!(plate.dofs, DofLayout::Pattern(Direction::ALL.to_vec()));
    assert_eq!(plate.damping, Damping::PerMode(vec![0.01, 0.02]));
    assert!(plate.notes.is_empty(), "{:?}", plate.notes);

    let [clamp, hinge, sensor] = &plate.interfaces[..] else {
        panic!("three interfaces")
    };
    assert_eq!(
        (clamp.name.as_str(), clamp.kind, clamp.role),
        ("clamp", InterfaceKind::Rigid, Role::Attachment)
    );
    assert_eq!(clamp.nodes, [0, 3]);
    assert_eq!(clamp.position, Some([0.0, 0.05, 0.0]));
    assert_eq!((&clamp.directions, &clamp.axes), (&None, &None));
    assert_eq!(hinge.kind, InterfaceKind::Average);
    assert_eq!(hinge.weights, Weights::Given(vec![1.0, 1.0]));
    assert_eq!(
        hinge.axes,
        Some([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])
    );
    assert_eq!(
        hinge.directions,
        Some(vec![
            Direction::Ux,
            Direction::Uy,
            Direction::Uz,
            Direction::Ry
        ])
    );
    assert_eq!(
        (sensor.kind, sensor.role),
        (InterfaceKind::Nodes, Role::Output)
    );
    assert_eq!(sensor.nodes, [2]);

    let map = plate.dof_map(24, Path::new("plate.json")).unwrap();
    assert_eq!(map.row(3, Direction::Ry), Some(3 * 6 + 4));
}

#[test]
fn the_published_schema_is_the_one_of_the_code() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/component.schema.json");
    let published: Value = serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap();
    assert!(
        published == component_schema(),
        "run: cargo run --release -p dcb-formats --example component_schema > docs/component.schema.json"
    );
}

#[test]
fn the_digest_is_that_of_the_bytes() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("part.json");
    std::fs::write(&path, documented("json")).unwrap();
    let digest = read_description(&path).unwrap().sha256;
    assert_eq!(digest.len(), 64);
    std::fs::write(&path, format!("{}\n", documented("json"))).unwrap();
    assert_ne!(
        read_description(&path).unwrap().sha256,
        digest,
        "one more byte"
    );
}

/// EXUDYN's test meshes as a meshio script wrote them; node counts from `tests/data/exudyn/SOURCES.md`'s originals.
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
        pyramid.dof_map(15, path).unwrap().dofs()[4],
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
fn a_typing_error_gives_line_column_and_the_nearest_name() {
    let text = "{\n  \"points\": [[0, 0]],\n  \"componnet\": {}\n}";
    assert_says(
        &refusal(text.as_bytes()),
        &["part.json:3: column 13: unknown field `componnet`; did you mean `component`?"],
    );
    let text = documented("json");
    for (right, wrong, parts) in [
        (
            "\"kind\": \"rigid\"",
            "\"knid\": \"rigid\"",
            ["unknown field `knid`; did you mean `kind`?", "point_set"],
        ),
        (
            "\"kind\": \"rigid\"",
            "\"kind\": \"rigit\"",
            ["unknown value `rigit`; did you mean `rigid`?", "average"],
        ),
        (
            "\"role\": \"output\"",
            "\"role\": \"ouput\"",
            [
                "unknown value `ouput`; did you mean `output`?",
                "attachment",
            ],
        ),
        (
            "\"mass\": \"kg\"",
            "\"Mass\": \"kg\"",
            ["unknown field `Mass`; did you mean `mass`?", "length"],
        ),
        (
            "\"modal\"",
            "\"model\"",
            ["unknown field `model`; did you mean `modal`?", "rayleigh"],
        ),
        (
            "\"weights\": [1, 1]",
            "\"weights\": \"aera\"",
            ["unknown value `aera`; did you mean `area`?", "uniform"],
        ),
        (
            "\"type\": \"quad\"",
            "\"typ\": \"quad\"",
            ["unknown field `typ`; did you mean `type`?", "data"],
        ),
        (
            "\"name\": \"plate\",",
            "",
            ["missing field `name`", "connecting-rod"],
        ),
        (
            "\"kind\": \"rigid\",",
            "",
            ["missing field `kind`", "average"],
        ),
    ] {
        let text = text.replacen(right, wrong, 1);
        let message = refusal(text.as_bytes());
        assert_says(&message, &parts);
        let line = message["part.json:".len()..]
            .split(':')
            .next()
            .unwrap()
            .parse::<usize>()
            .unwrap();
        assert!(
            wrong.is_empty() || text.lines().nth(line - 1).unwrap().contains(wrong),
            "{message}"
        );
        assert!(message.contains(": column "), "{message}");
    }
}

#[test]
fn text_that_is_no_json_is_refused_where_it_goes_wrong() {
    for literal in ["NaN", "Infinity", "-Infinity"] {
        let text = format!("{{\n\"points\": [[0, 0],\n [1, {literal}]]}}");
        assert_says(
            &refusal(text.as_bytes()),
            &[
                "part.json:3: column ",
                &format!("`{literal}` is not a number"),
                "finite",
            ],
        );
        let text = format!("{{\"point_data\": {{\"T\": [1.0, {literal}]}}}}");
        assert_says(
            &refusal(text.as_bytes()),
            &[&format!("`{literal}` is not a number")],
        );
    }
    assert_says(
        &refusal(b"{\"points\": [[0, 1e999]]}"),
        &["part.json:1: column 21", "number out of range"],
    );
    assert_says(
        &refusal(b"{\"points\": [[0, 0],]}"),
        &["part.json:1: column 20", "trailing comma"],
    );
    assert_says(&refusal(b"{\"points\": [[0, 0]"), &["EOF"]);
    assert_says(
        &refusal(b"{\"points\": [[0, \"0\"]]}"),
        &["point 0: ", "string \"0\"", "a finite number"],
    );
    assert_says(
        &refusal(b"{\"points\": [[0, 0], [null, 1]]}"),
        &["point 1: ", "null", "a finite number"],
    );
    assert_says(&refusal(b"[1, 2]"), &["expected an object"]);
    assert_says(
        &refusal(b"%%MatrixMarket matrix"),
        &["part.json:1: column 1: expected value"],
    );
    assert_says(&refusal(b"{\"points\": \"\xff\"}"), &["part.json:1: "]);
    let nested = [b"{\"field_data\": ".as_slice(), &[b'['; 100_000]].concat();
    assert_says(&refusal(&nested), &["part.json:1: "]);
}

#[test]
fn files_that_are_no_text_are_refused() {
    assert_says(&refusal(b""), &["part.json: is empty", "`points`"]);
    assert_says(&refusal(b" \n\t\n"), &["part.json: is empty"]);
    assert_says(&refusal(b"\xff\xfe{\0}\0"), &["UTF-16", "UTF-8"]);
    assert_says(&refusal(b"\x1f\x8b\x08"), &["gzip"]);
    let folder = tempfile::tempdir().unwrap();
    assert_says(
        &read_description(folder.path()).unwrap_err().to_string(),
        &["is a folder"],
    );
    let missing = folder.path().join("nothing.json");
    assert_says(
        &read_description(&missing).unwrap_err().to_string(),
        &["nothing.json: cannot read: No such file"],
    );
    let marked = [b"\xef\xbb\xbf", documented("json").as_bytes()].concat();
    assert_eq!(read_bytes(&marked).unwrap().name, "plate");
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
fn an_interface_needs_nodes_that_exist() {
    for (interface, parts) in [
        (
            json!({"name": "a", "kind": "nodes"}),
            &[
                "component.interfaces[0]: names no node",
                "`point_set`",
                "`nodes`",
            ][..],
        ),
        (
            json!({"name": "a", "kind": "nodes", "nodes": [1], "point_set": "base"}),
            &["interfaces[0]: has both"],
        ),
        (
            json!({"name": "a", "kind": "nodes", "nodes": []}),
            &["interfaces[0].nodes: is empty"],
        ),
        (
            json!({"name": "a", "kind": "nodes", "nodes": [0, 1, 7]}),
            &["component.interfaces[0].nodes[2]: is node 7", "5 nodes"],
        ),
        (
            json!({"name": "a", "kind": "nodes", "nodes": [0, 1, 0]}),
            &["component.interfaces[0].nodes[2]: is node 0 again"],
        ),
        (
            json!({"name": "a", "kind": "nodes", "point_set": "empty"}),
            &["interfaces[0].point_set: ", "\"empty\" is empty"],
        ),
        (
            json!({"name": "a", "kind": "nodes", "point_set": "bsae"}),
            &["\"bsae\"", "did you mean `base`?", "base, empty, twice"],
        ),
        (
            json!({"name": "a", "kind": "nodes", "point_set": "solid"}),
            &["\"solid\" is a cell set"],
        ),
        (
            json!({"name": "", "kind": "nodes", "nodes": [1]}),
            &["interfaces[0].name: is empty"],
        ),
        (
            json!({"name": "a/b", "kind": "nodes", "nodes": [1]}),
            &["interfaces[0].name: ", "\"a/b\"", "`/`"],
        ),
        (
            json!({"name": "a\nb", "kind": "nodes", "nodes": [1]}),
            &["control character"],
        ),
        (
            json!({"name": "tip", "kind": "nodes", "nodes": [1]}),
            &["interfaces[1].name: \"tip\"", "interfaces[0]"],
        ),
        (
            json!({"name": "a", "kind": "boundary", "nodes": [1]}),
            &["unknown value `boundary`", "nodes, average, rigid"],
        ),
        (json!(["a", "nodes"]), &["expected an object"]),
    ] {
        assert_refused(&with_foot_replaced(interface), parts);
    }
    let part = read(&with_foot("point_set", json!("twice"))).unwrap();
    assert_eq!(part.interfaces[0].nodes, [4, 3]);
    assert_says(
        &part.notes[0],
        &["interfaces[0].point_set", "\"twice\"", "1 nodes again"],
    );
    let part = read(&with(pyramid(), "/component/interfaces", json!([]))).unwrap();
    assert_says(&part.notes[0], &["no interface"]);
    let no_sets = without(pyramid(), "", "point_sets");
    assert_refused(
        &no_sets,
        &[
            "no point set is named \"base\"",
            "the file has no point sets",
        ],
    );
}

fn with_foot_replaced(interface: Value) -> Value {
    with(pyramid(), "/component/interfaces/0", interface)
}

#[test]
fn options_fit_the_kind_of_interface() {
    for (key, value, parts) in [
        (
            "position",
            json!([0, 0]),
            &["interfaces[0].position: has 2 numbers, expected 3"][..],
        ),
        (
            "weights",
            json!([1, 2]),
            &["interfaces[0].weights: has 2 numbers", "4 nodes"],
        ),
        (
            "weights",
            json!([1, 2, 0, 1]),
            &["interfaces[0].weights[2]: is 0", "> 0"],
        ),
        (
            "weights",
            json!(2),
            &["\"uniform\"", "one positive number per node"],
        ),
        ("dofs", json!([]), &["interfaces[0].dofs: is empty"]),
        (
            "dofs",
            json!(["ux", "ux"]),
            &["interfaces[0].dofs[1]: names ux twice"],
        ),
        (
            "role",
            json!("sensor"),
            &["unknown value `sensor`", "attachment, output"],
        ),
    ] {
        assert_refused(&with_foot(key, value), parts);
    }
    let tip = "/component/interfaces/1";
    assert_refused(
        &with(pyramid(), &format!("{tip}/position"), json!([0, 0, 0])),
        &["interfaces[1].position", "`nodes`"],
    );
    assert_refused(
        &with(pyramid(), &format!("{tip}/weights"), json!("area")),
        &["interfaces[1].weights", "`average`", "`nodes`"],
    );
    assert_refused(
        &with(pyramid(), &format!("{tip}/dofs"), json!(["rx"])),
        &["interfaces[1].dofs[0]: is rx", "only ux uy uz"],
    );
    let planar = with(triangle(), "/component/interfaces/0/dofs", json!(["uz"]));
    assert_refused(
        &planar,
        &["dofs[0]: is uz, but the frame has only ux uy rz"],
    );
    let planar = with(
        triangle(),
        "/component/interfaces/0/position",
        json!([0, 1, 2]),
    );
    assert_refused(&planar, &["position: has z = 2", "planar"]);
}

#[test]
fn frames_have_translations_before_rotations() {
    let part = read(&with_foot("dofs", json!(["rz", "uy", "ux"]))).unwrap();
    assert_eq!(
        part.interfaces[0].directions,
        Some(vec![Direction::Ux, Direction::Uy, Direction::Rz])
    );
    let part = read(&with(
        pyramid(),
        "/component/interfaces/1/dofs",
        json!(["uz", "ux"]),
    ))
    .unwrap();
    assert_eq!(
        part.interfaces[1].directions,
        Some(vec![Direction::Uz, Direction::Ux])
    );
}

#[test]
fn axes_are_right_handed_unit_vectors() {
    for (axes, parts) in [
        (
            json!([[1, 0, 0], [0, 1, 0]]),
            &["interfaces[0].axes: has 2 rows", "expected 3 rows of 3"][..],
        ),
        (json!([[1, 0, 0], [0, 1], [0, 0, 1]]), &["3, 2, 3 numbers"]),
        (
            json!([[1, 0, 0], [0, 2, 0], [0, 0, 1]]),
            &["interfaces[0].axes[1]: has length 2", "unit vector"],
        ),
        (
            json!([[1, 0, 0], [0.6, 0.8, 0], [0, 0, 1]]),
            &["rows 0 and 1 are not perpendicular", "6e-1"],
        ),
        (json!([[1, 0, 0], [0, 1, 0], [0, 0, -1]]), &["left-handed"]),
        (
            json!([[1e200, 0, 0], [0, 1e200, 0], [0, 0, 1e200]]),
            &["axes[0]: has length inf"],
        ),
    ] {
        assert_refused(&with_foot("axes", axes), parts);
    }
    let planar_axes = |axes| with(triangle(), "/component/interfaces/0/axes", axes);
    let part = read(&planar_axes(json!([[0.6, 0.8], [-0.8, 0.6]]))).unwrap();
    let axes = part.interfaces[0].axes.unwrap();
    assert!((axes[0][0] - 0.6).abs() < 1e-15 && (axes[1][0] + 0.8).abs() < 1e-15);
    assert_eq!(axes[2], [0.0, 0.0, 1.0]);
    assert_refused(&planar_axes(json!([[0, 1], [1, 0]])), &["left-handed"]);
    assert_refused(
        &planar_axes(json!([[0, 1, 0], [1, 0, 0], [0, 0, -1]])),
        &["axes[2]", "turns about z"],
    );
}

#[test]
fn two_rigid_interfaces_cannot_share_a_node() {
    let interfaces = json!([
        {"name": "a", "nodes": [0, 1, 2], "kind": "rigid"},
        {"name": "b", "nodes": [2, 3], "kind": "average"},
        {"name": "c", "nodes": [4, 2], "kind": "rigid"}
    ]);
    assert_refused(
        &with(pyramid(), "/component/interfaces", interfaces),
        &[
            "component.interfaces[2]: node 2 belongs to the rigid interface \"a\"",
            "`average`",
        ],
    );
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
    assert_eq!(damped(json!(null)).damping, Damping::None);
    assert_says(
        &damped(json!({"modal": 2})).notes[0],
        &["component.damping.modal is 2", "percent"],
    );
}

#[test]
fn the_documented_messages_are_the_real_ones() {
    let misspelt = documented("json").replacen("\"kind\"", "\"knid\"", 1);
    let unknown_key = refusal(misspelt.as_bytes());
    let (_, unknown_key) = unknown_key.split_once("unknown field").unwrap();

    let mut file = pyramid();
    file["point_sets"] = json!({"big_end": [0, 1], "small_end": [4]});
    file["component"]["interfaces"] =
        json!([{"name": "a", "point_set": "big_ned", "kind": "rigid"}]);
    let unknown_set = refusal(file.to_string().as_bytes());

    file["component"]["interfaces"] = json!([]);
    file["points"] = json!(vec![[0.0, 0.0, 1.0]; 115]);
    let row_count = read(&file)
        .unwrap()
        .dof_map(342, Path::new("part.json"))
        .unwrap_err()
        .to_string();
    for message in [unknown_key, &unknown_set, &row_count] {
        assert!(
            DOCUMENTATION.contains(message),
            "not in docs/component.md: {message}"
        );
    }
}

/// Gmsh 2.2: two triangles and a named edge; physical tags repeat between dimensions.
const GMSH_SQUARE: &str = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n1 1 \"left edge\"\n2 1 \"plate\"\n\
    $EndPhysicalNames\n$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n$EndNodes\n\
    $Elements\n3\n1 1 2 1 1 4 1\n2 2 2 1 1 1 2 3\n3 2 2 1 1 1 3 4\n$EndElements\n";

/// Needs Python with meshio; without them there is nothing to run.
#[test]
fn the_documented_script_turns_a_meshio_mesh_into_a_component() {
    use std::process::Command;
    let script = documented("python");
    assert!(script.lines().count() <= 15);
    let meshio = Command::new("python3")
        .args(["-c", "import meshio"])
        .output();
    if !meshio.is_ok_and(|found| found.status.success()) {
        eprintln!("skipped: python3 with meshio is not installed");
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let (mesh, part) = (
        folder.path().join("square.msh"),
        folder.path().join("square.json"),
    );
    std::fs::write(&mesh, GMSH_SQUARE).unwrap();
    let run = Command::new("python3")
        .args(["-c", script])
        .args([&mesh, &part])
        .output()
        .unwrap();
    assert!(
        run.status.success(),
        "{}",
        String::from_utf8_lossy(&run.stderr)
    );
    let square = read_description(&part).unwrap();
    assert_eq!(square.mesh.point_sets["left edge"], [0, 3]);
    assert_eq!(square.mesh.point_sets["plate"], [0, 1, 2, 3]);
    assert_eq!(
        square
            .mesh
            .cells
            .iter()
            .map(|block| block.cell_count())
            .collect::<Vec<_>>(),
        [1, 2]
    );
    assert_eq!(square.interfaces.len(), 2);
}

/// Whatever bytes come, there is an answer or an error that names the file.
#[test]
fn damaged_files_never_panic() {
    let seeds = [
        documented("json").as_bytes().to_vec(),
        pyramid().to_string().into_bytes(),
        triangle().to_string().into_bytes(),
    ];
    let tokens: [&[u8]; 12] = [
        b"-1",
        b"1e308",
        b"4294967295",
        b"[",
        b"]",
        b"{}",
        b"null",
        b"\"\"",
        b",",
        b"\\u0000",
        b"\xff",
        b"0.5",
    ];
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("part.json");
    let mut state = 0x2545_f491_4f6c_dd1d_u64;
    let mut random = |below: usize| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state % below as u64) as usize
    };
    let mut accepted = 0;
    for round in 0..6000 {
        let mut bytes = seeds[round % seeds.len()].clone();
        for _ in 0..=random(3) {
            let at = random(bytes.len());
            match random(4) {
                0 => bytes[at] ^= 1 << random(8),
                1 => drop(bytes.drain(at..(at + 1 + random(6)).min(bytes.len()))),
                2 => drop(bytes.splice(at..at, tokens[random(tokens.len())].iter().copied())),
                _ if random(8) == 0 => bytes.truncate(at + 1),
                _ => bytes[at] = b"0123456789,:[]{}\"uxyz"[random(21)],
            }
            if bytes.is_empty() {
                break;
            }
        }
        std::fs::write(&path, &bytes).unwrap();
        match read_description(&path) {
            Ok(part) => {
                accepted += 1;
                let _ = part.dof_map(15, &path);
            }
            Err(error) => assert!(error.to_string().contains("part.json")),
        }
    }
    assert!(
        accepted > 100,
        "the damage is too coarse to reach the checks: {accepted} of 6000 files read"
    );
}

#[test]
fn a_hundred_thousand_nodes_are_read() {
    const NODES: usize = 100_000;
    let mut text = String::from("{\"points\": [[0.0, 0.0, 0.0]");
    for node in 1..NODES {
        write!(
            text,
            ", [{}, {}, {}]",
            node as f64 * 1e-3,
            (node % 317) as f64 / 7.0,
            0.25
        )
        .unwrap();
    }
    text += "], \"cells\": [{\"type\": \"tetra\", \"data\": [[0, 1, 2, 3]";
    for cell in 1..NODES - 3 {
        write!(
            text,
            ", [{}, {}, {}, {}]",
            cell,
            cell + 1,
            cell + 2,
            cell + 3
        )
        .unwrap();
    }
    write!(
        text,
        "]}}], \"component\": {}}}",
        without(pyramid(), "/component", "interfaces")["component"]
    )
    .unwrap();
    let part = read_bytes(text.as_bytes()).unwrap();
    assert_eq!(part.mesh.node_count(), NODES);
    assert_eq!(part.mesh.cells[0].cell_count(), NODES - 3);
    assert_eq!(part.mesh.position(317), [317.0 * 1e-3, 0.0, 0.25]);
    assert_eq!(
        part.dof_map(3 * NODES, Path::new("part.json"))
            .unwrap()
            .row(NODES as u32 - 1, Direction::Uz),
        Some(3 * NODES - 1)
    );
}
