//! Rigid mechanisms of the IFToMM library of multibody benchmarks, with published solutions or independent models of least
//! coordinates.
//!
//! Sources: González, Dopico, Lugrís, Cuadrado, "A benchmarking system for MBS simulation software", Multibody System Dynamics 16
//! (2006) 179-190 (problems A01, A02, A04); the IFToMM library's problem "spatial rigid slider-crank mechanism" and the
//! solutions submitted to it; values of Exudyn's examples where named.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use dcb_formats::mesh::Dimension;
use dcb_runtime::initial::{InitialReport, Redundancy};
use dcb_runtime::integrator::Method;
use dcb_runtime::joint::{Cylindrical, JointKind, Prismatic, Spherical, Universal};
use dcb_runtime::simulation::Simulation;
use dcb_runtime::system::builder::Drawn;
use dcb_tests::mechanism::{
    Scene, between, energy, extrapolated, method, revolute, rigid, run, runge_kutta, slender_bar,
    stabilized,
};
use nalgebra::{Matrix3, Vector3};

const GRAVITY: f64 = 9.81;

/// Two windows of five bars of 1 m and 1 kg, upright, pushed at 1 m/s (A02). They are parallelograms, so one angle φ from the
/// vertical tells everything: 3 φ'' = 3.5 g sin φ.
fn double_four_bar(method: Method) -> Simulation {
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
fn first_head(simulation: &Simulation) -> Vector3<f64> {
    2.0 * simulation.state().origins[0]
}

/// Exudyn's `fourBarMechanismIftomm.py` gives the place of the first head at 10 s for steps of 0.25 and 0.125 ms: (0.3284552113,
/// 0.9445195467) and (0.3284573768, 0.9445187937), of second order in the step; and a largest energy error of 1.143e-3 J at 1 ms.
#[test]
fn double_four_bar_passes_its_singular_positions() {
    let (coarse, fine) = ([0.3284552113, 0.9445195467], [0.3284573768, 0.9445187937]);
    let published: [f64; 2] = std::array::from_fn(|k| extrapolated(coarse[k], fine[k]));
    let least = runge_kutta([0.0, 1.0], 10.0, 20_000, |[angle, rate]| {
        [*rate, 3.5 * GRAVITY / 3.0 * angle.sin()]
    });
    let expected = [least[0].sin(), least[0].cos()];
    for k in 0..2 {
        println!("{:.1e}", published[k] - expected[k]);
        assert!((published[k] - expected[k]).abs() < 2e-8);
    }
    for method in [method(0.95), stabilized(0.95)] {
        let errors = [10_000, 20_000].map(|steps| {
            let mut simulation = double_four_bar(method);
            let start = energy(&mut simulation);
            let mut worst: f64 = 0.0;
            run(&mut simulation, 10.0, steps, |simulation| {
                worst = worst.max((energy(simulation) - start).abs());
            });
            let head = first_head(&simulation);
            let error = (head.x - expected[0]).hypot(head.y - expected[1]);
            println!("{steps} steps: {error:.2e} m, {worst:.2e} J");
            (error, worst)
        });
        assert!(errors[0].0 < 1e-4 && errors[0].1 < 2e-3, "{errors:?}");
        let ratio = errors[0].0 / errors[1].0;
        assert!((3.5..4.5).contains(&ratio), "order: {ratio}");
    }
}

/// Crank 0.08 m about x at (0, 0.1, 0.12), rod 0.3 m with a spherical and a universal joint, slider along x; free from 6 rad/s.
fn spatial_slider_crank(method: Method) -> Simulation {
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

/// González's solution in the IFToMM library: the slider's place every 10 ms to nine digits; here at 1, 2, ..., 5 s. It was made
/// with some step; solutions submitted by others scatter by 1e-3 m. The limit of small steps is within 5e-5 m of it.
#[test]
fn spatial_slider_crank_follows_the_submitted_solution() {
    let published = [
        0.211_754_668,
        0.289_063_554,
        0.228_450_093,
        0.188_208_161,
        0.240_761_815,
    ];
    let runs = [2000, 4000].map(|steps| {
        let mut simulation = spatial_slider_crank(method(0.95));
        let start = energy(&mut simulation);
        let found: [f64; 5] = std::array::from_fn(|_| {
            run(&mut simulation, 1.0, steps, |_| {});
            simulation.state().origins[2].x
        });
        assert!((energy(&mut simulation) - start).abs() < 2e-6);
        found
    });
    for (second, expected) in published.iter().enumerate() {
        let limit = extrapolated(runs[0][second], runs[1][second]);
        println!("{limit:.9} {:.1e}", limit - expected);
        assert!((limit - expected).abs() < 5e-5);
        // The step's own error.
        assert!((runs[1][second] - limit).abs() < 2e-5);
    }
}

/// What closes the loop of Bricard's mechanism.
#[derive(Clone, Copy)]
enum Last {
    /// A revolute joint, as published: one constraint too many.
    Revolute,
    /// A cylindrical joint: the loop itself keeps it from sliding.
    Cylindrical,
}

/// Five bars of 1 m and 1 kg with a square section of 0.1 m on edges of a cube, six revolute joints (A04).
fn bricard(
    last: Last,
    method: Method,
    redundancy: Redundancy,
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

/// Bricard's mechanism moves although it has one constraint too many, which is found and shared out. The same loop closed by a
/// cylindrical joint has no redundancy and the same motion.
#[test]
fn bricard_moves_with_a_redundant_constraint() {
    let methods = [method(0.95), stabilized(0.95)];
    assert!(bricard(Last::Revolute, methods[0], Redundancy::Refuse).is_err());
    for method in methods {
        let (mut simulation, report) =
            bricard(Last::Revolute, method, Redundancy::MinimumNorm).unwrap();
        println!("{report:?}");
        assert_eq!(report.independent_constraints, 29);
        assert_eq!(
            report
                .redundant
                .iter()
                .map(|(_, count)| count)
                .sum::<usize>(),
            1
        );
        let (mut other, report) = bricard(Last::Cylindrical, method, Redundancy::Refuse).unwrap();
        assert_eq!(report.independent_constraints, 29);
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
        println!(
            "energy {drift:.2e} J, apart {apart:.2e} m, {:?}",
            simulation.effort()
        );
        assert!(drift < 1e-2 && apart < 1e-7);
    }
}

/// A pendulum of 1 kg on 1 m from the horizontal for 10 s (A01): an energy error below 5e-5 J is asked for.
#[test]
fn simple_pendulum_keeps_its_energy() {
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
    let start = energy(&mut simulation);
    let mut worst: f64 = 0.0;
    run(&mut simulation, 10.0, 20_000, |simulation| {
        worst = worst.max((energy(simulation) - start).abs());
    });
    let expected = runge_kutta([0.0, 0.0], 10.0, 20_000, |[angle, rate]| {
        [*rate, GRAVITY * angle.cos() / (1.0 + moment)]
    });
    let place = simulation.state().origins[0];
    let error = (place.x + expected[0].cos()).hypot(place.y + expected[0].sin());
    println!("{worst:.2e} J, {error:.2e} m");
    assert!(worst < 5e-5 && error < 1e-4);
}

/// Ten bars that hang from each other, let go from the horizontal: the energy error is of second order, or better, in the step.
#[test]
fn chain_of_ten_bars_keeps_its_energy() {
    let drift = |steps: usize| {
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
        let start = energy(&mut simulation);
        let mut worst: f64 = 0.0;
        run(&mut simulation, 0.8, steps, |simulation| {
            worst = worst.max((energy(simulation) - start).abs());
        });
        worst
    };
    let drifts = [2000, 4000].map(drift);
    println!("{drifts:?}");
    assert!(drifts[1] < 1e-4 && drifts[0] / drifts[1] > 3.0);
}
