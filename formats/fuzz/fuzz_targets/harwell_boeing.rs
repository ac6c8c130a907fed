//! Other programs' files that begin as those of the seeds do, as `reduce import` reads them.
#![no_main]

use dcb_formats_fuzz::matrices;
use libfuzzer_sys::fuzz_target;

fuzz_target!(|data: &[u8]| matrices(data));
