//! `reduce PART.mtx --cache`: a superelement taken from the cache instead of being made, or kept there once it is made.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::Path;

use dcb_formats::component_files::ComponentFiles;
use dcb_formats::dcb::{Compression, Contents, WriteOptions, copy_whole, write_superelement};
use serde_json::{Value, json};

use crate::cache::{Cache, Claim, Entry, ModeRequest, Request, Reservation, Stored};
use crate::cli::ReduceArguments;
use crate::cli_cache::Told;
use crate::cli_memory::FactorPlace;
use crate::cli_reduce::{DEFAULT_MODES, Outcome};
use crate::cli_scene::Made;
use crate::error::Error;
use crate::inspect::{frequency_table, interface_table, mass_lines};
use crate::memory_limit::readable;
use crate::summary::{further_columns, stage_lines};
use crate::timing::StageClock;

/// What decides the result of a reduction: the part's files, which are hashed, and options.
///
/// # Errors
/// A file can't be read.
pub fn request(files: &ComponentFiles, arguments: &ReduceArguments) -> Result<Request, Error> {
    let modes = match arguments.max_frequency {
        Some(hertz) => ModeRequest::BelowHertz(hertz),
        None => ModeRequest::Lowest(arguments.modes.unwrap_or(DEFAULT_MODES)),
    };
    Ok(Request::new(&files.sources()?, modes, options(arguments)))
}

/// What else the result depends on; what is as usual is left out.
fn options(arguments: &ReduceArguments) -> BTreeMap<String, Value> {
    let mut options = BTreeMap::new();
    let mut say = |name: &str, value: Value| options.insert(name.to_owned(), value);
    if let Some(count) = arguments.interface_modes {
        say("interface_modes", json!(count));
    }
    if !arguments.enrich.is_empty() {
        let names = arguments.enrich.iter().map(|name| format!("{name:?}"));
        say("enrich", json!(names.collect::<Vec<_>>()));
    }
    if arguments.without_estimate {
        say("without_estimate", json!(true));
    }
    if arguments.allow_grounded {
        say("allow_grounded", json!(true));
    }
    if arguments.allow_loose {
        say("allow_loose", json!(true));
    }
    if arguments.eigen_solver != Default::default() {
        say(
            "eigen_solver",
            json!(format!("{:?}", arguments.eigen_solver)),
        );
    }
    if arguments.memory.factor == FactorPlace::Single {
        say("factor", json!("single"));
    }
    options
}

/// The entry of a request or its reservation; `None`, with a warning, where the cache can't be used.
pub fn claim<'c>(cache: &'c Cache, request: &Request, told: Told) -> Option<Claim<'c>> {
    let waiting = || {
        told.say(
            "waiting",
            "another process makes this superelement; its result is taken",
        );
    };
    match cache.claim(request, waiting) {
        Ok(claim) => {
            if let Claim::Missing(reservation) = &claim
                && let Some(damage) = &reservation.damage
            {
                told.say(
                    "warning",
                    &format!("the cache had a damaged superelement, which is made anew: {damage}"),
                );
            }
            Some(claim)
        }
        Err(error) => {
            let folder = cache.folder().display();
            told.say(
                "warning",
                &format!("the cache isn't used: {folder}: {error}"),
            );
            None
        }
    }
}

/// Writes a superelement of the cache as it is asked for, and says what it is.
///
/// # Errors
/// The output can't be written.
pub fn serve(
    entry: &Entry,
    arguments: &ReduceArguments,
    target: &Path,
    options: &WriteOptions,
    clock: &mut StageClock,
    (told, listed): (Told, usize),
) -> Result<Outcome, Error> {
    let mut element = entry.file.superelement()?;
    clock.start("write");
    if arguments.without_fields || options.compression != Compression::None {
        say_form(&mut element.provenance.options, arguments);
        let (recovery, mesh) = match arguments.without_fields {
            true => (None, None),
            false => (entry.file.recovery()?, entry.file.mesh()?),
        };
        let contents = Contents {
            superelement: &element,
            recovery: recovery.as_ref(),
            mesh: mesh.as_ref(),
        };
        write_superelement(target, &contents, options)?;
    } else {
        copy_whole(&entry.path, target, options.replace_existing)?;
    }
    clock.clear();
    for warning in &element.provenance.warnings {
        told.say("warning", warning);
    }
    let mut output = String::new();
    let _ = writeln!(
        output,
        "{}: {} modes and {} attachment rows (rank {}){}, from the cache: {} was made in {:.1} s",
        element.name,
        element.mode_count(),
        element.boundary_row_count(),
        element.residual.sigma_squared.len(),
        further_columns(&element),
        entry.record.request.key().short(),
        entry.record.seconds,
    );
    output += &mass_lines(&element);
    output += &frequency_table(&element, None, listed);
    output += &interface_table(&element);
    output += &stage_lines(clock.stages());
    let _ = writeln!(output, "wrote {}", target.display());
    Ok(Outcome {
        output,
        failure: None,
    })
}

/// Keeps a superelement that was made, with nodal fields whether or not they were asked for. Where that fails there is a warning.
pub(crate) fn keep(
    reservation: Reservation<'_>,
    arguments: &ReduceArguments,
    made: &mut Made,
    seconds: f64,
    told: Told,
) {
    let form = &mut made.superelement.provenance.options;
    form["without_fields"] = json!(false);
    form["compress"] = json!(false);
    let contents = Contents {
        superelement: &made.superelement,
        recovery: made.fields.as_ref(),
        mesh: made.mesh.as_ref(),
    };
    let stored = reservation.store(&contents, seconds);
    say_form(&mut made.superelement.provenance.options, arguments);
    let why = match stored {
        Ok(Stored::Kept) => return,
        Ok(Stored::TooLarge { bytes }) => format!(
            "its {} are more than the cache may have; --cache-limit allows more",
            readable(bytes)
        ),
        Err(error) => error.to_string(),
    };
    told.say(
        "warning",
        &format!("the superelement is complete, but isn't kept in the cache: {why}"),
    );
}

fn say_form(options: &mut Value, arguments: &ReduceArguments) {
    options["without_fields"] = json!(arguments.without_fields);
    options["compress"] = json!(arguments.compress);
}
