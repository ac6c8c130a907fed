//! Abaqus' MATRIX INPUT: a real file with internal nodes, and the bracket in its layout.

use std::collections::BTreeMap;

use dcb_formats::mesh::Direction;
use dcb_import::matrix::abaqus::matrix_input::{list, read, recognises};
use dcb_import::stored::{RowLabel, Rows, StoredMatrix, Triangles};

use crate::damage;
use crate::support::{Format, assert_same, expected, sample, stored};
use crate::text::{assert_refused, completed, lower, read_text};

const MATRIX_INPUT: Format = Format {
    list,
    read,
    recognises,
};

fn labels(matrix: &StoredMatrix) -> Vec<(i64, u32)> {
    let Rows::Labelled(labels) = &matrix.rows else {
        panic!("no labels");
    };
    let pair = |label: &RowLabel| match *label {
        RowLabel::Nodal { node, direction } => (i64::from(node), direction.index() as u32 + 1),
        RowLabel::Internal { point, number } => (-i64::from(point), number),
    };
    labels.iter().map(pair).collect()
}

#[test]
fn the_bracket_is_that_of_matrix_market() {
    for (name, right) in [
        ("abaqus/bracket_STIF1.mtx", "bracket.mtx"),
        ("abaqus/bracket_MASS1.mtx", "bracket.mass.mtx"),
    ] {
        let found = MATRIX_INPUT.all(name);
        let [matrix] = &found[..] else {
            panic!("{name}: {} matrices", found.len());
        };
        assert_same(name, matrix, &lower(expected(right)));
        assert_eq!(
            (matrix.triangles, matrix.digits),
            (Triangles::One, Some(16))
        );
        // Labels 10 k + 3, three translations each.
        let right: Vec<(i64, u32)> = (0..240)
            .map(|row| (10 * (row / 3) + 3, row as u32 % 3 + 1))
            .collect();
        assert_eq!(labels(matrix), right, "{name}");
    }
}

/// Values by two labels, lower and upper place alike.
type ByLabels = BTreeMap<[(i64, u32); 2], u64>;

#[test]
fn internal_nodes_of_a_real_file_are_rows_behind_the_others() {
    for name in [
        "abaqus/fembeam/model_STIF1.mtx",
        "abaqus/fembeam/model_MASS1.mtx",
    ] {
        let found = MATRIX_INPUT.all(name);
        let matrix = &found[0];
        // As the reference of this file lists the rows, those of node -1 at the end here.
        let mut right: Vec<(i64, u32)> = (1..=2)
            .flat_map(|node| (1..=6).map(move |dof| (node, dof)))
            .collect();
        right.extend([(-1, 1), (-1, 2)]);
        assert_eq!((labels(matrix), matrix.digits), (right, Some(16)), "{name}");
        let row = labels(matrix);
        let mut places = ByLabels::new();
        for ((first, second), bits) in stored(matrix) {
            places.insert([row[first as usize], row[second as usize]], bits);
        }
        // The file once more, by the standard library.
        let text = std::fs::read_to_string(sample(name)).unwrap();
        let mut right = ByLabels::new();
        for line in text.lines() {
            let fields: Vec<&str> = line.split(',').map(str::trim).collect();
            let integer = |at: usize| fields[at].parse::<i64>().unwrap();
            let label = |at: usize| (integer(at), integer(at + 1) as u32);
            let value: f64 = fields[4].parse().unwrap();
            right.insert([label(0), label(2)], value.to_bits());
        }
        assert_eq!(right.len(), 33, "{name}");
        assert_eq!(places, right, "{name}");
    }
}

#[test]
fn triangles_and_order_of_what_is_made_by_hand_do_not_matter() {
    let text = "** upper, backwards\n20,6,20,6,4.\n 7 , 1 , 20 , 6 , -1.5\n-3,9,-3,9,2\n7,1,7,1,3.5\n7,1,-3,9,.25\n";
    let matrix = read_text(MATRIX_INPUT, text).unwrap();
    assert_eq!(labels(&matrix), [(7, 1), (20, 6), (-3, 9)]);
    let right = [
        ((0, 0), 3.5),
        ((1, 1), 4.0),
        ((2, 2), 2.0),
        ((0, 1), -1.5),
        ((0, 2), 0.25),
    ];
    let right = right
        .map(|(place, value): (_, f64)| (place, value.to_bits()))
        .into();
    assert_same("text", &matrix, &right);
}

#[test]
fn many_blocks_have_one_numbering() {
    let count = 60_000;
    let mut lines = Vec::new();
    for number in 0..count {
        // Labels fall, so that each block meets lower ones than the block before.
        let label = 3 * (count - number);
        let other = label - 3;
        lines.push(format!("{label},2, {label},2, 2.500000000000000e+00\n"));
        if other > 0 {
            lines.push(format!("{other},2, {label},2, -1.000000000000000e+00\n"));
        }
    }
    let matrix = read_text(MATRIX_INPUT, lines.concat()).unwrap();
    let right: Vec<(i64, u32)> = (1..=count).map(|number| (3 * number, 2)).collect();
    assert_eq!(labels(&matrix), right);
    let places = completed(&matrix);
    assert_eq!(places.len() as i64, 3 * count - 2);
    for ((row, column), bits) in places {
        let value = if row == column { 2.5f64 } else { -1.0 };
        assert!(
            row.abs_diff(column) < 2 && bits == value.to_bits(),
            "{row} {column}"
        );
    }
    lines[100_000] = "3,2, 3\n".into();
    assert_refused(
        MATRIX_INPUT,
        lines.concat(),
        "part:100001: `3,2, 3`; expected `node,dof, node,dof, value`",
    );
}

#[test]
fn held_degrees_of_freedom_are_named() {
    let mut text = String::new();
    for node in 1..=12 {
        text += &format!(
            "{node},1, {node},1,  1.000000000000000e+36\n{node},2, {node},1, 5.0\n{node},2, {node},2,  1.5e+06\n"
        );
    }
    let words = "12 degrees of freedom are held: a stiffness of 1e36 on the diagonal of node 1 ux, node 2 ux, node 3 ux, node 4 ux, node 5 ux, node 6 ux, node 7 ux, node 8 ux, node 9 ux, node 10 ux, ...; remove *BOUNDARY";
    assert_refused(MATRIX_INPUT, text, words);
}

#[test]
fn lines_that_are_no_entries_are_refused_where_they_are() {
    for (line, words) in [
        ("1,1, 1,1", "part:2: `1,1, 1,1`; expected"),
        ("1,1, 1,1, 1.0, 1.0", "part:2:"),
        ("1,1 1,1, 1.0", "part:2:"),
        ("1,1, 1,1, x", "part:2:"),
        ("1,1, 1,1, nan", "part:2:"),
        (
            "1,7, 1,7, 1.0",
            "part:2: degree of freedom 7 (warping) of node 1; only displacements (1 to 3) and rotations (4 to 6) are supported",
        ),
        ("1,8, 1,8, 1.0", "degree of freedom 8 (pressure) of node 1"),
        (
            "1,11, 1,11, 1.0",
            "degree of freedom 11 (temperature) of node 1",
        ),
        ("1,0, 1,0, 1.0", "degree of freedom 0 of node 1"),
        ("0,1, 0,1, 1.0", "labels of nodes, which are counted from 1"),
        (
            "-0,1, 1,1, 1.0",
            "labels of nodes, which are counted from 1",
        ),
        ("2147483648,1, 1,1, 1.0", "labels of nodes up to 2147483647"),
        (
            "99999999999999999999,1, 1,1, 1.0",
            "labels of nodes up to 2147483647",
        ),
        (
            "PART-1-1.1,1, PART-1-1.1,1, 1.0",
            "as FORMAT=LABELS writes them",
        ),
        ("*MATRIX", "part:2:"),
    ] {
        assert_refused(MATRIX_INPUT, format!("1,1, 1,1, 1.5\n{line}\n"), words);
    }
    assert_refused(
        MATRIX_INPUT,
        "1,1, 1,1, 1.5\r1,2, 1,2, 1.5\r",
        "save the file with LF line ends",
    );
    assert_refused(
        MATRIX_INPUT,
        "1,1, 1,1, 1.5",
        "part:1: the file ends within this line",
    );
    assert_refused(
        MATRIX_INPUT,
        "1,1, 1,1, 1.5\n1,2, 1,1, 1.5\n",
        "node 1 uy has entries, but none on the diagonal",
    );
}

#[test]
fn loads_are_no_matrix() {
    let loads = "** Assembled nodal loads\n*CLOAD\n 1,1, 0.5\n";
    for text in [loads, "*CLOAD\n1,1,0.5\n"] {
        assert!(recognises(text.as_bytes()));
        assert_refused(
            MATRIX_INPUT,
            text,
            "holds nodal loads of Abaqus (*CLOAD), no matrix",
        );
    }
}

#[test]
fn labels_by_name_are_recognised_to_be_refused() {
    let text = b"PART-1-1.1,1, PART-1-1.1,1, 1.5e+06\nPART-1-1.1,2, PART-1-1.1,1, 1.5e+06\n";
    assert!(recognises(text));
    assert_refused(
        MATRIX_INPUT,
        text,
        "write the matrices with FORMAT=MATRIX INPUT",
    );
}

#[test]
fn direction_names_go_with_their_numbers() {
    let text: String = (1..=6)
        .map(|dof| format!("4,{dof}, 4,{dof}, {dof}.5\n"))
        .collect();
    let matrix = read_text(MATRIX_INPUT, text).unwrap();
    let right = Direction::ALL.map(|direction| RowLabel::Nodal { node: 4, direction });
    assert_eq!(matrix.rows, Rows::Labelled(right.to_vec()));
}

#[test]
fn cut_off_at_every_64th_byte() {
    for name in [
        "abaqus/bracket_STIF1.mtx",
        "abaqus/bracket_MASS1.mtx",
        "abaqus/fembeam/model_STIF1.mtx",
    ] {
        damage::cut_off(MATRIX_INPUT, name);
    }
}

#[test]
fn changed_bytes_do_no_harm() {
    damage::flipped(MATRIX_INPUT, "abaqus/bracket_MASS1.mtx", 600);
    damage::flipped(MATRIX_INPUT, "abaqus/fembeam/model_STIF1.mtx", 2000);
}
