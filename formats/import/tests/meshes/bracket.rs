//! The bracket in every format is the bracket.

use std::collections::BTreeMap;

use dcb_formats::description::read_description;
use dcb_formats::mesh::Mesh;
use dcb_import::mesh::{FoundMesh, MeshFormat};

use crate::samples::{read, sample};

fn bracket() -> Mesh {
    read_description(&sample("bracket.json")).unwrap().mesh
}

/// Places in `bracket.json`, which has the nodes by rising label, of the nodes of a mesh.
fn places(mesh: &FoundMesh) -> Vec<u32> {
    let labels = mesh.labels.as_ref().unwrap();
    let mut rising = labels.clone();
    rising.sort_unstable();
    assert_eq!(rising, (0..80).map(|k| 10 * k + 3).collect::<Vec<u32>>());
    labels.iter().map(|label| (label - 3) / 10).collect()
}

/// Points within `tolerance`, the hexahedra in their order, the sets.
fn assert_is_bracket(name: &str, mesh: &FoundMesh, places: &[u32], tolerance: f64) {
    let bracket = bracket();
    assert_eq!(mesh.points.len(), 80, "{name}");
    for (node, point) in mesh.points.iter().enumerate() {
        let known = bracket.position(places[node]);
        for axis in 0..3 {
            let defect = (point[axis] - known[axis]).abs();
            assert!(
                defect <= tolerance,
                "{name}: node {node} is off by {defect:e} mm"
            );
        }
    }
    let solid = mesh
        .cells
        .iter()
        .find(|cells| cells.cell_type == "hexahedron20");
    let nodes: Vec<u32> = solid
        .unwrap()
        .nodes
        .iter()
        .map(|node| places[*node as usize])
        .collect();
    assert_eq!(nodes, bracket.cells[0].nodes, "{name}");
}

fn assert_has_sets(name: &str, mesh: &FoundMesh, places: &[u32], names: [&str; 2]) {
    let known = bracket().point_sets;
    let found: BTreeMap<&str, Vec<u32>> = (mesh.sets.iter())
        .map(|(set, nodes)| {
            let mut nodes: Vec<u32> = nodes.iter().map(|node| places[*node as usize]).collect();
            nodes.sort_unstable();
            (set.as_str(), nodes)
        })
        .collect();
    for (set, known_as) in names.into_iter().zip(["foot", "tip"]) {
        assert_eq!(found[set], known[known_as], "{name}: {set}");
    }
}

#[test]
fn every_calculix_deck_of_the_bracket_is_the_bracket() {
    for deck in [
        "bracket",
        "bracket_held",
        "bracket_substructure",
        "bracket_transform",
    ] {
        let name = format!("calculix/{deck}.inp");
        let read = read(&name);
        assert_eq!(read.format, MeshFormat::Abaqus);
        let places = places(&read.mesh);
        // Twelve digits are printed.
        assert_is_bracket(&name, &read.mesh, &places, 1e-10);
        assert_has_sets(&name, &read.mesh, &places, ["FOOT", "TIP"]);
        assert_eq!(read.mesh.sets[0].0, "NALL");
        assert_eq!(read.mesh.sets[0].1.len(), 80);
        assert_eq!(read.mesh.cell_sets.len(), 1);
        assert_eq!(read.mesh.cell_sets[0].0, "PART");
    }
}

#[test]
fn the_nastran_deck_in_three_forms_is_the_bracket() {
    let mesh = read("mesh/bracket.bdf").mesh;
    let places = places(&mesh);
    // Nine decimals are printed of numbers such as 2.5500000000000003.
    assert_is_bracket("bracket.bdf", &mesh, &places, 1e-14);
    assert_has_sets("bracket.bdf", &mesh, &places, ["set_1", "set_2"]);
}

#[test]
fn every_mesh_of_gmsh_is_the_bracket() {
    for name in ["bracket_ascii.msh", "bracket_binary.msh", "bracket_v22.msh"] {
        let mesh = read(&format!("mesh/{name}")).mesh;
        let places = match name {
            // Version 2.2 has new labels: the places in the other one's order.
            "bracket_v22.msh" => places(&read("mesh/bracket_ascii.msh").mesh),
            _ => places(&mesh),
        };
        // Sixteen digits are printed, and all of binary numbers are there.
        let tolerance = if name == "bracket_binary.msh" {
            0.0
        } else {
            1e-14
        };
        assert_is_bracket(name, &mesh, &places, tolerance);
        assert_has_sets(name, &mesh, &places, ["foot", "tip"]);
        assert_eq!(mesh.sets.len(), 2, "{name}");
        assert_eq!(mesh.cell_sets[0].0, "part");
        assert_eq!(mesh.cell_sets[0].1.len(), 80);
    }
}

#[test]
fn universal_files_of_two_programs_are_the_bracket() {
    for name in ["bracket.unv", "bracket_gmsh.unv"] {
        let mesh = read(&format!("mesh/{name}")).mesh;
        let places = places(&mesh);
        // Gmsh writes 2.55 as it is, not as the nearest double of 0.05 * 51.
        assert_is_bracket(name, &mesh, &places, 1e-14);
        assert_has_sets(name, &mesh, &places, ["foot", "tip"]);
    }
}

#[test]
fn vtu_files_of_meshio_are_the_bracket() {
    // Text has eleven decimals.
    for (name, tolerance) in [("bracket_ascii.vtu", 1e-11), ("bracket_zlib.vtu", 0.0)] {
        let mesh = read(&format!("mesh/{name}")).mesh;
        assert_is_bracket(name, &mesh, &places(&mesh), tolerance);
        assert_eq!(mesh.sets, []);
    }
}

#[test]
fn json_is_read_with_and_without_the_component() {
    let whole = std::fs::read_to_string(sample("bracket.json")).unwrap();
    let mut json: serde_json::Value = serde_json::from_str(&whole).unwrap();
    json.as_object_mut().unwrap().remove("component");
    let alone = crate::samples::read_text(json.to_string()).unwrap();
    let with_component = read("bracket.json");
    assert_eq!(with_component.format, MeshFormat::Json);
    assert_eq!(alone, with_component.mesh);
    let places: Vec<u32> = (0..80).collect();
    assert_is_bracket("bracket.json", &alone, &places, 0.0);
    assert_has_sets("bracket.json", &alone, &places, ["foot", "tip"]);
    for (text, said) in [
        (
            r#"{"points": [[0, 0], [1, 0, 0]]}"#,
            "point 1 has 3 coordinates, but point 0 has 2",
        ),
        (
            r#"{"points": [[0, 0, 0]], "point_sets": {"a": [1]}}"#,
            "point_sets.a[0]: is node 1, but the mesh has 1 nodes",
        ),
        (r#"{"points": []}"#, "points: is empty"),
        (r#"{"Points": []}"#, "unknown field `Points`"),
    ] {
        let error = crate::samples::read_text(text).unwrap_err();
        assert!(error.contains(said), "{error}");
    }
}
