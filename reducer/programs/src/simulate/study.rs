//! The `simulate study SCENE.json` command: try options, and say what each costs and how far it is off.

use std::fmt::Write as _;
use std::num::NonZeroUsize;
use std::path::PathBuf;

use clap::{Args, ValueEnum};
use dcb_report::{PARETO_FRONT, Start};

use crate::outcome::Outcome;
use crate::program::CommonArguments;
use crate::simulate::compatibility;
use crate::simulate::scene::{is_interrupted, watch_for_interruption};
use dcb_formats::scene::{Compatibility, InertiaChange, Scene};
use dcb_runtime::error::Error;
use dcb_workflow::progress_bar::bar;
use dcb_workflow::scene_study::monitor::Monitor;
use dcb_workflow::scene_study::{
    Combination, Conducted, Fineness, Lists, ModeCount, Plan, SceneReference, SceneStudy, Setting,
    Store, Subject, report,
};
use dcb_workflow::shard::{Shard, waiting_for_others};

/// How far the inertia of bodies follows their deflection.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum InertiaArgument {
    /// Not at all.
    #[value(alias = "none")]
    Constant,
    /// In first order.
    #[value(alias = "linear")]
    FirstOrder,
    /// All of it.
    #[value(alias = "full")]
    SecondOrder,
}

/// Options of a study. Lists are separated by commas; without any list the study tries modes, strong and static compatibility and steps.
#[derive(Debug, Args)]
pub struct StudyArguments {
    /// Scene.
    #[arg(value_name = "SCENE.json")]
    scene: PathBuf,
    /// Numbers of modes, for every superelement: `1,2,5,all`.
    #[arg(long, value_name = "LIST", value_delimiter = ',', allow_hyphen_values = true, value_parser = mode_count)]
    modes: Vec<ModeCount>,
    /// How interfaces follow the coordinates: `strong,static,weak`.
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = compatibility())]
    compatibility: Vec<Compatibility>,
    /// Steps, in the scene's unit of time.
    #[arg(
        long,
        value_name = "LIST",
        value_delimiter = ',',
        allow_hyphen_values = true
    )]
    step: Vec<f64>,
    /// Accuracies of radau, whose steps follow them.
    #[arg(
        long,
        value_name = "LIST",
        value_delimiter = ',',
        allow_hyphen_values = true
    )]
    accuracy: Vec<f64>,
    /// Spectral radii at infinite frequency of generalized alpha.
    #[arg(
        long,
        value_name = "LIST",
        value_delimiter = ',',
        allow_hyphen_values = true
    )]
    rho_infinity: Vec<f64>,
    /// How far the inertia follows the deflection: `constant,first-order,second-order`.
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_enum)]
    inertia: Vec<InertiaArgument>,
    /// How the lists are combined [default: product, or one-at-a-time where that is more than 60 rows].
    #[arg(long, value_enum)]
    combine: Option<Combination>,
    /// Names of outputs or recorded channels to compare [default: all outputs].
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    outputs: Vec<String>,
    /// The error, relative to each output's range, for which the fastest row is named.
    #[arg(
        long,
        value_name = "E",
        default_value_t = 1e-3,
        allow_hyphen_values = true
    )]
    tolerance: f64,
    /// Folder of the study [default: SCENE.study]. One that was stopped, or is done, goes on.
    #[arg(long, short, value_name = "FOLDER")]
    output: Option<PathBuf>,
    /// Only every Nth row, beginning with the Ith: array task I of N. All tasks have one folder.
    #[arg(
        long,
        value_name = "I/N",
        allow_hyphen_values = true,
        conflicts_with = "force"
    )]
    shard: Option<Shard>,
    /// Start anew in a folder that has a study.
    #[arg(long)]
    force: bool,
}

pub fn run(arguments: &StudyArguments, common: &CommonArguments) -> Result<Outcome, Error> {
    let tolerance = arguments.tolerance;
    if !(tolerance > 0.0 && tolerance.is_finite()) {
        return Err(Error::described(
            "--tolerance",
            format!("is {tolerance}, expected a positive number"),
        ));
    }
    let path = &arguments.scene;
    let scene = Scene::read(path)?;
    let subject = Subject::of(scene, &arguments.outputs).map_err(|error| error.in_file(path))?;
    let asked = lists(arguments);
    asked.check(&subject)?;
    let lists = match asked.is_empty() {
        true => Lists::usual(&subject),
        false => asked,
    };
    let settings = lists.settings(&subject, arguments.combine)?;
    let grid = subject.grid(&settings);
    let own = subject.own.fineness;
    let values = settings.iter().map(|setting| setting.fineness.value());
    let finest = own.with(values.fold(f64::INFINITY, f64::min));
    let first = SceneReference::first_setting(&subject, finest);
    let default = path.with_extension("study");
    let folder = arguments.output.as_ref().unwrap_or(&default);
    let start = if arguments.force {
        Start::Anew
    } else {
        Start::Continue
    };
    let mut store = Store::open(folder, &subject, &first, grid, start)?;
    watch_for_interruption();
    let monitor = monitor(common);
    let plan = Plan {
        settings: &settings,
        shard: arguments.shard.unwrap_or(Shard::WHOLE),
        first,
        grid,
    };
    let conducted = SceneStudy::conduct(subject, plan, &mut store, threads(common), &monitor);
    monitor.close();
    let study = match conducted? {
        Conducted::Complete(study) => study,
        Conducted::Shared { made, of } => {
            return Ok(Outcome::done(waiting_for_others(made, of, folder)));
        }
        Conducted::Stopped => {
            return Ok(Outcome::interrupted(format!(
                "{}: stopped; the same command goes on with the rows that are left\n",
                folder.display()
            )));
        }
    };
    report::write(&study, &store, tolerance)?;
    Ok(Outcome::done(told(&study, &store, tolerance)))
}

fn lists(arguments: &StudyArguments) -> Lists {
    let inertia_changes = arguments.inertia.iter().map(|change| match change {
        InertiaArgument::Constant => InertiaChange::Constant,
        InertiaArgument::FirstOrder => InertiaChange::FirstOrder,
        InertiaArgument::SecondOrder => InertiaChange::SecondOrder,
    });
    Lists {
        modes: arguments.modes.clone(),
        compatibilities: arguments.compatibility.clone(),
        fineness: (arguments.step.iter().copied().map(Fineness::Step))
            .chain(arguments.accuracy.iter().copied().map(Fineness::Accuracy))
            .collect(),
        further_fineness: Vec::new(),
        radii: arguments.rho_infinity.clone(),
        inertia_changes: inertia_changes.collect(),
    }
}

fn mode_count(text: &str) -> Result<ModeCount, String> {
    match text.trim() {
        "all" => Ok(ModeCount::All),
        number => number
            .parse()
            .map(ModeCount::Lowest)
            .map_err(|_| format!("{number:?} is no number of modes; give a whole number or `all`")),
    }
}

/// As many as were asked for, or as the machine runs at once.
fn threads(common: &CommonArguments) -> NonZeroUsize {
    let asked = common
        .threads
        .and_then(|count| NonZeroUsize::new(count.into()));
    asked
        .or_else(|| std::thread::available_parallelism().ok())
        .unwrap_or(NonZeroUsize::MIN)
}

/// Progress of a study or a preparation.
pub(crate) fn monitor(common: &CommonArguments) -> Monitor {
    let template = "{wide_bar} {msg}: {percent} % of the steps ({eta} left)";
    Monitor::new(bar(common.told().display(), 0, template), is_interrupted)
}

/// Value found.
fn told(study: &SceneStudy, store: &Store, tolerance: f64) -> String {
    let subject = &study.subject;
    let time = &subject.scene.units.time;
    let stable = study.rows.iter().filter(|row| row.is_stable()).count();
    let mut text = match study.rows.len() {
        1 => format!("1 row, {stable} of it stable\n"),
        count => format!("{count} rows, {stable} of them stable\n"),
    };
    // Writing to a string doesn't fail.
    let _ = writeln!(text, "{}", study.reference_told());
    let _ = writeln!(text, "{PARETO_FRONT}");
    let _ = writeln!(
        text,
        "{:>4} {:>6} {:<8} {:>11} {:>5} {:<12} {:>8} {:>10} {:>9} {:>11}",
        "row",
        "modes",
        "compat.",
        match subject.own.fineness {
            Fineness::Step(_) => format!("step [{time}]"),
            Fineness::Accuracy(_) => "accuracy".to_owned(),
        },
        "rho",
        "inertia",
        "elastic",
        format!("wall [s/{time}]"),
        "steps/s",
        "error/range"
    );
    for index in study.front() {
        let row = &study.rows[index];
        let Setting {
            fineness,
            rho_infinity,
            ..
        } = row.setting;
        let _ = writeln!(
            text,
            "{:>4} {:>6} {:<8} {:>11.4e} {:>5} {:<12} {:>8} {:>10.4} {:>9.0} {:>11}",
            index + 1,
            row.setting.modes_text(),
            row.setting.compatibility.name(),
            fineness.value(),
            rho_infinity.map_or("-".to_owned(), |rho| rho.to_string()),
            row.setting.inertia_text(),
            row.course.elastic,
            row.cost(subject.end).unwrap_or(f64::NAN),
            row.speed().unwrap_or(f64::NAN),
            row.claim(&study.reference).to_string(),
        );
    }
    let _ = writeln!(text, "{}", study.verdict(tolerance));
    if let Some(index) = study.best(tolerance) {
        let _ = writeln!(
            text,
            "In the scene: {}",
            study.rows[index].setting.in_scene(subject)
        );
    }
    let _ = writeln!(text, "{}", store.path("report.html").display());
    text
}
