//! Hard cases of scale: masses, stiffnesses and sizes that are many decades apart in one mechanism, and residual attachments that rounding
//! made.

use std::f64::consts::TAU;
use std::sync::Arc;

use dcb_formats::SparseMatrix;
use dcb_formats::mesh::Dimension;
use dcb_formats::scene::RedundantConstraints;
use dcb_formats::superelement::Superelement;
use dcb_runtime::force_law::{Characteristic, Law};
use dcb_runtime::measure::{Displacement, Measure};
use dcb_runtime::simulation::Simulation;
use dcb_runtime::system::builder::Drawn;
use dcb_runtime::{Compatibility, FlexibleBody};
use dcb_samples::{RodSection, planar_rod};
use faer::{Mat, Side};
use nalgebra::{DMatrix, DVector, Matrix3, Unit, Vector3};

use crate::assert_says;
use crate::dense::dense;
use crate::hard::case::{Bounded, HardCase};
use crate::hard::dynamics::naive_constraints::{
    absolute_tolerance, explicit_springs, penalty_rod, sequential_impulses,
};
use crate::hard::dynamics::steps::patient;
use crate::lowest;
use crate::mechanism::rigid_benchmarks::GRAVITY;
use crate::mechanism::slider_crank::{ROD, SliderCrank};
use crate::mechanism::{
    Scene, between, method, revolute, rigid, run, runge_kutta, slender_bar, start,
};
use crate::rod::deflection::{apart, history};
use crate::rod::reduced::{Benchmark, ReducedRod};

/// A tonne hangs on a bar of ten milligrams.
pub fn mass_ratio_1e8() -> HardCase {
    let (light, heavy) = (1e-5, 1e3);
    let naive = sequential_impulses(&[light, heavy], 100, 1e-3, 1000);
    assert!(naive > 0.05, "the string stretches by {naive} only");
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
    let (system, state) = scene.finish();
    let torque = GRAVITY * (heavy + 0.5 * light) / (heavy + light / 3.0);
    let expected = runge_kutta([0.0, 0.0], 2.0, 20_000, |[angle, rate]| {
        [*rate, -torque * angle.cos()]
    });
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
        naive: format!("the string of 1 m stretches by {:.0} %", 100.0 * naive),
        ours: format!(
            "a tonne on a bar of 10 mg for 2 s in steps of {step:.0e} s (stopped by name: {failed:?}); place, m, from the angle's own equation"
        ),
        error: Some(Bounded {
            found: (place.x - expected[0].cos()).hypot(place.y - expected[0].sin()),
            bound: 1e-4,
        }),
    }
}

/// A block on 100 N/m one way and 1e12 N/m the other.
pub fn stiffness_ratio_1e10() -> HardCase {
    let (soft, stiff) = (100.0, 1e12);
    let failed = explicit_springs([soft, stiff], 1e-3, 1000).expect("leapfrog fails");
    let mut scene = Scene::new(Dimension::Planar, Vector3::new(0.0, -GRAVITY, 0.0));
    let block = rigid(
        Dimension::Planar,
        1.0,
        Matrix3::identity() * 0.01,
        &[[0.0; 3]],
    );
    let drawn = Drawn {
        position: Vector3::new(0.01, 0.0, 0.0),
        ..Drawn::default()
    };
    let block = scene.body(&block, &drawn);
    let (ground, center) = (scene.ground([0.0; 3]), scene.on(block, 0));
    let laws = [
        linear(Vector3::x_axis(), soft),
        linear(Vector3::y_axis(), stiff),
    ];
    scene.builder().spring("bushing", ground, center, laws);
    let (mut simulation, _) = scene.start(method(0.8));
    let mut error: f64 = 0.0;
    run(&mut simulation, 1.0, 1000, |simulation| {
        let state = simulation.state();
        let expected = 0.01 * (10.0 * state.time).cos();
        error = error.max((state.origins[0].x - expected).abs() / 0.01);
    });
    // The stiff direction has rung out.
    error = error.max((simulation.state().forces[1].abs() / GRAVITY - 1.0).abs());
    HardCase {
        group: "dynamics",
        name: "stiffness_ratio_1e10",
        naive_method: "leapfrog at the same step of 1 ms",
        naive: format!("the block is a metre away after {failed} steps"),
        ours: "place over 1 s from the cosine, and the force of the stiff direction from the weight, relative".into(),
        error: Some(Bounded {
            found: error,
            bound: 1e-3,
        }),
    }
}

/// A steel rod on a bushing of 100 N/m at one end and 1e12 N/m at the other, let go under its weight.
pub fn bushing_on_steel() -> HardCase {
    let (stiffness, step) = ([100.0, 1e12], 1e-4);
    let component = planar_rod(4, &RodSection::default());
    let square = |matrix: &SparseMatrix| {
        let full = dense(matrix);
        DMatrix::from_fn(full.nrows(), full.ncols(), |i, j| full[(i, j)])
    };
    let (mut k, m) = (square(&component.stiffness), square(&component.mass));
    let n = m.nrows();
    // ux uy rz at five nodes; the ends are the first and the last.
    for (stiffness, first) in stiffness.into_iter().zip([0, n - 3]) {
        k[(first, first)] += stiffness;
        k[(first + 1, first + 1)] += stiffness;
    }
    let upward = DVector::from_fn(n, |i, _| if i % 3 == 1 { 1.0 } else { 0.0 });
    let weight = -GRAVITY * (&m * upward);
    let factor = m.clone().cholesky().expect("a mass matrix");

    let (mut u, mut v) = (DVector::zeros(n), DVector::zeros(n));
    let failed = (1..=1000).find(|_| {
        v += step * factor.solve(&(&weight - &k * &u));
        u += step * &v;
        u.amax() > 1.0
    });
    let failed = failed.expect("leapfrog fails");

    // u = Σ φ (φᵀ f / ω²) (1 - cos ω t)
    let inverse = factor.l().try_inverse().expect("an inverse");
    let modes = (&inverse * &k * inverse.transpose()).symmetric_eigen();
    let shapes = inverse.transpose() * &modes.eigenvectors;
    let loads = shapes.transpose() * &weight;
    let soft_end = |time: f64| -> f64 {
        let terms = modes.eigenvalues.iter().enumerate();
        let term = |(j, square): (usize, &f64)| {
            shapes[(1, j)] * loads[j] / square * (1.0 - (square.sqrt() * time).cos())
        };
        terms.map(term).sum()
    };

    let rod = ReducedRod::new(Benchmark::first(), 4, 12);
    let mut scene = Scene::new(Dimension::Planar, Vector3::new(0.0, -GRAVITY, 0.0));
    let body = scene.body(&rod.body, &Drawn::default());
    for (end, slope) in stiffness.into_iter().enumerate() {
        let x = RodSection::default().length * end as f64;
        let (ground, at) = (scene.ground([x, 0.0, 0.0]), scene.on(body, end));
        let laws = [Vector3::x_axis(), Vector3::y_axis()].map(|along| linear(along, slope));
        scene
            .builder()
            .spring(&format!("bushing {end}"), ground, at, laws);
    }
    let soft = scene.on(body, 0);
    let (mut simulation, _) = scene.start(method(0.8));
    let (mut error, mut largest): (f64, f64) = (0.0, 0.0);
    run(
        &mut simulation,
        0.1,
        (0.1 / step).round() as usize,
        |simulation| {
            let expected = soft_end(simulation.state().time);
            let found = simulation.refresh().motions[soft].position.y;
            error = error.max((found - expected).abs());
            largest = largest.max(expected.abs());
        },
    );
    HardCase {
        group: "dynamics",
        name: "bushing_on_steel",
        naive_method: "leapfrog on the finite elements at the same step of 0.1 ms",
        naive: format!("an end is a metre away after {failed} steps"),
        ours: "the soft end over a period of the swing, from the modes of the linear finite elements with their springs, by its largest".into(),
        error: Some(Bounded {
            found: error / largest,
            bound: 3e-3,
        }),
    }
}

fn linear(direction: Unit<Vector3<f64>>, slope: f64) -> (Measure, Law) {
    let law = Law::new(
        0.0,
        Characteristic::Linear { slope },
        Characteristic::Linear { slope: 0.0 },
    );
    let measure = Measure::Displacement(Displacement { direction });
    (measure, law.expect("a law"))
}

/// A kilogram that whirls about a pin at 100 rad/s.
pub fn force_of_a_pin() -> HardCase {
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
    let (mut simulation, _) = scene.start(method(0.9));
    let mut error: f64 = 0.0;
    run(&mut simulation, step * turn as f64, turn, |simulation| {
        let forces = &simulation.state().forces;
        error = error.max((forces[0].hypot(forces[1]) / expected - 1.0).abs());
    });
    HardCase {
        group: "dynamics",
        name: "force_of_a_pin",
        naive_method: "a penalty spring of 1e8 N/m for the joint, leapfrog",
        naive: format!(
            "its force rings between {least:.0} and {most:.0} N where it is {expected:.0} N"
        ),
        ours: "the pin's force over a turn, relative".into(),
        error: Some(Bounded {
            found: error,
            bound: 1e-4,
        }),
    }
}

/// Pendulums of a micrometre and of a kilometre, side by side.
pub fn micrometre_beside_kilometre() -> HardCase {
    let (tiny, huge) = (1e-6, 1e3);
    let (duration, steps) = (2e-3, 200);
    let naive = absolute_tolerance(1e-15, tiny, 1e-6, duration / steps as f64, steps);
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
    let (mut simulation, _) = scene.start(method(0.9));
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
        name: "micrometre_beside_kilometre",
        naive_method: "an iteration that ends at 1e-6 N and 1e-6 m",
        naive: format!("the rod of a micrometre changes its length by {:.0} %", 100.0 * naive),
        ours: "both pendulums for 2 ms, a period of the short one; places by how far they fall, from the angles' own equations".into(),
        error: Some(Bounded {
            found: error,
            bound: 2e-2,
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
