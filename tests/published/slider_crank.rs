//! The slider-crank with a round flexible rod that Jonker, Meijaard, Schwab and others use: deflection of the rod's middle from the
//! chord over the crank angle, in linear elasticity, from the rod's rigid start.
//!
//! Reference histories: `ref_planar.json`, an independent program's, at 144000 steps a revolution. Where two programs are
//! compared, "relative" means by the largest deflection.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use std::f64::consts::TAU;

use dcb_runtime::integrator::Method;
use dcb_tests::mechanism::{method, run};
use dcb_tests::reduced_rod::{Benchmark, ReducedRod};
use dcb_tests::reference::{numbers, reference};
use dcb_tests::slider_crank::rod_coordinates;

/// Deflections every 10 degrees of two revolutions, the start included.
fn history(rod: &ReducedRod, revolution: f64, method: Method, steps: usize) -> Vec<f64> {
    let mechanism = rod.mechanism();
    let mut simulation = mechanism.start(&mechanism.rigid_start(), method);
    let mut deflections = vec![0.0];
    for _ in 0..72 {
        run(&mut simulation, revolution / 36.0, steps / 36, |_| {});
        deflections.push(rod.deflection(rod_coordinates(&simulation)));
    }
    deflections
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |most, value| value.abs().max(most))
}

/// Largest difference by the largest value.
fn apart(found: &[f64], expected: &[f64]) -> f64 {
    assert_eq!(found.len(), expected.len());
    let differences: Vec<f64> = found.iter().zip(expected).map(|(a, b)| a - b).collect();
    largest(&differences) / largest(expected)
}

/// All modes of 2, 4 and 8 elements against the reference (Figs 3 and 4, first set of data).
#[test]
fn unreduced_rods_follow_the_reference() {
    let file = reference("ref_planar.json");
    for (elements, modes) in [(2, 6), (4, 12), (8, 24)] {
        let expected = numbers(&file["deflection"][elements.to_string()]["defl"]);
        let benchmark = Benchmark::first();
        let rod = ReducedRod::new(benchmark, elements, modes);
        assert_eq!(rod.body.coordinate_count(), modes);
        let found = history(&rod, benchmark.revolution(), method(0.9), 14_400);
        let difference = apart(&found, &expected);
        println!("{elements} elements: {difference:.2e}");
        assert!(difference < 2e-4);
    }
}

/// The error of the step with rho 0.8: what users must expect of coarse steps.
#[test]
fn steps_converge_to_the_reference() {
    let expected = numbers(&reference("ref_planar.json")["deflection"]["4"]["defl"]);
    let benchmark = Benchmark::first();
    let rod = ReducedRod::new(benchmark, 4, 12);
    let errors = [720, 3600, 14_400].map(|steps| {
        let found = history(&rod, benchmark.revolution(), method(0.8), steps);
        apart(&found, &expected)
    });
    println!("{errors:?}");
    assert!((2e-3..5e-3).contains(&errors[0]));
    assert!(errors[1] < 1e-3);
    assert!(errors[2] < 2e-4);
}

/// Modes and attachments against all modes, 4 elements (Figs 6 and 7). The paper's bounds are 1 % with 5 modes and better with 8.
#[test]
fn reduced_rods_follow_the_unreduced() {
    let benchmark = Benchmark::first();
    for (steps, limits) in [(3600, [5e-3, 1e-3, 1e-4]), (14_400, [1e-3, 5e-4, 2e-5])] {
        let whole = ReducedRod::new(benchmark, 4, 12);
        let whole = history(&whole, benchmark.revolution(), method(0.8), steps);
        for (modes, limit) in [1, 5, 8].into_iter().zip(limits) {
            let rod = ReducedRod::new(benchmark, 4, modes);
            let found = history(&rod, benchmark.revolution(), method(0.8), steps);
            let difference = apart(&found, &whole);
            println!("{steps} steps, {modes} modes: {difference:.2e}");
            assert!(difference < limit);
        }
    }
}

/// The classical co-rotated equations with joint forces as unknowns, integrated explicitly, against the runtime and the reference
/// (Fig 5), for both sets of data.
#[test]
fn classical_equations_have_the_same_deflection() {
    for (benchmark, elements, modes) in [(Benchmark::first(), 4, 12), (Benchmark::second(), 2, 6)] {
        let rod = ReducedRod::new(benchmark, elements, modes);
        let found = history(&rod, benchmark.revolution(), method(0.9), 14_400);
        let classical = rod.classical();
        let start = rod.mechanism().rigid_start();
        let mut motion = classical.start(&start.y, &start.rates, start.spin);
        let mut expected = vec![0.0];
        for _ in 0..72 {
            classical.advance(&mut motion, benchmark.revolution() / 36.0 / 200.0, 200);
            expected.push(rod.deflection(motion.position.rows(3, modes).as_slice()));
        }
        let difference = apart(&found, &expected);
        println!("{elements} elements: runtime {difference:.2e}");
        assert!(difference < 4e-4);
        if elements == 4 {
            let file = numbers(&reference("ref_planar.json")["deflection"]["4"]["defl"]);
            let difference = apart(&expected, &file);
            println!("reference {difference:.2e}");
            assert!(difference < 1e-5);
        }
    }
}

/// Peaks of the deflection: six sine modes of the continuous rod give 0.018762 at 0.846 rad and -0.0136 at 5.83 rad.
#[test]
fn peaks_are_those_of_the_continuous_rod() {
    let benchmark = Benchmark::first();
    let rod = ReducedRod::new(benchmark, 8, 8);
    let mechanism = rod.mechanism();
    let mut simulation = mechanism.start(&mechanism.rigid_start(), method(0.9));
    let (mut highest, mut lowest) = ((0.0, 0.0), (0.0, 0.0));
    run(
        &mut simulation,
        benchmark.revolution(),
        7200,
        |simulation| {
            let angle = benchmark.speed * simulation.state().time;
            let deflection = rod.deflection(rod_coordinates(simulation));
            if deflection > highest.1 {
                highest = (angle, deflection);
            }
            if deflection < lowest.1 {
                lowest = (angle, deflection);
            }
        },
    );
    println!("{highest:?} {lowest:?} of {TAU}");
    assert!((highest.0 - 0.846).abs() < 3e-3 && (highest.1 - 0.018762).abs() < 2e-5);
    assert!((lowest.0 - 5.83).abs() < 2e-2 && (lowest.1 + 0.0136).abs() < 1e-4);
}
