//! `reduce verify`: recomputes what can be recomputed, from the file alone or, given the component, everything.

use std::path::PathBuf;

use clap::Args;
use dcb_formats::dcb::SuperelementFile;
use dcb_reducer::error::Error;
use dcb_reducer::resources::memory_limit::available;
use dcb_reducer::verify::{Findings, check_alone, check_component};

use crate::outcome::Outcome;
use crate::program::{Detail, Told};
use crate::reduce::part::files::{PartArguments, PartFiles};

/// Superelement to verify, and its component.
#[derive(Debug, Args)]
#[command(mut_arg("mass", |arg| arg.requires("component").help("The component's mass matrix [default: PART.mass.mtx]")))]
#[command(mut_arg("mesh", |arg| arg.requires("component").help("The component's description [default: PART.json]")))]
#[command(mut_arg("boundary", |arg| arg.requires("component").help("The component's rows of the boundary, n_b x n_e [default: PART.boundary.mtx if there]")))]
pub(crate) struct VerifyArguments {
    /// Superelement.
    pub file: PathBuf,
    /// Stiffness matrix of the component that it was made from.
    #[arg(long, value_name = "PART.mtx")]
    pub component: Option<PathBuf>,
    #[command(flatten)]
    pub part: PartArguments,
}

pub fn run(arguments: &VerifyArguments, detail: Detail) -> Result<Outcome, Error> {
    let path = &arguments.file;
    let file = SuperelementFile::open(path)?;
    let mut findings = Findings {
        text: String::new(),
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
        let files = PartFiles::of(stiffness, &arguments.part)?;
        let component = files.read(available(), Told::Nothing)?;
        check_component(&element, recovery.as_ref(), &component, &mut findings)
            .map_err(|error| error.naming_the_file(&files.files))?;
    }
    let path = path.display();
    let checks = findings.text.lines().count();
    let against = match &arguments.component {
        Some(component) => format!(" against {}", component.display()),
        None => String::new(),
    };
    let output = match (findings.broken.len(), detail) {
        (0, Detail::Verdict) => {
            format!("{path}: verified{against}, all {checks} checks hold (-v lists them)\n")
        }
        (0, Detail::Tables) => {
            format!(
                "{path}: verified{against}, all {checks} checks hold\n{}",
                findings.text
            )
        }
        (broken, _) => format!(
            "{path}: NOT verified{against}, {broken} of {checks} checks fail\n{}",
            findings.text
        ),
    };
    let what = format!("{path}: not verified");
    Ok(Outcome::unless(output, &what, &findings.broken))
}
