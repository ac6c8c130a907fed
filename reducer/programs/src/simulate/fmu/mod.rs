//! The `simulate fmu SCENE.json` command: a scene with all that it needs as one archive for co-simulation (FMI 3.0).

mod archive;
mod library;
mod resources;

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use clap::Args;
use dcb_cosimulation::{CoSimulation, Named, Source, documentation, model_description, terminals};
use dcb_formats::output::{UnfinishedFolder, check_output};
use dcb_formats::scene::Scene;
use dcb_formats::units::readable;
use dcb_runtime::error::Error;
use dcb_runtime::run::refuse_inputs;

use crate::outcome::Outcome;
use crate::program::CommonArguments;
use crate::simulate::replace;
use archive::Member;
use library::Library;
use resources::Resources;

/// Licence of what is in the library.
const LICENCE: &str = include_str!("../../../../../LICENSE-MIT");

/// Options of an archive.
#[derive(Debug, Args)]
pub struct FmuArguments {
    /// Scene.
    #[arg(value_name = "SCENE.json")]
    scene: PathBuf,
    /// Archive [default: SCENE.fmu].
    #[arg(long, short, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Shared library with the functions of FMI, once for each platform [default: libdcb_fmu beside this program or in ../lib].
    #[arg(long, value_name = "FILE")]
    library: Vec<PathBuf>,
    /// Replace an existing archive.
    #[arg(long)]
    force: bool,
}

pub fn run(arguments: &FmuArguments, common: &CommonArguments) -> Result<Outcome, Error> {
    let path = &arguments.scene;
    let scene = Scene::read(path)?;
    let beside = path.with_extension("fmu");
    let target = arguments.output.as_ref().unwrap_or(&beside);
    let replace = replace(arguments.force);
    check_output(target, replace)?;
    refuse_inputs(target, [path.as_path()], "the scene")?;
    let superelements: Vec<PathBuf> = (scene.superelements())
        .map(|(_, of)| scene.resolve(&of.file))
        .collect();
    let superelements = superelements.iter().map(PathBuf::as_path);
    refuse_inputs(target, superelements, "a superelement of the scene")?;
    let libraries = Library::find(&arguments.library)?;
    let paths = libraries.iter().map(|library| library.path.as_path());
    refuse_inputs(target, paths, "the shared library")?;
    let name = name(target);
    let identifier = identifier(&name);

    // The unit is read from the folder that goes into the archive, as importers will read it.
    let folder = folder_of(target);
    let unfinished = UnfinishedFolder::within(folder, target.file_name().unwrap_or_default())
        .map_err(|source| dcb_formats::Error::not_written(target, 0, source))?;
    let resources =
        Resources::write(scene, unfinished.path()).map_err(|error| error.in_file(path))?;
    let mut unit = CoSimulation::load(unfinished.path()).map_err(|error| told(error, path))?;
    for warning in unit.take_warnings() {
        common.told().say("note", &warning);
    }
    let named = Named {
        model: &name,
        identifier: &identifier,
    };
    let written = |source| dcb_formats::Error::not_written(target, 0, source);
    let mut members = vec![
        Member::text(
            "modelDescription.xml",
            model_description(&unit, named).map_err(written)?,
        ),
        Member::text(
            "documentation/index.html",
            documentation(&unit, named).map_err(written)?,
        ),
        Member::text("documentation/licenses/license.txt", LICENCE.to_owned()),
    ];
    if let Some(terminals) = terminals(&unit).map_err(written)? {
        let member = "terminalsAndIcons/terminalsAndIcons.xml";
        members.push(Member::text(member, terminals));
    }
    for library in libraries {
        members.push(library.member(&identifier));
    }
    members.extend(resources.members(unfinished.path())?);
    archive::write(members, target, replace)?;
    drop(unfinished);
    Ok(Outcome::done(report(&unit, &resources, target)))
}

/// What was written.
fn report(unit: &CoSimulation, resources: &Resources, target: &Path) -> String {
    let mut counts = [0; 3];
    for variable in unit.variables() {
        match variable.source {
            Source::Time => {}
            Source::Parameter(_) => counts[0] += 1,
            Source::Input(_) => counts[1] += 1,
            Source::Output { .. } => counts[2] += 1,
        }
    }
    let counted = |count: usize, what: &str| match count {
        1 => format!("1 {what}"),
        _ => format!("{count} {what}s"),
    };
    let mut text = format!(
        "{}, {}, {}\n",
        counted(counts[0], "parameter"),
        counted(counts[1], "input"),
        counted(counts[2], "output")
    );
    for part in resources.parts() {
        // Writing to a string doesn't fail.
        let _ = writeln!(text, "{part}");
    }
    let size = std::fs::metadata(target).map_or(0, |data| data.len());
    let _ = writeln!(
        text,
        "{}: FMI 3.0, co-simulation, {}",
        target.display(),
        readable(size)
    );
    text
}

/// What the scene itself is to blame for is told with the scene's name, not with that of its copy.
fn told(error: dcb_cosimulation::Error, path: &Path) -> Error {
    match error {
        dcb_cosimulation::Error::Runtime(Error::File(dcb_formats::Error::Location {
            location,
            message,
            ..
        })) => Error::described(location, message).in_file(path),
        dcb_cosimulation::Error::Runtime(error) => error,
        other => Error::described("fmu", other.to_string()).in_file(path),
    }
}

/// Name of the archive without its ending.
fn name(target: &Path) -> String {
    let stem = target.file_stem().unwrap_or_default().to_string_lossy();
    stem.chars().filter(|c| !c.is_control()).collect()
}

/// A name as C has them.
fn identifier(name: &str) -> String {
    let plain = |c: char| match c {
        'a'..='z' | 'A'..='Z' | '0'..='9' | '_' => c,
        _ => '_',
    };
    let name: String = name.chars().map(plain).collect();
    match name.starts_with(|c: char| c.is_ascii_digit()) || name.is_empty() {
        true => format!("_{name}"),
        false => name,
    }
}

fn folder_of(target: &Path) -> &Path {
    match target.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent,
        _ => Path::new("."),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn libraries_have_names_as_c_has_them() {
        for (target, wanted) in [
            ("mech.fmu", "mech"),
            ("out/slider-crank 2.fmu", "slider_crank_2"),
            ("2d.fmu", "_2d"),
            ("größe.fmu", "gr__e"),
        ] {
            assert_eq!(identifier(&name(Path::new(target))), wanted);
        }
    }
}
