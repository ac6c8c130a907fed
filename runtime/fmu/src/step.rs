//! Communication steps.

use std::ffi::c_void;

use crate::instance::{Condition, Instance, answer};
use crate::status::Status;

/// Moves from one communication point to the next. Neither events nor an early return come of it.
///
/// # Safety
/// That of the standard ([`crate`]).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3DoStep(
    instance: *mut c_void,
    current_communication_point: f64,
    communication_step_size: f64,
    _no_set_fmu_state_prior_to_current_point: bool,
    event_handling_needed: *mut bool,
    terminate_simulation: *mut bool,
    early_return: *mut bool,
    last_successful_time: *mut f64,
) -> Status {
    for pointer in [event_handling_needed, terminate_simulation, early_return] {
        if !pointer.is_null() {
            // SAFETY: a place for a boolean, as demanded.
            unsafe { pointer.write(false) };
        }
    }
    let mut reached = current_communication_point;
    let work = |instance: &mut Instance| {
        if instance.condition == Condition::Failed {
            return Err("an earlier step failed; reset the unit or set a saved state".to_owned());
        }
        let before = instance.unit.time_reached();
        let made = instance
            .unit
            .step(current_communication_point, communication_step_size);
        let after = instance.unit.time_reached();
        if made.is_ok() {
            reached = instance.unit.time();
        } else if after > before {
            // The motion is between communication points.
            reached = after;
            instance.condition = Condition::Failed;
        }
        made.map_err(|error| error.to_string())
    };
    // SAFETY: as demanded.
    let status = unsafe { answer(instance, "fmi3DoStep", work) };
    if !last_successful_time.is_null() {
        // SAFETY: a place for a number, as demanded.
        unsafe { last_successful_time.write(reached) };
    }
    status
}
