//! Results files: what is written is read, by h5py too, however the run ended.

use std::fs;
use std::path::Path;
use std::process::Command;

use dcb_formats::Error;
use dcb_formats::component::{Source, Units};
use dcb_formats::output::Replace;
use dcb_formats::results::{Channel, Column, Header, Outcome, Results, ResultsWriter};
use dcb_tests::python;
use hdf5::file::LibraryVersion;
use serde_json::{Value, json};

use crate::hdf5_file::edit;

fn header() -> Header {
    Header {
        units: Units {
            length: "m".to_owned(),
            mass: "kg".to_owned(),
            time: "s".to_owned(),
        },
        generator: "simulate 0.1.0".to_owned(),
        scene: json!({ "dimension": 2, "note": "Größe \"x\"" }),
        inputs: vec![Source {
            role: "body rod".to_owned(),
            file_name: "rod.dcb.h5".to_owned(),
            sha256: "ab".repeat(32),
        }],
        options: json!({ "step": 1e-3 }),
        warnings: vec!["one\nwarning".to_owned()],
    }
}

fn channels() -> Vec<Channel> {
    let column = |name: &str, unit: &str| Column {
        name: name.to_owned(),
        unit: unit.to_owned(),
    };
    vec![
        Channel::scalar("outputs/midpoint_deflection", "1", "deflection over chord"),
        Channel {
            path: "interface_forces/big rod/Auge-ü".to_owned(),
            columns: vec![column("fx", "N"), column("fy", "N"), column("mz", "N m")],
            description: "force on the body, world axes".to_owned(),
        },
        Channel::vector("outputs/tip", &["x", "y"], "m", "position of the tip"),
    ]
}

/// The row of a step, every number different.
fn row(step: usize) -> (f64, [f64; 6]) {
    let time = 1e-3 * step as f64;
    (
        time,
        std::array::from_fn(|i| (time * (i as f64 + 0.7)).sin() / 3.0),
    )
}

fn started(path: &Path, steps: usize) -> ResultsWriter {
    let mut writer = ResultsWriter::create(path, &channels(), &header(), Replace::Refuse).unwrap();
    for step in 0..steps {
        let (time, values) = row(step);
        writer.append(time, &values).unwrap();
    }
    writer
}

/// The steps that the file has, each compared bit by bit.
fn steps_as_written(path: &Path) -> usize {
    let results = Results::open(path).unwrap();
    let time = results.time().unwrap();
    assert_eq!(time.len(), results.step_count());
    let mut first = 0;
    for channel in channels() {
        let history = results.history(&channel.path).unwrap();
        let columns = channel.columns.len();
        assert_eq!((history.nrows(), history.ncols()), (time.len(), columns));
        for (step, found) in time.iter().enumerate() {
            let (expected, values) = row(step);
            assert_eq!(*found, expected);
            for column in 0..columns {
                assert_eq!(history[(step, column)], values[first + column]);
            }
        }
        first += columns;
    }
    time.len()
}

/// What h5py finds.
fn checked_with_h5py(path: &Path) -> Value {
    let found = python::run("check_results.py", &[path.as_os_str()]).unwrap();
    serde_json::from_str(&found).unwrap()
}

#[test]
fn every_row_comes_back_whatever_the_number_of_blocks() {
    let folder = tempfile::tempdir().unwrap();
    for steps in [0, 1, 1023, 1024, 1025, 5000] {
        let path = folder.path().join(format!("{steps}.h5"));
        let mut writer = started(&path, steps);
        writer.note(0.5, "contact lost");
        writer
            .finish(&Outcome::Complete, &json!({ "iterations": 3 }))
            .unwrap();
        assert_eq!(steps_as_written(&path), steps);

        let results = Results::open(&path).unwrap();
        assert_eq!(*results.outcome(), Outcome::Complete);
        assert_eq!(*results.units(), header().units);
        let mut expected = channels();
        expected.sort_by(|a, b| a.path.cmp(&b.path));
        assert_eq!(results.channels(), expected);
        assert_eq!(results.provenance("scene").unwrap(), header().scene);
        assert_eq!(results.provenance("summary").unwrap()["iterations"], 3);
        let events = results.events().unwrap();
        assert_eq!(
            (events[0].time, events[0].message.as_str()),
            (0.5, "contact lost")
        );

        let found = checked_with_h5py(&path);
        assert_eq!(found["steps"], steps);
        assert_eq!(found["complete"], true);
        let forces = &found["channels"]["interface_forces/big rod/Auge-ü"];
        assert_eq!(forces["columns"], json!(["fx", "fy", "mz"]));
        assert_eq!(forces["units"], "mixed");
        let sum: f64 = (0..steps).map(|step| row(step).1[3]).sum();
        let difference = forces["sum"][2].as_f64().unwrap() - sum;
        assert!(difference.abs() <= 1e-12 * steps as f64, "{difference:e}");
    }
    assert_eq!(
        fs::read_dir(folder.path()).unwrap().count(),
        6,
        "nothing else is left"
    );
}

#[test]
fn a_run_that_stops_says_why_and_when() {
    let folder = tempfile::tempdir().unwrap();
    let (stopped, dropped) = (
        folder.path().join("stopped.h5"),
        folder.path().join("dropped.h5"),
    );
    let outcome = Outcome::Stopped {
        reason: "Newton's method didn't converge".to_owned(),
        time: Some(row(1499).0),
    };
    started(&stopped, 1500)
        .finish(&outcome, &json!(null))
        .unwrap();
    drop(started(&dropped, 1500));
    assert_eq!(*Results::open(&stopped).unwrap().outcome(), outcome);
    let Outcome::Stopped { reason, time } = Results::open(&dropped).unwrap().outcome().clone()
    else {
        panic!("a dropped writer must not call its run complete");
    };
    assert!(reason.contains("abandoned"), "{reason}");
    assert_eq!(time, Some(row(1499).0));
    for path in [&stopped, &dropped] {
        assert_eq!(steps_as_written(path), 1500);
        let found = checked_with_h5py(path);
        assert_eq!(
            (&found["complete"], &found["steps"]),
            (&json!(false), &json!(1500))
        );
        assert_eq!(found["stopped"]["time"], row(1499).0);
    }
}

/// A copy made while the run goes on is what a kill at that moment leaves.
#[test]
fn a_killed_run_leaves_its_written_blocks() {
    let folder = tempfile::tempdir().unwrap();
    let (path, killed) = (
        folder.path().join("run.h5"),
        folder.path().join("killed.h5"),
    );
    let writer = started(&path, 3 * 1024 + 100);
    fs::copy(&path, &killed).unwrap();
    drop(writer);
    assert_eq!(steps_as_written(&killed), 3 * 1024);
    assert!(matches!(
        Results::open(&killed).unwrap().outcome(),
        Outcome::Stopped { time: None, .. }
    ));
    assert_eq!(checked_with_h5py(&killed)["steps"], 3 * 1024);
}

#[test]
fn an_existing_file_is_replaced_only_where_that_is_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.h5");
    started(&path, 3)
        .finish(&Outcome::Complete, &json!(null))
        .unwrap();
    let create = |replace| ResultsWriter::create(&path, &channels(), &header(), replace);
    assert!(matches!(
        create(Replace::Refuse),
        Err(Error::OutputExists { .. })
    ));
    assert_eq!(steps_as_written(&path), 3);
    drop(create(Replace::Overwrite).unwrap());
    assert_eq!(steps_as_written(&path), 0);
}

#[test]
fn rows_that_do_not_fit_are_refused_and_leave_the_file_usable() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.h5");
    let mut writer = started(&path, 10);
    let (time, values) = row(9);
    assert!(writer.append(time + 1.0, &values[1..]).is_err());
    for wrong in [time, time - 1.0, f64::NAN, f64::INFINITY] {
        let refused = writer.append(wrong, &values).unwrap_err().to_string();
        assert!(refused.contains("increase"), "{refused}");
    }
    let (time, values) = row(10);
    writer.append(time, &values).unwrap();
    drop(writer);
    assert_eq!(steps_as_written(&path), 11);
}

#[test]
fn channels_that_cannot_share_a_file_are_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.h5");
    for (paths, said) in [
        (vec!["tip"], "GROUP/NAME"),
        (vec!["outputs/../tip"], "GROUP/NAME"),
        (vec!["/outputs/tip"], "GROUP/NAME"),
        (vec!["outputs//tip"], "GROUP/NAME"),
        (vec!["a/b/c/d/e/f"], "GROUP/NAME"),
        (vec!["provenance/tip"], "meaning of its own"),
        (vec!["outputs/tip", "outputs/tip"], "twice"),
        (
            vec!["outputs/tip/x", "outputs/tip"],
            "is inside outputs/tip",
        ),
    ] {
        let channels: Vec<_> = paths
            .iter()
            .map(|path| Channel::scalar(path, "1", ""))
            .collect();
        let refused =
            ResultsWriter::create(&path, &channels, &header(), Replace::Refuse).unwrap_err();
        let message = refused.to_string();
        assert!(message.contains(said), "{paths:?}: {message}");
        assert!(!path.exists());
    }
}

#[test]
fn a_channel_is_found_by_name_and_a_misspelt_one_is_suggested() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.h5");
    started(&path, 1)
        .finish(&Outcome::Complete, &json!(null))
        .unwrap();
    let results = Results::open(&path).unwrap();
    for name in ["tip", "outputs/tip", "/outputs/tip"] {
        assert_eq!(results.channel(name).unwrap().path, "outputs/tip");
    }
    assert_eq!(
        results.channel("Auge-ü").unwrap().path,
        "interface_forces/big rod/Auge-ü"
    );
    let message = results
        .channel("midpont_deflection")
        .unwrap_err()
        .to_string();
    assert!(
        message.contains("did you mean `midpoint_deflection`?"),
        "{message}"
    );
}

fn edited(path: &Path, change: impl FnOnce(&hdf5::File)) -> String {
    edit(path, LibraryVersion::V18, change);
    match Results::open(path) {
        Ok(results) => results.history("tip").map(drop).unwrap_err().to_string(),
        Err(error) => error.to_string(),
    }
}

#[test]
fn damaged_and_foreign_files_are_refused_with_the_place() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("run.h5");
    let fresh = || {
        let _ = fs::remove_file(&path);
        started(&path, 20)
            .finish(&Outcome::Complete, &json!(null))
            .unwrap();
    };
    fresh();
    let message = edited(&path, |file| {
        file.unlink("outputs/tip").unwrap();
        let huge = file.new_dataset::<f64>().chunk([1, 1000]).deflate(9);
        huge.shape([1_000_000, 1_000_000])
            .create("outputs/tip")
            .unwrap();
    });
    assert!(
        message.contains("/outputs/tip") && message.contains("can't hold"),
        "{message}"
    );
    fresh();
    let message = edited(&path, |file| {
        file.dataset("outputs/tip")
            .unwrap()
            .resize((19, 2))
            .unwrap();
    });
    assert!(
        message.contains("/outputs/tip") && message.contains("19 rows"),
        "{message}"
    );
    fresh();
    let message = edited(&path, |file| file.unlink("time").unwrap());
    assert!(
        message.contains("/time") && message.contains("missing"),
        "{message}"
    );
    fresh();
    let message = edited(&path, |file| file.delete_attr("complete").unwrap());
    assert!(message.contains("complete"), "{message}");
    fresh();
    let bytes = fs::read(&path).unwrap();
    fs::write(&path, &bytes[..bytes.len() / 2]).unwrap();
    let message = Results::open(&path).unwrap_err().to_string();
    assert!(message.contains("truncated"), "{message}");
    fs::write(&path, "time,x\n").unwrap();
    let message = Results::open(&path).unwrap_err().to_string();
    assert!(message.contains("`simulate`"), "{message}");
}

/// On a file system of 512 KiB, where this machine lets the test make one.
#[test]
fn a_full_disk_is_told_and_the_steps_before_it_stay_readable() {
    let folder = tempfile::tempdir().unwrap();
    let disk = folder.path().join("disk");
    fs::create_dir(&disk).unwrap();
    let mount = Command::new("mount")
        .args(["-t", "tmpfs", "-o", "size=512k", "tmpfs"])
        .arg(&disk)
        .output();
    if !mount.is_ok_and(|output| output.status.success()) {
        println!("SKIPPED: mounting a small file system needs root; the full disk wasn't tested");
        return;
    }
    let path = disk.join("run.h5");
    let saved = folder.path().join("saved.h5");
    let mut writer = started(&path, 0);
    let failed = (0..100_000).find_map(|step| {
        let (time, values) = row(step);
        writer
            .append(time, &values)
            .err()
            .map(|error| (step, error))
    });
    let later = writer.append(1e9, &row(0).1);
    drop(writer);
    let _ = fs::copy(&path, &saved);
    let _ = Command::new("umount").arg("-l").arg(&disk).status();
    let (step, error) = failed.expect("512 KiB don't hold these results");
    assert!(error.to_string().contains("No space left"), "{error}");
    assert!(later.is_err());
    let steps = steps_as_written(&saved);
    assert_eq!(steps, step + 1 - 1024, "all blocks but the last");
    assert_eq!(checked_with_h5py(&saved)["steps"], steps);
}
