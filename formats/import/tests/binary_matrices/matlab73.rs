//! MATLAB files of version 7.3 and other HDF5 files, written by h5py with the attributes that MATLAB writes.

use dcb_formats::mesh::Direction;
use dcb_import::matrix::matlab::version73::{list, read, recognises};
use dcb_import::matrix::tables::read_table;
use dcb_import::stored::{RowLabel, Rows, StoredMatrix};

use crate::damage;
use crate::support::{
    Format, assert_same, expected, is_compressed, rounded, sample, stored, without_zeros,
};

const MATLAB: Format = Format {
    list,
    read,
    recognises,
};

/// A matrix of a sample by its name.
fn named(file: &str, name: &str) -> StoredMatrix {
    let listed = list(&sample(file)).unwrap();
    let number = listed.iter().position(|found| found.name == name).unwrap();
    read(&sample(file), &[number]).unwrap().matrices.remove(0)
}

#[test]
fn the_bracket_is_that_of_matrix_market() {
    let name = "matlab/bracket_v73.mat";
    let found = MATLAB.all(name);
    let names: Vec<&str> = found.iter().map(|matrix| matrix.name.as_str()).collect();
    assert_eq!(names, ["K", "M"]);
    assert_same(name, &found[0], &expected("bracket.mtx"));
    assert_same(name, &found[1], &expected("bracket.mass.mtx"));
    assert!(found.iter().all(is_compressed));
}

#[test]
fn structures_are_followed_and_all_else_says_what_it_is() {
    let name = "matlab/variants_v73.mat";
    let listed = list(&sample(name)).unwrap();
    let listed = listed
        .iter()
        .map(|found| (found.name.as_str(), found.shape, found.obstacle.as_deref()));
    let right = [
        ("cell", Some((1, 1)), Some("of references, a cell array")),
        ("dofs", Some((12, 2)), Some("rectangular, 12 x 2")),
        ("flags", Some((12, 12)), Some("logical")),
        ("nodes", Some((4, 3)), Some("rectangular, 4 x 3")),
        ("single", Some((12, 12)), None),
        ("whole", Some((12, 12)), None),
        ("z", Some((3, 3)), Some("complex")),
        ("nothing", Some((4, 4)), None),
        ("s/M", Some((12, 12)), None),
        ("s/K", Some((12, 12)), None),
    ];
    assert_eq!(listed.collect::<Vec<_>>(), right);
    assert_same(name, &named(name, "s/K"), &expected("variants.mtx"));
    assert_same(name, &named(name, "s/M"), &expected("variants.mass.mtx"));
    assert_same(name, &named(name, "whole"), &rounded(|value| value));
    let single = |bits| f64::from(f64::from_bits(bits) as f32).to_bits();
    let right = expected("variants.mtx").into_iter();
    let right = right.map(|(place, bits)| (place, single(bits))).collect();
    assert_same(name, &named(name, "single"), &right);
    let message = read(&sample(name), &[0]).unwrap_err().to_string();
    assert!(
        message.contains("cell: is of references, a cell array"),
        "{message}"
    );
    // Four rows, and labels for twelve.
    let message = read(&sample(name), &[7]).unwrap_err().to_string();
    assert!(
        message.contains("dof_ref: has 12 rows, but the matrix \"nothing\" has 4"),
        "{message}"
    );
}

#[test]
fn a_table_labels_the_rows_and_is_read_by_name() {
    let name = "matlab/variants_v73.mat";
    let Rows::Labelled(rows) = named(name, "s/K").rows else {
        panic!("no labels");
    };
    let fifth = RowLabel::Nodal {
        node: 13,
        direction: Direction::Uy,
    };
    assert_eq!((rows.len(), rows[4]), (12, fifth));
    let (table, _) = read_table(&sample(name), None).unwrap();
    let (same, _) = read_table(&sample(name), Some("Dofs")).unwrap();
    assert_eq!(table, same);
    assert_eq!(
        (table.columns, &table.values[..6]),
        (2, &[3, 0, 3, 1, 3, 2][..])
    );
}

#[test]
fn files_of_other_programs_have_rows_first() {
    let name = "matlab/variants_big_endian.h5";
    let found = MATLAB.all(name);
    let names: Vec<&str> = found.iter().map(|matrix| matrix.name.as_str()).collect();
    assert_eq!(names, ["K", "system"]);
    assert_same(name, &found[0], &expected("variants.mtx"));
    assert_same(name, &found[1], &expected("variants.mass.mtx"));
    assert_eq!(without_zeros(stored(&found[0])).len(), 50);
}

#[test]
fn a_superelement_is_no_matrix() {
    let message = MATLAB.refusal("../../../samples/slider-crank/rod.dcb.h5");
    assert!(message.contains("is a file of this project"), "{message}");
}

#[test]
fn damaged_files_are_refused_soon() {
    damage::cut_off(MATLAB, "matlab/variants_big_endian.h5");
    damage::cut_off(MATLAB, "matlab/bracket_v73.mat");
    for name in ["matlab/variants_v73.mat", "matlab/variants_big_endian.h5"] {
        damage::flipped(MATLAB, name, 1000);
    }
}
