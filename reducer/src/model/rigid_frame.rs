//! Degrees of freedom of the model, and the frames that stand for the nodes of rigid interfaces.

use dcb_formats::component::{Component, Interface};
use dcb_formats::mesh::Direction;

use crate::error::InterfaceRefusal;
use crate::model::frame::{FitDofs, FrameFit, cannot_carry, frame_directions, weighted_centroid};

/// A dof of the model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModelDof {
    /// Point that it belongs to, for orderings and graphs: node id, node count + index among the rigid frames, or for internal rows a
    /// point of their own after these.
    pub point: u32,
    /// The motion that it is an amplitude of; `None` for an internal row of the component.
    pub motion: Option<PointMotion>,
}

/// A direction of a node or of a rigid interface's frame, and where that is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointMotion {
    /// Direction.
    pub direction: Direction,
    /// Position, component coordinates.
    pub position: [f64; 3],
}

impl ModelDof {
    /// Of a node or of a frame.
    pub(super) fn of_point(point: u32, direction: Direction, position: [f64; 3]) -> Self {
        Self {
            point,
            motion: Some(PointMotion {
                direction,
                position,
            }),
        }
    }

    /// Whether it is a rotation.
    pub fn is_rotation(&self) -> bool {
        self.motion
            .is_some_and(|motion| motion.direction.is_rotation())
    }
}

/// The frame that stands for a rigid interface's nodes.
#[derive(Clone, Debug, PartialEq)]
pub struct RigidFrame {
    /// Index of the interface in the component.
    pub interface: usize,
    /// Its name.
    pub name: String,
    /// Reference position, component coordinates.
    pub position: [f64; 3],
    /// Directions that the interface offers as rows.
    pub wanted: Vec<Direction>,
    /// Directions that the nodes determine, with their model dofs.
    pub dofs: Vec<(Direction, u32)>,
    /// Each of those directions as a combination of the component's dofs: (row, coefficient).
    pub from_nodes: Vec<Vec<(u32, f64)>>,
}

impl RigidFrame {
    /// Model dof of a direction, if the frame has it.
    pub fn dof(&self, direction: Direction) -> Option<u32> {
        self.dofs
            .iter()
            .find(|(known, _)| *known == direction)
            .map(|(_, dof)| *dof)
    }

    /// Frame of the nodes of a rigid interface; its dofs are appended to `dofs`.
    ///
    /// # Errors
    /// [`InterfaceRefusal`] for a node without dofs, and where the nodes can't carry a direction that is asked for.
    pub(super) fn of(
        component: &Component,
        index: usize,
        interface: &Interface,
        frame_count: usize,
        dofs: &mut Vec<ModelDof>,
    ) -> Result<Self, InterfaceRefusal> {
        let has_dof = |node: u32| {
            Direction::ALL
                .iter()
                .any(|d| component.dofs.row(node, *d).is_some())
        };
        if let Some(node) = interface.nodes.iter().find(|node| !has_dof(**node)) {
            return Err(InterfaceRefusal::NodeWithoutDof {
                interface: interface.name.clone(),
                node: *node,
            });
        }
        let weights = vec![1.0; interface.nodes.len()];
        let position = interface
            .position
            .unwrap_or_else(|| weighted_centroid(component, &interface.nodes, &weights));
        let fit = FrameFit::new(
            component,
            &interface.nodes,
            &weights,
            position,
            FitDofs::All,
        );
        let wanted = frame_directions(component, interface);
        if let Some(open) = wanted.iter().find(|direction| fit.leaves_open(**direction)) {
            return Err(cannot_carry(component, interface, *open, &fit.determined()));
        }
        let point = (component.mesh.node_count() + frame_count) as u32;
        let mut frame_dofs = Vec::new();
        for direction in fit.independent_directions() {
            frame_dofs.push((direction, dofs.len() as u32));
            dofs.push(ModelDof::of_point(point, direction, position));
        }
        let from_nodes = frame_dofs
            .iter()
            .map(|(direction, _)| fit.row(*direction))
            .collect();
        Ok(Self {
            interface: index,
            name: interface.name.clone(),
            position,
            wanted,
            dofs: frame_dofs,
            from_nodes,
        })
    }
}
