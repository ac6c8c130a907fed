//! Values of variables: all of them are `Float64`.

use std::ffi::{c_char, c_void};

use crate::instance::{Instance, answer};
use crate::life::{slice, slice_mut};
use crate::status::Status;

/// An array is missing.
const NULL: &str = "an array is null";

/// Values of variables.
///
/// # Safety
/// That of the standard ([`crate`]).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3GetFloat64(
    instance: *mut c_void,
    value_references: *const u32,
    reference_count: usize,
    values: *mut f64,
    value_count: usize,
) -> Status {
    let work = |instance: &mut Instance| {
        is_one_each(reference_count, value_count)?;
        // SAFETY: arrays of these lengths, as demanded.
        let arrays =
            unsafe { slice(value_references, reference_count).zip(slice_mut(values, value_count)) };
        let (references, values) = arrays.ok_or(NULL)?;
        for (reference, value) in references.iter().zip(values) {
            let found = instance.unit.value(*reference);
            *value = found.map_err(|error| error.to_string())?;
        }
        Ok::<(), String>(())
    };
    // SAFETY: as demanded.
    unsafe { answer(instance, "fmi3GetFloat64", work) }
}

/// Sets parameters and inputs.
///
/// # Safety
/// That of the standard ([`crate`]).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetFloat64(
    instance: *mut c_void,
    value_references: *const u32,
    reference_count: usize,
    values: *const f64,
    value_count: usize,
) -> Status {
    let work = |instance: &mut Instance| {
        is_one_each(reference_count, value_count)?;
        // SAFETY: arrays of these lengths, as demanded.
        let arrays =
            unsafe { slice(value_references, reference_count).zip(slice(values, value_count)) };
        let (references, values) = arrays.ok_or(NULL)?;
        for (reference, value) in references.iter().zip(values) {
            let set = instance.unit.set(*reference, *value);
            set.map_err(|error| error.to_string())?;
        }
        Ok::<(), String>(())
    };
    // SAFETY: as demanded.
    unsafe { answer(instance, "fmi3SetFloat64", work) }
}

fn is_one_each(references: usize, values: usize) -> Result<(), String> {
    match references == values {
        true => Ok(()),
        false => Err(format!(
            "{references} value references, but {values} values: every variable is one number"
        )),
    }
}

/// Functions for types that no variable has: well without variables, else an error.
macro_rules! other_types {
    ($($name:ident($($type:ty),*);)*) => {$(
        /// No variable has this type: an error, unless nothing is asked for.
        ///
        /// # Safety
        /// That of the standard ([`crate`]).
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name(
            instance: *mut c_void,
            _value_references: *const u32,
            reference_count: usize,
            $(_: $type),*
        ) -> Status {
            let work = |_: &mut Instance| match reference_count {
                0 => Ok(()),
                _ => Err("all variables of the unit are Float64"),
            };
            // SAFETY: as demanded.
            unsafe { answer(instance, stringify!($name), work) }
        }
    )*};
}

other_types! {
    fmi3GetFloat32(*mut f32, usize);
    fmi3GetInt8(*mut i8, usize);
    fmi3GetUInt8(*mut u8, usize);
    fmi3GetInt16(*mut i16, usize);
    fmi3GetUInt16(*mut u16, usize);
    fmi3GetInt32(*mut i32, usize);
    fmi3GetUInt32(*mut u32, usize);
    fmi3GetInt64(*mut i64, usize);
    fmi3GetUInt64(*mut u64, usize);
    fmi3GetBoolean(*mut bool, usize);
    fmi3GetString(*mut *const c_char, usize);
    fmi3GetBinary(*mut usize, *mut *const u8, usize);
    fmi3GetClock(*mut bool);
    fmi3SetFloat32(*const f32, usize);
    fmi3SetInt8(*const i8, usize);
    fmi3SetUInt8(*const u8, usize);
    fmi3SetInt16(*const i16, usize);
    fmi3SetUInt16(*const u16, usize);
    fmi3SetInt32(*const i32, usize);
    fmi3SetUInt32(*const u32, usize);
    fmi3SetInt64(*const i64, usize);
    fmi3SetUInt64(*const u64, usize);
    fmi3SetBoolean(*const bool, usize);
    fmi3SetString(*const *const c_char, usize);
    fmi3SetBinary(*const usize, *const *const u8, usize);
    fmi3SetClock(*const bool);
}
