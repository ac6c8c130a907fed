//! Checks of the interface requests against the mesh and the dofs.

use std::collections::{HashMap, HashSet};

use super::axes::checked_axes;
use super::diagnosis::{listed, suggestion};
use super::file::{InterfacePart, KindPart, RolePart};
use super::geometry::{check_ids, check_repeats};
use super::lists::NodeList;
use super::values::{DirectionName, Number, WeightsValue};
use super::{DofLayout, Fault, check_label, fault};
use crate::component::{Interface, InterfaceKind, Role, Weights};
use crate::mesh::{Dimension, Direction, Mesh};
use crate::named::Object;

pub fn interfaces(
    parts: Vec<Object<InterfacePart>>,
    mesh: &Mesh,
    dofs: &DofLayout,
    cell_sets: &[String],
    notes: &mut Vec<String>,
) -> Result<Vec<Interface>, Fault> {
    if parts.is_empty() {
        notes.push("the component has no interface: no joint or force can act on it".into());
    }
    let request = Request {
        mesh,
        dofs,
        cell_sets,
    };
    let mut interfaces = Vec::new();
    let mut names = HashMap::new();
    for (index, Object(part)) in parts.into_iter().enumerate() {
        let at = format!("component.interfaces[{index}]");
        check_name(&at, &part.name)?;
        if let Some(first) = names.insert(part.name.clone(), index) {
            return Err(fault(
                format!("{at}.name"),
                format!(
                    "\"{}\" is the name of interfaces[{first}] already; names must differ",
                    part.name
                ),
            ));
        }
        interfaces.push(request.interface(&at, part, notes)?);
    }
    check_rigid_overlap(&interfaces)?;
    Ok(interfaces)
}

fn check_name(at: &str, name: &str) -> Result<(), Fault> {
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

/// A node that two rigid frames hold would weld them together.
fn check_rigid_overlap(interfaces: &[Interface]) -> Result<(), Fault> {
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

/// Context that an interface request is checked against.
struct Request<'a> {
    mesh: &'a Mesh,
    dofs: &'a DofLayout,
    cell_sets: &'a [String],
}

impl Request<'_> {
    fn interface(
        &self,
        at: &str,
        part: InterfacePart,
        notes: &mut Vec<String>,
    ) -> Result<Interface, Fault> {
        let kind = match part.kind {
            KindPart::Nodes => InterfaceKind::Nodes,
            KindPart::Average => InterfaceKind::Average,
            KindPart::Rigid => InterfaceKind::Rigid,
        };
        let nodes = self.nodes(at, part.point_set, part.nodes, notes)?;
        let position = match part.position {
            Some(_) if kind == InterfaceKind::Nodes => {
                return Err(fault(
                    format!("{at}.position"),
                    "is for the kinds `average` and `rigid`; an interface of kind `nodes` is where its nodes are",
                ));
            }
            Some(position) => Some(self.position(&format!("{at}.position"), &position)?),
            None => None,
        };
        let weights = match part.weights {
            Some(_) if kind != InterfaceKind::Average => {
                return Err(fault(
                    format!("{at}.weights"),
                    format!(
                        "is for the kind `average`, but this one is `{}`",
                        kind.name()
                    ),
                ));
            }
            Some(WeightsValue(weights)) => {
                checked_weights(&format!("{at}.weights"), weights, nodes.len())?
            }
            None => Weights::Uniform,
        };
        let axes = match part.axes {
            Some(rows) => Some(checked_axes(
                &format!("{at}.axes"),
                &rows,
                self.mesh.dimension,
            )?),
            None => None,
        };
        let directions = match part.dofs {
            Some(names) => Some(self.directions(&format!("{at}.dofs"), kind, &names)?),
            None => None,
        };
        let role = match part.role.unwrap_or_default() {
            RolePart::Attachment => Role::Attachment,
            RolePart::Output => Role::Output,
        };
        Ok(Interface {
            name: part.name,
            kind,
            nodes,
            position,
            weights,
            axes,
            directions,
            role,
        })
    }

    fn nodes(
        &self,
        at: &str,
        point_set: Option<String>,
        nodes: Option<NodeList>,
        notes: &mut Vec<String>,
    ) -> Result<Vec<u32>, Fault> {
        match (point_set, nodes) {
            (Some(name), None) => self.nodes_of_set(at, &name, notes),
            (None, Some(NodeList(nodes))) => {
                let location = format!("{at}.nodes");
                if nodes.is_empty() {
                    return Err(fault(location, "is empty; expected at least one node id"));
                }
                check_ids(&location, &nodes, self.mesh.node_count())?;
                let mut seen = HashSet::new();
                if let Some(repeat) = nodes.iter().position(|node| !seen.insert(*node)) {
                    return Err(fault(
                        format!("{location}[{repeat}]"),
                        format!("is node {} again", nodes[repeat]),
                    ));
                }
                Ok(nodes)
            }
            (None, None) => Err(fault(
                at,
                "names no node; give it `point_set` (the name of a set) or `nodes` (ids)",
            )),
            (Some(_), Some(_)) => Err(fault(
                at,
                "has both `point_set` and `nodes`; expected one of them",
            )),
        }
    }

    /// The nodes of a set, each once, in the order of the set.
    fn nodes_of_set(
        &self,
        at: &str,
        name: &str,
        notes: &mut Vec<String>,
    ) -> Result<Vec<u32>, Fault> {
        let location = format!("{at}.point_set");
        let sets = &self.mesh.point_sets;
        let Some(ids) = sets.get(name) else {
            return Err(fault(location, self.unknown_set(name)));
        };
        if ids.is_empty() {
            return Err(fault(
                location,
                format!("the set \"{name}\" is empty; an interface needs at least one node"),
            ));
        }
        let mut seen = HashSet::new();
        let nodes: Vec<u32> = ids
            .iter()
            .copied()
            .filter(|&node| seen.insert(node))
            .collect();
        if nodes.len() < ids.len() {
            let repeats = ids.len() - nodes.len();
            notes.push(format!(
                "{location}: the set \"{name}\" lists {repeats} nodes again; each counts once"
            ));
        }
        Ok(nodes)
    }

    fn unknown_set(&self, name: &str) -> String {
        let sets = &self.mesh.point_sets;
        let names = || sets.keys().map(String::as_str);
        let known = if sets.is_empty() {
            "the file has no point sets".to_owned()
        } else {
            format!("the file has: {}", listed(names()))
        };
        if self.cell_sets.iter().any(|cells| cells == name) {
            return format!(
                "\"{name}\" is a cell set; an interface needs nodes, so write the nodes of its cells as a point set ({known})"
            );
        }
        format!(
            "no point set is named \"{name}\"{} ({known})",
            suggestion(name, names())
        )
    }

    fn position(&self, location: &str, numbers: &[Number]) -> Result<[f64; 3], Fault> {
        match (self.mesh.dimension, numbers) {
            (Dimension::Planar, &[Number(x), Number(y)] | &[Number(x), Number(y), Number(0.0)]) => {
                Ok([x, y, 0.0])
            }
            (Dimension::Spatial, &[Number(x), Number(y), Number(z)]) => Ok([x, y, z]),
            (Dimension::Planar, &[_, _, Number(z)]) => Err(fault(
                location,
                format!("has z = {z}, but the component is planar; expected [x, y]"),
            )),
            (dimension, _) => {
                let (found, expected) = (numbers.len(), dimension.coordinate_count());
                Err(fault(
                    location,
                    format!("has {found} numbers, expected {expected}"),
                ))
            }
        }
    }

    fn directions(
        &self,
        location: &str,
        kind: InterfaceKind,
        names: &[DirectionName],
    ) -> Result<Vec<Direction>, Fault> {
        let mut directions: Vec<Direction> = names.iter().map(|name| name.0).collect();
        if directions.is_empty() {
            return Err(fault(
                location,
                "is empty; leave it out for all dofs, or name at least one",
            ));
        }
        check_repeats(location, &directions)?;
        let (owner, available) = match (kind, self.dofs) {
            (InterfaceKind::Nodes, DofLayout::Pattern(pattern)) => {
                ("the nodes have", pattern.as_slice())
            }
            _ => ("the frame has", self.mesh.dimension.frame_directions()),
        };
        if let Some(at) = directions
            .iter()
            .position(|direction| !available.contains(direction))
        {
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
        if kind != InterfaceKind::Nodes {
            directions.sort_unstable();
        }
        Ok(directions)
    }
}

fn checked_weights(location: &str, weights: Weights, node_count: usize) -> Result<Weights, Fault> {
    if let Weights::Given(weights) = &weights {
        if weights.len() != node_count {
            let found = weights.len();
            return Err(fault(
                location,
                format!(
                    "has {found} numbers, but the interface has {node_count} nodes; expected one per node"
                ),
            ));
        }
        if let Some(at) = weights.iter().position(|&weight| weight <= 0.0) {
            return Err(fault(
                format!("{location}[{at}]"),
                format!("is {}, expected a number > 0", weights[at]),
            ));
        }
    }
    Ok(weights)
}
