//! Which row is which motion: labels of the matrices, of a table, or the order of the mesh.

use dcb_formats::component::Source;
use dcb_formats::description::DofLayout;
use dcb_formats::mesh::{Direction, Dof, MatrixRow};
use dcb_formats::{Description, Error};

use crate::dof_table::{self, DofTable};
use crate::mesh::FoundMesh;
use crate::operators::of_file;
use crate::request::{Import, NodeOrder, RowSource};
use crate::rows::order::{CommonRows, positional};
use crate::source::matrices::{Sourced, file_name, source};
use crate::source::named_file::NamedFile;
use crate::source::partner::dof_file;
use crate::stored::{RowLabel, Rows};

/// Directions of a node where nothing says other ones.
const USUAL: [Direction; 3] = [Direction::Ux, Direction::Uy, Direction::Uz];

/// Labels of all rows, if anything says them, and what it is.
pub(crate) fn row_labels(
    request: &Import,
    stiffness: &Sourced,
    mass: &Sourced,
    mesh: Option<&FoundMesh>,
    (sources, notes): (&mut Vec<Source>, &mut Vec<String>),
) -> Result<Option<(CommonRows, String)>, Error> {
    let size = stiffness.matrix.size;
    let table = match &request.dofs {
        Some(RowSource::Table(table)) => Some(table.clone()),
        Some(RowSource::Pattern(_)) => None,
        None => dof_file(&stiffness.path)
            .filter(|_| stiffness.matrix.rows == Rows::Unlabelled)
            .map(|path| NamedFile::only(&path)),
    };
    if let Some(table) = table {
        same_size(stiffness, mass)?;
        let DofTable {
            rows,
            sha256,
            notes: of_table,
        } = dof_table::read(&table.path, table.name.as_deref(), size)?;
        notes.extend(of_table);
        sources.push(source("dofs", &table.path, &sha256));
        let order = format!("labels of {}", file_name(&table.path));
        return Ok(Some((CommonRows::of(&rows, &rows), order)));
    }
    let labels = |of: &Sourced| match &of.matrix.rows {
        Rows::Labelled(labels) => Some(labels.clone()),
        Rows::Unlabelled => None,
    };
    let found = match (labels(stiffness), labels(mass)) {
        (Some(stiffness), Some(mass)) => Some((stiffness, mass)),
        (Some(labels), None) | (None, Some(labels)) => {
            same_size(stiffness, mass)?;
            Some((labels.clone(), labels))
        }
        (None, None) => None,
    };
    if let Some((of_stiffness, of_mass)) = found {
        let order = "labels of the matrices' rows".to_owned();
        return Ok(Some((CommonRows::of(&of_stiffness, &of_mass), order)));
    }
    match mesh.and_then(|mesh| mesh.rows.as_ref()) {
        Some(rows) if rows.len() == same_size(stiffness, mass)? && request.dofs.is_none() => {
            let rows: &[RowLabel] = rows;
            let order = "rows as the mesh file lists them".to_owned();
            Ok(Some((CommonRows::of(rows, rows), order)))
        }
        _ => Ok(None),
    }
}

pub(crate) fn same_size(stiffness: &Sourced, mass: &Sourced) -> Result<usize, Error> {
    let (of_stiffness, of_mass) = (stiffness.matrix.size, mass.matrix.size);
    match of_stiffness == of_mass {
        true => Ok(of_stiffness),
        false => Err(of_file(
            &mass.path,
            format!(
                "the mass has {of_mass} rows, but the stiffness in {} has {of_stiffness}; expected matrices of one model",
                file_name(&stiffness.path)
            ),
        )),
    }
}

pub(crate) fn pattern(request: &Import, description: Option<&Description>) -> Vec<Direction> {
    match (&request.dofs, description.map(|described| &described.dofs)) {
        (Some(RowSource::Pattern(pattern)), _) => pattern.clone(),
        (_, Some(DofLayout::Pattern(pattern))) => pattern.clone(),
        _ => USUAL.to_vec(),
    }
}

/// Owners of rows without labels, and their order in words.
pub(crate) fn rows_in_mesh_order(
    request: &Import,
    mesh: &FoundMesh,
    pattern: &[Direction],
    size: usize,
) -> Result<(Vec<MatrixRow>, String), String> {
    let names: Vec<&str> = pattern.iter().map(|direction| direction.name()).collect();
    let names = names.join(",");
    let order = match (request.node_order, &mesh.labels) {
        (NodeOrder::File, _) => "as the mesh lists its nodes",
        (NodeOrder::Label, Some(_)) => "by rising label",
        (NodeOrder::Label, None) => {
            return Err("the mesh has no labels, so its nodes can't be put in their order; leave --node-order label out".into());
        }
    };
    let described = format!("{order}, {names} each");
    let rows = positional(mesh, request.node_order, pattern);
    if rows.len() == size {
        return Ok((rows, described));
    }
    let mut in_cells = vec![false; mesh.points.len()];
    for node in mesh.cells.iter().flat_map(|block| &block.nodes) {
        in_cells[*node as usize] = true;
    }
    let is_in_cell = |owner: &MatrixRow| matches!(owner, MatrixRow::Nodal(Dof { node, .. }) if in_cells[*node as usize]);
    let of_cells: Vec<MatrixRow> = rows.iter().copied().filter(is_in_cell).collect();
    if of_cells.len() == size {
        return Ok((of_cells, format!("{described}, only nodes of cells")));
    }
    let node_count = mesh.points.len();
    let remedy = match size / node_count {
        fits @ (2 | 3 | 6) if size.is_multiple_of(node_count) => {
            let other = Direction::NAMES[..fits].join(",");
            format!("{size} = {node_count} nodes x {fits}: is --dofs {other} meant?")
        }
        _ => "rows were removed, or it is another mesh: give the label and direction of each row in a table, --dofs FILE".to_owned(),
    };
    Err(format!(
        "has {size} rows, but {node_count} nodes of the mesh x {} directions ({names}) make {}; {remedy}",
        pattern.len(),
        rows.len()
    ))
}
