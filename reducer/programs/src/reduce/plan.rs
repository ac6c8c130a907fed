//! The `reduce plan PART.mtx` command: read, order, and say what a reduction will cost.

use std::path::PathBuf;

use clap::Args;
use dcb_formats::component_files::{ComponentFiles, read_component};

use crate::reduce::inspect::Form;
use crate::reduce::memory::MemoryArguments;
use crate::reduce::part::{Outcome, default_output};
use crate::reduce::plan_report::report;
use dcb_reducer::error::Error;
use dcb_reducer::forecast;
use dcb_reducer::mode_selection::ModeOptions;
use dcb_workflow::siblings::SiblingArguments;

/// Component to plan for.
#[derive(Debug, Args)]
pub struct PlanArguments {
    /// Stiffness matrix, Matrix Market (.mtx or .mtx.gz).
    #[arg(value_name = "PART.mtx")]
    pub stiffness: PathBuf,
    /// Modes.
    #[command(flatten)]
    pub modes: ModeOptions,
    /// Files beside the stiffness matrix.
    #[command(flatten)]
    pub siblings: SiblingArguments,
    /// Memory.
    #[command(flatten)]
    pub memory: MemoryArguments,
    /// As JSON; memory in bytes, time in seconds.
    #[arg(long)]
    pub json: bool,
}

/// Runs the command.
///
/// # Errors
/// Any error of the component.
pub fn run(arguments: &PlanArguments) -> Result<Outcome, Error> {
    let limit = arguments
        .memory
        .limit(&default_output(&arguments.stiffness));
    let files = ComponentFiles::beside(&arguments.stiffness, &arguments.siblings.overrides())?;
    let component = read_component(&files, limit.bytes)?;
    let modes = arguments.modes.request().selection(&component.units.time)?;
    let forecast = forecast(&component, modes).map_err(|error| error.naming_the_file(&files))?;
    let forecast = limit.fitted(forecast);
    let form = if arguments.json {
        Form::Json
    } else {
        Form::Text
    };
    Ok(report(
        &arguments.stiffness.display().to_string(),
        &forecast,
        &limit,
        form,
    ))
}
