//! What an assembly refuses, and what it says.

use std::path::Path;

use dcb_formats::assembly::Assembly;
use dcb_samples::spatial_beam::{SpatialBeam, spatial_beam};
use dcb_tests::lowest;

use crate::{loaded, put_together};

const HALVES: &str = r#"{"dimension": 3, "units": {"length": "m", "mass": "kg", "time": "s"},
  "bodies": {"first": {"superelement": "f.dcb.h5"}, "second": {"superelement": "s.dcb.h5", "position": [1, 0, 0]}},
  "joints": {"weld": {"fixed": {"a": "first/b", "b": "second/a"}}},
  "interfaces": {"a": "first/a", "b": "second/b"}}"#;

fn refused(text: &str) -> String {
    let beam = spatial_beam(&SpatialBeam::default());
    let reduced = lowest(&beam, 4);
    let parts = vec![
        loaded(&beam, reduced.clone(), "f"),
        loaded(&beam, reduced, "f"),
    ];
    let error = put_together(text, parts, 4).unwrap_err();
    assert!(error.is_unusable_input(), "{error}");
    error.to_string()
}

#[test]
fn places_that_do_not_fit() {
    for (from, to, told) in [
        (
            "[1, 0, 0]",
            "[1.001, 0, 0]",
            "don't meet: they are 1.000000e-3 m apart",
        ),
        ("[1, 0, 0]", "[0, 0, 0]", "which is the same file"),
        (
            "\"first/b\"",
            "\"first/c\"",
            "has no interface \"c\" (there are: a, b)",
        ),
        ("\"second/b\"", "\"second/d\"", "has no interface \"d\""),
        (
            r#"{"weld": {"fixed": {"a": "first/b", "b": "second/a"}}}"#,
            "{}",
            "isn't one body: 6 motion(s)",
        ),
        (
            r#"{"weld": {"fixed""#,
            r#"{"pin": {"spherical": {"a": "ground", "b": "first/a"}}, "weld": {"fixed""#,
            "held in part: 3 of 6",
        ),
        (
            r#""fixed": {"a""#,
            r#""spherical": {"a""#,
            "isn't one body: 3 motion(s)",
        ),
    ] {
        let text = HALVES.replace(from, to);
        assert_ne!(text, HALVES);
        let message = refused(&text);
        assert!(message.contains(told), "{message}");
    }
}

#[test]
fn a_gap_is_bridged_where_that_is_asked_for() {
    let beam = spatial_beam(&SpatialBeam::default());
    let reduced = lowest(&beam, 4);
    let parts = vec![
        loaded(&beam, reduced.clone(), "f"),
        loaded(&beam, reduced, "f"),
    ];
    let text = HALVES
        .replace("[1, 0, 0]", "[1.001, 0, 0]")
        .replace("\"interfaces\"", "\"allow_gap\": 0.01, \"interfaces\"");
    let found = put_together(&text, parts, 4).unwrap();
    assert!((found.report.meetings[0].gap - 1e-3).abs() < 1e-12);
    assert!(found.report.warnings()[0].contains("joined by a rigid link"));
    // A rigid motion of all still meets no force: the tensor is that of two beams a millimetre apart.
    assert!(found.report.is_free);
}

#[test]
fn files_that_are_no_assembly() {
    for (text, told) in [
        ("", "EOF"),
        ("[]", "expected"),
        (r#"{"dimension": 3}"#, "units"),
        (&HALVES.replace("\"joints\"", "\"drives\""), "drives"),
        (
            &HALVES.replace("\"first/b\", ", "\"first\", "),
            "a place on it is needed",
        ),
        (
            &HALVES.replace("\"second/b\"", "\"first/a\""),
            "is interface \"a\" already",
        ),
        (
            &HALVES.replace(r#""position": [1, 0, 0]"#, r#""position": [1, 0]"#),
            "has 2 components, expected 3",
        ),
        (
            &HALVES.replace(r#""position": [1, 0, 0]"#, r#""velocity": [1, 0, 0]"#),
            "velocity",
        ),
        (
            &HALVES.replace(
                "\"interfaces\": {\"a\": \"first/a\", \"b\": \"second/b\"}",
                "\"interfaces\": {}",
            ),
            "Name at least one",
        ),
    ] {
        let message = Assembly::parse(text, Path::new("machine.json"))
            .unwrap_err()
            .to_string();
        assert!(
            message.starts_with("machine.json") && message.contains(told),
            "{message}"
        );
    }
}
