//! Damping of the assembled modes: the asked ratios, nothing of motions without deflection, the same in every position.

use std::sync::Arc;

use crate::support::Part;
use crate::support::mechanisms::{about_z, linear, method};
use dcb_formats::mesh::Dimension;
use dcb_formats::scene::{AssembledDamping, ModalRatios, RayleighPoints, RedundantConstraints};
use dcb_runtime::analysis::assembled_damping::damped_amplitudes;
use dcb_runtime::analysis::effective_damping::{DampedPart, damping_by_part};
use dcb_runtime::analysis::eigenmodes::Eigenmodes;
use dcb_runtime::energy::{Energy, Works};
use dcb_runtime::integrator::Formulation;
use dcb_runtime::measure::{Displacement, Measure};
use dcb_runtime::simulation::Simulation;
use dcb_runtime::system::builder::{Drawn, SystemBuilder, Turning};
use dcb_runtime::system::evaluation::Evaluation;
use dcb_runtime::system::linearization::Linearization;
use dcb_runtime::system::{State, System};
use dcb_samples::{SpatialBeam, spatial_beam};
use nalgebra::{Matrix3, UnitQuaternion, Vector3};

/// Two equal beams in a line, hinged to the ground and to each other about z.
fn double_pendulum(own_ratio: f64) -> SystemBuilder {
    let beam = SpatialBeam {
        elements: 4,
        ..SpatialBeam::default()
    };
    let mut body = Part::reduced(spatial_beam(&beam), 6).body;
    body.damping.fill(own_ratio);
    let body = Arc::new(body);
    let mut builder = SystemBuilder::new(Dimension::Spatial, Vector3::zeros());
    let upper = builder.body("upper", body.clone(), &Drawn::default());
    let root = builder.marker(upper, 0, Turning::Interface).unwrap();
    let middle = builder.marker(upper, 1, Turning::Interface).unwrap();
    let drawn = Drawn {
        position: builder.frame(middle).position - builder.frame(root).position,
        ..Drawn::default()
    };
    let lower = builder.body("lower", body, &drawn);
    let head = builder.marker(lower, 0, Turning::Interface).unwrap();
    let place = builder.frame(root).position;
    let ground = builder.ground(place, Matrix3::identity());
    builder.joint("pivot", ground, root, &about_z()).unwrap();
    builder.joint("knee", middle, head, &about_z()).unwrap();
    builder
}

fn damped(mut builder: SystemBuilder, asked: &AssembledDamping) -> (System, State) {
    let (system, state) = builder.clone().finish();
    let amplitudes = damped_amplitudes(&system, &state, asked).unwrap();
    builder.damp_amplitudes("damping", &amplitudes);
    builder.finish()
}

fn modal(ratios: &[f64]) -> AssembledDamping {
    AssembledDamping {
        assembled_modal: Some(ModalRatios::PerMode(ratios.to_vec())),
        ..AssembledDamping::default()
    }
}

/// Complex eigenvalues have the asked ratios and the undamped frequencies; the two swings stay free.
#[test]
fn modes_have_the_asked_ratios_exactly() {
    let (undamped, state) = double_pendulum(0.0).finish();
    let frequencies = Eigenmodes::at(&undamped, &state).unwrap();
    let (system, state) = damped(double_pendulum(0.0), &modal(&[0.003, 0.02, 0.007]));
    let found = Eigenmodes::at(&system, &state).unwrap();
    assert_eq!((found.rigid_count, frequencies.rigid_count), (2, 2));
    let modes = found.modes[2..].iter().zip(&frequencies.modes[2..]);
    for (index, (mode, undamped)) in modes.enumerate() {
        let asked = [0.003, 0.02, 0.007][index.min(2)];
        let size = mode.growth.hypot(mode.angular_frequency);
        let defect = (mode.damping_ratio() - asked).abs();
        assert!(defect < 1e-10, "mode {index}: {defect:e}");
        assert!((size / undamped.angular_frequency - 1.0).abs() < 1e-9);
    }
    let points = RayleighPoints {
        frequencies: [
            frequencies.modes[2].frequency(),
            frequencies.modes[4].frequency(),
        ],
        ratios: [0.01, 0.02],
    };
    let rayleigh = AssembledDamping {
        assembled_rayleigh: Some(points),
        ..AssembledDamping::default()
    };
    let (system, state) = damped(double_pendulum(0.0), &rayleigh);
    let found = Eigenmodes::at(&system, &state).unwrap();
    for (mode, asked) in [(2, 0.01), (4, 0.02)] {
        assert!((found.modes[mode].damping_ratio() - asked).abs() < 1e-10);
    }
    let structural = AssembledDamping {
        assembled_structural: Some(0.03),
        ..AssembledDamping::default()
    };
    let (system, state) = damped(double_pendulum(0.0), &structural);
    let found = Eigenmodes::at(&system, &state).unwrap();
    for mode in &found.modes[2..] {
        assert!((mode.damping_ratio() - 0.015).abs() < 1e-10);
    }
}

/// Wherever the pendulum has gone: C meets no motion without deflection, and has the same entries for deflections.
#[test]
fn motions_without_deflection_are_not_damped_in_any_position() {
    let (system, mut state) = damped(double_pendulum(0.0), &modal(&[0.01]));
    let damping = |state: &State| {
        let evaluation = Evaluation::at(&system, state);
        Linearization::at(&system, state, &evaluation)
            .unwrap()
            .damping
    };
    let drawn = damping(&state);
    let size = drawn.norm_max();
    assert!(size > 0.0);
    state.orientations[0] = UnitQuaternion::new(Vector3::new(0.3, -0.2, 2.0));
    state.orientations[1] = UnitQuaternion::new(Vector3::new(1.0, 0.4, -1.5));
    state.origins[1] += Vector3::new(3.0, -2.0, 1.0);
    let gone = damping(&state);
    for body in &system.bodies {
        for i in body.velocities.clone().take(6) {
            for j in 0..system.velocity_count() {
                assert!(gone[(i, j)].abs() + gone[(j, i)].abs() < 1e-12 * size);
            }
        }
    }
    assert!((gone - drawn).norm_max() < 1e-12 * size);
}

/// What a vibration in the lowest mode loses is what the damping takes.
#[test]
fn energy_is_lost_by_the_damping_alone() {
    let (system, mut state) = damped(double_pendulum(0.0), &modal(&[0.02]));
    let lowest = Eigenmodes::at(&system, &state).unwrap().modes[2].clone();
    let shape: Vec<f64> = lowest.shape.iter().map(|part| 1e-3 * part).collect();
    state.shift(&system, &shape);
    let lowest = lowest.frequency();
    let method = method(Formulation::StabilizedIndex2, 1.0);
    let (mut simulation, _) =
        Simulation::start(system, state, method, RedundantConstraints::MinimumNorm).unwrap();
    let mut evaluation = Evaluation::of(simulation.system());
    evaluation.refresh(simulation.system(), simulation.state());
    let mut works = Works::at_start(simulation.system(), simulation.state(), &evaluation);
    let start = Energy::at(simulation.system(), simulation.state(), &mut evaluation).total();
    let step = 1.0 / (200.0 * lowest);
    for _ in 0..600 {
        simulation.step(step).unwrap();
        let (system, state) = (simulation.system(), simulation.state());
        evaluation.refresh(system, state);
        works.advance(system, state, &evaluation, step);
    }
    let end = Energy::at(simulation.system(), simulation.state(), &mut evaluation).total();
    println!("{start:e} {end:e} {:e}", works.dissipated);
    assert!(works.dissipated > 0.1 * start);
    assert!((start - end - works.dissipated).abs() < 0.02 * start);
}

/// Shares of bodies and of a bushing by its name add up to zᵀCz of the assembled linearization.
#[test]
fn shares_of_parts_add_up_to_the_whole() {
    let mut builder = double_pendulum(0.01);
    let lower = 1;
    let tip = builder.marker(lower, 1, Turning::Interface).unwrap();
    let place = builder.frame(tip).position;
    let wall = builder.ground(place, Matrix3::identity());
    let direction = Vector3::y_axis();
    let along = Measure::Displacement(Displacement { direction });
    builder.spring("mount", wall, tip, [(along, linear(0.0, 1e4, 3.0))]);
    let (system, state) = builder.finish();
    let evaluation = Evaluation::at(&system, &state);
    let linear = Linearization::at(&system, &state, &evaluation).unwrap();
    let found = damping_by_part(&system, &state, 6).unwrap();
    let (undamped, rest) = {
        let mut quiet = double_pendulum(0.0);
        let tip = quiet.marker(lower, 1, Turning::Interface).unwrap();
        let wall = quiet.ground(place, Matrix3::identity());
        quiet.spring("mount", wall, tip, [(along, self::linear(0.0, 1e4, 0.0))]);
        quiet.finish()
    };
    let modes = Eigenmodes::at(&undamped, &rest).unwrap();
    let modes = modes
        .modes
        .iter()
        .filter(|mode| mode.angular_frequency > 0.0);
    let mut mounted = 0.0_f64;
    for (part, mode) in found.iter().zip(modes) {
        let form = |matrix: &faer::Mat<f64>| -> f64 {
            let z = &mode.shape;
            let rows = (0..z.len()).map(|i| (0..z.len()).map(move |j| (i, j)));
            rows.flatten()
                .map(|(i, j)| z[i] * matrix[(i, j)] * z[j])
                .sum()
        };
        let whole = 0.5 * form(&linear.damping) / (mode.angular_frequency * form(&linear.mass));
        let sum: f64 = part.shares.iter().map(|share| share.ratio).sum();
        assert_eq!(sum, part.ratio);
        assert!(
            (part.ratio / whole - 1.0).abs() < 1e-6,
            "{part:?} {whole:e}"
        );
        assert_eq!(part.shares.len(), 3);
        let mount = part
            .shares
            .iter()
            .find(|share| share.name == "mount")
            .unwrap();
        assert_eq!(mount.part, DampedPart::Spring);
        mounted = mounted.max(mount.ratio);
    }
    assert!(mounted > 1e-4, "{mounted:e}");
}

#[test]
fn ratios_and_frequencies_that_belong_to_no_mode_are_refused() {
    let (system, state) = double_pendulum(0.0).finish();
    let message = |asked: &AssembledDamping| {
        damped_amplitudes(&system, &state, asked)
            .unwrap_err()
            .to_string()
    };
    let found = message(&modal(&[0.01; 200]));
    assert!(
        found.contains("damping.assembled_modal") && found.contains("lists 200 ratios"),
        "{found}"
    );
    let points = RayleighPoints {
        frequencies: [1.0, 1e9],
        ratios: [0.01, 0.9],
    };
    let found = message(&AssembledDamping {
        assembled_rayleigh: Some(points),
        ..AssembledDamping::default()
    });
    assert!(found.contains("above that of every mode"), "{found}");
}
