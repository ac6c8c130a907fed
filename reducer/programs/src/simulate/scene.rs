//! The `simulate SCENE.json` command: read, run, record, and say what was done.

use std::path::{Path, PathBuf};

use dcb_formats::out_of_memory::at_stage;
use dcb_formats::output::{Replace, check_output, is_same_file};
use dcb_formats::results::Results;
use indicatif::ProgressBar;
use serde_json::json;

use crate::outcome::Outcome;
use crate::program::CommonArguments;
use crate::program::Told;
use crate::simulate::page::way_between;
use crate::simulate::run_report::{self, describe, told_of};
use crate::simulate::{ModelArgument, SceneArguments, replace};
use crate::stop_signal::{self, StopSignal};
use dcb_demand::SuperelementFiles;
use dcb_formats::scene::{Analysis, BeyondBand, Compatibility, Method, STANDARD_INPUT, Scene};
use dcb_runtime::error::Error;
use dcb_runtime::export::csv;
use dcb_runtime::export::history::Selection;
use dcb_runtime::model::Model;
use dcb_runtime::run::{self, Observer, Profiling, Target};
use dcb_workflow::progress_bar::bar;
use dcb_workflow::scene_study::{by_command_line, no_radius};

/// Positions of the progress bar.
const POSITIONS: u64 = 1000;

/// From now on the first signal to end is noticed instead of ending the program.
pub fn watch_for_interruption() {
    stop_signal::watch(|_| {});
}

/// Whether the program was asked to end.
pub fn is_interrupted() -> bool {
    stop_signal::received().is_some()
}

pub fn run(arguments: &SceneArguments, common: &CommonArguments) -> Result<Outcome, Error> {
    let Some(path) = &arguments.scene else {
        return Err(Error::described("SCENE.json", "is missing"));
    };
    check_tolerance(arguments.tolerance)?;
    at_stage("scene");
    let mut scene = Scene::read(path)?;
    override_scene(&mut scene, arguments)?;
    let output = match &arguments.output {
        Some(output) => output.clone(),
        None if path == Path::new(STANDARD_INPUT) => {
            return Err(Error::described(
                "--output",
                "is missing: a scene from standard input has no name for its results; name them with -o FILE.h5",
            ));
        }
        None => path.with_extension("h5"),
    };
    let mut target = Target {
        options: options(arguments, path, &output),
        path: output,
        replace: replace(arguments.force),
        fields_in: arguments.fields_in.clone(),
        kept: std::iter::once(path)
            .chain(&arguments.csv)
            .cloned()
            .collect(),
        profiling: if arguments.profile {
            Profiling::Stages
        } else {
            Profiling::Off
        },
    };
    check_output(&target.path, target.replace)?;
    check_targets(path, &scene, &target, arguments)?;
    watch_for_interruption();
    at_stage("superelements");
    let open = SuperelementFiles::default();
    let loaded = match arguments.model {
        ModelArgument::Everything => Model::load_from(&scene, &open).map(|model| (model, None)),
        ModelArgument::Needed => Model::load_needed(&scene, &open, arguments.tolerance)
            .map(|(model, pruning)| (model, Some(pruning))),
    };
    let (model, pruning) = loaded.map_err(|error| error.in_file(path))?;
    if let Some(pruning) = &pruning {
        target.options["left_out"] = json!(pruning.left_out());
    }
    drop(open);
    let mut watcher = Watcher::new(common);
    for note in &model.notes {
        watcher.note(0.0, note);
    }
    let mut loaded = describe(&scene, &model, common);
    if let Some(pruning) = &pruning {
        loaded += &told_of(pruning, arguments);
    }
    at_stage("run");
    let report = run::run(&scene, model, &target, &mut watcher);
    watcher.finish();
    let report = report.map_err(|error| error.in_file(path))?;
    if let Some(table) = &arguments.csv {
        let results = Results::open(&target.path)?;
        csv::write_csv(&results, Selection::Outputs, table, Replace::Overwrite)?;
    }
    let told = run_report::Told {
        report: &report,
        path: &target.path,
        scene: &scene,
        notes: watcher.notes,
        detail: common.detail(),
    };
    let output = told.text(&loaded)?;
    Ok(match report.is_complete() {
        true => Outcome::done(output),
        false => Outcome::interrupted(output),
    })
}

/// A tolerance is a part of something.
pub(crate) fn check_tolerance(tolerance: f64) -> Result<(), Error> {
    match tolerance > 0.0 && tolerance < 1.0 {
        true => Ok(()),
        false => Err(Error::described(
            "--tolerance",
            format!("is {tolerance}, expected a number between 0 and 1"),
        )),
    }
}

/// Nothing that is read may be written, and nothing that is written may be written over.
fn check_targets(
    scene_path: &Path,
    scene: &Scene,
    target: &Target,
    arguments: &SceneArguments,
) -> Result<(), Error> {
    let superelements: Vec<PathBuf> = (scene.superelements())
        .map(|(_, of)| scene.resolve(&of.file))
        .collect();
    let targets = [Some(&target.path), arguments.csv.as_ref()];
    for written in targets.into_iter().flatten() {
        run::refuse_inputs(written, [scene_path], "the scene")?;
        let superelements = superelements.iter().map(PathBuf::as_path);
        run::refuse_inputs(written, superelements, "a superelement of the scene")?;
    }
    let Some(table) = &arguments.csv else {
        return Ok(());
    };
    check_output(table, Replace::Overwrite)?;
    if is_same_file(table, &target.path) {
        return Err(Error::described(
            "--csv",
            "names the file of the results; name another one",
        ));
    }
    Ok(())
}

/// Options of the command line in place of the scene's.
fn override_scene(scene: &mut Scene, arguments: &SceneArguments) -> Result<(), Error> {
    for (option, given) in [("--step", arguments.step), ("--end", arguments.end)] {
        if let Some(given) = given.filter(|given| !(*given > 0.0 && given.is_finite())) {
            return Err(Error::described(
                option,
                format!("is {given}; expected a finite number above zero"),
            ));
        }
    }
    if let Some(integrator) = &mut scene.integrator {
        if let Some(step) = arguments.step {
            integrator.step = step;
        }
        if let Some(end) = arguments.end {
            integrator.end = end;
        }
        if let Some(given) = arguments.rho_infinity {
            match &mut integrator.method {
                Method::GeneralizedAlpha { rho_infinity } => *rho_infinity = given,
                method => return Err(no_radius(*method)),
            }
        }
    } else {
        let numbers = [
            ("--step", arguments.step),
            ("--end", arguments.end),
            ("--rho-infinity", arguments.rho_infinity),
        ];
        if let Some((option, _)) = numbers.iter().find(|(_, given)| given.is_some()) {
            return Err(Error::described(
                *option,
                "has nothing to change: the scene has no `integrator`",
            ));
        }
    }
    if let Some(compatibility) = arguments.compatibility {
        scene.compatibility = compatibility;
    }
    scene.allow_unstable_weak |= arguments.allow_unstable_weak;
    if arguments.strict {
        let Analysis::FrequencyResponse(asked) = &mut scene.analysis else {
            return Err(Error::described(
                "--strict",
                "is for a frequency response; the scene has another analysis",
            ));
        };
        asked.beyond_band = BeyondBand::Refuse;
    }
    scene.check().map_err(|error| by_command_line(error.into()))
}

fn options(arguments: &SceneArguments, scene: &Path, output: &Path) -> serde_json::Value {
    json!({
        "step": arguments.step,
        "end": arguments.end,
        "rho_infinity": arguments.rho_infinity,
        "compatibility": arguments.compatibility.map(Compatibility::name),
        "model": format!("{:?}", arguments.model).to_lowercase(),
        "tolerance": arguments.tolerance,
        "scene_file": way_between(output, scene),
    })
}

/// Tells notes on standard error, and progress if it is a terminal.
pub(crate) struct Watcher {
    bar: ProgressBar,
    told: Told,
    /// How many notes there were.
    notes: usize,
}

impl Watcher {
    pub(crate) fn new(common: &CommonArguments) -> Self {
        let (told, template) = (common.told(), "{wide_bar} t = {msg} ({eta} left)");
        Self {
            bar: bar(told.display(), POSITIONS, template),
            told,
            notes: 0,
        }
    }

    /// Takes the progress away.
    pub(crate) fn finish(&self) {
        self.bar.finish_and_clear();
    }
}

impl Observer for Watcher {
    fn note(&mut self, time: f64, message: &str) {
        self.notes += 1;
        let line = match time == 0.0 {
            true => message.to_owned(),
            false => format!("t = {time:.6}: {message}"),
        };
        self.bar.suspend(|| self.told.say("note", &line));
    }

    fn progress(&mut self, time: f64, end: f64) {
        self.bar
            .set_position((POSITIONS as f64 * time / end) as u64);
        self.bar.set_message(format!("{time:.4}"));
    }

    fn is_stopped(&self) -> bool {
        is_interrupted()
    }

    fn stop_reason(&self) -> &'static str {
        stop_signal::received()
            .unwrap_or(StopSignal::Interrupt)
            .reason()
    }
}
