//! A reduction as a user would make it, timed: everything after the component is read, up to the file on the disk.

use std::path::Path;
use std::time::Instant;

use dcb_formats::dcb::{Contents, WriteOptions, write_superelement};
use dcb_formats::output::Replace;
use dcb_formats::{Component, Superelement};

use dcb_reducer::Reduction;
use dcb_reducer::error::Error;
use dcb_reducer::{WholeReduction, reduce_whole};

/// Short reductions are repeated until they took this long together, but not more often than [`MOST_REPEATS`].
const LONG_ENOUGH: f64 = 0.5;
const MOST_REPEATS: usize = 5;

/// Result and effort of a reduction.
#[derive(Clone, Debug)]
pub struct Timed {
    /// The superelement with its shapes.
    pub whole: WholeReduction,
    /// Time of the reduction and of writing its file, s; the shortest of all repeats.
    pub seconds: f64,
    /// How often it was made.
    pub repeats: usize,
    /// Size of the file, with nodal shapes and mesh.
    pub file_bytes: u64,
}

impl Timed {
    /// The superelement.
    pub fn element(&self) -> &Superelement {
        &self.whole.reduced.superelement
    }
}

/// Reduces, writes to `scratch` and removes the file again.
pub fn timed(component: &Component, options: &Reduction, scratch: &Path) -> Result<Timed, Error> {
    let mut shortest = f64::INFINITY;
    let mut total = 0.0;
    let mut repeats = 0;
    loop {
        repeats += 1;
        let start = Instant::now();
        let whole = reduce_whole(component, options, &mut ())?.accepted()?;
        let reduced = &whole.reduced;
        let contents = Contents {
            superelement: &reduced.superelement,
            recovery: Some(&reduced.recovery),
            mesh: Some(&component.mesh),
        };
        let how = WriteOptions {
            replace_existing: Replace::Overwrite,
            ..WriteOptions::default()
        };
        write_superelement(scratch, &contents, &how)?;
        let seconds = start.elapsed().as_secs_f64();
        let told = |source| dcb_formats::Error::io(scratch, "cannot read back", source);
        let file_bytes = std::fs::metadata(scratch).map_err(told)?.len();
        std::fs::remove_file(scratch).map_err(told)?;
        shortest = shortest.min(seconds);
        total += seconds;
        if total >= LONG_ENOUGH || repeats == MOST_REPEATS {
            return Ok(Timed {
                whole,
                seconds: shortest,
                repeats,
                file_bytes,
            });
        }
    }
}
