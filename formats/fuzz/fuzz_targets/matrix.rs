//! Matrix Market, packed or not, as every command reads it.
#![no_main]

use dcb_formats::matrix::{read_matrix, read_symmetric_operator};
use dcb_formats_fuzz::{file, refused};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| {
    let name = match data.starts_with(&[0x1f, 0x8b]) {
        true => "part.mtx.gz",
        false => "part.mtx",
    };
    let path = file(name, data);
    if let Err(error) = read_matrix(&path) {
        refused(&error.to_string());
    }
    if let Err(error) = read_symmetric_operator(&path) {
        refused(&error.to_string());
    }
});
