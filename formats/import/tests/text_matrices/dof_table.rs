//! Tables of degrees of freedom.

use dcb_formats::mesh::Direction;
use dcb_import::dof_table::{DofTable, read};
use dcb_import::stored::RowLabel;

use crate::support::sample;

fn table(text: impl AsRef<[u8]>, row_count: usize) -> Result<DofTable, String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("part");
    std::fs::write(&path, text).unwrap();
    let shown = path.display().to_string();
    read(&path, None, row_count).map_err(|error| error.to_string().replace(&shown, "part"))
}

fn pairs(table: &DofTable) -> Vec<(u32, usize)> {
    let pair = |label: &RowLabel| match label {
        RowLabel::Nodal { node, direction } => (*node, direction.index() + 1),
        RowLabel::Internal { .. } => panic!("{label:?}"),
    };
    table.rows.iter().map(pair).collect()
}

#[track_caller]
fn assert_refused(text: impl AsRef<[u8]>, row_count: usize, words: &str) {
    let message = table(text, row_count).map(|_| "read".to_owned());
    let message = message.unwrap_or_else(|message| message);
    assert!(message.contains(words), "no {words:?} in: {message}");
}

/// Labels 10 k + 3, three translations each.
fn bracket() -> Vec<(u32, usize)> {
    (0..240)
        .map(|row| (10 * (row / 3) + 3, row as usize % 3 + 1))
        .collect()
}

#[test]
fn the_tables_of_the_bracket_are_its_rows() {
    for name in [
        "calculix/bracket.dof",
        "calculix/bracket_transform.dof",
        "ansys/bracket.mapping",
    ] {
        let table = read(&sample(name), None, 240).unwrap();
        assert_eq!(pairs(&table), bracket(), "{name}");
        assert!(table.notes.is_empty() && table.sha256.len() == 64, "{name}");
    }
}

#[test]
fn tables_of_calculix_keep_what_the_mesh_must_explain() {
    let rigid = pairs(&read(&sample("calculix/bracket_rigid.dof"), None, 222).unwrap());
    assert!(rigid.ends_with(&[(9001, 3), (9002, 1), (9002, 2), (9002, 3)]));
    let incompatible = pairs(&read(&sample("calculix/plate_incompatible.dof"), None, 162).unwrap());
    assert_eq!(incompatible.len(), 162);
    let held = read(&sample("calculix/bracket_held.dof"), None, 216).unwrap();
    assert_eq!(held.rows.len(), 216);
}

#[test]
fn shells_that_come_twice_are_refused() {
    let rows = std::fs::read_to_string(sample("calculix/plate_shell.dof"))
        .unwrap()
        .lines()
        .count();
    let message = read(&sample("calculix/plate_shell.dof"), None, rows)
        .unwrap_err()
        .to_string();
    assert!(message.contains("plate_shell.dof:4: node 5 ux is in line 1 already; CalculiX has expanded shells or beams to solids"), "{message}");
}

#[test]
fn lines_of_calculix_that_cannot_be_are_refused() {
    for (text, rows, words) in [
        (
            "3.1\n3.2\n3.4\n",
            3,
            "part:3: direction 4 of node 3; expected displacements, 1 to 3",
        ),
        (
            "3.1\n3.11\n",
            2,
            "part:2: degree of freedom 11 (temperature) of node 3",
        ),
        ("3.1\n0.2\n", 2, "part:2: `0`; expected the label of a node"),
        (
            "3.1\n2147483648.2\n",
            2,
            "part:2: `2147483648`; expected the label of a node, from 1 to 2147483647",
        ),
        ("3.1\n3\n", 2, "part:2: `3`; expected `label.direction`"),
        (
            "3.1\n3.2\n3.3\n",
            2,
            "part:3: one row more than the 2 of the matrix",
        ),
        ("3.1\n3.2\n", 3, "has 2 rows, the matrix 3"),
        (
            "3.1\r3.2\r",
            2,
            "has a carriage return that no line feed follows",
        ),
    ] {
        assert_refused(text, rows, words);
    }
}

#[test]
fn the_listing_of_hbmat_is_read_in_any_language_and_order() {
    let text = "  Gleichungsnummer  Knotennummer  FHG\n\n  2   17  UY\n  1   17  UX\n\n Seite 2\n  Gleichungsnummer  Knotennummer  FHG\n  3   9 ROTZ\n";
    assert_eq!(pairs(&table(text, 3).unwrap()), [(17, 1), (17, 2), (9, 6)]);
    for (text, rows, words) in [
        (
            "1 17 UX\n2 17 TEMP\n",
            2,
            "part:2: `TEMP` is no displacement or rotation",
        ),
        (
            "1 17 UX\n1 17 UY\n",
            2,
            "part:2: equation 1, which another line has already",
        ),
        (
            "1 17 UX\n3 17 UY\n",
            2,
            "part:2: equation 3, but no line has equation 2",
        ),
        (
            "2 17 UX\n3 17 UY\n",
            2,
            "part:1: equation 2, but no line has equation 1",
        ),
        (
            "1 17 UX\n2 17 UX\n",
            2,
            "part:2: node 17 ux is in line 1 already",
        ),
        ("1 17 UX\n", 2, "has 1 rows, the matrix 2"),
        (
            "1 17 UX\n2 17 UY\n3 17 UZ\n",
            2,
            "part:3: one row more than the 2 of the matrix",
        ),
        ("1 0 UX\n", 1, "part:1: `0`; expected the label of a node"),
    ] {
        assert_refused(text, rows, words);
    }
}

#[test]
fn plain_tables_are_read_as_people_write_them() {
    let right = [(17, 1), (17, 5), (3, 3)];
    for text in [
        "17 ux\n17 ry\n3 uz\n",
        "17\tUX\r\n17\tROTY\r\n3\tUZ\r\n",
        "node,dof\n17,1\n17,5\n3,3\n",
        "\"node\";\"direction\"\n\"17\";\"T1\"\n\"17\";\"R2\"\n\"3\";\"T3\"\n",
        "# label, direction\n\n17, 1\n17, 5\n\n3, 3\n",
        "\u{feff}17 ux\n17 ry\n3 uz\n",
        "1.700000000000000000e+01 1.0e+00\n1.7e+01 5.0e+00\n3.0e+00 3.0e+00\n",
    ] {
        let table = table(text, 3).unwrap_or_else(|error| panic!("{text}: {error}"));
        assert_eq!(pairs(&table), right, "{text}");
        assert!(table.notes.is_empty());
    }
    let from_zero = table("17 0\n17 4\n3 2\n", 3).unwrap();
    assert_eq!(pairs(&from_zero), right);
    assert!(
        from_zero.notes[0]
            .starts_with("direction 0 in line 1: directions are taken as counted from 0")
    );
    for (text, rows, words) in [
        (
            "17 ux\n17 press\n",
            2,
            "part:2: `press` is no displacement or rotation",
        ),
        (
            "17 ux\nhere\n",
            2,
            "part:2: `here`; expected `label direction`",
        ),
        (
            "17 1\n17 7\n",
            2,
            "degree of freedom 7 (warping) of node 17",
        ),
        ("17 0\n17 6\n", 2, "part:2: direction 6, but 0 in line 1"),
        (
            "17 ux\n17 ux\n",
            2,
            "part:2: node 17 ux is in line 1 already",
        ),
        (
            "nothing\n",
            2,
            "has no row of a table of degrees of freedom",
        ),
        ("", 2, "has no row of a table of degrees of freedom"),
        ("3000000000 ux\n", 1, "expected the label of a node"),
    ] {
        assert_refused(text, rows, words);
    }
}

#[test]
fn the_map_of_ansys_names_the_node_of_each_block() {
    let text = "%%MatrixMarket matrix array integer general\n% comment\n2 1\n17\n3\n";
    let map = table(text, 6).unwrap();
    assert_eq!(
        pairs(&map),
        [(17, 1), (17, 2), (17, 3), (3, 1), (3, 2), (3, 3)]
    );
    assert!(
        map.notes[0].contains("names 2 nodes for 6 rows; their directions are taken as ux, uy, uz")
    );
    assert_eq!(
        table(text, 12).unwrap().rows.last(),
        Some(&RowLabel::Nodal {
            node: 3,
            direction: Direction::Rz
        })
    );
    for (text, rows, words) in [
        (
            text,
            7,
            "2 nodes for the 7 rows of the matrix; expected 2, 3 or 6 rows for each",
        ),
        (text, 2, "expected 2, 3 or 6 rows for each"),
        (
            &text[..text.len() - 1],
            6,
            "part:5: the file ends within this line",
        ),
        (
            "%%MatrixMarket matrix array integer general\n2 1\n17\n17\n",
            6,
            "node 17 ux is in line 3 already; a map names every node once",
        ),
        (
            "%%MatrixMarket matrix array integer general\n2 1\n17\n",
            6,
            "has 3 rows, the matrix 6",
        ),
        (
            "%%MatrixMarket matrix array integer general\n2 1\n17\n3\n4\n",
            6,
            "part:5: one row more than the 6",
        ),
        (
            "%%MatrixMarket matrix array integer general\n2 1\n17\n-3\n",
            6,
            "part:4: `-3`; expected the label of a node",
        ),
        (
            "%%MatrixMarket matrix coordinate integer general\n2 1 2\n1 1 17\n2 1 3\n",
            6,
            "a sparse matrix; a map of degrees of freedom is a dense array",
        ),
        (
            "%%MatrixMarket matrix array integer general\n",
            6,
            "the file ends before its size line",
        ),
    ] {
        assert_refused(text, rows, words);
    }
}

/// One column of integers, as NumPy saves it.
fn npy(values: &[i64]) -> Vec<u8> {
    let head = format!(
        "{{'descr': '<i8', 'fortran_order': False, 'shape': ({},), }}",
        values.len()
    );
    let head = format!("{head:<117}\n");
    let mut bytes = b"\x93NUMPY\x01\0".to_vec();
    bytes.extend((head.len() as u16).to_le_bytes());
    bytes.extend(head.as_bytes());
    bytes.extend(values.iter().flat_map(|value| value.to_le_bytes()));
    bytes
}

#[test]
fn arrays_of_numpy_and_matlab_are_tables_too() {
    let right: Vec<(u32, usize)> = (0..12)
        .map(|row| (10 * (row / 3) + 3, row as usize % 3 + 1))
        .collect();
    for (name, array) in [
        ("scipy/variants_dof_ref.npy", None),
        ("matlab/variants_labelled.mat", None),
        ("matlab/variants_labelled.mat", Some("DOF_REF")),
    ] {
        let table = read(&sample(name), array, 12).unwrap();
        assert_eq!(pairs(&table), right, "{name}");
        let refused = read(&sample(name), array, 13).unwrap_err().to_string();
        assert!(refused.contains("has 12 rows, the matrix 13"), "{refused}");
    }
    let nodes = table(npy(&[17, 3]), 6).unwrap();
    assert_eq!(
        pairs(&nodes),
        [(17, 1), (17, 2), (17, 3), (3, 1), (3, 2), (3, 3)]
    );
    assert_eq!(nodes.notes.len(), 1);
    assert_refused(npy(&[17, 3]), 7, "2 nodes for the 7 rows of the matrix");
    assert_refused(npy(&[17, 17]), 6, "has the label 17 twice");
    assert_refused(
        npy(&[17, 0]),
        6,
        "has the label 0; labels of nodes are from 1",
    );
}

#[test]
fn what_is_no_text_has_no_name_there() {
    let message = read(&sample("calculix/bracket.dof"), Some("map"), 240)
        .unwrap_err()
        .to_string();
    assert!(message.contains("leave `#map` out"), "{message}");
    assert_refused(
        b"\x7fELF\0\0\0",
        3,
        "holds no table of dofs; expected .npz, .npy or .mat",
    );
}

#[test]
fn changed_bytes_and_cut_off_files_do_no_harm() {
    let mut state = 0x9e37_79b9_7f4a_7c15u64;
    let mut random = move |below: usize| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state % below as u64) as usize
    };
    for name in ["calculix/bracket.dof", "ansys/bracket.mapping"] {
        let whole = std::fs::read(sample(name)).unwrap();
        for length in (0..whole.len()).step_by(64) {
            assert!(
                table(&whole[..length], 240).is_err(),
                "{name} cut off at {length}"
            );
        }
        for _ in 0..1000 {
            let mut bytes = whole.clone();
            for _ in 0..=random(3) {
                let at = random(bytes.len());
                bytes[at] = random(256) as u8;
            }
            let _ = table(bytes, 240);
        }
    }
}
