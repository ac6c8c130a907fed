//! Nodal fields in VTK files, read back by meshio.

use crate::support;
use std::collections::BTreeMap;
use std::path::Path;

use crate::support::{Part, numbers};
use dcb_formats::component_files::{ComponentFiles, Overrides, read_component};
use dcb_formats::mesh::{CellBlock, Dimension, Mesh};
use dcb_formats::output::Replace;
use dcb_runtime::export::nodal_field::NodalField;
use dcb_runtime::export::vtu::{FieldSeries, FieldSnapshot};
use dcb_samples::{RodSection, planar_rod};
use dcb_tests::python;
use nalgebra::{Rotation3, Vector3};
use serde_json::Value;

/// Points, cells and point data as meshio reads them.
fn read_with_meshio(path: &Path) -> Value {
    const SCRIPT: &str = "
import json, sys, meshio
for forgotten in ('wedge15', 'pyramid13'):  # by meshio 5.3.5
    meshio._mesh.topological_dimension.setdefault(forgotten, 3)
mesh = meshio.read(sys.argv[1])
print(json.dumps({
    'points': mesh.points.tolist(),
    'cells': [[block.type, block.data.tolist()] for block in mesh.cells],
    'data': {name: values.tolist() for name, values in mesh.point_data.items()},
}))";
    python::answer(SCRIPT, path)
}

fn vectors(of: &Value) -> Vec<Vector3<f64>> {
    let triples: Vec<[f64; 3]> = serde_json::from_value(of.clone()).unwrap();
    triples.into_iter().map(Vector3::from).collect()
}

fn rotor() -> Part {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../samples/data/rotor/rotor.mtx");
    let files = ComponentFiles::beside(&path, &Overrides::default()).unwrap();
    Part::reduced(read_component(&files, None).unwrap(), 8)
}

#[test]
fn a_mode_of_the_rotor_comes_back_as_it_was_computed() {
    let part = rotor();
    let (mesh, basis) = (&part.component.mesh, part.basis());
    let field = NodalField::new(&part.body, &part.reduced.recovery, mesh).unwrap();
    assert!(field.recovered().iter().all(|&mark| mark == 1));
    let y = numbers(part.body.coordinate_count(), 7);
    let displacement = field.displacement(&y);
    // The same from the dense basis, dof by dof.
    let dense = support::product(&basis, &y);
    for (row, dof) in part.component.dofs.nodal_dofs().iter().enumerate() {
        if !dof.direction.is_rotation() {
            let found = displacement[dof.node as usize][dof.direction.axis()];
            assert!((found - dense[row]).abs() < 1e-12 * dense[row].abs().max(1.0));
        }
    }

    let position = Vector3::new(0.3, -1.2, 0.7);
    let axes = Rotation3::from_euler_angles(0.4, -0.9, 2.0).into_inner();
    let rigid = field.rigid_positions(&position, &axes);
    for node in 0..mesh.node_count() as u32 {
        let arm = Vector3::from(mesh.position(node)) - Vector3::from(part.body.origin);
        assert!((rigid[node as usize] - position - axes * arm).norm() < 1e-14);
    }
    let world: Vec<_> = displacement.iter().map(|u| axes * u).collect();
    let folder = tempfile::tempdir().unwrap();
    let mut series = FieldSeries::create(folder.path(), "rotor/1", mesh, Replace::Refuse).unwrap();
    let times = [0.0, 1.16e-5, 0.1];
    let paths = times.map(|time| {
        let snapshot = FieldSnapshot {
            time,
            positions_world: &rigid,
            vectors: &[("displacement", &world)],
            numbers: &[],
            marks: &[("recovered", field.recovered())],
        };
        series.write(&snapshot).unwrap()
    });
    let found = read_with_meshio(&paths[1]);
    assert_eq!(vectors(&found["points"]), rigid);
    assert_eq!(vectors(&found["data"]["displacement"]), world);
    assert_eq!(
        found["data"]["recovered"].as_array().unwrap().len(),
        mesh.node_count()
    );
    let cells: Vec<(String, Vec<Vec<u32>>)> =
        serde_json::from_value(found["cells"].clone()).unwrap();
    let expected: Vec<(String, Vec<Vec<u32>>)> = mesh
        .cells
        .iter()
        .map(|block| {
            (
                block.cell_type.clone(),
                block.cells().map(<[u32]>::to_vec).collect(),
            )
        })
        .collect();
    assert!(!expected.is_empty());
    assert_eq!(cells, expected);

    let list = std::fs::read_to_string(folder.path().join("rotor~2f~1.pvd")).unwrap();
    for (time, path) in times.iter().zip(&paths) {
        let entry = format!(
            "timestep=\"{time:?}\" file=\"{}\"",
            path.file_name().unwrap().display()
        );
        assert!(list.contains(&entry), "{list}");
    }
    assert!(list.ends_with("</Collection>\n</VTKFile>\n"), "{list}");
}

/// One cell of each type that meshio and VTK know, each with nodes of its own.
#[test]
fn every_type_of_cell_keeps_its_node_order() {
    let types = [
        ("vertex", 1),
        ("line", 2),
        ("triangle", 3),
        ("quad", 4),
        ("tetra", 4),
        ("hexahedron", 8),
        ("wedge", 6),
        ("pyramid", 5),
        ("line3", 3),
        ("triangle6", 6),
        ("quad8", 8),
        ("tetra10", 10),
        ("hexahedron20", 20),
        ("wedge15", 15),
        ("pyramid13", 13),
        ("quad9", 9),
        ("hexahedron27", 27),
    ];
    let mut next = 0;
    let cells = types.map(|(name, count)| {
        next += count as u32;
        CellBlock {
            cell_type: name.to_owned(),
            nodes_per_cell: count,
            nodes: (next - count as u32..next).collect(),
        }
    });
    let mesh = Mesh {
        dimension: Dimension::Spatial,
        coordinates: numbers(3 * next as usize, 3),
        cells: cells.to_vec(),
        point_sets: BTreeMap::new(),
    };
    let points: Vec<_> = (0..next)
        .map(|node| Vector3::from(mesh.position(node)))
        .collect();
    let folder = tempfile::tempdir().unwrap();
    let mut series = FieldSeries::create(folder.path(), "cells", &mesh, Replace::Refuse).unwrap();
    let snapshot = FieldSnapshot {
        time: 0.0,
        positions_world: &points,
        vectors: &[],
        numbers: &[],
        marks: &[],
    };
    let path = series.write(&snapshot).unwrap();
    let found = read_with_meshio(&path);
    assert_eq!(vectors(&found["points"]), points);
    let found: Vec<(String, Vec<Vec<u32>>)> =
        serde_json::from_value(found["cells"].clone()).unwrap();
    let expected: Vec<(String, Vec<Vec<u32>>)> = cells
        .iter()
        .map(|block| (block.cell_type.clone(), vec![block.nodes.clone()]))
        .collect();
    assert_eq!(found, expected);

    let mut misspelt = mesh.clone();
    misspelt.cells[3].cell_type = "quads".to_owned();
    let refused = FieldSeries::create(folder.path(), "cells", &misspelt, Replace::Overwrite)
        .unwrap_err()
        .to_string();
    assert!(
        refused.contains("`quads`") && refused.contains("did you mean `quad`?"),
        "{refused}"
    );
    let few = FieldSnapshot {
        positions_world: &points[1..],
        ..snapshot
    };
    assert!(
        series
            .write(&few)
            .unwrap_err()
            .to_string()
            .contains("positions")
    );
}

#[test]
fn nodes_without_fields_are_marked_and_move_with_the_frame() {
    let part = Part::reduced(planar_rod(4, &RodSection::default()), 3);
    let mesh = &part.component.mesh;
    let whole = NodalField::new(&part.body, &part.reduced.recovery, mesh).unwrap();
    let mut pruned = part.reduced.recovery.clone();
    let kept: Vec<usize> = (0..pruned.dofs.len())
        .filter(|&row| pruned.dofs[row].node != 2)
        .collect();
    let rows =
        |of: &faer::Mat<f64>| faer::Mat::from_fn(kept.len(), of.ncols(), |i, j| of[(kept[i], j)]);
    pruned.modes = rows(&pruned.modes);
    pruned.residual = rows(&pruned.residual);
    pruned.dofs = kept.iter().map(|&row| pruned.dofs[row]).collect();
    let field = NodalField::new(&part.body, &pruned, mesh).unwrap();
    assert_eq!(
        field.recovered().iter().filter(|&&mark| mark == 0).count(),
        1
    );
    assert_eq!(field.recovered()[2], 0);
    let y = numbers(part.body.coordinate_count(), 5);
    let (all, some) = (whole.displacement(&y), field.displacement(&y));
    for node in 0..mesh.node_count() {
        let expected = if node == 2 {
            Vector3::zeros()
        } else {
            all[node]
        };
        assert_eq!(some[node], expected);
    }
    let other = Part::reduced(planar_rod(4, &RodSection::default()), 2);
    let refused = NodalField::new(&other.body, &pruned, mesh)
        .unwrap_err()
        .to_string();
    assert!(refused.contains("3 modes"), "{refused}");
}

/// Nodes without cells, as a planar view of a spatial part has: ParaView shows cells only, and meshio reads no file without them.
#[test]
fn nodes_without_cells_are_written_as_vertices() {
    let mesh = Mesh {
        dimension: Dimension::Planar,
        coordinates: numbers(2 * 5, 9),
        cells: Vec::new(),
        point_sets: BTreeMap::new(),
    };
    let points: Vec<_> = (0..5)
        .map(|node| Vector3::from(mesh.position(node)))
        .collect();
    let folder = tempfile::tempdir().unwrap();
    let mut series = FieldSeries::create(folder.path(), "points", &mesh, Replace::Refuse).unwrap();
    let snapshot = FieldSnapshot {
        time: 0.0,
        positions_world: &points,
        vectors: &[("displacement", &points)],
        numbers: &[],
        marks: &[],
    };
    let found = read_with_meshio(&series.write(&snapshot).unwrap());
    assert_eq!(vectors(&found["points"]), points);
    assert_eq!(vectors(&found["data"]["displacement"]), points);
    let expected = serde_json::json!([["vertex", [[0], [1], [2], [3], [4]]]]);
    assert_eq!(found["cells"], expected);
}
