//! The command line of `simulate`. Results go to standard output, everything else to standard error.

mod component_reduction;
mod prepare;
mod run_report;
mod scene;
mod study;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use crate::program::{Told, begin, print_to_stderr, print_to_stdout};
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::{Args, Parser, Subcommand, ValueEnum};
use dcb_formats::output::{Replace, check_output};
use dcb_formats::results::Results;
use dcb_formats::terminal::one_line;

use crate::simulate::prepare::PrepareArguments;
use crate::simulate::study::StudyArguments;
use crate::stop_signal::{self, StopSignal};
use dcb_formats::scene::{Compatibility, scene_schema};
use dcb_runtime::error::Error;
use dcb_runtime::export::csv;
use dcb_runtime::export::history::Selection;
use dcb_runtime::export::picture;
use dcb_runtime::run::refuse_inputs;

/// Simulates mechanisms of superelements and rigid bodies.
///
/// SCENE.json names the bodies, the joints between them, what drives them and what is recorded; results go to SCENE.h5.
#[derive(Debug, Parser)]
#[command(
    name = "simulate",
    version,
    args_conflicts_with_subcommands = true,
    subcommand_negates_reqs = true
)]
#[command(
    after_help = "Exit status: 0 done, 1 numerical failure, 2 unusable input, 130 interrupted (143 by SIGTERM, 129 by SIGHUP)."
)]
struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
    #[command(flatten)]
    scene: SceneArguments,
    #[command(flatten)]
    common: CommonArguments,
}

/// Options of every command.
#[derive(Debug, Args)]
pub struct CommonArguments {
    /// Print no summary, notes or progress.
    #[arg(long, short, global = true)]
    pub quiet: bool,
    /// Say more: what was loaded, every note.
    #[arg(long, short, global = true)]
    pub verbose: bool,
    /// Worker threads of a study [default: all]. A scene is integrated by one.
    #[arg(long, global = true, value_name = "N", allow_negative_numbers = true, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub threads: Option<u16>,
}

impl CommonArguments {
    /// Whether the user is told what goes on.
    pub(crate) fn told(&self) -> Told {
        match self.quiet {
            true => Told::Nothing,
            false => Told::Everything,
        }
    }
}

/// Parser of a compatibility by its name in scenes.
fn compatibility() -> impl TypedValueParser<Value = Compatibility> {
    let choices = [
        ("strong", "Attachments are dynamic coordinates (stable)"),
        (
            "static",
            "Attachments follow the forces without inertia (stable)",
        ),
        (
            "weak",
            "The dual form of the paper; unstable below a step, refused there unless it is allowed by name",
        ),
    ];
    let choices = choices.map(|(name, help)| PossibleValue::new(name).help(help));
    PossibleValuesParser::new(choices).try_map(|name| serde_json::from_value(name.into()))
}

/// Options of a run.
#[derive(Debug, Args)]
pub struct SceneArguments {
    /// Scene.
    #[arg(value_name = "SCENE.json", required = true)]
    pub scene: Option<PathBuf>,
    /// Results [default: SCENE.h5].
    #[arg(long, short, value_name = "FILE")]
    pub output: Option<PathBuf>,
    /// Step, in the scene's unit of time.
    #[arg(long, value_name = "H", allow_hyphen_values = true)]
    pub step: Option<f64>,
    /// Time at which the run ends.
    #[arg(long, value_name = "T", allow_hyphen_values = true)]
    pub end: Option<f64>,
    /// Spectral radius at infinite frequency of generalized alpha.
    #[arg(long, value_name = "R", allow_hyphen_values = true)]
    pub rho_infinity: Option<f64>,
    /// How interfaces follow the coordinates.
    #[arg(long, value_parser = compatibility())]
    pub compatibility: Option<Compatibility>,
    /// Let --compatibility weak run where it is unstable.
    #[arg(long)]
    pub allow_unstable_weak: bool,
    /// Replace existing results, and files of fields.
    #[arg(long)]
    pub force: bool,
    /// Also write the outputs as CSV (replaces an older one).
    #[arg(long, value_name = "FILE")]
    pub csv: Option<PathBuf>,
    /// Folder in which the scene may write fields, beside its own and that of the results.
    #[arg(long, value_name = "FOLDER")]
    pub fields_in: Option<PathBuf>,
    /// Say where the time goes.
    #[arg(long)]
    pub profile: bool,
    /// Contents of the superelements that are carried.
    #[arg(long, value_name = "WHAT", value_enum, default_value_t)]
    pub model: ModelArgument,
    /// How far a body's response may change by what is left out.
    #[arg(long, value_name = "E", default_value_t = dcb_demand::pruning::DEFAULT_TOLERANCE, allow_negative_numbers = true)]
    pub tolerance: f64,
    /// List what of each body is left out, why, and at which estimated cost.
    #[arg(long)]
    pub explain: bool,
}

/// Contents of the superelements that are carried.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum ModelArgument {
    /// Needs of the scene.
    #[default]
    Needed,
    /// All that is in the files.
    Everything,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Try options of a scene: what each costs, and how far it is off.
    Study(StudyArguments),
    /// Reduce the parts of a scene, and leave out of them what its outputs don't need.
    Prepare(PrepareArguments),
    /// Draw recorded quantities over time as SVG.
    Plot {
        /// Results.
        results: PathBuf,
        /// Names of outputs or channels [default: all outputs].
        names: Vec<String>,
        /// Picture [default: RESULTS.svg].
        #[arg(long, short, value_name = "FILE")]
        output: Option<PathBuf>,
        /// Replace an existing picture.
        #[arg(long)]
        force: bool,
    },
    /// Write recorded quantities as CSV.
    Csv {
        /// Results.
        results: PathBuf,
        /// Names of outputs or channels [default: all outputs].
        names: Vec<String>,
        /// Table [default: RESULTS.csv].
        #[arg(long, short, value_name = "FILE")]
        output: Option<PathBuf>,
        /// Replace an existing table.
        #[arg(long)]
        force: bool,
    },
    /// List what a results file holds and how the run ended.
    Show {
        /// Results.
        results: PathBuf,
    },
    /// Print the JSON schema of scenes.
    Schema,
}

/// Runs the program.
pub fn main() -> ExitCode {
    let common = |cli: &Cli| (cli.common.threads, cli.common.told());
    let cli = match begin("SCENE.json", common) {
        Ok(cli) => cli,
        Err(status) => return status,
    };
    let done = match &cli.command {
        None => scene::run(&cli.scene, &cli.common),
        Some(Command::Prepare(arguments)) => prepare::run(arguments, &cli.common),
        Some(Command::Study(arguments)) => study::run(arguments, &cli.common),
        Some(Command::Plot {
            results,
            names,
            output,
            force,
        }) => export(
            results,
            output.as_deref(),
            replace(*force),
            "svg",
            |results, target| picture::plot(results, selection(names), target, replace(*force)),
        ),
        Some(Command::Csv {
            results,
            names,
            output,
            force,
        }) => export(
            results,
            output.as_deref(),
            replace(*force),
            "csv",
            |results, target| csv::write_csv(results, selection(names), target, replace(*force)),
        ),
        Some(Command::Show { results }) => show(results),
        Some(Command::Schema) => schema(),
    };
    let done = done.and_then(|done| {
        let is_report = matches!(cli.command, None | Some(Command::Study(_)));
        if !(is_report && cli.common.quiet) {
            print_to_stdout(&done.output)?;
        }
        Ok(done.ending)
    });
    match done {
        Ok(Ending::Complete) => ExitCode::SUCCESS,
        Ok(Ending::Interrupted) => {
            let signal = stop_signal::received().unwrap_or(StopSignal::Interrupt);
            ExitCode::from(signal.exit_status())
        }
        Err(error) => {
            print_to_stderr("error", &error.to_string());
            ExitCode::from(if error.is_unusable_input() { 2 } else { 1 })
        }
    }
}

/// Output of a command.
#[derive(Clone, Debug, PartialEq)]
pub struct Done {
    /// For standard output.
    pub output: String,
    /// Whether all was done.
    pub ending: Ending,
}

/// Whether all was done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ending {
    /// It was.
    Complete,
    /// The user stopped it.
    Interrupted,
}

impl Done {
    fn with(output: String) -> Self {
        Self {
            output,
            ending: Ending::Complete,
        }
    }
}

/// Treatment of an existing file.
pub(crate) fn replace(force: bool) -> Replace {
    if force {
        Replace::Overwrite
    } else {
        Replace::Refuse
    }
}

fn selection(names: &[String]) -> Selection<'_> {
    if names.is_empty() {
        Selection::Outputs
    } else {
        Selection::Named(names)
    }
}

/// A file made of results; without a name it stands beside them with the extension of its kind.
fn export(
    path: &Path,
    output: Option<&Path>,
    replace: Replace,
    extension: &str,
    write: impl FnOnce(&Results, &Path) -> Result<(), Error>,
) -> Result<Done, Error> {
    let results = Results::open(path)?;
    let target = output.map_or_else(|| path.with_extension(extension), Path::to_path_buf);
    check_output(&target, replace)?;
    refuse_inputs(&target, [path], "the file of the results")?;
    write(&results, &target)?;
    Ok(Done::with(format!("{}\n", target.display())))
}

fn show(path: &PathBuf) -> Result<Done, Error> {
    use std::fmt::Write as _;

    let results = Results::open(path)?;
    let mut text = format!("{}: {} rows, ", path.display(), results.step_count());
    // Writing to a string doesn't fail.
    let _ = match results.outcome() {
        dcb_formats::results::Outcome::Complete => writeln!(text, "complete"),
        dcb_formats::results::Outcome::Stopped {
            reason,
            time: Some(time),
        } => writeln!(text, "stopped at t = {time}: {}", one_line(reason)),
        dcb_formats::results::Outcome::Stopped { reason, time: None } => {
            writeln!(text, "stopped: {}", one_line(reason))
        }
    };
    for channel in results.channels() {
        let columns: Vec<String> = channel
            .columns
            .iter()
            .map(|column| format!("{} [{}]", channel.label(column), column.unit))
            .collect();
        let line = format!("{}  ({})", columns.join(", "), channel.description);
        let _ = writeln!(text, "  {}", one_line(&line));
    }
    if let Some(modes) = results.modes()? {
        let lists = modes.lists(results.units());
        let titles = lists
            .iter()
            .map(|(name, unit, _)| format!("{name} [{unit}]"));
        let titles: Vec<String> = titles.collect();
        let _ = writeln!(
            text,
            "  {} modes: {}",
            modes.frequency.len(),
            titles.join(", ")
        );
        for number in 0..modes.frequency.len() {
            let values = lists
                .iter()
                .map(|(.., values)| format!("{:>14.6e}", values[number]));
            let values: Vec<String> = values.collect();
            let _ = writeln!(text, "  {:>5} {}", number + 1, values.join(" "));
        }
    }
    for event in results.events()? {
        let _ = writeln!(text, "  t = {}: {}", event.time, one_line(&event.message));
    }
    Ok(Done::with(text))
}

fn schema() -> Result<Done, Error> {
    let text = serde_json::to_string_pretty(&scene_schema()).unwrap_or_default();
    Ok(Done::with(text + "\n"))
}
