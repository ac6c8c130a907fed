//! Harwell-Boeing files: the bracket in HBMAT's layout, and small matrices in every format; SciPy writes and reads some of them.

use dcb_import::matrix::harwell_boeing::{list, read, recognises};
use dcb_import::stored::{Rows, Triangles};

use crate::damage;
use crate::support::{Format, assert_same, expected, sample, stored};
use crate::text::{assert_refused, completed, lower, read_text};

const HARWELL_BOEING: Format = Format {
    list,
    read,
    recognises,
};

#[test]
fn the_bracket_is_that_of_matrix_market() {
    for (name, right, title) in [
        (
            "ansys/bracket_stiff.matrix",
            "bracket.mtx",
            "stiffness matrix",
        ),
        (
            "ansys/bracket_mass.matrix",
            "bracket.mass.mtx",
            "mass matrix",
        ),
    ] {
        let found = HARWELL_BOEING.all(name);
        let [matrix] = &found[..] else {
            panic!("{name}: {} matrices", found.len());
        };
        assert_same(name, matrix, &lower(expected(right)));
        assert_eq!(
            (matrix.triangles, matrix.digits),
            (Triangles::One, Some(16))
        );
        assert_eq!(
            (matrix.name.as_str(), &matrix.rows),
            (title, &Rows::Unlabelled)
        );
    }
}

#[test]
fn five_digits_are_told_and_as_close_as_they_can_be() {
    let name = "ansys/bracket_stiff_5digits.matrix";
    let found = HARWELL_BOEING.all(name);
    assert_eq!(found[0].digits, Some(5));
    let (found, right) = (completed(&found[0]), expected("bracket.mtx"));
    let value = |bits: &u64| f64::from_bits(*bits);
    assert_eq!(found.len(), right.len());
    for (place, bits) in &found {
        let difference = (value(bits) - value(&right[place])).abs();
        assert!(
            difference < 5e-5 * value(&right[place]).abs(),
            "{place:?}: {difference:e}"
        );
    }
}

#[test]
fn every_format_of_numbers_gives_the_same_matrix() {
    for (name, right, digits) in [
        ("ansys/variants_scipy.rua", "variants.mtx", 17),
        ("ansys/variants_full.rua", "variants.mtx", 17),
        ("ansys/variants_no_comma.rua", "variants.mtx", 17),
        ("ansys/variants_touching.rsa", "variants.mtx", 17),
        ("ansys/variants_d.rsa", "variants.mtx", 17),
        ("ansys/variants_no_letter.rsa", "variants.mtx", 17),
        ("ansys/variants_right_hand.rsa", "variants.mass.mtx", 17),
        ("ansys/variants_rutherford.rb", "variants.mass.mtx", 17),
    ] {
        let found = HARWELL_BOEING.all(name);
        let matrix = &found[0];
        let right = match matrix.triangles {
            Triangles::Both => expected(right),
            _ => lower(expected(right)),
        };
        assert_same(name, matrix, &right);
        assert_eq!(matrix.digits, Some(digits), "{name}");
    }
    // Seventeen places behind the point: the numbers below one have fewer digits.
    let found = HARWELL_BOEING.all("ansys/variants_fixed.rua");
    let right = expected("variants.mtx");
    for (place, bits) in stored(&found[0]) {
        let difference = f64::from_bits(bits) - f64::from_bits(right[&place]);
        assert!(difference.abs() <= 5e-18, "{place:?}: {difference:e}");
    }
}

/// A sample with a piece of text replaced, once.
fn changed(name: &str, from: &str, to: &str) -> String {
    let text = std::fs::read_to_string(sample(name)).unwrap();
    assert!(text.contains(from), "{from:?}");
    text.replacen(from, to, 1)
}

#[test]
fn what_is_no_stiffness_is_listed_with_its_obstacle_and_refused() {
    let name = "ansys/variants_touching.rsa";
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("part");
    for (kind, obstacle) in [
        ("CSA", "complex"),
        ("PSA", "a pattern without numbers"),
        ("RZA", "skew-symmetric"),
        ("RRA", "rectangular"),
        ("RSE", "elemental, not assembled"),
        ("CHA", "complex"),
    ] {
        let text = changed(name, "RSA", kind);
        std::fs::write(&path, &text).unwrap();
        let listed = list(&path).unwrap();
        assert_eq!(listed[0].obstacle.as_deref(), Some(obstacle));
        assert_refused(
            HARWELL_BOEING,
            &text,
            &format!("of type {kind}, 12 x 12: {obstacle}; expected a real, square, assembled one"),
        );
    }
    let text = changed(
        name,
        "            12            12 ",
        "            12            13 ",
    );
    assert_refused(HARWELL_BOEING, text, "12 x 13: rectangular");
}

#[test]
fn counts_that_do_not_fit_are_refused_where_they_are() {
    let name = "ansys/variants_touching.rsa";
    for (from, to, words) in [
        (
            "            31             0\n",
            "      31000000             0\n",
            "part:2: 2 lines of row numbers are announced; 31000000 of them, 26 a line, take 1192308",
        ),
        (
            "RSA                       12            12",
            "RSA                 12000000      12000000",
            "part:2: 2 lines of pointers are announced",
        ),
        (
            "             2             2            11",
            "             2             2         11000",
            "part:2: 11000 lines of values are announced; 31 of them, 3 a line, take 11",
        ),
        (
            "(26I3)",
            "(26A3)",
            "part:4: format `(26A3)`; expected one such as (10I8)",
        ),
        ("(26I3)", "(3E23.", "part:4: format"),
        (
            "(10I8)          (26I3)          (1P,3E23.16)",
            "(10I8)          (26I3)",
            "part:4: no format of values",
        ),
        (
            "(10I8)          (26I3)          (1P,3E23.16)",
            "(10E8.0)        (26I3)          (1P,3E23.16)",
            "part:4: the format of the pointers",
        ),
        (
            "       1       4       7",
            "       2       4       7",
            "pointers of columns go from 2 to 32; expected from 1 to 32",
        ),
        (
            "       1       4       7",
            "       1       9       7",
            "column 3 begins at entry 7, the one before at 9; expected rising pointers",
        ),
        (
            "       1       4       7",
            "       1       x       7",
            "part:5: `x`; expected an integer from 1 to 32",
        ),
        (
            "  1  2  5  2",
            "  1  2 15  2",
            "part:7: `15`; expected an integer from 1 to 12",
        ),
        (
            "  1  2  5  2",
            "  1  2  0  2",
            "part:7: `0`; expected an integer from 1 to 12",
        ),
        (
            " 5.4142135623730949E+00-1",
            " 5.4142135623730949X+00-1",
            "part:9: `5.4142135623730949X+00`; expected a finite number",
        ),
        (
            " 5.4142135623730949E+00-1",
            "                    NaN-1",
            "part:9: `NaN`; expected a finite number",
        ),
        (
            " 5.4142135623730949E+00-1",
            "     54142135623730949E+0-1",
            "part:9:",
        ),
        (
            " 5.4142135623730949E+00-1",
            "      54142135623730949-1",
            "part:9:",
        ),
        (
            " 5.4142135623730949E+00-1",
            "     5.4142135623730949-1",
            "the scale factor of the format would change it",
        ),
        ("            15             2", "            15", "part:2: "),
        ("RSA", "XSA", "part:3: `XSA"),
    ] {
        let text = changed(name, from, to);
        assert_refused(HARWELL_BOEING, text, words);
    }
    let huge = changed(
        name,
        "            12            12            31",
        "    2147483647    2147483647    4294967290",
    );
    assert_refused(
        HARWELL_BOEING,
        huge,
        "part:2: 2 lines of pointers are announced",
    );
    let short = "title\n 3 1 1 1 0\nRSA 1 1 1 0\n(I8) (I8) (E20.12)\n       1\n       2\n";
    assert_refused(
        HARWELL_BOEING,
        short,
        "part:2: 1 lines of pointers are announced; 2 of them, 1 a line, take 2",
    );
    let text = changed(
        "ansys/bracket_mass.matrix",
        "241          3240          3240             0",
        "241       3240000       3240000             0",
    );
    let text = text.replacen(
        "3240             0\n(1I14)",
        "3240000             0\n(1I14)",
        1,
    );
    assert_refused(
        HARWELL_BOEING,
        text,
        "240 columns and 3240000 entries are announced, but the file has",
    );
}

#[test]
fn decimal_commas_are_points() {
    let name = "ansys/variants_touching.rsa";
    let text = std::fs::read_to_string(sample(name)).unwrap();
    let head: usize = text.lines().take(4).map(|line| line.len() + 1).sum();
    let text = format!("{}{}", &text[..head], text[head..].replace('.', ","));
    let matrix = read_text(HARWELL_BOEING, text).unwrap();
    assert_same(name, &matrix, &lower(expected("variants.mtx")));
    let both = changed(name, " 5.4142135623730949E+00", " 5.414213562373.949E,00");
    assert_refused(HARWELL_BOEING, both, "expected a finite number");
}

#[test]
fn a_missing_line_shifts_nothing() {
    let text = std::fs::read_to_string(sample("ansys/variants_touching.rsa")).unwrap();
    let without = |number: usize| {
        let lines: Vec<&str> = text
            .lines()
            .enumerate()
            .filter(|(at, _)| *at != number)
            .map(|(_, line)| line)
            .collect();
        lines.join("\n") + "\n"
    };
    for number in 4..text.lines().count() {
        assert!(
            read_text(HARWELL_BOEING, without(number)).is_err(),
            "line {}",
            number + 1
        );
    }
}

#[test]
fn a_large_file_is_read_from_many_blocks() {
    let size = 40_000u32;
    let entries = 2 * size - 1;
    let value = |at: u32| 1.0 + f64::from(at) / 7.0;
    let lines = |numbers: Vec<String>, fields: usize| -> (usize, String) {
        let lines: Vec<String> = numbers
            .chunks(fields)
            .map(|line| line.concat() + "\n")
            .collect();
        (lines.len(), lines.concat())
    };
    let (pointer_lines, pointers) = lines(
        (0..=size)
            .map(|column| format!("{:8}", (2 * column + 1).min(entries + 1)))
            .collect(),
        10,
    );
    let rows = (0..size)
        .flat_map(|column| [column, column + 1])
        .take(entries as usize);
    let (row_lines, rows) = lines(rows.map(|row| format!("{:8}", row + 1)).collect(), 10);
    let (value_lines, values) = lines(
        (0..entries)
            .map(|at| format!("{:>25}", format!("{:.16e}", value(at))))
            .collect(),
        3,
    );
    let head = format!(
        "title\n{} {pointer_lines} {row_lines} {value_lines} 0\nRSA {size} {size} {entries} 0\n(10I8) (10I8) (3E25.16)\n",
        pointer_lines + row_lines + value_lines
    );
    let text = [head, pointers, rows, values].concat();
    let matrix = read_text(HARWELL_BOEING, &text).unwrap();
    let places = stored(&matrix);
    assert_eq!(places.len(), entries as usize);
    for ((row, column), bits) in places {
        let at = 2 * column + (row - column);
        assert_eq!(bits, value(at).to_bits(), "{row} {column}");
    }
    let bad = text.lines().count() - 5;
    let mut lines: Vec<&str> = text.lines().collect();
    lines[bad] = "x";
    assert_refused(
        HARWELL_BOEING,
        lines.join("\n") + "\n",
        &format!("part:{}: `x`; expected a finite number", bad + 1),
    );
}

#[test]
fn cut_off_at_every_64th_byte() {
    damage::cut_off(HARWELL_BOEING, "ansys/bracket_mass.matrix");
    damage::cut_off(HARWELL_BOEING, "ansys/variants_touching.rsa");
    damage::cut_off(HARWELL_BOEING, "ansys/variants_right_hand.rsa");
}

#[test]
fn changed_bytes_do_no_harm() {
    damage::flipped(HARWELL_BOEING, "ansys/bracket_mass.matrix", 600);
    damage::flipped(HARWELL_BOEING, "ansys/variants_touching.rsa", 3000);
    damage::flipped(HARWELL_BOEING, "ansys/variants_right_hand.rsa", 3000);
}
