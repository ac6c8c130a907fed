//! The planar slider-crank with a flexible connecting rod: a driven rigid crank, a rod, a slider on the x axis.

use std::sync::Arc;

use dcb_formats::function::{Function, TimeFunction};
use dcb_formats::mesh::Dimension;
use dcb_runtime::FlexibleBody;
use dcb_runtime::integrator::Rule;
use dcb_runtime::joint::{JointKind, Prismatic};
use dcb_runtime::simulation::Simulation;
use dcb_runtime::system::builder::{Drawn, JointCoordinate, SystemBuilder, Turning};
use dcb_runtime::system::{Signal, State, System};
use nalgebra::{Matrix3, UnitQuaternion, Vector3};

use crate::mechanism::{revolute, rigid, start};

/// The mechanism; it starts with crank and rod along x.
#[derive(Clone, Debug)]
pub struct SliderCrank {
    /// Length of the crank.
    pub crank: f64,
    /// The crank's angle is `speed t`.
    pub speed: f64,
    /// Mass of the slider.
    pub slider: f64,
    /// The rod: interfaces a at the crank pin and b at the slider.
    pub rod: Arc<FlexibleBody>,
    /// Planar or spatial; the motion is in the x-y plane.
    pub dimension: Dimension,
    /// Angle about z of the rod's component axes at the start, such that its ends are along the world's x axis.
    pub rod_axes: f64,
}

/// How the rod starts.
#[derive(Clone, Debug)]
pub struct RodStart {
    /// Coordinates.
    pub y: Vec<f64>,
    /// Their rates.
    pub rates: Vec<f64>,
    /// Spin about z.
    pub spin: f64,
}

/// Index of the crank among the bodies.
pub const CRANK: usize = 0;
/// Index of the rod.
pub const ROD: usize = 1;
/// Index of the slider.
pub const SLIDER: usize = 2;

impl SliderCrank {
    /// Undeformed, with the velocities of a rigid rod.
    pub fn rigid_start(&self) -> RodStart {
        let n = self.rod.coordinate_count();
        let length = (self.rod_end(1) - self.rod_end(0)).norm();
        RodStart {
            y: vec![0.0; n],
            rates: vec![0.0; n],
            spin: -self.crank * self.speed / length,
        }
    }

    fn rod_end(&self, end: usize) -> Vector3<f64> {
        self.rod.attachment(end).expect("a frame").position
    }

    /// The started simulation.
    pub fn start(&self, rod: &RodStart, rule: impl Into<Rule>) -> Simulation {
        let (system, state) = self.system(rod);
        start(system, state, rule).0
    }

    /// The mechanism as drawn.
    pub fn system(&self, rod: &RodStart) -> (System, State) {
        let mut builder = SystemBuilder::new(self.dimension, Vector3::zeros());
        // The crank is driven and the slider doesn't turn: what their moment of inertia is doesn't matter to the motion.
        let small = 0.1 * self.slider * self.crank * self.crank;
        let half = 0.5 * self.crank;
        let crank = rigid(
            self.dimension,
            self.slider,
            Matrix3::identity() * small,
            &[[-half, 0.0, 0.0], [half, 0.0, 0.0]],
        );
        let slider = rigid(
            self.dimension,
            self.slider,
            Matrix3::identity() * small,
            &[[0.0; 3]],
        );
        let axes = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), self.rod_axes);
        let [arm_a, arm_b] = [0, 1].map(|end| {
            let attachment = self.rod.attachment(end).expect("a frame");
            let (displacement, _) = attachment.products(&rod.y);
            let (moving, _) = attachment.products(&rod.rates);
            (axes * (attachment.position + displacement), axes * moving)
        });
        let spin = Vector3::new(0.0, 0.0, rod.spin);
        let pin = Vector3::new(self.crank, 0.0, 0.0);
        let origin = pin - arm_a.0;
        let pin_velocity = Vector3::new(0.0, self.crank * self.speed, 0.0);
        let velocity = pin_velocity - arm_a.1 - spin.cross(&arm_a.0);
        let center = axes * Vector3::from(self.rod.origin);
        let end = origin + arm_b.0;
        let end_velocity = velocity + arm_b.1 + spin.cross(&arm_b.0);

        let drawn = |position, velocity, angular_velocity| Drawn {
            position,
            velocity,
            angular_velocity,
            ..Drawn::default()
        };
        let turning = Vector3::new(0.0, 0.0, self.speed);
        builder.body(
            "crank",
            crank,
            &drawn(0.5 * pin, 0.5 * pin_velocity, turning),
        );
        builder.body(
            "rod",
            self.rod.clone(),
            &Drawn {
                orientation: axes,
                ..drawn(origin - center, velocity - spin.cross(&center), spin)
            },
        );
        let along = Vector3::new(end_velocity.x, 0.0, 0.0);
        builder.body("slider", slider, &drawn(end, along, Vector3::zeros()));

        let mut marker = |body, interface| {
            builder
                .marker(body, interface, Turning::Interface)
                .expect("a frame")
        };
        let (pivot, crank_pin) = (marker(CRANK, 0), marker(CRANK, 1));
        let (rod_a, rod_b, block) = (marker(ROD, 0), marker(ROD, 1), marker(SLIDER, 0));
        let ground = builder.ground(Vector3::zeros(), Matrix3::identity());
        let guide = builder.ground(Vector3::zeros(), Matrix3::identity());
        let z = revolute(Vector3::z());
        let mut join =
            |name, a, b, kind: &JointKind| builder.joint(name, a, b, kind).expect("a joint");
        let bearing = join("bearing", ground, pivot, &z);
        let along_x = JointKind::Prismatic(Prismatic { axis: Vector3::x() });
        match self.dimension {
            Dimension::Planar => {
                join("pin a", crank_pin, rod_a, &z);
                join("pin b", rod_b, block, &z);
            }
            // The rod's end a keeps it in the plane; end b is free to turn.
            Dimension::Spatial => {
                join("pin a", crank_pin, rod_a, &z);
                join(
                    "pin b",
                    rod_b,
                    block,
                    &JointKind::Spherical(dcb_runtime::joint::Spherical),
                );
            }
        }
        join("guide", guide, block, &along_x);
        let function = Function::Polynomial(vec![0.0, self.speed]);
        let signal = builder.signal(Signal {
            function: TimeFunction::new(&function).expect("a function"),
            input: None,
            offset: 0.0,
        });
        let angle = bearing
            .coordinate(JointCoordinate::Rotation)
            .expect("an angle");
        builder.drive("motor", &bearing, angle, signal);
        let (system, mut state) = builder.finish();
        let body = &system.bodies[ROD];
        state.coordinates[body.coordinates.clone()].copy_from_slice(&rod.y);
        state.velocities[body.velocities.clone()][6..].copy_from_slice(&rod.rates);
        (system, state)
    }
}

/// Angle of the rod's frame.
pub fn rod_angle(simulation: &Simulation) -> f64 {
    let turn = &simulation.state().orientations[ROD];
    let axis = turn * Vector3::x();
    axis.y.atan2(axis.x)
}

/// Place of the slider on the x axis.
pub fn slider_position(simulation: &Simulation) -> f64 {
    simulation.state().origins[SLIDER].x
}

/// The rod's coordinates.
pub fn rod_coordinates(simulation: &Simulation) -> &[f64] {
    let range = simulation.system().bodies[ROD].coordinates.clone();
    &simulation.state().coordinates[range]
}
