//! MATLAB files of version 5. `bracket_*`, `variants_structure*` and `variants_labelled` were written by SciPy; `variants_by_hand_*` have what
//! SciPy doesn't write but reads.

use dcb_formats::mesh::Direction;
use dcb_import::matrix::matlab::version5::{list, read, recognises};
use dcb_import::matrix::tables::read_table;
use dcb_import::stored::{RowLabel, Rows};

use crate::damage;
use crate::support::{
    Format, assert_same, expected, is_compressed, rounded, sample, stored, without_zeros,
};

const MATLAB: Format = Format {
    list,
    read,
    recognises,
};

#[test]
fn the_bracket_is_that_of_matrix_market() {
    for name in ["matlab/bracket_v5.mat", "matlab/bracket_v5_compressed.mat"] {
        let found = MATLAB.all(name);
        let names: Vec<&str> = found.iter().map(|matrix| matrix.name.as_str()).collect();
        assert_eq!(names, ["K", "M"]);
        assert_same(name, &found[0], &expected("bracket.mtx"));
        assert_same(name, &found[1], &expected("bracket.mass.mtx"));
        assert!(found.iter().all(is_compressed), "{name}");
    }
}

/// The stiffness was stored with 24 bits.
#[test]
fn dense_matrices_have_the_entries_that_are_not_zero() {
    let found = MATLAB.all("matlab/bracket_v5_dense_single.mat");
    let right = without_zeros(expected("bracket.mtx"));
    let stiffness = stored(&found[0]);
    assert_eq!((found[0].digits, found[1].digits), (Some(7), None));
    let single = |bits: &u64| f64::from(f64::from_bits(*bits) as f32);
    for (place, bits) in &right {
        let found = stiffness.get(place).map(|bits| f64::from_bits(*bits));
        assert_eq!(found, Some(single(bits)), "{place:?}");
    }
    assert_eq!(stiffness.len(), right.len());
    let mass = stored(&found[1]);
    assert_eq!(mass, without_zeros(expected("bracket.mass.mtx")));
}

#[test]
fn structures_are_followed_and_all_else_is_passed_over() {
    for name in [
        "matlab/variants_structure.mat",
        "matlab/variants_structure_compressed.mat",
    ] {
        let listed: Vec<_> = list(&sample(name)).unwrap();
        let listed = listed.iter().map(|found| {
            (
                found.name.as_str(),
                found.shape,
                found.obstacle.as_deref().unwrap_or_default(),
            )
        });
        let expected_list = [
            ("s/K", Some((12, 12)), ""),
            ("s/inner/M", Some((12, 12)), ""),
            ("s/empty", Some((0, 0)), ""),
            ("z", Some((3, 3)), "complex"),
            ("flags", Some((2, 2)), "logical"),
            ("nodes", Some((4, 3)), "rectangular, 4 x 3"),
            ("cube", None, "3 dimensions"),
            ("K1", Some((12, 12)), ""),
            ("dofs", Some((12, 2)), "rectangular, 12 x 2"),
        ];
        assert_eq!(listed.collect::<Vec<_>>(), expected_list, "{name}");
        let found = MATLAB.all(name);
        assert_same(name, &found[0], &expected("variants.mtx"));
        assert_same(name, &found[1], &expected("variants.mass.mtx"));
        assert_same(name, &found[3], &expected("variants.mtx"));
        let one = read(&sample(name), &[7, 0]).unwrap().matrices;
        assert_eq!((one[0].name.as_str(), one[1].name.as_str()), ("K1", "s/K"));
        let message = read(&sample(name), &[3]).unwrap_err().to_string();
        assert!(
            message.contains("z: complex; stiffness and mass are real"),
            "{message}"
        );
    }
}

#[test]
fn a_table_labels_the_rows() {
    let found = MATLAB.all("matlab/variants_labelled.mat");
    assert_eq!(found.len(), 2);
    for matrix in found {
        let Rows::Labelled(rows) = &matrix.rows else {
            panic!("{:?}", matrix.rows);
        };
        let fifth = RowLabel::Nodal {
            node: 13,
            direction: Direction::Uy,
        };
        assert_eq!((rows.len(), rows[4]), (12, fifth));
    }
}

#[test]
fn tables_of_dofs_are_read_by_name() {
    let labelled = sample("matlab/variants_labelled.mat");
    let (table, digest) = read_table(&labelled, None).unwrap();
    assert_eq!((table.columns, table.row_count()), (2, 12));
    assert_eq!(table.values[..6], [3, 0, 3, 1, 3, 2]);
    assert_eq!(digest, read(&labelled, &[0]).unwrap().sha256);
    // Stored as reals, in a file with more.
    let (same, _) = read_table(&sample("matlab/variants_structure.mat"), Some("DOFS")).unwrap();
    assert_eq!(same, table);
    let refused = |file: &str, name| read_table(&sample(file), name).unwrap_err().to_string();
    let message = refused("matlab/variants_structure.mat", None);
    assert!(
        message.ends_with("has no array \"dof_ref\"; name the table of dofs, as in `FILE#NAME`"),
        "{message}"
    );
    let message = refused("matlab/variants_structure.mat", Some("nodes"));
    assert!(
        message.ends_with("nodes: 3 columns; a table of dofs has one or two"),
        "{message}"
    );
    let message = refused("petsc/bracket_K.petsc", None);
    assert!(
        message.ends_with("holds no table of dofs; expected .npz, .npy or .mat"),
        "{message}"
    );
}

#[test]
fn both_byte_orders_and_every_type_of_number() {
    for name in [
        "matlab/variants_by_hand_little.mat",
        "matlab/variants_by_hand_big.mat",
    ] {
        let found = MATLAB.all(name);
        assert_eq!(found.len(), 14);
        for matrix in &found {
            let right = match matrix.name.as_str() {
                "K" => expected("variants.mtx"),
                "M" => expected("variants.mass.mtx"),
                "one" => [((0, 0), 3.0_f64.to_bits())].into(),
                unsigned if unsigned.starts_with("d_u") => rounded(f64::abs),
                _ => rounded(|value| value),
            };
            assert_same(&format!("{name} {}", matrix.name), matrix, &right);
        }
    }
}

#[test]
fn version_4_is_refused_with_its_remedy() {
    assert_eq!(
        MATLAB.refusal("matlab/bracket_v4.mat"),
        "is a MATLAB file of version 4, which is not read; save it again with `-v7` (in SciPy: savemat with format=\"5\")"
    );
}

#[test]
fn counts_that_the_file_cannot_hold_are_refused() {
    let name = "matlab/bracket_v5.mat";
    // The length of the matrix, its rows, the length of its row numbers.
    for (at, message) in [
        (132, "bytes of an element of 1 bytes are announced"),
        (
            160,
            "K: rectangular, 240000000 x 240; stiffness and mass are real and square",
        ),
        (180, "an element is longer than the one that it is in"),
    ] {
        let told = damage::replaced(MATLAB, name, at, &240_000_000_i32.to_le_bytes());
        assert!(told.contains(message), "{at}: {told}");
    }
    let both = [240_000_000_i32.to_le_bytes(); 2].concat();
    let told = damage::replaced(MATLAB, name, 160, &both);
    assert!(
        told.contains("K: 241 starts of columns; a matrix with 240000000 columns has 240000001"),
        "{told}"
    );
    let told = damage::replaced(MATLAB, name, 184, &240_i32.to_le_bytes());
    assert!(
        told.contains("K: entry 1 in column 1 has the 0-based row 240"),
        "{told}"
    );
}

#[test]
fn damaged_files_are_refused_soon() {
    damage::cut_off(MATLAB, "matlab/variants_structure_compressed.mat");
    damage::cut_off(MATLAB, "matlab/variants_by_hand_big.mat");
    damage::cut_off(MATLAB, "matlab/bracket_v5_compressed.mat");
    for name in [
        "matlab/variants_structure.mat",
        "matlab/variants_structure_compressed.mat",
        "matlab/variants_by_hand_big.mat",
        "matlab/variants_labelled.mat",
    ] {
        damage::flipped(MATLAB, name, 1000);
    }
}

#[test]
fn damage_inside_is_found_by_the_checksums() {
    damage::checked(MATLAB, "matlab/bracket_v5_compressed.mat");
    damage::checked(MATLAB, "matlab/variants_structure_compressed.mat");
}
