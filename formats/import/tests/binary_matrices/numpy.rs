//! Archives and arrays that NumPy and SciPy saved.

use dcb_formats::mesh::Direction;
use dcb_import::matrix::numpy::{list, read, recognises};
use dcb_import::matrix::tables::read_table;
use dcb_import::stored::{Content, RowLabel, Rows};

use crate::damage;
use crate::support::{
    Format, assert_same, expected, is_compressed, rounded, sample, stored, stored_anew,
    without_zeros,
};

const NUMPY: Format = Format {
    list,
    read,
    recognises,
};

#[test]
fn the_bracket_is_that_of_matrix_market() {
    for (name, right, compressed) in [
        ("scipy/bracket_K_csr.npz", "bracket.mtx", true),
        ("scipy/bracket_K_csc_stored.npz", "bracket.mtx", true),
        ("scipy/bracket_K_coo.npz", "bracket.mtx", false),
        ("scipy/bracket_K_bsr.npz", "bracket.mtx", false),
        ("scipy/bracket_M_csr.npz", "bracket.mass.mtx", true),
        ("scipy/bracket_M_array.npz", "bracket.mass.mtx", true),
    ] {
        let found = NUMPY.all(name);
        assert_eq!((found.len(), found[0].name.as_str()), (1, ""), "{name}");
        assert_same(name, &found[0], &expected(right));
        assert_eq!(is_compressed(&found[0]), compressed, "{name}");
        assert_eq!(found[0].rows, Rows::Unlabelled);
    }
}

#[test]
fn dense_matrices_have_the_entries_that_are_not_zero() {
    let found = NUMPY.all("scipy/bracket_dense.npz");
    for (matrix, (name, right)) in found
        .iter()
        .zip([("K", "bracket.mtx"), ("M", "bracket.mass.mtx")])
    {
        assert_eq!(matrix.name, name);
        assert_same(name, matrix, &without_zeros(expected(right)));
    }
}

#[test]
fn a_lumped_mass_has_the_sums_of_the_rows() {
    let found = NUMPY.all("scipy/bracket_M_dia.npz");
    let places = stored(&found[0]);
    let mut sums = vec![0.0; 240];
    for ((row, _), bits) in expected("bracket.mass.mtx") {
        sums[row as usize] += f64::from_bits(bits);
    }
    assert_eq!(places.len(), 240);
    for ((row, column), bits) in places {
        assert_eq!(row, column);
        let sum = sums[row as usize];
        assert!(
            (f64::from_bits(bits) - sum).abs() <= 1e-15 * sum.abs(),
            "{row}"
        );
    }
}

#[test]
fn every_variant_gives_the_same_matrix() {
    for (name, compressed) in [
        ("scipy/variants_csr_unsorted.npz", false),
        ("scipy/variants_bsr.npz", false),
        ("scipy/variants_dia.npz", false),
        ("scipy/variants.npy", false),
        ("scipy/variants_streamed.npz", false),
        ("scipy/variants_without_shape.npz", true),
        ("scipy/variants_by_hand.npz", true),
    ] {
        let found = NUMPY.all(name);
        assert_same(name, &found[0], &expected("variants.mtx"));
        assert_eq!(is_compressed(&found[0]), compressed, "{name}");
    }
}

#[test]
fn repeated_places_and_zeros_stay_as_they_are() {
    let found = NUMPY.all("scipy/variants_coo_twice.npz");
    let Content::Entries(blocks) = &found[0].content else {
        panic!("{:?}", found[0].content);
    };
    let entries: Vec<_> = blocks.iter().flat_map(|block| block.iter()).collect();
    assert_eq!(entries.len(), 101);
    let last = entries[100];
    assert_eq!((last.row, last.column, last.value), (0, 11, 0.0));
    let twice = |bits: u64| (2.0 * f64::from_bits(bits)).to_bits();
    let halves = stored_anew(&found[0])
        .into_iter()
        .map(|(place, bits)| (place, twice(bits)));
    assert_eq!(without_zeros(halves.collect()), expected("variants.mtx"));
}

#[test]
fn one_triangle_stays_one() {
    let found = NUMPY.all("scipy/variants_upper.npz");
    let mut upper = expected("variants.mtx");
    upper.retain(|(row, column), _| row <= column);
    assert_eq!(stored(&found[0]), upper);
}

#[test]
fn pieces_under_names_make_matrices_and_a_table_labels_their_rows() {
    let name = "scipy/variants_by_hand.npz";
    let listed = list(&sample(name)).unwrap();
    let listed: Vec<_> = listed
        .iter()
        .map(|found| (found.name.as_str(), found.obstacle.as_deref()))
        .collect();
    assert_eq!(
        listed,
        [
            ("K", None),
            ("M", None),
            ("nodes", Some("rectangular, 4 x 3"))
        ]
    );
    let found = NUMPY.all(name);
    assert_same(name, &found[1], &expected("variants.mass.mtx"));
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
fn every_type_of_number_in_both_orders() {
    let name = "scipy/variants_types.npz";
    let found = NUMPY.all(name);
    assert_eq!(found.len(), 21);
    for matrix in &found {
        let right = match matrix.name.as_str() {
            "flags" => (0..3).map(|i| ((i, i), 1.0_f64.to_bits())).collect(),
            unsigned if unsigned.contains('u') => rounded(f64::abs),
            _ => rounded(|value| value),
        };
        assert_same(&format!("{name} {}", matrix.name), matrix, &right);
    }
    let listed = list(&sample(name)).unwrap();
    let obstacles: Vec<_> = listed
        .iter()
        .filter_map(|found| found.obstacle.as_deref())
        .collect();
    assert_eq!(obstacles, ["complex", "of the type f2; save float64"]);
}

#[test]
fn tables_of_dofs_are_read_with_and_without_a_name() {
    let (table, _) = read_table(&sample("scipy/variants_by_hand.npz"), None).unwrap();
    assert_eq!((table.columns, table.row_count()), (2, 12));
    assert_eq!(table.values[..6], [3, 0, 3, 1, 3, 2]);
    let (same, _) = read_table(&sample("scipy/variants_by_hand.npz"), Some("DOF_Ref")).unwrap();
    let (alone, _) = read_table(&sample("scipy/variants_dof_ref.npy"), None).unwrap();
    assert_eq!((&same, &alone), (&table, &table));
    let (column, _) = read_table(&sample("scipy/variants_types.npz"), Some("line")).unwrap();
    assert_eq!((column.columns, column.values), (1, vec![0, 1, 2]));
    let refused = |name| {
        let error = read_table(&sample("scipy/variants_by_hand.npz"), Some(name));
        error.unwrap_err().to_string()
    };
    assert!(refused("nodes").ends_with("nodes: 3 columns; a table of dofs has one or two"));
    assert!(refused("names").ends_with("names: has no integers; a table of dofs has"));
    assert!(refused("K").contains("has no array \"K\""));
}

#[test]
fn what_cannot_be_read_is_refused_with_a_remedy() {
    for (name, message) in [
        (
            "scipy/pickled.npz",
            "K: is a pickled Python object, which is never read; np.savez pickles SciPy matrices; save each with \
             `scipy.sparse.save_npz(\"K.npz\", K)` and a table of dofs with `np.save(\"dof_ref.npy\", dof_ref)`",
        ),
        (
            "scipy/pickled_ansys.npz",
            "K: is a pickled Python object, which is never read; np.savez pickles SciPy matrices; save each with \
             `scipy.sparse.save_npz(\"K.npz\", K)` and a table of dofs with `np.save(\"dof_ref.npy\", dof_ref)`",
        ),
        (
            "scipy/refused_names.npz",
            "names: is a pickled Python object, which is never read; leave it out, or give its elements a type of their own, as \
             `.astype(str)` does for names",
        ),
        (
            "scipy/refused_large.npz",
            "data: number 1 of the array: the integer 9007199254740992 is 2^53 or beyond, where real numbers have gaps; save reals \
             (float64)",
        ),
        (
            "scipy/refused_bzip2.npz",
            "K: is compressed with Bzip2; NumPy writes deflate (np.savez_compressed) or nothing (np.savez)",
        ),
        (
            "scipy/refused_twice.npz",
            "has members of the same name or the same bytes; the archive is damaged",
        ),
        (
            "scipy/refused_encrypted.npz",
            "K: is encrypted; save it without a password",
        ),
    ] {
        assert_eq!(NUMPY.refusal(name), message, "{name}");
    }
}

/// The places of sizes in an archive that isn't compressed.
#[test]
fn counts_that_the_file_cannot_hold_are_refused() {
    let name = "scipy/bracket_K_csc_stored.npz";
    let bytes = std::fs::read(sample(name)).unwrap();
    let find = |text: &[u8]| {
        bytes
            .windows(text.len())
            .position(|window| window == text)
            .unwrap()
    };
    let shape = find(b"(18716,)");
    let message = damage::replaced(NUMPY, name, shape, b"(9000000000000000000,)}");
    assert!(
        message.contains("of shape [9000000000000000000] doesn't fit its 74992 bytes"),
        "{message}"
    );
    // Changed data don't have their checksum.
    let first = shape - shape % 64 + 64;
    let first = (first..).find(|at| bytes[at - 1] == b'\n').unwrap();
    let message = damage::replaced(NUMPY, name, first, &240_i32.to_le_bytes());
    assert_eq!(
        message,
        "indices: can't be decompressed: Invalid checksum; the archive is damaged"
    );
    let directory = find(b"PK\x01\x02");
    let message = damage::replaced(NUMPY, name, directory + 24, &0x7000_0000_u32.to_le_bytes());
    assert!(
        message.contains("should have 1879048192 bytes, which 74992 in the archive can't hold"),
        "{message}"
    );
}

#[test]
fn damaged_files_are_refused_soon() {
    for name in [
        "scipy/bracket_M_csr.npz",
        "scipy/variants_by_hand.npz",
        "scipy/variants_coo_twice.npz",
        "scipy/variants.npy",
    ] {
        damage::cut_off(NUMPY, name);
    }
    for name in [
        "scipy/variants_by_hand.npz",
        "scipy/variants_coo_twice.npz",
        "scipy/variants_csr_unsorted.npz",
        "scipy/variants_bsr.npz",
        "scipy/variants_dia.npz",
        "scipy/variants.npy",
    ] {
        damage::flipped(NUMPY, name, 500);
    }
}

#[test]
fn damage_inside_is_found_by_the_checksums() {
    damage::checked(NUMPY, "scipy/bracket_K_csr.npz");
    damage::checked(NUMPY, "scipy/bracket_K_csc_stored.npz");
}
