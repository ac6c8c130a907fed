//! The command line of `reduce`. Results go to standard output, everything else to standard error.

mod assemble;
mod batch;
mod cache;
mod import;
mod init;
mod memory;
mod part;
mod plan;
mod ranks;
mod scene;
mod study;
mod superelement;
mod update;

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use crate::examples::{REDUCE, with_examples};
use crate::manual::{CompletionArguments, ManualArguments, completions, manual};
use crate::program::{CommonArguments, Detail, Program, Told, begin, print_to_stderr};
use crate::stop_signal;
use clap::{Args, Command, CommandFactory, Parser, Subcommand, ValueEnum};
use dcb_formats::output::remove_unfinished;

use crate::outcome::{Outcome, ended};
use crate::reduce::assemble::AssembleArguments;
use crate::reduce::batch::BatchArguments;
use crate::reduce::cache::{CacheArguments, InventoryArguments};
use crate::reduce::import::ImportCommand;
use crate::reduce::init::InitArguments;
use crate::reduce::memory::MemoryArguments;
use crate::reduce::part::files::PartArguments;
use crate::reduce::plan::PlanArguments;
use crate::reduce::ranks::RanksArguments;
use crate::reduce::scene::SceneReductionArguments;
use crate::reduce::study::ComponentStudyArguments;
use crate::reduce::superelement::export::ExportArguments;
pub use crate::reduce::superelement::inspect::Form;
use crate::reduce::superelement::inspect::InspectArguments;
use crate::reduce::superelement::report::ReportArguments;
use crate::reduce::superelement::verify::VerifyArguments;
use crate::reduce::superelement::{compare, export, inspect, report, verify};
use crate::reduce::update::UpdateArguments;
use dcb_reducer::Reduction;
use dcb_reducer::error::Error;
use dcb_reducer::mode_selection::ModeOptions;
use dcb_workflow::batch::manifest::batch_schema;
use dcb_workflow::file_form::FileForm;

/// Turns a component's finite-element stiffness and mass into a superelement for flexible multibody dynamics.
///
/// PART.mtx is the stiffness; PART.mass.mtx and PART.json are found beside it.
///
/// Matrices of Abaqus, Ansys, CalculiX, Nastran, NumPy, MATLAB and PETSc are read as they are (docs/import.md).
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
    common: CommonArguments,
}

/// Options of a reduction.
#[derive(Debug, Args)]
pub(crate) struct ReduceArguments {
    /// Stiffness matrix: Matrix Market (.mtx, .mtx.gz) or another program's; FILE#NAME picks one of several.
    #[arg(value_name = "PART.mtx", required = true)]
    pub stiffness: Option<PathBuf>,
    /// Output [default: PART.dcb.h5].
    #[arg(long, short, value_name = "FILE")]
    pub output: Option<PathBuf>,
    #[command(flatten)]
    pub modes: ModeOptions,
    #[command(flatten)]
    pub reduction: Reduction,
    #[command(flatten)]
    pub scene: SceneReductionArguments,
    #[command(flatten)]
    pub part: PartArguments,
    /// Replace an existing output.
    #[arg(long)]
    pub force: bool,
    #[command(flatten)]
    pub form: FileForm,
    /// Write times and memory of each stage and counts of the work as JSON (replaces an older one).
    #[arg(long, value_name = "F.json")]
    pub timings: Option<PathBuf>,
    #[command(flatten)]
    pub memory: MemoryArguments,
    #[command(flatten)]
    pub ranks: RanksArguments,
    #[command(flatten)]
    pub cache: CacheArguments,
}

/// Files that have a schema.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
enum SchemaName {
    /// Component description, PART.json.
    #[default]
    Component,
    /// Manifest of `reduce batch`.
    Batch,
    /// Assembly file of `reduce assemble`.
    Assembly,
}

#[derive(Debug, Subcommand)]
enum ReduceCommand {
    /// Make PART.mtx, PART.mass.mtx and PART.json of another program's matrices and mesh.
    Import(ImportCommand),
    /// Draft PART.json from a mesh and its node sets.
    Init(InitArguments),
    /// Join superelements, rigid bodies and springs to one superelement.
    Assemble(AssembleArguments),
    /// Show what a superelement holds.
    Inspect(InspectArguments),
    /// Check a superelement by computing its numbers again: from the file alone, or from the component.
    Verify(VerifyArguments),
    /// Compare two superelements: frequencies, shapes, flexibility, mass.
    Compare {
        /// First superelement.
        a: PathBuf,
        /// Second superelement.
        b: PathBuf,
    },
    /// Compare a superelement with measured modes, and take over damping or frequencies.
    Update(UpdateArguments),
    /// Make a page that shows a superelement: modes in motion, responses with bounds, quality
    Report(ReportArguments),
    /// Write a superelement for other programs: NumPy, Simscape, Nastran, Exudyn, MBDyn, SID_FEM, glTF, VTU.
    Export(ExportArguments),
    /// Say what a reduction will cost, without doing it: factor, memory, time.
    Plan(PlanArguments),
    /// Reduce in many ways and say what each costs and how far it is off.
    Study(ComponentStudyArguments),
    /// List or clear the superelements that --cache keeps.
    Cache(InventoryArguments),
    /// Reduce many parts, or one in many ways, as a manifest says.
    Batch(BatchArguments),
    /// Print the JSON schema of the component description, a manifest or an assembly.
    Schema {
        /// Of what.
        #[arg(value_enum, default_value_t)]
        of: SchemaName,
    },
    /// Print what a shell needs to complete commands and options.
    Completions(CompletionArguments),
    /// Write the pages of the manual (for man).
    Man(ManualArguments),
}

/// The command line, with examples in its helps.
pub fn command() -> Command {
    with_examples(ReduceCli::command(), REDUCE)
}

/// What `reduce inspect` says of a superelement, as JSON or for people.
///
/// # Errors
/// Those of reading the file, and of bounds of its errors.
pub fn inspected(file: &Path, form: Form) -> Result<String, Error> {
    let arguments = InspectArguments::of(file, form);
    Ok(inspect::run(&arguments, Detail::Tables)?.output)
}

/// What `reduce compare` says of two superelements.
///
/// # Errors
/// Those of reading the files; one is planar and the other spatial.
pub fn compared(a: &Path, b: &Path) -> Result<String, Error> {
    Ok(compare::run(a, b, Detail::Tables)?.output)
}

/// Runs the program with its name and arguments; the exit status. `other` is the command line of the other program, which may have an option
/// that this one hasn't.
pub fn main(arguments: impl IntoIterator<Item = OsString>, other: fn() -> clap::Command) -> u8 {
    let program = Program {
        file: "PART.mtx",
        examples: REDUCE,
        other,
    };
    let cli = match begin(arguments, &program, |cli: &ReduceCli| &cli.common) {
        Ok(cli) => cli,
        Err(status) => return status,
    };
    let outcome = match &cli.command {
        None => part::run(&cli.reduce, &cli.common),
        Some(ReduceCommand::Import(arguments)) => import::run(arguments, &cli.common),
        Some(ReduceCommand::Init(arguments)) => init::run(arguments, &cli.common),
        Some(ReduceCommand::Assemble(arguments)) => assemble::run(arguments, &cli.common),
        Some(ReduceCommand::Inspect(arguments)) => inspect::run(arguments, cli.common.detail()),
        Some(ReduceCommand::Verify(arguments)) => verify::run(arguments, cli.common.detail()),
        Some(ReduceCommand::Compare { a, b }) => compare::run(a, b, cli.common.detail()),
        Some(ReduceCommand::Update(arguments)) => update::run(arguments, &cli.common),
        Some(ReduceCommand::Report(arguments)) => report::run(arguments),
        Some(ReduceCommand::Export(arguments)) => export::run(arguments),
        Some(ReduceCommand::Plan(arguments)) => plan::run(arguments, cli.common.detail()),
        Some(ReduceCommand::Study(arguments)) => study::run(arguments, &cli.common),
        Some(ReduceCommand::Cache(arguments)) => cache::run(arguments),
        Some(ReduceCommand::Batch(arguments)) => batch::run(arguments, &cli.common),
        Some(ReduceCommand::Schema { of }) => schema(*of),
        Some(ReduceCommand::Completions(arguments)) => Ok(completions(command(), arguments)),
        Some(ReduceCommand::Man(arguments)) => manual(command(), arguments).map_err(Error::from),
    };
    // What was asked for is printed also with --quiet; what was done along the way is not.
    let is_report = matches!(
        cli.command,
        None | Some(
            ReduceCommand::Assemble(_)
                | ReduceCommand::Verify(_)
                | ReduceCommand::Study(_)
                | ReduceCommand::Batch(_)
                | ReduceCommand::Export(_)
                | ReduceCommand::Report(_)
                | ReduceCommand::Update(_)
                | ReduceCommand::Import(_)
        )
    );
    let told = match is_report {
        true => cli.common.told(),
        false => Told::Everything,
    };
    ended(outcome, told, Error::is_unusable_input, wait_if_interrupted)
}

/// Ends what was started, cleans up, says what there is, and ends with the signal's status (130 for Ctrl-C).
pub(crate) fn when_interrupted(clean_up: impl Fn() -> String + Send + 'static) {
    stop_signal::watch(move |signal| {
        #[cfg(feature = "ranks")]
        dcb_sparse::ranks::job::end_all();
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
        SchemaName::Assembly => dcb_formats::assembly::assembly_schema(),
    };
    let text = serde_json::to_string_pretty(&schema)
        .map_err(|_| Error::NotFinite { what: "the schema" })?;
    Ok(Outcome::done(text + "\n"))
}
