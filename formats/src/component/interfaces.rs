//! Checks of the interface requests against the mesh and the dofs.

use std::collections::{HashMap, HashSet};

use super::axes::checked_axes;
use super::fault::{ComponentFault, fault};
use super::geometry::{check_ids, check_repeats};
use super::label::check_label;
use super::{EXPLICIT_BOUNDARY, Interface, InterfaceKind, Weights};
use crate::mesh::{Dimension, Direction, Mesh};

/// The interfaces with exactly orthonormal axes, and the directions of frames in their order. `pattern` are the directions of the nodes
/// where all have the same.
///
/// # Errors
/// The first place that is wrong, by its key in the component file.
pub(crate) fn check_interfaces(
    mut interfaces: Vec<Interface>,
    mesh: &Mesh,
    pattern: Option<&[Direction]>,
) -> Result<Vec<Interface>, ComponentFault> {
    let mut names = HashMap::new();
    for (index, interface) in interfaces.iter_mut().enumerate() {
        let at = format!("component.interfaces[{index}]");
        check_name(&at, &interface.name)?;
        if let Some(first) = names.insert(interface.name.clone(), index) {
            return Err(fault(
                format!("{at}.name"),
                format!(
                    "\"{}\" is the name of interfaces[{first}] already; names must differ",
                    interface.name
                ),
            ));
        }
        check_nodes(&format!("{at}.nodes"), &interface.nodes, mesh.node_count())?;
        check_position(&format!("{at}.position"), interface, mesh.dimension)?;
        check_weights(&format!("{at}.weights"), interface)?;
        if let Some(axes) = &mut interface.axes {
            *axes = checked_axes(&format!("{at}.axes"), *axes, mesh.dimension)?;
        }
        check_wanted(&format!("{at}.dofs"), interface, mesh.dimension, pattern)?;
    }
    check_rigid_overlap(&interfaces)?;
    Ok(interfaces)
}

/// The rows of L_b that are given as a matrix make an interface too.
pub(super) fn check_names_beside_boundary(interfaces: &[Interface]) -> Result<(), ComponentFault> {
    match (interfaces.iter()).position(|interface| interface.name == EXPLICIT_BOUNDARY) {
        None => Ok(()),
        Some(index) => Err(fault(
            format!("component.interfaces[{index}].name"),
            format!(
                "{EXPLICIT_BOUNDARY:?} is the name of the rows given as a matrix (--boundary); rename the interface"
            ),
        )),
    }
}

fn check_name(at: &str, name: &str) -> Result<(), ComponentFault> {
    let location = format!("{at}.name");
    check_label(&location, name)?;
    if name.contains('/') {
        return Err(fault(
            location,
            format!("\"{name}\" contains `/`, which separates body and interface in scenes"),
        ));
    }
    Ok(())
}

fn check_nodes(location: &str, nodes: &[u32], node_count: usize) -> Result<(), ComponentFault> {
    if nodes.is_empty() {
        return Err(fault(location, "is empty; expected at least one node id"));
    }
    check_ids(location, nodes, node_count)?;
    let mut seen = HashSet::new();
    match nodes.iter().position(|node| !seen.insert(*node)) {
        None => Ok(()),
        Some(repeat) => Err(fault(
            format!("{location}[{repeat}]"),
            format!("is node {} again", nodes[repeat]),
        )),
    }
}

fn check_position(
    location: &str,
    interface: &Interface,
    dimension: Dimension,
) -> Result<(), ComponentFault> {
    let Some(position) = interface.position else {
        return Ok(());
    };
    if interface.kind == InterfaceKind::Nodes {
        return Err(fault(
            location,
            "is for the kinds `average` and `rigid`; an interface of kind `nodes` is where its nodes are",
        ));
    }
    if let Some(x) = position.iter().find(|x| !x.is_finite()) {
        return Err(fault(location, format!("has {x}, expected finite numbers")));
    }
    if dimension == Dimension::Planar && position[2] != 0.0 {
        return Err(fault(
            location,
            format!(
                "has z = {}, but the component is planar; expected [x, y]",
                position[2]
            ),
        ));
    }
    Ok(())
}

/// Weights are for averages.
pub(crate) fn check_weights_kind(
    location: &str,
    kind: InterfaceKind,
) -> Result<(), ComponentFault> {
    if kind == InterfaceKind::Average {
        return Ok(());
    }
    Err(fault(
        location,
        format!(
            "is for the kind `average`, but this one is `{}`",
            kind.name()
        ),
    ))
}

fn check_weights(location: &str, interface: &Interface) -> Result<(), ComponentFault> {
    if interface.weights != Weights::Uniform {
        check_weights_kind(location, interface.kind)?;
    }
    let Weights::Given(weights) = &interface.weights else {
        return Ok(());
    };
    let (found, node_count) = (weights.len(), interface.nodes.len());
    if found != node_count {
        return Err(fault(
            location,
            format!(
                "has {found} numbers, but the interface has {node_count} nodes; expected one per node"
            ),
        ));
    }
    match weights
        .iter()
        .position(|&weight| !(weight > 0.0 && weight.is_finite()))
    {
        None => Ok(()),
        Some(at) => Err(fault(
            format!("{location}[{at}]"),
            format!("is {}, expected a number > 0", weights[at]),
        )),
    }
}

/// The directions wanted are there, each once; those of a frame are put into their order.
fn check_wanted(
    location: &str,
    interface: &mut Interface,
    dimension: Dimension,
    pattern: Option<&[Direction]>,
) -> Result<(), ComponentFault> {
    let Some(directions) = &mut interface.directions else {
        return Ok(());
    };
    if directions.is_empty() {
        return Err(fault(
            location,
            "is empty; leave it out for all dofs, or name at least one",
        ));
    }
    check_repeats(location, directions)?;
    let (owner, available) = match (interface.kind, pattern) {
        (InterfaceKind::Nodes, Some(pattern)) => ("the nodes have", pattern),
        _ => ("the frame has", dimension.frame_directions()),
    };
    if let Some(at) = (directions.iter()).position(|direction| !available.contains(direction)) {
        let known: Vec<&str> = available.iter().map(|direction| direction.name()).collect();
        return Err(fault(
            format!("{location}[{at}]"),
            format!(
                "is {}, but {owner} only {}",
                directions[at].name(),
                known.join(" ")
            ),
        ));
    }
    if interface.kind != InterfaceKind::Nodes {
        directions.sort_unstable();
    }
    Ok(())
}

/// A node that two rigid frames hold would weld them together.
fn check_rigid_overlap(interfaces: &[Interface]) -> Result<(), ComponentFault> {
    let mut holders: HashMap<u32, &str> = HashMap::new();
    for (index, interface) in interfaces.iter().enumerate() {
        if interface.kind != InterfaceKind::Rigid {
            continue;
        }
        for &node in &interface.nodes {
            if let Some(other) = holders.insert(node, &interface.name) {
                return Err(fault(
                    format!("component.interfaces[{index}]"),
                    format!(
                        "node {node} belongs to the rigid interface \"{other}\" as well, which would weld the two together; \
                         take it out of one of them, or make one of them `average`"
                    ),
                ));
            }
        }
    }
    Ok(())
}
