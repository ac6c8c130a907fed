//! DMIG in every form of field.

use std::fmt::Write as _;

use dcb_formats::mesh::Direction;
use dcb_import::matrix::nastran::dmig;
use dcb_import::stored::{Reading, RowLabel, Rows, StoredMatrix, Triangles};

use crate::support::{Places, Reader, difference, entry_difference, file, full, sample, truth};

const DMIG: Reader = Reader {
    recognises: dmig::recognises,
    list: dmig::list,
    read: dmig::read,
};

fn labels(matrix: &StoredMatrix) -> &[RowLabel] {
    match &matrix.rows {
        Rows::Labelled(labels) => labels,
        Rows::Unlabelled => &[],
    }
}

fn label(point: u32, component: u32) -> RowLabel {
    match component.checked_sub(1) {
        None => RowLabel::Internal { point, number: 0 },
        Some(index) => RowLabel::Nodal {
            node: point,
            direction: Direction::from_index(index as usize).unwrap(),
        },
    }
}

fn read_text(text: &str, number: usize) -> Result<StoredMatrix, String> {
    let reading = dmig::read(file(text.as_bytes()).path(), &[number]);
    let Reading { mut matrices, .. } = reading.map_err(|error| error.to_string())?;
    Ok(matrices.remove(0))
}

#[test]
fn the_bracket_is_as_near_as_the_printed_digits() {
    let expected = [truth("bracket.mtx"), truth("bracket.mass.mtx")];
    for (name, digits, largest) in [("double", 10, 1e-10), ("small_field", 3, 1e-4)] {
        let path = sample(&format!("nastran/bracket_{name}.pch"));
        assert!(dmig::recognises(&std::fs::read(&path).unwrap()));
        let names = dmig::list(&path).unwrap();
        let names: Vec<&str> = names.iter().map(|one| one.name.as_str()).collect();
        assert_eq!(names, ["KAAX", "MAAX"]);
        let reading = dmig::read(&path, &[0, 1]).unwrap();
        for (matrix, expected) in reading.matrices.iter().zip(&expected) {
            assert_eq!((matrix.size, matrix.triangles), (240, Triangles::One));
            let rows = labels(matrix);
            // Labels 10 k + 3, three directions each.
            assert_eq!(rows.len(), 240);
            assert!(rows.is_sorted());
            assert_eq!(
                rows[..4],
                [label(3, 1), label(3, 2), label(3, 3), label(13, 1)]
            );
            assert_eq!(rows[239], label(793, 3));
            let far = difference(&full(matrix), expected);
            assert!(far <= largest, "{name} {}: {far:e}", matrix.name);
            assert_eq!(matrix.digits, Some(digits), "{name} {}", matrix.name);
        }
    }
}

/// Written by pyNastran: grids and scalar points, upper triangle, columns from the last to the first, heads repeated.
#[test]
fn labels_are_sorted_whatever_the_order_of_columns() {
    let text = std::fs::read_to_string(sample("nastran/variants_labels.txt")).unwrap();
    let pairs = text.lines().map(|line| {
        let (point, component) = line.split_once(' ').unwrap();
        (point.parse().unwrap(), component.parse().unwrap())
    });
    let all: Vec<RowLabel> = pairs
        .map(|(point, component)| label(point, component))
        .collect();
    let expected = truth("nastran/variants_tame.mtx");
    for (name, digits, largest) in [
        ("double", 10, 5e-10),
        ("large", 10, 5e-10),
        ("small", 0, 0.05),
    ] {
        let path = sample(&format!("nastran/variants_{name}.pch"));
        let reading = dmig::read(&path, &[1, 0]).unwrap();
        for (matrix, name) in reading.matrices.iter().zip(["B2GG", "KAAX"]) {
            assert_eq!(matrix.name, name);
            let rows = labels(matrix);
            assert!(rows.is_sorted());
            let place = |row: u32| {
                all.iter()
                    .position(|other| *other == rows[row as usize])
                    .unwrap() as u32
            };
            let found: Places = full(matrix)
                .into_iter()
                .map(|((row, column), value)| ((place(row), place(column)), value))
                .collect();
            let far = entry_difference(&found, &expected);
            assert!(far <= largest, "{name}: {far:e}");
            assert!(matrix.digits >= Some(digits), "{name}: {:?}", matrix.digits);
        }
    }
}

/// Sums by pyyeti 1.4.7 of a real punch file.
#[test]
fn real_punch_files_are_read() {
    let path = sample("nastran/pyyeti/matrix_factory.pch");
    let listed = dmig::list(&path).unwrap();
    let listed: Vec<_> = listed
        .iter()
        .map(|one| (one.name.as_str(), one.obstacle.as_deref()))
        .collect();
    assert_eq!(
        listed,
        [
            ("PATRN", None),
            ("IDENT", None),
            ("RANDM", None),
            ("CMPLX", Some("complex"))
        ]
    );
    let matrices = dmig::read(&path, &[0, 1, 2]).unwrap().matrices;
    let pattern = full(&matrices[0]);
    assert_eq!(pattern.len(), 441);
    assert!(
        pattern
            .iter()
            .all(|((_, column), value)| f64::from_bits(*value) == f64::from(column + 1))
    );
    let identity = (0..21).map(|row| ((row, row), 1f64.to_bits()));
    assert!(full(&matrices[1]) == identity.collect::<Places>());
    let random: Vec<f64> = full(&matrices[2])
        .values()
        .map(|bits| f64::from_bits(*bits))
        .collect();
    assert!((random.iter().sum::<f64>() - 224.360_189_815_542_8).abs() < 1e-11);
    let squares: f64 = random.iter().map(|value| value * value).sum();
    assert!((squares - 148.533_887_031).abs() < 1e-8);
    assert_eq!(f64::from_bits(full(&matrices[2])[&(3, 5)]), 0.926_350_276_4);
    for (matrix, digits) in matrices.iter().zip([10, 10, 10]) {
        assert_eq!((matrix.size, matrix.triangles), (21, matrix.triangles));
        assert_eq!(matrix.digits, Some(digits), "{}", matrix.name);
        assert_eq!(
            labels(matrix)[18..],
            [label(10, 0), label(11, 0), label(12, 0)]
        );
    }
    let error = dmig::read(&path, &[3]).unwrap_err().to_string();
    assert!(error.contains("the matrix CMPLX: is complex"), "{error}");
}

/// The same matrix in free, small and large fields, with tabulators, small letters, other cards between, repeated heads, other line ends.
#[test]
fn every_form_of_field_gives_the_same_matrix() {
    let free = "DMIG,kaax,0,6,2,0,,,2\nDMIG,KAAX,5,1,,5,1,1.5D+03\n,12,,-.5,,5,2,8.0593-7\nDMIG,KAAX,12,,,12,0,1.5+3\ndmig,kaax,5,2,,5,2,-0.0\n";
    let small = "DMIG    KAAX           0       6       2       0                       2\n\
        DMIG    KAAX           5       1               5       1    1.+3\n\
        $ a comment\n\
        +       \n\
        $\n\
        DMIG    KAAX           5       1               5       1 1.5D+03        +A\n\
        +A            12             -.5               5       28.0593-7\n\
        DMIG    KAAX          12                      12           1.5+3\n\
        DMIG    KAAX           5       2               5       2    -0.0\n";
    let small = small.replace("DMIG    KAAX           5       1               5       1    1.+3\n$ a comment\n+       \n$\n", "");
    let large = "$TITLE   = DMIG\n\
        DMIG*   KAAX                           0               6               2*KA\n\
        *KA                            0                               2\n\
        GRID*                  5               0              1.              2.\n\
        *                     3.               0\n\
        DMIG*   KAAX                           5               1\n\
        *                      5               1         1.5D+03\n\
        *                     12               0             -.5\n\
        GRID          12              0.      0.      0.\n\
        +           9999\n\
        DMIG*   KAAX                           5               1\n\
        *                      5               2        8.0593-7                $ why\n\
        DMIG*   KAAX                          12               0\n\
        *                     12                           1.5+3\n\
        DMIG*   KAAX                           5               2\n\
        *                      5               2            -0.0\n\
        ENDDATA\n";
    let large_free = "DMIG*,KAAX,0,6,2\n*,0,,,\nDMIG*,KAAX,5,1\n*,5,1,1.5D+03\n*,12,0,-.5\n*,5,2,8.0593-7\nDMIG*,KAAX,12\n*,12,,1500.\nDMIG*,KAAX,5,2,\n*,5,2,-0.0,,\n";
    let tabs = "DMIG\tKAAX\t0\t6\t2\nDMIG\tKAAX\t5\t1\t\t5\t1\t1.5D+03\n\t12\t\t-.5\t\t5\t2\t8.0593-7\nDMIG\tKAAX\t12\t\t\t12\t0\t1500.\nDMIG\tKAAX\t5\t2\t\t5\t2\t-.0\n";
    let rows = [label(5, 1), label(5, 2), label(12, 0)];
    let expected = Places::from([
        ((0, 0), 1500f64.to_bits()),
        ((1, 1), (-0.0f64).to_bits()),
        ((2, 2), 1500f64.to_bits()),
        ((0, 1), 8.0593e-7f64.to_bits()),
        ((1, 0), 8.0593e-7f64.to_bits()),
        ((0, 2), (-0.5f64).to_bits()),
        ((2, 0), (-0.5f64).to_bits()),
    ]);
    let mut upper = free.to_owned();
    upper = upper.replace(
        "5,1,,5,1,1.5D+03\n,12,,-.5,,5,2,8.0593-7",
        "5,1,,5,1,1.5D+03",
    );
    upper += "DMIG,KAAX,12,,,5,1,-.5\nDMIG,KAAX,5,2,,5,1,8.0593-7,,,,,,\n";
    for text in [free, &small, large, large_free, tabs, &upper] {
        let mixed = format!("K2GG=KAAX\nBEGIN BULK\nFORCE,1,2\n,3,4\n{text}");
        for text in [text.to_owned(), text.replace('\n', "\r\n"), mixed] {
            assert!(dmig::recognises(text.as_bytes()), "{text}");
            let matrix = read_text(&text, 0).unwrap();
            assert_eq!(matrix.name, "KAAX");
            assert_eq!(labels(&matrix), rows, "{text}");
            assert!(full(&matrix) == expected, "{text}\n{matrix:?}");
        }
    }
}

/// Long columns, so that blocks of text begin within them, and within other cards; another matrix between.
#[test]
fn columns_may_be_longer_than_a_block() {
    let (mut text, mut expected) = (String::new(), Places::new());
    text += "DMIG    KGG            0       6       2\nDMIG*   SKIP                           0               1               4\n*                      4               1\n";
    let size = 6000;
    for column in 0..30u32 {
        writeln!(text, "DMIG*   KGG     {:>16}{:>16}", column + 1, 0).unwrap();
        for row in column..size {
            let value = f64::from(row + 1) / 64.0 + f64::from(column);
            expected.insert((row, column), value.to_bits());
            expected.insert((column, row), value.to_bits());
            writeln!(text, "*       {:>16}{:>16}{value:>16.9}", row + 1, 0).unwrap();
        }
        writeln!(
            text,
            "DMIG*   SKIP    {:>16}{:>16}\n*       {:>16}{:>16}{:>16}{:>16}",
            1, 1, 2, 2, 1.0, 2.0
        )
        .unwrap();
        for node in 0..4000 {
            writeln!(
                text,
                "GRID*   {node:>16}{:>16}{:>16}{:>16}\n*       {:>16}",
                "", 1.5, 2.5, 3.5
            )
            .unwrap();
        }
    }
    for row in 30..size {
        expected.insert((row, row), 7f64.to_bits());
        writeln!(text, "DMIG,KGG,{},,,{},,7.0", row + 1, row + 1).unwrap();
    }
    assert!(text.len() > 20 << 18);
    let matrix = read_text(&text, 0).unwrap();
    assert_eq!(matrix.size, size as usize);
    assert!(full(&matrix) == expected);
}

#[test]
fn what_cant_be_used_is_told_by_its_line() {
    let good = "DMIG,K,0,6,2,0\nDMIG,K,1,1,,1,1,1.0\nDMIG,K,2,1,,2,1,1.0\n";
    assert!(read_text(good, 0).is_ok());
    for (old, new, told) in [
        (
            "K,2,1,,",
            "K,2147483648,1,,",
            ":3: the label 2147483648; labels are at most 2147483647",
        ),
        (
            "K,2,1,,",
            "K,99999999999999999999,1,,",
            ":3: the label 99999999999999999999",
        ),
        ("2,1,1.0", "2,7,1.0", ":3: component `7` of point 2"),
        (
            "2,1,1.0",
            "2,123456,1.0",
            ":3: component `123456` of point 2",
        ),
        (
            "2,1,1.0",
            "2,1,1",
            ":3: `1`; expected a number with a point",
        ),
        ("2,1,1.0", "2,1,", ":3: ``; expected a number"),
        ("2,1,1.0", "2,1,1.0,2.0", ":3: `2.0` as the imaginary part"),
        (
            "2,1,1.0",
            "2,1,1.0+400",
            ":3: `1.0+400`; expected a finite number",
        ),
        ("2,1,1.0", "x,1,1.0", ":3: `x`; expected the label"),
        ("2,1,1.0", "0,1,1.0", ":3: `0`; expected the label"),
        ("2,1,1.0", "2,1,1,0,,,,", ":3: "),
        (
            "DMIG,K,2,1,,2,1,1.0\n",
            "DMIG*   K                              2               1\n*                      2               1 1,500000000D+06\n",
            ":4: commas in fields of fixed width; numbers have a decimal point",
        ),
        (
            "DMIG,K,2",
            "DMIG,K2,2",
            ":3: a column of K2, which has no header",
        ),
        ("DMIG,K,2", "DMIG,,2", ":3: ``; expected the name"),
        (
            "2,1,1.0\n",
            "2,1,1.0\nDMIG,K,0,6,2\n",
            "two headers of the matrix K",
        ),
        ("2,1,1.0\n", "2,1,1.0", ":3: the file ends within this line"),
        (
            "2,1,1.0\n",
            "1,1,1.0\n",
            "node 2 ux has entries, but none on the diagonal",
        ),
        ("0,6,2", "0,9,2", "is rectangular (form 9)"),
        ("0,6,2", "0,2,1", "is rectangular (form 2)"),
        ("0,6,2", "0,6,3", "is complex"),
        ("0,6,2,0", "0,6,4,0,1", "is complex, amplitudes and phases"),
        ("0,6,2", "0,8,2", "is of form 8"),
        ("0,6,2", "0,6,5", "of numbers of type 5"),
        (
            "DMIG,K,1,1,,1,1,1.0\nDMIG,K,2,1,,2,1,1.0\n",
            "",
            "has 0 rows",
        ),
    ] {
        assert!(good.contains(old), "{old}");
        let error = read_text(&good.replacen(old, new, 1), 0).unwrap_err();
        assert!(error.contains(told), "{old} -> {new}: {error}");
    }
    assert!(read_text("DMIG,UACCEL,0,9,1\nDMIG,UACCEL,2,,,1,3,386.4\n", 0).is_err());
    let acceleration = format!("DMIG,UACCEL,0,9,1\nDMIG,UACCEL,2,,,1,3,386.4\n{good}");
    assert!(read_text(&acceleration, 0).is_ok());
}

#[test]
fn cut_off_and_flipped_files_are_refused_or_read() {
    for name in ["variants_double.pch", "variants_small.pch"] {
        let text = std::fs::read(sample(&format!("nastran/{name}"))).unwrap();
        DMIG.is_flipped(&text, 700);
        DMIG.is_cut_off(&text);
    }
}
