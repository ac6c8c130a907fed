//! Reductions of the components of a scene before it is prepared, each by the program `reduce`.

use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus};
use std::time::Duration;

use dcb_formats::component_files::with_ending;
use dcb_formats::dcb::SuperelementFile;
use dcb_formats::mesh::Dimension;
use dcb_formats::scene::{BodyKind, Scene};
use dcb_runtime::error::Error;
use dcb_workflow::batch::child::terminate;

use crate::simulate::prepare::PrepareArguments;
use crate::simulate::scene::is_interrupted;

/// Folder of the superelements that are reduced, in that of the prepared scene, until it is done.
pub(super) const FOLDER: &str = "large";
/// Fraction of the tolerance that the reductions may use.
const REDUCTION_SHARE: f64 = 0.5;
/// Interval at which a running reduction is looked at.
const LOOK_INTERVAL: Duration = Duration::from_millis(20);

/// A component that was reduced for a preparation.
pub(super) struct Reduced {
    /// The superelement as the scene names it.
    file: PathBuf,
    /// Its stiffness matrix.
    pub(super) matrix: PathBuf,
    /// The superelement that was made, absolute.
    pub(super) large: PathBuf,
}

/// Reduces every component whose matrix stands beside where the scene has its superelement, and puts the large superelements in its place.
pub(super) fn reduce_components(
    scene: &mut Scene,
    arguments: &PrepareArguments,
    folder: &Path,
) -> Result<Vec<Reduced>, Error> {
    let mut parts: Vec<Reduced> = Vec::new();
    for (_, of) in scene.superelements() {
        let file = scene.resolve(&of.file);
        let Some(matrix) = matrix_of(&file) else {
            continue;
        };
        if is_spatial_in_plane(scene, &file) {
            continue;
        }
        if parts.iter().all(|part| part.file != of.file) {
            let name = file.file_name().unwrap_or_default().to_string_lossy();
            let place = folder.join(FOLDER).join(parts.len().to_string());
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
                    let program = program(arguments);
                    let refused = dcb_formats::Error::io(&program, "cannot run", source);
                    failure.get_or_insert(refused.into());
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
            terminate(&mut child);
            return child.wait();
        }
        std::thread::sleep(LOOK_INTERVAL);
    }
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
    let mut candidates = [".mtx", ".mtx.gz"]
        .into_iter()
        .map(|ending| with_ending(&stem, ending));
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
pub(super) fn size(text: &str) -> Result<(f64, String), String> {
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

/// Makes a folder, and those that it is in.
pub(super) fn create(folder: &Path) -> Result<(), Error> {
    let told = |source| dcb_formats::Error::io(folder, "cannot create", source).into();
    std::fs::create_dir_all(folder).map_err(told)
}
