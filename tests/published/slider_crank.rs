//! The slider-crank with a round flexible rod that Jonker, Meijaard, Schwab and others use: deflection of the rod's middle from the
//! chord over the crank angle, in linear elasticity, from the rod's rigid start.
//!
//! Reference histories: `ref_planar.json`, an independent program's, at 144000 steps a revolution. Where two programs are
//! compared, "relative" means by the largest deflection.

use std::f64::consts::TAU;

use dcb_tests::mechanism::slider_crank::rod_coordinates;
use dcb_tests::mechanism::{method, run};
use dcb_tests::motion::deflection::{step_bound, step_error};
use dcb_tests::rod::deflection::{apart, classical_samples, history, reference_history};
use dcb_tests::rod::reduced::{Benchmark, ReducedRod};

/// All modes of 2, 4 and 8 elements against the reference (Figs 3 and 4, first set of data).
#[test]
fn unreduced_rods_follow_the_reference() {
    for (elements, modes) in [(2, 6), (4, 12), (8, 24)] {
        let expected = reference_history(elements);
        let benchmark = Benchmark::first();
        let rod = ReducedRod::new(benchmark, elements, modes);
        assert_eq!(rod.body.coordinate_count(), modes);
        let found = history(&rod, method(0.9), 14_400);
        let difference = apart(&found, &expected);
        println!("{elements} elements: {difference:.2e}");
        assert!(difference < 2e-4);
    }
}

/// The error of the step with rho 0.8: what users must expect of coarse steps.
#[test]
fn steps_converge_to_the_reference() {
    for modes in [5, 12] {
        let errors = [720, 3600, 14_400].map(|steps| {
            let (error, bound) = (step_error(modes, steps), step_bound(modes, steps));
            println!("{modes} modes, {steps} steps: {error:.2e}");
            assert!(bound.is_some_and(|bound| error < bound));
            error
        });
        assert!(errors.is_sorted_by(|a, b| a > b));
    }
}

/// Modes and attachments against all modes, 4 elements (Figs 6 and 7). The paper's bounds are 1 % with 5 modes and better with 8.
#[test]
fn reduced_rods_follow_the_unreduced() {
    let benchmark = Benchmark::first();
    for (steps, limits) in [(3600, [5e-3, 1e-3, 1e-4]), (14_400, [1e-3, 5e-4, 2e-5])] {
        let whole = ReducedRod::new(benchmark, 4, 12);
        let whole = history(&whole, method(0.8), steps);
        for (modes, limit) in [1, 5, 8].into_iter().zip(limits) {
            let rod = ReducedRod::new(benchmark, 4, modes);
            let found = history(&rod, method(0.8), steps);
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
        let found = history(&rod, method(0.9), 14_400);
        let expected = classical_samples(&rod, 72);
        let difference = apart(&found, &expected);
        println!("{elements} elements: runtime {difference:.2e}");
        assert!(difference < 4e-4);
        if elements == 4 {
            let difference = apart(&expected, &reference_history(4));
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
