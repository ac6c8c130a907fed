//! Flexible bodies in motions with a closed form or a conserved quantity: a bar spun about its end, a free body, a cantilever
//! in turned positions.
#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

use std::sync::Arc;

use dcb_formats::component::Damping;
use dcb_formats::mesh::{Dimension, Direction};
use dcb_reducer::Reduced;
use dcb_runtime::energy::momentum;
use dcb_runtime::function::{Function, TimeFunction};
use dcb_runtime::joint::{Fixed, JointKind};
use dcb_runtime::simulation::Simulation;
use dcb_runtime::system::builder::{Drawn, JointCoordinate};
use dcb_runtime::system::{Signal, State};
use dcb_runtime::{Compatibility, FlexibleBody};
use dcb_samples::spatial_beam::{BeamSection, SpatialBeam};
use dcb_samples::{reference_hexahedra, spatial_beam};
use dcb_tests::lowest;
use dcb_tests::mechanism::{Scene, method, revolute, run, start};
use nalgebra::{UnitQuaternion, Vector3};

/// A steel beam of 1 m along x, clamped or hinged at a; b is free.
fn beam(elements: usize, modes: usize, damping: f64) -> (Reduced, Arc<FlexibleBody>) {
    let mut component = spatial_beam(&SpatialBeam {
        elements,
        section: BeamSection::rectangle(0.02, 0.03),
        ..SpatialBeam::default()
    });
    component.damping = Damping::Uniform(damping);
    let reduced = lowest(&component, modes);
    let body = FlexibleBody::from_superelement(&reduced.superelement, Compatibility::Strong);
    (reduced, Arc::new(body.unwrap()))
}

/// Displacement along x of every node against the node at the axis.
fn stretch(reduced: &Reduced, body: &FlexibleBody, y: &[f64]) -> Vec<(usize, f64)> {
    let mut amplitudes = vec![0.0; body.original_coordinate_count()];
    body.original_coordinates(y, &mut amplitudes);
    let recovery = &reduced.recovery;
    let modes = recovery.modes.ncols();
    let displacement = |row: usize| -> f64 {
        let entries = amplitudes.iter().enumerate();
        entries
            .map(|(k, x)| {
                x * if k < modes {
                    recovery.modes[(row, k)]
                } else {
                    recovery.residual[(row, k - modes)]
                }
            })
            .sum()
    };
    let along: Vec<(usize, f64)> = (recovery.dofs.iter().enumerate())
        .filter(|(_, dof)| dof.direction == Direction::Ux)
        .map(|(row, dof)| (dof.node as usize, displacement(row)))
        .collect();
    let at_axis = along.iter().find(|(node, _)| *node == 0).unwrap().1;
    along
        .into_iter()
        .map(|(node, u)| (node, u - at_axis))
        .collect()
}

/// A bar of density ρ and modulus E that turns about its end at ω stretches by u = ρ ω² / (2 E) (x L² - x³ / 3)
/// (code_aster, test SSNV/V3.04.104). Softening, u ω² ρ against E u'', is below 1e-5 here.
#[test]
fn bar_spun_about_its_end_stretches() {
    let (elements, speed) = (8, 60.0);
    let material = SpatialBeam::default().material;
    let (reduced, body) = beam(elements, 48, 0.5);
    let mut scene = Scene::new(Dimension::Spatial, Vector3::zeros());
    let bar = scene.body(&body, &Drawn::default());
    let (ground, end) = (scene.ground([0.0; 3]), scene.on(bar, 0));
    let bearing = scene.join(&revolute(Vector3::z()), ground, end);
    // The angular velocity rises smoothly and stays, to 1e-9 from 0.8 s on.
    let rise = format!("{speed}*(1 + tanh(20*(t - 0.25)))/2");
    let function = TimeFunction::integral_of(&Function::Formula(rise), 4.0).unwrap();
    let signal = scene.builder().signal(Signal {
        function,
        input: None,
        offset: 0.0,
    });
    let angle = bearing.coordinate(JointCoordinate::Rotation).unwrap();
    scene.builder().drive("motor", &bearing, angle, signal);
    let (mut simulation, _) = scene.start(method(0.6));
    run(&mut simulation, 3.0, 6000, |_| {});
    let unit = material.density * speed * speed / (2.0 * material.youngs_modulus);
    let tip = unit * 2.0 / 3.0;
    let mut worst: f64 = 0.0;
    for (node, found) in stretch(&reduced, &body, &simulation.state().coordinates) {
        let x = node as f64 / elements as f64;
        worst = worst.max((found - unit * (x - x.powi(3) / 3.0)).abs());
    }
    println!("tip {tip:.3e}, worst {:.2e} of it", worst / tip);
    assert!(worst < 2e-3 * tip);
}

/// A free soft box, spinning about its intermediate axis, with its first modes deflected.
fn free_box() -> (FlexibleBody, Simulation) {
    let superelement = lowest(&reference_hexahedra(), 6).superelement;
    let body = FlexibleBody::from_superelement(&superelement, Compatibility::Strong).unwrap();
    let mut scene = Scene::new(Dimension::Spatial, Vector3::zeros());
    let drawn = Drawn {
        orientation: UnitQuaternion::from_euler_angles(0.3, -0.2, 0.5),
        velocity: Vector3::new(0.3, -0.1, 0.7),
        angular_velocity: Vector3::new(0.4, 20.0, 0.6),
        ..Drawn::default()
    };
    scene.body(&Arc::new(body.clone()), &drawn);
    let (system, mut state) = scene.finish();
    for (k, y) in state.coordinates.iter_mut().take(6).enumerate() {
        *y = 0.01 / (1.0 + k as f64);
    }
    (body, start(system, state, method(0.9)).0)
}

fn momenta(simulation: &mut Simulation) -> (Vector3<f64>, Vector3<f64>) {
    let (system, state): (_, State) = (simulation.system().clone(), simulation.state().clone());
    momentum(&system, &state, simulation.refresh())
}

/// Nothing acts on a free body: its linear momentum stays to rounding, angular momentum and energy to the order of the method.
#[test]
fn free_body_keeps_its_momenta() {
    let drifts = [4000, 8000].map(|steps| {
        let (_, mut simulation) = free_box();
        let (p, l) = momenta(&mut simulation);
        simulation.refresh();
        let energy = simulation.energy().0.total();
        run(&mut simulation, 0.2, steps, |_| {});
        let (p_now, l_now) = momenta(&mut simulation);
        simulation.refresh();
        let energy_now = simulation.energy().0.total();
        assert!((p_now - p).norm() < 1e-11 * p.norm());
        // Angular momentum about the world's origin, which the centre has left.
        [
            (l_now - l).norm() / l.norm(),
            (energy_now / energy - 1.0).abs(),
        ]
    });
    println!("{drifts:?}");
    for k in 0..2 {
        assert!(drifts[1][k] < 1e-4);
        assert!(drifts[0][k] / drifts[1][k] > 3.4, "{drifts:?}");
    }
}

/// A clamped beam turned from the horizontal by `angle`: what its own weight makes of its end.
fn cantilever(angle: f64) -> (f64, f64) {
    let (_, body) = beam(8, 20, 0.5);
    let mut scene = Scene::new(Dimension::Spatial, Vector3::new(0.0, 0.0, -9.81));
    let turn = UnitQuaternion::from_axis_angle(&Vector3::y_axis(), -angle);
    let drawn = Drawn {
        orientation: turn,
        ..Drawn::default()
    };
    let bar = scene.body(&body, &drawn);
    let (ground, clamped, free) = (scene.ground([0.0; 3]), scene.on(bar, 0), scene.on(bar, 1));
    scene.join(&JointKind::Fixed(Fixed), ground, clamped);
    let (mut simulation, _) = scene.start(method(0.5));
    run(&mut simulation, 3.0, 3000, |_| {});
    let tip = simulation.refresh().motions[free].position;
    let moved = turn.inverse() * tip - Vector3::x();
    (moved.x, moved.z)
}

/// In axes of the turned clamp the end sinks by ρ A g L⁴ cos / (8 E I), and a standing beam is shorter by ρ g L² / (2 E). The
/// linear theory is of first order in the deflection, 6e-4 here.
#[test]
fn turned_cantilevers_bend_under_their_weight() {
    let material = SpatialBeam::default().material;
    let section = BeamSection::rectangle(0.02, 0.03);
    let weight = material.density * 9.81;
    let sag = weight * section.area / (8.0 * material.youngs_modulus * section.second_moment_y);
    for degrees in [0.0_f64, 30.0, 75.0, 120.0] {
        let angle = degrees.to_radians();
        let (_, across) = cantilever(angle);
        let expected = -sag * angle.cos();
        println!("{degrees} degrees: {across:.5e} for {expected:.5e}");
        assert!((across - expected).abs() < 5e-4 * sag);
    }
    let shortening = weight / (2.0 * material.youngs_modulus);
    let (along, across) = cantilever(std::f64::consts::FRAC_PI_2);
    println!(
        "standing: {along:.5e} for {:.5e}, {across:.1e}",
        -shortening
    );
    assert!((along + shortening).abs() < 5e-3 * shortening);
    assert!(across.abs() < 1e-6 * sag);
}
