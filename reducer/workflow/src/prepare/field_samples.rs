//! Displacement fields among what a preparation compares: some nodes of each stand for all.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use crate::scene_study::Subject;
use dcb_formats::scene::{FieldRequest, MeshNode, Output, Scene};
use dcb_runtime::error::Error;
use dcb_runtime::model::Model;

/// Nodes that stand for a field, spread over the mesh.
const NODES: usize = 16;

/// The fields that a scene asks for, and the outputs that stand for them while it is prepared.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FieldSamples {
    requests: Vec<FieldRequest>,
    /// Outputs of each body that has a field.
    outputs: BTreeMap<String, Vec<String>>,
}

impl FieldSamples {
    /// Adds outputs to a scene, displacements of nodes, for the fields that it asks for.
    ///
    /// # Errors
    /// Those of [`Model::load`], for example for a superelement without nodal fields.
    pub fn add_to(scene: &mut Scene) -> Result<Self, Error> {
        let mut samples = Self {
            requests: scene.fields.clone(),
            outputs: BTreeMap::new(),
        };
        if scene.fields.is_empty() {
            return Ok(samples);
        }
        for plan in &Model::load(scene)?.fields {
            let body = plan.body_name();
            if samples.outputs.contains_key(body) {
                continue;
            }
            let nodes = plan.nodes();
            let count = nodes.len().min(NODES);
            let mut names = Vec::new();
            for place in 0..count {
                let node = nodes[place * (nodes.len() - 1) / (count - 1).max(1)];
                let name = format!("{}, node {node}", field_name(body));
                if scene.outputs.contains_key(&name) {
                    return Err(Error::described(
                        format!("outputs.{name}"),
                        "has the name of a node that stands for a field; call it otherwise",
                    ));
                }
                let of = MeshNode {
                    body: body.to_owned(),
                    node,
                };
                scene
                    .outputs
                    .insert(name.clone(), Output::NodeDisplacement(of));
                names.push(name);
            }
            samples.outputs.insert(body.to_owned(), names);
        }
        Ok(samples)
    }

    /// Compares the nodes of a field as one quantity, relative to the field's range.
    pub fn join(&self, subject: &mut Subject) {
        for (body, outputs) in &self.outputs {
            subject.join(&field_name(body), outputs);
        }
    }

    /// Which fields were among what was compared.
    pub fn told(&self, subject: &Subject) -> String {
        let lines = self.outputs.iter().map(|(body, outputs)| {
            let name = field_name(body);
            match subject
                .quantities
                .iter()
                .any(|quantity| quantity.name == name)
            {
                true => format!("{name}: compared at {} nodes\n", outputs.len()),
                false => format!("{name}: not compared, because --outputs names what counts\n"),
            }
        });
        lines.collect()
    }

    /// Puts the fields back in place of the outputs. Their folders are relative: those that are absolute get their last part.
    pub fn restore(&self, scene: &mut Scene) {
        for name in self.outputs.values().flatten() {
            scene.outputs.shift_remove(name);
        }
        let mut moved: Vec<(&Path, PathBuf)> = Vec::new();
        scene.fields.clone_from(&self.requests);
        for (field, request) in scene.fields.iter_mut().zip(&self.requests) {
            if request.directory.is_relative() {
                continue;
            }
            let known = moved.iter().find(|(from, _)| *from == request.directory);
            field.directory = match known {
                Some((_, to)) => to.clone(),
                None => {
                    let taken = |to: &Path| {
                        moved.iter().any(|(_, other)| other == to)
                            || self.requests.iter().any(|other| other.directory == to)
                    };
                    let to = relative(&request.directory, taken);
                    moved.push((&request.directory, to.clone()));
                    to
                }
            };
        }
    }
}

fn field_name(body: &str) -> String {
    format!("field of {body}")
}

/// The last part of a folder's path, with a number if another one has it.
fn relative(directory: &Path, taken: impl Fn(&Path) -> bool) -> PathBuf {
    let name = directory.file_name().map(|name| name.to_string_lossy());
    let name = name.as_deref().unwrap_or("fields");
    let numbered = (2..).map(|number| PathBuf::from(format!("{name}-{number}")));
    std::iter::once(PathBuf::from(name))
        .chain(numbered)
        .find(|to| !taken(to))
        .unwrap_or_default()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use dcb_formats::mesh::Dimension;

    use super::*;

    #[test]
    fn absolute_folders_become_relative_and_stay_different() {
        let root = if cfg!(windows) { "C:/" } else { "/" };
        let requests: Vec<FieldRequest> = [
            format!("{root}one/fields"),
            format!("{root}two/fields"),
            format!("{root}one/fields"),
            "fields-2".to_owned(),
            "../seen".to_owned(),
            root.to_owned(),
        ]
        .iter()
        .map(|directory| FieldRequest {
            directory: directory.into(),
            ..FieldRequest::default()
        })
        .collect();
        let samples = FieldSamples {
            requests,
            outputs: BTreeMap::new(),
        };
        let mut scene = Scene::new(Dimension::Planar);
        samples.restore(&mut scene);
        let found: Vec<&str> = (scene.fields.iter())
            .map(|field| field.directory.to_str().unwrap())
            .collect();
        assert_eq!(
            found,
            [
                "fields", "fields-3", "fields", "fields-2", "../seen", "fields-4"
            ]
        );
    }
}
