//! Small mechanisms of the runtime: units, rigid bodies, methods and runs that succeed.

pub mod closed_form_motions;
pub mod equivalent_models;
pub mod governor;
pub mod ivp_slider_crank;
pub mod rigid_benchmarks;
pub mod slider_crank;

use std::sync::Arc;

use dcb_formats::component::Units;
use dcb_formats::function::{Function, TimeFunction};
use dcb_formats::mesh::Dimension;
use dcb_formats::scene::RedundantConstraints;
use dcb_formats::scene::Scheme;
use dcb_runtime::FlexibleBody;
use dcb_runtime::body::{RigidBody, RigidPoint};
use dcb_runtime::initial::InitialReport;
use dcb_runtime::integrator::radau::{Accuracy, Stages};
use dcb_runtime::integrator::{Formulation, Method, Rule, Tolerance};
use dcb_runtime::joint::{JointKind, Revolute};
use dcb_runtime::simulation::Simulation;
use dcb_runtime::system::builder::{BuiltJoint, Drawn, SystemBuilder, Turning};
use dcb_runtime::system::{LoadAxes, Signal, State, System};
use nalgebra::{Matrix3, UnitQuaternion, Vector3};

/// Metre, kilogram, second.
pub fn si() -> Units {
    Units {
        length: "m".into(),
        mass: "kg".into(),
        time: "s".into(),
    }
}

/// A rigid body about its centre of mass, with points whose axes are the body's.
pub fn rigid(
    dimension: Dimension,
    mass: f64,
    tensor: Matrix3<f64>,
    points: &[[f64; 3]],
) -> Arc<FlexibleBody> {
    let points = points.iter().enumerate();
    let body = RigidBody {
        name: "rigid".into(),
        units: si(),
        dimension,
        mass,
        tensor,
        center: Vector3::zeros(),
        points: points
            .map(|(index, position)| RigidPoint {
                name: format!("p{index}"),
                position: Vector3::from(*position),
                axes: Matrix3::identity(),
            })
            .collect(),
    };
    Arc::new(FlexibleBody::rigid(&body).expect("a rigid body"))
}

/// A slender bar along x with a point at each end; a hundredth of its inertia is about the axis.
pub fn slender_bar(dimension: Dimension, mass: f64, length: f64) -> Arc<FlexibleBody> {
    let moment = mass * length * length / 12.0;
    let tensor = Matrix3::from_diagonal(&Vector3::new(0.01 * moment, moment, moment));
    let half = 0.5 * length;
    rigid(
        dimension,
        mass,
        tensor,
        &[[-half, 0.0, 0.0], [half, 0.0, 0.0]],
    )
}

/// A revolute joint about an axis of the first frame.
pub fn revolute(axis: Vector3<f64>) -> JointKind {
    JointKind::Revolute(Revolute { axis, axis_b: None })
}

/// Generalized-alpha on positions, converged to rounding.
pub fn method(spectral_radius: f64) -> Method {
    Method {
        scheme: Scheme::generalized_alpha(spectral_radius),
        formulation: Formulation::Index3,
        tolerance: Tolerance {
            relative: 1e-10,
            max_iterations: 20,
        },
    }
}

/// The same with positions and velocities of the constraints.
pub fn stabilized(spectral_radius: f64) -> Method {
    Method {
        formulation: Formulation::StabilizedIndex2,
        ..method(spectral_radius)
    }
}

/// A start that succeeds.
pub fn start(system: System, state: State, rule: impl Into<Rule>) -> (Simulation, InitialReport) {
    match Simulation::start(system, state, rule, RedundantConstraints::MinimumNorm) {
        Ok(started) => started,
        Err(error) => panic!("{error}"),
    }
}

/// Radau IIA of order 9 with this accuracy.
pub fn radau(tolerance: f64) -> Accuracy {
    Accuracy {
        tolerance,
        of_forces: f64::INFINITY,
        stages: Stages::Five,
        longest: f64::INFINITY,
        horizon: 10.0,
    }
}

/// `steps` equal steps over `duration`; after each of them `see` is shown the simulation.
pub fn run(
    simulation: &mut Simulation,
    duration: f64,
    steps: usize,
    mut see: impl FnMut(&mut Simulation),
) {
    for step in 0..steps {
        if let Err(error) = simulation.step(duration / steps as f64) {
            panic!("step {step}: {error}");
        }
        see(simulation);
    }
}

/// A system built of pieces that fit.
pub struct Scene {
    builder: SystemBuilder,
    joints: usize,
}

impl Scene {
    /// An empty scene under gravity.
    pub fn new(dimension: Dimension, gravity: Vector3<f64>) -> Self {
        Self {
            builder: SystemBuilder::new(dimension, gravity),
            joints: 0,
        }
    }

    /// Adds a body.
    pub fn body(&mut self, body: &Arc<FlexibleBody>, drawn: &Drawn) -> usize {
        let name = format!("body {}", self.builder.system().bodies.len());
        self.builder.body(&name, body.clone(), drawn)
    }

    /// The marker on interface `interface` of a body.
    pub fn on(&mut self, body: usize, interface: usize) -> usize {
        self.builder
            .marker(body, interface, Turning::Interface)
            .expect("a frame")
    }

    /// A marker on the ground along the world's axes.
    pub fn ground(&mut self, position: [f64; 3]) -> usize {
        self.builder
            .ground(Vector3::from(position), Matrix3::identity())
    }

    /// A joint between two markers.
    pub fn join(&mut self, kind: &JointKind, a: usize, b: usize) -> BuiltJoint {
        self.joints += 1;
        let name = format!("joint {}", self.joints);
        match self.builder.joint(&name, a, b, kind) {
            Ok(joint) => joint,
            Err(error) => panic!("{name}: {error}"),
        }
    }

    /// Pushes a marker with a constant force along the world's x and y.
    pub fn push(&mut self, marker: usize, force: [f64; 2]) {
        let [x, y] = force.map(|value| {
            Some(self.builder.signal(Signal {
                function: TimeFunction::new(&Function::Polynomial(vec![value])).expect("a number"),
                input: None,
                offset: 0.0,
            }))
        });
        self.builder
            .load("load", marker, LoadAxes::World, [x, y, None], [None; 3]);
    }

    /// For what is not a body, a joint or such a force.
    pub fn builder(&mut self) -> &mut SystemBuilder {
        &mut self.builder
    }

    /// The system and its state as drawn.
    pub fn finish(self) -> (System, State) {
        self.builder.finish()
    }

    /// Starts a simulation from the drawing.
    pub fn start(self, rule: impl Into<Rule>) -> (Simulation, InitialReport) {
        let (system, state) = self.builder.finish();
        start(system, state, rule)
    }
}

/// A body drawn with its x axis from one point to another, its origin in the middle, moving as a rigid one.
pub fn between(
    from: [f64; 3],
    to: [f64; 3],
    velocity: [f64; 3],
    angular_velocity: [f64; 3],
) -> Drawn {
    let (from, to) = (Vector3::from(from), Vector3::from(to));
    let turn = UnitQuaternion::rotation_between(&Vector3::x(), &(to - from));
    Drawn {
        position: 0.5 * (from + to),
        orientation: turn
            .unwrap_or_else(|| UnitQuaternion::from_euler_angles(0.0, 0.0, std::f64::consts::PI)),
        velocity: Vector3::from(velocity),
        angular_velocity: Vector3::from(angular_velocity),
    }
}

/// Mechanical energy now.
pub fn energy(simulation: &mut Simulation) -> f64 {
    simulation.refresh();
    simulation.energy().0.total()
}

/// Classical Runge-Kutta steps of `slope(x) = x'` for small independent models.
pub fn runge_kutta<const N: usize>(
    start: [f64; N],
    duration: f64,
    steps: usize,
    slope: impl Fn(&[f64; N]) -> [f64; N],
) -> [f64; N] {
    let h = duration / steps as f64;
    let moved = |x: &[f64; N], k: &[f64; N], by: f64| -> [f64; N] {
        std::array::from_fn(|i| x[i] + by * k[i])
    };
    let mut x = start;
    for _ in 0..steps {
        let k1 = slope(&x);
        let k2 = slope(&moved(&x, &k1, 0.5 * h));
        let k3 = slope(&moved(&x, &k2, 0.5 * h));
        let k4 = slope(&moved(&x, &k3, h));
        x = std::array::from_fn(|i| x[i] + h / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]));
    }
    x
}

/// The limit of a value with an error of second order, from steps h and h/2.
pub fn extrapolated(coarse: f64, fine: f64) -> f64 {
    fine + (fine - coarse) / 3.0
}
