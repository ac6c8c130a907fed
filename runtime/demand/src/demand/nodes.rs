//! Which nodes of a part a scene looks at.

use std::collections::BTreeMap;

use serde::Serialize;

use dcb_formats::scene::Scene;

/// Nodes whose displacement is wanted, and who wants it: paths of keys of the scene.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum NodeDemand {
    /// None: the nodal fields are not needed.
    None,
    /// These nodes of the mesh, from 0.
    Some(BTreeMap<u32, Vec<String>>),
    /// The whole field.
    All(Vec<String>),
}

impl NodeDemand {
    pub(super) fn of(scene: &Scene, body: &str) -> Self {
        let wholes = scene.fields.iter().enumerate();
        let wholes: Vec<String> = wholes
            .filter(|(_, field)| field.body == body)
            .map(|(index, _)| format!("fields[{index}]"))
            .collect();
        if !wholes.is_empty() {
            return Self::All(wholes);
        }
        let mut nodes: BTreeMap<u32, Vec<String>> = BTreeMap::new();
        for (name, output) in &scene.outputs {
            if let Some((_, node)) = output.node().filter(|(of, _)| *of == body) {
                let looking = nodes.entry(node).or_default();
                looking.push(format!("outputs.{name}"));
            }
        }
        match nodes.is_empty() {
            true => Self::None,
            false => Self::Some(nodes),
        }
    }
}
