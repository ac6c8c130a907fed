//! Formulas in the time, read, evaluated and integrated.
#![no_main]

use dcb_formats_fuzz::refused;
use dcb_formats::function::{Function, TimeFunction};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|text: &str| {
    let formula = Function::Formula(text.into());
    match TimeFunction::new(&formula) {
        Ok(function) => {
            for time in [-1.0, 0.0, 0.5, 1e3] {
                let _ = function.evaluate(time, 0.0);
            }
            if let Err(error) = TimeFunction::integral_of(&formula, 1.0) {
                refused(&error.to_string());
            }
        }
        Err(error) => refused(&error.to_string()),
    }
});
