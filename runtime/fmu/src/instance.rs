//! What an importer holds: a unit, its log, and whether it is still whole.

use std::any::Any;
use std::ffi::c_void;
use std::panic::{AssertUnwindSafe, catch_unwind};

use dcb_cosimulation::CoSimulation;

use crate::status::{Log, Status};

/// A unit in the hands of an importer.
pub(crate) struct Instance {
    pub unit: CoSimulation,
    pub log: Log,
    pub condition: Condition,
}

/// What is left of an instance.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Condition {
    /// All.
    Whole,
    /// A step or a start failed: a reset or a saved state makes it whole.
    Failed,
    /// A panic left it in no known state.
    Broken,
}

/// Answers a call: errors and panics are told and become a status.
///
/// # Safety
/// `instance` is null or comes from this library, isn't freed, and nothing else uses it meanwhile.
pub(crate) unsafe fn answer<E: ToString>(
    instance: *mut c_void,
    call: &str,
    work: impl FnOnce(&mut Instance) -> Result<(), E>,
) -> Status {
    // SAFETY: as demanded above.
    let Some(instance) = (unsafe { instance.cast::<Instance>().as_mut() }) else {
        return Status::Error;
    };
    if instance.condition == Condition::Broken {
        return Status::Fatal;
    }
    let done = catch_unwind(AssertUnwindSafe(|| {
        work(instance).map_err(|error| error.to_string())
    }));
    for warning in instance.unit.take_warnings() {
        instance.log.tell(Status::Warning, &warning);
    }
    match done {
        Ok(Ok(())) => Status::Ok,
        Ok(Err(message)) => {
            instance
                .log
                .tell(Status::Error, &format!("{call}: {message}"));
            Status::Error
        }
        Err(panic) => {
            instance.condition = Condition::Broken;
            instance.log.tell(Status::Fatal, &defect(call, &*panic));
            Status::Fatal
        }
    }
}

/// The message of a panic.
pub(crate) fn defect(call: &str, panic: &(dyn Any + Send)) -> String {
    let text = panic
        .downcast_ref::<&str>()
        .copied()
        .or_else(|| panic.downcast_ref::<String>().map(String::as_str));
    format!(
        "{call}: a defect of the unit, please report it: {}",
        text.unwrap_or("no further message")
    )
}

#[cfg(test)]
#[expect(
    clippy::unwrap_used,
    clippy::panic,
    reason = "a test says what went wrong by failing"
)]
mod tests {
    use std::ptr::null_mut;

    use super::*;

    /// A pendulum without superelements.
    const SCENE: &str = r#"{
        "dimension": 2, "units": {"length": "m", "mass": "kg", "time": "s"}, "gravity": [0, -9.81],
        "bodies": {"bob": {"rigid": {"mass": 1, "inertia": 1e-6, "points": {"pivot": [-0.5, 0]}}, "position": [0.5, 0]}},
        "joints": {"pivot": {"revolute": {"a": "ground", "b": "bob/pivot"}}},
        "integrator": {"generalized_alpha": {"step": 1e-3, "end": 1}}
    }"#;

    #[test]
    fn a_panic_is_fatal_and_stays_inside() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join(dcb_cosimulation::SCENE), SCENE).unwrap();
        let mut instance = Instance {
            unit: CoSimulation::load(folder.path()).unwrap(),
            log: Log::new(null_mut(), None, false),
            condition: Condition::Whole,
        };
        let pointer = (&raw mut instance).cast();
        let fails = |_: &mut Instance| -> Result<(), String> { panic!("a defect") };
        let works = |_: &mut Instance| Ok::<(), String>(());
        // SAFETY: the instance lives on, and nothing else uses it.
        unsafe {
            assert_eq!(answer(pointer, "test", works), Status::Ok);
            assert_eq!(answer(pointer, "test", fails), Status::Fatal);
            assert_eq!(answer(pointer, "test", works), Status::Fatal);
        }
        assert!(defect("test", &"a defect").contains("report it: a defect"));
    }
}
