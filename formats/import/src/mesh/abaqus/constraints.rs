//! Nodes that a deck holds or makes dependent on others: they have no rows of their own in CalculiX's matrices.

use super::super::RigidBody;
use super::super::fields;
use super::super::label_sets::{Sets, key_of};
use super::super::node_sets::Marks;
use super::super::nodes::LabelIndex;
use super::keyword::Keyword;

/// A node or a set, as a line names it.
#[derive(Debug)]
pub(super) enum Target {
    Node(u32),
    Set(String),
}

impl Target {
    pub fn of(field: &[u8]) -> Result<Self, String> {
        Ok(match field.first() {
            Some(b'0'..=b'9' | b'-' | b'+') => Self::Node(fields::label(field)?),
            _ => Self::Set(key_of(&unquoted(field))),
        })
    }
}

/// A name without its quotes.
pub(super) fn unquoted(field: &[u8]) -> String {
    let name = String::from_utf8_lossy(field);
    name.trim().trim_matches(['"', '\'']).to_owned()
}

/// `*RIGID BODY` before it is known what there is.
#[derive(Debug)]
struct RigidBodyDraft {
    node_sets: Vec<String>,
    element_set: Option<String>,
    reference: Target,
    rotation: Option<Target>,
}

/// What the deck says of nodes that aren't free.
#[derive(Debug, Default)]
pub(super) struct Constraints {
    rigid_bodies: Vec<RigidBodyDraft>,
    held: Vec<Target>,
    dependent: Vec<Target>,
}

impl Constraints {
    pub fn hold(&mut self, field: &[u8]) -> Result<(), String> {
        self.held.push(Target::of(field)?);
        Ok(())
    }

    pub fn depends(&mut self, field: &[u8]) -> Result<(), String> {
        self.dependent.push(Target::of(field)?);
        Ok(())
    }

    pub fn rigid_body(&mut self, keyword: &Keyword) -> Result<(), String> {
        let Some(reference) = keyword.get("REFNODE") else {
            return Err("*RIGID BODY has no REF NODE".into());
        };
        let sets = ["NSET", "PINNSET", "TIENSET"];
        self.rigid_bodies.push(RigidBodyDraft {
            node_sets: sets
                .iter()
                .filter_map(|set| keyword.get(set))
                .map(key_of)
                .collect(),
            element_set: keyword.get("ELSET").map(key_of),
            reference: Target::of(reference.as_bytes())?,
            rotation: (keyword.get("ROTNODE"))
                .map(|node| Target::of(node.as_bytes()))
                .transpose()?,
        });
        Ok(())
    }
}

/// Sets of a deck with their members.
pub(super) struct Known<'a> {
    pub nodes: &'a LabelIndex,
    pub sets: &'a Sets,
    pub members: &'a [Vec<u32>],
    pub marks: &'a mut Marks,
}

impl Known<'_> {
    fn set(&self, key: &str) -> Result<&[u32], String> {
        match self.sets.get_index_of(key) {
            Some(at) => Ok(&self.members[at]),
            None => Err(format!("names the set {key}, which isn't there")),
        }
    }

    fn node(&self, target: &Target) -> Result<u32, String> {
        match target {
            Target::Node(label) => (self.nodes.place(*label))
                .ok_or_else(|| format!("names node {label}, which isn't there")),
            Target::Set(key) => match self.set(key)? {
                [node] => Ok(*node),
                nodes => Err(format!(
                    "needs one node, but the set {key} has {}",
                    nodes.len()
                )),
            },
        }
    }

    /// All nodes of targets, each once. Unknown nodes and sets are left out, as CalculiX does.
    fn nodes_of(&mut self, targets: &[Target]) -> Result<Vec<u32>, String> {
        let mut nodes = Vec::new();
        self.marks.start();
        for target in targets {
            match target {
                Target::Node(label) => {
                    if let Some(node) = self.nodes.place(*label) {
                        self.marks.put(&mut nodes, node).map_err(|e| e.message())?;
                    }
                }
                Target::Set(key) => {
                    let found = self.sets.get_index_of(key).map(|at| &self.members[at]);
                    for node in found.into_iter().flatten() {
                        self.marks.put(&mut nodes, *node).map_err(|e| e.message())?;
                    }
                }
            }
        }
        Ok(nodes)
    }
}

/// Nodes that aren't free.
#[derive(Debug, Default)]
pub(super) struct Bound {
    pub rigid_bodies: Vec<RigidBody>,
    pub held: Vec<u32>,
    pub dependent: Vec<u32>,
}

impl Constraints {
    /// Ties labels and sets to nodes. `nodes_of_elements` puts the nodes of a set of elements.
    ///
    /// # Errors
    /// What names something that isn't there.
    pub fn tied(
        self,
        known: &mut Known,
        mut nodes_of_elements: impl FnMut(&str, &mut Vec<u32>, &mut Marks) -> Result<(), String>,
    ) -> Result<Bound, String> {
        let mut bound = Bound {
            held: known.nodes_of(&self.held)?,
            ..Bound::default()
        };
        let mut dependent = known.nodes_of(&self.dependent)?;
        for body in self.rigid_bodies {
            let said = |message: String| format!("*RIGID BODY: {message}");
            let reference = known.node(&body.reference).map_err(said)?;
            let rotation = (body.rotation.as_ref())
                .map(|node| known.node(node))
                .transpose()
                .map_err(said)?;
            let mut nodes = Vec::new();
            known.marks.start();
            for key in &body.node_sets {
                let at = (known.sets.get_index_of(key))
                    .ok_or_else(|| said(format!("names the set {key}, which isn't there")))?;
                for node in &known.members[at] {
                    known
                        .marks
                        .put(&mut nodes, *node)
                        .map_err(|e| e.message())?;
                }
            }
            if let Some(key) = &body.element_set {
                nodes_of_elements(key, &mut nodes, known.marks).map_err(said)?;
            }
            // A reference node may be one of the set's own; it stays free.
            nodes.retain(|node| *node != reference && Some(*node) != rotation);
            dependent.extend(&nodes);
            bound.rigid_bodies.push(RigidBody {
                nodes,
                reference,
                rotation,
            });
        }
        known.marks.start();
        for node in dependent {
            (known.marks.put(&mut bound.dependent, node)).map_err(|e| e.message())?;
        }
        Ok(bound)
    }
}
