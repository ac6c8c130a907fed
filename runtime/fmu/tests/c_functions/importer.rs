//! An importer: it has nothing but pointers to the functions of the standard and the model description.

use std::collections::BTreeMap;
use std::ffi::{CStr, CString, c_char, c_void};
use std::ptr::{null, null_mut};
use std::sync::Mutex;

use dcb_fmu::*;

use crate::support::Unpacked;

/// What an instance told.
pub type Messages = Mutex<Vec<(Status, String, String)>>;

/// An instance in the hands of an importer.
pub struct Importer {
    pub instance: *mut c_void,
    references: BTreeMap<String, u32>,
    pub messages: Box<Messages>,
}

// SAFETY: an instance may be used by any thread, by one at a time.
unsafe impl Send for Importer {}

pub unsafe extern "C" fn log(
    environment: *mut c_void,
    status: Status,
    category: *const c_char,
    message: *const c_char,
) {
    let text = |pointer| {
        unsafe { CStr::from_ptr(pointer) }
            .to_str()
            .unwrap()
            .to_owned()
    };
    let messages = unsafe { &*environment.cast::<Messages>() };
    let told = (status, text(category), text(message));
    messages.lock().unwrap().push(told);
}

/// Instantiates, or tells why not.
pub fn instantiate(resources: &str, token: &str, is_with_events: bool) -> Result<Importer, String> {
    let messages = Box::<Messages>::default();
    let texts = ["test", token, resources].map(|text| CString::new(text).unwrap());
    let [name, token, resources] = &texts;
    let environment = (&raw const *messages).cast_mut().cast();
    let instance = unsafe {
        fmi3InstantiateCoSimulation(
            name.as_ptr(),
            token.as_ptr(),
            resources.as_ptr(),
            false,
            true,
            is_with_events,
            false,
            null(),
            0,
            environment,
            Some(log),
            null(),
        )
    };
    if instance.is_null() {
        let (status, category, message) = messages.lock().unwrap().pop().unwrap();
        assert_eq!(
            (status, category.as_str()),
            (Status::Error, "logStatusError")
        );
        return Err(message);
    }
    Ok(Importer {
        instance,
        references: BTreeMap::new(),
        messages,
    })
}

impl Importer {
    pub fn of(unpacked: &Unpacked) -> Self {
        let resources = unpacked.resources.to_str().unwrap();
        let mut importer = instantiate(resources, &unpacked.token, false).unwrap();
        for line in unpacked.description.lines() {
            let value = |key: &str| {
                let (_, rest) = line.split_once(key)?;
                Some(rest.split_once('"').unwrap().0)
            };
            if line.trim_start().starts_with("<Float64 ") {
                let name = value(" name=\"").unwrap().to_owned();
                let reference = value(" valueReference=\"").unwrap().parse().unwrap();
                importer.references.insert(name, reference);
            }
        }
        importer
    }

    /// Initialized, with the start values of the model description.
    pub fn started(unpacked: &Unpacked) -> Self {
        let importer = Self::of(unpacked);
        importer.start();
        importer
    }

    pub fn start(&self) {
        assert_eq!(self.enter(0.0), Status::Ok);
        assert_eq!(self.exit(), Status::Ok, "{:?}", self.messages);
    }

    pub fn enter(&self, start: f64) -> Status {
        unsafe { fmi3EnterInitializationMode(self.instance, false, 0.0, start, false, 0.0) }
    }

    pub fn exit(&self) -> Status {
        unsafe { fmi3ExitInitializationMode(self.instance) }
    }

    pub fn get(&self, name: &str) -> f64 {
        self.get_all(&[name])[0]
    }

    pub fn get_all(&self, names: &[&str]) -> Vec<f64> {
        let references: Vec<u32> = names.iter().map(|name| self.references[*name]).collect();
        let mut values = vec![f64::NAN; names.len()];
        let (count, place) = (names.len(), values.as_mut_ptr());
        let status =
            unsafe { fmi3GetFloat64(self.instance, references.as_ptr(), count, place, count) };
        assert_eq!(status, Status::Ok, "{:?}", self.messages);
        values
    }

    pub fn set(&self, name: &str, value: f64) -> Status {
        let reference = self.references[name];
        unsafe { fmi3SetFloat64(self.instance, &raw const reference, 1, &raw const value, 1) }
    }

    pub fn must_set(&self, name: &str, value: f64) {
        assert_eq!(self.set(name, value), Status::Ok, "{:?}", self.messages);
    }

    /// A step: the status, and how far it came.
    pub fn step(&self, from: f64, length: f64) -> (Status, f64) {
        let (mut events, mut ends, mut early) = (true, true, true);
        let mut reached = f64::NAN;
        let status = unsafe {
            fmi3DoStep(
                self.instance,
                from,
                length,
                true,
                &raw mut events,
                &raw mut ends,
                &raw mut early,
                &raw mut reached,
            )
        };
        assert!(!(events || ends || early));
        (status, reached)
    }

    /// Steps from one multiple of a length to another.
    pub fn go(&self, length: f64, steps: std::ops::Range<usize>) {
        for index in steps {
            let (from, to) = (index as f64 * length, (index + 1) as f64 * length);
            let (status, reached) = self.step(from, to - from);
            assert_eq!(status, Status::Ok, "{:?}", self.messages);
            assert!((reached - to).abs() <= 1e-12 * to);
        }
    }

    pub fn last_message(&self) -> String {
        let messages = self.messages.lock().unwrap();
        messages.last().unwrap().2.clone()
    }

    pub fn save(&self) -> *mut c_void {
        let mut state = null_mut();
        let status = unsafe { fmi3GetFMUState(self.instance, &raw mut state) };
        assert_eq!(status, Status::Ok, "{:?}", self.messages);
        state
    }

    pub fn restore(&self, state: *mut c_void) -> Status {
        unsafe { fmi3SetFMUState(self.instance, state) }
    }

    pub fn serialized(&self, state: *mut c_void) -> Vec<u8> {
        let mut size = 0;
        let asked = unsafe { fmi3SerializedFMUStateSize(self.instance, state, &raw mut size) };
        assert_eq!(asked, Status::Ok);
        let mut bytes = vec![0; size];
        let written =
            unsafe { fmi3SerializeFMUState(self.instance, state, bytes.as_mut_ptr(), size) };
        assert_eq!(written, Status::Ok);
        bytes
    }

    pub fn deserialized(&self, bytes: &[u8]) -> Result<*mut c_void, String> {
        let mut state = null_mut();
        let status = unsafe {
            fmi3DeserializeFMUState(self.instance, bytes.as_ptr(), bytes.len(), &raw mut state)
        };
        match status {
            Status::Ok => Ok(state),
            _ => Err(self.last_message()),
        }
    }

    pub fn free_state(&self, mut state: *mut c_void) {
        unsafe { fmi3FreeFMUState(self.instance, &raw mut state) };
        assert!(state.is_null());
    }
}

impl Drop for Importer {
    fn drop(&mut self) {
        unsafe { fmi3FreeInstance(self.instance) };
    }
}
