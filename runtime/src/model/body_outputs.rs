//! Outputs of bodies as a whole: their frames, their mass, alone and together; and nodes of their meshes.

use dcb_formats::mesh::Dimension;
use dcb_formats::results::Channel;
use dcb_formats::scene::{AngularMomentum, MassPoint, MeshNode, MomentPoint, OfMass, in_space};
use nalgebra::{Matrix3, Vector3};

use super::mass_probe::{MassProbe, MassQuantity};
use super::outputs::OutputBuilder;
use super::probe::{FrameProbe, FrameQuantity, NodeQuantity, Probe};
use crate::error::Error;
use crate::measure::{Angle, Measure};
use crate::system::marker::Marker;

impl OutputBuilder<'_> {
    /// A quantity of a body's frame.
    pub(super) fn body_frame(
        &mut self,
        path: &str,
        body: &str,
        quantity: FrameQuantity,
    ) -> (Channel, Probe) {
        let channel = self.frame_channel(path, quantity);
        let body = self.body(body);
        let turns =
            (quantity, self.scene.dimension) == (FrameQuantity::Orientation, Dimension::Planar);
        let angle = turns.then(|| {
            let world = self.builder.ground(Vector3::zeros(), Matrix3::identity());
            let frame = self.builder.body_frame(body);
            self.builder
                .watch(world, frame, Measure::Angle(Angle::in_plane()))
        });
        let probe = FrameProbe {
            marker: Marker::on_body(body),
            quantity,
            at_start: Vector3::zeros(),
            angle,
        };
        (channel, Probe::Frame(Box::new(probe)))
    }

    pub(super) fn center_of_mass(&self, path: &str, of: &OfMass) -> (Channel, Probe) {
        let q = self.quantities;
        let what = "position of the centre of mass, world axes";
        let channel = q.vector(path, self.scene.dimension, &q.length, what);
        (channel, self.mass(of.body.as_deref(), MassQuantity::Center))
    }

    pub(super) fn momentum(&self, path: &str, of: &OfMass) -> (Channel, Probe) {
        let q = self.quantities;
        let channel = q.vector(
            path,
            self.scene.dimension,
            &q.momentum,
            "momentum, world axes",
        );
        (channel, self.mass(of.body.as_deref(), MassQuantity::Linear))
    }

    pub(super) fn angular_momentum(&self, path: &str, of: &AngularMomentum) -> (Channel, Probe) {
        let q = self.quantities;
        let (quantity, what) = match &of.about {
            None => (
                MassQuantity::AngularAbout(Vector3::zeros()),
                "angular momentum about the world's origin, world axes",
            ),
            Some(MomentPoint::Fixed(point)) => (
                MassQuantity::AngularAbout(in_space(point)),
                "angular momentum about a fixed point, world axes",
            ),
            Some(MomentPoint::OfMass(MassPoint::CenterOfMass)) => (
                MassQuantity::AngularAboutCenter,
                "angular momentum about the centre of mass, world axes",
            ),
        };
        let channel = match self.scene.dimension {
            Dimension::Planar => Channel::scalar(path, &q.angular_momentum, what),
            Dimension::Spatial => q.vector(path, Dimension::Spatial, &q.angular_momentum, what),
        };
        (channel, self.mass(of.body.as_deref(), quantity))
    }

    fn mass(&self, body: Option<&str>, quantity: MassQuantity) -> Probe {
        Probe::Mass(MassProbe {
            body: body.map(|body| self.body(body)),
            quantity,
        })
    }

    /// A quantity of a node; `at` is the path of keys.
    pub(super) fn node_motion(
        &mut self,
        path: &str,
        at: &str,
        of: &MeshNode,
        quantity: NodeQuantity,
    ) -> Result<(Channel, Probe), Error> {
        let node = self.node(at, &of.body, of.node)?;
        let (q, body) = (self.quantities, self.body(&of.body));
        let (unit, what) = match quantity {
            NodeQuantity::Displacement => {
                (&q.length, "elastic displacement of the node, body axes")
            }
            NodeQuantity::Position => (&q.length, "position of the node, world axes"),
            NodeQuantity::Velocity => (&q.velocity, "velocity of the node, world axes"),
            NodeQuantity::Acceleration => (&q.acceleration, "acceleration of the node, world axes"),
        };
        let probe = Probe::Node {
            body,
            node: Box::new(node),
            quantity,
        };
        Ok((q.vector(path, self.scene.dimension, unit, what), probe))
    }
}
