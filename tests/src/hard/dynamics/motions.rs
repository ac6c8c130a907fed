//! Hard cases of long motions: a chain of many bars, many turns, a start that the constraints don't allow.

use std::f64::consts::TAU;

use dcb_formats::mesh::Dimension;
use dcb_runtime::integrator::Rule;
use dcb_runtime::system::builder::Drawn;
use nalgebra::{DMatrix, DVector, Matrix3, Vector2, Vector3};

use crate::hard::case::{Bounded, HardCase};
use crate::hard::dynamics::naive_constraints::{sequential_impulses, twice_differentiated};
use crate::mechanism::rigid_benchmarks::GRAVITY;
use crate::mechanism::{
    Scene, between, energy, method, radau, revolute, rigid, run, runge_kutta, slender_bar,
};

/// Angles below the horizontal of `N` slender bars that hang from each other, by Lagrange's equations of the angles.
fn angles_of_chain<const N: usize>(length: f64, duration: f64, steps: usize) -> [f64; N] {
    let mut state = DVector::zeros(2 * N);
    let beyond = |i: usize| (N - 1 - i) as f64;
    let slope = |state: &DVector<f64>| {
        let mut matrix = DMatrix::zeros(N, N);
        let mut right = DVector::zeros(N);
        for i in 0..N {
            for j in 0..N {
                let own = if i == j { 1.0 / 3.0 } else { 0.5 };
                let weight = beyond(i.max(j)) + own;
                let (sine, cosine) = (state[i] - state[j]).sin_cos();
                matrix[(i, j)] = weight * cosine;
                right[i] -= weight * sine * state[N + j].powi(2);
            }
            right[i] += GRAVITY / length * (beyond(i) + 0.5) * state[i].cos();
        }
        let accelerations = matrix.cholesky().expect("a mass matrix").solve(&right);
        let mut slope = DVector::zeros(2 * N);
        slope.rows_mut(0, N).copy_from(&state.rows(N, N));
        slope.rows_mut(N, N).copy_from(&accelerations);
        slope
    };
    let h = duration / steps as f64;
    for _ in 0..steps {
        let k1 = slope(&state);
        let k2 = slope(&(&state + 0.5 * h * &k1));
        let k3 = slope(&(&state + 0.5 * h * &k2));
        let k4 = slope(&(&state + h * &k3));
        state += h / 6.0 * (k1 + 2.0 * (k2 + k3) + k4);
    }
    std::array::from_fn(|i| state[i])
}

/// Sixty-four bars, one metre in all, let go from the horizontal.
pub fn long_chain() -> HardCase {
    falling_chain("long_chain", method(0.9).into(), 1500, 1e-3)
}

/// The same by accuracy.
pub fn long_chain_by_radau() -> HardCase {
    falling_chain("long_chain_by_radau", radau(1e-7).into(), 1, 1e-6)
}

fn falling_chain(name: &'static str, rule: Rule, steps: usize, bound: f64) -> HardCase {
    const COUNT: usize = 64;
    let (length, duration) = (1.0 / COUNT as f64, 0.3);
    let naive = sequential_impulses(&[length; COUNT], 5, 1e-3, 300);
    assert!(naive > 0.01, "the chain stretches by {naive} only");
    let mut scene = Scene::new(Dimension::Planar, Vector3::new(0.0, -GRAVITY, 0.0));
    let bar = slender_bar(Dimension::Planar, length, length);
    let mut last = scene.ground([0.0; 3]);
    for index in 0..COUNT {
        let x = length * index as f64;
        let drawn = between([x, 0.0, 0.0], [x + length, 0.0, 0.0], [0.0; 3], [0.0; 3]);
        let body = scene.body(&bar, &drawn);
        let start = scene.on(body, 0);
        scene.join(&revolute(Vector3::z()), last, start);
        last = scene.on(body, 1);
    }
    let (mut simulation, _) = scene.start(rule);
    run(&mut simulation, duration, steps, |_| {});
    let angles = angles_of_chain::<COUNT>(length, duration, 600);
    let (mut joint, mut error) = (Vector3::zeros(), 0.0_f64);
    for (angle, found) in angles.iter().zip(&simulation.state().origins) {
        let along = Vector3::new(angle.cos(), -angle.sin(), 0.0) * length;
        error = error.max((found - (joint + 0.5 * along)).norm());
        joint += along;
    }
    HardCase {
        group: "dynamics",
        name,
        naive_method: "sequential impulses, 5 sweeps a step",
        naive: format!("a chain of 64 links stretches by {:.0} %", 100.0 * naive),
        ours: "64 bars fall for 0.3 s; places, m of 1 m, from Lagrange's equations of the angles"
            .into(),
        error: Some(Bounded {
            found: error,
            bound,
        }),
    }
}

/// A bar on a pin that whirls over the top: turns, change of the energy by what it was, and change of the rod's length.
fn whirled(rule: Rule, steps: usize, a_turn: f64) -> [f64; 3] {
    let speed = 20.0;
    let step = TAU / (speed * a_turn);
    let mut scene = Scene::new(Dimension::Planar, Vector3::new(0.0, -GRAVITY, 0.0));
    let bar = slender_bar(Dimension::Planar, 1.0, 1.0);
    let drawn = between(
        [0.0; 3],
        [1.0, 0.0, 0.0],
        [0.0, 0.5 * speed, 0.0],
        [0.0, 0.0, speed],
    );
    let bar = scene.body(&bar, &drawn);
    let (ground, pin) = (scene.ground([0.0; 3]), scene.on(bar, 0));
    scene.join(&revolute(Vector3::z()), ground, pin);
    let (mut simulation, _) = scene.start(rule);
    let start = energy(&mut simulation);
    let (mut drift, mut open, mut turned): (f64, f64, f64) = (0.0, 0.0, 0.0);
    for index in 1..=steps {
        simulation.step(step).expect("a step");
        let mean = simulation.state().velocities[5];
        turned += mean * step / TAU;
        if index % 97 == 0 {
            drift = drift.max((energy(&mut simulation) / start - 1.0).abs());
            open = open.max((simulation.state().origins[0].norm() - 0.5).abs());
        }
    }
    [turned, drift, open]
}

fn whirling(name: &'static str, rule: Rule, (steps, a_turn): (usize, f64), bound: f64) -> HardCase {
    let naive = twice_differentiated(Vector2::new(0.0, 20.0), TAU / (20.0 * a_turn), steps);
    assert!(
        naive.abs() > 1e-3 || naive.is_nan(),
        "the rod keeps its length: {naive:e}"
    );
    let [turns, drift, open] = whirled(rule, steps, a_turn);
    assert!(turns > 0.9 * steps as f64 / a_turn, "{turns} turns");
    assert!(open < 1e-9, "the pin is open by {open:e}");
    HardCase {
        group: "dynamics",
        name,
        naive_method: "constraint differentiated twice, Runge-Kutta of order four",
        naive: format!("the rod of 1 m is off by {naive:.1e} m after {steps} steps"),
        ours: format!(
            "{turns:.0} turns at {a_turn} steps or looks a turn, the pin open by {open:.0e} m at most; change of the energy, relative"
        ),
        error: Some(Bounded {
            found: drift,
            bound,
        }),
    }
}

/// A thousand turns.
pub fn whirling_bar() -> HardCase {
    whirling("whirling_bar", method(0.9).into(), (100_000, 100.0), 1e-3)
}

/// Ten thousand turns.
pub fn whirling_bar_ten_thousand_turns() -> HardCase {
    let rule = method(0.9).into();
    let steps = (1_000_000, 100.0);
    whirling("whirling_bar_ten_thousand_turns", rule, steps, 5e-3)
}

/// Ten thousand turns by accuracy.
pub fn whirling_bar_by_radau() -> HardCase {
    whirling(
        "whirling_bar_by_radau",
        radau(1e-8).into(),
        (200_000, 20.0),
        1e-4,
    )
}

/// A bar that is drawn with a velocity its pin doesn't allow.
pub fn inconsistent_start() -> HardCase {
    thrown_bob("inconsistent_start", method(0.9).into(), 8000, 1e-4)
}

/// The same by accuracy.
pub fn inconsistent_start_by_radau() -> HardCase {
    thrown_bob("inconsistent_start_by_radau", radau(1e-9).into(), 1, 1e-7)
}

fn thrown_bob(name: &'static str, rule: Rule, steps: usize, bound: f64) -> HardCase {
    let naive = twice_differentiated(Vector2::new(0.5, -1.0), 1e-3, 2000).abs();
    assert!(naive > 0.1, "the rod keeps its length: {naive:e}");
    let moment = 1e-4;
    let mut scene = Scene::new(Dimension::Planar, Vector3::new(0.0, -GRAVITY, 0.0));
    let bob = rigid(
        Dimension::Planar,
        1.0,
        Matrix3::identity() * moment,
        &[[-1.0, 0.0, 0.0]],
    );
    let drawn = Drawn {
        position: Vector3::new(1.0, 0.0, 0.0),
        velocity: Vector3::new(0.5, -1.0, 0.0),
        ..Drawn::default()
    };
    let bob = scene.body(&bob, &drawn);
    let (ground, pin) = (scene.ground([0.0; 3]), scene.on(bob, 0));
    scene.join(&revolute(Vector3::z()), ground, pin);
    let (mut simulation, report) = scene.start(rule);
    assert_eq!(report.sped.len(), 1, "{report:?}");
    run(&mut simulation, 2.0, steps, |_| {});
    // The least change of momentum: m and I share the velocity across the rod.
    let spin = -1.0 / (1.0 + moment);
    let expected = runge_kutta([0.0, spin], 2.0, 20_000, |[angle, rate]| {
        [*rate, -GRAVITY * angle.cos() / (1.0 + moment)]
    });
    let place = simulation.state().origins[0];
    HardCase {
        group: "dynamics",
        name,
        naive_method: "velocities left as drawn, constraint differentiated twice",
        naive: format!("the rod of 1 m is off by {naive:.2} m after 2 s"),
        ours: "the velocity is corrected by the least momentum and told; place after 2 s, m, from the angle's own equation".into(),
        error: Some(Bounded {
            found: (place.x - expected[0].cos()).hypot(place.y - expected[0].sin()),
            bound,
        }),
    }
}
