//! Axes of channels in results files: xarray shows times and columns, and readers of channels are not misled.

use std::path::Path;

use dcb_formats::component::Units;
use dcb_formats::output::Replace;
use dcb_formats::results::{Channel, Column, Header, Outcome, Results, ResultsWriter};
use dcb_tests::python;
use serde_json::{Value, json};

fn header() -> Header {
    Header {
        units: Units {
            length: "m".to_owned(),
            mass: "kg".to_owned(),
            time: "s".to_owned(),
        },
        generator: "simulate 0.1.0".to_owned(),
        scene: json!({}),
        inputs: Vec::new(),
        options: json!({}),
        warnings: Vec::new(),
    }
}

fn channels() -> Vec<Channel> {
    let numbers: Vec<String> = (1..=4).map(|number| number.to_string()).collect();
    let numbers: Vec<&str> = numbers.iter().map(String::as_str).collect();
    vec![
        Channel::vector("outputs/tip", &["x", "y"], "m", "position"),
        Channel::vector("outputs/hub", &["x", "y"], "m", "position"),
        Channel::scalar("outputs/angle", "rad", "angle"),
        Channel::vector("outputs/turn", &["w", "x", "y", "z"], "1", "quaternion"),
        // Names that scales would have.
        Channel::vector("outputs/fx_fy", &["a", "b"], "N", "force"),
        Channel::vector("outputs/push", &["fx", "fy"], "N", "force"),
        Channel::vector("motion/big rod/coordinates", &numbers, "1", "coordinates"),
        Channel::scalar("drives/time", "N", "a drive that is called so"),
        Channel {
            path: "reactions/Größe".to_owned(),
            columns: ["fx", "fy", "mz"]
                .map(|name| Column {
                    name: name.to_owned(),
                    unit: if name == "mz" { "N m" } else { "N" }.to_owned(),
                })
                .to_vec(),
            description: "force and moment".to_owned(),
        },
    ]
}

fn written(path: &Path, rows: usize) {
    let mut writer = ResultsWriter::create(path, &channels(), &header(), Replace::Refuse).unwrap();
    let count = writer.value_count();
    for row in 0..rows {
        let values: Vec<f64> = (0..count).map(|k| (row * count + k) as f64).collect();
        writer.append(0.5 * row as f64, &values).unwrap();
    }
    writer.finish(&Outcome::Complete, &json!({})).unwrap();
}

fn axes(path: &Path) -> Value {
    let printed = python::run("axes.py", &[path.as_os_str()]).unwrap();
    serde_json::from_str(&printed).unwrap()
}

#[test]
fn xarray_shows_times_and_columns() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("results.h5");
    written(&path, 3);
    let found = axes(&path);
    let outputs = &found["groups"]["/outputs"];
    assert_eq!(outputs["variables"]["tip"]["dims"], json!(["time", "x_y"]));
    assert_eq!(outputs["variables"]["hub"]["dims"], json!(["time", "x_y"]));
    assert_eq!(
        outputs["variables"]["angle"]["dims"],
        json!(["time", "single"])
    );
    assert_eq!(
        outputs["variables"]["turn"]["dims"],
        json!(["time", "w_x_y_z"])
    );
    assert_eq!(
        outputs["variables"]["push"]["dims"],
        json!(["time", "fx_fy_"])
    );
    assert_eq!(outputs["variables"]["tip"]["units"], "m");
    for of in ["coordinates", "alone"] {
        assert_eq!(outputs[of]["time"], json!([0.0, 0.5, 1.0]), "{of}");
        assert_eq!(outputs[of]["x_y"], json!(["x", "y"]));
        assert_eq!(outputs[of]["fx_fy_"], json!(["fx", "fy"]));
        assert_eq!(outputs[of]["single"], Value::Null);
    }
    // The first channel is the first two numbers of rows of 21.
    let rows: f64 = (0..3).map(|row| 2.0 * 21.0 * f64::from(row) + 1.0).sum();
    assert_eq!(outputs["variables"]["tip"]["sum"], json!(rows));
    let motion = &found["groups"]["/motion/big rod"];
    let columns = &motion["alone"]["coordinates_columns"];
    assert_eq!(columns, &json!(["1", "2", "3", "4"]));
    assert_eq!(motion["alone"]["time"], json!([0.0, 0.5, 1.0]));
    // The name of the times is taken: they are in the root.
    let drive = &found["groups"]["/drives"]["variables"]["time"];
    assert_eq!(drive["dims"], json!(["time", "single"]));
    let reactions = &found["groups"]["/reactions"]["variables"];
    assert_eq!(reactions["Größe"]["dims"], json!(["time", "fx_fy_mz"]));
    let datasets = found["datasets"].as_object().unwrap();
    for (name, said) in datasets {
        let is_scale = !channels().iter().any(|channel| channel.path == *name);
        assert_eq!(said["is_scale"], json!(is_scale), "{name}");
        if !is_scale {
            assert_eq!(said["attached"], json!([true, true]), "{name}");
        }
    }
}

#[test]
fn scales_are_no_channels() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("results.h5");
    written(&path, 2000);
    let results = Results::open(&path).unwrap();
    assert_eq!(results.format_version().to_string(), "1.1");
    let mut expected: Vec<String> = channels().into_iter().map(|one| one.path).collect();
    expected.sort();
    let found: Vec<&str> = results
        .channels()
        .iter()
        .map(|one| one.path.as_str())
        .collect();
    assert_eq!(found, expected);
    assert_eq!(results.time().unwrap().len(), 2000);
}

#[test]
fn what_ties_axes_may_be_anything() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("results.h5");
    for change in [
        "del file['outputs/tip'].attrs['DIMENSION_LIST']",
        "file['time'].attrs['REFERENCE_LIST'] = 'nobody'",
        "del file['single']",
        "del file['outputs/x_y']",
        "del file['outputs/time']; file['outputs/time'] = h5py.SoftLink('/outputs')",
        "del file['outputs/time']; file['outputs/time'] = numpy.zeros(10**6, 'f4')",
    ] {
        let _ = std::fs::remove_file(&path);
        written(&path, 10);
        let program = format!(
            "import sys, h5py, numpy\nwith h5py.File(sys.argv[1], 'r+') as file:\n    {change}"
        );
        python::run_text(&program, &[path.as_os_str()]).unwrap();
        let results = Results::open(&path).unwrap();
        assert_eq!(results.channels().len(), channels().len(), "{change}");
        assert_eq!(results.history("tip").unwrap()[(9, 1)], 190.0, "{change}");
    }
}

/// Files of version 1.0 have no scales.
#[test]
fn frozen_results_read_as_when_they_were_written() {
    let frozen = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/frozen");
    for version in ["1.0", "1.1"] {
        let results = Results::open(frozen.join(format!("results-{version}.h5"))).unwrap();
        assert_eq!(results.format_version().to_string(), version);
        assert_eq!(*results.outcome(), Outcome::Complete);
        assert_eq!(results.step_count(), 5);
        let angle = results.history("angle").unwrap();
        // A pendulum of 0.5 m that is let go level: half the acceleration times the time squared.
        let fallen = -0.5 * 9.81 / 0.5 * 4e-3 * 4e-3;
        assert!(
            (angle[(4, 0)] - fallen).abs() < 1e-7,
            "{version}: {}",
            angle[(4, 0)]
        );
        assert!(results.channel("reactions/pivot").unwrap().columns.len() == 3);
    }
}
