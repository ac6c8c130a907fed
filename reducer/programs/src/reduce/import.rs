//! `reduce import`: another program's matrices and mesh as the files of a component.

use std::path::PathBuf;

use clap::Args;
use dcb_formats::component_files::{with_ending, write_component};
use dcb_formats::output::{Replace, check_output};
use dcb_import::{Imported, import};
use dcb_reducer::error::{CommandRefusal, Error, Occupied};

use crate::outcome::Outcome;
use crate::program::CommonArguments;
use crate::reduce::part::files::{ImportArguments, tell_unread_mesh};
use crate::reduce::part::{part_stem, refuse_input_as_output};

/// Files of another program.
#[derive(Debug, Args)]
#[command(
    after_help = "Formats are told by content, never by the file's ending.\n\
                  Matrices: Abaqus (MATRIX INPUT, COORDINATE, substructure), Ansys (Harwell-Boeing, Matrix Market, npz),\n\
                  CalculiX (.sti, .mas, .dof), Nastran (OP4, DMIG), NumPy (.npz), MATLAB (.mat), PETSc, Matrix Market.\n\
                  Meshes: Abaqus and CalculiX decks, Nastran bulk data, Gmsh (.msh), UNV, VTU, JSON, lists of nodes.\n\
                  A page for each FE code: docs/fe-codes."
)]
pub(crate) struct ImportCommand {
    /// Stiffness matrix; FILE#NAME picks one of several in a file.
    #[arg(value_name = "STIFFNESS")]
    stiffness: PathBuf,
    /// Mass matrix [default: the partner of the stiffness, in its file or beside it].
    #[arg(value_name = "MASS")]
    mass: Option<PathBuf>,
    /// Mesh with the nodes of the rows [default: a deck beside the stiffness].
    #[arg(long, value_name = "FILE")]
    mesh: Option<PathBuf>,
    #[command(flatten)]
    import: ImportArguments,
    /// Output: PART.mtx, with PART.mass.mtx and PART.json beside it [default: NAME.mtx here].
    #[arg(long, short, value_name = "PART.mtx")]
    output: Option<PathBuf>,
    /// Replace existing outputs.
    #[arg(long)]
    force: bool,
}

pub(crate) fn run(command: &ImportCommand, common: &CommonArguments) -> Result<Outcome, Error> {
    let mass = command.mass.as_deref();
    let request = command
        .import
        .import(&command.stiffness, mass, command.mesh.as_deref())?;
    let stem = stem_of_output(command)?;
    let replace = match command.force {
        true => Replace::Overwrite,
        false => Replace::Refuse,
    };
    let inputs = [
        Some(&request.stiffness.path),
        request.mass.as_ref().map(|mass| &mass.path),
        request.mesh.as_ref(),
    ];
    let inputs: Vec<PathBuf> = inputs.into_iter().flatten().cloned().collect();
    for ending in [".mtx", ".mass.mtx", ".json"] {
        let target = with_ending(&stem, ending);
        refuse_input_as_output(&inputs, &target, Occupied::Import)?;
        check_output(&target, replace)?;
    }
    tell_unread_mesh(&command.stiffness, command.mesh.as_deref(), common.told());
    let Imported { component, report } = import(&request)?;
    let written = write_component(&component, &stem, replace)?;
    for note in &report.notes {
        common.told().say("note", note);
    }
    for warning in &component.notes {
        common.told().say("warning", warning);
    }
    let mut text = report.text();
    for path in written {
        text += &format!("wrote {}\n", path.display());
    }
    Ok(Outcome::done(text))
}

/// `PATH/part` of the output.
fn stem_of_output(command: &ImportCommand) -> Result<PathBuf, Error> {
    let Some(output) = &command.output else {
        let stem = part_stem(&command.stiffness);
        let name = command.import.name.clone();
        let own = stem
            .file_name()
            .map(|name| name.to_string_lossy().into_owned());
        return Ok(PathBuf::from(name.or(own).unwrap_or_else(|| "part".into())));
    };
    let is_mtx = output.extension().is_some_and(|ending| ending == "mtx");
    match is_mtx {
        true => Ok(output.with_extension("")),
        false => Err(CommandRefusal::NoMatrixMarketName {
            path: output.clone(),
        }
        .into()),
    }
}
