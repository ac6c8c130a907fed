//! From the making of an instance to its end.

use std::ffi::{CStr, c_char, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::ptr::null_mut;

use dcb_cosimulation::CoSimulation;

use crate::instance::{Condition, Instance, answer, defect};
use crate::status::{Log, LogMessage, Status};

/// The version of the standard.
#[unsafe(no_mangle)]
pub extern "C" fn fmi3GetVersion() -> *const c_char {
    c"3.0".as_ptr()
}

/// Which messages are told: errors are in any case.
///
/// # Safety
/// That of the standard ([`crate`]).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3SetDebugLogging(
    instance: *mut c_void,
    logging_on: bool,
    category_count: usize,
    categories: *const *const c_char,
) -> Status {
    let work = |instance: &mut Instance| {
        // SAFETY: so many texts, as demanded.
        let names = unsafe { slice(categories, category_count) }.ok_or("no categories")?;
        let mut known = Vec::new();
        for name in names {
            // SAFETY: a text, as demanded.
            known.push(unsafe { text(*name) }.ok_or("a category without a name")?);
        }
        instance.log.choose(logging_on, &known)
    };
    // SAFETY: as demanded.
    unsafe { answer(instance, "fmi3SetDebugLogging", work) }
}

/// Makes an instance of the unit in the folder of resources; null where that isn't possible.
///
/// # Safety
/// That of the standard ([`crate`]).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateCoSimulation(
    _instance_name: *const c_char,
    instantiation_token: *const c_char,
    resource_path: *const c_char,
    _visible: bool,
    logging_on: bool,
    event_mode_used: bool,
    _early_return_allowed: bool,
    _required_intermediate_variables: *const u32,
    required_intermediate_variable_count: usize,
    instance_environment: *mut c_void,
    log_message: LogMessage,
    _intermediate_update: *const c_void,
) -> *mut c_void {
    let call = "fmi3InstantiateCoSimulation";
    let log = Log::new(instance_environment, log_message, logging_on);
    let work = || {
        if event_mode_used {
            return Err("the unit has no event mode: hasEventMode is false".to_owned());
        }
        if required_intermediate_variable_count > 0 {
            return Err(
                "the unit has no intermediate update: providesIntermediateUpdate is false".into(),
            );
        }
        // SAFETY: texts, as demanded.
        let (token, path) = unsafe { (text(instantiation_token), text(resource_path)) };
        let token = token.ok_or("there is no instantiation token")?;
        let path = path.ok_or("there is no path of the resources, which the unit is made of")?;
        let unit = CoSimulation::load(&folder(path)?).map_err(|error| error.to_string())?;
        match token.to_bytes() == unit.token().as_bytes() {
            true => Ok(unit),
            false => Err(format!(
                "the instantiation token is {:?}, but that of the resources is {:?}: model description, resources and library aren't of one archive",
                token.to_string_lossy(),
                unit.token()
            )),
        }
    };
    match catch_unwind(AssertUnwindSafe(work)) {
        Ok(Ok(mut unit)) => {
            for warning in unit.take_warnings() {
                log.tell(Status::Warning, &warning);
            }
            let condition = Condition::Whole;
            Box::into_raw(Box::new(Instance {
                unit,
                log,
                condition,
            }))
            .cast()
        }
        Ok(Err(message)) => {
            log.tell(Status::Error, &format!("{call}: {message}"));
            null_mut()
        }
        Err(panic) => {
            log.tell(Status::Fatal, &defect(call, &*panic));
            null_mut()
        }
    }
}

/// The unit is for co-simulation only: null, with a message.
///
/// # Safety
/// That of the standard ([`crate`]).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateModelExchange(
    _instance_name: *const c_char,
    _instantiation_token: *const c_char,
    _resource_path: *const c_char,
    _visible: bool,
    logging_on: bool,
    instance_environment: *mut c_void,
    log_message: LogMessage,
) -> *mut c_void {
    let log = Log::new(instance_environment, log_message, logging_on);
    let message = "fmi3InstantiateModelExchange: the unit is for co-simulation only: its equations are differential-algebraic";
    log.tell(Status::Error, message);
    null_mut()
}

/// The unit is for co-simulation only: null, with a message.
///
/// # Safety
/// That of the standard ([`crate`]).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3InstantiateScheduledExecution(
    _instance_name: *const c_char,
    _instantiation_token: *const c_char,
    _resource_path: *const c_char,
    _visible: bool,
    logging_on: bool,
    instance_environment: *mut c_void,
    log_message: LogMessage,
    _clock_update: *const c_void,
    _lock_preemption: *const c_void,
    _unlock_preemption: *const c_void,
) -> *mut c_void {
    let log = Log::new(instance_environment, log_message, logging_on);
    let message =
        "fmi3InstantiateScheduledExecution: the unit is for co-simulation only: it has no clocks";
    log.tell(Status::Error, message);
    null_mut()
}

/// Ends an instance. Its saved states are freed by themselves.
///
/// # Safety
/// That of the standard ([`crate`]).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3FreeInstance(instance: *mut c_void) {
    if !instance.is_null() {
        // SAFETY: made by `Box::into_raw` of this type and given back once, as demanded.
        let instance = unsafe { Box::from_raw(instance.cast::<Instance>()) };
        let _ = catch_unwind(AssertUnwindSafe(|| drop(instance)));
    }
}

/// Begins the choice of start values. The motion begins at zero; the tolerance isn't used: the unit has parameters of its own for it.
///
/// # Safety
/// That of the standard ([`crate`]).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3EnterInitializationMode(
    instance: *mut c_void,
    _tolerance_defined: bool,
    _tolerance: f64,
    start_time: f64,
    stop_time_defined: bool,
    stop_time: f64,
) -> Status {
    let stop = stop_time_defined.then_some(stop_time);
    let work = |instance: &mut Instance| instance.unit.enter_initialization(start_time, stop);
    // SAFETY: as demanded.
    unsafe { answer(instance, "fmi3EnterInitializationMode", work) }
}

/// Starts the motion.
///
/// # Safety
/// That of the standard ([`crate`]).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3ExitInitializationMode(instance: *mut c_void) -> Status {
    let work = |instance: &mut Instance| instance.unit.exit_initialization();
    // SAFETY: as demanded.
    unsafe { answer(instance, "fmi3ExitInitializationMode", work) }
}

/// Ends the motion.
///
/// # Safety
/// That of the standard ([`crate`]).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3Terminate(instance: *mut c_void) -> Status {
    // SAFETY: as demanded.
    unsafe {
        answer(instance, "fmi3Terminate", |instance| {
            instance.unit.terminate()
        })
    }
}

/// Back to where the instance began, with the start values of the model description.
///
/// # Safety
/// That of the standard ([`crate`]).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn fmi3Reset(instance: *mut c_void) -> Status {
    let work = |instance: &mut Instance| {
        instance.unit.reset()?;
        instance.condition = Condition::Whole;
        Ok::<(), dcb_cosimulation::Error>(())
    };
    // SAFETY: as demanded.
    unsafe { answer(instance, "fmi3Reset", work) }
}

/// A text of the importer; `None` for null.
///
/// # Safety
/// Null, or a text that ends with a zero byte and lives as long as the answer.
unsafe fn text<'a>(pointer: *const c_char) -> Option<&'a CStr> {
    // SAFETY: as demanded.
    (!pointer.is_null()).then(|| unsafe { CStr::from_ptr(pointer) })
}

/// An array of the importer; `None` for null with a length.
///
/// # Safety
/// So many elements, which live as long as the answer.
pub(crate) unsafe fn slice<'a, T>(pointer: *const T, count: usize) -> Option<&'a [T]> {
    match (pointer.is_null(), count) {
        (_, 0) => Some(&[]),
        (true, _) => None,
        // SAFETY: as demanded.
        (false, _) => Some(unsafe { std::slice::from_raw_parts(pointer, count) }),
    }
}

/// An array that is written.
///
/// # Safety
/// So many elements, which live as long as the answer and which nothing else looks at meanwhile.
pub(crate) unsafe fn slice_mut<'a, T>(pointer: *mut T, count: usize) -> Option<&'a mut [T]> {
    match (pointer.is_null(), count) {
        (_, 0) => Some(&mut []),
        (true, _) => None,
        // SAFETY: as demanded.
        (false, _) => Some(unsafe { std::slice::from_raw_parts_mut(pointer, count) }),
    }
}

/// The folder that a path of an importer names.
fn folder(path: &CStr) -> Result<std::path::PathBuf, String> {
    #[cfg(unix)]
    {
        use std::os::unix::ffi::OsStrExt as _;
        Ok(Path::new(std::ffi::OsStr::from_bytes(path.to_bytes())).to_owned())
    }
    #[cfg(not(unix))]
    {
        let path = path.to_str().map_err(|error| error.to_string())?;
        Ok(Path::new(path).to_owned())
    }
}
