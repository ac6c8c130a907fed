//! What `docs/component.md` says is what the reader does.

use std::path::Path;

use dcb_formats::component::{Damping, InterfaceKind, Role, Weights};
use dcb_formats::description::DofLayout;
use dcb_formats::mesh::{Dimension, Direction};
use dcb_formats::{component_schema, read_description};
use dcb_tests::python;
use serde_json::{Value, json};

use super::*;

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

#[test]
fn the_documented_script_turns_a_meshio_mesh_into_a_component() {
    let script = documented("python");
    assert!(script.lines().count() <= 15);
    let folder = tempfile::tempdir().unwrap();
    let (mesh, part) = (
        folder.path().join("square.msh"),
        folder.path().join("square.json"),
    );
    std::fs::write(&mesh, GMSH_SQUARE).unwrap();
    python::run_text(script, &[mesh.as_os_str(), part.as_os_str()]).unwrap();
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
