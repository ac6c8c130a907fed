//! Hard cases of scale: masses and sizes that are many decades apart in one mechanism, and residual attachments that rounding made.

use std::f64::consts::TAU;
use std::sync::Arc;

use dcb_formats::mesh::Dimension;
use dcb_formats::scene::RedundantConstraints;
use dcb_formats::superelement::Superelement;
use dcb_runtime::integrator::Rule;
use dcb_runtime::simulation::Simulation;
use dcb_runtime::system::builder::Drawn;
use dcb_runtime::system::{State, System};
use dcb_runtime::{Compatibility, FlexibleBody};
use dcb_samples::{RodSection, planar_rod};
use faer::{Mat, Side};
use nalgebra::{Matrix3, Vector3};

use crate::assert_says;
use crate::hard::case::{Bounded, HardCase};
use crate::hard::dynamics::naive_constraints::{
    absolute_tolerance, penalty_rod, sequential_impulses,
};
use crate::hard::dynamics::steps::patient;
use crate::lowest;
use crate::mechanism::rigid_benchmarks::GRAVITY;
use crate::mechanism::slider_crank::{ROD, SliderCrank};
use crate::mechanism::{
    Scene, between, method, radau, revolute, rigid, run, runge_kutta, slender_bar, start,
};
use crate::rod::deflection::{apart, history};
use crate::rod::reduced::{Benchmark, ReducedRod};

/// Masses of a bar and of what hangs on it, kg.
const RATIO: (f64, f64) = (1e-5, 1e3);

/// A tonne hangs on a bar of ten milligrams: bodies and the start, and where the tonne is after two seconds.
fn tonne_on_a_bar() -> ((System, State), Vector3<f64>) {
    let (light, heavy) = RATIO;
    let mut scene = Scene::new(Dimension::Planar, Vector3::new(0.0, -GRAVITY, 0.0));
    let bar = slender_bar(Dimension::Planar, light, 1.0);
    let weight = rigid(Dimension::Planar, heavy, Matrix3::identity(), &[[0.0; 3]]);
    let z = revolute(Vector3::z());
    let bar = scene.body(
        &bar,
        &between([0.0; 3], [1.0, 0.0, 0.0], [0.0; 3], [0.0; 3]),
    );
    let drawn = Drawn {
        position: Vector3::x(),
        ..Drawn::default()
    };
    let weight = scene.body(&weight, &drawn);
    let (ground, foot) = (scene.ground([0.0; 3]), scene.on(bar, 0));
    let (head, center) = (scene.on(bar, 1), scene.on(weight, 0));
    scene.join(&z, ground, foot);
    scene.join(&z, head, center);
    let torque = GRAVITY * (heavy + 0.5 * light) / (heavy + light / 3.0);
    let [angle, _] = runge_kutta([0.0, 0.0], 2.0, 20_000, |[angle, rate]| {
        [*rate, -torque * angle.cos()]
    });
    (scene.finish(), Vector3::new(angle.cos(), angle.sin(), 0.0))
}

/// The string that stretches.
fn stretched_string() -> String {
    let naive = sequential_impulses(&[RATIO.0, RATIO.1], 100, 1e-3, 1000);
    assert!(naive > 0.05, "the string stretches by {naive} only");
    format!("the string of 1 m stretches by {:.0} %", 100.0 * naive)
}

/// Masses that are eight decades apart.
pub fn mass_ratio_1e8() -> HardCase {
    let ((system, state), expected) = tonne_on_a_bar();
    // The iteration leaves out what the joints' forces do as they turn, which a bar without inertia doesn't outweigh in long steps: they
    // fail by name.
    let (mut failed, mut found) = (Vec::new(), None);
    for steps in [4000, 40_000, 400_000] {
        let (mut simulation, _) = start(system.clone(), state.clone(), method(0.8));
        let step = 2.0 / f64::from(steps);
        match (0..steps).find_map(|_| simulation.step(step).err()) {
            Some(error) => {
                println!("{step}: {error}");
                assert_says(&error.to_string(), &["t = ", "take"]);
                failed.push(step);
            }
            None => {
                found = Some((step, simulation.state().origins[1]));
                break;
            }
        }
    }
    let (step, place) = found.expect("a step that is short enough");
    HardCase {
        group: "dynamics",
        name: "mass_ratio_1e8",
        naive_method: "sequential impulses, 100 sweeps a step",
        naive: stretched_string(),
        ours: format!(
            "a tonne on a bar of 10 mg for 2 s in steps of {step:.0e} s (stopped by name: {failed:?}); place, m, from the angle's own equation"
        ),
        error: Some(Bounded {
            found: (place - expected).norm(),
            bound: 1e-4,
        }),
    }
}

/// The same by accuracy.
pub fn mass_ratio_1e8_by_radau() -> HardCase {
    let ((system, state), expected) = tonne_on_a_bar();
    let (mut simulation, _) = start(system, state, radau(1e-8));
    run(&mut simulation, 2.0, 1, |_| {});
    HardCase {
        group: "dynamics",
        name: "mass_ratio_1e8_by_radau",
        naive_method: "sequential impulses, 100 sweeps a step",
        naive: stretched_string(),
        ours: "a tonne on a bar of 10 mg for 2 s; place, m, from the angle's own equation".into(),
        error: Some(Bounded {
            found: (simulation.state().origins[1] - expected).norm(),
            bound: 1e-6,
        }),
    }
}

/// A kilogram that whirls about a pin at 100 rad/s.
pub fn force_of_a_pin() -> HardCase {
    whirling_kilogram("force_of_a_pin", method(0.9).into(), 1e-4)
}

/// The same by accuracy.
pub fn force_of_a_pin_by_radau() -> HardCase {
    whirling_kilogram("force_of_a_pin_by_radau", radau(1e-8).into(), 1e-6)
}

fn whirling_kilogram(name: &'static str, rule: Rule, bound: f64) -> HardCase {
    let (speed, step) = (100.0, 1e-4);
    let expected = speed * speed;
    let turn = (TAU / speed / step) as usize;
    let [least, most] = penalty_rod(1e8, speed, step, turn);
    assert!(most > 1.8 * expected, "{least} to {most}");
    let mut scene = Scene::new(Dimension::Planar, Vector3::zeros());
    let bob = rigid(
        Dimension::Planar,
        1.0,
        Matrix3::identity() * 0.01,
        &[[-1.0, 0.0, 0.0]],
    );
    let spin = Vector3::new(0.0, 0.0, speed);
    let drawn = Drawn {
        position: Vector3::x(),
        velocity: spin.cross(&Vector3::x()),
        angular_velocity: spin,
        ..Drawn::default()
    };
    let bob = scene.body(&bob, &drawn);
    let (ground, pin) = (scene.ground([0.0; 3]), scene.on(bob, 0));
    scene.join(&revolute(Vector3::z()), ground, pin);
    let (mut simulation, _) = scene.start(rule);
    let mut error: f64 = 0.0;
    run(&mut simulation, step * turn as f64, turn, |simulation| {
        let forces = &simulation.state().forces;
        error = error.max((forces[0].hypot(forces[1]) / expected - 1.0).abs());
    });
    HardCase {
        group: "dynamics",
        name,
        naive_method: "a penalty spring of 1e8 N/m for the joint, leapfrog",
        naive: format!(
            "its force rings between {least:.0} and {most:.0} N where it is {expected:.0} N"
        ),
        ours: "the pin's force over a turn, relative".into(),
        error: Some(Bounded {
            found: error,
            bound,
        }),
    }
}

/// Pendulums of a micrometre and of a kilometre, side by side.
pub fn micrometre_beside_kilometre() -> HardCase {
    two_pendulums("micrometre_beside_kilometre", method(0.9).into(), 200, 2e-2)
}

/// The same by accuracy.
pub fn micrometre_beside_kilometre_by_radau() -> HardCase {
    two_pendulums(
        "micrometre_beside_kilometre_by_radau",
        radau(1e-8).into(),
        1,
        1e-4,
    )
}

fn two_pendulums(name: &'static str, rule: Rule, steps: usize, bound: f64) -> HardCase {
    let (tiny, huge) = (1e-6, 1e3);
    let duration = 2e-3;
    let naive = absolute_tolerance(1e-15, tiny, 1e-6, duration / 200.0, 200);
    let naive = naive.expect("a solution");
    assert!(naive > 0.1, "{naive}");
    let mut scene = Scene::new(Dimension::Planar, Vector3::new(0.0, -GRAVITY, 0.0));
    for (length, mass) in [(tiny, 1e-15), (huge, 1e9)] {
        let bar = slender_bar(Dimension::Planar, mass, length);
        let drawn = between([0.0; 3], [length, 0.0, 0.0], [0.0; 3], [0.0; 3]);
        let bar = scene.body(&bar, &drawn);
        let (ground, pin) = (scene.ground([0.0; 3]), scene.on(bar, 0));
        scene.join(&revolute(Vector3::z()), ground, pin);
    }
    let (mut simulation, _) = scene.start(rule);
    run(&mut simulation, duration, steps, |_| {});
    let mut error: f64 = 0.0;
    for (length, place) in [tiny, huge].into_iter().zip(&simulation.state().origins) {
        let expected = runge_kutta([0.0, 0.0], duration, 20_000, |[angle, rate]| {
            [*rate, -1.5 * GRAVITY / length * angle.cos()]
        });
        // The fall of the long one is compared with itself.
        let scale = 0.5 * length * expected[0].abs().min(1.0);
        let misfit = (place.x - 0.5 * length * expected[0].cos())
            .hypot(place.y - 0.5 * length * expected[0].sin());
        error = error.max(misfit / scale);
    }
    HardCase {
        group: "dynamics",
        name,
        naive_method: "an iteration that ends at 1e-6 N and 1e-6 m",
        naive: format!("the rod of a micrometre changes its length by {:.0} %", 100.0 * naive),
        ours: "both pendulums for 2 ms, a period of the short one; places by how far they fall, from the angles' own equations".into(),
        error: Some(Bounded {
            found: error,
            bound,
        }),
    }
}

/// The rod's superelement with attachments in every direction that M_res has, rounding or not.
fn unfiltered(superelement: &Superelement) -> Superelement {
    let mut all = superelement.clone();
    let residual = &mut all.residual;
    let n = residual.mass.nrows();
    // T_r with T_rᵀ M_res T_r = I, then T_rᵀ F_res T_r diagonal.
    let mass = residual
        .mass
        .self_adjoint_eigen(Side::Lower)
        .expect("eigenvalues");
    let values = mass.S().column_vector();
    let whitened = Mat::from_fn(n, n, |i, k| mass.U()[(i, k)] / values[k].abs().sqrt());
    let flexibility = whitened.transpose() * &residual.flexibility * &whitened;
    let turned = flexibility
        .self_adjoint_eigen(Side::Lower)
        .expect("eigenvalues");
    residual.transform = &whitened * turned.U();
    residual.sigma_squared = turned.S().column_vector().iter().copied().collect();
    all
}

/// Ten of twelve modes: two of the four residual directions are rounding.
pub fn attachments_of_rounding() -> HardCase {
    let benchmark = Benchmark::first();
    let reduced = lowest(&planar_rod(4, &RodSection::default()), 10).superelement;
    assert_eq!(reduced.residual.sigma_squared.len(), 2);
    let steps = 720;
    let naive = match FlexibleBody::from_superelement(&unfiltered(&reduced), Compatibility::Strong)
    {
        Err(refused) => format!("is no body: {refused}"),
        Ok(body) => {
            let mechanism = SliderCrank {
                rod: Arc::new(body),
                ..ReducedRod::new(benchmark, 4, 10).mechanism()
            };
            let (system, state) = mechanism.system(&mechanism.rigid_start());
            let started = Simulation::start(
                system,
                state,
                patient(0.8),
                RedundantConstraints::MinimumNorm,
            );
            match started {
                Err(refused) => format!("doesn't start: {refused}"),
                Ok((mut simulation, _)) => {
                    let step = benchmark.revolution() / steps as f64;
                    let failed = fails_after(&mut simulation, step, 2 * steps);
                    format!(
                        "diverges after {} of {steps} steps a revolution",
                        failed.expect("the unfiltered body survives")
                    )
                }
            }
        }
    };
    let filtered = history(&ReducedRod::new(benchmark, 4, 10), method(0.8), steps);
    let whole = history(&ReducedRod::new(benchmark, 4, 12), method(0.8), steps);
    HardCase {
        group: "dynamics",
        name: "attachments_of_rounding",
        naive_method: "residual attachments in all four directions of a residual mass of rank two",
        naive,
        ours: "two directions are kept; deflection over two revolutions against all modes".into(),
        error: Some(Bounded {
            found: apart(&filtered, &whole),
            bound: 1e-5,
        }),
    }
}

/// The step that fails, or after which the rod is beyond all measure.
fn fails_after(simulation: &mut Simulation, step: f64, most: usize) -> Option<usize> {
    (1..=most).find(|_| {
        let failed = simulation.step(step).is_err();
        let origin = simulation.state().origins[ROD].norm();
        failed || origin.is_nan() || origin > 10.0
    })
}
