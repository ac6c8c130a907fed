//! Geometric stiffening: bending frequencies of a spinning rod against the beam's own mode by quadrature, balances, and the linear limit.

use crate::support::free::{FreeState, free_motion, integrate};
use crate::support::{Part, numbers};
use dcb_formats::Component;
use dcb_formats::component::ComponentDraft;
use dcb_runtime::FlexibleBody;
use dcb_runtime::watch::validity::rod_frequency_deficit;
use dcb_samples::spatial_beam::BeamSection;
use dcb_samples::{Material, RodSection, SpatialBeam, axial_prestress, planar_rod, spatial_beam};
use faer::Mat;
use nalgebra::Vector3;

fn stiffened(component: Component, mass_per_length: f64) -> Component {
    Component::checked(ComponentDraft {
        geometric_stiffness: Some(axial_prestress(&component, mass_per_length)),
        ..component.into_draft()
    })
    .unwrap()
}

fn rod(elements: usize) -> Component {
    let section = RodSection::default();
    stiffened(
        planar_rod(elements, &section),
        section.density * section.area,
    )
}

/// S of the first free-free bending mode φ: ∫ ½ μ (L x - x²) φ'² dx / ∫ μ φ² dx, the stiffness that a unit Ω² adds to unit modal mass.
fn first_mode_stiffening() -> f64 {
    let beta: f64 = 4.730_040_744_862_704;
    let ratio = (beta.cosh() - beta.cos()) / (beta.sinh() - beta.sin());
    let shape = |x: f64| {
        let b = beta * x;
        (
            b.cosh() + b.cos() - ratio * (b.sinh() + b.sin()),
            beta * (b.sinh() - b.sin() - ratio * (b.cosh() + b.cos())),
        )
    };
    // Simpson's rule on the unit length.
    let count = 2000;
    let integral = |f: &dyn Fn(f64) -> f64| {
        let h = 1.0 / f64::from(count);
        let weight = |i: i32| match i {
            0 => 1.0,
            i if i == count => 1.0,
            i if i % 2 == 1 => 4.0,
            _ => 2.0,
        };
        (0..=count)
            .map(|i| weight(i) * f(f64::from(i) * h))
            .sum::<f64>()
            * h
            / 3.0
    };
    integral(&|x| 0.5 * (x - x * x) * shape(x).1.powi(2)) / integral(&|x| shape(x).0.powi(2))
}

/// Angular frequency of a small bending motion of a body that spins about z, from the time of its ninth zero.
fn bending_frequency(body: &FlexibleBody, spin: f64, expected: f64) -> f64 {
    let mut state = FreeState::spinning(body, Vector3::new(0.0, 0.0, spin));
    state.y[0] = 1e-6;
    let n = body.coordinate_count();
    let scale: Vec<f64> = std::iter::repeat_n(1e-9, 4)
        .chain(std::iter::repeat_n(1e-9 * spin, 3))
        .chain(std::iter::repeat_n(1e-12, n))
        .chain(std::iter::repeat_n(1e-12 * expected, n))
        .collect();
    let mut terms = dcb_runtime::InertiaTerms::for_coordinates(n);
    let mut x = state.pack();
    let interval = std::f64::consts::TAU / expected / 100.0;
    let (mut zeros, mut time) = (0, 0.0);
    loop {
        let before = x[7];
        integrate(
            |x, dx| free_motion(body, &mut terms, x, dx),
            &mut x,
            interval,
            &scale,
        );
        let after = x[7];
        time += interval;
        assert!(after.abs() < 1e-4, "the motion grows at t = {time}");
        if before * after <= 0.0 {
            zeros += 1;
            if zeros == 9 {
                let at = time - interval * after / (after - before);
                return (f64::from(zeros) - 0.5) * std::f64::consts::PI / at;
            }
        }
        assert!(time < 20.0 * std::f64::consts::TAU / expected);
    }
}

/// In the plane of the spin ω² = ω₁² + Ω² (S - 1): the 1 is the softening that the linear theory has alone. Axial modes add the order
/// of (2Ω/ω_axial)².
#[test]
fn a_spinning_rod_bends_as_fast_as_its_axial_force_says() {
    let part = Part::reduced(rod(16), 8);
    let first = part.body.stiffness[0].sqrt();
    let axial = std::f64::consts::PI / 0.3 * (0.2e12_f64 / 7870.0).sqrt();
    let factor = first_mode_stiffening();
    assert!(part.body.is_stiffened());
    for ratio in [0.1, 0.5, 0.95, 2.0] {
        let spin = ratio * first;
        let expected = (first * first + spin * spin * (factor - 1.0)).sqrt();
        let found = bending_frequency(&part.body, spin, expected);
        let allowed = 2e-3 + (2.0 * spin / axial).powi(2);
        println!(
            "spin {ratio} of the first frequency: {:.4}, expected {:.4}",
            found / first,
            expected / first
        );
        assert!((found / expected - 1.0).abs() < allowed);
    }
}

/// Without the matrices the same rod softens to ω₁ √(1 - r²), and below the first frequency alone.
#[test]
fn without_stiffening_it_softens() {
    let part = Part::reduced(planar_rod(16, &RodSection::default()), 8);
    let first = part.body.stiffness[0].sqrt();
    assert!(!part.body.is_stiffened());
    for ratio in [0.3, 0.8] {
        let expected = first * f64::sqrt(1.0 - ratio * ratio);
        let found = bending_frequency(&part.body, ratio * first, expected);
        assert!((found / expected - 1.0).abs() < 5e-3);
    }
}

/// What `simulate` tells of a spinning body without the matrices is what its frequency lacks of that with them.
#[test]
fn what_is_told_of_a_spin_is_what_the_frequency_lacks() {
    let linear = Part::reduced(planar_rod(16, &RodSection::default()), 8);
    let stiff = Part::reduced(rod(16), 8);
    let first = linear.body.stiffness[0].sqrt();
    let factor = first_mode_stiffening();
    for (ratio, told) in [(0.1, 0.015), (0.3, 0.123), (0.8, 0.605)] {
        let (spin, square) = (ratio * first, ratio * ratio);
        let softened = first * f64::sqrt(1.0 - square);
        let stiffened = first * f64::sqrt(1.0 + (factor - 1.0) * square);
        let found = 1.0
            - bending_frequency(&linear.body, spin, softened)
                / bending_frequency(&stiff.body, spin, stiffened);
        let deficit = rod_frequency_deficit(ratio);
        println!("{ratio}: {found:.4}, told {deficit:.4}");
        assert!((deficit - (1.0 - softened / stiffened)).abs() < 1e-6);
        assert!((deficit - told).abs() < 1e-3);
        assert!((found - deficit).abs() < 4e-3);
    }
}

/// Out of the plane of the spin nothing softens: ω² = ω₁² + Ω² S, in space, with the beam in any direction.
#[test]
fn a_spinning_beam_flaps_as_fast_as_its_axial_force_says() {
    let section = BeamSection::rectangle(0.004, 0.002);
    let material = Material::STEEL;
    let beam = SpatialBeam {
        elements: 12,
        start: [0.1, -0.2, 0.0],
        end: [0.34, 0.12, 0.0],
        section,
        material,
        ..SpatialBeam::default()
    };
    let component = stiffened(spatial_beam(&beam), material.density * section.area);
    let part = Part::reduced(component, 8);
    // The thin direction of the section is along z: the softest bending is out of the plane.
    let first = part.body.stiffness[0].sqrt();
    let factor = first_mode_stiffening();
    for ratio in [0.5, 2.0] {
        let spin = ratio * first;
        let expected = (first * first + spin * spin * factor).sqrt();
        let found = bending_frequency(&part.body, spin, expected);
        println!(
            "{ratio}: {:.4}, expected {:.4}",
            found / first,
            expected / first
        );
        assert!((found / expected - 1.0).abs() < 5e-3);
    }
}

/// Nothing pulls along a shaft that spins about its own axis: below its first frequency and above, the linear frame lets it swing in a plane
/// that stays in space.
#[test]
fn a_shaft_that_spins_about_its_axis_swings_as_if_it_did_not() {
    let beam = SpatialBeam {
        elements: 12,
        end: [0.4, 0.0, 0.0],
        section: BeamSection::rectangle(0.004, 0.004),
        ..SpatialBeam::default()
    };
    let part = Part::reduced(spatial_beam(&beam), 4);
    let body = &part.body;
    let first = body.stiffness[0].sqrt();
    assert!((body.stiffness[1].sqrt() / first - 1.0).abs() < 1e-9);
    let (n, size) = (body.coordinate_count(), 1e-6);
    for ratio in [0.4, 1.5] {
        let speed = ratio * first;
        let mut state = FreeState::spinning(body, Vector3::new(speed, 0.0, 0.0));
        // In a turning frame what has no velocity in space has -ω × y.
        let (mut damping, mut stiffness) = (Mat::zeros(n, n), Mat::zeros(n, n));
        let inertia = &body.inertia;
        let still = Vector3::zeros();
        inertia.write_elastic_tangent(&state.spin, &still, damping.as_mut(), stiffness.as_mut());
        let turning = 0.5 * damping[(0, 1)];
        assert!((turning.abs() / speed - 1.0).abs() < 1e-3);
        state.y[0] = size;
        state.rates[1] = turning * size;
        let scale: Vec<f64> = std::iter::repeat_n(1e-9, 4)
            .chain(std::iter::repeat_n(1e-9 * speed, 3))
            .chain(std::iter::repeat_n(1e-6 * size, n))
            .chain(std::iter::repeat_n(1e-6 * size * first, n))
            .collect();
        let mut terms = part.terms();
        let mut x = state.pack();
        let interval = 0.1 * std::f64::consts::TAU / first;
        for k in 1..=20 {
            let motion = |x: &[f64], dx: &mut [f64]| free_motion(body, &mut terms, x, dx);
            integrate(motion, &mut x, interval, &scale);
            let time = f64::from(k) * interval;
            let swing = size * (first * time).cos();
            let expected = [
                swing * (speed * time).cos(),
                swing * (speed * time).sin() * turning.signum(),
            ];
            let found = FreeState::unpack(&x).y;
            for (found, expected) in found.iter().zip(expected) {
                assert!((found - expected).abs() < 1e-2 * size, "{ratio}, {k}");
            }
        }
    }
}

/// Energy and angular momentum of bodies that nothing acts on, deflected much.
#[test]
fn stiffened_bodies_conserve_energy_and_angular_momentum() {
    let beam = SpatialBeam {
        elements: 4,
        end: [0.4, 0.3, 0.1],
        section: BeamSection::rectangle(0.01, 0.02),
        ..SpatialBeam::default()
    };
    let spatial = stiffened(spatial_beam(&beam), 7850.0 * 2e-4);
    for (component, spin) in [
        (rod(4), Vector3::new(0.0, 0.0, 900.0)),
        (spatial, Vector3::new(150.0, -100.0, 200.0)),
    ] {
        let part = Part::reduced(component, 4);
        let body = &part.body;
        let mut state = FreeState::spinning(body, spin);
        let size = 0.01 * body.inertia.mass().sqrt();
        state.y = numbers(state.y.len(), 3)
            .iter()
            .zip(&body.stiffness)
            .map(|(number, stiffness)| size * number * body.stiffness[0] / stiffness)
            .collect();
        let mut terms = part.terms();
        let (energy, momentum) = state.invariants(body, &mut terms);
        let n = body.coordinate_count();
        let scale: Vec<f64> = std::iter::repeat_n(1e-12, 4)
            .chain(std::iter::repeat_n(1e-12 * spin.norm(), 3))
            .chain(std::iter::repeat_n(1e-12 * size, n))
            .chain(std::iter::repeat_n(
                1e-12 * size * body.stiffness[0].sqrt(),
                n,
            ))
            .collect();
        let mut x = state.pack();
        integrate(
            |x, dx| free_motion(body, &mut terms, x, dx),
            &mut x,
            0.01,
            &scale,
        );
        let (after, turned) = FreeState::unpack(&x).invariants(body, &mut terms);
        assert!(
            (after / energy - 1.0).abs() < 1e-10,
            "{:e}",
            after / energy - 1.0
        );
        assert!((turned - momentum).norm() < 1e-10 * momentum.norm());
    }
}
