//! Hard cases of constraints: redundant and nearly redundant loops, closed rings, dead centres.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use dcb_formats::mesh::Dimension;
use dcb_formats::scene::RedundantConstraints;
use dcb_runtime::integrator::Rule;
use dcb_runtime::simulation::Simulation;
use dcb_runtime::system::evaluation::Evaluation;
use dcb_runtime::system::linearization::Linearization;
use dcb_runtime::system::{State, System};
use nalgebra::{DMatrix, DVector, UnitQuaternion, Vector3};

use crate::assert_says;
use crate::hard::case::{Bounded, HardCase};
use crate::hard::dynamics::naive_constraints::{kinematic_newton, plain_elimination};
use crate::mechanism::rigid_benchmarks::GRAVITY;
use crate::mechanism::slider_crank::{SliderCrank, slider_position};
use crate::mechanism::{Scene, between, method, radau, revolute, run, slender_bar};

/// Largest λ that Gaussian elimination of the whole system finds at a state, no joint forces known.
fn eliminated(system: &System, state: &State) -> f64 {
    let mut still = state.clone();
    still.accelerations.fill(0.0);
    still.forces.fill(0.0);
    let mut evaluation = Evaluation::of(system);
    evaluation.refresh(system, &still);
    let matrices = Linearization::at(system, &still, &evaluation).expect("matrices");
    let dense = |matrix: &faer::Mat<f64>| {
        DMatrix::from_fn(matrix.nrows(), matrix.ncols(), |i, j| matrix[(i, j)])
    };
    let forces = DVector::from_iterator(
        evaluation.residual.len(),
        evaluation.residual.iter().map(|residual| -residual),
    );
    let curvature = matrices.constraints.iter();
    let curvature: Vec<f64> = curvature
        .map(|row| evaluation.second_rate(system, *row))
        .collect();
    plain_elimination(
        &dense(&matrices.mass),
        &dense(&matrices.jacobian),
        &forces,
        &DVector::from_vec(curvature),
    )
}

/// A four-bar linkage in space, the last axis out of parallel by an angle; λ by plain elimination at the start, and the simulation.
fn skewed_linkage(skew: f64, rule: Rule) -> (f64, Simulation) {
    let space = Dimension::Spatial;
    let mut scene = Scene::new(space, Vector3::new(0.0, -GRAVITY, 0.0));
    let corners = [
        [0.0, 0.0, 0.0],
        [0.0, 0.4, 0.0],
        [0.9, 0.7, 0.0],
        [1.0, 0.0, 0.0],
    ];
    let z = revolute(Vector3::z());
    let mut last = scene.ground(corners[0]);
    for pair in corners.windows(2) {
        let length = (Vector3::from(pair[1]) - Vector3::from(pair[0])).norm();
        let bar = slender_bar(space, length, length);
        let body = scene.body(&bar, &between(pair[0], pair[1], [0.0; 3], [0.0; 3]));
        let start = scene.on(body, 0);
        scene.join(&z, last, start);
        last = scene.on(body, 1);
    }
    let turn = UnitQuaternion::from_axis_angle(&Vector3::x_axis(), skew);
    let axes = turn.to_rotation_matrix().into_inner();
    let ground = scene.builder().ground(Vector3::from(corners[3]), axes);
    scene.join(&revolute(Vector3::z()), ground, last);
    let (system, state) = scene.finish();
    let naive = eliminated(&system, &state);
    let started = Simulation::start(system, state, rule, RedundantConstraints::MinimumNorm);
    (naive, started.expect("a start").0)
}

/// Four revolute axes of which one is 1e-9 rad out of parallel: a loop that is not quite redundant.
pub fn nearly_redundant_loop() -> HardCase {
    skewed_beside_parallel("nearly_redundant_loop", method(0.9).into(), 200)
}

/// The same by accuracy.
pub fn nearly_redundant_loop_by_radau() -> HardCase {
    skewed_beside_parallel("nearly_redundant_loop_by_radau", radau(1e-8).into(), 1)
}

fn skewed_beside_parallel(name: &'static str, rule: Rule, steps: usize) -> HardCase {
    let (naive, mut skewed) = skewed_linkage(1e-9, rule);
    let (_, mut parallel) = skewed_linkage(0.0, rule);
    let largest = |simulation: &Simulation| {
        let forces = simulation.state().forces.iter();
        forces.fold(0.0_f64, |most, force| most.max(force.abs()))
    };
    let expected = largest(&parallel);
    assert!(naive > 1e3 * expected, "{naive:e} of {expected:e}");
    let mut apart: f64 = 0.0;
    for _ in 0..15 {
        run(&mut skewed, 0.1, steps, |_| {});
        run(&mut parallel, 0.1, steps, |_| {});
        let places = skewed.state().origins.iter().zip(&parallel.state().origins);
        apart = places.map(|(a, b)| (a - b).norm()).fold(apart, f64::max);
        assert!(largest(&skewed) < 100.0 * expected);
    }
    HardCase {
        group: "dynamics",
        name,
        naive_method: "Gaussian elimination with row pivoting of the whole system",
        naive: format!(
            "joint forces of {naive:.0e} N in a linkage of a few kilograms whose largest is {expected:.0} N"
        ),
        ours: "the nearly dependent rows are told as redundant; places over 1.5 s, m, from those of the parallel axes".into(),
        error: Some(Bounded {
            found: apart,
            bound: 1e-6,
        }),
    }
}

/// Sixty-four bars that spin as a regular polygon, in space, where three of the loop's constraints are redundant.
pub fn closed_ring() -> HardCase {
    spinning_polygon("closed_ring", method(0.9).into(), 200, 1e-3)
}

/// The same by accuracy.
pub fn closed_ring_by_radau() -> HardCase {
    spinning_polygon("closed_ring_by_radau", radau(1e-8).into(), 1, 1e-6)
}

fn spinning_polygon(name: &'static str, rule: Rule, steps: usize, bound: f64) -> HardCase {
    const COUNT: usize = 64;
    let (speed, length, mass) = (10.0, 0.1, 0.2);
    let half = PI / COUNT as f64;
    let (outer, inner) = (length / (2.0 * half.sin()), length / (2.0 * half.tan()));
    let corner = |index: usize| {
        let (sine, cosine) = (TAU * index as f64 / COUNT as f64).sin_cos();
        [outer * cosine, outer * sine, 0.0]
    };
    let mut scene = Scene::new(Dimension::Spatial, Vector3::zeros());
    let bar = slender_bar(Dimension::Spatial, mass, length);
    let spin = Vector3::new(0.0, 0.0, speed);
    let bodies: Vec<usize> = (0..COUNT)
        .map(|index| {
            let (from, to) = (corner(index), corner((index + 1) % COUNT));
            let middle = 0.5 * (Vector3::from(from) + Vector3::from(to));
            let drawn = between(from, to, spin.cross(&middle).into(), spin.into());
            scene.body(&bar, &drawn)
        })
        .collect();
    for index in 0..COUNT {
        let (a, b) = (bodies[index], bodies[(index + 1) % COUNT]);
        let (a, b) = (scene.on(a, 1), scene.on(b, 0));
        scene.join(&revolute(Vector3::z()), a, b);
    }
    let (system, state) = scene.finish();
    // Two forces along the tangents at its ends hold a bar on its circle.
    let expected = mass * speed * speed * inner / (2.0 * half.sin());
    let naive = eliminated(&system, &state);
    assert!(naive.is_finite(), "the redundancy is noticed");
    let (mut simulation, report) =
        Simulation::start(system, state, rule, RedundantConstraints::MinimumNorm).expect("a start");
    let redundant: usize = report.redundant.iter().map(|(_, count)| count).sum();
    assert_eq!(redundant, 3);
    let first = simulation.state().origins.clone();
    run(&mut simulation, PI / speed, steps, |_| {});
    let places = simulation.state().origins.iter().zip(&first);
    let mut error = places
        .map(|(now, then)| (now + then).norm() / outer)
        .fold(0.0, f64::max);
    for connection in &simulation.system().connections {
        let force = &simulation.state().forces[connection.rows.clone()];
        let force = Vector3::from_column_slice(&force[..3]).norm();
        error = error.max((force / expected - 1.0).abs());
    }
    HardCase {
        group: "dynamics",
        name,
        naive_method: "Gaussian elimination with row pivoting of the whole system",
        naive: format!("joint forces, {naive:.0} N at most, and no word of the three that are arbitrary"),
        ours: "three redundant constraints are found in 320; places and joint forces of 64 spinning bars after half a turn".into(),
        error: Some(Bounded {
            found: error,
            bound,
        }),
    }
}

/// The largest error of the slider's place in a turn of crank and rod of 1 m, or why it stops.
fn turned(mechanism: &SliderCrank, rule: impl Into<Rule>, steps: usize) -> Result<f64, String> {
    let mut simulation = mechanism.start(&mechanism.rigid_start(), rule);
    let step = TAU / mechanism.speed / steps as f64;
    let mut error: f64 = 0.0;
    for _ in 0..steps {
        simulation.step(step).map_err(|error| error.to_string())?;
        let expected = 2.0 * (mechanism.speed * simulation.state().time).cos();
        error = error.max((slider_position(&simulation) - expected).abs());
    }
    Ok(error)
}

/// Steps of a quarter turn that end on its dead centre.
const QUARTER: usize = 100;

/// Crank and rod of the same length: at 90 degrees the slider is over the axle and the rod could go either way.
fn equal_crank_and_rod() -> SliderCrank {
    SliderCrank {
        crank: 1.0,
        speed: 10.0,
        slider: 1.0,
        rod: slender_bar(Dimension::Planar, 1.0, 1.0),
        dimension: Dimension::Planar,
        rod_axes: 0.0,
    }
}

/// What a plain iteration from place to place comes to.
fn stuck_newton() -> String {
    let angles = (1..=2 * QUARTER).map(|k| FRAC_PI_2 * k as f64 / QUARTER as f64);
    let naive = kinematic_newton(angles);
    let failed = naive.is_none_or(|place| (place + 2.0).abs() > 0.1);
    assert!(failed, "{naive:?}");
    naive.map_or(
        "no solution at 90 degrees, where the Jacobian is singular".into(),
        |place| format!("slider at {place:.2} m after half a turn in place of -2 m"),
    )
}

/// Steps that end on the dead centres, and steps that don't.
pub fn dead_centre() -> HardCase {
    let mechanism = equal_crank_and_rod();
    let exact = turned(&mechanism, method(0.8), 4 * QUARTER);
    let beside = turned(&mechanism, method(0.8), 4 * QUARTER + 1);
    println!("{exact:?} {beside:?}");
    for message in [&exact, &beside]
        .into_iter()
        .filter_map(|run| run.as_ref().err())
    {
        assert_says(message, &["t = ", "step"]);
    }
    HardCase {
        group: "dynamics",
        name: "dead_centre",
        naive_method: "Newton's iteration from the last position, plain elimination",
        naive: stuck_newton(),
        ours: match (&exact, &beside) {
            (Ok(_), Ok(_)) => "both dead centres of a turn are passed, hit by steps or not; place of the slider, m, from 2 cos φ".into(),
            (Err(_), Ok(_)) => "a step that ends on a dead centre is refused with its time; steps beside it pass; place of the slider, m, from 2 cos φ".into(),
            (_, Err(message)) => format!("refused: {message}"),
        },
        error: beside.ok().map(|found| Bounded { found, bound: 1e-3 }),
    }
}

/// The same by accuracy, looked at as often and once a turn only.
pub fn dead_centre_by_radau() -> HardCase {
    let mechanism = equal_crank_and_rod();
    let looks = [4 * QUARTER, 4 * QUARTER + 1, 1];
    let errors = looks.map(|looks| turned(&mechanism, radau(1e-8), looks));
    println!("{errors:?}");
    let worst = errors
        .into_iter()
        .map(|error| error.expect("a turn"))
        .fold(0.0, f64::max);
    HardCase {
        group: "dynamics",
        name: "dead_centre_by_radau",
        naive_method: "Newton's iteration from the last position, plain elimination",
        naive: stuck_newton(),
        ours: "both dead centres of a turn are passed, looked at 400, 401 times or once; place of the slider, m, from 2 cos φ".into(),
        error: Some(Bounded {
            found: worst,
            bound: 1e-6,
        }),
    }
}
