//! `reduce init`: the description of a component, drafted from a mesh and its node sets.

use std::path::{Path, PathBuf};

use clap::Args;
use dcb_formats::component::Units;
use dcb_formats::component_files::write_description;
use dcb_formats::mesh::Direction;
use dcb_formats::output::Replace;
use dcb_import::{MatrixFile, NodeOrder, RequestedSet, RowSource, described, units};
use dcb_reducer::error::{CommandRefusal, Error, Occupied};

use crate::outcome::Outcome;
use crate::program::CommonArguments;
use crate::reduce::part::{part_stem, refuse_input_as_output};

/// A mesh.
#[derive(Debug, Args)]
pub(crate) struct InitArguments {
    /// Mesh: Abaqus or CalculiX deck, Nastran bulk data, Gmsh (.msh), UNV, VTU, JSON.
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
fn no_mesh(path: &Path, format: &str) -> Error {
    dcb_formats::Error::File {
        path: path.to_owned(),
        message: format!(
            "is a matrix ({format}), and a draft is made of a mesh: name the deck or mesh that the matrix was made of (.inp, .bdf, .msh, .vtu), or a list of its nodes, `label x y z` a line, as in: reduce init nodes.txt --units m,kg,s -o {}",
            part_stem(path).with_extension("json").display()
        ),
    }
    .into()
}

pub(crate) fn run(arguments: &InitArguments, common: &CommonArguments) -> Result<Outcome, Error> {
    let RowSource::Pattern(pattern) = &arguments.dofs else {
        return Err(CommandRefusal::TableInDraft.into());
    };
    let pattern: &[Direction] = pattern;
    if let Ok(Some(matrix)) = MatrixFile::recognised(&arguments.mesh) {
        return Err(no_mesh(&arguments.mesh, matrix.format_name()));
    }
    let order = (arguments.node_order, pattern);
    let draft = described(
        &arguments.mesh,
        order,
        arguments.interfaces.as_deref(),
        arguments.units.clone(),
        arguments.name.as_deref(),
    )?;
    let target = match &arguments.output {
        Some(output) => output.clone(),
        None => PathBuf::from(format!("{}.json", draft.name)),
    };
    let replace = match arguments.force {
        true => Replace::Overwrite,
        false => Replace::Refuse,
    };
    refuse_input_as_output(
        std::slice::from_ref(&arguments.mesh),
        &target,
        Occupied::Import,
    )?;
    write_description(&draft, &target, replace)?;
    for note in &draft.notes {
        common.told().say("note", note);
    }
    let names: Vec<&str> = pattern.iter().map(|direction| direction.name()).collect();
    let rows = draft.dofs.len();
    let interfaces: Vec<String> = draft
        .interfaces
        .iter()
        .map(|interface| format!("{} ({} nodes)", interface.name, interface.nodes.len()))
        .collect();
    Ok(Outcome::done(format!(
        "{} nodes with {} make {rows} rows: stiffness and mass need as many, in this order\ninterfaces: {}\nwrote {}\n",
        draft.mesh.node_count(),
        names.join(" "),
        if interfaces.is_empty() {
            "none".into()
        } else {
            interfaces.join(", ")
        },
        target.display()
    )))
}
