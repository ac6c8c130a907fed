//! The start: rough drawings are closed, held bodies stay, and what moved is told.

use std::f64::consts::PI;

use dcb_runtime::{Error, Mechanism};
use serde_json::{Value, json};

use super::parts::{Folder, rigid_scene, scene_text};

/// A slider-crank with lengths 0.15 and 0.3, the crank at 0.6 rad, drawn off by a tenth of its size.
fn rough() -> Value {
    scene_text(
        2,
        json!({
            "bodies": {
                "crank": {"rigid": {"mass": 0.1, "inertia": 1e-4, "points": {"axle": [0, 0], "pin": [0.15, 0]}}, "position": [0.02, -0.01], "orientation": 0.6},
                "rod": {"rigid": {"mass": 0.1, "inertia": 1e-3, "center_of_mass": [0.15, 0], "points": {"a": [0, 0], "b": [0.3, 0]}}, "position": [0.16, 0.06], "orientation": -0.2},
                "slider": {"rigid": {"mass": 0.05, "inertia": 1e-5, "points": {"pin": [0, 0]}}, "position": [0.45, 0.03], "orientation": 0.1}
            },
            "joints": {
                "axle": {"revolute": {"a": "ground", "b": "crank/axle"}},
                "wrist": {"revolute": {"a": "crank/pin", "b": "rod/a"}},
                "pin": {"revolute": {"a": "rod/b", "b": "slider/pin"}},
                "guide": {"point_on_line": {"a": "ground", "b": "slider/pin", "axis": [1, 0]}}
            },
            "outputs": {
                "wrist": {"position": {"at": "crank/pin"}}, "rod": {"position": {"at": "rod/a"}},
                "end": {"position": {"at": "rod/b"}}, "slider": {"position": {"at": "slider/pin"}}
            }
        }),
    )
}

fn moved(mechanism: &Mechanism) -> Vec<&str> {
    let moved = mechanism.initial().moved.iter();
    moved.map(|body| body.body.as_str()).collect()
}

#[test]
fn a_rough_drawing_is_closed_and_what_moved_is_told() {
    let mut mechanism = Mechanism::start(&rigid_scene(&rough())).unwrap();
    assert_eq!(moved(&mechanism), ["crank", "rod", "slider"]);
    let mut at = |output: &str| mechanism.output(output).unwrap().to_vec();
    let (wrist, rod, end, slider) = (at("wrist"), at("rod"), at("end"), at("slider"));
    let apart = |a: &[f64], b: &[f64]| (a[0] - b[0]).hypot(a[1] - b[1]);
    assert!(apart(&wrist, &rod) < 1e-12 && apart(&end, &slider) < 1e-12);
    assert!(slider[1].abs() < 1e-12);
    // The geometry of the triangle: crank, rod, guide.
    assert!((wrist[0].hypot(wrist[1]) - 0.15).abs() < 1e-12);
    assert!((apart(&wrist, &end) - 0.3).abs() < 1e-12);
    for body in &mechanism.initial().moved {
        assert!(body.translation < 0.1 && body.rotation < 0.5, "{body:?}");
    }
}

#[test]
fn held_bodies_stay_and_the_others_come_to_them() {
    let mut text = rough();
    text["bodies"]["crank"]["position"] = json!([0, 0]);
    text["initial"] = json!({"hold": ["crank"]});
    let mut mechanism = Mechanism::start(&rigid_scene(&text)).unwrap();
    assert_eq!(moved(&mechanism), ["rod", "slider"]);
    let wrist = mechanism.output("wrist").unwrap();
    let (sine, cosine) = 0.6_f64.sin_cos();
    assert!((wrist[0] - 0.15 * cosine).abs() < 1e-15 && (wrist[1] - 0.15 * sine).abs() < 1e-15);
    // Without holding it, the crank gives way as well.
    text["initial"] = json!({});
    let free = Mechanism::start(&rigid_scene(&text)).unwrap();
    assert!(moved(&free).contains(&"crank"));
}

#[test]
fn a_held_body_that_would_have_to_move_names_its_joint() {
    let mut text = rough();
    text["initial"] = json!({"hold": ["crank"]});
    // The crank is drawn off its axle.
    let error = Mechanism::start(&rigid_scene(&text)).err().unwrap();
    let Error::CannotAssemble { joint, misfit, .. } = &error else {
        panic!("{error}")
    };
    assert_eq!(joint, "axle");
    assert!((misfit.abs() - 0.02).abs() < 1e-9, "{error}");
}

#[test]
fn a_held_superelement_neither_moves_nor_bends() {
    let folder = Folder::with_parts();
    let text = |hold: Value| {
        folder.scene(&scene_text(
            2,
            json!({
                "bodies": {
                    "rod": {"superelement": "rod.dcb.h5", "position": [0.01, 0.02], "orientation": 0.05},
                    "block": {"rigid": {"mass": 1, "inertia": 1e-3, "points": {"pin": [0, 0]}}, "position": [0.29, 0.01], "orientation": 0.1}
                },
                "joints": {"weld": {"fixed": {"a": "rod/b", "b": "block/pin"}}},
                "initial": {"hold": hold},
                "outputs": {"end": {"position": {"at": "rod/b"}}, "block": {"position": {"at": "block/pin"}}}
            }),
        ))
    };
    let mut mechanism = Mechanism::start(&text(json!(["rod"]))).unwrap();
    assert_eq!(moved(&mechanism), ["block"]);
    assert!(mechanism.initial().strained.is_empty());
    let end = mechanism.output("end").unwrap().to_vec();
    assert!((end[0] - 0.01 - 0.3 * 0.05_f64.cos()).abs() < 1e-12);
    let block = mechanism.output("block").unwrap();
    assert!((block[0] - end[0]).abs() < 1e-12 && (block[1] - end[1]).abs() < 1e-12);
    let mechanism = Mechanism::start(&text(json!(["block"]))).unwrap();
    assert_eq!(moved(&mechanism), ["rod"]);
}

#[test]
fn the_driven_crank_passes_both_of_its_dead_centres() {
    let mut text = rough();
    text["bodies"]["crank"]["position"] = json!([0, 0]);
    text["bodies"]["crank"]["orientation"] = json!(0);
    text["bodies"]["rod"]["position"] = json!([0.15, 0]);
    text["bodies"]["rod"]["orientation"] = json!(0);
    text["bodies"]["slider"] = json!({"rigid": {"mass": 0.05, "inertia": 1e-5, "points": {"pin": [0, 0]}}, "position": [0.45, 0]});
    text["drives"] = json!({"motor": {"angle": {"joint": "axle", "polynomial": [0, 10]}}});
    let mut mechanism = Mechanism::start(&rigid_scene(&text)).unwrap();
    // The stretched position, where it starts, and the folded one, where x = 0.15.
    let step = PI / 10.0 / 200.0;
    for _ in 0..200 {
        mechanism.step(step).unwrap();
    }
    let slider = mechanism.output("slider").unwrap()[0];
    assert!((slider - 0.15).abs() < 1e-12, "{slider}");
    for _ in 0..200 {
        mechanism.step(step).unwrap();
    }
    let slider = mechanism.output("slider").unwrap()[0];
    assert!((slider - 0.45).abs() < 1e-12, "{slider}");
}
