//! Superelements put together, against the reduction of the whole mesh, closed forms and bounds.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::needless_range_loop
)]

mod bounds;
mod refusals;
mod springs;
mod stress;
mod whole_mesh;

use std::path::{Path, PathBuf};

use dcb_assembly::{Assembled, Error, Inside, KeptModes, LoadedPart, LooseMotions, Options};
use dcb_formats::Component;
use dcb_formats::assembly::Assembly;
use dcb_reducer::Reduced;

/// Two parts, end to end, in the places that their components have.
const HALVES: &str = r#"{"dimension": 3, "units": {"length": "m", "mass": "kg", "time": "s"},
  "bodies": {"first": {"superelement": "first.dcb.h5"}, "second": {"superelement": "second.dcb.h5"}},
  "joints": {"weld": {"fixed": {"a": "first/b", "b": "second/a"}}},
  "interfaces": {"a": "first/a", "b": "second/b"}}"#;

/// A reduced part as if it had been read from a file.
fn loaded(component: &Component, reduced: Reduced, name: &str) -> Option<LoadedPart> {
    Some(LoadedPart {
        superelement: reduced.superelement,
        inside: Inside {
            recovery: Some(reduced.recovery),
            mesh: Some(component.mesh.clone()),
        },
        file: PathBuf::from(format!("{name}.dcb.h5")),
        digest: name.to_owned(),
    })
}

fn assembly(text: &str) -> Assembly {
    Assembly::parse(text, Path::new("machine.json")).unwrap()
}

fn put_together(
    text: &str,
    parts: Vec<Option<LoadedPart>>,
    modes: usize,
) -> Result<Assembled, Error> {
    let options = Options {
        modes: KeptModes::Lowest(modes),
        loose: LooseMotions::Refuse,
    };
    dcb_assembly::assemble(&assembly(text), parts, &options)
}
