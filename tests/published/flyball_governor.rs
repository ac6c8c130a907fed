//! The stiff flyball governor of the IFToMM library of multibody benchmarks: González, Dopico, Lugrís, Cuadrado, "A
//! benchmarking system for MBS simulation software", Multibody System Dynamics 16 (2006) 179-190, problem A05.

use dcb_tests::mechanism::governor::{governor_errors, least_governor};

/// No figures to more than three digits are published, so the motion is compared with Lagrange's equations in two coordinates.
#[test]
fn flyball_governor_follows_lagrange() {
    for duration in [1.0, 4.0] {
        let expected = least_governor(duration, (duration * 2e5) as usize);
        let check = least_governor(duration, (duration * 1e5) as usize);
        assert!((expected[2] - check[2]).abs() < 1e-9);
        let errors = [1000.0, 2000.0].map(|rate| governor_errors(duration, rate));
        println!("{errors:?}");
        let errors = errors.map(|[place, spin]| place + spin);
        assert!(errors[1] < 1e-4, "{errors:?}");
        assert!((3.0..5.0).contains(&(errors[0] / errors[1])), "{errors:?}");
    }
}
