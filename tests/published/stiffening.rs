//! The slider-crank's slender rod with geometric stiffening by the forces at its ends and by its spin, against values of an independent
//! program (sine modes in a rod with the axial force in its bending stiffness): first peak 0.01539 and minimum -0.01263 at 5.08 rad, where the
//! linear theory has 0.01876 and -0.0136 at 5.83 rad.

use dcb_formats::component::ComponentDraft;
use std::sync::Arc;

use dcb_formats::Component;
use dcb_formats::mesh::Dimension;
use dcb_reducer::Reduction;
use dcb_runtime::{Compatibility, FlexibleBody};
use dcb_samples::{RodSection, axial_prestress, planar_rod};
use dcb_tests::mechanism::{Scene, energy, method, revolute, run, stabilized};
use dcb_tests::rod::deflection::sampled;
use dcb_tests::rod::reduced::{Benchmark, ReducedRod};
use nalgebra::Vector3;

fn stiffened(elements: usize) -> Component {
    let section = RodSection::default();
    let rod = planar_rod(elements, &section);
    Component::checked(ComponentDraft {
        geometric_stiffness: Some(axial_prestress(&rod, section.density * section.area)),
        ..rod.into_draft()
    })
    .unwrap()
}

/// First peak, and the minimum with its crank angle, up to 8 rad.
fn extremes(rod: &ReducedRod) -> (f64, f64, f64) {
    let samples = 720;
    let history = sampled(rod, method(0.8), 3600, samples);
    let angle = |i: usize| 2.0 * std::f64::consts::TAU * i as f64 / samples as f64;
    let peak = (0..samples)
        .filter(|i| angle(*i) < 2.0)
        .fold(0.0, |most, i| f64::max(most, history[i]));
    let lowest = (0..samples)
        .filter(|i| angle(*i) < 8.0)
        .min_by(|a, b| history[*a].total_cmp(&history[*b]))
        .unwrap();
    (peak, history[lowest], angle(lowest))
}

#[test]
fn the_axial_force_stiffens_the_rod_of_the_slider_crank() {
    let benchmark = Benchmark::first();
    for (elements, modes) in [(8, 5), (8, 10)] {
        let options = Reduction::lowest(modes);
        let rod = ReducedRod::of(
            benchmark,
            &stiffened(elements),
            &options,
            Compatibility::Strong,
        );
        let (peak, lowest, at) = extremes(&rod);
        println!("{modes} modes: peak {peak:.5}, minimum {lowest:.5} at {at:.3} rad");
        assert!((peak / 0.01539 - 1.0).abs() < 0.01);
        // Theirs has the axial force of a rigid rod.
        assert!((lowest / -0.01263 - 1.0).abs() < 0.03);
        assert!((at - 5.08).abs() < 0.05);
    }
    let linear = ReducedRod::new(benchmark, 8, 5);
    let (peak, _, _) = extremes(&linear);
    assert!((peak / 0.01876 - 1.0).abs() < 0.01);
}

/// The force of a row does its work on the motion that it belongs to: a pendulum of a stiffened rod keeps its energy, the more closely
/// the smaller its steps.
#[test]
fn a_stiffened_pendulum_keeps_its_energy() {
    let options = Reduction::lowest(4);
    let reduced = dcb_tests::with(&stiffened(4), &options);
    let body = FlexibleBody::from_superelement(&reduced.superelement, Compatibility::Strong);
    let body = Arc::new(body.unwrap());
    assert!(!body.interface_stiffening.is_empty());
    let drift = |steps: usize| {
        let mut scene = Scene::new(Dimension::Planar, Vector3::new(0.0, -9.81, 0.0));
        let drawn = dcb_runtime::system::builder::Drawn {
            angular_velocity: Vector3::new(0.0, 0.0, 60.0),
            ..Default::default()
        };
        let rod = scene.body(&body, &drawn);
        let pin = scene.ground([0.0; 3]);
        let end = scene.on(rod, 0);
        scene.join(&revolute(Vector3::z()), pin, end);
        let (mut simulation, _) = scene.start(stabilized(0.9));
        let start = energy(&mut simulation);
        let mut worst = 0.0_f64;
        run(&mut simulation, 0.1, steps, |simulation| {
            worst = worst.max((energy(simulation) - start).abs());
        });
        worst / start.abs()
    };
    let (coarse, fine) = (drift(4000), drift(16_000));
    println!("energy drift {coarse:.2e}, {fine:.2e}");
    assert!(fine < 2e-4 && fine < 0.5 * coarse);
}
