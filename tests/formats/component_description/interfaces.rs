//! Interface requests against the mesh.

use dcb_formats::mesh::Direction;
use serde_json::{Value, json};

use super::*;

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
