//! Lines `row column value`: CalculiX's own files, and the layout of Abaqus' COORDINATE.

use dcb_import::matrix::abaqus::coordinate::{list, read, recognises};
use dcb_import::stored::{Rows, Triangles};

use crate::damage;
use crate::support::{Format, assert_same, expected, sample, stored};
use crate::text::{assert_refused, completed, lower, read_text};

const COORDINATE: Format = Format {
    list,
    read,
    recognises,
};

#[test]
fn the_bracket_is_that_of_matrix_market() {
    for (name, right, digits) in [
        ("calculix/bracket.sti", "bracket.mtx", 14),
        ("calculix/bracket.mas", "bracket.mass.mtx", 14),
        ("calculix/bracket_transform.sti", "bracket.mtx", 14),
        ("abaqus/bracket_STIF1_coordinate.mtx", "bracket.mtx", 16),
        (
            "abaqus/bracket_MASS1_coordinate.mtx",
            "bracket.mass.mtx",
            16,
        ),
    ] {
        let found = COORDINATE.all(name);
        let [matrix] = &found[..] else {
            panic!("{name}: {} matrices", found.len());
        };
        assert_eq!(matrix.size, 240, "{name}");
        assert_eq!(
            (matrix.triangles, &matrix.rows),
            (Triangles::Unsaid, &Rows::Unlabelled)
        );
        assert_eq!(matrix.digits, Some(digits), "{name}");
        assert_eq!(completed(matrix), expected(right), "{name}");
        // What is stored of it: both triangles in Abaqus' files, the upper one in CalculiX's.
        let right = expected(right);
        let half = match name.starts_with("abaqus") {
            true => right,
            false => lower(right)
                .into_iter()
                .map(|((row, column), bits)| ((column, row), bits))
                .collect(),
        };
        assert_same(name, matrix, &half);
    }
}

#[test]
fn comments_blanks_order_and_spellings_do_not_matter() {
    let text =
        "** Abaqus\n\n  2\t2   2.5D+00  \r\n1 1 1,5\n** between\n3 3 +.25e1\n1 3 -1.25-1\n2 1 0.\n";
    let matrix = read_text(COORDINATE, text).unwrap();
    let right = [
        ((1, 1), 2.5),
        ((0, 0), 1.5),
        ((2, 2), 2.5),
        ((0, 2), -0.125),
    ];
    let right = right
        .map(|(place, value): (_, f64)| (place, value.to_bits()))
        .into();
    assert_same("text", &matrix, &right);
    assert_eq!((matrix.size, matrix.digits), (3, Some(3)));
}

#[test]
fn a_row_of_zeros_counts_as_a_row() {
    let matrix = read_text(COORDINATE, "1 1 2.0\n2 2 0.0\n3 3 0.0\n1 3 0.0\n").unwrap();
    assert_eq!((matrix.size, stored(&matrix).len()), (3, 1));
}

#[test]
fn lines_that_are_no_entries_are_refused_where_they_are() {
    for (line, words) in [
        ("1 1", "part:2: `1 1`; expected `row column value`"),
        ("1 1 1 1", "part:2: `1 1 1 1`; expected `row column value`"),
        (
            "0 1 1.0",
            "part:2: `0 1 1.0`; expected `row column value`, rows and columns counted from 1",
        ),
        ("1 1 x", "part:2: `1 1 x`"),
        ("1 1 nan", "part:2: `1 1 nan`; expected a finite value"),
        ("1 1 1e999", "expected a finite value"),
        ("1 1 1.000,5", "part:2: `1 1 1.000,5`"),
        ("1.5 1 1.0", "part:2: `1.5 1 1.0`"),
        ("-1 1 1.0", "part:2: `-1 1 1.0`"),
        (
            "4294967297 1 1.0",
            "row or column 4294967297; at most 2147483647",
        ),
        (
            "99999999999999999999 1 1.0",
            "a row or column that 32 bits hold",
        ),
        (
            "2147483647 2147483647 1.0",
            "part:2: row or column 2147483647, but the file has 3 entries",
        ),
        (
            "7 7 1.0",
            "part:2: row or column 7, but the file has 3 entries",
        ),
    ] {
        assert_refused(COORDINATE, format!("1 1 1.5\n{line}\n2 2 1.5\n"), words);
    }
    assert_refused(COORDINATE, "", "has no entry");
    assert_refused(COORDINATE, "** only this\n", "has no entry");
    assert_refused(
        COORDINATE,
        "1 1 1.5\r2 2 1.5\r",
        "save the file with LF line ends",
    );
}

#[test]
fn what_shows_that_a_file_is_cut_off_is_told() {
    assert_refused(
        COORDINATE,
        "1 1 1.5\n2 2 1.5",
        "part:2: the file ends within this line",
    );
    let words = "row 2 has entries, but none on the diagonal";
    assert_refused(COORDINATE, "1 1 1.5\n1 2 1.5\n", words);
    assert_refused(COORDINATE, "1 1 1.5\n3 3 1.5\n2 1 1.5\n", words);
}

#[test]
fn a_banner_that_is_lost_is_told() {
    let text = "3 3 3\n1 1 1.5\n2 2 1.5\n3 3 1.5\n";
    assert_refused(
        COORDINATE,
        text,
        "part:1: is the size line of a Matrix Market file",
    );
}

#[test]
fn a_file_of_many_blocks_names_its_bad_line() {
    let line = |number: usize| format!("{number} {number} 1.2345678901234567e+00\n");
    let mut lines: Vec<String> = (1..=100_000).map(line).collect();
    let matrix = read_text(COORDINATE, lines.concat()).unwrap();
    assert_eq!((matrix.size, matrix.digits), (100_000, Some(17)));
    lines[77_776] = "1 2\n".into();
    lines[98_000] = "x\n".into();
    assert_refused(COORDINATE, lines.concat(), "part:77777: `1 2`");
    let packed = crate::text::gzip(lines.concat().as_bytes());
    assert_refused(COORDINATE, &packed, "part:77777: `1 2`");
    assert_refused(
        COORDINATE,
        &packed[..packed.len() / 2],
        "gzip data damaged or cut off",
    );
}

/// Of a file that is cut off behind the diagonal of a column nothing is left to be seen: a leading part of the matrix, with fewer rows.
#[test]
fn cut_off_at_every_64th_byte() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("damaged");
    for (name, right) in [
        ("calculix/bracket.sti", "bracket.mtx"),
        ("abaqus/bracket_MASS1_coordinate.mtx", "bracket.mass.mtx"),
    ] {
        let whole = std::fs::read(sample(name)).unwrap();
        let right = expected(right);
        let mut parts = 0;
        for length in (0..whole.len()).step_by(64) {
            std::fs::write(&path, &whole[..length]).unwrap();
            let Ok(read) = read(&path, &[0]) else {
                continue;
            };
            let matrix = &read.matrices[0];
            let size = matrix.size as u32;
            let mut leading = right.clone();
            leading.retain(|(row, column), _| row.max(column) < &size);
            assert!(size < 240, "{name} cut off at {length}");
            assert_eq!(completed(matrix), leading, "{name} cut off at {length}");
            parts += 1;
        }
        assert!(
            parts < 12,
            "{name}: {parts} of {} are read",
            whole.len() / 64
        );
    }
}

#[test]
fn changed_bytes_do_no_harm() {
    damage::flipped(COORDINATE, "calculix/bracket.sti", 600);
    damage::flipped(COORDINATE, "abaqus/bracket_MASS1_coordinate.mtx", 600);
}
