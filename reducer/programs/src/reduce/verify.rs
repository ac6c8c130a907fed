//! `reduce verify`: recomputes what can be recomputed, from the file alone or, given the component, everything.

use dcb_formats::component_files::{ComponentFiles, Overrides, read_component};
use dcb_formats::dcb::SuperelementFile;
use dcb_reducer::error::Error;
use dcb_reducer::resources::memory_limit::available;
use dcb_reducer::verify::{Findings, check_alone, check_component};

use crate::reduce::VerifyArguments;
use crate::reduce::part::Outcome;

/// Runs the command.
///
/// # Errors
/// If the file is not an intact superelement, or the component can't be read.
pub fn run(arguments: &VerifyArguments) -> Result<Outcome, Error> {
    let path = &arguments.file;
    let file = SuperelementFile::open(path)?;
    let mut findings = Findings {
        text: format!("{}\n", path.display()),
        broken: Vec::new(),
    };
    let datasets = file.verify_digests()?;
    findings.require(
        "digests of all datasets",
        true,
        &format!("{datasets} agree"),
    );
    let element = file.superelement()?;
    let recovery = file.recovery()?;
    let mesh = file.mesh()?;
    check_alone(&element, recovery.as_ref(), mesh.as_ref(), &mut findings)?;
    if let Some(stiffness) = &arguments.component {
        let overrides = Overrides {
            mass: arguments.mass.clone(),
            description: arguments.mesh.clone(),
            boundary: arguments.boundary.clone(),
        };
        let files = ComponentFiles::beside(stiffness, &overrides)?;
        let component = read_component(&files, available())?;
        check_component(&element, recovery.as_ref(), &component, &mut findings)
            .map_err(|error| error.naming_the_file(&files))?;
    }
    let verdict = if findings.broken.is_empty() {
        "verified\n"
    } else {
        "NOT verified\n"
    };
    let what = format!("{}: not verified", path.display());
    Ok(Outcome::unless(
        findings.text + verdict,
        &what,
        &findings.broken,
    ))
}
