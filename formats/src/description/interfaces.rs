//! The interface requests of a component file, with their nodes looked up.

use std::collections::HashSet;

use super::DofLayout;
use super::diagnosis::{listed, suggestion};
use super::file::InterfacePart;
use super::lists::NodeList;
use super::values::{Number, WeightsValue};
use crate::component::{
    ComponentFault, Interface, Weights, check_interfaces, check_weights_kind, fault,
};
use crate::mesh::{Dimension, Mesh};
use crate::named::Object;

pub fn interfaces(
    parts: Vec<Object<InterfacePart>>,
    mesh: &Mesh,
    dofs: &DofLayout,
    cell_sets: &[String],
    notes: &mut Vec<String>,
) -> Result<Vec<Interface>, ComponentFault> {
    if parts.is_empty() {
        notes.push("the component has no interface: no joint or force can act on it".into());
    }
    let request = Request { mesh, cell_sets };
    let asked = parts.into_iter().enumerate();
    let interfaces = asked
        .map(|(index, Object(part))| {
            request.interface(&format!("component.interfaces[{index}]"), part, notes)
        })
        .collect::<Result<_, _>>()?;
    let pattern = match dofs {
        DofLayout::Pattern(pattern) => Some(pattern.as_slice()),
        DofLayout::Table(_) => None,
    };
    check_interfaces(interfaces, mesh, pattern)
}

/// Context that an interface request is checked against.
struct Request<'a> {
    mesh: &'a Mesh,
    cell_sets: &'a [String],
}

impl Request<'_> {
    fn interface(
        &self,
        at: &str,
        part: InterfacePart,
        notes: &mut Vec<String>,
    ) -> Result<Interface, ComponentFault> {
        let kind = part.kind;
        let nodes = self.nodes(at, part.point_set, part.nodes, notes)?;
        let at_position = format!("{at}.position");
        let position = (part.position.as_deref())
            .map(|numbers| self.position(&at_position, numbers))
            .transpose()?;
        let weights = match part.weights {
            Some(WeightsValue(weights)) => {
                check_weights_kind(&format!("{at}.weights"), kind)?;
                weights
            }
            None => Weights::Uniform,
        };
        let axes = (part.axes.as_deref())
            .map(|rows| given_axes(&format!("{at}.axes"), rows, self.mesh.dimension))
            .transpose()?;
        let directions = part
            .dofs
            .map(|names| names.iter().map(|name| name.0).collect());
        let role = part.role.unwrap_or_default();
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
    ) -> Result<Vec<u32>, ComponentFault> {
        match (point_set, nodes) {
            (Some(name), None) => self.nodes_of_set(at, &name, notes),
            (None, Some(NodeList(nodes))) => Ok(nodes),
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
    ) -> Result<Vec<u32>, ComponentFault> {
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

    fn position(&self, location: &str, numbers: &[Number]) -> Result<[f64; 3], ComponentFault> {
        match (self.mesh.dimension, numbers) {
            (Dimension::Planar, &[Number(x), Number(y)]) => Ok([x, y, 0.0]),
            (_, &[Number(x), Number(y), Number(z)]) => Ok([x, y, z]),
            (dimension, _) => {
                let (found, expected) = (numbers.len(), dimension.coordinate_count());
                Err(fault(
                    location,
                    format!("has {found} numbers, expected {expected}"),
                ))
            }
        }
    }
}

/// Three rows; a planar frame may be given by its two rows in the plane.
fn given_axes(
    location: &str,
    rows: &[Vec<Number>],
    dimension: Dimension,
) -> Result<[[f64; 3]; 3], ComponentFault> {
    let size = rows.len();
    let sizes: &[usize] = match dimension {
        Dimension::Planar => &[2, 3],
        Dimension::Spatial => &[3],
    };
    if !sizes.contains(&size) || rows.iter().any(|row| row.len() != size) {
        let lengths: Vec<String> = rows.iter().map(|row| row.len().to_string()).collect();
        let expected = if size == 2 && sizes.contains(&2) {
            "2 rows of 2"
        } else {
            "3 rows of 3"
        };
        return Err(fault(
            location,
            format!(
                "has {size} rows with {} numbers, expected {expected}",
                lengths.join(", ")
            ),
        ));
    }
    let mut axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    for (axis, row) in axes.iter_mut().zip(rows) {
        for (entry, Number(given)) in axis.iter_mut().zip(row) {
            *entry = *given;
        }
    }
    Ok(axes)
}
