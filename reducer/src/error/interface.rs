//! Defects of a component's interfaces.

use dcb_formats::component::InterfaceKind;
use dcb_formats::mesh::{Dimension, Direction};

/// An interface that the component can't have.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum InterfaceRefusal {
    /// A node has no degree of freedom at all.
    #[error(
        "interface {interface:?}: node {node} has no dof in the dof table; leave it out of the interface"
    )]
    NodeWithoutDof {
        /// Name of the interface.
        interface: String,
        /// The node.
        node: u32,
    },
    /// A node lacks a direction that is asked for.
    #[error(
        "interface {interface:?}: node {node} has no {}; ask for directions that every node of the interface has",
        direction.name()
    )]
    NoDirection {
        /// Name of the interface.
        interface: String,
        /// The node.
        node: u32,
        /// The direction.
        direction: Direction,
    },
    /// A node of an averaged frame lacks a translation.
    #[error(
        "interface {interface:?}: node {node} has no {}, but an averaged frame needs every translation of its nodes; leave the node out",
        direction.name()
    )]
    NoTranslation {
        /// Name of the interface.
        interface: String,
        /// The node.
        node: u32,
        /// The translation.
        direction: Direction,
    },
    /// A kind without frame where one is needed.
    #[error("interface {interface:?}: kind {} has no frame", kind.name())]
    NoFrame {
        /// Name of the interface.
        interface: String,
        /// Its kind.
        kind: InterfaceKind,
    },
    /// The nodes leave a direction of the frame open.
    #[error(
        "interface {interface:?}: its {nodes} node(s) can't carry {} because they are too few or lie on one line and have no rotations of their own; use at least {}, or ask for \"dofs\": [{}] only",
        direction.name(),
        match dimension {
            Dimension::Planar => "2 distinct nodes",
            Dimension::Spatial => "3 nodes that are not on one line",
        },
        quoted(possible)
    )]
    CannotCarry {
        /// Name of the interface.
        interface: String,
        /// How many nodes it has.
        nodes: usize,
        /// The direction.
        direction: Direction,
        /// Directions that the nodes can carry.
        possible: Vec<Direction>,
        /// Of the component.
        dimension: Dimension,
    },
    /// Weighted by area, and a node has none.
    #[error(
        "interface {interface:?}: weights \"area\": node {node} touches no boundary face whose nodes all belong to the interface; use \"uniform\", or complete the node set and the mesh's cells"
    )]
    NoArea {
        /// Name of the interface.
        interface: String,
        /// The node.
        node: u32,
    },
    /// Weighted by mass, and a node has none.
    #[error(
        "interface {interface:?}: node {node} has no mass, so it can't be weighted by mass; use \"uniform\" or \"area\""
    )]
    NoMass {
        /// Name of the interface.
        interface: String,
        /// The node.
        node: u32,
    },
}

fn quoted(directions: &[Direction]) -> String {
    let names = directions.iter().map(|d| format!("{:?}", d.name()));
    names.collect::<Vec<_>>().join(", ")
}
