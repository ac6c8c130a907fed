//! OUTPUT4, binary and ASCII.

use std::path::Path;
use std::time::Instant;

use dcb_import::matrix::nastran::op4;
use dcb_import::stored::{Listed, Rows, StoredMatrix, Triangles};

use crate::support::{Places, Reader, entry_difference, file, full, sample, truth};

const BINARY: Reader = Reader {
    recognises: op4::binary::recognises,
    list: op4::binary::list,
    read: op4::binary::read,
};
const TEXT: Reader = Reader {
    recognises: op4::text::recognises,
    list: op4::text::list,
    read: op4::text::read,
};

/// The reader that recognises a file, which no other one does.
fn reader(path: &Path) -> Reader {
    let bytes = std::fs::read(path).unwrap();
    match ((BINARY.recognises)(&bytes), (TEXT.recognises)(&bytes)) {
        (true, false) => BINARY,
        (false, true) => TEXT,
        both => unreachable!("{}: {both:?}", path.display()),
    }
}

fn read(path: &Path, number: usize) -> StoredMatrix {
    let mut reading = (reader(path).read)(path, &[number]).unwrap();
    assert_eq!(reading.sha256.len(), 64);
    reading.matrices.pop().unwrap()
}

#[test]
fn the_bracket_is_the_same_to_the_last_bit_in_every_layout() {
    let expected = [truth("bracket.mtx"), truth("bracket.mass.mtx")];
    for layout in ["dense_le", "bigmat_be", "nonbigmat_le", "bigmat_ascii"] {
        let path = sample(&format!("nastran/bracket_{layout}.op4"));
        let names: Vec<_> = (reader(&path).list)(&path).unwrap();
        let listed = |name: &str| Listed {
            name: name.into(),
            shape: Some((240, 240)),
            obstacle: None,
        };
        assert_eq!(names, [listed("KGG"), listed("MGG")], "{layout}");
        let reading = (reader(&path).read)(&path, &[1, 0]).unwrap();
        for (matrix, number) in reading.matrices.iter().zip([1, 0]) {
            assert_eq!(matrix.size, 240);
            assert_eq!(
                (matrix.triangles, &matrix.rows),
                (Triangles::Both, &Rows::Unlabelled)
            );
            assert_eq!(matrix.name, ["KGG", "MGG"][number]);
            let digits = layout.ends_with("ascii").then_some(17);
            assert_eq!(matrix.digits, digits, "{layout}");
            assert!(full(matrix) == expected[number], "{layout} {number}");
        }
    }
}

#[test]
fn what_pyyeti_writes_is_read_back_to_the_last_bit_that_it_prints() {
    for (suffix, expected, largest) in [
        ("le", "variants.mtx", 0.0),
        ("be", "variants.mtx", 0.0),
        ("ascii", "variants_tame.mtx", 0.0),
        ("ascii_9", "variants_tame.mtx", 5e-9),
    ] {
        for layout in ["dense", "bigmat", "nonbigmat"] {
            let path = sample(&format!("nastran/variants_{layout}_{suffix}.op4"));
            let listed = (reader(&path).list)(&path).unwrap();
            let obstacles: Vec<_> = listed.iter().map(|one| one.obstacle.as_deref()).collect();
            assert_eq!(
                obstacles,
                [None, Some("rectangular, 30 x 11"), Some("complex"), None]
            );
            let matrix = read(&path, 3);
            let difference =
                entry_difference(&full(&matrix), &truth(&format!("nastran/{expected}")));
            assert!(difference <= largest, "{layout} {suffix}: {difference:e}");
            for refused in [1, 2] {
                let error = (reader(&path).read)(&path, &[3, refused]).unwrap_err();
                let expected = ["30 rows and 11 columns", "`C` is complex"][refused - 1];
                assert!(error.to_string().contains(expected), "{error}");
            }
        }
    }
}

#[test]
fn rows_beyond_65535_make_strings_of_two_integers() {
    for name in ["variants_wide.op4", "variants_wide_ascii.op4"] {
        let matrix = read(&sample(&format!("nastran/{name}")), 0);
        assert_eq!(matrix.size, 70_000);
        assert!(
            full(&matrix) == truth("nastran/variants_wide.mtx"),
            "{name}"
        );
    }
}

#[test]
fn ten_million_rows_in_a_small_file_take_no_memory_for_each() {
    for (layout, sum, sum_of_squares) in [
        ("bigmat", 23.629_690_382_617_884, 15.317_759_502_907_895),
        ("nonbigmat", 23.629_690_382_617_884, 15.317_759_502_907_895),
    ] {
        let path = sample(&format!("nastran/pyyeti/nas_large_dim_{layout}_binary.op4"));
        let start = Instant::now();
        let matrix = read(&path, 2);
        assert!(start.elapsed().as_secs_f64() < 0.1);
        let values: Vec<f64> = full(&matrix)
            .values()
            .map(|bits| f64::from_bits(*bits))
            .collect();
        assert_eq!(
            (matrix.size, values.len(), matrix.digits),
            (10_000_001, 49, None)
        );
        assert!((values.iter().sum::<f64>() - sum).abs() < 1e-13);
        let squares: f64 = values.iter().map(|value| value * value).sum();
        assert!((squares - sum_of_squares).abs() < 1e-13);
    }
}

/// Sum and sum of squares; also of matrices that aren't square.
#[test]
fn every_listed_name_shape_and_type_is_the_references() {
    let reference = std::fs::read(sample("nastran/pyyeti/reference.json")).unwrap();
    let reference: serde_json::Value = serde_json::from_slice(&reference).unwrap();
    for (name, matrices) in reference.as_object().unwrap() {
        let path = sample(&format!("nastran/pyyeti/{name}"));
        let listed = (reader(&path).list)(&path).unwrap();
        let matrices = matrices.as_array().unwrap();
        assert_eq!(listed.len(), matrices.len(), "{name}");
        for (number, (found, expected)) in listed.iter().zip(matrices).enumerate() {
            let shape = (
                expected["shape"][0].as_u64().unwrap(),
                expected["shape"][1].as_u64().unwrap(),
            );
            assert_eq!(found.shape, Some(shape), "{name}");
            let is_complex = expected["type"].as_u64().unwrap() > 2;
            assert_eq!(
                found.obstacle.as_deref() == Some("complex"),
                is_complex,
                "{name}"
            );
            if !name.ends_with("badname.op4") {
                assert_eq!(
                    found.name.to_lowercase(),
                    expected["name"].as_str().unwrap()
                );
            }
            let may_be_read = !is_complex && shape.0 == shape.1;
            let read = (reader(&path).read)(&path, &[number]);
            assert_eq!(read.is_ok(), may_be_read, "{name} {number}: {read:?}");
        }
    }
    let odd = sample("nastran/pyyeti/double_bigmat_ascii_badname.op4");
    let names: Vec<_> = op4::text::list(&odd)
        .unwrap()
        .into_iter()
        .map(|one| one.name)
        .collect();
    assert_eq!(names, ["1MAT", "", "09"]);
}

/// Sizes of 8 characters that touch, and of 16; both widths of columns behind `|I16` (NX writes 8 there); D, small letters, no letter.
#[test]
fn every_spelling_of_ascii_is_understood() {
    let expected = Places::from([
        ((0, 0), 1.5f64.to_bits()),
        ((1, 0), (-0.0f64).to_bits()),
        ((2, 2), 2.5e-310f64.to_bits()),
    ]);
    let narrow = "       3      -3       6       2K\0\0\0\0\0\0\0";
    let wide = "               3              -3       6       2K       ";
    let all_wide = "               3              -3               6               2        ";
    let strings = |width: usize, each: usize| {
        let field = |value: usize| format!("{value:width$}");
        let column = |number, words| [number, 0, words].map(field).concat();
        let string = |length, row| [length, row].map(field).concat();
        let last = [4, 1, 1].map(field).concat();
        format!(
            "{}\n{}\n 1.50000000000D+00-0.00000000000D+00\n{}\n{}\n 2.50000000000-310\n{last}\n 1.00000000000D+00\n",
            column(1, 2 * each + 2),
            string(2 * each + 1, 1),
            column(3, each + 2),
            string(each + 1, 3),
        )
    };
    for (header, width) in [(narrow, 8), (wide, 8), (wide, 16), (all_wide, 16)] {
        for format in ["1P,2D18.11", "1p,2d18.11"] {
            for each in [1, 2] {
                let size = if header == narrow { "" } else { "|I16" };
                let text = format!("{header}{format}{size}\n{}", strings(width, each));
                for text in [
                    text.clone(),
                    text.replace('\n', "\r\n"),
                    text.replace('D', "d"),
                ] {
                    let file = file(text.as_bytes());
                    let matrix = read(file.path(), 0);
                    assert!(full(&matrix) == expected, "{text}");
                    assert_eq!(matrix.digits, Some(12), "{text}");
                    assert_eq!(matrix.name == "K", header != all_wide);
                }
            }
        }
    }
    let touching = "1000000110000001       6       2KGG     1P,3E23.16\n10000002       1       1\n 1.0000000000000000E+00\n";
    let file = file(touching.as_bytes());
    assert_eq!(
        op4::text::list(file.path()).unwrap()[0].shape,
        Some((10_000_001, 10_000_001))
    );
}

/// Dense columns and strings longer than a block of text, so that blocks begin in their middle.
#[test]
fn columns_may_be_longer_than_a_block() {
    let size = 40_000u32;
    let value = |row: u32| {
        if row % 3 == 1 {
            0.0
        } else {
            1.0 / f64::from(row + 1)
        }
    };
    for is_dense in [true, false] {
        let sign = if is_dense { "" } else { "-" };
        let mut text = format!(
            "{size:8}{:>8}       1       2K       1P,3E23.16\n",
            format!("{sign}{size}")
        );
        let mut expected = Places::new();
        for column in [7u32, 9, size] {
            let rows: Vec<u32> = (5..size).collect();
            let mut print = |rows: &[u32]| {
                let mut printed = String::new();
                for line in rows.chunks(3) {
                    for row in line {
                        printed += &fortran(value(*row));
                    }
                    printed.push('\n');
                }
                for &row in rows {
                    if value(row) != 0.0 || !is_dense {
                        expected.insert((row, column - 1), value(row).to_bits());
                    }
                }
                printed
            };
            if is_dense {
                text += &format!("{column:8}{:8}{:8}\n{}", 6, rows.len(), print(&rows));
            } else {
                let strings: Vec<&[u32]> = rows.chunks(11).collect();
                let words: usize = strings.iter().map(|string| 2 + 2 * string.len()).sum();
                text += &format!("{column:8}{:8}{words:8}\n", 0);
                for string in strings {
                    text += &format!(
                        "{:8}{:8}\n{}",
                        2 * string.len() + 1,
                        string[0] + 1,
                        print(string)
                    );
                }
            }
        }
        text += &format!("{:8}{:8}{:8}\n{}\n", size + 1, 1, 1, fortran(2f64.sqrt()));
        let file = file(text.as_bytes());
        assert!(full(&read(file.path(), 0)) == expected, "{is_dense}");
    }
}

/// As `E23.16` prints with `1P`.
fn fortran(value: f64) -> String {
    let printed = format!("{value:.16e}");
    let (mantissa, exponent) = printed.split_once('e').unwrap();
    let exponent: i32 = exponent.parse().unwrap();
    let sign = if exponent < 0 { '-' } else { '+' };
    format!("{mantissa:>19}E{sign}{:02}", exponent.abs())
}

#[test]
fn single_precision_is_told() {
    for is_little in [true, false] {
        let integer = |value: i32| {
            if is_little {
                value.to_le_bytes()
            } else {
                value.to_be_bytes()
            }
        };
        let real = |value: f32| {
            if is_little {
                value.to_le_bytes()
            } else {
                value.to_be_bytes()
            }
        };
        let mut bytes = Vec::new();
        let mut record = |payload: Vec<[u8; 4]>| {
            let length = integer(4 * payload.len() as i32);
            bytes.extend([vec![length], payload, vec![length]].concat().concat());
        };
        record(
            [
                [2, 2, 6, 1].map(integer).to_vec(),
                vec![*b"  1K", *b"\0\0  "],
            ]
            .concat(),
        );
        record(
            [
                [2, 0, 4].map(integer).to_vec(),
                vec![integer((3 << 16) + 1), real(0.1), real(0.0)],
            ]
            .concat(),
        );
        // One word too many is announced.
        let damaged = bytes.clone();
        bytes.truncate(bytes.len() - 32);
        let mut record = |payload: Vec<[u8; 4]>| {
            let length = integer(4 * payload.len() as i32);
            bytes.extend([vec![length], payload, vec![length]].concat().concat());
        };
        record(
            [
                [2, 0, 3].map(integer).to_vec(),
                vec![integer((3 << 16) + 1), real(0.1), real(0.0)],
            ]
            .concat(),
        );
        record([[3, 1, 1].map(integer).to_vec(), vec![real(1.0)]].concat());
        let whole = file(&bytes);
        let matrix = read(whole.path(), 0);
        assert_eq!((matrix.name.as_str(), matrix.digits), ("1K", Some(7)));
        assert!(
            matrix.notes[0].contains("single precision"),
            "{:?}",
            matrix.notes
        );
        let expected = [((0, 1), f64::from(0.1f32).to_bits()), ((1, 1), 0)];
        assert!(full(&matrix) == Places::from(expected));
        let error = op4::binary::read(file(&damaged).path(), &[0]).unwrap_err();
        assert!(error.to_string().contains("announces 4 words"), "{error}");
    }
}

#[test]
fn files_of_two_byte_orders_are_refused() {
    let bytes = |suffix: &str| {
        std::fs::read(sample(&format!("nastran/variants_bigmat_{suffix}.op4"))).unwrap()
    };
    let both = file(&[bytes("le"), bytes("be")].concat());
    for error in [
        op4::binary::list(both.path()).map(drop).unwrap_err(),
        op4::binary::read(both.path(), &[7]).map(drop).unwrap_err(),
    ] {
        assert!(
            error.to_string().contains("the byte order changes here"),
            "{error}"
        );
    }
}

#[test]
fn damaged_files_are_told_by_their_place() {
    let good = std::fs::read_to_string(sample("nastran/variants_bigmat_ascii.op4")).unwrap();
    let lines: Vec<&str> = good.lines().collect();
    // The first column has strings in lines 3, 5, 7, 9, 11 and 13.
    for (line, new, told) in [
        (
            2,
            "       2       0      30",
            ":15: column 2 is 2 words short",
        ),
        (3, "       7      29", "beyond row 30"),
        (
            3,
            "       4       2",
            ":7: a string of column 2 announces 2 words and has 1 numbers",
        ),
        (
            4,
            "-3.7181789790516192E-17",
            ":5: a string of column 2 announces 6 words and has 1 numbers",
        ),
        (
            4,
            "-3.7181789790516192E-17 9.37783705401277x9E-04",
            ":4: ` 9.37783705401277x9E-04`",
        ),
        (
            4,
            "-3.7181789790516192E-17                    NaN",
            "finite",
        ),
        (3, "       5", ":3: `       5`"),
        (
            1,
            "      30     -30       6       9FIRST   1P,3E23.16",
            ":1: ",
        ),
        (
            1,
            "      30     -30       6       2FIRST   1P,3E23,16",
            ":1: ",
        ),
        (2, "      31       0      26", ":3: "),
    ] {
        let mut damaged = lines.clone();
        damaged[line - 1] = new;
        let text = damaged.join("\n") + "\n";
        let error = op4::text::read(file(text.as_bytes()).path(), &[0])
            .unwrap_err()
            .to_string();
        assert!(error.contains(told), "line {line}, `{new}`: {error}");
    }
    let record = std::fs::read(sample("nastran/variants_bigmat_le.op4")).unwrap();
    for (at, told) in [(28, "ends with the length"), (4 + 24 + 4, "announced")] {
        let mut damaged = record.clone();
        damaged[at + 3] ^= 0x40;
        let error = op4::binary::list(file(&damaged).path())
            .unwrap_err()
            .to_string();
        assert!(error.contains(told), "byte {at}: {error}");
    }
}

#[test]
fn cut_off_and_flipped_files_are_refused_or_read() {
    for name in [
        "variants_dense_be",
        "variants_bigmat_le",
        "variants_nonbigmat_le",
        "variants_bigmat_ascii",
        "variants_dense_ascii_9",
        "pyyeti/cdbin",
        "pyyeti/nas_large_dim_bigmat_binary",
    ] {
        let path = sample(&format!("nastran/{name}.op4"));
        let bytes = std::fs::read(&path).unwrap();
        reader(&path).is_cut_off(&bytes);
        reader(&path).is_flipped(&bytes, 700);
    }
}

#[test]
fn sizes_times_a_million_are_refused_at_once() {
    let start = Instant::now();
    let text = std::fs::read_to_string(sample("nastran/variants_nonbigmat_ascii.op4")).unwrap();
    let larger = text.replacen("       2       0      22", "       2       022000000", 1);
    assert!(op4::text::read(file(larger.as_bytes()).path(), &[0]).is_err());
    let mut bytes = std::fs::read(sample("nastran/variants_dense_le.op4")).unwrap();
    let words = u32::from_le_bytes(*bytes[44..].first_chunk().unwrap());
    bytes[44..48].copy_from_slice(&(words * 1_000_000).to_le_bytes());
    assert!(op4::binary::read(file(&bytes).path(), &[0]).is_err());
    assert!(start.elapsed().as_secs_f64() < 0.5);
}

/// Sums by pyyeti of real files. Their first matrices aren't square, so the header is given as many rows as columns; what is stored stays.
#[test]
fn sums_of_real_files_are_those_of_pyyeti() {
    let reference = std::fs::read(sample("nastran/pyyeti/reference.json")).unwrap();
    let reference: serde_json::Value = serde_json::from_slice(&reference).unwrap();
    let mut seen = 0;
    for (name, matrices) in reference.as_object().unwrap() {
        let expected = &matrices[0];
        // With ten million rows its strings would be read as those of a bigmat.
        let changes_strings = name.contains("large_dim_nonbigmat");
        if expected["type"].as_u64().unwrap() > 2 || changes_strings {
            continue;
        }
        seen += 1;
        let mut bytes = std::fs::read(sample(&format!("nastran/pyyeti/{name}"))).unwrap();
        let columns = expected["shape"][1].as_i64().unwrap();
        if name.contains("ascii") {
            let is_bigmat = bytes[8..16].contains(&b'-');
            let rows = if is_bigmat { -columns } else { columns };
            bytes[8..16].copy_from_slice(format!("{rows:8}").as_bytes());
        } else {
            let is_little = bytes[0] > 0;
            let word = if bytes.contains(&48) && bytes[0].max(bytes[3]) == 48 {
                8
            } else {
                4
            };
            let field = &mut bytes[4 + word..4 + 2 * word];
            let is_bigmat = field[if is_little { word - 1 } else { 0 }] & 0x80 > 0;
            let rows = if is_bigmat { -columns } else { columns };
            let written = if is_little {
                rows.to_le_bytes()
            } else {
                rows.to_be_bytes()
            };
            field.copy_from_slice(if is_little {
                &written[..word]
            } else {
                &written[8 - word..]
            });
        }
        let whole = file(&bytes);
        let matrix = full(&read(whole.path(), 0));
        let values = matrix.values().map(|bits| f64::from_bits(*bits));
        let near = |found: f64, key: &serde_json::Value| {
            let expected = key.as_f64().unwrap();
            assert!(
                (found - expected).abs() <= 1e-13 * expected.abs(),
                "{name}: {found} {expected}"
            );
        };
        near(values.clone().sum(), &expected["sum"][0]);
        near(
            values.clone().map(|value| value * value).sum(),
            &expected["sum_of_squares"],
        );
        if !name.contains("dense") {
            assert_eq!(
                matrix.len() as u64,
                expected["nnz"].as_u64().unwrap(),
                "{name}"
            );
        }
    }
    assert_eq!(seen, 11);
}
