//! Manifests of batches.
#![no_main]

use dcb_formats_fuzz::{file, refused};
use dcb_reducer::batch::manifest::read_manifest;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    if let Err(error) = read_manifest(&file("batch.json", data)) {
        refused(&error.to_string());
    }
});
