//! Results files: everything that can be asked of one.
#![no_main]

use dcb_formats::results::Results;
use dcb_formats_fuzz::{file, refused};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    let path = file("results.h5", data);
    let results = match Results::open(&path) {
        Ok(results) => results,
        Err(error) => return refused(&error.to_string()),
    };
    let mut errors = Vec::new();
    errors.extend(results.time().err());
    errors.extend(results.events().err());
    for name in ["scene", "inputs", "options", "warnings", "summary"] {
        errors.extend(results.provenance(name).err());
    }
    for channel in results.channels() {
        errors.extend(results.history(&channel.path).err());
    }
    for error in errors {
        refused(&error.to_string());
    }
});
