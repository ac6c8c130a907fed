//! Rows of the matrices that belong to no node.

use std::path::Path;

use dcb_formats::component::{Component, ComponentDraft};
use dcb_formats::mesh::{Direction, Dof, DofMap, MatrixRow};
use serde_json::{Value, json};

use super::*;

/// The pyramid's dofs as a table, with two internal rows among them.
fn table() -> Vec<Value> {
    let names = ["ux", "uy", "uz"];
    let mut table: Vec<Value> = (0..15)
        .map(|row| json!([row / 3, names[row % 3]]))
        .collect();
    table.insert(4, json!([null, "internal"]));
    table.push(json!([null, "internal"]));
    table
}

#[test]
fn a_table_may_have_rows_that_belong_to_no_node() {
    let read = read(&with(pyramid(), "/component/dofs", json!(table()))).unwrap();
    let map = read.dof_map(17, Path::new("part.json")).unwrap();
    assert_eq!((map.len(), map.internal_count()), (17, 2));
    assert_eq!(map.rows()[4], MatrixRow::Internal);
    assert_eq!((map.dof(4), map.dof(16), map.dof(17)), (None, None, None));
    let uy = Dof {
        node: 1,
        direction: Direction::Uy,
    };
    assert_eq!(map.dof(5), Some(uy));
    assert_eq!(map.row(1, Direction::Uy), Some(5));
    assert_eq!(map.nodal_dofs().len(), 15);
    assert_eq!(map.nodal().nth(4), Some((5, uy)));
    assert_eq!(map.pattern(), None);
    assert_eq!(
        (map.row_name(4), map.row_name(5)),
        ("internal row 4".to_owned(), "node 1 uy".to_owned())
    );
    let message = read
        .dof_map(15, Path::new("part.json"))
        .unwrap_err()
        .to_string();
    assert_says(&message, &["15 rows", "17 dofs", "[null, \"internal\"]"]);
}

#[test]
fn entries_that_are_neither_a_nodes_nor_internal_are_refused() {
    let with_entry = |entry: Value| {
        let mut table = table();
        table[6] = entry;
        with(pyramid(), "/component/dofs", json!(table))
    };
    assert_refused(
        &with_entry(json!([null, "ux"])),
        &[
            "dofs[6]",
            "ux is a direction of a node, but the node is null",
            "[null, \"internal\"]",
        ],
    );
    assert_refused(
        &with_entry(json!([3, "internal"])),
        &[
            "dofs[6]",
            "an internal row belongs to no node, found node 3",
            "expected [null, \"internal\"]",
        ],
    );
    assert_refused(
        &with_entry(json!([null, "inner"])),
        &["dofs[6]", "unknown value `inner`", "rz, internal)"],
    );
    assert_refused(&with_entry(json!([null])), &["dofs[6]", "length 1"]);
    assert_refused(&with_entry(json!(null)), &["dofs[6]", "null"]);
    assert_refused(
        &with(
            pyramid(),
            "/component/dofs",
            json!(["ux", "uy", "uz", "internal"]),
        ),
        &[
            "dofs[3]",
            "a pattern has the directions of every node, and `internal` is none",
            "table",
        ],
    );
    assert_refused(
        &with(
            pyramid(),
            "/component/dofs",
            json!(vec![json!([null, "internal"]); 15]),
        ),
        &["component.dofs: ", "15 internal rows and no row of a node"],
    );
}

#[test]
fn a_draft_with_internal_rows_is_checked_as_a_file_is() {
    let rod = dcb_samples::planar_rod(2, &dcb_samples::RodSection::default());
    let nodes = rod.mesh.node_count();
    let with_owners = |owners: Vec<MatrixRow>| {
        rod.clone()
            .changed(|draft| draft.dofs = DofMap::new(owners, nodes).unwrap())
    };
    let mut owners = rod.dofs.rows().to_vec();
    owners[2] = MatrixRow::Internal;
    let component = with_owners(owners).unwrap();
    assert_eq!(component.dofs.internal_count(), 1);
    let none = with_owners(vec![MatrixRow::Internal; rod.dofs.len()]).unwrap_err();
    assert_says(&none.to_string(), &["no row of a node"]);

    let boundary = dcb_tests::dense::sparse(&faer::Mat::from_fn(1, rod.dofs.len(), |_, j| {
        f64::from(u8::from(j == 0 || j == 2))
    }));
    let refused = Component::checked(ComponentDraft {
        explicit_boundary: Some(boundary),
        interfaces: Vec::new(),
        ..component.into_draft()
    })
    .unwrap_err();
    assert_says(
        &refused.to_string(),
        &["row 1 has an entry in column 3", "internal row"],
    );
}

#[test]
fn the_writer_of_samples_writes_internal_rows() {
    let component = dcb_tests::parts::with_internal_rows("plate");
    let folder = tempfile::tempdir().unwrap();
    dcb_samples::write::write(&component, folder.path(), "plate").unwrap();
    let path = folder.path().join("plate.json");
    let again = dcb_formats::read_description(&path).unwrap();
    let map = again.dof_map(component.dofs.len(), &path).unwrap();
    assert_eq!(map, component.dofs);
}
