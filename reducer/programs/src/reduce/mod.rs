//! The command line of `reduce`. Results go to standard output, everything else to standard error.

mod batch;
mod cache;
mod cached;
mod compare;
mod eigen_solver;
mod error_report;
mod inspect;
mod memory;
mod part;
mod plan;
mod plan_report;
mod reduction_report;
mod scene;
mod study;
mod timing;
mod verify;

use std::path::PathBuf;
use std::process::ExitCode;

use crate::program::{Told, begin, print_to_stderr, print_to_stdout};
use crate::stop_signal;
use clap::{Args, Parser, Subcommand, ValueEnum};
use dcb_formats::output::remove_unfinished;

use crate::reduce::batch::BatchArguments;
use crate::reduce::cache::{CacheArguments, InventoryArguments};
use crate::reduce::eigen_solver::EigenSolverArguments;
use crate::reduce::memory::MemoryArguments;
use crate::reduce::part::Outcome;
use crate::reduce::plan::PlanArguments;
use crate::reduce::scene::SceneReductionArguments;
use crate::reduce::study::ComponentStudyArguments;
use dcb_reducer::Reduction;
use dcb_reducer::error::Error;
use dcb_reducer::mode_selection::ModeOptions;
use dcb_workflow::batch::manifest::batch_schema;
use dcb_workflow::file_form::FileForm;
use dcb_workflow::siblings::SiblingArguments;

/// Turns a component's finite-element stiffness and mass into a superelement for flexible multibody dynamics.
///
/// PART.mtx is the stiffness; PART.mass.mtx and PART.json are found beside it.
#[derive(Debug, Parser)]
#[command(
    name = "reduce",
    version,
    args_conflicts_with_subcommands = true,
    subcommand_negates_reqs = true
)]
#[command(
    after_help = "Exit status: 0 done, 1 numerical failure or broken quality limit, 2 unusable input,\n130 interrupted (143 by SIGTERM, 129 by SIGHUP)."
)]
struct ReduceCli {
    #[command(subcommand)]
    command: Option<ReduceCommand>,
    #[command(flatten)]
    reduce: ReduceArguments,
    #[command(flatten)]
    common: ReduceCommonArguments,
}

/// Options of every command.
#[derive(Debug, Args)]
pub struct ReduceCommonArguments {
    /// Print no summary, warnings or progress.
    #[arg(long, short, global = true)]
    pub quiet: bool,
    /// List every mode, and say beforehand what the reduction will cost.
    #[arg(long, short, global = true)]
    pub verbose: bool,
    /// Worker threads (default: one per processor). Results do not depend on it.
    #[arg(long, global = true, value_name = "N", allow_negative_numbers = true, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
}

impl ReduceCommonArguments {
    /// Whether the user is told what goes on.
    pub fn told(&self) -> Told {
        match self.quiet {
            true => Told::Nothing,
            false => Told::Everything,
        }
    }
}

/// Options of a reduction.
#[derive(Debug, Args)]
pub struct ReduceArguments {
    /// Stiffness matrix, Matrix Market (.mtx or .mtx.gz).
    #[arg(value_name = "PART.mtx", required = true)]
    pub stiffness: Option<PathBuf>,
    /// Output [default: PART.dcb.h5].
    #[arg(long, short, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Modes.
    #[command(flatten)]
    pub modes: ModeOptions,
    /// Further options that decide the result.
    #[command(flatten)]
    pub reduction: Reduction,
    /// Reducing for a scene.
    #[command(flatten)]
    pub scene: SceneReductionArguments,
    /// Files beside the stiffness matrix.
    #[command(flatten)]
    pub siblings: SiblingArguments,
    /// Replace an existing output.
    #[arg(long)]
    pub force: bool,
    /// How the file is written.
    #[command(flatten)]
    pub form: FileForm,
    /// Write times and memory of each stage and counts of the work as JSON (replaces an older one).
    #[arg(long, value_name = "F.json")]
    pub timings: Option<PathBuf>,
    /// Solver for the modes.
    #[command(flatten)]
    pub eigen_solver: EigenSolverArguments,
    /// Memory.
    #[command(flatten)]
    pub memory: MemoryArguments,
    /// Cache.
    #[command(flatten)]
    pub cache: CacheArguments,
}

/// Superelement to verify, and its component.
#[derive(Debug, Args)]
pub struct VerifyArguments {
    /// Superelement.
    pub file: PathBuf,
    /// Stiffness matrix of the component that it was made from.
    #[arg(long, value_name = "PART.mtx")]
    pub component: Option<PathBuf>,
    /// The component's mass matrix [default: PART.mass.mtx].
    #[arg(long, value_name = "FILE", requires = "component")]
    pub mass: Option<PathBuf>,
    /// The component's description [default: PART.json].
    #[arg(long, value_name = "FILE", requires = "component")]
    pub mesh: Option<PathBuf>,
    /// The component's boundary localization, n_b x n_e [default: PART.boundary.mtx if there].
    #[arg(long, value_name = "FILE", requires = "component")]
    pub boundary: Option<PathBuf>,
}

/// Files that have a schema.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum SchemaName {
    /// Component description, PART.json.
    #[default]
    Component,
    /// Manifest of `reduce batch`.
    Batch,
}

#[derive(Debug, Subcommand)]
enum ReduceCommand {
    /// Show what a superelement holds.
    Inspect {
        /// Superelement.
        file: PathBuf,
        /// As JSON.
        #[arg(long)]
        json: bool,
        /// Band of frequencies for the errors, Hz [default: up to half the highest mode].
        #[arg(long, value_name = "FMIN:FMAX", allow_hyphen_values = true, value_parser = study::band)]
        band: Option<[f64; 2]>,
    },
    /// Recompute what can be recomputed: from the file alone, or everything from the component.
    Verify(VerifyArguments),
    /// Compare two superelements: frequencies, shapes, flexibility, mass.
    Compare {
        /// First superelement.
        a: PathBuf,
        /// Second superelement.
        b: PathBuf,
    },
    /// Say what a reduction will cost, without doing it: factor, memory, time.
    Plan(PlanArguments),
    /// Reduce in many ways and say what each costs and how far it is off.
    Study(ComponentStudyArguments),
    /// List or clear the superelements that --cache keeps.
    Cache(InventoryArguments),
    /// Reduce many parts, or one in many ways, as a manifest says.
    Batch(BatchArguments),
    /// Print the JSON schema of the component description, or of a manifest.
    Schema {
        /// Of what.
        #[arg(value_enum, default_value_t)]
        of: SchemaName,
    },
}

/// Runs the program.
pub fn main() -> ExitCode {
    let common = |cli: &ReduceCli| (cli.common.threads, cli.common.told());
    let cli = match begin("PART.mtx", common) {
        Ok(cli) => cli,
        Err(status) => return status,
    };
    let outcome = match &cli.command {
        None => part::run(&cli.reduce, &cli.common),
        Some(ReduceCommand::Inspect { file, json, band }) => inspect::run(
            file,
            if *json {
                inspect::Form::Json
            } else {
                inspect::Form::Text
            },
            *band,
        ),
        Some(ReduceCommand::Verify(arguments)) => verify::run(arguments),
        Some(ReduceCommand::Compare { a, b }) => compare::run(a, b),
        Some(ReduceCommand::Plan(arguments)) => plan::run(arguments),
        Some(ReduceCommand::Study(arguments)) => study::run(arguments, &cli.common),
        Some(ReduceCommand::Cache(arguments)) => cache::run(arguments),
        Some(ReduceCommand::Batch(arguments)) => batch::run(arguments, &cli.common),
        Some(ReduceCommand::Schema { of }) => schema(*of),
    };
    // What was asked for is printed also with --quiet; what was done along the way is not.
    let is_report = matches!(
        cli.command,
        None | Some(ReduceCommand::Verify(_) | ReduceCommand::Study(_) | ReduceCommand::Batch(_))
    );
    let outcome = outcome.and_then(|outcome| {
        if !(is_report && cli.common.quiet) {
            print_to_stdout(&outcome.output)?;
        }
        Ok(outcome.failure)
    });
    wait_if_interrupted();
    match outcome {
        Ok(None) => ExitCode::SUCCESS,
        Ok(Some(failure)) => {
            print_to_stderr("error", &failure);
            ExitCode::from(1)
        }
        Err(error) => {
            print_to_stderr("error", &error.to_string());
            ExitCode::from(if error.is_unusable_input() { 2 } else { 1 })
        }
    }
}

/// Ends what was started, cleans up, says what there is, and ends with the signal's status (130 for Ctrl-C).
pub(crate) fn when_interrupted(clean_up: impl Fn() -> String + Send + 'static) {
    stop_signal::watch(move |signal| {
        #[cfg(feature = "slepc")]
        dcb_reducer::modes::mpi_job::end_all();
        remove_unfinished();
        print_to_stderr(signal.reason(), &clean_up());
        stop_signal::end(signal);
    });
}

/// Leaves the last word to the signal that ends the program; whatever goes wrong after it is a consequence.
fn wait_if_interrupted() {
    while stop_signal::received().is_some() {
        std::thread::park();
    }
}

fn schema(of: SchemaName) -> Result<Outcome, Error> {
    let schema = match of {
        SchemaName::Component => dcb_formats::component_schema(),
        SchemaName::Batch => batch_schema(),
    };
    let text = serde_json::to_string_pretty(&schema)
        .map_err(|_| Error::NotFinite { what: "the schema" })?;
    Ok(Outcome {
        output: text + "\n",
        failure: None,
    })
}
