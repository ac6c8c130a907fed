//! Errors of positions, velocities and the joints' forces over the step, against the same motion at much shorter steps.

use std::sync::Arc;

use dcb_formats::mesh::Dimension;
use dcb_runtime::FlexibleBody;
use dcb_runtime::integrator::{Formulation, Method};
use dcb_runtime::joint::{JointKind, Spherical};
use dcb_runtime::simulation::Simulation;
use dcb_runtime::system::State;
use dcb_runtime::system::builder::Drawn;
use nalgebra::Vector3;
use serde_json::{Value, json};

use crate::mechanism::closed_form_motions::beam;
use crate::mechanism::rigid_benchmarks::spatial_slider_crank;
use crate::mechanism::{Scene, between, method, revolute, slender_bar, stabilized};

/// Steps of the coarsest run.
pub const COARSEST: usize = 50;
/// Multiples of them, and of the run that stands for the exact motion.
const FINER: [usize; 3] = [1, 2, 4];
const FINEST: usize = 24;
/// By how much an observed order may be off 2.
pub const ORDER_BOUND: f64 = 0.25;
/// What is observed.
pub const QUANTITIES: [&str; 3] = ["positions", "velocities", "forces"];

/// A mechanism, and for how long it moves.
pub struct Problem {
    /// Its name.
    pub name: &'static str,
    start: fn(Method) -> Simulation,
    duration: f64,
}

/// Rigid bodies in a spatial loop, in an open chain, and a beam that bends through tenths of its length.
pub const PROBLEMS: [Problem; 3] = [
    Problem {
        name: "spatial slider-crank",
        start: spatial_slider_crank,
        duration: 0.2,
    },
    Problem {
        name: "rigid double pendulum",
        start: double_pendulum,
        duration: 0.4,
    },
    Problem {
        name: "soft pendulum",
        start: soft_pendulum,
        duration: 0.4,
    },
];

/// Two bars on a skew hinge and a ball, thrown so that all their axes turn far.
fn double_pendulum(method: Method) -> Simulation {
    let mut scene = Scene::new(Dimension::Spatial, Vector3::new(0.0, -9.81, 1.0));
    let bar = slender_bar(Dimension::Spatial, 1.0, 1.0);
    let mut add = |x: f64| {
        let thrown = [4.0, 2.0, -3.0 * x];
        scene.body(
            &bar,
            &between([x, 0.0, 0.0], [x + 1.0, 0.0, 0.0], [0.0; 3], thrown),
        )
    };
    let [first, second] = [0.0, 1.0].map(&mut add);
    let (ground, top) = (scene.ground([0.0; 3]), scene.on(first, 0));
    scene.join(&revolute(Vector3::new(0.3, 0.2, 1.0)), ground, top);
    let (end, next) = (scene.on(first, 1), scene.on(second, 0));
    scene.join(&JointKind::Spherical(Spherical), end, next);
    scene.start(method).0
}

/// A beam on a skew hinge, its stiffness so low that every coordinate is resolved.
fn soft_pendulum(method: Method) -> Simulation {
    let (_, body) = beam(4, 3, 0.0);
    let mut soft = FlexibleBody::clone(&body);
    let count = soft.stiffness.len();
    for (k, stiffness) in soft.stiffness.iter_mut().enumerate() {
        *stiffness = 1500.0 * (1.0 + k as f64 / count as f64);
    }
    soft.damping.fill(0.02);
    let mut scene = Scene::new(Dimension::Spatial, Vector3::new(0.0, -9.81, 0.0));
    let drawn = Drawn {
        angular_velocity: Vector3::new(0.0, 0.0, 2.0),
        ..Drawn::default()
    };
    let bar = scene.body(&Arc::new(soft), &drawn);
    let (ground, end) = (scene.ground([0.0; 3]), scene.on(bar, 0));
    scene.join(&revolute(Vector3::new(0.0, 0.3, 1.0)), ground, end);
    scene.start(method).0
}

fn states(problem: &Problem, method: Method, steps: usize) -> Vec<State> {
    let mut simulation = (problem.start)(method);
    let mut states = vec![simulation.state().clone()];
    crate::mechanism::run(&mut simulation, problem.duration, steps, |simulation| {
        states.push(simulation.state().clone());
    });
    states
}

fn difference(a: &[f64], b: &[f64]) -> f64 {
    let pairs = a.iter().zip(b);
    pairs.map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt()
}

/// Largest errors of positions (m and rad), velocities and forces over all steps, by their largest values.
fn errors(states: &[State], exact: &[State]) -> [f64; 3] {
    let every = (exact.len() - 1) / (states.len() - 1);
    let (mut worst, mut size) = ([0.0_f64; 3], [1.0, 0.0, 0.0]);
    for (state, exact) in states.iter().zip(exact.iter().step_by(every)) {
        let mut position = difference(&state.coordinates, &exact.coordinates);
        for body in 0..state.origins.len() {
            position += (state.origins[body] - exact.origins[body]).norm()
                + state.orientations[body].angle_to(&exact.orientations[body]);
        }
        let velocity = difference(&state.velocities, &exact.velocities);
        let force = difference(&state.forces, &exact.forces);
        let none = |values: &[f64]| difference(values, &vec![0.0; values.len()]);
        for (k, (error, value)) in [
            (position, 1.0),
            (velocity, none(&exact.velocities)),
            (force, none(&exact.forces)),
        ]
        .into_iter()
        .enumerate()
        {
            worst[k] = worst[k].max(error);
            size[k] = f64::max(size[k], value);
        }
    }
    std::array::from_fn(|k| worst[k] / size[k])
}

/// Errors of the three quantities at the three steps.
pub fn convergence(problem: &Problem, method: Method) -> [[f64; 3]; 3] {
    let exact = states(problem, method, FINEST * COARSEST);
    let found = FINER.map(|finer| errors(&states(problem, method, finer * COARSEST), &exact));
    std::array::from_fn(|k| found.map(|errors| errors[k]))
}

/// Orders between neighbouring steps.
pub fn orders(errors: &[f64; 3]) -> [f64; 2] {
    std::array::from_fn(|i| (errors[i] / errors[i + 1]).log2())
}

/// One line for each problem, formulation and quantity.
pub fn order() -> Vec<Value> {
    let mut lines = Vec::new();
    for problem in &PROBLEMS {
        for method in [method(0.8), stabilized(0.8)] {
            for (k, errors) in convergence(problem, method).iter().enumerate() {
                let orders = orders(errors);
                let off = orders.iter().map(|order| (order - 2.0).abs());
                lines.push(json!({
                    "kind": "order", "problem": problem.name, "quantity": QUANTITIES[k],
                    "formulation": match method.formulation {
                        Formulation::Index3 => "index 3",
                        Formulation::StabilizedIndex2 => "stabilized index 2",
                    },
                    "steps": FINER.map(|finer| problem.duration / (finer * COARSEST) as f64),
                    "errors": errors, "orders": orders,
                    "error": off.fold(0.0, f64::max), "bound": ORDER_BOUND,
                }));
            }
        }
    }
    lines
}
