//! Every sample is recognised by its own reader and by no other one of the text matrices.

use std::path::Path;

use dcb_import::matrix::abaqus::{coordinate, matrix_input, substructure};
use dcb_import::matrix::harwell_boeing;

use crate::support::sample;

/// Names of the readers that recognise a file.
fn readers(path: &Path) -> Vec<&'static str> {
    let bytes = std::fs::read(path).unwrap();
    let start = &bytes[..bytes.len().min(1 << 20)];
    let told = [
        ("coordinate", coordinate::recognises(start)),
        ("harwell_boeing", harwell_boeing::recognises(start)),
        ("matrix_input", matrix_input::recognises(start)),
        ("substructure", substructure::recognises(start)),
    ];
    let told = told.into_iter().filter(|(_, is_recognised)| *is_recognised);
    told.map(|(name, _)| name).collect()
}

#[test]
fn samples_are_told_apart() {
    let own = |path: &str| match path {
        _ if path.contains("substructure") && !path.ends_with(".inp") => Some("substructure"),
        _ if path.ends_with(".sti") || path.ends_with(".mas") || path.contains("_coordinate") => {
            Some("coordinate")
        }
        _ if path.ends_with(".matrix") || path.contains("ansys/variants_") => {
            Some("harwell_boeing")
        }
        _ if path.contains("abaqus/") && path.ends_with(".mtx") => Some("matrix_input"),
        _ => None,
    };
    let mut folders = vec![sample("")];
    let mut counts = [0; 2];
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
                continue;
            }
            let name = path.to_string_lossy().into_owned();
            let expected: Vec<&str> = own(&name)
                .filter(|_| !name.contains("LICENSE"))
                .into_iter()
                .collect();
            assert_eq!(readers(&path), expected, "{name}");
            counts[expected.len()] += 1;
        }
    }
    assert!(counts[0] > 20 && counts[1] > 25, "{counts:?}");
}
