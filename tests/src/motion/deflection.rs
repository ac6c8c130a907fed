//! The slider-crank's deflection for `docs/accuracy.md`: convergence in the step, the figures of the literature, and the three
//! choices of compatibility. One line of JSON per measurement or curve.

use dcb_formats::scene::Scheme;
use dcb_runtime::Compatibility;
use dcb_runtime::watch::compatibility_window::WeakWindow;
use serde_json::{Value, json};

use crate::mechanism::method;
use crate::mechanism::slider_crank::ROD;
use crate::rod::deflection::{
    apart, classical_samples, history, largest, reference_history, sampled,
};
use crate::rod::reduced::{Benchmark, ReducedRod};

/// Steps a revolution of the table of convergence.
pub const STEPS: [usize; 7] = [360, 720, 1440, 3600, 7200, 14_400, 72_000];
/// Spectral radius of the methods in these tables.
const RADIUS: f64 = 0.8;
/// Points of a drawn curve: every two degrees of two revolutions.
const POINTS: usize = 360;

/// Largest error of the deflection by its largest value, 4 elements, against the reference history.
pub fn step_error(modes: usize, steps: usize) -> f64 {
    let rod = ReducedRod::new(Benchmark::first(), 4, modes);
    apart(&history(&rod, method(RADIUS), steps), &reference_history(4))
}

/// What [`step_error`] may be.
pub fn step_bound(modes: usize, steps: usize) -> Option<f64> {
    match (modes, steps) {
        (5 | 12, 720) => Some(5e-3),
        (5 | 12, 3600) => Some(1e-3),
        (12, 14_400) => Some(2e-4),
        (5, 14_400) => Some(5e-4),
        _ => None,
    }
}

/// The rod with 5 modes and attachments, and with all 12 modes, over the number of steps.
pub fn step_convergence() -> Vec<Value> {
    let line = |modes: usize, steps: usize| {
        json!({
            "kind": "steps", "modes": modes, "steps": steps,
            "error": step_error(modes, steps), "bound": step_bound(modes, steps),
        })
    };
    let all = STEPS.iter();
    all.flat_map(|steps| [5, 12].map(|modes| line(modes, *steps)))
        .collect()
}

/// A curve over the crank angle in degrees, seven digits.
fn curve(picture: &str, name: &str, every: f64, values: &[f64]) -> Value {
    let rounded: Vec<f64> = values
        .iter()
        .map(|value| format!("{value:.6e}").parse().expect("a number"))
        .collect();
    json!({"kind": "curve", "picture": picture, "name": name, "every": every, "values": rounded})
}

/// Every two degrees of two revolutions.
fn degrees(samples: usize) -> f64 {
    720.0 / samples as f64
}

/// Two elements with all their modes, both sets of data.
pub fn unreduced() -> Vec<Value> {
    let sets = [
        ("first set", Benchmark::first()),
        ("second set", Benchmark::second()),
    ];
    let one = |(name, benchmark): (&str, Benchmark)| {
        let rod = ReducedRod::new(benchmark, 2, 6);
        let values = sampled(&rod, method(0.9), 3600, POINTS);
        curve("unreduced", name, degrees(POINTS), &values)
    };
    let mut lines: Vec<Value> = sets.into_iter().map(one).collect();
    for (elements, modes) in [(2, 6), (4, 12), (8, 24)] {
        let rod = ReducedRod::new(Benchmark::first(), elements, modes);
        let found = history(&rod, method(0.9), 14_400);
        lines.push(json!({
            "kind": "unreduced", "elements": elements,
            "error": apart(&found, &reference_history(elements)), "bound": 2e-4,
        }));
    }
    lines
}

/// The classical co-rotated equations against the runtime, no mode left out.
pub fn classical() -> Vec<Value> {
    let cases = [
        ("first set, 4 elements", Benchmark::first(), 4, 12),
        ("second set, 2 elements", Benchmark::second(), 2, 6),
    ];
    let one = |(name, benchmark, elements, modes): (&str, Benchmark, usize, usize)| {
        let rod = ReducedRod::new(benchmark, elements, modes);
        let expected = classical_samples(&rod, POINTS);
        let found = sampled(&rod, method(0.9), 14_400, POINTS);
        let difference = largest_so_far(&found, &expected);
        vec![
            curve("classical", name, degrees(POINTS), &found),
            curve("classical difference", name, degrees(POINTS), &difference),
            json!({
                "kind": "classical", "case": name,
                "error": apart(&found, &expected), "bound": 4e-4,
            }),
        ]
    };
    cases.into_iter().flat_map(one).collect()
}

/// Largest difference from all 12 modes at the same steps, and from the reference history, by the largest deflection: 4 elements.
fn reduction_errors(compatibility: Compatibility, modes: usize, steps: usize) -> [f64; 2] {
    let whole = ReducedRod::new(Benchmark::first(), 4, 12);
    let rod = ReducedRod::with(Benchmark::first(), 4, modes, compatibility);
    let found = history(&rod, method(RADIUS), steps);
    [
        apart(&found, &history(&whole, method(RADIUS), steps)),
        apart(&found, &reference_history(4)),
    ]
}

/// Largest difference up to each of the samples.
fn largest_so_far(found: &[f64], expected: &[f64]) -> Vec<f64> {
    let differences = found.iter().zip(expected).map(|(a, b)| (a - b).abs());
    differences
        .scan(0.0, |most: &mut f64, difference| {
            *most = most.max(difference);
            Some(*most)
        })
        .collect()
}

/// What the second of [`reduction_errors`] may be.
const REDUCED_BOUND: f64 = 2e-3;

/// 5 and 8 modes of 4 elements, attachments as coordinates and without mass, against all modes.
pub fn reduced() -> Vec<Value> {
    let whole = ReducedRod::new(Benchmark::first(), 4, 12);
    let whole = sampled(&whole, method(RADIUS), 3600, POINTS);
    let mut lines = vec![curve("reduced", "unreduced", degrees(POINTS), &whole)];
    for modes in [5, 8] {
        for compatibility in [Compatibility::Strong, Compatibility::Static] {
            let rod = ReducedRod::with(Benchmark::first(), 4, modes, compatibility);
            let found = sampled(&rod, method(RADIUS), 3600, POINTS);
            let difference = largest_so_far(&found, &whole);
            let name = format!("{compatibility:?}, {modes} modes");
            if compatibility == Compatibility::Strong {
                lines.push(curve("reduced", &name, degrees(POINTS), &found));
            }
            lines.push(curve(
                "reduced difference",
                &name,
                degrees(POINTS),
                &difference,
            ));
            let errors = reduction_errors(compatibility, modes, 3600);
            lines.push(json!({
                "kind": "reduced", "compatibility": format!("{compatibility:?}"), "modes": modes,
                "against_all_modes": errors[0], "error": errors[1], "bound": REDUCED_BOUND,
            }));
        }
    }
    lines
}

/// Weak compatibility, 5 modes: where it can be used, its error there, and how it grows elsewhere.
pub fn weak() -> Vec<Value> {
    let rod = ReducedRod::with(Benchmark::first(), 4, 5, Compatibility::Weak);
    let mechanism = rod.mechanism();
    let simulation = mechanism.start(&mechanism.rigid_start(), method(RADIUS));
    let scheme = Scheme::generalized_alpha(RADIUS);
    let window = WeakWindow::of(simulation.system(), simulation.state(), &scheme);
    let body = window.bodies.first().expect("a weak body");
    let whole = ReducedRod::new(Benchmark::first(), 4, 12);
    let of = |modes, compatibility, steps| {
        let rod = ReducedRod::with(Benchmark::first(), 4, modes, compatibility);
        sampled(&rod, method(RADIUS), steps, 2 * steps)
    };
    let error = |modes: usize, steps: usize, bound: f64| {
        let expected = of(12, Compatibility::Strong, steps);
        let found = of(modes, Compatibility::Weak, steps);
        let twin = of(modes, Compatibility::Static, steps);
        json!({
            "kind": "weak error", "modes": modes, "steps": steps,
            "error": apart(&found, &expected), "bound": bound,
            "static_error": apart(&found, &twin), "static_bound": 1e-4,
        })
    };
    let growing = end_forces(&rod, 1000);
    vec![
        json!({
            "kind": "weak window", "sigma_min": body.sigma_min, "smallest_step": body.smallest_step,
            "steps": rod.revolution() / body.smallest_step,
            "negative_eigenvalues": window.negative_eigenvalue_count,
        }),
        error(5, 50, 2e-2),
        error(8, 50, 6e-3),
        error(5, 72, 1e-2),
        json!({"kind": "weak growth", "steps": 1000, "failed_after": growing.len() - 1}),
        curve(
            "weak",
            "unreduced",
            degrees(100),
            &of(12, Compatibility::Strong, 50),
        ),
        curve(
            "weak",
            "Weak, 5 modes",
            degrees(100),
            &of(5, Compatibility::Weak, 50),
        ),
        curve("weak growth", "Weak, 5 modes", 1.0, &growing),
        curve(
            "weak growth",
            "unreduced",
            1.0,
            &end_forces(&whole, growing.len()),
        ),
    ]
}

/// Largest force at the rod's ends, N, at the start and after every step of a thousandth of a revolution, until a step fails or
/// for `most` steps.
fn end_forces(rod: &ReducedRod, most: usize) -> Vec<f64> {
    let mechanism = rod.mechanism();
    let mut simulation = mechanism.start(&mechanism.rigid_start(), method(RADIUS));
    let mut forces = Vec::new();
    for _ in 0..most {
        simulation.refresh();
        forces.push(largest(&simulation.interface_forces(ROD)));
        if simulation.step(rod.revolution() / 1000.0).is_err() {
            break;
        }
    }
    forces
}
