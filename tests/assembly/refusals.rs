//! What an assembly refuses, and what it says.

use std::path::Path;

use dcb_formats::assembly::Assembly;
use dcb_formats::component::{Interface, InterfaceKind};
use dcb_samples::bracket;
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

/// The second beam turned by a milliradian about z: its frames meet, and are turned.
#[test]
fn frames_that_are_nearly_aligned_are_told_with_their_angle() {
    let half = 0.5e-3_f64;
    let turned = format!(
        r#""position": [1, 0, 0], "orientation": [{:?}, 0, 0, {:?}]"#,
        half.cos(),
        half.sin()
    );
    let beam = spatial_beam(&SpatialBeam::default());
    let reduced = lowest(&beam, 4);
    let parts = || {
        vec![
            loaded(&beam, reduced.clone(), "f"),
            loaded(&beam, reduced.clone(), "f"),
        ]
    };
    let text = HALVES.replace("\"position\": [1, 0, 0]", &turned);
    let found = put_together(&text, parts(), 4).unwrap();
    let angle = found.report.meetings[0].angle.unwrap();
    assert!((angle - 1e-3).abs() < 1e-9, "{angle:e}");
    let warnings = found.report.warnings();
    assert!(
        warnings
            .iter()
            .any(|warning| warning.contains("turned by 1.0e-3 rad against each other")),
        "{warnings:?}"
    );
    // Turned on purpose, as an elbow is.
    let elbow = HALVES.replace(
        "\"position\": [1, 0, 0]",
        r#""position": [1, 0, 0], "orientation": [0.8, 0, 0, 0.6]"#,
    );
    let found = put_together(&elbow, parts(), 4).unwrap();
    assert!(
        found.report.warnings().is_empty(),
        "{:?}",
        found.report.warnings()
    );
    // Both: a gap is refused with the angle beside it.
    let both = text.replace("[1, 0, 0]", "[1.001, 0, 0]");
    let message = put_together(&both, parts(), 4).unwrap_err().to_string();
    assert!(
        message.contains("1.000000e-3 m apart")
            && message.contains("frames are turned by 1.0e-3 rad against each other"),
        "{message}"
    );
}

/// A frame that carries nodes: inside of them it meets them, away from them it doesn't.
#[test]
fn a_frame_away_from_the_nodes_that_it_carries_is_refused() {
    let block = bracket(1).changed(|draft| {
        let tip = draft.interfaces.pop().unwrap();
        draft.interfaces.push(Interface {
            kind: InterfaceKind::Nodes,
            position: None,
            ..tip
        });
    });
    let block = block.unwrap();
    let tip = bracket(1).interfaces[1].position.unwrap();
    let reduced = lowest(&block, 4);
    let joined = |z: f64| {
        let text = format!(
            r#"{{"dimension": 3, "units": {{"length": "m", "mass": "kg", "time": "s"}},
              "bodies": {{"part": {{"superelement": "part.dcb.h5"}},
                          "plate": {{"rigid": {{"mass": 1, "inertia": [1e-3, 1e-3, 1e-3], "points": {{"p": [0, 0, 0]}}}}, "position": [{:?}, {:?}, {z:?}]}}}},
              "joints": {{"weld": {{"fixed": {{"a": "part/tip", "b": "plate/p"}}}}}},
              "interfaces": {{"wall": "part/wall"}}}}"#,
            tip[0], tip[1]
        );
        put_together(
            &text,
            vec![loaded(&block, reduced.clone(), "part"), None],
            4,
        )
    };
    let found = joined(0.004).unwrap();
    assert_eq!(found.report.meetings[0].gap, 0.0);
    let message = joined(1.0).unwrap_err().to_string();
    // The nodes are within 16.2 mm of the middle of the end.
    assert!(
        message.contains("joints.weld.fixed") && message.contains("don't meet: they are 9.83"),
        "{message}"
    );
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
