//! The `reduce plan PART.mtx` command: read, order, and say what a reduction will cost.

use std::path::PathBuf;

use clap::Args;
use dcb_formats::component_files::{ComponentFiles, Overrides, read_component};

use crate::cli::{count, frequency};
use crate::cli_memory::MemoryArguments;
use crate::cli_reduce::{Outcome, default_output, mode_selection, naming_the_file};
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
    /// Mass matrix [default: PART.mass.mtx].
    #[arg(long, value_name = "FILE")]
    pub mass: Option<PathBuf>,
    /// Component description [default: PART.json].
    #[arg(long, value_name = "FILE")]
    pub mesh: Option<PathBuf>,
    /// Boundary localization, n_b x n_e [default: PART.boundary.mtx if there].
    #[arg(long, value_name = "FILE")]
    pub boundary: Option<PathBuf>,
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
    let overrides = Overrides {
        mass: arguments.mass.clone(),
        description: arguments.mesh.clone(),
        boundary: arguments.boundary.clone(),
    };
    let limit = arguments
        .memory
        .limit(&default_output(&arguments.stiffness));
    let files = ComponentFiles::beside(&arguments.stiffness, &overrides)?;
    let component = read_component(&files)?;
    let modes = mode_selection(
        arguments.modes,
        arguments.max_frequency,
        &component.units.time,
    )?;
    let forecast = forecast(&component, modes).map_err(|error| naming_the_file(error, &files))?;
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
