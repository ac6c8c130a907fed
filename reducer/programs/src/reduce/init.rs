//! `reduce init`: the description of a component, drafted from a mesh and its node sets, or a template for a matrix.

use std::io::Write as _;
use std::path::{Path, PathBuf};

use clap::Args;
use dcb_formats::component::Units;
use dcb_formats::component_files::write_description;
use dcb_formats::mesh::{Dimension, Direction};
use dcb_formats::output::{Replace, write_stream};
use dcb_import::{MatrixFile, NodeOrder, RequestedSet, RowSource, described, mesh_beside, units};
use dcb_reducer::error::{CommandRefusal, Error, Occupied};
use serde_json::json;

use crate::outcome::Outcome;
use crate::program::CommonArguments;
use crate::reduce::part::{part_stem, refuse_input_as_output};

/// A mesh.
#[derive(Debug, Args)]
pub(crate) struct InitArguments {
    /// Mesh: Abaqus or CalculiX deck, Nastran bulk data, Gmsh (.msh), UNV, VTU, JSON.
    ///
    /// Or a stiffness matrix without a mesh beside it: then a template to fill in is written.
    #[arg(value_name = "MESH")]
    mesh: PathBuf,
    /// Units of length, mass and time, for example m,kg,s or mm,t,s.
    #[arg(long, value_name = "UNITS", value_parser = units)]
    units: Units,
    /// Directions of every node, in the order of the matrices' rows.
    #[arg(long, value_name = "DOFS", default_value = "ux,uy,uz")]
    dofs: RowSource,
    /// Order of the nodes: file (as in the mesh) or label (rising).
    #[arg(long, value_name = "ORDER", default_value = "file", value_parser = super::part::files::node_order)]
    node_order: NodeOrder,
    /// Node sets that become interfaces, SET[:KIND],... [default: all sets, average].
    #[arg(long, value_name = "SETS", value_delimiter = ',')]
    interfaces: Option<Vec<RequestedSet>>,
    /// Name of the component [default: that of the mesh file].
    #[arg(long, value_name = "NAME")]
    name: Option<String>,
    /// Output [default: NAME.json here].
    #[arg(long, short, value_name = "PART.json")]
    output: Option<PathBuf>,
    /// Replace an existing output.
    #[arg(long)]
    force: bool,
}

/// What to name in place of a matrix, which says nothing of nodes.
fn no_mesh(path: &Path, format: &str, mesh: &Path) -> Error {
    dcb_formats::Error::File {
        path: path.to_owned(),
        message: format!(
            "is a matrix ({format}), and a draft is made of a mesh: name {}",
            mesh.display()
        ),
    }
    .into()
}

/// A description with a text in the place of what a matrix doesn't say: where its nodes are.
fn template(
    arguments: &InitArguments,
    matrix: &MatrixFile,
    pattern: &[Direction],
) -> Result<Outcome, Error> {
    let stem = part_stem(&arguments.mesh);
    let usual = || stem.file_name().unwrap_or_default().to_string_lossy();
    let name = arguments
        .name
        .clone()
        .unwrap_or_else(|| usual().into_owned());
    let (target, replace) = target(arguments, &name)?;
    let rows = match matrix.listed().first().and_then(|listed| listed.shape) {
        Some((rows, _)) => rows as usize,
        None => (matrix.read(&[0])?.matrices.first()).map_or(0, |matrix| matrix.size),
    };
    let (each, directions) = (pattern.len(), names(pattern));
    if rows == 0 || rows % each != 0 {
        return Err(dcb_formats::Error::File {
            path: arguments.mesh.clone(),
            message: format!(
                "has {rows} rows, no multiple of the {each} directions {}; name those of every node with --dofs",
                directions.join(",")
            ),
        }
        .into());
    }
    let nodes = rows / each;
    let in_plane = Dimension::Planar.frame_directions();
    let axes = match pattern.iter().all(|direction| in_plane.contains(direction)) {
        true => "[x, y]",
        false => "[x, y, z]",
    };
    let units = &arguments.units;
    let description = json!({
        "format": "meshio-json",
        "version": 1,
        "points": format!("Replace this text: {nodes} points {axes} in the order of the rows"),
        "component": {
            "name": name,
            "units": {"length": units.length, "mass": units.mass, "time": units.time},
            "dofs": directions,
            "interfaces": [
                {"name": "left", "nodes": "Replace this text: nodes counted from 0", "kind": "average"},
                {"name": "right", "nodes": "Replace this text: nodes counted from 0", "kind": "average"}
            ]
        }
    });
    let text = serde_json::to_string_pretty(&description).unwrap_or_default() + "\n";
    write_stream(&target, replace, |out| out.write_all(text.as_bytes()))?;
    Ok(Outcome::done(format!(
        "{}: {rows} rows: {nodes} nodes with {}\nwrote {}, a template: replace its three texts, then: reduce {}\nA list of the nodes, `label x y z` a line, makes the file with the points in it: reduce init nodes.txt --units {},{},{} --name {name} --force\n",
        arguments.mesh.display(),
        directions.join(" "),
        target.display(),
        arguments.mesh.display(),
        units.length,
        units.mass,
        units.time
    )))
}

/// Where the description of a part of this name goes.
fn target(arguments: &InitArguments, name: &str) -> Result<(PathBuf, Replace), Error> {
    let usual = || PathBuf::from(format!("{name}.json"));
    let target = arguments.output.clone().unwrap_or_else(usual);
    refuse_input_as_output(
        std::slice::from_ref(&arguments.mesh),
        &target,
        Occupied::Import,
    )?;
    let replace = match arguments.force {
        true => Replace::Overwrite,
        false => Replace::Refuse,
    };
    Ok((target, replace))
}

fn names(pattern: &[Direction]) -> Vec<&'static str> {
    pattern.iter().map(|direction| direction.name()).collect()
}

pub(crate) fn run(arguments: &InitArguments, common: &CommonArguments) -> Result<Outcome, Error> {
    let RowSource::Pattern(pattern) = &arguments.dofs else {
        return Err(CommandRefusal::TableInDraft.into());
    };
    let pattern: &[Direction] = pattern;
    if let Ok(Some(matrix)) = MatrixFile::recognised(&arguments.mesh) {
        return match mesh_beside(&arguments.mesh) {
            Some(mesh) => Err(no_mesh(&arguments.mesh, matrix.format_name(), &mesh.path)),
            None => template(arguments, &matrix, pattern),
        };
    }
    let order = (arguments.node_order, pattern);
    let draft = described(
        &arguments.mesh,
        order,
        arguments.interfaces.as_deref(),
        arguments.units.clone(),
        arguments.name.as_deref(),
    )?;
    let (target, replace) = target(arguments, &draft.name)?;
    write_description(&draft, &target, replace)?;
    for note in &draft.notes {
        common.told().say("note", note);
    }
    let rows = draft.dofs.len();
    let interfaces: Vec<String> = draft
        .interfaces
        .iter()
        .map(|interface| format!("{} ({} nodes)", interface.name, interface.nodes.len()))
        .collect();
    Ok(Outcome::done(format!(
        "{} nodes with {} make {rows} rows: stiffness and mass need as many, in this order\ninterfaces: {}\nwrote {}\n",
        draft.mesh.node_count(),
        names(pattern).join(" "),
        if interfaces.is_empty() {
            "none".into()
        } else {
            interfaces.join(", ")
        },
        target.display()
    )))
}
