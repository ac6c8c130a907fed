//! The same mechanism described in different ways: in the plane and in space, in other units, drawn in other axes, with bodies
//! and joints in another order. Each function tells how far apart the motions are, relative to their size.

use std::sync::Arc;

use dcb_formats::mesh::Dimension;
use dcb_runtime::integrator::Method;
use dcb_runtime::{Compatibility, FlexibleBody};
use dcb_samples::spatial_beam::{BeamSection, SpatialBeam};
use dcb_samples::{Material, RodSection, planar_rod, spatial_beam};
use nalgebra::Vector3;

use crate::lowest;
use crate::mechanism::slider_crank::{SliderCrank, rod_angle, rod_coordinates, slider_position};
use crate::mechanism::{Scene, between, method, revolute, run, slender_bar};
use crate::rod::reduced::Benchmark;

/// Place of the slider by the crank's length, angle of the rod, strain energy by the rod's kinetic energy scale, every twelfth of
/// a revolution.
fn observed(mechanism: &SliderCrank, steps: usize) -> Vec<[f64; 3]> {
    let mut simulation = mechanism.start(&mechanism.rigid_start(), method(0.8));
    let revolution = std::f64::consts::TAU / mechanism.speed;
    let scale = mechanism.rod.inertia.mass() * (mechanism.crank * mechanism.speed).powi(2);
    (0..12)
        .map(|_| {
            run(&mut simulation, revolution / 12.0, steps / 12, |_| {});
            [
                slider_position(&simulation) / mechanism.crank,
                rod_angle(&simulation) - mechanism.rod_axes,
                mechanism.rod.strain_energy(rod_coordinates(&simulation)) / scale,
            ]
        })
        .collect()
}

/// Largest difference of place, angle and energy, each by its largest value.
fn apart(found: &[[f64; 3]], expected: &[[f64; 3]]) -> [f64; 3] {
    std::array::from_fn(|k| {
        let size = expected.iter().map(|x| x[k].abs()).fold(0.0, f64::max);
        let pairs = found.iter().zip(expected);
        pairs.map(|(a, b)| (a[k] - b[k]).abs()).fold(0.0, f64::max) / size
    })
}

fn largest(apart: [f64; 3]) -> f64 {
    apart.into_iter().fold(0.0, f64::max)
}

fn planar(section: &RodSection, crank: f64) -> SliderCrank {
    let superelement = lowest(&planar_rod(2, section), 6).superelement;
    let rod = FlexibleBody::from_superelement(&superelement, Compatibility::Strong).unwrap();
    SliderCrank {
        crank,
        speed: 150.0,
        slider: 0.5 * superelement.inertia.mass,
        rod_axes: -section.angle,
        rod: Arc::new(rod),
        dimension: Dimension::Planar,
    }
}

/// All modes of a rod of the plane and of a beam in space; the beam's other modes stay at rest.
pub fn flexible_in_space() -> f64 {
    let section = RodSection::default();
    let flat = planar(&section, 0.15);
    let beam = spatial_beam(&SpatialBeam {
        elements: 2,
        start: [0.0; 3],
        end: [section.length, 0.0, 0.0],
        roll: 0.3,
        section: BeamSection::round(0.006),
        material: Material {
            youngs_modulus: section.youngs_modulus,
            poisson_ratio: 0.3,
            density: section.density,
        },
        ..SpatialBeam::default()
    });
    let superelement = lowest(&beam, 12).superelement;
    let rod = FlexibleBody::from_superelement(&superelement, Compatibility::Strong).unwrap();
    assert_eq!(rod.coordinate_count(), 12);
    let spatial = SliderCrank {
        rod: Arc::new(rod),
        dimension: Dimension::Spatial,
        ..flat.clone()
    };
    largest(apart(&observed(&spatial, 3600), &observed(&flat, 3600)))
}

/// Rigid bars: a four-bar linkage under gravity by both routes, m of 1 m. In space three of its constraints are redundant.
pub fn rigid_linkage_in_space(method: Method) -> f64 {
    let end = [Dimension::Planar, Dimension::Spatial].map(|dimension| {
        let mut scene = Scene::new(dimension, Vector3::new(0.0, -9.81, 0.0));
        let corners = [
            [0.0, 0.0, 0.0],
            [0.0, 0.4, 0.0],
            [0.9, 0.7, 0.0],
            [1.0, 0.0, 0.0],
        ];
        let mut last = scene.ground(corners[0]);
        for pair in corners.windows(2) {
            let length = (Vector3::from(pair[1]) - Vector3::from(pair[0])).norm();
            let bar = slender_bar(dimension, length, length);
            let body = scene.body(&bar, &between(pair[0], pair[1], [0.0; 3], [0.0; 3]));
            let start = scene.on(body, 0);
            scene.join(&revolute(Vector3::z()), last, start);
            last = scene.on(body, 1);
        }
        let ground = scene.ground(corners[3]);
        scene.join(&revolute(Vector3::z()), last, ground);
        let (mut simulation, report) = scene.start(method);
        let redundant: usize = report.redundant.iter().map(|(_, count)| count).sum();
        assert_eq!(
            redundant,
            [0, 3][usize::from(dimension == Dimension::Spatial)]
        );
        run(&mut simulation, 1.5, 3000, |_| {});
        simulation.state().origins.clone()
    });
    let apart = end[0].iter().zip(&end[1]).map(|(a, b)| (a - b).norm());
    apart.fold(0.0, f64::max)
}

/// Metre, kilogram, second and millimetre, tonne, second.
pub fn other_units() -> f64 {
    let si = RodSection::default();
    let fine = RodSection {
        length: si.length * 1e3,
        area: si.area * 1e6,
        second_moment: si.second_moment * 1e12,
        youngs_modulus: si.youngs_modulus * 1e-6,
        density: si.density * 1e-12,
        ..si
    };
    let expected = observed(&planar(&si, 0.15), 3600);
    let found = observed(&planar(&fine, 150.0), 3600);
    largest(apart(&found, &expected))
}

/// The rod's component drawn at an angle and turned back.
pub fn other_component_axes(angle: f64) -> f64 {
    let benchmark = Benchmark::first();
    let expected = observed(&planar(&benchmark.section, 0.15), 3600);
    let turned = RodSection {
        angle,
        ..benchmark.section
    };
    let mut found = observed(&planar(&turned, 0.15), 3600);
    for sample in &mut found {
        let angle = sample[1];
        sample[1] = angle.sin().atan2(angle.cos());
    }
    largest(apart(&found, &expected))
}

/// A hanging chain whose bodies and joints are named from either end, m of 1 m.
pub fn other_order() -> f64 {
    let ends = [false, true].map(|reversed| {
        let mut scene = Scene::new(Dimension::Spatial, Vector3::new(0.0, 0.0, -9.81));
        let bar = slender_bar(Dimension::Spatial, 1.0, 1.0);
        let corner = |index: usize| [index as f64, 0.0, 0.0];
        let in_order = |count: usize| -> Vec<usize> {
            if reversed {
                (0..count).rev().collect()
            } else {
                (0..count).collect()
            }
        };
        let mut bodies = [0; 4];
        for index in in_order(4) {
            let drawn = between(corner(index), corner(index + 1), [0.0; 3], [0.0; 3]);
            bodies[index] = scene.body(&bar, &drawn);
        }
        let ground = scene.ground(corner(0));
        for index in in_order(4) {
            let a = match index {
                0 => ground,
                _ => scene.on(bodies[index - 1], 1),
            };
            let b = scene.on(bodies[index], 0);
            // Axes in turn, so that the motion is not plane.
            let axis = [Vector3::y(), Vector3::new(0.0, 1.0, 1.0)][index % 2];
            scene.join(&revolute(axis), a, b);
        }
        let (mut simulation, _) = scene.start(method(0.9));
        run(&mut simulation, 0.6, 1200, |_| {});
        bodies.map(|body| simulation.state().origins[body])
    });
    let apart = ends[0].iter().zip(&ends[1]).map(|(a, b)| (a - b).norm());
    apart.fold(0.0, f64::max)
}
