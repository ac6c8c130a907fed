//! The `simulate prepare SCENE.json` command: reduce the parts of a scene, and leave out of them what its outputs don't need.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus};
use std::time::{Duration, Instant};

use clap::Args;
use dcb_formats::dcb::SuperelementFile;
use dcb_formats::mesh::Dimension;
use dcb_formats::output::check_output;
use dcb_formats::output::write_text;
use serde::Serialize;
use serde_json::json;

use crate::simulate::scene::{check_tolerance, is_interrupted, watch_for_interruption};
use crate::simulate::study::bar;
use crate::simulate::{CommonArguments, Done, Ending, replace};
use dcb_formats::scene::{BodyKind, InertiaChange, Scene};
use dcb_runtime::error::Error;
use dcb_runtime::run::refuse_inputs;
use dcb_workflow::prepare::{FieldSamples, Integration, Prepared, PreparedFile, prepare, write};
use dcb_workflow::scene_study::Subject;
use dcb_workflow::scene_study::monitor::Monitor;

/// Folder of the superelements that are reduced, in that of the prepared scene, until it is done.
const LARGE: &str = "large";
/// Part of the tolerance that the reductions may use.
const REDUCTION_SHARE: f64 = 0.5;
/// How often a reduction is looked at.
const LOOK_INTERVAL: Duration = Duration::from_millis(20);

/// Options of a preparation.
#[derive(Debug, Args)]
pub struct PrepareArguments {
    /// Scene.
    #[arg(value_name = "SCENE.json")]
    scene: PathBuf,
    /// How far an output may be off, relative to its range.
    #[arg(
        long,
        value_name = "E",
        default_value_t = 1e-3,
        allow_negative_numbers = true
    )]
    tolerance: f64,
    /// Names of outputs or recorded channels that are kept within it [default: all outputs].
    #[arg(long, value_name = "LIST", value_delimiter = ',')]
    outputs: Vec<String>,
    /// Time at which the runs of the preparation end [default: the scene's].
    #[arg(long, value_name = "T", allow_negative_numbers = true)]
    end: Option<f64>,
    /// Adapt the integrator too: a coarser iteration, and steps up to 16 times as long, as far as the tolerance allows.
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
    jobs: u16,
    /// Memory that all of them may take together, for example 8G [default: what `reduce` finds available].
    #[arg(long, value_name = "SIZE", value_parser = size)]
    memory: Option<(f64, String)>,
    /// Let the reductions use a cache (docs/cache.md).
    #[arg(long, value_name = "FOLDER", num_args = 0..=1, require_equals = true)]
    cache: Option<Option<PathBuf>>,
    /// The program that reduces [default: `reduce` beside this one, or on the path].
    #[arg(long, value_name = "FILE")]
    reduce: Option<PathBuf>,
}

/// Runs the command.
///
/// # Errors
/// Whatever made it impossible to read, to reduce, to make the run with everything, or to write.
pub fn run(arguments: &PrepareArguments, common: &CommonArguments) -> Result<Done, Error> {
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
    let reduced = reduce_parts(&mut scene, arguments, folder)?;
    let reduction = clock.elapsed().as_secs_f64();
    if is_interrupted() {
        return Ok(stopped(folder));
    }
    let fields = FieldSamples::add_to(&mut scene).map_err(|error| error.in_file(path))?;
    let subject = Subject::of(scene, &arguments.outputs);
    let mut subject = subject.map_err(|error| error.in_file(path))?;
    fields.join(&mut subject);
    let monitor = Monitor::new(bar(common), is_interrupted);
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
    let _ = std::fs::remove_dir_all(folder.join(LARGE));
    let seconds = Seconds {
        reduction,
        runs: clock.elapsed().as_secs_f64() - reduction,
    };
    report(&prepared, &files, tolerance, &seconds, folder)?;
    Ok(Done {
        output: told(&prepared, &files, tolerance, folder) + &fields.told(&subject),
        ending: Ending::Complete,
    })
}

/// What a preparation took.
#[derive(Serialize)]
struct Seconds {
    /// Reducing the parts.
    reduction: f64,
    /// Running the scene, choosing and writing.
    runs: f64,
}

fn stopped(folder: &Path) -> Done {
    Done {
        output: format!("{}: stopped, nothing was prepared\n", folder.display()),
        ending: Ending::Interrupted,
    }
}

fn create(folder: &Path) -> Result<(), Error> {
    std::fs::create_dir_all(folder).map_err(|source| {
        Error::File(dcb_formats::Error::Io {
            path: folder.to_owned(),
            action: "cannot create",
            source,
        })
    })
}

/// What a file was made of, from the folder of the prepared scene: of a superelement that was reduced here the matrix, because it is gone itself.
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

/// A part that was reduced for a preparation.
struct Reduced {
    /// The superelement as the scene names it.
    file: PathBuf,
    matrix: PathBuf,
    /// The superelement that was made, absolute.
    large: PathBuf,
}

/// Reduces every part whose matrix stands beside where the scene has its superelement, and puts the large superelements in its place.
fn reduce_parts(
    scene: &mut Scene,
    arguments: &PrepareArguments,
    folder: &Path,
) -> Result<Vec<Reduced>, Error> {
    let mut parts: Vec<Reduced> = Vec::new();
    for body in scene.bodies.values() {
        let BodyKind::Superelement(of) = &body.kind else {
            continue;
        };
        let file = scene.resolve(&of.file);
        let Some(matrix) = matrix_of(&file) else {
            continue;
        };
        if is_spatial_in_plane(scene, &file) {
            continue;
        }
        if parts.iter().all(|part| part.file != of.file) {
            let name = file.file_name().unwrap_or_default().to_string_lossy();
            let place = folder.join(LARGE).join(parts.len().to_string());
            create(&place)?;
            let large = place.join(&*name);
            parts.push(Reduced {
                file: of.file.clone(),
                matrix,
                large: std::path::absolute(&large).unwrap_or(large),
            });
        }
    }
    let mut waiting = parts.iter();
    let mut failure = None;
    loop {
        let batch: Vec<_> = waiting.by_ref().take(arguments.jobs.into()).collect();
        if batch.is_empty() || is_interrupted() {
            break;
        }
        let share = batch.len();
        let mut running = Vec::new();
        for Reduced { matrix, large, .. } in batch {
            running.push((matrix, reduction(arguments, matrix, large, share).spawn()));
        }
        for (matrix, child) in running {
            let status = child.and_then(end_of);
            match status {
                Ok(status) if status.success() => {}
                Ok(status) => {
                    failure.get_or_insert(Error::Reduction {
                        part: matrix.clone(),
                        status: status.to_string(),
                        is_unusable_input: status.code() == Some(2),
                    });
                }
                Err(source) => {
                    failure.get_or_insert(Error::File(dcb_formats::Error::Io {
                        path: program(arguments),
                        action: "cannot run",
                        source,
                    }));
                }
            }
        }
    }
    if let Some(failure) = failure.filter(|_| !is_interrupted()) {
        return Err(failure);
    }
    for body in scene.bodies.values_mut() {
        if let BodyKind::Superelement(of) = &mut body.kind
            && let Some(part) = parts.iter().find(|part| part.file == of.file)
        {
            of.file.clone_from(&part.large);
        }
    }
    Ok(parts)
}

/// Waits for a reduction, and passes on to it that this program is asked to end.
fn end_of(mut child: Child) -> std::io::Result<ExitStatus> {
    loop {
        if let Some(status) = child.try_wait()? {
            return Ok(status);
        }
        if is_interrupted() {
            terminate(&mut child)?;
            return child.wait();
        }
        std::thread::sleep(LOOK_INTERVAL);
    }
}

/// Lets it remove what it has begun to write.
#[cfg(unix)]
fn terminate(child: &mut Child) -> std::io::Result<()> {
    use nix::sys::signal::{Signal, kill};
    use nix::unistd::Pid;

    match i32::try_from(child.id()) {
        Ok(id) => kill(Pid::from_raw(id), Signal::SIGTERM).map_err(Into::into),
        Err(_) => child.kill(),
    }
}

#[cfg(not(unix))]
fn terminate(child: &mut Child) -> std::io::Result<()> {
    child.kill()
}

/// Whether a planar scene uses a spatial superelement, which is taken as it is.
fn is_spatial_in_plane(scene: &Scene, superelement: &Path) -> bool {
    let read = SuperelementFile::open(superelement).and_then(|file| file.superelement());
    read.is_ok_and(|read| {
        (scene.dimension, read.dimension) == (Dimension::Planar, Dimension::Spatial)
    })
}

/// `NAME.mtx` or `NAME.mtx.gz` beside `NAME.dcb.h5`, if there is one.
fn matrix_of(superelement: &Path) -> Option<PathBuf> {
    let without = |path: PathBuf, extension: &str| {
        (path.extension()? == extension).then(|| path.with_extension(""))
    };
    let stem = without(without(superelement.to_path_buf(), "h5")?, "dcb")?;
    let mut candidates = [".mtx", ".mtx.gz"].into_iter().map(|ending| {
        let mut name = stem.as_os_str().to_owned();
        name.push(ending);
        PathBuf::from(name)
    });
    candidates.find(|candidate| candidate.is_file())
}

fn reduction(arguments: &PrepareArguments, matrix: &Path, large: &Path, share: usize) -> Command {
    let mut command = Command::new(program(arguments));
    command
        .arg(matrix)
        .arg("--scene")
        .arg(&arguments.scene)
        .arg("--tolerance")
        .arg((REDUCTION_SHARE * arguments.tolerance).to_string())
        .arg("-o")
        .arg(large)
        .args(["--keep-all", "--force", "--quiet"]);
    match &arguments.cache {
        None => {}
        Some(None) => {
            command.arg("--cache");
        }
        Some(Some(folder)) => {
            command.arg(format!("--cache={}", folder.display()));
        }
    }
    if let Some((size, unit)) = &arguments.memory {
        command.arg("--memory");
        command.arg(format!("{}{unit}", size / share as f64));
    }
    command
}

/// A size and its unit, which `reduce` understands.
fn size(text: &str) -> Result<(f64, String), String> {
    let number = text.trim_end_matches(|c: char| c.is_ascii_alphabetic());
    match number.trim().parse::<f64>() {
        Ok(size) if size > 0.0 && size.is_finite() => Ok((size, text[number.len()..].to_owned())),
        _ => Err(format!("{text:?} is no size; give for example 8G")),
    }
}

/// `reduce` beside this program, or wherever the system finds it.
fn program(arguments: &PrepareArguments) -> PathBuf {
    if let Some(given) = &arguments.reduce {
        return given.clone();
    }
    let name = format!("reduce{}", std::env::consts::EXE_SUFFIX);
    let beside = std::env::current_exe().map(|own| own.with_file_name(&name));
    match beside {
        Ok(beside) if beside.is_file() => beside,
        _ => PathBuf::from(name),
    }
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
        "step": prepared.narrowed.scene.integrator.map(|integrator| integrator.step),
        "iteration_tolerance": prepared.narrowed.scene.integrator.map(|integrator| integrator.tolerance),
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
    scene.bodies.iter().filter_map(|(name, body)| {
        let BodyKind::Superelement(of) = &body.kind else {
            return None;
        };
        match of.inertia_change {
            InertiaChange::Constant => Some((name.as_str(), "that of the undeformed body")),
            InertiaChange::FirstOrder => {
                Some((name.as_str(), "follows the deflection to first order"))
            }
            InertiaChange::SecondOrder => None,
        }
    })
}

fn told(prepared: &Prepared, files: &[PreparedFile], tolerance: f64, folder: &Path) -> String {
    let mut text = prepared.pruning.to_string();
    // Writing to a string doesn't fail.
    let _ = writeln!(
        text,
        "{} of {} elastic coordinates are enough, found by {} runs: no output is further than {:.1e} of its range from the run with everything (allowed {tolerance:.0e})",
        prepared.coordinates, prepared.reference.elastic, prepared.runs, prepared.error
    );
    for (name, inertia) in simpler_inertia(&prepared.narrowed.scene) {
        let _ = writeln!(text, "inertia of body {name:?}: {inertia}");
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
