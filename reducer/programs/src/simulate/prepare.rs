//! The `simulate prepare SCENE.json` command: reduce the parts of a scene, and leave out of them what its outputs don't need.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::time::Instant;

use clap::Args;
use dcb_formats::output::check_output;
use dcb_formats::output::write_text;
use serde::Serialize;
use serde_json::json;

use crate::outcome::Outcome;
use crate::program::{CommonArguments, Detail};
use crate::simulate::component_reduction::{self, Reduced, create, reduce_components};
use crate::simulate::replace;
use crate::simulate::scene::{check_tolerance, is_interrupted, watch_for_interruption};
use crate::simulate::study::monitor;
use dcb_formats::scene::{InertiaChange, Integrator, Scene};
use dcb_runtime::error::Error;
use dcb_runtime::run::refuse_inputs;
use dcb_workflow::prepare::{FieldSamples, Integration, Prepared, PreparedFile, prepare, write};
use dcb_workflow::scene_study::Subject;

/// Options of a preparation.
#[derive(Debug, Args)]
pub struct PrepareArguments {
    /// Scene.
    #[arg(value_name = "SCENE.json")]
    pub(super) scene: PathBuf,
    /// How far an output may be off, relative to its range.
    #[arg(
        long,
        value_name = "E",
        default_value_t = 1e-3,
        allow_negative_numbers = true
    )]
    pub(super) tolerance: f64,
    /// Names of outputs or recorded channels that are kept within it [default: all outputs].
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    outputs: Vec<String>,
    /// Time at which the runs of the preparation end [default: the scene's].
    #[arg(long, value_name = "T", allow_negative_numbers = true)]
    end: Option<f64>,
    /// Adapt the integrator too, as far as the tolerance allows: a coarser iteration and steps up to 16 times as long, or radau.
    #[arg(long)]
    adapt_integrator: bool,
    /// Folder of the prepared scene [default: SCENE.prepared].
    #[arg(long, short, value_name = "FOLDER")]
    output: Option<PathBuf>,
    /// Replace files in it.
    #[arg(long)]
    force: bool,
    /// Reductions beside each other.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(super) jobs: u16,
    /// Memory that all of them may take together, for example 8G [default: what `reduce` finds available].
    #[arg(long, value_name = "SIZE", value_parser = component_reduction::size)]
    pub(super) memory: Option<(f64, String)>,
    /// Let the reductions use a cache (docs/cache.md).
    #[arg(long, value_name = "FOLDER", num_args = 0..=1, require_equals = true)]
    pub(super) cache: Option<Option<PathBuf>>,
    /// The program that reduces [default: `reduce` beside this one, or on the path].
    #[arg(long, value_name = "FILE")]
    pub(super) reduce: Option<PathBuf>,
}

pub fn run(arguments: &PrepareArguments, common: &CommonArguments) -> Result<Outcome, Error> {
    let tolerance = arguments.tolerance;
    check_tolerance(tolerance)?;
    let path = &arguments.scene;
    let mut scene = Scene::read(path)?;
    let end = scene.integrator.map(|integrator| integrator.end);
    if let (Some(given), Some(integrator)) = (arguments.end, &mut scene.integrator) {
        integrator.end = given;
        scene.check()?;
    }
    let default = path.with_extension("prepared");
    let folder = arguments.output.as_ref().unwrap_or(&default);
    let replace = replace(arguments.force);
    create(folder)?;
    for name in ["scene.json", "report.json"] {
        check_output(&folder.join(name), replace)?;
        refuse_inputs(&folder.join(name), [path.as_path()], "the scene")?;
    }
    watch_for_interruption();
    let clock = Instant::now();
    let reduced = reduce_components(&mut scene, arguments, folder)?;
    let reduction = clock.elapsed().as_secs_f64();
    if is_interrupted() {
        return Ok(stopped(folder));
    }
    let fields = FieldSamples::add_to(&mut scene).map_err(|error| error.in_file(path))?;
    let subject = Subject::of(scene, &arguments.outputs);
    let mut subject = subject.map_err(|error| error.in_file(path))?;
    fields.join(&mut subject);
    let monitor = monitor(common);
    let integration = match arguments.adapt_integrator {
        true => Integration::Adapted,
        false => Integration::OfScene,
    };
    let prepared = prepare(&subject, tolerance, integration, &monitor);
    monitor.close();
    let Some(mut prepared) = prepared? else {
        return Ok(stopped(folder));
    };
    if let (Some(end), Some(integrator)) = (end, &mut prepared.narrowed.scene.integrator) {
        integrator.end = end;
    }
    fields.restore(&mut prepared.narrowed.scene);
    let mut files = write(&prepared, folder, replace)?;
    for file in &mut files {
        file.from = from_folder(&file.from, &reduced, folder);
    }
    // What is left over can stay.
    let _ = std::fs::remove_dir_all(folder.join(component_reduction::FOLDER));
    let seconds = Seconds {
        reduction,
        runs: clock.elapsed().as_secs_f64() - reduction,
    };
    report(&prepared, &files, tolerance, &seconds, folder)?;
    Ok(Outcome::done(
        told(
            &prepared,
            &files,
            (tolerance, integration),
            folder,
            common.detail(),
        ) + &fields.told(&subject),
    ))
}

/// Effort of a preparation.
#[derive(Serialize)]
struct Seconds {
    /// Reducing the parts.
    reduction: f64,
    /// Running the scene, choosing and writing.
    runs: f64,
}

fn stopped(folder: &Path) -> Outcome {
    Outcome::interrupted(format!(
        "{}: stopped, nothing was prepared\n",
        folder.display()
    ))
}

/// Source of a file, from the folder of the prepared scene. Of a superelement that was reduced here it is the matrix: the superelement itself is deleted.
fn from_folder(file: &Path, reduced: &[Reduced], folder: &Path) -> PathBuf {
    let made = reduced.iter().find(|part| part.large == file);
    let from = made.map_or(file, |part| &part.matrix);
    let absolute = |path: &Path| std::path::absolute(path).unwrap_or_else(|_| path.to_owned());
    // Another drive has no relative path.
    pathdiff::diff_paths(absolute(from), absolute(folder))
        .filter(|path| path.is_relative())
        .or_else(|| from.file_name().map(PathBuf::from))
        .unwrap_or_default()
}

fn report(
    prepared: &Prepared,
    files: &[PreparedFile],
    tolerance: f64,
    seconds: &Seconds,
    folder: &Path,
) -> Result<(), Error> {
    let bodies = prepared.pruning.bodies.iter();
    let left_out: serde_json::Map<String, serde_json::Value> = bodies
        .map(|(name, pruned)| {
            let told = pruned.left_out.iter().map(ToString::to_string);
            (name.clone(), told.collect())
        })
        .collect();
    let trials = prepared.trials.iter();
    let trials: Vec<_> = trials
        .map(|trial| {
            json!({"coordinates": trial.kept, "error": trial.error.is_finite().then_some(trial.error)})
        })
        .collect();
    let text = json!({
        "tolerance": tolerance,
        "error": prepared.error,
        "coordinates": prepared.coordinates,
        "of_coordinates": prepared.reference.elastic,
        "integrator": prepared.narrowed.scene.integrator,
        "left_out": left_out,
        "inertia_change": simpler_inertia(&prepared.narrowed.scene).collect::<BTreeMap<_, _>>(),
        "trials": trials,
        "seconds": seconds,
        "files": files,
    });
    let path = folder.join("report.json");
    Ok(write_text(&path, &format!("{text:#}\n"))?)
}

/// Bodies whose inertia doesn't follow the deflection to second order, and how it does.
fn simpler_inertia(scene: &Scene) -> impl Iterator<Item = (&str, &'static str)> {
    (scene.superelements()).filter_map(|(name, of)| match of.inertia_change {
        InertiaChange::Constant => Some((name, "that of the undeformed body")),
        InertiaChange::FirstOrder => Some((name, "follows the deflection to first order")),
        InertiaChange::SecondOrder => None,
    })
}

/// A method and how finely it integrates.
fn described(integrator: &Integrator, time: &str) -> String {
    let name = integrator.method.name();
    match integrator.is_radau() {
        true => format!("{name}, accuracy {:.1e}", integrator.tolerance),
        false => format!(
            "{name}, steps of {:.3e} {time}, iteration to {:.0e}",
            integrator.step, integrator.tolerance
        ),
    }
}

fn told(
    prepared: &Prepared,
    files: &[PreparedFile],
    (tolerance, integration): (f64, Integration),
    folder: &Path,
    detail: Detail,
) -> String {
    let mut text = format!(
        "prepared: {} of {} elastic coordinates are enough; outputs differ by at most {:.1e} of their range from the run with all of them (allowed {tolerance:.0e}; {} runs)\n",
        prepared.coordinates, prepared.reference.elastic, prepared.error, prepared.runs
    );
    if detail == Detail::Tables {
        text += &prepared.pruning.to_string();
    }
    // Writing to a string doesn't fail.
    for (name, inertia) in simpler_inertia(&prepared.narrowed.scene) {
        let _ = writeln!(text, "inertia of body {name:?}: {inertia}");
    }
    let scene = &prepared.narrowed.scene;
    if let (Integration::Adapted, Some(integrator)) = (integration, &scene.integrator) {
        let _ = writeln!(
            text,
            "integrator: {}",
            described(integrator, &scene.units.time)
        );
    }
    for file in files {
        let _ = writeln!(
            text,
            "{}: {} of {} coordinates, {} of {} bytes",
            folder.join(&file.file).display(),
            file.coordinates,
            file.of_coordinates,
            file.size,
            file.of_size
        );
    }
    let _ = writeln!(text, "{}", folder.join("scene.json").display());
    text
}
