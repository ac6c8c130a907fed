//! Closed forms, unit systems and thread counts for `docs/accuracy.md`, and on what it was measured, one line of JSON per measurement.

use std::f64::consts::PI;

use dcb_formats::Component;
use dcb_reducer::Reduced;
use dcb_samples::{RodSection, UnitScale, connecting_rod, in_units};
use faer::Mat;
use serde_json::{Value, json};

use crate::dense::relative;
use crate::{lowest, parts};

/// Roots of cos β cosh β = 1.
const FREE_FREE: [f64; 3] = [
    4.730_040_744_862_704,
    7.853_204_624_095_838,
    10.995_607_838_001_671,
];

/// Command, commit, processor and compiler.
pub fn machine(command: &str) -> Value {
    let output = |program: &str, arguments: &[&str]| {
        let run = std::process::Command::new(program)
            .args(arguments)
            .output()
            .ok()
            .filter(|run| run.status.success());
        run.map_or("unknown".to_owned(), |run| {
            String::from_utf8_lossy(&run.stdout).trim().to_owned()
        })
    };
    let information = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = information
        .lines()
        .find(|line| line.starts_with("model name"))
        .and_then(|line| line.split_once(':'));
    json!({
        "kind": "machine", "command": command,
        "commit": output("git", &["rev-parse", "--short", "HEAD"]),
        "cpu": model.map_or("unknown", |(_, name)| name.trim()),
        "cores": std::thread::available_parallelism().map_or(1, usize::from),
        "rustc": output("rustc", &["--version"]),
    })
}

/// Square roots of these.
pub fn roots(eigenvalues: &[f64]) -> Vec<f64> {
    eigenvalues.iter().map(|value| value.sqrt()).collect()
}

/// Circular frequencies of the kept modes.
pub fn frequencies(reduced: &Reduced) -> Vec<f64> {
    roots(&reduced.superelement.modes.eigenvalues)
}

/// The planar rod against what beam and bar theory give in closed form.
pub fn closed_forms() -> Vec<Value> {
    const ELEMENTS: [usize; 4] = [2, 4, 8, 16];
    let rod = RodSection::default();
    let (length, bar) = (rod.length, rod.youngs_modulus * rod.area);
    let beam = rod.youngs_modulus * rod.second_moment;
    let mut lines = Vec::new();
    let mut add = |quantity: &str, exact: &str, order: Option<i32>, errors: Vec<f64>| {
        let orders: Vec<f64> = errors
            .windows(2)
            .map(|pair| (pair[0] / pair[1]).abs().log2())
            .collect();
        let orders = order.map(|_| orders);
        lines.push(json!({
            "kind": "closed forms", "quantity": quantity, "reference": exact, "elements": ELEMENTS,
            "relative_errors": errors, "orders": orders, "expected_order": order,
        }));
    };
    let spectra = ELEMENTS.map(|n| frequencies(&lowest(&parts::rod(n), 3 * n)));
    for (mode, root) in FREE_FREE.iter().enumerate() {
        let exact = (root / length).powi(2) * (beam / (rod.density * rod.area)).sqrt();
        let errors = spectra
            .iter()
            .map(|omegas| omegas[mode] / exact - 1.0)
            .collect();
        add(
            &format!("bending frequency {}", mode + 1),
            "cos β cosh β = 1",
            Some(4),
            errors,
        );
    }
    let speed = (rod.youngs_modulus / rod.density).sqrt();
    let axial = |n: usize, omegas: &[f64]| {
        // Linear elements with consistent mass say which of the frequencies is the axial one.
        let (h, angle) = (length / n as f64, PI / n as f64);
        let target = (6.0 * (1.0 - angle.cos()) / (2.0 + angle.cos())).sqrt() * speed / h;
        let nearest = omegas
            .iter()
            .min_by(|a, b| (*a - target).abs().total_cmp(&(*b - target).abs()));
        nearest.expect("modes") / (PI * speed / length) - 1.0
    };
    let errors = ELEMENTS
        .iter()
        .zip(&spectra)
        .map(|(n, omegas)| axial(*n, omegas))
        .collect();
    add("axial frequency 1", "π/L √(E/ρ)", Some(2), errors);
    let flexibility = ELEMENTS.map(|n| lowest(&parts::rod(n), 0).superelement.residual.flexibility);
    let against = |value: &dyn Fn(&Mat<f64>) -> f64, exact: f64| {
        flexibility.iter().map(|f| value(f) / exact - 1.0).collect()
    };
    add(
        "end to end, axial",
        "L/(2EA)",
        None,
        against(&|f| f[(0, 0)] - f[(0, 2)], length / (2.0 * bar)),
    );
    add(
        "at an end, axial",
        "L/(3EA)",
        Some(2),
        against(&|f| f[(0, 0)], length / (3.0 * bar)),
    );
    add(
        "at an end, across",
        "L³/(105EI)",
        Some(4),
        against(&|f| f[(1, 1)], length.powi(3) / (105.0 * beam)),
    );
    lines
}

/// The same parts in m-kg-s and in mm-t-s.
pub fn unit_systems() -> Vec<Value> {
    use dcb_samples::spatial_beam::{BeamMass, BeamTheory};
    let beam = parts::beam(8, BeamTheory::EulerBernoulli, BeamMass::Consistent);
    let named = [
        ("rotor", parts::rotor(), 10),
        ("rod, 4 elements", parts::rod(4), 8),
        ("spatial beam, 8 elements", beam, 10),
        ("connecting rod, refinement 0", connecting_rod(0), 10),
        ("connecting rod, refinement 1", connecting_rod(1), 10),
    ];
    let line = |(name, component, count): (&str, Component, usize)| {
        let (a, b) = (
            lowest(&component, count),
            lowest(&in_units(&component, &UnitScale::mm_t_s()), count),
        );
        let rank = |r: &Reduced| {
            (
                r.quality.residual_rank,
                r.quality.static_directions,
                r.quality.flexibility_rank,
            )
        };
        let equal =
            a.superelement.mode_count() == b.superelement.mode_count() && rank(&a) == rank(&b);
        let rounding = a
            .quality
            .eigenvalue_roundings
            .iter()
            .copied()
            .fold(0.0, f64::max);
        let error = if equal {
            relative(&frequencies(&b), &frequencies(&a))
        } else {
            1.0
        };
        json!({
            "kind": "unit systems", "part": name, "n_e": component.dofs.len(), "n_k": a.superelement.mode_count(),
            "relative_error": error, "bound": 1e-10_f64.max(10.0 * rounding), "equal": equal,
        })
    };
    named.into_iter().map(line).collect()
}

/// One reduction with 1, 2 and 4 threads.
pub fn thread_counts() -> Vec<Value> {
    let component = connecting_rod(0);
    let with_threads = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .expect("threads");
        pool.install(|| lowest(&component, 10))
    };
    let one = with_threads(1);
    let line = |threads: usize| {
        let other = with_threads(threads);
        let identical = one.superelement == other.superelement && one.recovery == other.recovery;
        json!({"kind": "thread counts", "part": "connecting rod, refinement 0", "threads": threads, "identical": identical})
    };
    [1, 2, 4].into_iter().map(line).collect()
}
