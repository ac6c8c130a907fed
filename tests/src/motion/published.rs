//! Published solutions, closed forms and conserved quantities for `docs/accuracy.md`, one line of JSON per measurement.

use serde_json::{Value, json};

use crate::mechanism::closed_form_motions::{
    cantilever, free_body_drifts, spun_bar, weight_deflections,
};
use crate::mechanism::governor::governor_errors;
use crate::mechanism::ivp_slider_crank::{
    Answer, PUBLISHED, PUBLISHED_FORCES, classical, element_errors, relative, simulated,
    sine_samples,
};
use crate::mechanism::rigid_benchmarks::{
    SUBMITTED_PLACES, bricard_errors, chain_error, double_four_bar_errors, pendulum_errors,
    slider_places,
};
use crate::mechanism::{extrapolated, method, stabilized};

/// What the test set publishes.
const QUANTITIES: [&str; 9] = ["φ2", "x3", "q1", "q2", "q3", "q4", "λ1", "λ2", "λ3"];
/// Bounds of the runtime at 200000 steps, and of the classical equations.
const BOUNDS: [f64; 9] = [2e-9, 5e-9, 3e-7, 3e-6, 2e-5, 5e-5, 2e-3, 2e-3, 2e-3];
const CLASSICAL_BOUNDS: [f64; 9] = [1e-10, 2e-9, 1e-9, 1e-9, 1e-9, 1e-9, 1e-8, 1e-8, 1e-8];

fn all(answer: &Answer) -> Vec<f64> {
    answer
        .positions
        .iter()
        .chain(&answer.forces)
        .copied()
        .collect()
}

/// The set's own mass: published, by the classical equations, by the runtime; and the consistent mass.
pub fn test_set() -> Vec<Value> {
    let published: Vec<f64> = PUBLISHED.into_iter().chain(PUBLISHED_FORCES).collect();
    let classical_own = all(&classical(1.0));
    let runtime = all(&simulated(1.0, method(0.9), 200_000));
    let consistent = all(&classical(1.0 / 15.0));
    let runtime_consistent = all(&simulated(1.0 / 15.0, method(0.9), 200_000));
    let own = relative(&runtime, &published);
    let by_classical = relative(&classical_own, &published);
    let corrected = relative(&runtime_consistent, &consistent);
    let line = |k: usize| {
        json!({
            "kind": "test set", "quantity": QUANTITIES[k], "published": published[k], "found": runtime[k],
            "error": own[k], "bound": BOUNDS[k],
            "classical_error": by_classical[k], "classical_bound": CLASSICAL_BOUNDS[k],
            "consistent": consistent[k], "consistent_error": corrected[k],
        })
    };
    (0..9).map(line).collect()
}

/// The test set's rod in finite elements against two sines and a quadratic, both from an undeformed start.
pub fn elements() -> Vec<Value> {
    let expected = sine_samples();
    let line = |(elements, modes, bound): (usize, usize, f64)| {
        let [deflection, slider] = element_errors(&expected, elements, modes);
        json!({
            "kind": "element rod", "elements": elements, "modes": modes,
            "error": deflection, "bound": bound, "slider_error": slider, "slider_bound": 2e-4,
        })
    };
    [(2, 1, 0.1), (2, 6, 0.1), (4, 6, 0.012), (8, 8, 0.008)]
        .map(line)
        .to_vec()
}

/// One line of the tables of mechanisms.
fn finding(
    kind: &str,
    problem: &str,
    quantity: &str,
    against: &str,
    steps: &str,
    (error, bound): (f64, f64),
) -> Value {
    json!({
        "kind": kind, "problem": problem, "quantity": quantity, "against": against, "steps": steps,
        "error": error, "bound": bound,
    })
}

/// The IFToMM library's rigid mechanisms.
pub fn rigid() -> Vec<Value> {
    const LAGRANGE: &str = "Lagrange's equations";
    let mut lines = Vec::new();
    let mut add = |problem: &str, quantity: &str, against: &str, steps: &str, pair: (f64, f64)| {
        lines.push(finding("rigid", problem, quantity, against, steps, pair));
    };
    let (drift, place) = pendulum_errors(20_000);
    let steps = "0.5 ms, 10 s";
    add(
        "pendulum (A01)",
        "energy, J",
        "asked for: 5e-5",
        steps,
        (drift, 5e-5),
    );
    add("pendulum (A01)", "place, m", LAGRANGE, steps, (place, 1e-4));
    for (name, method) in [
        ("index 3", method(0.95)),
        ("stabilized index 2", stabilized(0.95)),
    ] {
        let (place, drift) = double_four_bar_errors(method, 10_000);
        let problem = format!("double four-bar (A02), {name}");
        let against = "equation of the angle";
        add(
            &problem,
            "place of the first head, m",
            against,
            "1 ms, 10 s",
            (place, 1e-4),
        );
        add(
            &problem,
            "energy, J",
            "conserved",
            "1 ms, 10 s",
            (drift, 2e-3),
        );
        let (drift, apart) = bricard_errors(method);
        let problem = format!("Bricard (A04), {name}");
        add(
            &problem,
            "energy, J",
            "conserved",
            "1 ms, 10 s",
            (drift, 1e-2),
        );
        let against = "the loop without redundancy";
        add(&problem, "places, m", against, "1 ms, 10 s", (apart, 1e-7));
    }
    for duration in [1.0, 4.0] {
        let [place, spin] = governor_errors(duration, 2000.0);
        let steps = format!("0.5 ms, {duration} s");
        add(
            "flyball governor (A05)",
            "slider, m",
            LAGRANGE,
            &steps,
            (place, 1e-4),
        );
        add(
            "flyball governor (A05)",
            "spin, rad/s",
            LAGRANGE,
            &steps,
            (spin, 1e-4),
        );
    }
    let runs = [2000, 4000].map(slider_places);
    let limit = |second: usize| extrapolated(runs[0].0[second], runs[1].0[second]);
    let worst = |error: &dyn Fn(usize) -> f64| (0..5).map(error).fold(0.0, f64::max);
    let problem = "spatial slider-crank";
    let against = "submitted solution, 1 to 5 s";
    let from_published = worst(&|k| (limit(k) - SUBMITTED_PLACES[k]).abs());
    add(
        problem,
        "slider, limit of small steps, m",
        against,
        "0.5, 0.25 ms",
        (from_published, 5e-5),
    );
    let of_step = worst(&|k| (runs[1].0[k] - limit(k)).abs());
    add(
        problem,
        "slider, m",
        "its limit of small steps",
        "0.25 ms, 5 s",
        (of_step, 2e-5),
    );
    add(
        problem,
        "energy, J",
        "conserved",
        "0.25 ms, 5 s",
        (runs[1].1, 2e-6),
    );
    add(
        "chain of ten bars",
        "energy, J",
        "conserved",
        "0.2 ms, 0.8 s",
        (chain_error(4000), 1e-4),
    );
    lines
}

/// Flexible bodies in motions with a closed form.
pub fn flexible() -> Vec<Value> {
    let mut lines = Vec::new();
    let mut add = |problem: &str, quantity: &str, against: &str, steps: &str, pair: (f64, f64)| {
        lines.push(finding("flexible", problem, quantity, against, steps, pair));
    };
    let (_, worst) = spun_bar();
    let against = "ρω²/(2E) (xL² - x³/3)";
    add(
        "bar spun about its end",
        "stretch, by the tip's",
        against,
        "0.5 ms, 3 s",
        (worst, 2e-3),
    );
    let (shortening, sag) = weight_deflections();
    let steps = "1 ms, 3 s";
    for degrees in [0.0_f64, 30.0, 75.0, 120.0] {
        let angle = degrees.to_radians();
        let (_, across) = cantilever(angle);
        let problem = format!("cantilever turned by {degrees}°");
        let of_sag = (across + sag * angle.cos()).abs() / sag;
        let against = "ρAgL⁴ cos/(8EI)";
        add(
            &problem,
            "sag, by the horizontal's",
            against,
            steps,
            (of_sag, 5e-4),
        );
    }
    let (along, _) = cantilever(std::f64::consts::FRAC_PI_2);
    let of_length = (along + shortening).abs() / shortening;
    add(
        "standing cantilever",
        "shortening",
        "ρgL²/(2E)",
        steps,
        (of_length, 5e-3),
    );
    let drifts = free_body_drifts(8000);
    let quantities = ["momentum", "angular momentum", "energy"];
    for (k, bound) in [1e-11, 1e-4, 1e-4].into_iter().enumerate() {
        add(
            "free soft box",
            quantities[k],
            "conserved",
            "25 µs, 0.2 s",
            (drifts[k], bound),
        );
    }
    lines
}
