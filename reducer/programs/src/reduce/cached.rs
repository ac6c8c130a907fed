//! `reduce PART.mtx --cache`: a superelement taken from the cache instead of being made, or kept there once it is made.

use std::fmt::Write as _;
use std::path::Path;

use crate::program::Told;
use dcb_formats::dcb::{Contents, WriteOptions, write_superelement};
use dcb_formats::output::copy_whole;

use crate::reduce::inspect::{frequency_table, interface_table, mass_lines};
use crate::reduce::part::Outcome;
use crate::reduce::reduction_report::{further_columns, stage_lines};
use crate::reduce::scene::Made;
use crate::reduce::timing::StageClock;
use dcb_formats::units::readable;
use dcb_reducer::error::Error;
use dcb_workflow::cache::{Cache, Claim, Entry, Request, Reservation, Stored};
use dcb_workflow::file_form::FileForm;

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
    form: FileForm,
    target: &Path,
    options: &WriteOptions,
    clock: &mut StageClock,
    (told, listed): (Told, usize),
) -> Result<Outcome, Error> {
    let mut element = entry.file.superelement()?;
    clock.start("write");
    if form != FileForm::default() {
        form.say(&mut element.provenance.options);
        let (recovery, mesh) = match form.without_fields {
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
    form: FileForm,
    made: &mut Made,
    seconds: f64,
    told: Told,
) {
    FileForm::default().say(&mut made.superelement.provenance.options);
    let contents = Contents {
        superelement: &made.superelement,
        recovery: made.fields.as_ref(),
        mesh: made.mesh.as_ref(),
    };
    let stored = reservation.store(&contents, seconds);
    form.say(&mut made.superelement.provenance.options);
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
