//! Saved states in the hands of an importer.

use std::ffi::c_void;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::ptr::null_mut;

use dcb_cosimulation::SavedState;

use crate::instance::{Condition, Instance, answer};
use crate::life::{slice, slice_mut};
use crate::status::Status;

/// A pointer is missing.
const NULL: &str = "a pointer is null";

/// Saves the state. Where `*state` is one already, it is overwritten.
///
/// # Safety
/// That of the standard ([`crate`]).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetFMUState(instance: *mut c_void, state: *mut *mut c_void) -> Status {
    let work = |instance: &mut Instance| {
        if instance.condition == Condition::Failed {
            return Err("a step failed: there is no state to save".to_owned());
        }
        let saved = instance.unit.save().map_err(|error| error.to_string())?;
        // SAFETY: a place for a state, as demanded.
        unsafe { hand_over(state, saved) }
    };
    // SAFETY: as demanded.
    unsafe { answer(instance, "fmi3GetFMUState", work) }
}

/// Goes back, or on, to a saved state.
///
/// # Safety
/// That of the standard ([`crate`]).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetFMUState(instance: *mut c_void, state: *mut c_void) -> Status {
    let work = |instance: &mut Instance| {
        // SAFETY: null or a state, as demanded.
        let saved = unsafe { state.cast::<SavedState>().as_ref() }.ok_or(NULL)?;
        let restored = instance.unit.restore(saved);
        restored.map_err(|error| error.to_string())?;
        instance.condition = Condition::Whole;
        Ok::<(), String>(())
    };
    // SAFETY: as demanded.
    unsafe { answer(instance, "fmi3SetFMUState", work) }
}

/// Frees a saved state.
///
/// # Safety
/// That of the standard ([`crate`]).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3FreeFMUState(
    _instance: *mut c_void,
    state: *mut *mut c_void,
) -> Status {
    // SAFETY: null or a place for a state, as demanded.
    if let Some(place) = unsafe { state.as_mut() }
        && !place.is_null()
    {
        let saved = std::mem::replace(place, null_mut()).cast::<SavedState>();
        // SAFETY: made by `Box::into_raw` of this type and given back once, as demanded.
        let saved = unsafe { Box::from_raw(saved) };
        let _ = catch_unwind(AssertUnwindSafe(|| drop(saved)));
    }
    Status::Ok
}

/// How many bytes a saved state has.
///
/// # Safety
/// That of the standard ([`crate`]).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SerializedFMUStateSize(
    instance: *mut c_void,
    state: *mut c_void,
    size: *mut usize,
) -> Status {
    let work = |_: &mut Instance| {
        // SAFETY: null or a state, and a place for a number, as demanded.
        let (saved, size) = unsafe { (state.cast::<SavedState>().as_ref(), size.as_mut()) };
        let (saved, size) = saved.zip(size).ok_or(NULL)?;
        *size = saved.bytes().len();
        Ok::<(), &str>(())
    };
    // SAFETY: as demanded.
    unsafe { answer(instance, "fmi3SerializedFMUStateSize", work) }
}

/// Writes a saved state as bytes.
///
/// # Safety
/// That of the standard ([`crate`]).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SerializeFMUState(
    instance: *mut c_void,
    state: *mut c_void,
    serialized_state: *mut u8,
    size: usize,
) -> Status {
    let work = |_: &mut Instance| {
        // SAFETY: null or a state, and so many bytes, as demanded.
        let (saved, room) = unsafe {
            (
                state.cast::<SavedState>().as_ref(),
                slice_mut(serialized_state, size),
            )
        };
        let (saved, room) = saved.zip(room).ok_or(NULL)?;
        let bytes = saved.bytes();
        let count = bytes.len();
        let room = room
            .get_mut(..count)
            .ok_or_else(|| format!("the state has {count} bytes, but there is room for {size}"))?;
        room.copy_from_slice(&bytes);
        Ok::<(), String>(())
    };
    // SAFETY: as demanded.
    unsafe { answer(instance, "fmi3SerializeFMUState", work) }
}

/// Makes a saved state of bytes.
///
/// # Safety
/// That of the standard ([`crate`]).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3DeserializeFMUState(
    instance: *mut c_void,
    serialized_state: *const u8,
    size: usize,
    state: *mut *mut c_void,
) -> Status {
    let work = |instance: &mut Instance| {
        // SAFETY: so many bytes, as demanded.
        let bytes = unsafe { slice(serialized_state, size) }.ok_or(NULL)?;
        let saved = instance.unit.state_of_bytes(bytes);
        let saved = saved.map_err(|error| error.to_string())?;
        // SAFETY: a place for a state, as demanded.
        unsafe { hand_over(state, saved) }
    };
    // SAFETY: as demanded.
    unsafe { answer(instance, "fmi3DeserializeFMUState", work) }
}

/// Gives a state to the importer.
///
/// # Safety
/// Null, or a place for a state that is null or one of this library.
unsafe fn hand_over(place: *mut *mut c_void, saved: SavedState) -> Result<(), String> {
    // SAFETY: as demanded.
    let place = unsafe { place.as_mut() }.ok_or(NULL)?;
    // SAFETY: as demanded.
    match unsafe { place.cast::<SavedState>().as_mut() } {
        Some(there) => *there = saved,
        None => *place = Box::into_raw(Box::new(saved)).cast(),
    }
    Ok(())
}
