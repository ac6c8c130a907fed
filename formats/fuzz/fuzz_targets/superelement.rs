//! `.dcb.h5`: everything that can be asked of a file. Built for fuzzing, digests aren't compared: no mutation could guess them.
#![no_main]

use dcb_formats::Error;
use dcb_formats::dcb::SuperelementFile;
use dcb_formats_fuzz::{file, refused};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    let path = file("part.dcb.h5", data);
    let opened = match SuperelementFile::open(&path) {
        Ok(opened) => opened,
        Err(error) => return refused(&error.to_string()),
    };
    let answers: [Result<(), Error>; 5] = [
        opened.superelement().map(drop),
        opened.recovery().map(drop),
        opened.recovery_of(&[0, 2]).map(drop),
        opened.mesh().map(drop),
        opened.verify_digests().map(drop),
    ];
    for error in answers.into_iter().filter_map(Result::err) {
        refused(&error.to_string());
    }
});
