//! Vibrations of assembled mechanisms against closed forms.

use std::sync::Arc;

use crate::support::Part;
use crate::support::mechanisms::{about_z, linear, rigid};
use dcb_formats::mesh::Dimension;
use dcb_runtime::analysis::eigenmodes::Eigenmodes;
use dcb_runtime::analysis::equilibrium::{EquilibriumSettings, find_equilibrium};
use dcb_runtime::joint::{Fixed, JointKind};
use dcb_runtime::measure::{Displacement, Measure};
use dcb_runtime::system::builder::{Drawn, SystemBuilder, Turning};
use dcb_runtime::system::{State, System};
use dcb_samples::{RodSection, SpatialBeam, planar_rod, spatial_beam};
use nalgebra::{Matrix3, UnitQuaternion, Vector3};

const GRAVITY: f64 = 9.81;

/// Bars hanging on each other, drawn at an angle to the vertical; `scale` is the unit of length, mass in 1/scale.
fn pendulum(bars: usize, angle: f64, scale: f64) -> (System, State) {
    let mut builder =
        SystemBuilder::new(Dimension::Spatial, Vector3::new(0.0, -GRAVITY * scale, 0.0));
    let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), angle);
    let along = turn * Vector3::new(0.0, -scale, 0.0);
    let mut above = builder.ground(Vector3::zeros(), Matrix3::identity());
    for index in 0..bars {
        let ends = [
            Vector3::new(0.0, 0.5 * scale, 0.0),
            Vector3::new(0.0, -0.5 * scale, 0.0),
        ];
        let inertia = Vector3::new(0.1, 0.02, 0.1) * scale;
        let body = rigid(Dimension::Spatial, 2.0 / scale, inertia, &ends);
        let drawn = Drawn {
            position: along * (index as f64 + 0.5),
            orientation: turn,
            ..Drawn::default()
        };
        let bar = builder.body(&format!("bar {index}"), body, &drawn);
        let top = builder.marker(bar, 0, Turning::Interface).unwrap();
        builder.joint("hinge", above, top, &about_z()).unwrap();
        above = builder.marker(bar, 1, Turning::Interface).unwrap();
    }
    builder.finish()
}

fn at_rest((system, mut state): (System, State)) -> Eigenmodes {
    find_equilibrium(&system, &mut state, &EquilibriumSettings::default()).unwrap();
    Eigenmodes::at(&system, &state).unwrap()
}

fn close(found: f64, expected: f64, tolerance: f64) {
    let error = (found / expected - 1.0).abs();
    assert!(error < tolerance, "{found} against {expected}");
}

#[test]
fn pendulum_swings_with_its_own_frequency_in_any_units() {
    for scale in [1.0, 1000.0] {
        let modes = at_rest(pendulum(1, 1.0, scale));
        assert_eq!((modes.dof_count, modes.rigid_count), (1, 0));
        let squared = 2.0 * GRAVITY * 0.5 / (0.1 + 2.0 * 0.25);
        close(modes.modes[0].angular_frequency, squared.sqrt(), 1e-9);
    }
}

#[test]
fn pendulum_above_its_pivot_falls() {
    let (system, mut state) = pendulum(1, std::f64::consts::PI, 1.0);
    // Held up by the pivot: λ of the first row along y carries the weight.
    dcb_runtime::initial::Starter::of(&system)
        .unwrap()
        .start(
            &mut state,
            dcb_formats::scene::RedundantConstraints::MinimumNorm,
        )
        .unwrap();
    state.accelerations.fill(0.0);
    let modes = Eigenmodes::at(&system, &state).unwrap();
    let squared = 2.0 * GRAVITY * 0.5 / (0.1 + 2.0 * 0.25);
    assert_eq!(modes.unstable().len(), 1);
    close(modes.unstable()[0].growth, squared.sqrt(), 1e-9);
}

#[test]
fn double_pendulum_has_the_frequencies_of_its_two_by_two_problem() {
    for scale in [1.0, 1000.0] {
        let modes = at_rest(pendulum(2, 0.7, scale));
        // M = [[0.1 + 0.5 + 2, 1], [1, 0.6]], K = g diag(1 + 2, 1)
        let (a, b, c) = (2.6, 1.0, 0.6);
        let (k, l) = (3.0 * GRAVITY, GRAVITY);
        let (first, second, third) = (a * c - b * b, -(a * l + c * k), k * l);
        let root = (second * second - 4.0 * first * third).sqrt();
        for (mode, squared) in modes.modes.iter().zip([
            (-second - root) / (2.0 * first),
            (-second + root) / (2.0 * first),
        ]) {
            close(mode.angular_frequency, squared.sqrt(), 1e-9);
        }
        assert_eq!(modes.dof_count, 2);
    }
}

#[test]
fn damped_spring_has_its_frequency_and_ratio_and_leaves_the_other_motions_free() {
    let body = rigid(
        Dimension::Spatial,
        4.0,
        Vector3::new(0.1, 0.2, 0.3),
        &[Vector3::zeros()],
    );
    let mut builder = SystemBuilder::new(Dimension::Spatial, Vector3::zeros());
    let block = builder.body("block", body, &Drawn::default());
    let end = builder.marker(block, 0, Turning::Interface).unwrap();
    let ground = builder.ground(Vector3::zeros(), Matrix3::identity());
    let direction = Vector3::x_axis();
    let measure = Measure::Displacement(Displacement { direction });
    builder.spring("spring", ground, end, [(measure, linear(0.0, 900.0, 12.0))]);
    let (system, state) = builder.finish();
    let modes = Eigenmodes::at(&system, &state).unwrap();
    assert_eq!((modes.dof_count, modes.rigid_count), (6, 5));
    let mode = &modes.modes[5];
    close(
        mode.damping_ratio(),
        12.0 / (2.0 * (4.0_f64 * 900.0).sqrt()),
        1e-10,
    );
    close(mode.growth, -12.0 / 8.0, 1e-10);
}

#[test]
fn free_beam_has_the_frequencies_of_its_file() {
    let part = Part::reduced(spatial_beam(&SpatialBeam::default()), 6);
    let mut stiffness = part.body.stiffness.clone();
    stiffness.sort_by(f64::total_cmp);
    let mut builder = SystemBuilder::new(Dimension::Spatial, Vector3::zeros());
    builder.body("beam", Arc::new(part.body), &Drawn::default());
    let (system, state) = builder.finish();
    let modes = Eigenmodes::at(&system, &state).unwrap();
    assert_eq!(modes.rigid_count, 6);
    for (mode, stiffness) in modes.modes[6..].iter().zip(&stiffness) {
        close(mode.angular_frequency.powi(2), *stiffness, 1e-9);
    }
}

#[test]
fn beams_on_supports_have_the_frequencies_of_beam_theory() {
    let beam = SpatialBeam::default();
    let part = Part::reduced(spatial_beam(&beam), 8);
    let mut builder = SystemBuilder::new(Dimension::Spatial, Vector3::zeros());
    let body = builder.body("beam", Arc::new(part.body), &Drawn::default());
    let root = builder.marker(body, 0, Turning::Interface).unwrap();
    let ground = builder.ground(Vector3::zeros(), Matrix3::identity());
    builder
        .joint("clamp", ground, root, &JointKind::Fixed(Fixed))
        .unwrap();
    let (system, state) = builder.finish();
    let modes = Eigenmodes::at(&system, &state).unwrap();
    assert_eq!(modes.rigid_count, 0);
    let (section, material) = (beam.section, beam.material);
    let unit =
        |moment: f64| (material.youngs_modulus * moment / (material.density * section.area)).sqrt();
    let mut expected = Vec::new();
    for root in [1.875_104_068_7_f64, 4.694_091_133_0] {
        for moment in [section.second_moment_y, section.second_moment_z] {
            expected.push(root * root * unit(moment));
        }
    }
    expected.sort_by(f64::total_cmp);
    for (mode, expected) in modes.modes.iter().zip(expected) {
        close(mode.angular_frequency, expected, 1e-3);
    }

    let rod = RodSection::default();
    let part = Part::reduced(planar_rod(8, &rod), 6);
    let mut builder = SystemBuilder::new(Dimension::Planar, Vector3::zeros());
    let body = builder.body("rod", Arc::new(part.body), &Drawn::default());
    for (name, index) in [("left", 0), ("right", 1)] {
        let end = builder.marker(body, index, Turning::Interface).unwrap();
        let ground = builder.ground(builder.frame(end).position, Matrix3::identity());
        builder.joint(name, ground, end, &about_z()).unwrap();
    }
    let (system, state) = builder.finish();
    let modes = Eigenmodes::at(&system, &state).unwrap();
    let bending = rod.youngs_modulus * rod.second_moment / (rod.density * rod.area);
    for half_waves in 1..3 {
        let wave = f64::from(half_waves) * std::f64::consts::PI / rod.length;
        let found = modes.modes[half_waves as usize - 1].angular_frequency;
        close(found, wave * wave * bending.sqrt(), 1e-3);
    }
}

#[test]
fn spinning_top_without_forces_nutates() {
    let body = rigid(Dimension::Spatial, 1.0, Vector3::new(0.2, 0.2, 0.3), &[]);
    let mut builder = SystemBuilder::new(Dimension::Spatial, Vector3::zeros());
    let drawn = Drawn {
        angular_velocity: Vector3::new(0.0, 0.0, 40.0),
        ..Drawn::default()
    };
    builder.body("top", body, &drawn);
    let (system, state) = builder.finish();
    let modes = Eigenmodes::at(&system, &state).unwrap();
    // (C - A) / A times the spin, as the body sees it.
    let found = modes
        .modes
        .iter()
        .map(|mode| (mode.angular_frequency - 20.0).abs());
    assert!(found.fold(f64::INFINITY, f64::min) < 1e-8);
    assert!(modes.modes.iter().all(|mode| mode.growth.abs() < 1e-3));
}
