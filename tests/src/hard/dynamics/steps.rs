//! Hard cases of the step: far too short, far too long, too little numerical damping, and the paper's weak form below its window. The
//! mechanism is the slider-crank of the literature.

use std::path::Path;

use dcb_formats::mesh::Dimension;
use dcb_formats::scene::Scheme;
use dcb_runtime::integrator::{Method, Rule, Tolerance};
use dcb_runtime::simulation::Simulation;
use dcb_runtime::system::builder::Drawn;
use dcb_runtime::watch::compatibility_window::WeakWindow;
use dcb_runtime::{Compatibility, Error, Scene};
use nalgebra::{Matrix3, Vector3};

use crate::assert_says;
use crate::hard::case::{Bounded, HardCase};
use crate::hard::dynamics::naive_constraints::unscaled_least_squares;
use crate::hard::dynamics::step_rules::{self, STEPS, classical};
use crate::hard::dynamics::weak_form_map::survived;
use crate::mechanism::{
    Scene as Pieces, between, method, radau, revolute, rigid, run, slender_bar, stabilized,
};
use crate::rod::deflection::{apart, history, reference_history, sampled};
use crate::rod::reduced::{Benchmark, ReducedRod};

/// The method of runs with weak compatibility, whose iteration converges slowly where steps are short.
pub fn patient(spectral_radius: f64) -> Method {
    Method {
        tolerance: Tolerance {
            relative: 1e-7,
            max_iterations: 100,
        },
        ..method(spectral_radius)
    }
}

fn rod(modes: usize) -> ReducedRod {
    ReducedRod::new(Benchmark::first(), 4, modes)
}

fn started(rod: &ReducedRod, method: Method) -> Simulation {
    let mechanism = rod.mechanism();
    mechanism.start(&mechanism.rigid_start(), method)
}

/// Steps of 1e-4 to 1e-7 s at four spectral radii: the default form against the classical equations over the same coordinates, integrated
/// explicitly; the weak form, allowed by name, at 0.8.
pub fn tiny_steps() -> HardCase {
    const INTERVAL: f64 = 2e-4;
    const SAMPLES: usize = 10;
    let benchmark = Benchmark::first();
    let reduced = rod(5);
    let equations = reduced.classical_with_attachments();
    let expected = classical(&reduced, &equations, INTERVAL, SAMPLES, 1e-6);
    let mut worst: f64 = 0.0;
    for per_interval in [2, 20, 200, 2000] {
        for radius in [0.9, 0.8, 0.5, 0.0] {
            let mut simulation = started(&reduced, method(radius));
            let mut found = vec![0.0];
            for _ in 0..SAMPLES {
                run(&mut simulation, INTERVAL, per_interval, |_| {});
                found.push(reduced.deflection_in(&mut simulation));
            }
            let error = apart(&found, &expected);
            println!("{per_interval} steps, rho {radius}: {error:.2e}");
            worst = worst.max(error);
        }
    }
    let weak = ReducedRod::with(benchmark, 4, 5, Compatibility::Weak);
    let failed: Vec<usize> = [1e-4, 1e-5, 1e-6, 1e-7]
        .into_iter()
        .map(|step| {
            let most = 20_000;
            let steps = survived(&weak, patient(0.8), step, most);
            assert!(
                steps < most,
                "the weak form survived {most} steps of {step}"
            );
            steps
        })
        .collect();
    HardCase {
        group: "dynamics",
        name: "tiny_steps",
        naive_method: "the paper's weak form, 5 modes, ρ 0.8",
        naive: format!(
            "diverges at every step: after {}, {}, {} and {} steps of 1e-4, 1e-5, 1e-6 and 1e-7 s",
            failed[0], failed[1], failed[2], failed[3]
        ),
        ours: "the default form runs at all of these steps and ρ 0.9, 0.8, 0.5, 0; deflection over 2 ms against explicit \
               extrapolation of the same model"
            .into(),
        error: Some(Bounded {
            found: worst,
            bound: 3e-2,
        }),
    }
}

/// Two revolutions at 5 to 720 steps each, and at 1e-2 and 1e-3 s: what nothing is said about is right.
pub fn long_steps() -> HardCase {
    let (mut trusted, mut untold): (f64, f64) = (0.0, 0.0);
    for finding in step_rules::step_findings(&STEPS) {
        println!("{finding:?}");
        if finding.said.is_none() {
            trusted = trusted.max(finding.error);
        }
        untold = untold.max(finding.error);
    }
    assert!(untold > 0.3, "long steps do no harm: {untold}");
    // 1e-2 s is an error, with time and advice; 1e-3 s is told.
    let mut simulation = started(&rod(5), method(0.8));
    let failed = (0..9).find_map(|_| simulation.step(1e-2).err());
    let failed = failed.expect("an error at 1e-2 s");
    assert!(!failed.is_unusable_input());
    assert_says(&failed.to_string(), &["t = ", "take a smaller step"]);
    let mut simulation = started(&rod(5), method(0.8));
    let mut error = None;
    for _ in 0..84 {
        error = simulation.step(1e-3).err();
        if error.is_some() {
            break;
        }
    }
    assert!(error.is_some() || !simulation.resolution().told().is_empty());
    HardCase {
        group: "dynamics",
        name: "long_steps",
        naive_method: "the same integrator, its numbers taken at their word",
        naive: format!(
            "deflections wrong by up to {:.0} % of the largest at 5 to 720 steps a revolution",
            100.0 * untold
        ),
        ours: "1e-2 s stops with time and advice, 1e-3 s is told with the step to take; error of the runs about which nothing is said"
            .into(),
        error: Some(Bounded {
            found: trusted,
            bound: 0.15,
        }),
    }
}

/// Without numerical damping hard constraints are weakly unstable, whatever the modes.
pub fn no_numerical_damping() -> HardCase {
    let whole = rod(12);
    let most = 20_000;
    let failed = survived(&whole, patient(1.0), whole.revolution() / 500.0, most);
    assert!(
        failed < most,
        "index 3 survived {most} steps without damping"
    );
    for radius in ["0.95", "1"] {
        let text = format!(
            r#"{{"dimension": 2, "units": {{"length": "m", "mass": "kg", "time": "s"}},
                "bodies": {{"bob": {{"rigid": {{"mass": 1, "inertia": 1, "points": {{"o": [0, 0]}}}}}}}},
                "integrator": {{"generalized_alpha": {{"step": 1e-3, "end": 1, "rho_infinity": {radius}}}}}}}"#
        );
        let refused = Scene::parse(&text, Path::new("scene.json")).expect_err("a refusal");
        assert!(refused.is_unusable_input());
        assert_says(
            &refused.to_string(),
            &[
                "rho_infinity",
                radius,
                "weakly unstable",
                "at most 0.9",
                "stabilized-index-2",
            ],
        );
    }
    // Stabilized index 2 at the same steps for twice as many, and its deflection.
    let steps = survived(&whole, undamped(), whole.revolution() / 500.0, 2 * most);
    assert_eq!(
        steps,
        2 * most,
        "stabilized index 2 fails after {steps} steps"
    );
    let error = apart(&history(&whole, undamped(), 3600), &reference_history(4));
    HardCase {
        group: "dynamics",
        name: "no_numerical_damping",
        naive_method: "the trapezoidal rule (ρ 1) on positions, all modes",
        naive: format!("diverges after {failed} steps of 500 a revolution"),
        ours: "ρ above 0.9 is refused by name in index 3; stabilized index 2 runs at ρ 1, 40000 such steps, and follows the reference \
               over two revolutions of 3600"
            .into(),
        error: Some(Bounded {
            found: error,
            bound: 5e-3,
        }),
    }
}

fn undamped() -> Method {
    Method {
        tolerance: Tolerance {
            relative: 1e-7,
            max_iterations: 100,
        },
        ..stabilized(1.0)
    }
}

/// A thousand steps a revolution with 5 modes.
pub fn weak_form_below_its_window() -> HardCase {
    let benchmark = Benchmark::first();
    let step = benchmark.revolution() / 1000.0;
    let weak = ReducedRod::with(benchmark, 4, 5, Compatibility::Weak);
    let failed = survived(&weak, patient(0.8), step, 2000);
    assert!(failed < 100, "the weak form survived {failed} steps");
    let simulation = started(&weak, patient(0.8));
    let scheme = Scheme::generalized_alpha(0.8);
    let window = WeakWindow::of(simulation.system(), simulation.state(), &scheme);
    let refused = window.check(step).expect_err("a refusal");
    assert!(matches!(refused, Error::WeakUnstable { .. }));
    assert_says(
        &refused.to_string(),
        &["\"rod\"", "take steps above", "strong or static"],
    );
    let steps = 1008;
    let found = sampled(&rod(5), method(0.8), steps, 72);
    let error = apart(&found, &reference_history(4));
    HardCase {
        group: "dynamics",
        name: "weak_form_below_its_window",
        naive_method: "the paper's weak form, allowed by name",
        naive: format!("diverges after {failed} of 1000 steps a revolution"),
        ours: "refused with the smallest step that is stable; the default form at such steps, two revolutions".into(),
        error: Some(Bounded {
            found: error,
            bound: 5e-3,
        }),
    }
}

/// The bar on its pin a kilometre away, steps or looks of 1e-7 s: largest relative error of the pin's force, and of its rounding.
fn spinning_far_away(rule: Rule) -> (f64, f64) {
    let mut scene = Pieces::new(Dimension::Planar, Vector3::new(0.0, -9.81, 0.0));
    let bar = slender_bar(Dimension::Planar, 1.0, 1.0);
    let far = 1e3;
    let drawn = between(
        [far, 0.0, 0.0],
        [far + 1.0, 0.0, 0.0],
        [0.0, 5.0, 0.0],
        [0.0, 0.0, 10.0],
    );
    let bar = scene.body(&bar, &drawn);
    let (ground, pin) = (scene.ground([far, 0.0, 0.0]), scene.on(bar, 0));
    scene.join(&revolute(Vector3::z()), ground, pin);
    let (mut simulation, _) = scene.start(rule);
    // A bar about its end: φ'' = -1.5 g/L cos φ, to the second order of 20 µs; along it m (L/2 φ'² - g sin φ), across a quarter of the weight.
    let expected = |time: f64| {
        let (angle, rate) = (
            10.0 * time - 0.75 * 9.81 * time * time,
            10.0 - 1.5 * 9.81 * time,
        );
        (0.25 * 9.81 * angle.cos()).hypot(0.5 * rate * rate - 9.81 * angle.sin())
    };
    let (mut worst, mut rounding): (f64, f64) = (0.0, 0.0);
    for _ in 0..200 {
        simulation.step(1e-7).expect("a step");
        let force = simulation.state().forces[0].hypot(simulation.state().forces[1]);
        let expected = expected(simulation.state().time);
        worst = worst.max((force / expected - 1.0).abs());
        rounding = rounding.max(simulation.rounding_of_forces(1e-7));
    }
    (worst, rounding)
}

/// What comes of constraints on positions alone.
fn rounded_positions() -> String {
    let (naive, rounding) = spinning_far_away(method(0.8).into());
    assert!(naive > 0.1, "constraints on positions are right: {naive}");
    // What `simulate` tells beyond a hundredth.
    assert!(rounding > 1e-2, "nothing is told: {rounding}");
    format!("force of the pin wrong by up to {naive:.1e} of itself")
}

/// A bar that spins on a pin a kilometre from the world's origin: at steps of 1e-7 s the rounding of positions is all that
/// the forces of constraints on positions consist of.
pub fn forces_far_from_the_origin() -> HardCase {
    let (error, _) = spinning_far_away(stabilized(0.8).into());
    HardCase {
        group: "dynamics",
        name: "forces_far_from_the_origin",
        naive_method: "constraints on positions alone (index 3), steps of 1e-7 s, 1 km from the origin",
        naive: rounded_positions(),
        ours: "told as rounding, with stabilized index 2 among the remedies; its force there"
            .into(),
        error: Some(Bounded {
            found: error,
            bound: 1e-3,
        }),
    }
}

/// The same by accuracy: forces come from accelerations, not from differences of places.
pub fn forces_far_from_the_origin_by_radau() -> HardCase {
    let (error, _) = spinning_far_away(radau(1e-8).into());
    HardCase {
        group: "dynamics",
        name: "forces_far_from_the_origin_by_radau",
        naive_method: "constraints on positions alone (index 3), steps of 1e-7 s, 1 km from the origin",
        naive: rounded_positions(),
        ours: "200 looks 1e-7 s apart; force of the pin".into(),
        error: Some(Bounded {
            found: error,
            bound: 1e-9,
        }),
    }
}

/// A bob that passes its lowest point, at steps of 1e-6 s: entries of the matrix of Newton's iteration are 24 decades apart.
pub fn unscaled_newton_matrix() -> HardCase {
    passing_bob(
        "unscaled_newton_matrix",
        method(0.8).into(),
        1000,
        "steps of 1e-6 s on positions alone; force of the pin, relative",
        1e-3,
    )
}

/// The same by accuracy.
pub fn unscaled_newton_matrix_by_radau() -> HardCase {
    passing_bob(
        "unscaled_newton_matrix_by_radau",
        radau(1e-8).into(),
        1,
        "1 ms by accuracy; force of the pin, relative",
        1e-6,
    )
}

fn passing_bob(name: &'static str, rule: Rule, looks: usize, ours: &str, bound: f64) -> HardCase {
    let (step, steps) = (1e-6, 1000);
    let naive = unscaled_least_squares(step, steps);
    // The angle is t to its third order: T = g cos φ + v², v² = 1 - 2 g (1 - cos φ).
    let angle = step * steps as f64;
    let expected = 9.81 * angle.cos() + 1.0 - 2.0 * 9.81 * (1.0 - angle.cos());
    assert!((naive / expected - 1.0).abs() > 0.5, "{naive}");
    let mut scene = Pieces::new(Dimension::Planar, Vector3::new(0.0, -9.81, 0.0));
    let bob = rigid(
        Dimension::Planar,
        1.0,
        Matrix3::identity() * 1e-6,
        &[[0.0, 1.0, 0.0]],
    );
    let drawn = Drawn {
        position: -Vector3::y(),
        velocity: Vector3::x(),
        angular_velocity: Vector3::z(),
        ..Drawn::default()
    };
    let bob = scene.body(&bob, &drawn);
    let (ground, pin) = (scene.ground([0.0; 3]), scene.on(bob, 0));
    scene.join(&revolute(Vector3::z()), ground, pin);
    let (mut simulation, _) = scene.start(rule);
    run(&mut simulation, angle, looks, |_| {});
    let force = simulation.state().forces[0].hypot(simulation.state().forces[1]);
    HardCase {
        group: "dynamics",
        name,
        naive_method: "Newton's matrix as it stands, least squares with the usual cut at rounding",
        naive: format!(
            "the rod pulls with {naive:.2} N in place of {expected:.2} N: the constraint is cut off"
        ),
        ours: ours.into(),
        error: Some(Bounded {
            found: (force / expected - 1.0).abs(),
            bound,
        }),
    }
}
