//! Runs that end early, and what they say on the way.

use serde_json::json;

use crate::scene_folder::{pendulum, planar};
use crate::support::{Folder, answer, says};

#[test]
fn a_formula_that_ends_in_nothing_stops_the_run_at_its_time() {
    let folder = Folder::with(&pendulum(json!({
        "loads": {"pull": {"force": {"at": "bob/tip", "components": [{"formula": "sqrt(0.0505 - t)"}, 0]}}}
    })));
    folder.run("scene.json").is_error(
        1,
        &["error: t = 5.1", "\"pull\"", "is NaN", "until the end"],
    );
    let (reason, time, rows) = folder.stopped();
    says!(reason, "is NaN");
    assert!((time.unwrap() - 0.05).abs() < 1e-9);
    assert_eq!(rows, 51);
    let angle = folder.results().history("angle").unwrap();
    assert!((0..rows).all(|row| angle[(row, 0)].is_finite()));
}

#[test]
fn too_large_a_step_names_time_residual_and_worst_body() {
    let folder = Folder::slider_crank();
    folder.run("scene.json --step 0.004 --end 0.08").is_error(
        1,
        &[
            "error: t = ",
            "no convergence in 12 iterations",
            "allowed is",
            "largest at body",
            "smaller step",
        ],
    );
    let (reason, time, rows) = folder.stopped();
    says!(reason, "no convergence");
    assert!(time.is_some() && rows >= 1);
}

#[test]
fn contacts_with_end_stops_are_events() {
    let folder = Folder::with(&planar(json!({
        "bodies": {"block": {"rigid": {"mass": 1, "inertia": 1, "points": {"center": [0, 0]}}, "velocity": [1, 0]}},
        "joints": {"guide": {"prismatic": {"a": "ground", "b": "block/center", "axis": [1, 0]}}},
        "actuators": {"buffer": {"end_stop": {"joint": "guide", "lower": -0.02, "upper": 0.03, "stiffness": 1e5}}},
        "integrator": {"generalized_alpha": {"step": 1e-4, "end": 0.1}}
    })));
    let answer = folder.run("scene.json");
    assert_eq!(answer.code, Some(0), "{answer:?}");
    let events = folder.results().events().unwrap();
    says!(
        events[0].message,
        "actuator \"buffer\": contact with the upper end at a rate of"
    );
    assert!((events[0].time - 0.03).abs() < 1e-6, "{events:?}");
    says!(
        events[1].message,
        "contact with the lower end at a rate of -"
    );
    // Half a period of the spring in between, and the way back.
    let expected = 0.03 + std::f64::consts::PI * 1e5_f64.sqrt().recip() + 0.05;
    assert!((events[1].time - expected).abs() < 1e-5, "{events:?}");
}

#[test]
fn steps_that_follow_nothing_stop_the_run() {
    let spring = planar(json!({
        "bodies": {"block": {
            "rigid": {"mass": 1, "inertia": 1, "points": {"center": [0, 0]}},
            "position": [0.1, 0], "velocity": [1, 0]
        }},
        "springs": {"mount": {"bushing": {"a": "ground", "b": "block/center", "translation": [900, 900]}}},
        "integrator": {"generalized_alpha": {"step": 0.05, "end": 5}}
    }));
    let folder = Folder::with(&spring);
    folder.run("scene.json").is_error(
        1,
        &["error: t = ", "too long", "\"block\"", "take steps below"],
    );
    let (reason, time, _) = folder.stopped();
    assert!(reason.contains("too long") && time.is_some(), "{reason}");
}

#[test]
fn steps_too_long_for_a_vibration_are_told_once() {
    let folder = Folder::slider_crank();
    let answer = folder.done("scene.json --step 0.0008 --end 0.08");
    let told = answer.stderr.matches("the deflection of body \"rod\"");
    assert_eq!(told.count(), 1, "{}", answer.stderr);
    says!(folder.told().join("\n"), "to follow it take steps below");
}

#[test]
fn an_interrupted_run_keeps_its_rows() {
    let folder = Folder::endless();
    let stdout = folder.interrupted("scene.json --csv scene.csv", "scene.h5");
    says!(stdout, "scene.h5 (incomplete)");
    let (reason, time, rows) = folder.stopped();
    assert_eq!(reason, "interrupted");
    assert!(rows > 10, "{rows} rows");
    assert_eq!(folder.results().time().unwrap().last().copied(), time);
    assert_eq!(folder.read("scene.csv").lines().count(), rows + 1);
    let shown = folder.done("show scene.h5").stdout;
    says!(shown, format!("{rows} rows, stopped at t = "));
}

/// Batch systems and containers send SIGTERM, a terminal that is closed SIGHUP.
#[test]
fn a_run_that_is_asked_to_end_keeps_its_rows_and_says_who_asked() {
    for (signal, status, reason) in [
        ("TERM", 143, "terminated (SIGTERM)"),
        ("HUP", 129, "hung up (SIGHUP)"),
    ] {
        let folder = Folder::endless();
        let stdout = folder.stopped_by(signal, status, "scene.json", "scene.h5");
        says!(stdout, "scene.h5 (incomplete)");
        let (told, time, rows) = folder.stopped();
        assert_eq!(told, reason);
        assert!(rows > 10, "{rows} rows");
        assert_eq!(folder.results().time().unwrap().last().copied(), time);
        assert_eq!(folder.names(), ["rod.dcb.h5", "scene.h5", "scene.json"]);
    }
}

/// A program started by `nohup` outlives its terminal.
#[test]
fn a_run_that_ignores_hangups_goes_on() {
    let folder = Folder::slider_crank();
    let script = "trap '' HUP; \"$0\" scene.json & child=$!; while [ ! -e scene.h5 ]; do :; done; kill -HUP $child; wait $child";
    assert_eq!(answer(&mut folder.shell(script)).code, Some(0));
    assert_eq!(
        *folder.results().outcome(),
        dcb_formats::results::Outcome::Complete
    );
}

/// A full disk, as `ulimit -f` makes one for everybody.
#[test]
fn results_without_room_are_told_and_stay_readable() {
    let folder = Folder::slider_crank();
    folder.set_scene("record", json!({"every": 1}));
    folder.set_integrator("end", 0.1);
    folder.done("scene.json -o whole.h5");
    let size = folder.size("whole.h5") / 1024;
    let answer = folder.run_within(size as u32 * 2 / 3, "scene.json");
    answer.is_error(
        2,
        &["scene.h5: larger than a file may be here (ulimit -f): needs "],
    );
    assert!(folder.results().step_count() > 10);
    let (reason, _, _) = folder.stopped();
    assert!(!reason.is_empty());
}

#[test]
fn large_deflections_and_fast_spins_are_told_once() {
    let free = planar(json!({
        "bodies": {"rod": {"superelement": "rod.dcb.h5", "angular_velocity": 0}},
        "integrator": {"generalized_alpha": {"step": 1e-6, "end": 5e-6}}
    }));
    // A blow on its end bends the rod.
    let folder = Folder::slider_crank();
    let mut scene = free.clone();
    scene["loads"] = json!({"blow": {"force": {"at": "rod/b", "components": [0, 3000]}}});
    scene["integrator"]["generalized_alpha"] = json!({"step": 1e-5, "end": 1.5e-3});
    folder.write("scene.json", scene.to_string());
    let answer = folder.done("scene.json");
    let told = answer.stderr.matches("body \"rod\" deflects by 0.").count();
    assert_eq!(told, 1, "{}", answer.stderr);
    let told = folder.told().join("\n");
    assert_eq!(told.matches("deflects by").count(), 1, "{told}");
    // The rod's first frequency is about 2000 rad/s: it is told that there is no meaning in faster spins.
    let spun = |spin: f64| {
        let folder = Folder::slider_crank();
        let mut scene = free.clone();
        scene["bodies"]["rod"]["angular_velocity"] = json!(spin);
        folder.write("scene.json", scene.to_string());
        // Nothing refers to the rod: by itself it would be carried as rigid.
        folder.run("scene.json --model everything").stderr
    };
    assert_eq!(spun(100.0), "");
    let warned = spun(1000.0);
    assert_eq!(
        warned.matches("of its first frequency").count(),
        1,
        "{warned}"
    );
    says!(warned, "\"rod\" spins at 0.", "too low by about");
    let beyond = spun(4000.0);
    says!(beyond, "the linear floating frame is not valid there");
    assert!(!beyond.contains("too low by about"), "{beyond}");
}

#[test]
fn a_rough_drawing_is_closed_and_told() {
    let folder = Folder::slider_crank();
    folder.set_scene("bodies/slider/position", json!([0.48, 0.02]));
    folder.set_scene("bodies/rod/position", json!([0.16, 0.01]));
    let answer = folder.done("scene.json");
    says!(
        answer.stderr,
        "assembly moved body \"slider\" by",
        "assembly moved body \"rod\" by"
    );
    says!(folder.told().join("\n"), "assembly moved body");
    let quiet = folder.done("scene.json --force --quiet");
    assert_eq!((quiet.stdout.as_str(), quiet.stderr.as_str()), ("", ""));
}
