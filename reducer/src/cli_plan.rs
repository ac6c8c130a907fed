//! The `reduce plan PART.mtx` command: read, order, and say what a reduction will cost.

use std::path::PathBuf;

use clap::Args;
use dcb_formats::component_files::{ComponentFiles, read_component};

use crate::cli::{SiblingArguments, count, frequency};
use crate::cli_memory::MemoryArguments;
use crate::cli_reduce::{Outcome, default_output, mode_selection};
use crate::error::Error;
use crate::plan::{Form, forecast, report};

/// What is to be reduced.
#[derive(Debug, Args)]
pub struct PlanArguments {
    /// Stiffness matrix, Matrix Market (.mtx or .mtx.gz).
    #[arg(value_name = "PART.mtx")]
    pub stiffness: PathBuf,
    /// This many elastic modes [default: 20].
    #[arg(long, value_name = "N", conflicts_with = "max_frequency", allow_negative_numbers = true, value_parser = count)]
    pub modes: Option<usize>,
    /// Every elastic mode below this frequency; how many that are isn't known yet.
    #[arg(long, value_name = "HZ", allow_negative_numbers = true, value_parser = frequency)]
    pub max_frequency: Option<f64>,
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
/// Whatever makes the component unusable.
pub fn run(arguments: &PlanArguments) -> Result<Outcome, Error> {
    let limit = arguments
        .memory
        .limit(&default_output(&arguments.stiffness));
    let files = ComponentFiles::beside(&arguments.stiffness, &arguments.siblings.overrides())?;
    let component = read_component(&files, limit.bytes)?;
    let modes = mode_selection(
        arguments.modes,
        arguments.max_frequency,
        &component.units.time,
    )?;
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
