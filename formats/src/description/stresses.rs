//! The rows of stress matrices as a component file describes them.

use super::diagnosis::{listed, suggestion};
use super::file::StressPart;
use super::lists::NodeList;
use crate::component::{ComponentFault, StressComponent, StressPoint, StressQuantity, fault};
use crate::mesh::Mesh;
use crate::named::{Named, Object};

/// What the rows of `part.stress.NAME.mtx` are.
#[derive(Clone, Debug, PartialEq)]
pub struct StressRows {
    /// NAME.
    pub name: String,
    /// Stress or strain.
    pub quantity: StressQuantity,
    /// Components at every place, in the order of the rows.
    pub components: Vec<StressComponent>,
    /// Places, component coordinates.
    pub points: Vec<StressPoint>,
}

pub fn stresses(
    parts: Named<Object<StressPart>>,
    mesh: &Mesh,
) -> Result<Vec<StressRows>, ComponentFault> {
    (parts.into_iter())
        .map(|(name, Object(part))| {
            let at = format!("component.stresses.{name}");
            Ok(StressRows {
                quantity: part.quantity,
                points: points(&at, &part, mesh)?,
                components: part
                    .components
                    .unwrap_or_else(|| StressComponent::usual(mesh.dimension).to_vec()),
                name,
            })
        })
        .collect()
}

fn points(at: &str, part: &StressPart, mesh: &Mesh) -> Result<Vec<StressPoint>, ComponentFault> {
    let d = mesh.dimension.coordinate_count();
    let position = |coordinates: &[f64]| {
        let mut position = [0.0; 3];
        for (to, from) in position.iter_mut().zip(coordinates) {
            *to = *from;
        }
        position
    };
    let at_nodes = |location: String, nodes: &[u32]| {
        (nodes.iter())
            .map(|node| {
                let first = *node as usize * d;
                let coordinates = mesh.coordinates.get(first..first + d).ok_or_else(|| {
                    fault(
                        location.clone(),
                        format!(
                            "names node {node}, but the mesh has {} nodes, counted from 0",
                            mesh.node_count()
                        ),
                    )
                })?;
                Ok(StressPoint {
                    position: position(coordinates),
                    node: Some(*node),
                })
            })
            .collect()
    };
    match (&part.point_set, &part.nodes, &part.positions) {
        (Some(name), None, None) => match mesh.point_sets.get(name) {
            Some(nodes) => at_nodes(format!("{at}.point_set"), nodes),
            None => {
                let names = || mesh.point_sets.keys().map(String::as_str);
                Err(fault(
                    format!("{at}.point_set"),
                    format!(
                        "no point set is named {name:?}{} (the file has: {})",
                        suggestion(name, names()),
                        listed(names())
                    ),
                ))
            }
        },
        (None, Some(NodeList(nodes)), None) => at_nodes(format!("{at}.nodes"), nodes),
        (None, None, Some(places)) => {
            if places.coordinate_count != d {
                return Err(fault(
                    format!("{at}.positions"),
                    format!(
                        "have {} coordinates each, but the component has {d}",
                        places.coordinate_count
                    ),
                ));
            }
            Ok((places.coordinates.chunks_exact(d))
                .map(|coordinates| StressPoint {
                    position: position(coordinates),
                    node: None,
                })
                .collect())
        }
        (None, None, None) => Err(fault(
            at,
            "names no place; give one of `point_set`, `nodes` and `positions`",
        )),
        _ => Err(fault(
            at,
            "says twice where it is; expected one of `point_set`, `nodes` and `positions`",
        )),
    }
}
