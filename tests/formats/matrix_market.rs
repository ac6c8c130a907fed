//! The Matrix Market reader against the conformance set, and the facts a reader of K and M has to get right.

use std::collections::BTreeMap;
use std::io::Write;
use std::path::{Path, PathBuf};

use dcb_formats::matrix::{MatrixReport, read_matrix, read_symmetric_operator};
use dcb_formats::{Error, SparseMatrix};
use dcb_samples::PseudoRandom;
use serde_json::Value;

fn conformance_folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../tests/data/matrix-market-conformance")
}

/// Files of `cpp/` and `py/` that fast_matrix_market reads and we refuse on purpose.
const REFUSED_THOUGH_READ_ELSEWHERE: [(&str, &str); 3] = [
    (
        "py/matrix_coordinate_real_general.mtx.bz2",
        "bzip2 is refused by name; gzip is the compressed form",
    ),
    (
        "py/matrix_coordinate_real_skew-symmetric.mtx",
        "a skew-symmetric matrix with (3, 3) = 30 contradicts its banner",
    ),
    (
        "py/scipy_crashes/dim_over_32_bit.mtx",
        "2^40 rows in a file of 120 bytes: beyond 32-bit indices, 8 TiB of column pointers",
    ),
];

struct Scratch(tempfile::TempDir);

impl Scratch {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn file(&self, name: &str, bytes: impl AsRef<[u8]>) -> PathBuf {
        let path = self.0.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        path
    }
}

pub fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

fn dense(matrix: &SparseMatrix) -> Vec<Vec<f64>> {
    let mut rows = vec![vec![0.0; matrix.ncols()]; matrix.nrows()];
    for entry in matrix.triplet_iter() {
        rows[entry.row][entry.col] = *entry.val;
    }
    rows
}

/// Pattern and values, values as bits.
fn bits(matrix: &SparseMatrix) -> (Vec<u32>, Vec<u32>, Vec<u64>) {
    let values = matrix.val().iter().map(|value| value.to_bits()).collect();
    (
        matrix.symbolic().col_ptr().to_vec(),
        matrix.symbolic().row_idx().to_vec(),
        values,
    )
}

fn assert_exactly_symmetric(matrix: &SparseMatrix) {
    let transpose = matrix.transpose().to_col_major().unwrap();
    assert_eq!(bits(matrix), bits(&transpose));
}

fn refusal_of(text: impl AsRef<[u8]>) -> String {
    let scratch = Scratch::new();
    let path = scratch.file("k.mtx", text);
    let error = read_symmetric_operator(&path).expect_err("expected a refusal");
    error
        .to_string()
        .replace(&path.display().to_string(), "k.mtx")
}

fn read_text(text: impl AsRef<[u8]>) -> (SparseMatrix, MatrixReport) {
    read_symmetric_operator(&Scratch::new().file("k.mtx", text)).unwrap()
}

/// The numbers of a `dense` field; `None` where they are complex or not finite.
fn finite_real(value: &Value) -> Option<Vec<Vec<f64>>> {
    let row = |row: &Value| row.as_array()?.iter().map(Value::as_f64).collect();
    value.as_array()?.iter().map(row).collect()
}

/// What is wrong with our reading of a file of `own/`, if anything.
fn complaint_by_policy(name: &str, path: &Path, expectation: &Value) -> Option<String> {
    let read = read_matrix(path);
    let operator = read_symmetric_operator(path);
    let policy = expectation["policy"].as_str()?;
    let fits = match policy {
        "ok" => read.is_ok(),
        // Refused as K or M only: a pattern is a fine boundary localization.
        "error" if name == "own/pattern_for_real_use.mtx" => read.is_ok() && operator.is_err(),
        "error" => read.is_err() && operator.is_err(),
        "ok-or-error" => true,
        _ => false,
    };
    let wanted = finite_real(&expectation["dense"]);
    let same = [&read, &operator]
        .into_iter()
        .flatten()
        .all(|(matrix, _)| wanted.as_ref().is_none_or(|w| *w == dense(matrix)));
    (!fits || !same).then(|| format!("{name}: policy {policy}, {read:?}"))
}

/// What is wrong with our reading of a file of `cpp/` or `py/`, if anything.
fn complaint_by_comparison(name: &str, path: &Path, expectation: &Value) -> Option<String> {
    let is_exception = REFUSED_THOUGH_READ_ELSEWHERE
        .iter()
        .any(|(exception, _)| *exception == name);
    // Without a dense listing the matrix is large, but real.
    let is_real_and_finite = expectation
        .get("dense")
        .is_none_or(|values| finite_real(values).is_some());
    let should_read = expectation["fmm"] == "ok" && is_real_and_finite && !is_exception;
    match read_matrix(path) {
        Err(error) => should_read.then(|| format!("{name}: refused: {error}")),
        Ok(_) if !should_read => Some(format!("{name}: read, but should be refused")),
        Ok((matrix, _)) => {
            let shape = [matrix.nrows(), matrix.ncols()];
            let same_shape = expectation["shape"] == serde_json::json!(shape);
            let wanted = expectation.get("dense").and_then(finite_real);
            let same = same_shape && wanted.is_none_or(|wanted| wanted == dense(&matrix));
            (!same).then(|| format!("{name}: other values"))
        }
    }
}

#[test]
fn conformance_set() {
    let folder = conformance_folder();
    let text = std::fs::read_to_string(folder.join("expected.json")).unwrap();
    let expected: BTreeMap<String, Value> = serde_json::from_str(&text).unwrap();
    assert!(expected.len() > 140, "{} files", expected.len());
    for (exception, _) in REFUSED_THOUGH_READ_ELSEWHERE {
        assert_eq!(
            expected[exception]["fmm"], "ok",
            "{exception} is no exception"
        );
    }
    let complaints: Vec<String> = expected
        .iter()
        .filter_map(|(name, expectation)| {
            let path = folder.join(name);
            assert!(path.is_file(), "{name} is missing");
            if expectation.get("policy").is_some() {
                complaint_by_policy(name, &path, expectation)
            } else {
                complaint_by_comparison(name, &path, expectation)
            }
        })
        .collect();
    assert!(complaints.is_empty(), "{}", complaints.join("\n"));
}

#[test]
fn what_the_policy_leaves_open_is_read() {
    for name in [
        "upper_triangle_symmetric",
        "comment_in_body",
        "lower_case_banner",
        "fortran_d_exponent",
        "bom_utf8",
        "gz_named_mtx",
    ] {
        let read = read_matrix(&conformance_folder().join("own").join(format!("{name}.mtx")));
        assert!(read.is_ok(), "{name}: {read:?}");
    }
}

const LOWER: &str =
    "%%MatrixMarket matrix coordinate real symmetric\n3 3 5\n1 1 4\n2 1 -1\n2 2 4\n3 2 -2\n3 3 5\n";

#[test]
fn same_matrix_through_every_variant() {
    let scratch = Scratch::new();
    let general = "%%MatrixMarket matrix coordinate real general\n3 3 7\n1 1 4\n2 1 -1\n1 2 -1\n2 2 4\n3 2 -2\n2 3 -2\n3 3 5\n";
    let array = "%%MatrixMarket matrix array real general\n3 3\n4\n-1\n0\n-1\n4\n-2\n0\n-2\n5\n";
    let lower_array = "%%MatrixMarket matrix array real symmetric\n3 3\n4\n-1\n0\n4\n-2\n5\n";
    let (first, second) = LOWER.split_at(60);
    let variants: [(&str, Vec<u8>); 13] = [
        (
            "upper",
            LOWER
                .replace("2 1 -1", "1 2 -1")
                .replace("3 2 -2", "2 3 -2")
                .into(),
        ),
        ("mixed_triangles", LOWER.replace("2 1 -1", "1 2 -1").into()),
        ("general", general.into()),
        ("integer", LOWER.replace("real", "integer").into()),
        ("array", array.into()),
        ("lower_array", lower_array.into()),
        ("crlf", LOWER.replace('\n', "\r\n").into()),
        (
            "blanks",
            LOWER
                .replace("2 1 -1", "\n  \n% remark\n  2\t 1  -1.0D+00  ")
                .into(),
        ),
        ("no_final_newline", LOWER.trim_end().into()),
        ("byte_order_mark", format!("\u{feff}{LOWER}").into()),
        ("gz", gzip(LOWER.as_bytes())),
        (
            "gz_two_members",
            [gzip(first.as_bytes()), gzip(second.as_bytes())].concat(),
        ),
        (
            "duplicates",
            LOWER
                .replace("3 3 5\n1 1 4", "3 3 7\n1 1 3\n2 1 0\n1 1 1")
                .into(),
        ),
    ];
    let (reference, report) = read_symmetric_operator(&scratch.file("lower.mtx", LOWER)).unwrap();
    assert_eq!(
        (report.rows, report.columns, report.stored_entries),
        (3, 3, 5)
    );
    assert_eq!(report.file_name, "lower.mtx");
    assert_eq!(
        report.sha256, "7cc38ced4945ab872a5d2eeb473b23826007e593a8ef03fc897d492b4339e4c4",
        "sha256sum of the same bytes"
    );
    assert_exactly_symmetric(&reference);
    for (name, bytes) in variants {
        let path = scratch.file(name, bytes);
        for (matrix, _) in [
            read_symmetric_operator(&path).unwrap(),
            read_matrix(&path).unwrap(),
        ] {
            assert_eq!(bits(&matrix), bits(&reference), "{name}");
        }
    }
}

#[test]
fn skew_files_are_expanded_with_the_opposite_sign() {
    let text = "%%MatrixMarket matrix coordinate real skew-symmetric\n3 3 2\n2 1 -1\n2 3 4\n";
    let (matrix, _) = read_matrix(&Scratch::new().file("skew.mtx", text)).unwrap();
    assert_eq!(
        dense(&matrix),
        [[0.0, 1.0, 0.0], [-1.0, 0.0, 4.0], [0.0, -4.0, 0.0]]
    );
}

#[test]
fn duplicates_and_zeros_are_counted() {
    let text = "%%MatrixMarket matrix coordinate real symmetric\n2 2 6\n1 1 1\n2 1 .5\n1 1 2\n2 1 .5\n2 2 0\n2 1 1e-1\n";
    let (matrix, report) = read_text(text);
    assert_eq!(dense(&matrix), [[3.0, 1.1], [1.1, 0.0]]);
    assert_eq!(
        (
            report.stored_entries,
            report.duplicates_summed,
            report.explicit_zeros
        ),
        (6, 3, 1)
    );
    assert_eq!(matrix.compute_nnz(), 4, "the zero stays in the pattern");
    let infinite =
        "%%MatrixMarket matrix coordinate real general\n2 2 2\n2 1 1.7e308\n2 1 1.7e308\n";
    assert_eq!(
        refusal_of(infinite),
        "k.mtx: the duplicates of (2, 1) add up to something infinite"
    );
}

/// Unsorted entries below the diagonal, most of them duplicates whose sum depends on the order.
fn disorderly(entry_count: usize, size: usize) -> String {
    let mut random = PseudoRandom::new(7);
    let mut text =
        format!("%%MatrixMarket matrix coordinate real symmetric\n{size} {size} {entry_count}\n");
    for _ in 0..entry_count {
        let column = random.below(size - 1) + 1;
        let row = column + 1 + random.below(size - column);
        let value = (random.below(2_000_001) as f64 - 1e6) * 1.1f64.powi(random.below(200) as i32);
        text += &format!("{row} {column} {value:e}\n");
    }
    text
}

#[test]
fn result_does_not_depend_on_the_number_of_threads() {
    let scratch = Scratch::new();
    let path = scratch.file("k.mtx", disorderly(200_000, 300));
    let read_with = |thread_count| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(thread_count)
            .build()
            .unwrap();
        pool.install(|| read_symmetric_operator(&path)).unwrap()
    };
    let (reference, report) = read_with(1);
    assert!(report.duplicates_summed > 100_000);
    assert_exactly_symmetric(&reference);
    for thread_count in [2, 3] {
        let (matrix, other_report) = read_with(thread_count);
        assert_eq!(bits(&matrix), bits(&reference));
        assert_eq!(other_report, report);
    }
    // Independent of the assembly: sums in file order.
    let mut sums = BTreeMap::<(usize, usize), f64>::new();
    for line in std::fs::read_to_string(&path).unwrap().lines().skip(2) {
        let words: Vec<&str> = line.split(' ').collect();
        let index = |word: &str| word.parse::<usize>().unwrap() - 1;
        let value: f64 = words[2].parse().unwrap();
        sums.entry((index(words[0]), index(words[1])))
            .and_modify(|sum| *sum += value)
            .or_insert(value);
    }
    assert_eq!(report.stored_entries - report.duplicates_summed, sums.len());
    assert_eq!(reference.compute_nnz(), 2 * sums.len());
    for entry in reference.triplet_iter() {
        let place = (entry.row.max(entry.col), entry.row.min(entry.col));
        assert_eq!(entry.val.to_bits(), sums[&place].to_bits());
    }
}

#[test]
fn lines_are_right_far_into_a_large_file() {
    let mut lines: Vec<String> = disorderly(200_000, 300)
        .lines()
        .map(str::to_owned)
        .collect();
    lines.insert(1000, "% a remark".into());
    lines.insert(2000, String::new());
    assert!(
        lines.iter().map(String::len).sum::<usize>() > 3 << 20,
        "several chunks"
    );
    let with = |number: usize, line: &str| {
        let mut lines = lines.clone();
        lines[number - 1] = line.into();
        refusal_of(lines.join("\n") + "\n")
    };
    assert_eq!(
        with(180_001, "301 7 1.0"),
        "k.mtx:180001: row 301 exceeds the announced 300 rows"
    );
    assert_eq!(
        with(150_002, "30 7 1.0x"),
        "k.mtx:150002: `1.0x`; expected a number"
    );
    let extra = [lines.clone(), vec!["1 1 1".into(), "junk".into()]]
        .concat()
        .join("\n");
    assert_eq!(
        refusal_of(extra),
        "k.mtx:200005: one entry more than the 200000 announced in line 2"
    );
    let missing = lines[..190_000].join("\n") + "\n\n";
    assert_eq!(
        refusal_of(missing),
        "k.mtx:190000: the file ends after 189996 entries; line 2 announces 200000"
    );
    // Rows beyond 300 hold nothing but this pair, its halves far apart.
    let mut both: Vec<String> = lines
        .iter()
        .map(|line| line.replace("300 300 ", "302 302 "))
        .collect();
    both[5] = "301 302 1".into();
    both[170_000] = "302 301 1".into();
    assert_eq!(
        refusal_of(both.join("\n") + "\n"),
        "k.mtx:170001: (302, 301) and (301, 302) are both stored, but the banner promises one triangle; \
         expected `general` in the banner or one of them"
    );
}

#[test]
fn bad_lines_name_found_and_expected() {
    let body = |line: &str| {
        refusal_of(format!(
            "%%MatrixMarket matrix coordinate real general\n% c\n3 3 1\n{line}\n"
        ))
    };
    for (line, message) in [
        ("0 1 1", "row 0; rows are counted from 1"),
        ("1 4 1", "column 4 exceeds the announced 3 columns"),
        ("-1 1 1", "`-1`; expected a row from 1 to 3"),
        (
            "1.0 1 1",
            "`.0` after an index; expected a blank, then a column",
        ),
        (
            "99999999999999999999 1 1",
            "row `99999999999999999999` exceeds the announced 3 rows",
        ),
        ("1 1", "the line ends; expected a value"),
        ("1", "the line ends; expected a column"),
        ("1 1 nan", "value `nan`; expected a finite number"),
        ("1 1 -inf", "value `-inf`; expected a finite number"),
        ("1 1 1e999", "value `1e999`; expected a finite number"),
        ("1 1 1.5+100", "`1.5+100`; expected a number"),
        ("1 1 0x10", "`0x10`; expected a number"),
        (
            "1 1 1,5",
            "`1,5`; expected a number with a decimal point, not a comma",
        ),
        (
            "1 1 1 7",
            "`7` after the entry; expected the end of the line",
        ),
    ] {
        assert_eq!(body(line), format!("k.mtx:4: {message}"));
    }
}

#[test]
fn what_cannot_be_stiffness_or_mass_is_refused() {
    let expected = "a stiffness or mass matrix has to be real and symmetric";
    for (words, sizes, message) in [
        (
            "matrix coordinate pattern symmetric",
            "3 3 0",
            format!("1: a pattern without values; {expected}"),
        ),
        (
            "matrix coordinate real skew-symmetric",
            "3 3 0",
            format!("1: a skew-symmetric matrix; {expected}"),
        ),
        (
            "matrix coordinate real hermitian",
            "3 3 0",
            format!("1: a hermitian matrix; {expected}"),
        ),
        (
            "matrix coordinate real general",
            "3 4 0",
            format!("2: 3 rows and 4 columns; {expected}"),
        ),
        (
            "vector coordinate real general",
            "3 0",
            format!("2: a vector; {expected}"),
        ),
        (
            "matrix coordinate real symmetric",
            "3 4 0",
            "2: 3 rows and 4 columns in a symmetric matrix".into(),
        ),
        (
            "matrix coordinate complex symmetric",
            "3 3 0",
            "1: complex values; expected real ones (`real`, `integer` or `pattern`)".into(),
        ),
    ] {
        assert_eq!(
            refusal_of(format!("%%MatrixMarket {words}\n{sizes}\n")),
            format!("k.mtx:{message}")
        );
    }
}

#[test]
fn rounding_asymmetry_is_averaged_and_reported() {
    let text = "%%MatrixMarket matrix coordinate real general\n3 3 7\n1 1 8e9\n2 2 2e9\n3 3 1\n1 2 1.1e-7\n\
                2 3 -1.0\n3 2 -1.000000001\n3 1 3e-7\n";
    let (matrix, report) = read_text(text);
    assert_exactly_symmetric(&matrix);
    let dense = dense(&matrix);
    assert_eq!(dense[0], [8e9, 0.5 * 1.1e-7, 0.5 * 3e-7]);
    assert_eq!(dense[1][2], -0.5 * (1.0 + 1.000000001));
    // (3, 2): 1e-9 over √(2e9 · 1); (3, 1): 3e-7 against nothing, over √(8e9 · 1).
    let expected = (1e-9 / 2e9f64.sqrt()).max(3e-7 / 8e9f64.sqrt());
    assert!(
        (report.largest_asymmetry / expected - 1.0).abs() < 1e-12,
        "{:e}",
        report.largest_asymmetry
    );
}

#[test]
fn averaging_completes_the_pattern_whatever_the_number_of_threads() {
    let size = 2000;
    let mut random = PseudoRandom::new(11);
    let mut lines = BTreeMap::new();
    for _ in 0..60_000 {
        let (row, column) = (1 + random.below(size), 1 + random.below(size));
        let value = 1.0 + random.below(1000) as f64;
        let is_pair = value > 300.0;
        // Alone in its pair, an entry has to be rounding beside the diagonal.
        let scale = if is_pair { 1.0 } else { 1e-9 };
        if row != column && !lines.contains_key(&(column, row)) {
            lines.insert((row, column), scale * value);
            if is_pair {
                lines.insert((column, row), scale * value * (1.0 + 1e-12 * value));
            }
        }
    }
    lines.extend((1..=size).map(|place| ((place, place), 1e4)));
    let mut text = format!(
        "%%MatrixMarket matrix coordinate real general\n{size} {size} {}\n",
        lines.len()
    );
    for ((row, column), value) in &lines {
        text += &format!("{row} {column} {value:e}\n");
    }
    let scratch = Scratch::new();
    let path = scratch.file("k.mtx", text);
    let mut expected = BTreeMap::new();
    for (&(row, column), a) in &lines {
        let b = lines.get(&(column, row)).copied().unwrap_or(0.0);
        let mean = if *a == b { b } else { 0.5 * a + 0.5 * b };
        expected.insert((column - 1, row - 1), mean);
        expected.insert((row - 1, column - 1), mean);
    }
    for thread_count in [1, 2, 3] {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(thread_count)
            .build()
            .unwrap();
        let (matrix, _) = pool.install(|| read_symmetric_operator(&path)).unwrap();
        let found: BTreeMap<_, _> = matrix
            .triplet_iter()
            .map(|entry| ((entry.row, entry.col), *entry.val))
            .collect();
        assert!(found == expected, "{thread_count} threads");
    }
}

#[test]
fn real_asymmetry_is_refused_with_the_worst_pair() {
    let text = "%%MatrixMarket matrix coordinate real general\n3 3 7\n1 1 4\n2 2 4\n3 3 4\n1 2 1\n2 1 1.001\n1 3 1\n3 1 1.5\n";
    assert_eq!(
        refusal_of(text),
        "k.mtx: not symmetric: (3, 1) is 1.5e0, but (1, 3) is 1e0, the worst pair; \
         relative difference 1.2e-1, expected at most 1e-8"
    );
    let (matrix, report) = read_matrix(&Scratch::new().file("l_b.mtx", text)).unwrap();
    assert_eq!(
        (dense(&matrix)[2][0], report.largest_asymmetry),
        (1.5, 0.0),
        "as any matrix it is read as it is"
    );
}

#[test]
fn announced_sizes_do_not_allocate() {
    let entries = refusal_of(
        "%%MatrixMarket matrix coordinate real general\n3 3 9000000000000000000\n1 1 1\n",
    );
    assert_eq!(
        entries,
        "k.mtx:3: the file ends after 1 entries; line 2 announces 9000000000000000000"
    );
    let sizes = refusal_of(
        "%%MatrixMarket matrix coordinate real general\n2000000000 2000000000 1\n1 1 1\n",
    );
    assert!(
        sizes.contains("announced by a file of 76 bytes; at most 16777216 are plausible"),
        "{sizes}"
    );
    let beyond = refusal_of(
        "%%MatrixMarket matrix coordinate real general\n4000000000 4000000000 1\n1 1 1\n",
    );
    assert!(
        beyond.contains("at most 2147483647 are supported"),
        "{beyond}"
    );
    let array = refusal_of("%%MatrixMarket matrix array real general\n16000000 16000000\n1\n");
    assert!(
        array.contains("the file ends after 1 entries; line 2 announces 256000000000000"),
        "{array}"
    );
}

#[test]
fn matrices_without_rows_or_columns_are_empty_or_refused_by_line() {
    let fields = ["real", "double", "integer", "pattern", "complex"];
    let symmetries = ["general", "symmetric", "skew-symmetric", "hermitian"];
    let sizes = [[0, 0], [0, 3], [3, 0], [15, 0], [1, 0], [0, 1]];
    let bodies = ["", "1\n", "1\n2\n3\n", "1 1 1\n", "0 0 0\n", "1 1\n"];
    let (mut empty_count, mut refused_count) = (0, 0);
    for object in ["matrix", "vector"] {
        for layout in ["array", "coordinate"] {
            for (field, symmetry) in fields.iter().flat_map(|f| symmetries.map(|s| (f, s))) {
                for ([rows, columns], body) in sizes.iter().flat_map(|s| bodies.map(|b| (s, b))) {
                    let size = match (object, layout) {
                        ("matrix", "array") => format!("{rows} {columns}"),
                        ("matrix", _) => format!("{rows} {columns} 0"),
                        (_, "array") => "0".into(),
                        _ => format!("{rows} 0"),
                    };
                    let text = format!(
                        "%%MatrixMarket {object} {layout} {field} {symmetry}\n{size}\n{body}"
                    );
                    let scratch = Scratch::new();
                    match read_matrix(&scratch.file("k.mtx", &text)) {
                        Ok((matrix, report)) => {
                            assert!(body.is_empty(), "{text}");
                            assert_eq!((report.stored_entries, matrix.compute_nnz()), (0, 0));
                            empty_count += 1;
                        }
                        Err(error) => {
                            assert!(matches!(error, Error::Line { .. }), "{text}: {error}");
                            refused_count += 1;
                        }
                    }
                }
            }
        }
    }
    assert!(
        empty_count > 50 && refused_count > 1000,
        "{empty_count} {refused_count}"
    );
    assert_eq!(
        refusal_of("%%MatrixMarket matrix array real general\n15 0\n1\n"),
        "k.mtx:2: 15 rows and 0 columns; a stiffness or mass matrix has to be real and symmetric"
    );
}

#[test]
fn files_that_are_something_else_are_named() {
    for (text, start) in [
        ("", "k.mtx:1: empty file; expected a Matrix Market banner"),
        ("*HEADING\n", "k.mtx:1: `*HEADING`; expected the banner"),
        (
            "%%MatrixMarket matrix coordinate real general\r3 3 0\r",
            "k.mtx:1: lines end with a bare carriage return",
        ),
    ] {
        let message = refusal_of(text);
        assert!(message.starts_with(start), "{message}");
    }
}

#[test]
fn damaged_gzip_and_unreadable_paths_are_errors() {
    let packed = gzip(disorderly(20_000, 100).as_bytes());
    let mut corrupt = packed.clone();
    corrupt[packed.len() / 2] ^= 0x55;
    for bytes in [
        &packed[..packed.len() / 2],
        &corrupt,
        &[&packed[..], b"trailing"].concat(),
    ] {
        let message = refusal_of(bytes);
        assert!(
            message.starts_with("k.mtx: gzip data damaged or cut off after"),
            "{message}"
        );
    }
    let scratch = Scratch::new();
    assert!(matches!(
        read_matrix(scratch.0.path()),
        Err(Error::Io { .. })
    ));
    assert!(matches!(
        read_matrix(&scratch.0.path().join("absent.mtx")),
        Err(Error::Io { .. })
    ));
}

#[test]
fn mutated_files_never_panic() {
    let originals = [
        "own/tabs_and_spaces.mtx",
        "own/array_symmetric.mtx",
        "own/number_forms.mtx",
        "own/gz_single.mtx.gz",
        "cpp/vector_array.mtx",
        "cpp/symmetry_array/array_skew-symmetric.mtx",
    ];
    let scratch = Scratch::new();
    let path = scratch.0.path().join("mutated.mtx");
    let mut random = PseudoRandom::new(2024);
    let alphabet = b"0123456789 \t\n\r.+-eEdD%xXniaf,\0\xff";
    let mut read_count = 0;
    for name in originals {
        let original = std::fs::read(conformance_folder().join(name)).unwrap();
        for _ in 0..1500 {
            let mut bytes = original.clone();
            for _ in 0..=random.below(3) {
                let at = random.below(bytes.len());
                let byte = alphabet[random.below(alphabet.len())];
                match random.below(8) {
                    0..=2 => bytes[at] = byte,
                    3..=4 => bytes.insert(at, byte),
                    5..=6 if bytes.len() > 1 => drop(bytes.remove(at)),
                    _ => bytes.truncate(at.max(1)),
                }
            }
            std::fs::write(&path, &bytes).unwrap();
            read_count += usize::from(read_matrix(&path).is_ok());
            if let Ok((matrix, _)) = read_symmetric_operator(&path) {
                assert_exactly_symmetric(&matrix);
            }
        }
    }
    assert!(read_count > 100, "{read_count} mutations left a valid file");
}
