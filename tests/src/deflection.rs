//! Histories of the deflection of the slider-crank's rod, and how far they are apart.

use dcb_runtime::Error;
use dcb_runtime::integrator::newton::Method;

use crate::reduced_rod::ReducedRod;
use crate::reference::{numbers, reference};

/// Deflections at `samples + 1` equal crank angles of two revolutions, the start included, with `steps` steps a revolution; those
/// up to the failing step if one fails. `samples` divides twice the steps.
pub fn until_failure(
    rod: &ReducedRod,
    method: Method,
    steps: usize,
    samples: usize,
) -> (Vec<f64>, Option<Error>) {
    let mechanism = rod.mechanism();
    let mut simulation = mechanism.start(&mechanism.rigid_start(), method);
    let every = 2 * steps / samples;
    assert!(every * samples == 2 * steps);
    let mut deflections = vec![rod.deflection_in(&mut simulation)];
    for step in 1..=2 * steps {
        if let Err(error) = simulation.step(rod.revolution() / steps as f64) {
            return (deflections, Some(error));
        }
        if step % every == 0 {
            deflections.push(rod.deflection_in(&mut simulation));
        }
    }
    (deflections, None)
}

/// The same where no step fails.
pub fn sampled(rod: &ReducedRod, method: Method, steps: usize, samples: usize) -> Vec<f64> {
    match until_failure(rod, method, steps, samples) {
        (deflections, None) => deflections,
        (_, Some(error)) => panic!("{error}"),
    }
}

/// Every 10 degrees.
pub fn history(rod: &ReducedRod, method: Method, steps: usize) -> Vec<f64> {
    sampled(rod, method, steps, 72)
}

/// Every 10 degrees by the classical co-rotated equations, for all modes kept.
pub fn classical_history(rod: &ReducedRod) -> Vec<f64> {
    let classical = rod.classical();
    let start = rod.mechanism().rigid_start();
    let modes = start.y.len();
    let mut motion = classical.start(&start.y, &start.rates, start.spin);
    let mut deflections = vec![0.0];
    for _ in 0..72 {
        classical.advance(&mut motion, rod.revolution() / 36.0 / 200.0, 200);
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
