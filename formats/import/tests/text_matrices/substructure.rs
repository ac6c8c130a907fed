//! Substructures: real ones of Abaqus, symmetric and unsymmetric, and CalculiX's of the bracket, which isn't condensed in this file: it has
//! the rows of the whole stiffness that are kept.

use dcb_import::matrix::abaqus::substructure::{list, read, recognises};
use dcb_import::stored::{RowLabel, Rows, StoredMatrix, Triangles};
use nalgebra::DMatrix;

use crate::damage;
use crate::support::{Format, Places, expected, sample, stored};
use crate::text::{assert_refused, completed, read_text};

const SUBSTRUCTURE: Format = Format {
    list,
    read,
    recognises,
};

fn nodal(matrix: &StoredMatrix) -> Vec<(u32, usize)> {
    let Rows::Labelled(labels) = &matrix.rows else {
        panic!("no labels");
    };
    let pair = |label: &RowLabel| match label {
        RowLabel::Nodal { node, direction } => (*node, direction.index() + 1),
        RowLabel::Internal { .. } => panic!("{label:?}"),
    };
    labels.iter().map(pair).collect()
}

fn dense(size: usize, places: &Places) -> DMatrix<f64> {
    let mut dense = DMatrix::zeros(size, size);
    for ((row, column), bits) in places {
        dense[(*row as usize, *column as usize)] = f64::from_bits(*bits);
    }
    dense
}

/// Numbers behind each `*MATRIX`, by the standard library.
fn numbers(name: &str) -> Vec<Vec<f64>> {
    let text = std::fs::read_to_string(sample(name)).unwrap();
    let mut found: Vec<Vec<f64>> = Vec::new();
    for line in text.lines() {
        if line.starts_with("*MATRIX") {
            found.push(Vec::new());
        } else if let Some(numbers) = found.last_mut() {
            let words = line
                .split(',')
                .map(str::trim)
                .filter(|word| !word.is_empty());
            numbers.extend(words.map(|word| word.parse::<f64>().unwrap()));
        }
    }
    found
}

#[test]
fn real_files_of_abaqus_give_their_numbers_in_their_places() {
    let listed = list(&sample("abaqus/substructure/inner.mtx")).unwrap();
    let names: Vec<&str> = listed.iter().map(|listed| listed.name.as_str()).collect();
    assert_eq!(names, ["STIFFNESS", "MASS"]);
    let mut both = Vec::new();
    // The mass of the unsymmetric file is a lower triangle all the same.
    for (name, triangles) in [
        (
            "abaqus/substructure/inner.mtx",
            [Triangles::One, Triangles::One],
        ),
        (
            "abaqus/substructure/inner_unsymmetric.mtx",
            [Triangles::Both, Triangles::One],
        ),
    ] {
        let found = SUBSTRUCTURE.all(name);
        let right = numbers(name);
        assert_eq!((found.len(), right.len()), (2, 2), "{name}");
        let mut full = Vec::new();
        for ((matrix, right), triangles) in found.iter().zip(right).zip(triangles) {
            assert_eq!(
                (matrix.size, matrix.triangles, matrix.digits),
                (36, triangles, Some(14)),
                "{name}"
            );
            let rows: Vec<(u32, usize)> = (2..=7)
                .flat_map(|node| (1..=6).map(move |dof| (node, dof)))
                .collect();
            assert_eq!(nodal(matrix), rows);
            let mut right = right.into_iter();
            let mut places = Places::new();
            for row in 0..36 {
                let end = if triangles == Triangles::Both {
                    36
                } else {
                    row + 1
                };
                for column in 0..end {
                    places.insert((row, column), right.next().unwrap().to_bits());
                }
            }
            assert_eq!(right.next(), None, "{name}");
            places.retain(|_, bits| f64::from_bits(*bits) != 0.0);
            assert_eq!(stored(matrix), places, "{name}: {}", matrix.name);
            full.push(dense(
                36,
                &match triangles {
                    Triangles::Both => stored(matrix),
                    _ => completed(matrix),
                },
            ));
        }
        both.push(full);
    }
    for (symmetric, unsymmetric) in both[0].iter().zip(&both[1]) {
        let difference = (symmetric - unsymmetric).amax() / symmetric.amax();
        assert!(difference < 1.8e-16, "{difference:e}");
    }
}

#[test]
fn the_substructure_of_calculix_has_the_kept_rows_of_the_stiffness() {
    let found = SUBSTRUCTURE.all("calculix/bracket_substructure.mtx");
    let [matrix] = &found[..] else {
        panic!("{} matrices", found.len());
    };
    assert_eq!(
        (matrix.name.as_str(), matrix.size, matrix.digits),
        ("STIFFNESS", 48, Some(13))
    );
    let kept: Vec<usize> = nodal(matrix)
        .into_iter()
        .map(|(node, dof)| 3 * (node as usize / 10) + dof - 1)
        .collect();
    let whole = dense(240, &expected("bracket.mtx"));
    let part = DMatrix::from_fn(48, 48, |row, column| whole[(kept[row], kept[column])]);
    let difference = (dense(48, &completed(matrix)) - &part).amax() / part.amax();
    assert!(difference < 1e-13, "{difference:e}");
}

const HEAD: &str = "*USER ELEMENT, NODES=2, LINEAR\n** ELEMENT NODES\n** 7, 9\n 1, 2\n 2, 6\n";

#[test]
fn types_are_called_as_they_are_and_chosen_by_number() {
    let text = format!(
        "{HEAD}*Matrix, Type=stiffness\n1.,\n.5, 2.\n0.,0.,3.\n*DAMPING CONTROLS\n junk\n*MATRIX,TYPE=STRUCTURAL DAMPING\n4.\n0.,\n** comment\n 5.\n0., 0., 6.,\n"
    );
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("part");
    std::fs::write(&path, text).unwrap();
    let names: Vec<String> = list(&path)
        .unwrap()
        .into_iter()
        .map(|listed| listed.name)
        .collect();
    assert_eq!(names, ["stiffness", "STRUCTURAL DAMPING"]);
    let damping = read(&path, &[1]).unwrap().matrices.remove(0);
    let right = [((0, 0), 4.0f64), ((1, 1), 5.0), ((2, 2), 6.0)];
    let bits = |(place, value): (_, f64)| (place, value.to_bits());
    assert_eq!(stored(&damping), right.map(bits).into());
    let matrix = read(&path, &[0]).unwrap().matrices.remove(0);
    assert_eq!(nodal(&matrix), [(7, 1), (7, 2), (9, 6)]);
    let right = [
        ((0, 0), 1.0f64),
        ((1, 0), 0.5),
        ((1, 1), 2.0),
        ((2, 2), 3.0),
    ];
    assert_eq!(stored(&matrix), right.map(bits).into());
}

#[test]
fn what_does_not_fit_together_is_refused() {
    let stiffness = "*MATRIX,TYPE=STIFFNESS\n1.,\n.5, 2.\n0.,0.,3.\n";
    for (head, body, words) in [
        (HEAD, "", "has no line `*MATRIX, TYPE=...`"),
        (
            HEAD,
            "*MATRIX,TYPE=STIFFNESS\n1.,\n.5, 2.\n",
            "part:6: STIFFNESS has 3 numbers; 3 rows have 6 (the lower triangle) or 9",
        ),
        (
            HEAD,
            "*MATRIX,TYPE=STIFFNESS\n1.,.5\n 2.\n0.,0.,3.\n",
            "part:7: row 1 of STIFFNESS has more than 1 numbers here",
        ),
        (
            HEAD,
            "*MATRIX,TYPE=STIFFNESS\n1.,\n.5, x\n0.,0.,3.\n",
            "part:8: `.5, x`; expected numbers with commas",
        ),
        (
            HEAD,
            "*MATRIX,TYPE=STIFFNESS\n1.,\n.5 2.\n0.,0.,3.\n",
            "part:8: `.5 2.`; expected numbers with commas",
        ),
        (
            HEAD,
            "*MATRIX,TYPE=STIFFNESS\n1.,\n.5, nan\n0.,0.,3.\n",
            "expected finite numbers",
        ),
        (
            HEAD,
            "*MATRIX\n1.,\n.5, 2.\n0.,0.,3.\n",
            "expected *MATRIX, TYPE=STIFFNESS",
        ),
        (
            HEAD,
            "*MATRIX,TYPE=STIFFNESS\n1.,\n.5, 2.\n0.,0.,3.",
            "part:9: the file ends within this line",
        ),
        (
            HEAD,
            "*MATRIX,TYPE=STIFFNESS\n1.,\n*USER ELEMENT\n",
            "a second *USER ELEMENT",
        ),
        (
            "*USER ELEMENT, LINEAR\n",
            stiffness,
            "expected NODES= and a number",
        ),
        (
            "*USER ELEMENT, NODES=3\n** ELEMENT NODES\n** 7, 9\n 1\n",
            stiffness,
            "NODES=3, but 2 labels",
        ),
        (
            "*USER ELEMENT, NODES=2\n** ELEMENT NODES\n** 7, 9\n 1, 1\n",
            stiffness,
            "node 7 ux is there twice",
        ),
        (
            "*USER ELEMENT, NODES=2\n** ELEMENT NODES\n** 7, 9\n 1\n 3, 1\n",
            stiffness,
            "degrees of freedom of node 3 of 2",
        ),
        (
            "*USER ELEMENT, NODES=2\n** ELEMENT NODES\n** 7, 9\n 1\n 1, 1\n",
            stiffness,
            "by rising numbers",
        ),
        (
            "*USER ELEMENT, NODES=2\n** ELEMENT NODES\n** 7, 3000000000\n 1\n",
            stiffness,
            "node 3000000000; expected labels",
        ),
        (
            "*USER ELEMENT, NODES=2\n** ELEMENT NODES\n** 7, 9\n 1, 11\n",
            stiffness,
            "degree of freedom 11 (temperature) of node 7",
        ),
        (
            "*USER ELEMENT, NODES=2\n** ELEMENT NODES\n** 7, a\n 1\n",
            stiffness,
            "expected integers with commas",
        ),
        (
            "*USER ELEMENT, NODES=2000000000\n 1\n 2000000000, 1\n",
            stiffness,
            "of which the file can't hold a matrix",
        ),
        (
            "*USER ELEMENT, NODES=2\n",
            stiffness,
            "*MATRIX before *USER ELEMENT with its degrees of freedom",
        ),
    ] {
        assert_refused(SUBSTRUCTURE, format!("{head}{body}"), words);
    }
}

#[test]
fn without_labels_the_rows_have_none() {
    let text = "*USER ELEMENT, NODES=3\n 1\n*MATRIX,TYPE=MASS\n1.,\n.5, 2.\n0.,0.,3.\n";
    let matrix = read_text(SUBSTRUCTURE, text).unwrap();
    assert_eq!(
        (matrix.size, &matrix.rows, matrix.notes.len()),
        (3, &Rows::Unlabelled, 1)
    );
}

#[test]
fn a_large_substructure_is_read_from_many_blocks() {
    let size = 700;
    let mut text = format!("*USER ELEMENT, NODES={size}, LINEAR\n** ELEMENT NODES\n");
    for node in 1..=size {
        text += &format!("** {},\n", 2 * node);
    }
    text += " 3\n*MATRIX,TYPE=STIFFNESS\n";
    let value = |row: usize, column: usize| (row * 1000 + column) as f64 * 1.25e-3 + 1.0;
    for row in 0..size {
        for (place, column) in (0..=row).enumerate() {
            text += &format!("{:.13E}", value(row, column));
            text += if place % 4 == 3 || column == row {
                ",\n"
            } else {
                ", "
            };
        }
    }
    let matrix = read_text(SUBSTRUCTURE, &text).unwrap();
    let places = stored(&matrix);
    assert_eq!(places.len(), size * (size + 1) / 2);
    for ((row, column), bits) in places {
        let right: f64 = format!("{:.13E}", value(row as usize, column as usize))
            .parse()
            .unwrap();
        assert_eq!(bits, right.to_bits(), "{row} {column}");
    }
    let at = text.len() / 2 + text[text.len() / 2..].find('\n').unwrap() + 1;
    let line = text[..at].lines().count();
    text.insert(at, '?');
    assert_refused(SUBSTRUCTURE, &text, &format!("part:{}: `?", line + 1));
}

#[test]
fn cut_off_at_every_64th_byte() {
    damage::cut_off(SUBSTRUCTURE, "abaqus/substructure/inner.mtx");
    damage::cut_off(SUBSTRUCTURE, "abaqus/substructure/inner_unsymmetric.mtx");
    damage::cut_off(SUBSTRUCTURE, "calculix/bracket_substructure.mtx");
}

#[test]
fn changed_bytes_do_no_harm() {
    damage::flipped(SUBSTRUCTURE, "abaqus/substructure/inner.mtx", 2000);
    damage::flipped(SUBSTRUCTURE, "calculix/bracket_substructure.mtx", 2000);
}
