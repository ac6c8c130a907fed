//! PETSc binary files. `variants_two_and_a_vector` and `variants_dense` were written by PETSc 3.18 itself.

use dcb_import::matrix::petsc::{list, read, recognises};

use crate::damage;
use crate::support::{Format, assert_same, expected, is_compressed, stored, without_zeros};

const PETSC: Format = Format {
    list,
    read,
    recognises,
};

#[test]
fn the_bracket_is_that_of_matrix_market() {
    for (name, right) in [
        ("petsc/bracket_K.petsc", "bracket.mtx"),
        ("petsc/bracket_M.petsc", "bracket.mass.mtx"),
    ] {
        let found = PETSC.all(name);
        assert_eq!((found.len(), found[0].name.as_str()), (1, ""));
        assert_same(name, &found[0], &expected(right));
        assert!(is_compressed(&found[0]), "{name}");
    }
}

#[test]
fn matrices_of_a_file_have_numbers_and_vectors_are_passed_over() {
    let name = "petsc/variants_two_and_a_vector.petsc";
    let found = PETSC.all(name);
    let names: Vec<&str> = found.iter().map(|matrix| matrix.name.as_str()).collect();
    assert_eq!(names, ["1", "2"]);
    assert_same(name, &found[0], &expected("variants.mtx"));
    assert_same(name, &found[1], &expected("variants.mass.mtx"));
}

#[test]
fn every_variant_gives_the_same_matrix() {
    for (name, compressed) in [
        ("petsc/variants_dense_native.petsc", false),
        ("petsc/variants_64bit.petsc", true),
        ("petsc/variants_unsorted.petsc", false),
    ] {
        let found = PETSC.all(name);
        assert_same(name, &found[0], &expected("variants.mtx"));
        assert_eq!(is_compressed(&found[0]), compressed, "{name}");
    }
}

/// PETSc writes a dense matrix as one with an entry in every place, unless it is asked for its native format.
#[test]
fn zeros_that_are_stored_stay() {
    let found = PETSC.all("petsc/variants_dense.petsc");
    let places = stored(&found[0]);
    assert_eq!(places.len(), 144);
    assert_eq!(without_zeros(places), expected("variants.mtx"));
    assert!(is_compressed(&found[0]));
}

#[test]
fn one_triangle_stays_one() {
    let found = PETSC.all("petsc/variants_upper.petsc");
    let mut upper = expected("variants.mtx");
    upper.retain(|(row, column), _| row <= column);
    assert_eq!(stored(&found[0]), upper);
}

#[test]
fn other_widths_of_numbers_are_told_by_the_length() {
    let message = PETSC.refusal("petsc/variants_single.petsc");
    assert_eq!(
        message,
        "at byte 16: a matrix of 12 x 12 with 50 entries in real double precision doesn't fit the 448 bytes behind its header, but one with \
         values of 4 bytes does (single precision); write it from a PETSc that is configured with real double precision"
    );
    let message = PETSC.refusal("petsc/variants_complex.petsc");
    assert!(
        message.contains("16 bytes does (complex numbers)"),
        "{message}"
    );
}

#[test]
fn counts_that_the_file_cannot_hold_are_refused() {
    let name = "petsc/bracket_K.petsc";
    let replaced = |at, with: i32| damage::replaced(PETSC, name, at, &with.to_be_bytes());
    for (at, with) in [
        (4, 240_000_000),
        (8, i32::MAX),
        (12, 1_900_000_000),
        (12, -1),
    ] {
        let message = replaced(at, with);
        assert!(
            message.contains("doesn't fit the") || message.contains("square"),
            "{at}: {message}"
        );
    }
    assert!(replaced(4, -240).contains("-240 rows are announced"));
    assert!(replaced(12, -7).contains("-7 entries are announced"));
    assert!(replaced(16, 1 << 30).contains("more than"));
    assert!(replaced(16, 1).contains("together, but"));
    let message = replaced(16 + 240 * 4, 240);
    assert!(
        message.contains("entry 1 in row 1 has the 0-based column 240"),
        "{message}"
    );
    let message = replaced(16 + 240 * 4, -1);
    assert!(
        message.contains("entry 1 in row 1 has no column that can be"),
        "{message}"
    );
    let bytes = std::fs::read(crate::support::sample(name)).unwrap();
    let message = damage::replaced(PETSC, name, bytes.len() - 8, &f64::NAN.to_be_bytes());
    assert!(
        message.contains("the entry in row 240, column 240 is NaN"),
        "{message}"
    );
}

#[test]
fn damaged_files_are_refused_soon() {
    damage::cut_off(PETSC, "petsc/bracket_M.petsc");
    damage::cut_off(PETSC, "petsc/variants_two_and_a_vector.petsc");
    damage::flipped(PETSC, "petsc/variants_two_and_a_vector.petsc", 1000);
    damage::flipped(PETSC, "petsc/variants_64bit.petsc", 1000);
}
