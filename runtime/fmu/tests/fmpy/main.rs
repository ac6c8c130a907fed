//! FMPy, an importer that shares nothing with this code, validates and simulates archives. Python with fmpy is `PYTHON` or python3; where it is
//! missing these tests say so and check nothing.
#![allow(clippy::unwrap_used, clippy::panic)]

#[path = "../support/mod.rs"]
#[allow(dead_code)]
mod support;

use std::fs;
use std::path::Path;
use std::process::Command;

use dcb_runtime::{Mechanism, Scene};
use serde_json::{Map, Value, json};

use support::{Folder, arm, slider_crank};

/// Python with fmpy, if it is there.
fn python() -> Option<Command> {
    let python = std::env::var_os("PYTHON").unwrap_or_else(|| "python3".into());
    let found = Command::new(&python)
        .args(["-c", "import fmpy, numpy"])
        .output();
    if !found.is_ok_and(|found| found.status.success()) {
        println!("SKIPPED: no fmpy in {python:?}");
        return None;
    }
    let mut command = Command::new(python);
    command.env("PYTHONDONTWRITEBYTECODE", "1");
    Some(command)
}

/// What a whole run records, for a program that reads JSON only.
fn run(folder: &Folder) -> Value {
    let results = folder.results();
    let time = results.time().unwrap();
    let mut outputs = Map::new();
    for channel in results.channels() {
        if !channel.path.starts_with("outputs/") {
            continue;
        }
        let values = results.history(&channel.path).unwrap();
        for (index, column) in channel.columns.iter().enumerate() {
            let series: Vec<f64> = (0..values.nrows())
                .map(|row| values[(row, index)])
                .collect();
            outputs.insert(channel.label(column), json!(series));
        }
    }
    json!({"interval": time[1], "time": time, "outputs": outputs})
}

fn check(folder: &Folder, reference: &Value) {
    let Some(mut command) = python() else {
        return;
    };
    let archive = folder.pack();
    let path = folder.path("reference.json");
    fs::write(&path, reference.to_string()).unwrap();
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/fmpy/check_unit.py");
    let answer = command.arg(script).arg(archive).arg(path).output().unwrap();
    let printed = String::from_utf8_lossy(&answer.stdout);
    let failed = String::from_utf8_lossy(&answer.stderr);
    assert!(answer.status.success(), "{printed}\n{failed}");
    assert!(printed.ends_with("all is well\n"), "{printed}");
    println!("{printed}");
}

/// Two superelements, inputs, parameters; a controller of Python against the same one in Rust.
#[test]
fn a_spatial_arm_with_a_controller() {
    let folder = arm();
    let (gains, angle, interval) = ([80.0, 12.0], 0.1, 2e-3);
    let mut mechanism =
        Mechanism::start(&Scene::read(&folder.path("scene.json")).unwrap()).unwrap();
    let mut tip = Vec::new();
    for _ in 0..80 {
        let now = mechanism.output("angle").unwrap()[0];
        let rate = mechanism.output("rate").unwrap()[0];
        let torque = -gains[0] * (now + angle) - gains[1] * rate;
        mechanism.set_input("motor", torque).unwrap();
        for _ in 0..2 {
            mechanism.step(1e-3).unwrap();
        }
        tip.push(mechanism.output("tip").unwrap().to_vec());
    }
    let controlled = json!({"gains": gains, "angle": angle, "interval": interval, "tip": tip});
    let reference =
        json!({"run": run(&folder), "step": 1e-3, "smooth": "tip.z", "controlled": controlled});
    check(&folder, &reference);
}

#[test]
fn a_planar_slider_crank() {
    let folder = slider_crank();
    let step = 1.1635528346628864e-5;
    let reference = json!({"run": run(&folder), "step": step, "smooth": "slider_position.x"});
    check(&folder, &reference);
}
