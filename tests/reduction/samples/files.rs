//! Units, written files and stored data.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use super::*;
use dcb_samples::catalogue::{CATALOGUE, find};
use dcb_samples::{RodSection, SpatialBeam, UnitScale, in_units, planar_rod, spatial_beam, write};
use serde_json::Value;

/// `(rows, columns, entries)` of a Matrix Market file, 0-based, as stored.
fn read_matrix(path: &Path) -> (usize, usize, Vec<(usize, usize, f64)>) {
    let text = std::fs::read_to_string(path).unwrap();
    let mut lines = text.lines().filter(|line| !line.starts_with('%'));
    let number = |word: &str| word.parse::<usize>().unwrap();
    let size: Vec<usize> = lines
        .next()
        .unwrap()
        .split_whitespace()
        .map(number)
        .collect();
    let entries: Vec<_> = lines
        .map(|line| {
            let words: Vec<&str> = line.split_whitespace().collect();
            (
                number(words[0]) - 1,
                number(words[1]) - 1,
                words[2].parse::<f64>().unwrap(),
            )
        })
        .collect();
    assert_eq!(entries.len(), size[2]);
    (size[0], size[1], entries)
}

#[test]
fn written_matrices_read_back_to_the_same_bits() {
    let folder = tempfile::tempdir().unwrap();
    let component = spatial_beam(&SpatialBeam {
        end: [0.4, 0.5, 0.6],
        ..SpatialBeam::default()
    });
    let paths = write(&component, folder.path(), "beam").unwrap();
    assert_eq!(paths.len(), 9);
    let masses = &component.component_masses.as_ref().unwrap().matrices;
    let files = [
        ("beam.mtx", &component.stiffness, true),
        ("beam.mass.mtx", &component.mass, true),
        ("beam.mass.zz.mtx", &masses[2], true),
        ("beam.mass.zx.mtx", &masses[5], false),
    ];
    for (file, matrix, lower) in files {
        let (rows, columns, entries) = read_matrix(&folder.path().join(file));
        assert_eq!((rows, columns), (matrix.nrows(), matrix.ncols()));
        let mut read = faer::Mat::zeros(rows, columns);
        for (row, column, value) in entries {
            assert!(!lower || row >= column);
            read[(row, column)] = value;
            if lower {
                read[(column, row)] = value;
            }
        }
        assert_eq!(read, dense(matrix), "{file}");
    }
    assert!(std::fs::read_dir(folder.path()).unwrap().all(|entry| {
        !entry
            .unwrap()
            .file_name()
            .to_string_lossy()
            .ends_with(".partial")
    }));
}

#[test]
fn written_json_describes_the_component() {
    let folder = tempfile::tempdir().unwrap();
    for (name, table) in [("grounded-block", true), ("connecting-rod", false)] {
        let component = find(name).unwrap().make(Some(0));
        write(&component, folder.path(), name).unwrap();
        let text = std::fs::read_to_string(folder.path().join(format!("{name}.json"))).unwrap();
        let json: Value = serde_json::from_str(&text).unwrap();
        assert_eq!(
            json["points"].as_array().unwrap().len(),
            component.mesh.node_count()
        );
        let last = numbers(&json["points"][component.mesh.node_count() - 1]);
        assert_eq!(
            last,
            component
                .mesh
                .position(component.mesh.node_count() as u32 - 1)
        );
        assert_eq!(json["cells"][0]["type"], component.mesh.cells[0].cell_type);
        let dofs = json["component"]["dofs"].as_array().unwrap();
        assert_eq!(dofs.len(), if table { component.dofs.len() } else { 3 });
        let interfaces = json["component"]["interfaces"].as_array().unwrap();
        assert_eq!(interfaces.len(), component.interfaces.len());
        for (written, interface) in interfaces.iter().zip(&component.interfaces) {
            assert_eq!(written["name"], interface.name);
            let nodes = numbers(&json["point_sets"][written["point_set"].as_str().unwrap()]);
            assert_eq!(
                nodes,
                interface
                    .nodes
                    .iter()
                    .map(|&node| f64::from(node))
                    .collect::<Vec<_>>()
            );
        }
    }
}

#[test]
fn the_same_part_in_millimetres_has_the_same_frequencies() {
    for component in [
        planar_rod(
            4,
            &RodSection {
                angle: 0.3,
                ..RodSection::default()
            },
        ),
        spatial_beam(&SpatialBeam {
            elements: 3,
            ..SpatialBeam::default()
        }),
        find("reference-hexahedra").unwrap().make(None),
    ] {
        let scaled = in_units(&component, &UnitScale::mm_t_s());
        for (a, b) in elastic_omegas(&scaled)
            .iter()
            .zip(elastic_omegas(&component))
        {
            assert!(
                relative(*a, b) < 1e-8,
                "{}: {a} against {b}",
                component.name
            );
        }
        assert!(rigid_defect(&scaled) < 1e-13);
        assert!(exactly_symmetric(&scaled.stiffness) && exactly_symmetric(&scaled.mass));
        let (tonnes, kilograms) = (rigid_motions(&scaled), rigid_motions(&component));
        let in_tonnes = form(&scaled.mass, &tonnes[0], &tonnes[0]);
        assert!(
            relative(
                in_tonnes * 1e3,
                form(&component.mass, &kilograms[0], &kilograms[0])
            ) < 1e-13
        );
        if let Some(masses) = &scaled.component_masses {
            // The inertia about the origin in t mm² is 1000 times that in kg m².
            let spin = tonnes.last().unwrap();
            let sum: f64 = masses.matrices[..component.dimension().coordinate_count()]
                .iter()
                .map(|mass| form(mass, spin, spin))
                .sum();
            let metric = kilograms.last().unwrap();
            assert!(relative(sum, 1e3 * form(&component.mass, metric, metric)) < 1e-12);
        }
    }
}

fn data(folder: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../samples/data")
        .join(folder)
}

#[test]
fn stored_rod_is_what_the_program_writes() {
    let folder = tempfile::tempdir().unwrap();
    let written = write(&find("rod").unwrap().make(None), folder.path(), "rod").unwrap();
    assert_eq!(
        written.len(),
        std::fs::read_dir(data("rod")).unwrap().count()
    );
    for path in written {
        let stored = data("rod").join(path.file_name().unwrap());
        assert_eq!(
            std::fs::read(&path).unwrap(),
            std::fs::read(&stored).unwrap(),
            "{}",
            stored.display()
        );
    }
}

#[test]
fn stored_rotor_fits_its_mesh_and_the_reference() {
    let json: Value =
        serde_json::from_str(&std::fs::read_to_string(data("rotor").join("rotor.json")).unwrap())
            .unwrap();
    let points: Vec<Vec<f64>> = json["points"]
        .as_array()
        .unwrap()
        .iter()
        .map(numbers)
        .collect();
    let full = |file: &str| {
        let (rows, columns, entries) = read_matrix(&data("rotor").join(file));
        let mut matrix = faer::Mat::zeros(rows, columns);
        for (row, column, value) in entries {
            matrix[(row, column)] = value;
            matrix[(column, row)] = value;
        }
        matrix
    };
    let (k, m) = (full("rotor.mtx"), full("rotor.mass.mtx"));
    assert_eq!(k.ncols(), 3 * points.len());
    let spin = faer::Mat::from_fn(k.ncols(), 1, |row, _| match row % 3 {
        0 => 0.0,
        1 => -points[row / 3][2],
        _ => points[row / 3][1],
    });
    let defect = (&k * &spin).norm_max() / k.norm_max();
    assert!(defect < 1e-10, "K turned about x: {defect:e}");
    let reference = reference("reference.json");
    let values = reference
        .as_array()
        .unwrap()
        .iter()
        .find(|case| case["name"].as_str().unwrap().starts_with("rotorAnsys"));
    let frequencies = numbers(&values.unwrap()["freq_first10_elastic"]);
    let computed = omega_squared(&k, &m).split_off(6);
    for (squared, hertz) in computed.iter().zip(frequencies) {
        assert!(relative(squared.sqrt() / std::f64::consts::TAU, hertz) < 1e-8);
    }
    for set in ["bearing_left", "bearing_right"] {
        assert_eq!(json["point_sets"][set].as_array().unwrap().len(), 9);
    }
}

/// Least determinant of the map from the cube [-1, 1]³ at its Gauss points, and the volume.
fn hexahedron(corners: &[[f64; 3]; 8]) -> (f64, f64) {
    let signs = [
        [-1., -1., -1.],
        [1., -1., -1.],
        [1., 1., -1.],
        [-1., 1., -1.],
        [-1., -1., 1.],
        [1., -1., 1.],
        [1., 1., 1.],
        [-1., 1., 1.],
    ];
    let (mut least, mut volume) = (f64::INFINITY, 0.0);
    for at in signs.map(|sign: [f64; 3]| sign.map(|s| s / 3f64.sqrt())) {
        let mut map = nalgebra::Matrix3::<f64>::zeros();
        for (corner, sign) in corners.iter().zip(signs) {
            for local in 0..3 {
                let slope: f64 = (0..3)
                    .filter(|other| *other != local)
                    .map(|other| 1.0 + sign[other] * at[other])
                    .product();
                for axis in 0..3 {
                    map[(axis, local)] += 0.125 * sign[local] * slope * corner[axis];
                }
            }
        }
        least = least.min(map.determinant());
        volume += map.determinant();
    }
    (least, volume)
}

#[test]
fn stored_rotor_cells_are_those_of_its_matrices() {
    let path = data("rotor").join("rotor.json");
    let mesh = dcb_formats::read_description(&path).unwrap().mesh;
    let (rows, _, mass) = read_matrix(&data("rotor").join("rotor.mass.mtx"));
    let (mut volume, mut joined) = (0.0, BTreeSet::new());
    for cell in mesh.cells[0].cells() {
        let corners = std::array::from_fn(|at| mesh.position(cell[at]));
        let (least, of_cell) = hexahedron(&corners);
        assert!(least > 0.0, "cell {cell:?} is inside out: {least:e}");
        volume += of_cell;
        for &a in cell {
            joined.extend(cell.iter().map(|&b| (a.max(b) as usize, a.min(b) as usize)));
        }
    }
    let along_x: f64 = mass
        .iter()
        .filter(|(row, column, _)| row == column && row % 3 == 0)
        .map(|(_, _, value)| value)
        .sum();
    assert_eq!(rows, 3 * mesh.node_count());
    assert!(relative(7850.0 * volume, along_x) < 1e-9);
    let (_, _, stiffness) = read_matrix(&data("rotor").join("rotor.mtx"));
    let coupled: BTreeSet<_> = stiffness
        .iter()
        .map(|(row, column, _)| (row / 3, column / 3))
        .collect();
    assert_eq!(joined, coupled);
}

#[test]
fn every_sample_is_complete() {
    for sample in CATALOGUE {
        let component = sample.make(if sample.name == "connecting-rod" {
            Some(0)
        } else {
            None
        });
        assert_eq!(
            component.dofs.len(),
            component.stiffness.ncols(),
            "{}",
            sample.name
        );
        assert_eq!(
            component.dofs.len(),
            component.mass.ncols(),
            "{}",
            sample.name
        );
        assert!(
            exactly_symmetric(&component.stiffness) && exactly_symmetric(&component.mass),
            "{}",
            sample.name
        );
        assert!(!component.interfaces.is_empty(), "{}", sample.name);
        for interface in &component.interfaces {
            assert!(
                !interface.nodes.is_empty(),
                "{}: {}",
                sample.name,
                interface.name
            );
        }
    }
}
