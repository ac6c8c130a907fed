//! What can't be done is an error with a message, and the instance says how to go on.

use std::ffi::CStr;
use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::ptr::{null, null_mut};

use dcb_fmu::*;
use dcb_tests::assert_says;

use crate::importer::{Importer, Messages, instantiate, log};
use crate::support::{arm, slider_crank};

/// A unit reads its folder and nothing else: it runs where nothing can be written, and leaves nothing behind.
#[test]
fn a_folder_that_is_read_only_is_enough() {
    let folder = arm();
    let unpacked = folder.unpacked("unit");
    let files = |folder: &Path| -> Vec<_> {
        let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap());
        let mut found: Vec<_> = entries
            .map(|entry| (entry.path(), entry.metadata().unwrap().modified().unwrap()))
            .collect();
        found.sort();
        found
    };
    let allow = |mode: u32| {
        let permissions = fs::Permissions::from_mode(mode);
        fs::set_permissions(&unpacked.resources, permissions).unwrap();
    };
    let before = files(&unpacked.resources);
    allow(0o555);
    let unit = Importer::started(&unpacked);
    unit.go(2.5e-3, 0..10);
    let state = unit.save();
    unit.free_state(state);
    drop(unit);
    allow(0o755);
    assert_eq!(files(&unpacked.resources), before);
}

#[test]
fn names_that_would_be_two_things_are_not_packed() {
    let folder = slider_crank();
    let mut scene: serde_json::Value =
        serde_json::from_slice(&fs::read(folder.path("scene.json")).unwrap()).unwrap();
    scene["outputs"]["time"] = serde_json::json!({"joint_coordinate": {"joint": "axle"}});
    folder.write_scene(&scene);
    let library = crate::support::library();
    let pack = ["fmu", "./scene.json", "-o", "./unit.fmu", "--library"];
    let arguments = [&pack[..], &[library.to_str().unwrap()]].concat();
    assert_eq!(folder.simulate(&arguments), 2);
    assert!(!folder.path("unit.fmu").exists());
}

#[test]
fn what_is_no_unit_is_not_instantiated() {
    let folder = arm();
    let unpacked = folder.unpacked("unit");
    let resources = unpacked.resources.to_str().unwrap();
    let refused =
        |resources: &str, token: &str| instantiate(resources, token, false).err().unwrap();
    let told = refused(resources, "another");
    assert_says(
        &told,
        &["the instantiation token is \"another\"", &unpacked.token],
    );
    assert_says(
        &refused("/nowhere", &unpacked.token),
        &["/nowhere/scene.json", "cannot read"],
    );
    let told = instantiate(resources, &unpacked.token, true).err().unwrap();
    assert_says(&told, &["no event mode"]);

    let superelement = unpacked.resources.join("link-2.dcb.h5");
    let whole = fs::read(&superelement).unwrap();
    let mut damaged = whole.clone();
    let place = damaged.len() / 2;
    for byte in &mut damaged[place..place + 64] {
        *byte ^= 0x55;
    }
    fs::write(&superelement, &damaged).unwrap();
    assert_says(&refused(resources, &unpacked.token), &["link-2.dcb.h5"]);
    fs::write(&superelement, &whole[..whole.len() - 1000]).unwrap();
    assert_says(&refused(resources, &unpacked.token), &["link-2.dcb.h5"]);
    fs::remove_file(&superelement).unwrap();
    assert_says(
        &refused(resources, &unpacked.token),
        &["link-2.dcb.h5", "there is no file"],
    );
    fs::write(&superelement, &whole).unwrap();
    // Another superelement in the place of the first is sound, but not the one that the description was made for.
    let first = unpacked.resources.join("link.dcb.h5");
    let own = fs::read(&first).unwrap();
    fs::write(&first, &whole).unwrap();
    assert_says(
        &refused(resources, &unpacked.token),
        &["aren't of one archive"],
    );
    fs::write(&first, &own).unwrap();
    assert!(instantiate(resources, &unpacked.token, false).is_ok());
}

#[test]
fn other_interfaces_are_refused_with_a_message() {
    let messages = Box::<Messages>::default();
    let environment = || (&raw const *messages).cast_mut().cast();
    let text = c"x".as_ptr();
    unsafe {
        let made =
            fmi3InstantiateModelExchange(text, text, text, false, false, environment(), Some(log));
        assert!(made.is_null());
        let made = fmi3InstantiateScheduledExecution(
            text,
            text,
            text,
            false,
            false,
            environment(),
            Some(log),
            null(),
            null(),
            null(),
        );
        assert!(made.is_null());
        // Without a log nobody is told.
        let made = fmi3InstantiateCoSimulation(
            null(),
            null(),
            null(),
            false,
            false,
            false,
            false,
            null(),
            0,
            null_mut(),
            None,
            null(),
        );
        assert!(made.is_null());
        assert_eq!(CStr::from_ptr(fmi3GetVersion()), c"3.0");
        fmi3FreeInstance(null_mut());
        assert_eq!(fmi3Reset(null_mut()), Status::Error);
    }
    let told = messages.lock().unwrap();
    assert_eq!(told.len(), 2);
    assert!(
        told.iter()
            .all(|(_, _, message)| message.contains("for co-simulation only"))
    );
}

#[test]
fn what_does_not_belong_here_is_an_error_and_changes_nothing() {
    let folder = arm();
    let unpacked = folder.unpacked("unit");
    let unit = Importer::of(&unpacked);
    let refused = |status: Status, parts: &[&str]| {
        assert_eq!(status, Status::Error, "{parts:?}");
        assert_says(&unit.last_message(), parts);
    };
    refused(unit.step(0.0, 1e-3).0, &["fmi3DoStep", "Instantiated"]);
    refused(
        unit.exit(),
        &[
            "fmi3ExitInitializationMode",
            "call fmi3EnterInitializationMode first",
        ],
    );
    refused(unit.enter(1.0), &["the start time is 1.0", "begins at 0"]);
    refused(unit.set("tip.x", 1.0), &["tip.x", "an output can't be set"]);
    refused(unit.set("time", 1.0), &["time"]);
    refused(unit.set("motor", f64::NAN), &["motor: is NaN"]);
    // A value that the scene refuses, at the start.
    unit.must_set("integrator.step", -1.0);
    assert_eq!(unit.enter(0.0), Status::Ok);
    refused(unit.exit(), &["integrator.generalized_alpha.step", "-1"]);
    unit.must_set("integrator.step", 1e-3);
    assert_eq!(unit.exit(), Status::Ok);

    refused(
        unit.set("gravity.x", 1.0),
        &["gravity.x", "before the start only"],
    );
    refused(
        unit.step(0.5, 1e-3).0,
        &["the current communication point is 0.5", "at 0.0"],
    );
    for length in [0.0, -1e-3, f64::NAN, f64::INFINITY] {
        refused(unit.step(0.0, length).0, &["the communication step is"]);
    }
    let (reference, mut value) = (77, 0.0);
    unsafe {
        let got = fmi3GetFloat64(unit.instance, &raw const reference, 1, &raw mut value, 1);
        refused(got, &["value reference 77"]);
        let got = fmi3GetFloat64(unit.instance, &raw const reference, 1, &raw mut value, 2);
        refused(got, &["1 value references, but 2 values"]);
        refused(
            fmi3GetFloat64(unit.instance, null(), 1, &raw mut value, 1),
            &["null"],
        );
        let mut whole = 0;
        let got = fmi3GetInt32(unit.instance, &raw const reference, 1, &raw mut whole, 1);
        refused(got, &["fmi3GetInt32", "Float64"]);
        assert_eq!(
            fmi3GetInt32(unit.instance, null(), 0, null_mut(), 0),
            Status::Ok
        );
        refused(
            fmi3EnterEventMode(unit.instance),
            &["fmi3EnterEventMode", "no event mode"],
        );
        let mut count = 0;
        let got = fmi3GetNumberOfContinuousStates(unit.instance, &raw mut count);
        refused(got, &["co-simulation only"]);
        refused(fmi3SetFMUState(unit.instance, null_mut()), &["null"]);
        let category = c"everything".as_ptr();
        let set = fmi3SetDebugLogging(unit.instance, true, 1, &raw const category);
        refused(set, &["no category \"everything\"", "logStatusWarning"]);
    }
    // None of it left a trace.
    let other = Importer::started(&unpacked);
    for unit in [&unit, &other] {
        unit.go(1e-3, 0..50);
    }
    assert_eq!(unit.get("tip.z"), other.get("tip.z"));
}

/// A failed step leaves the motion between two communication points: a reset or a saved state is needed.
#[test]
fn after_a_failed_step_a_saved_state_goes_on() {
    let folder = arm();
    let unit = Importer::started(&folder.unpacked("unit"));
    unit.go(5e-3, 0..4);
    let state = unit.save();
    unit.go(5e-3, 4..8);
    let future = unit.get("tip.z");
    unit.must_set("motor", 1e9);
    let (status, reached) = unit.step(0.04, 0.5);
    assert_eq!(status, Status::Error);
    let told = unit.last_message();
    assert_says(&told, &["fmi3DoStep: t = "]);
    assert!((0.04..0.54).contains(&reached), "{reached}");
    if reached > 0.04 {
        assert_eq!(unit.step(0.04, 1e-3).0, Status::Error);
        assert_says(&unit.last_message(), &["an earlier step failed"]);
    }
    assert_eq!(unit.restore(state), Status::Ok);
    unit.go(5e-3, 4..8);
    assert_eq!(unit.get("tip.z"), future);
    unit.free_state(state);
    assert_eq!(unsafe { fmi3Terminate(unit.instance) }, Status::Ok);
    assert_eq!(unit.get("tip.z"), future);
    assert_eq!(unit.set("motor", 0.0), Status::Error);
    assert_says(&unit.last_message(), &["the simulation is over"]);
}

/// Warnings are told where they are wanted, errors always.
#[test]
fn warnings_are_told_if_they_are_wanted() {
    let folder = slider_crank();
    let path = folder.path("scene.json");
    let text = fs::read_to_string(&path).unwrap();
    // The slider is drawn a little off the rod's end: assembly moves it.
    let moved = text.replace("\"position\": [0.45, 0]}", "\"position\": [0.4501, 0]}");
    assert_ne!(text, moved);
    fs::write(&path, moved).unwrap();
    let unpacked = folder.unpacked("unit");
    let unit = Importer::of(&unpacked);
    let told = |unit: &Importer| {
        let messages = unit.messages.lock().unwrap();
        let warnings = messages
            .iter()
            .filter(|(status, ..)| *status == Status::Warning);
        let assembled = warnings.filter(|(_, category, text)| {
            category == "logStatusWarning" && text.contains("assembly moved body")
        });
        assembled.count()
    };
    let at_first = told(&unit);
    assert!(at_first > 0, "{:?}", unit.messages);
    unsafe {
        let category = c"logStatusWarning".as_ptr();
        let set = fmi3SetDebugLogging(unit.instance, false, 1, &raw const category);
        assert_eq!(set, Status::Ok);
        assert_eq!(fmi3Reset(unit.instance), Status::Ok);
        assert_eq!(told(&unit), at_first);
        assert_eq!(
            fmi3SetDebugLogging(unit.instance, true, 0, null()),
            Status::Ok
        );
        assert_eq!(fmi3Reset(unit.instance), Status::Ok);
    }
    assert_eq!(told(&unit), 2 * at_first);
}
