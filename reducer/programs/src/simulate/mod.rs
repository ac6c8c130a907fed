//! The command line of `simulate`. Results go to standard output, everything else to standard error.

mod campbell;
mod component_reduction;
mod fmu;
mod init;
mod linearize;
mod page;
mod prepare;
mod run_report;
mod scene;
mod show;
mod study;

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use crate::examples::{SIMULATE, with_examples};
use crate::manual::{CompletionArguments, ManualArguments, completions, manual};
use crate::outcome::{Outcome, ended};
use crate::own_output::Made;
use crate::program::{CommonArguments, Program, Told, begin};
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use clap::{Args, CommandFactory, Parser, Subcommand, ValueEnum};
use dcb_formats::output::{Replace, check_output};
use dcb_formats::results::Results;

use crate::simulate::campbell::CampbellArguments;
use crate::simulate::fmu::FmuArguments;
use crate::simulate::init::InitArguments;
use crate::simulate::linearize::LinearizeArguments;
use crate::simulate::page::{AnimateArguments, PageArguments};
use crate::simulate::prepare::PrepareArguments;
use crate::simulate::show::ShowArguments;
use crate::simulate::study::StudyArguments;
use dcb_formats::scene::{Compatibility, scene_schema};
use dcb_runtime::error::Error;
use dcb_runtime::export::csv;
use dcb_runtime::export::history::Selection;
use dcb_runtime::export::picture;
use dcb_runtime::run::refuse_inputs;
use dcb_workflow::scene_page::Contents;

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
#[command(mut_arg("quiet", |arg| arg.help("Print no summary, notes or progress")))]
#[command(mut_arg("threads", |arg| arg.help("Worker threads [default: one per processor]; a scene is integrated by one")))]
struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
    #[command(flatten)]
    scene: SceneArguments,
    #[command(flatten)]
    common: CommonArguments,
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
            "Forces at the interfaces are coordinates (the paper's dual form): unstable at short steps, where it is refused unless --allow-unstable-weak",
        ),
    ];
    let choices = choices.map(|(name, help)| PossibleValue::new(name).help(help));
    PossibleValuesParser::new(choices).try_map(|name| serde_json::from_value(name.into()))
}

/// Options of a run.
#[derive(Debug, Args)]
pub(crate) struct SceneArguments {
    /// Scene; - reads it from standard input.
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
    /// Run --compatibility weak also at steps at which it is unstable.
    #[arg(long)]
    pub allow_unstable_weak: bool,
    /// Replace existing results, and files of fields.
    #[arg(long)]
    pub force: bool,
    /// Refuse a frequency response beyond what a superelement is made for.
    #[arg(long)]
    pub strict: bool,
    /// Also write the outputs as CSV (replaces an older one).
    #[arg(long, value_name = "FILE")]
    pub csv: Option<PathBuf>,
    /// Folder in which the scene may write fields, beside its own and that of the results.
    #[arg(long, value_name = "FOLDER")]
    pub fields_in: Option<PathBuf>,
    /// Say where the time goes.
    #[arg(long)]
    pub profile: bool,
    /// Which parts of the superelements the run carries.
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
pub(crate) enum ModelArgument {
    /// What this scene needs.
    #[default]
    Needed,
    /// All that is in the files.
    Everything,
}

/// Results, and what is made of them.
#[derive(Debug, Args)]
pub(crate) struct ExportArguments {
    /// Results.
    results: PathBuf,
    /// Names of outputs or channels, or of components: tip tip.z tip.x,tip.z [default: all outputs].
    names: Vec<String>,
    /// File [default: beside the results].
    #[arg(long, short, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Replace an existing one.
    #[arg(long)]
    force: bool,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Try options of a scene: what each costs, and how far it is off.
    Study(StudyArguments),
    /// Reduce the parts of a scene, and leave out of them what its outputs don't need.
    Prepare(PrepareArguments),
    /// Write the linear system about an operating point: A, B, C, D, poles.
    Linearize(LinearizeArguments),
    /// Whirl over the speed of a rotor: Campbell diagram and critical speeds.
    Campbell(CampbellArguments),
    /// Pack a scene and its superelements as an FMU: co-simulation by FMI 3.0, in whatever program.
    Fmu(FmuArguments),
    /// Draw recorded quantities over time as SVG.
    #[command(mut_arg("output", |arg| arg.help("Picture [default: RESULTS.svg]")))]
    #[command(mut_arg("force", |arg| arg.help("Replace an existing picture")))]
    Plot(ExportArguments),
    /// Write recorded quantities as CSV.
    #[command(mut_arg("output", |arg| arg.help("Table [default: RESULTS.csv]")))]
    #[command(mut_arg("force", |arg| arg.help("Replace an existing table")))]
    Csv(ExportArguments),
    /// Make a page in which the mechanism of a run moves, for any browser
    Animate(AnimateArguments),
    /// The same page with the tables of the run
    Report(PageArguments),
    /// List what a results file holds and how the run ended, or show values of what is named.
    Show(ShowArguments),
    /// Draft a scene of superelements in a chain: a scene that runs, with comments, to start from.
    Init(InitArguments),
    /// Print the JSON schema of scenes.
    Schema,
    /// Print what a shell needs to complete commands and options.
    Completions(CompletionArguments),
    /// Write the pages of the manual (for man).
    Man(ManualArguments),
}

/// The command line, with examples in its helps.
pub fn command() -> clap::Command {
    with_examples(Cli::command(), SIMULATE)
}

/// Runs the program with its name and arguments; the exit status. `other` is the command line of the other program, which may have an option
/// that this one hasn't.
pub fn main(arguments: impl IntoIterator<Item = OsString>, other: fn() -> clap::Command) -> u8 {
    let program = Program {
        file: "SCENE.json",
        examples: SIMULATE,
        other,
    };
    let cli = match begin(arguments, &program, |cli: &Cli| &cli.common) {
        Ok(cli) => cli,
        Err(status) => return status,
    };
    let done = match &cli.command {
        None => scene::run(&cli.scene, &cli.common),
        Some(Command::Prepare(arguments)) => prepare::run(arguments, &cli.common),
        Some(Command::Study(arguments)) => study::run(arguments, &cli.common),
        Some(Command::Linearize(arguments)) => linearize::run(arguments, &cli.common),
        Some(Command::Campbell(arguments)) => campbell::run(arguments, &cli.common),
        Some(Command::Fmu(arguments)) => fmu::run(arguments, &cli.common),
        Some(Command::Plot(arguments)) => export(arguments, "svg", picture::plot),
        Some(Command::Csv(arguments)) => export(arguments, "csv", csv::write_csv),
        Some(Command::Animate(arguments)) => page::animate(arguments),
        Some(Command::Report(arguments)) => page::run(arguments, Contents::Report),
        Some(Command::Show(arguments)) => show::run(arguments),
        Some(Command::Init(arguments)) => init::run(arguments),
        Some(Command::Schema) => schema(),
        Some(Command::Completions(arguments)) => Ok(completions(command(), arguments)),
        Some(Command::Man(arguments)) => manual(command(), arguments).map_err(Error::from),
    };
    let told = match cli.command {
        None
        | Some(
            Command::Study(_) | Command::Linearize(_) | Command::Campbell(_) | Command::Fmu(_),
        ) => cli.common.told(),
        _ => Told::Everything,
    };
    ended(done, told, Error::is_unusable_input, || {})
}

/// Treatment of an existing file.
pub(crate) fn replace(force: bool) -> Replace {
    if force {
        Replace::Overwrite
    } else {
        Replace::Refuse
    }
}

/// Writes a file made of results.
type Export = fn(&Results, Selection<'_>, &Path, Replace) -> Result<(), Error>;

/// A file made of results; without a name it stands beside them with the extension of its kind.
fn export(arguments: &ExportArguments, extension: &str, write: Export) -> Result<Outcome, Error> {
    let (path, replace) = (&arguments.results, replace(arguments.force));
    let results = opened(path)?;
    let beside = path.with_extension(extension);
    let target = arguments.output.as_ref().unwrap_or(&beside);
    if extension == "svg" {
        refuse_other_pictures(target)?;
    }
    let replace = match extension {
        "svg" => Made::Picture.replace(target, replace),
        _ => replace,
    };
    check_output(target, replace)?;
    refuse_inputs(target, [path.as_path()], "the file of the results")?;
    let selection = match arguments.names.as_slice() {
        [] => Selection::Outputs,
        names => Selection::Named(names),
    };
    write(&results, selection, target, replace)?;
    Ok(Outcome::done(format!("{}\n", target.display())))
}

/// Opens results; of a scene or a superelement in their place it is told what to do first.
fn opened(path: &Path) -> Result<Results, Error> {
    refuse_others(path)?;
    Ok(Results::open(path)?)
}

/// Of a scene or a superelement in the place of results it is told what to do first.
pub(crate) fn refuse_others(path: &Path) -> Result<(), Error> {
    let name = path.to_string_lossy();
    let message = if name.ends_with(".json") {
        format!(
            "is a scene, expected results of a run; run it first: simulate {name}, then take {}",
            path.with_extension("h5").display()
        )
    } else if name.ends_with(".dcb.h5") {
        format!("is a superelement, expected results of a run; its page: reduce report {name}")
    } else {
        return Ok(());
    };
    let path = path.to_owned();
    Err(dcb_formats::Error::File { path, message }.into())
}

/// Pictures are SVG: under the name of another kind no program would open them.
fn refuse_other_pictures(target: &Path) -> Result<(), Error> {
    const OTHERS: [&str; 7] = ["png", "jpg", "jpeg", "pdf", "gif", "eps", "webp"];
    let ending = target
        .extension()
        .map(|ending| ending.to_string_lossy().to_lowercase());
    match ending.filter(|ending| OTHERS.contains(&ending.as_str())) {
        None => Ok(()),
        Some(ending) => Err(Error::described(
            "--output",
            format!(
                "ends in .{ending}, but plots are SVG; write {} (a browser or Inkscape makes a .{ending} of it)",
                target.with_extension("svg").display()
            ),
        )),
    }
}

fn schema() -> Result<Outcome, Error> {
    let text = serde_json::to_string_pretty(&scene_schema()).unwrap_or_default();
    Ok(Outcome::done(text + "\n"))
}
