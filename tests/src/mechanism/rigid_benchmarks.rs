//! Closed loops and pendulums of rigid bars: problems of the IFToMM library of multibody benchmarks.
//!
//! Sources: González, Dopico, Lugrís, Cuadrado, "A benchmarking system for MBS simulation software", Multibody System Dynamics 16
//! (2006) 179-190 (problems A01, A02, A04); the IFToMM library's problem "spatial rigid slider-crank mechanism" and the
//! solutions submitted to it; values of Exudyn's examples where named.

use dcb_formats::mesh::Dimension;
use dcb_formats::scene::RedundantConstraints;
use dcb_runtime::initial::InitialReport;
use dcb_runtime::integrator::Method;
use dcb_runtime::joint::{Cylindrical, JointKind, Prismatic, Spherical, Universal};
use dcb_runtime::simulation::Simulation;
use dcb_runtime::system::builder::Drawn;
use nalgebra::{Matrix3, Vector3};

use crate::mechanism::{
    Scene, between, energy, method, revolute, rigid, run, runge_kutta, slender_bar,
};

/// Gravity of the library, m/s².
pub const GRAVITY: f64 = 9.81;

/// Two windows of five bars of 1 m and 1 kg, upright, pushed at 1 m/s (A02). They are parallelograms, so one angle φ from the
/// vertical tells everything: 3 φ'' = 3.5 g sin φ.
pub fn double_four_bar(method: Method) -> Simulation {
    let mut scene = Scene::new(Dimension::Planar, Vector3::new(0.0, -GRAVITY, 0.0));
    let bar = slender_bar(Dimension::Planar, 1.0, 1.0);
    let z = revolute(Vector3::z());
    let cranks = [0.0, 1.0, 2.0].map(|x| {
        let drawn = between(
            [x, 0.0, 0.0],
            [x, 1.0, 0.0],
            [0.5, 0.0, 0.0],
            [0.0, 0.0, -1.0],
        );
        let crank = scene.body(&bar, &drawn);
        let (ground, foot) = (scene.ground([x, 0.0, 0.0]), scene.on(crank, 0));
        scene.join(&z, ground, foot);
        crank
    });
    for (x, pair) in [0.0, 1.0].into_iter().zip(cranks.windows(2)) {
        let drawn = between(
            [x, 1.0, 0.0],
            [x + 1.0, 1.0, 0.0],
            [1.0, 0.0, 0.0],
            [0.0; 3],
        );
        let coupler = scene.body(&bar, &drawn);
        for (end, crank) in pair.iter().enumerate() {
            let (head, own) = (scene.on(*crank, 1), scene.on(coupler, end));
            scene.join(&z, head, own);
        }
    }
    scene.start(method).0
}

/// The head of the first crank.
pub fn first_head(simulation: &Simulation) -> Vector3<f64> {
    2.0 * simulation.state().origins[0]
}

/// The head of the first crank after 10 s by the angle's own equation.
pub fn expected_head() -> [f64; 2] {
    let least = runge_kutta([0.0, 1.0], 10.0, 20_000, |[angle, rate]| {
        [*rate, 3.5 * GRAVITY / 3.0 * angle.sin()]
    });
    [least[0].sin(), least[0].cos()]
}

/// Error of the first head's place after 10 s, and the largest error of the energy on the way, J.
pub fn double_four_bar_errors(method: Method, steps: usize) -> (f64, f64) {
    let mut simulation = double_four_bar(method);
    let worst = energy_error(&mut simulation, 10.0, steps);
    let (head, expected) = (first_head(&simulation), expected_head());
    ((head.x - expected[0]).hypot(head.y - expected[1]), worst)
}

/// Largest error of the energy in `steps` steps.
fn energy_error(simulation: &mut Simulation, duration: f64, steps: usize) -> f64 {
    let start = energy(simulation);
    let mut worst: f64 = 0.0;
    run(simulation, duration, steps, |simulation| {
        worst = worst.max((energy(simulation) - start).abs());
    });
    worst
}

/// Crank 0.08 m about x at (0, 0.1, 0.12), rod 0.3 m with a spherical and a universal joint, slider along x; free from 6 rad/s.
pub fn spatial_slider_crank(method: Method) -> Simulation {
    let mut scene = Scene::new(Dimension::Spatial, Vector3::new(0.0, 0.0, -GRAVITY));
    let diagonal = |x, y, z| Matrix3::from_diagonal(&Vector3::new(x, y, z));
    let crank = rigid(
        Dimension::Spatial,
        0.12,
        diagonal(1e-4, 1e-4, 1e-5),
        &[[0.0, 0.0, -0.04], [0.0, 0.0, 0.04]],
    );
    let rod = rigid(
        Dimension::Spatial,
        0.5,
        diagonal(4e-4, 4e-3, 4e-3),
        &[[-0.15, 0.0, 0.0], [0.15, 0.0, 0.0]],
    );
    let block = rigid(
        Dimension::Spatial,
        2.0,
        Matrix3::identity() * 1e-4,
        &[[0.0; 3]],
    );
    let (pin, end) = ([0.0, 0.1, 0.2], [0.2, 0.0, 0.0]);
    let crank = scene.body(
        &crank,
        &Drawn {
            position: Vector3::new(0.0, 0.1, 0.16),
            velocity: Vector3::new(0.0, -0.24, 0.0),
            angular_velocity: Vector3::new(6.0, 0.0, 0.0),
            ..Drawn::default()
        },
    );
    let drawn = between(pin, end, [0.12, -0.24, 0.0], [1.92, -0.96, 0.48]);
    let rod = scene.body(&rod, &drawn);
    let block = scene.body(
        &block,
        &Drawn {
            position: Vector3::from(end),
            velocity: Vector3::new(0.24, 0.0, 0.0),
            ..Drawn::default()
        },
    );
    let (bearing, guide) = (scene.ground([0.0, 0.1, 0.12]), scene.ground([0.0; 3]));
    let (foot, head) = (scene.on(crank, 0), scene.on(crank, 1));
    let (rod_a, rod_b, block) = (scene.on(rod, 0), scene.on(rod, 1), scene.on(block, 0));
    scene.join(&revolute(Vector3::x()), bearing, foot);
    scene.join(&JointKind::Spherical(Spherical), head, rod_a);
    // The cross's axis on the rod is perpendicular to the rod and to the guide.
    let across = Vector3::new(0.0, 2.0, -1.0);
    let universal = Universal {
        axis_a: drawn.orientation.inverse() * across,
        axis_b: Vector3::x(),
    };
    scene.join(&JointKind::Universal(universal), rod_b, block);
    let along = Prismatic { axis: Vector3::x() };
    scene.join(&JointKind::Prismatic(along), guide, block);
    let (simulation, report) = scene.start(method);
    // The published velocities belong to these joints.
    assert!(report.moved.is_empty() && report.sped.is_empty() && report.redundant.is_empty());
    simulation
}

/// González's solution in the IFToMM library: the slider's place, m, at 1, 2, ..., 5 s.
pub const SUBMITTED_PLACES: [f64; 5] = [
    0.211_754_668,
    0.289_063_554,
    0.228_450_093,
    0.188_208_161,
    0.240_761_815,
];

/// The slider's place at 1, 2, ..., 5 s with so many steps a second, and the error of the energy at the end.
pub fn slider_places(steps: usize) -> ([f64; 5], f64) {
    let mut simulation = spatial_slider_crank(method(0.95));
    let start = energy(&mut simulation);
    let places = std::array::from_fn(|_| {
        run(&mut simulation, 1.0, steps, |_| {});
        simulation.state().origins[2].x
    });
    (places, (energy(&mut simulation) - start).abs())
}

/// What closes the loop of Bricard's mechanism.
#[derive(Clone, Copy)]
pub enum Last {
    /// A revolute joint, as published: one constraint too many.
    Revolute,
    /// A cylindrical joint: the loop itself keeps it from sliding.
    Cylindrical,
}

/// Five bars of 1 m and 1 kg with a square section of 0.1 m on edges of a cube, six revolute joints (A04).
pub fn bricard(
    last: Last,
    method: Method,
    redundancy: RedundantConstraints,
) -> Result<(Simulation, InitialReport), dcb_runtime::Error> {
    let corners = [
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [1.0, -1.0, 0.0],
        [1.0, -1.0, 1.0],
        [0.0, -1.0, 1.0],
        [0.0, 0.0, 1.0],
    ];
    let mut scene = Scene::new(Dimension::Spatial, Vector3::new(0.0, -GRAVITY, 0.0));
    let across = (1.0 + 0.01) / 12.0;
    let tensor = Matrix3::from_diagonal(&Vector3::new(0.02 / 12.0, across, across));
    let bar = rigid(
        Dimension::Spatial,
        1.0,
        tensor,
        &[[-0.5, 0.0, 0.0], [0.5, 0.0, 0.0]],
    );
    let bars: Vec<(usize, Drawn)> = corners
        .windows(2)
        .map(|ends| {
            let drawn = between(ends[0], ends[1], [0.0; 3], [0.0; 3]);
            (scene.body(&bar, &drawn), drawn)
        })
        .collect();
    // The axis of each joint, world axes as drawn.
    let axes = [Vector3::y(), Vector3::z(), Vector3::x()];
    let ground = scene.ground(corners[0]);
    let first = scene.on(bars[0].0, 0);
    scene.join(&revolute(axes[0]), ground, first);
    for (index, pair) in bars.windows(2).enumerate() {
        let (a, b) = (scene.on(pair[0].0, 1), scene.on(pair[1].0, 0));
        let axis = pair[0].1.orientation.inverse() * axes[(index + 1) % 3];
        scene.join(&revolute(axis), a, b);
    }
    let ground = scene.ground(corners[5]);
    let end = scene.on(bars[4].0, 1);
    let kind = match last {
        Last::Revolute => revolute(axes[2]),
        Last::Cylindrical => JointKind::Cylindrical(Cylindrical {
            axis: axes[2],
            axis_b: None,
        }),
    };
    scene.join(&kind, ground, end);
    let (system, state) = scene.finish();
    Simulation::start(system, state, method, redundancy)
}

/// Bricard's mechanism for 10 s at 1 ms: largest error of the energy, J, and distance of its bodies, m, from
/// those of the same loop without redundancy.
pub fn bricard_errors(method: Method) -> (f64, f64) {
    let loops = [
        (Last::Revolute, RedundantConstraints::MinimumNorm),
        (Last::Cylindrical, RedundantConstraints::Refuse),
    ];
    let [mut simulation, mut other] =
        loops.map(|(last, redundancy)| bricard(last, method, redundancy).expect("a start").0);
    let start = energy(&mut simulation);
    let (mut drift, mut apart): (f64, f64) = (0.0, 0.0);
    for _ in 0..100 {
        run(&mut simulation, 0.1, 100, |_| {});
        run(&mut other, 0.1, 100, |_| {});
        drift = drift.max((energy(&mut simulation) - start).abs());
        let places = simulation
            .state()
            .origins
            .iter()
            .zip(&other.state().origins);
        apart = places.map(|(a, b)| (a - b).norm()).fold(apart, f64::max);
    }
    (drift, apart)
}

/// A pendulum of 1 kg on 1 m from the horizontal for 10 s (A01) in `steps` steps: largest error of the energy, J, and error of
/// the place at the end, m, against the angle's own equation.
pub fn pendulum_errors(steps: usize) -> (f64, f64) {
    let moment = 1e-4;
    let mut scene = Scene::new(Dimension::Planar, Vector3::new(0.0, -GRAVITY, 0.0));
    let bob = rigid(
        Dimension::Planar,
        1.0,
        Matrix3::identity() * moment,
        &[[1.0, 0.0, 0.0]],
    );
    let drawn = Drawn {
        position: Vector3::new(-1.0, 0.0, 0.0),
        ..Drawn::default()
    };
    let bob = scene.body(&bob, &drawn);
    let (ground, pin) = (scene.ground([0.0; 3]), scene.on(bob, 0));
    scene.join(&revolute(Vector3::z()), ground, pin);
    let mut simulation = scene.start(method(0.95)).0;
    let worst = energy_error(&mut simulation, 10.0, steps);
    let expected = runge_kutta([0.0, 0.0], 10.0, 20_000, |[angle, rate]| {
        [*rate, GRAVITY * angle.cos() / (1.0 + moment)]
    });
    let place = simulation.state().origins[0];
    let error = (place.x + expected[0].cos()).hypot(place.y + expected[0].sin());
    (worst, error)
}

/// Ten bars that hang from each other, let go from the horizontal for 0.8 s: largest error of the energy, J.
pub fn chain_error(steps: usize) -> f64 {
    let mut scene = Scene::new(Dimension::Planar, Vector3::new(0.0, -GRAVITY, 0.0));
    let bar = slender_bar(Dimension::Planar, 0.1, 0.1);
    let mut last = scene.ground([0.0; 3]);
    for index in 0..10 {
        let x = 0.1 * f64::from(index);
        let body = scene.body(
            &bar,
            &between([x, 0.0, 0.0], [x + 0.1, 0.0, 0.0], [0.0; 3], [0.0; 3]),
        );
        let start = scene.on(body, 0);
        scene.join(&revolute(Vector3::z()), last, start);
        last = scene.on(body, 1);
    }
    let mut simulation = scene.start(method(0.95)).0;
    energy_error(&mut simulation, 0.8, steps)
}
