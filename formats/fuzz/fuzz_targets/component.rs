//! A component's description with all of its lists.
#![no_main]

use dcb_formats::read_description;
use dcb_formats_fuzz::{file, refused};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    let path = file("part.json", data);
    match read_description(&path) {
        Ok(description) => {
            for rows in [0, 1, 15] {
                if let Err(error) = description.dof_map(rows, &path) {
                    refused(&error.to_string());
                }
            }
        }
        Err(error) => refused(&error.to_string()),
    }
});
