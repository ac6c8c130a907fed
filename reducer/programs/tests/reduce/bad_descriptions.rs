//! Component files with mistakes in them.

use serde_json::json;

use crate::support::Folder;

/// The rotor with its description changed is refused, with this said about it.
fn refused(change: impl FnOnce(&mut serde_json::Value), says: &[&str]) {
    let folder = Folder::rotor();
    folder.edit("rotor.json", change);
    let message = folder.refused("rotor.mtx", says);
    assert!(message.starts_with("error: rotor.json"), "{message}");
}

#[test]
fn dofs_that_do_not_match_the_matrix_are_counted() {
    refused(
        |json| json["component"]["dofs"] = json!(["ux", "uy", "uz", "rx", "ry", "rz"]),
        &["component.dofs", "345 rows", "115 nodes x 6", "690"],
    );
    refused(
        |json| json["component"]["dofs"] = json!([[0, "ux"], [0, "uy"], [1, "uz"]]),
        &["component.dofs", "345 rows", "lists 3 dofs", "one entry"],
    );
}

#[test]
fn interfaces_name_nodes_that_exist() {
    let interface = |value: serde_json::Value| {
        move |json: &mut serde_json::Value| json["component"]["interfaces"] = json!([value])
    };
    refused(
        interface(json!({"name": "x", "kind": "nodes"})),
        &[
            "component.interfaces[0]",
            "names no node",
            "point_set",
            "nodes",
        ],
    );
    refused(
        interface(json!({"name": "x", "kind": "nodes", "nodes": []})),
        &["component.interfaces[0].nodes", "at least one"],
    );
    refused(
        interface(json!({"name": "x", "kind": "nodes", "nodes": [3, 115]})),
        &["component.interfaces[0].nodes[1]", "115", "0-based"],
    );
    refused(
        interface(json!({"name": "x", "kind": "average", "point_set": "bearing"})),
        &[
            "component.interfaces[0].point_set",
            "\"bearing\"",
            "the file has",
        ],
    );
    refused(
        |json| json["point_sets"]["bearing_left"] = json!([]),
        &["bearing_left", "empty", "at least one node"],
    );
}

#[test]
fn interfaces_can_carry_what_is_asked_of_them() {
    let interfaces = |value: serde_json::Value| {
        move |json: &mut serde_json::Value| json["component"]["interfaces"] = value
    };
    refused(
        interfaces(json!([{"name": "x", "kind": "average", "nodes": [3]}])),
        &[
            "interface \"x\"",
            "1 node(s) can't carry rx",
            "at least 3 nodes",
            "\"dofs\": [\"ux\", \"uy\", \"uz\"]",
        ],
    );
    refused(
        interfaces(json!([
            {"name": "x", "kind": "rigid", "nodes": [3, 4, 5]},
            {"name": "y", "kind": "rigid", "nodes": [5, 6, 7]}
        ])),
        &["component.interfaces[1]", "node 5", "\"x\"", "average"],
    );
    refused(
        interfaces(json!([
            {"name": "x", "kind": "nodes", "nodes": [3]},
            {"name": "x", "kind": "nodes", "nodes": [4]}
        ])),
        &["component.interfaces[1].name", "\"x\"", "must differ"],
    );
}

#[test]
fn a_misspelt_key_is_found_by_line_and_column() {
    let folder = Folder::rotor();
    let text = folder
        .read("rotor.json")
        .replacen("\"kind\"", "\"knid\"", 1);
    let at = text.find("\"knid\"").unwrap();
    let line = text[..at].lines().count();
    folder.write("rotor.json", &text);
    folder.refused(
        "rotor.mtx",
        &[
            &format!("rotor.json:{line}: column "),
            "`knid`",
            "did you mean `kind`?",
        ],
    );
}

#[test]
fn json_that_breaks_off_is_refused_by_line() {
    let folder = Folder::rotor();
    let text = folder.read("rotor.json");
    folder.write("rotor.json", &text[..text.len() - 40]);
    folder.refused("rotor.mtx", &["rotor.json:", "column", "EOF"]);
}

#[test]
fn a_mesh_alone_is_not_a_component() {
    refused(
        |json| drop(json.as_object_mut().unwrap().remove("component")),
        &["component", "is missing", "\"units\""],
    );
}

#[test]
fn a_rigid_interface_with_a_node_that_has_no_dof_is_refused() {
    let folder = Folder::rod();
    folder.edit("rod.json", |json| {
        json["points"]
            .as_array_mut()
            .unwrap()
            .push(json!([0.3, 0.1]));
        json["component"]["dofs"] = (0..5)
            .flat_map(|node| ["ux", "uy", "rz"].map(|direction| json!([node, direction])))
            .collect();
        json["component"]["interfaces"] =
            json!([{"name": "hub", "kind": "rigid", "nodes": [4, 5]}]);
    });
    folder.refused(
        "rod.mtx",
        &["interface \"hub\": node 5 has no dof", "leave it out"],
    );
}
