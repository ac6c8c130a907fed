//! Functions of FMI 3.0 that the unit doesn't have, because its model description doesn't claim them.

use std::ffi::{c_int, c_void};

use crate::instance::{Instance, answer};
use crate::status::Status;

macro_rules! unsupported {
    ($($why:literal: { $($name:ident($($type:ty),*);)* })*) => {$($(
        /// Not claimed by the model description: an error with a message.
        ///
        /// # Safety
        /// That of the standard ([`crate`]).
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $name(instance: *mut c_void, $(_: $type),*) -> Status {
            let work = |_: &mut Instance| Err::<(), _>($why);
            // SAFETY: as demanded.
            unsafe { answer(instance, stringify!($name), work) }
        }
    )*)*};
}

unsupported! {
    "the unit has no event mode: hasEventMode is false": {
        fmi3EnterEventMode();
        fmi3EnterStepMode();
        fmi3EvaluateDiscreteStates();
        fmi3UpdateDiscreteStates(*mut bool, *mut bool, *mut bool, *mut bool, *mut bool, *mut f64);
    }
    "the unit has no clocks": {
        fmi3GetIntervalDecimal(*const u32, usize, *mut f64, *mut c_int);
        fmi3GetIntervalFraction(*const u32, usize, *mut u64, *mut u64, *mut c_int);
        fmi3GetShiftDecimal(*const u32, usize, *mut f64);
        fmi3GetShiftFraction(*const u32, usize, *mut u64, *mut u64);
        fmi3SetIntervalDecimal(*const u32, usize, *const f64);
        fmi3SetIntervalFraction(*const u32, usize, *const u64, *const u64);
        fmi3SetShiftDecimal(*const u32, usize, *const f64);
        fmi3SetShiftFraction(*const u32, usize, *const u64, *const u64);
        fmi3ActivateModelPartition(u32, f64);
    }
    "the unit has no structural parameters": {
        fmi3EnterConfigurationMode();
        fmi3ExitConfigurationMode();
    }
    "dependencies aren't known element by element: providesPerElementDependencies is false": {
        fmi3GetNumberOfVariableDependencies(u32, *mut usize);
        fmi3GetVariableDependencies(u32, *mut usize, *mut u32, *mut usize, *mut c_int, usize);
    }
    "the unit has no derivatives: providesDirectionalDerivatives, providesAdjointDerivatives and maxOutputDerivativeOrder aren't set": {
        fmi3GetDirectionalDerivative(*const u32, usize, *const u32, usize, *const f64, usize, *mut f64, usize);
        fmi3GetAdjointDerivative(*const u32, usize, *const u32, usize, *const f64, usize, *mut f64, usize);
        fmi3GetOutputDerivatives(*const u32, usize, *const i32, *mut f64, usize);
    }
    "the unit is for co-simulation only": {
        fmi3EnterContinuousTimeMode();
        fmi3CompletedIntegratorStep(bool, *mut bool, *mut bool);
        fmi3SetTime(f64);
        fmi3SetContinuousStates(*const f64, usize);
        fmi3GetContinuousStateDerivatives(*mut f64, usize);
        fmi3GetEventIndicators(*mut f64, usize);
        fmi3GetContinuousStates(*mut f64, usize);
        fmi3GetNominalsOfContinuousStates(*mut f64, usize);
        fmi3GetNumberOfEventIndicators(*mut usize);
        fmi3GetNumberOfContinuousStates(*mut usize);
    }
}
