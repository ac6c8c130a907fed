//! Runs that end early, and what they say on the way.

use serde_json::json;

use super::support::{Folder, pendulum};

#[test]
fn a_formula_that_ends_in_nothing_stops_the_run_at_its_time() {
    let folder = Folder::with(&pendulum(json!({
        "loads": {"pull": {"force": {"at": "bob/tip", "components": [{"formula": "sqrt(0.0505 - t)"}, 0]}}}
    })));
    folder.run("scene.json").assert(
        1,
        &["error: t = 5.1", "\"pull\"", "is NaN", "until the end"],
    );
    let (reason, time, rows) = folder.stopped();
    assert!(reason.contains("is NaN"), "{reason}");
    assert!((time.unwrap() - 0.05).abs() < 1e-9);
    assert_eq!(rows, 51);
    let angle = folder.results().history("angle").unwrap();
    assert!((0..rows).all(|row| angle[(row, 0)].is_finite()));
}

#[test]
fn too_large_a_step_names_time_residual_and_worst_body() {
    let folder = Folder::slider_crank();
    folder.run("scene.json --step 0.004 --end 0.08").assert(
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
    assert!(reason.contains("no convergence"), "{reason}");
    assert!(time.is_some() && rows >= 1);
}

#[test]
fn steps_that_follow_nothing_stop_the_run() {
    let spring = json!({
        "dimension": 2,
        "units": {"length": "m", "mass": "kg", "time": "s"},
        "bodies": {"block": {
            "rigid": {"mass": 1, "inertia": 1, "points": {"center": [0, 0]}},
            "position": [0.1, 0]
        }},
        "springs": {"mount": {"bushing": {"a": "ground", "b": "block/center", "translation": [900, 900]}}},
        "integrator": {"generalized_alpha": {"step": 0.05, "end": 5}}
    });
    // Free where it is drawn: it is pushed.
    let mut scene = spring;
    scene["bodies"]["block"]["velocity"] = json!([1, 0]);
    let folder = Folder::with(&scene);
    folder.run("scene.json").assert(
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
    let told = answer
        .stderr
        .matches("the deflection of body \"rod\" has")
        .count();
    assert_eq!(told, 1, "{}", answer.stderr);
    let events = folder.results().events().unwrap();
    assert!(
        events
            .iter()
            .any(|event| event.message.contains("to follow it take steps below"))
    );
}

#[test]
fn an_interrupted_run_keeps_its_rows() {
    let folder = Folder::slider_crank();
    folder.edit("scene.json", |scene| {
        scene["record"] = json!({"every": 1});
        scene["integrator"]["generalized_alpha"]["end"] = json!(1000);
    });
    let stdout = folder.interrupted("scene.json --csv scene.csv", "scene.h5");
    assert!(stdout.contains("scene.h5 (incomplete)"), "{stdout}");
    let (reason, time, rows) = folder.stopped();
    assert_eq!(reason, "interrupted");
    assert!(rows > 10, "{rows} rows");
    assert_eq!(folder.results().time().unwrap().last().copied(), time);
    assert_eq!(folder.read("scene.csv").lines().count(), rows + 1);
    let shown = folder.done("show scene.h5").stdout;
    assert!(
        shown.contains(&format!("{rows} rows, stopped at t = ")),
        "{shown}"
    );
}

/// Batch systems and containers send SIGTERM, a terminal that is closed SIGHUP.
#[test]
fn a_run_that_is_asked_to_end_keeps_its_rows_and_says_who_asked() {
    for (signal, status, reason) in [
        ("TERM", 143, "terminated (SIGTERM)"),
        ("HUP", 129, "hung up (SIGHUP)"),
    ] {
        let folder = Folder::slider_crank();
        folder.edit("scene.json", |scene| {
            scene["record"] = json!({"every": 1});
            scene["integrator"]["generalized_alpha"]["end"] = json!(1000);
        });
        let stdout = folder.stopped_by(signal, status, "scene.json", "scene.h5");
        assert!(stdout.contains("scene.h5 (incomplete)"), "{stdout}");
        let (told, time, rows) = folder.stopped();
        assert_eq!(told, reason);
        assert!(rows > 10, "{rows} rows");
        assert_eq!(folder.results().time().unwrap().last().copied(), time);
        let names: Vec<String> = folder.contents().into_keys().collect();
        assert_eq!(names, ["rod.dcb.h5", "scene.h5", "scene.json"]);
    }
}

/// A program started by `nohup` outlives its terminal.
#[test]
fn a_run_that_ignores_hangups_goes_on() {
    let folder = Folder::slider_crank();
    let program = env!("CARGO_BIN_EXE_simulate");
    let script = format!(
        "trap '' HUP; '{program}' scene.json & child=$!; while [ ! -e scene.h5 ]; do :; done; kill -HUP $child; wait $child"
    );
    let mut shell = std::process::Command::new("bash");
    let shell = shell.args(["-c", &script]).current_dir(folder.path("."));
    assert_eq!(shell.output().unwrap().status.code(), Some(0));
    assert_eq!(
        *folder.results().outcome(),
        dcb_formats::results::Outcome::Complete
    );
}

/// A full disk, as `ulimit -f` makes one for everybody.
#[test]
fn results_without_room_are_told_and_stay_readable() {
    let folder = Folder::slider_crank();
    folder.edit("scene.json", |scene| {
        scene["record"] = json!({"every": 1});
        scene["integrator"]["generalized_alpha"]["end"] = json!(0.1);
    });
    let whole = folder.done("scene.json -o whole.h5");
    drop(whole);
    let size = std::fs::metadata(folder.path("whole.h5")).unwrap().len() / 1024;
    let answer = folder.run_within(size as u32 * 2 / 3, "scene.json");
    answer.assert(
        2,
        &["scene.h5: larger than a file may be here (ulimit -f): needs "],
    );
    assert!(folder.results().step_count() > 10);
    let (reason, _, _) = folder.stopped();
    assert!(!reason.is_empty());
}

#[test]
fn large_deflections_and_fast_spins_are_told_once() {
    let free = json!({
        "dimension": 2,
        "units": {"length": "m", "mass": "kg", "time": "s"},
        "bodies": {"rod": {"superelement": "rod.dcb.h5", "angular_velocity": 0}},
        "integrator": {"generalized_alpha": {"step": 1e-6, "end": 5e-6}}
    });
    // A blow on its end bends the rod.
    let folder = Folder::slider_crank();
    let mut scene = free.clone();
    scene["loads"] = json!({"blow": {"force": {"at": "rod/b", "components": [0, 3000]}}});
    scene["integrator"]["generalized_alpha"] = json!({"step": 1e-5, "end": 1.5e-3});
    folder.write("scene.json", scene.to_string());
    let answer = folder.done("scene.json");
    let told = answer.stderr.matches("body \"rod\" deflects by 0.").count();
    assert_eq!(told, 1, "{}", answer.stderr);
    let events = folder.results().events().unwrap();
    let told = events
        .iter()
        .filter(|event| event.message.contains("deflects by"));
    assert_eq!(told.count(), 1, "{events:?}");
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
    assert!(
        warned.contains("\"rod\" spins at 0.") && warned.contains("too low by about"),
        "{warned}"
    );
    let beyond = spun(4000.0);
    assert!(
        beyond.contains("the linear floating frame is not valid there"),
        "{beyond}"
    );
    assert!(!beyond.contains("too low by about"), "{beyond}");
}

#[test]
fn a_rough_drawing_is_closed_and_told() {
    let folder = Folder::slider_crank();
    folder.edit("scene.json", |scene| {
        scene["bodies"]["slider"]["position"] = json!([0.48, 0.02]);
        scene["bodies"]["rod"]["position"] = json!([0.16, 0.01]);
    });
    let answer = folder.done("scene.json");
    for text in [
        "assembly moved body \"slider\" by",
        "assembly moved body \"rod\" by",
    ] {
        assert!(answer.stderr.contains(text), "{}", answer.stderr);
    }
    let events = folder.results().events().unwrap();
    assert!(
        events
            .iter()
            .any(|event| event.message.contains("assembly moved body"))
    );
    let quiet = folder.done("scene.json --force --quiet");
    assert_eq!((quiet.stdout.as_str(), quiet.stderr.as_str()), ("", ""));
}
