//! Saved states lead to the same future, in memory and as bytes.
//!
//! A restored state, and all that is computed from it on, is the same to the last bit.

use dcb_fmu::{Status, fmi3GetFMUState, fmi3Reset};

use crate::importer::Importer;
use crate::support::{arm, arm_scene, slider_crank};

const SHOWN: [&str; 6] = [
    "time",
    "tip.x",
    "tip.y",
    "tip.z",
    "pull.fx",
    "energy_defect",
];

/// Off and on the grid of steps; the state after a return is also that of an instance that was never anywhere else.
#[test]
fn a_saved_state_has_one_future() {
    let folder = arm();
    let unpacked = folder.unpacked("unit");
    let unit = Importer::started(&unpacked);
    unit.must_set("motor", 2.0);
    unit.go(2.5e-3, 0..11);
    let state = unit.save();
    let now = unit.get_all(&SHOWN);
    unit.go(2.5e-3, 11..31);
    let future = unit.get_all(&SHOWN);
    unit.must_set("motor", -5.0);
    unit.go(2.5e-3, 31..40);
    assert_eq!(unit.restore(state), Status::Ok);
    assert_eq!(unit.get_all(&SHOWN), now);
    assert_eq!(unit.get("motor"), 2.0);
    unit.go(2.5e-3, 11..31);
    assert_eq!(unit.get_all(&SHOWN), future);

    let bytes = unit.serialized(state);
    unit.free_state(state);
    drop(unit);
    // An instance of the same archive that hasn't even begun.
    let other = Importer::of(&unpacked);
    let state = other.deserialized(&bytes).unwrap();
    assert_eq!(other.serialized(state), bytes);
    assert_eq!(other.restore(state), Status::Ok);
    assert_eq!(other.get_all(&SHOWN), now);
    other.go(2.5e-3, 11..31);
    assert_eq!(other.get_all(&SHOWN), future);
    other.free_state(state);
}

/// Bytes are made without any influence on the motion.
#[test]
fn bytes_are_read_without_touching_the_motion() {
    let folder = arm();
    let unpacked = folder.unpacked("unit");
    let [unit, other] = [(); 2].map(|()| Importer::started(&unpacked));
    let state = other.save();
    let bytes = other.serialized(state);
    for index in 0..20 {
        unit.go(1e-3, index..index + 1);
        let read = unit.deserialized(&bytes).unwrap();
        unit.free_state(read);
    }
    let alone = Importer::started(&unpacked);
    alone.go(1e-3, 0..20);
    assert_eq!(unit.get_all(&SHOWN), alone.get_all(&SHOWN));
    other.free_state(state);
}

/// A state carries the parameters that its motion was made with, whatever the instance has now.
#[test]
fn a_state_brings_its_parameters_along() {
    let folder = arm();
    let unit = Importer::of(&folder.unpacked("unit"));
    unit.must_set("gravity.x", 3.0);
    unit.must_set("integrator.step", 5e-4);
    unit.start();
    unit.go(1e-3, 0..10);
    let state = unit.save();
    unit.go(1e-3, 10..20);
    let future = unit.get_all(&SHOWN);
    assert_eq!(unsafe { fmi3Reset(unit.instance) }, Status::Ok);
    unit.start();
    unit.go(1e-3, 0..20);
    assert_ne!(unit.get_all(&SHOWN), future);
    assert_eq!(unit.restore(state), Status::Ok);
    assert_eq!(unit.get_all(&["gravity.x", "integrator.step"]), [3.0, 5e-4]);
    unit.go(1e-3, 10..20);
    assert_eq!(unit.get_all(&SHOWN), future);
    // A state in the place of another one.
    let mut place = state;
    assert_eq!(
        unsafe { fmi3GetFMUState(unit.instance, &raw mut place) },
        Status::Ok
    );
    assert_eq!(place, state);
    assert_eq!(unit.restore(place), Status::Ok);
    assert_eq!(unit.get_all(&SHOWN), future);
    unit.free_state(place);
}

#[test]
fn an_adaptive_state_carries_its_step() {
    let folder = arm();
    let mut scene = arm_scene();
    scene["integrator"]["generalized_alpha"]["adaptive"] =
        serde_json::json!({"tolerance": 1e-5, "minimum_step": 1e-6, "maximum_step": 5e-3});
    folder.write_scene(&scene);
    let unpacked = folder.unpacked("unit");
    let unit = Importer::started(&unpacked);
    unit.go(0.02, 0..3);
    let state = unit.save();
    let bytes = unit.serialized(state);
    unit.go(0.02, 3..6);
    let other = Importer::started(&unpacked);
    let read = other.deserialized(&bytes).unwrap();
    assert_eq!(other.restore(read), Status::Ok);
    other.go(0.02, 3..6);
    assert_eq!(other.get_all(&SHOWN), unit.get_all(&SHOWN));
    unit.free_state(state);
    other.free_state(read);
}

#[test]
fn damaged_and_foreign_states_are_refused() {
    let folder = arm();
    let unit = Importer::started(&folder.unpacked("unit"));
    let state = unit.save();
    let bytes = unit.serialized(state);
    for place in (0..bytes.len()).step_by(97) {
        let mut damaged = bytes.clone();
        damaged[place] ^= 0x10;
        let told = unit.deserialized(&damaged).unwrap_err();
        assert!(told.contains("the saved state can't be used: "), "{told}");
        assert!(unit.deserialized(&bytes[..place]).is_err());
    }
    let other = slider_crank();
    let other = Importer::started(&other.unpacked("unit"));
    let told = other.deserialized(&bytes).unwrap_err();
    assert!(told.contains("it is of another unit"), "{told}");
    assert_eq!(other.restore(state), Status::Error);
    assert!(other.last_message().contains("it is of another unit"));
    unit.free_state(state);
}
