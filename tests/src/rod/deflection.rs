//! Histories of the deflection of the slider-crank's rod, and how far they are apart.

use dcb_runtime::integrator::Method;

use crate::mechanism::run;
use crate::reference::{numbers, reference};
use crate::rod::reduced::ReducedRod;

/// Deflections at `samples + 1` equal crank angles of two revolutions, the start included, with `steps` steps a revolution.
/// `samples` divides twice the steps.
pub fn sampled(rod: &ReducedRod, method: Method, steps: usize, samples: usize) -> Vec<f64> {
    let mechanism = rod.mechanism();
    let mut simulation = mechanism.start(&mechanism.rigid_start(), method);
    let every = 2 * steps / samples;
    assert!(every * samples == 2 * steps);
    let interval = 2.0 * rod.revolution() / samples as f64;
    let mut deflections = vec![rod.deflection_in(&mut simulation)];
    for _ in 0..samples {
        run(&mut simulation, interval, every, |_| {});
        deflections.push(rod.deflection_in(&mut simulation));
    }
    deflections
}

/// Every 10 degrees.
pub fn history(rod: &ReducedRod, method: Method, steps: usize) -> Vec<f64> {
    sampled(rod, method, steps, 72)
}

/// Deflections at `samples + 1` equal crank angles of two revolutions by the classical co-rotated equations, all modes kept.
pub fn classical_samples(rod: &ReducedRod, samples: usize) -> Vec<f64> {
    let classical = rod.classical();
    let start = rod.mechanism().rigid_start();
    let modes = start.y.len();
    let mut motion = classical.start(&start.y, &start.rates, start.spin);
    let mut deflections = vec![0.0];
    let parts = 14_400 / samples;
    for _ in 0..samples {
        let interval = 2.0 * rod.revolution() / samples as f64;
        classical.advance(&mut motion, interval / parts as f64, parts);
        deflections.push(rod.deflection(motion.position.rows(3, modes).as_slice()));
    }
    deflections
}

/// The history of an independent program, every 10 degrees, for 2, 4 or 8 elements and all modes.
pub fn reference_history(elements: usize) -> Vec<f64> {
    numbers(&reference("ref_planar.json")["deflection"][elements.to_string()]["defl"])
}

/// Largest size.
pub fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |most, value| value.abs().max(most))
}

/// Largest difference by the largest value.
pub fn apart(found: &[f64], expected: &[f64]) -> f64 {
    assert_eq!(found.len(), expected.len());
    assert!(found.iter().all(|value| value.is_finite()));
    let differences: Vec<f64> = found.iter().zip(expected).map(|(a, b)| a - b).collect();
    largest(&differences) / largest(expected)
}
