//! The description of a component, drafted from a mesh alone.

use std::path::Path;

use dcb_formats::component::{ComponentDraft, Units};
use dcb_formats::mesh::{Direction, DofMap};
use dcb_formats::{Error, SparseMatrix};

use crate::import::stem;
use crate::interfaces::{RequestedSet, interfaces};
use crate::operators::of_file;
use crate::request::NodeOrder;
use crate::rows::order::nodes_in_order;
use crate::source::part_mesh::PartMesh;

/// A component without stiffness and mass: nodes in an order, with the same directions each, and their sets as interfaces.
///
/// # Errors
/// What is wrong with the mesh or the sets.
pub fn described(
    mesh: &Path,
    (order, pattern): (NodeOrder, &[Direction]),
    asked: Option<&[RequestedSet]>,
    units: Units,
    name: Option<&str>,
) -> Result<ComponentDraft, Error> {
    let of_mesh = |message| of_file(mesh, message);
    let PartMesh { mut found, .. } = PartMesh::read(mesh)?;
    if order == NodeOrder::Label && found.labels.is_none() {
        return Err(of_mesh(
            "the mesh has no labels that nodes could be ordered by".into(),
        ));
    }
    let nodes = nodes_in_order(&found, order);
    found.keep(&nodes);
    let dofs = DofMap::uniform(nodes.len(), pattern).map_err(|error| of_mesh(error.to_string()))?;
    let made = interfaces((&found.sets, &found.cell_sets), asked, |set| {
        !set.is_empty() && set.len() < nodes.len()
    })
    .map_err(of_mesh)?;
    let shape = found.of_component(pattern.iter().copied());
    let nothing = SparseMatrix::try_new_from_triplets(0, 0, &[]);
    let nothing = nothing.map_err(|_| of_mesh("an empty matrix can't be made".into()))?;
    let name = name.map_or_else(|| stem(mesh), str::to_owned);
    let notes = [found.notes, made.notes].concat();
    Ok(ComponentDraft {
        interfaces: made.interfaces,
        notes,
        ..ComponentDraft::new(&name, units, (shape, dofs), nothing.clone(), nothing)
    })
}
