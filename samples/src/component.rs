//! Members that every generated component has in common.

use dcb_formats::component::{
    ComponentDraft, ComponentFault, Interface, InterfaceKind, Role, Units, Weights,
};
use dcb_formats::mesh::{Direction, Dof, DofMap, Mesh};
use dcb_formats::{Component, SparseMatrix};

/// Directions of a solid's node.
pub(crate) const TRANSLATIONS: [Direction; 3] = [Direction::Ux, Direction::Uy, Direction::Uz];

/// A component in SI units without component masses, damping or explicit boundary rows.
pub(crate) fn draft(
    name: &str,
    mesh: Mesh,
    dofs: DofMap,
    stiffness: SparseMatrix,
    mass: SparseMatrix,
    interfaces: Vec<Interface>,
) -> ComponentDraft {
    ComponentDraft {
        interfaces,
        ..ComponentDraft::new(name, si(), (mesh, dofs), stiffness, mass)
    }
}

/// The component that a draft of this crate is.
pub(crate) fn checked(draft: ComponentDraft) -> Component {
    consistent(Component::checked(draft))
}

fn consistent(checked: Result<Component, ComponentFault>) -> Component {
    match checked {
        Ok(component) => component,
        Err(fault) => unreachable!("a generated component is consistent: {fault}"),
    }
}

/// A component of this crate with a change.
pub(crate) fn changed(component: Component, change: impl FnOnce(&mut ComponentDraft)) -> Component {
    consistent(component.changed(change))
}

/// Metre, kilogram, second.
pub(crate) fn si() -> Units {
    Units {
        length: "m".into(),
        mass: "kg".into(),
        time: "s".into(),
    }
}

/// The same directions at every node.
pub(crate) fn uniform_dofs(node_count: usize, pattern: &[Direction]) -> DofMap {
    match DofMap::uniform(node_count, pattern) {
        Ok(map) => map,
        Err(error) => unreachable!("a fixed pattern names no direction twice: {error}"),
    }
}

/// A dof table made by leaving out or adding dofs of existing nodes.
pub(crate) fn dof_table(dofs: Vec<Dof>, node_count: usize) -> DofMap {
    match DofMap::new(dofs, node_count) {
        Ok(map) => map,
        Err(error) => unreachable!("the table is built from the nodes themselves: {error}"),
    }
}

/// The raw dofs of some nodes.
pub(crate) fn nodes_interface(name: &str, nodes: Vec<u32>, directions: &[Direction]) -> Interface {
    Interface {
        directions: Some(directions.to_vec()),
        ..interface(name, InterfaceKind::Nodes, nodes, None)
    }
}

/// A frame at `position` that follows the mean motion of the nodes.
pub(crate) fn average_interface(name: &str, nodes: Vec<u32>, position: [f64; 3]) -> Interface {
    interface(name, InterfaceKind::Average, nodes, Some(position))
}

fn interface(
    name: &str,
    kind: InterfaceKind,
    nodes: Vec<u32>,
    position: Option<[f64; 3]>,
) -> Interface {
    Interface {
        name: name.to_owned(),
        kind,
        nodes,
        position,
        weights: Weights::Uniform,
        axes: None,
        directions: None,
        role: Role::Attachment,
    }
}

/// Nodes whose coordinate along `axis` is `value`, to within 1e-9 of the largest coordinate.
pub(crate) fn nodes_on_plane(mesh: &Mesh, axis: usize, value: f64) -> Vec<u32> {
    let largest = mesh
        .coordinates
        .iter()
        .fold(0.0_f64, |most, x| most.max(x.abs()));
    (0..mesh.node_count() as u32)
        .filter(|&node| (mesh.position(node)[axis] - value).abs() <= 1e-9 * largest)
        .collect()
}
