//! Oracles and helpers of the cross-crate tests. Nothing here shares code with what it checks: dense matrices, faer's and
//! nalgebra's dense routines, explicit loops over nodes and over quadrature points.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

pub mod accuracy;
pub mod dense;
pub mod error_estimate;
pub mod fields;
pub mod hard;
pub mod localization;
pub mod mechanism;
pub mod motion;
pub mod nodal;
pub mod oracle;
pub mod own_process;
pub mod pages;
pub mod parts;
pub mod python;
pub mod random_parts;
pub mod reference;
pub mod rod;
pub mod synthetic;
pub mod turned;

use std::path::Path;

use dcb_formats::dcb::{Contents, WriteOptions, write_superelement};
use dcb_formats::output::Replace;
use dcb_formats::{Component, Superelement};
use dcb_reducer::{Reduced, Reduction, reduce};

/// The `count` lowest modes of a part that can be reduced.
pub fn lowest(component: &Component, count: usize) -> Reduced {
    with(component, &Reduction::lowest(count))
}

/// A reduction that succeeds.
pub fn with(component: &Component, options: &Reduction) -> Reduced {
    match reduce(component, options, &mut ()) {
        Ok(reduced) => reduced,
        Err(error) => panic!("{}: {error}", component.name),
    }
}

/// The message of a reduction that is refused.
pub fn refusal(component: &Component) -> String {
    match reduce(component, &Reduction::lowest(4), &mut ()) {
        Ok(_) => panic!("{} was reduced", component.name),
        Err(error) => error.to_string(),
    }
}

/// Asserts that a message has all these parts.
pub fn assert_says(message: &str, parts: &[&str]) {
    for part in parts {
        assert!(message.contains(part), "{part:?} is missing in {message:?}");
    }
}

/// Writes a superelement without nodal fields and mesh over whatever is there.
pub fn write_bare(path: &Path, superelement: &Superelement) {
    let contents = Contents {
        superelement,
        recovery: None,
        mesh: None,
    };
    let options = WriteOptions {
        replace_existing: Replace::Overwrite,
        ..WriteOptions::default()
    };
    write_superelement(path, &contents, &options).expect("a file");
}
