//! Flexible bodies in motions with a closed form or a conserved quantity: a bar spun about its end, a free body, a cantilever
//! in turned positions.

use std::sync::Arc;

use dcb_formats::component::Damping;
use dcb_formats::function::{Function, TimeFunction};
use dcb_formats::mesh::{Dimension, Direction};
use dcb_reducer::Reduced;
use dcb_runtime::joint::{Fixed, JointKind};
use dcb_runtime::momentum::Momentum;
use dcb_runtime::simulation::Simulation;
use dcb_runtime::system::builder::{Drawn, JointCoordinate};
use dcb_runtime::system::{Signal, State};
use dcb_runtime::{Compatibility, FlexibleBody};
use dcb_samples::spatial_beam::{BeamSection, SpatialBeam};
use dcb_samples::{reference_hexahedra, spatial_beam};
use nalgebra::{UnitQuaternion, Vector3};

use crate::lowest;
use crate::mechanism::{Scene, method, revolute, run, start};

/// A steel beam of 1 m along x, clamped or hinged at a; b is free.
pub fn beam(elements: usize, modes: usize, damping: f64) -> (Reduced, Arc<FlexibleBody>) {
    let component = spatial_beam(&SpatialBeam {
        elements,
        section: BeamSection::rectangle(0.02, 0.03),
        ..SpatialBeam::default()
    });
    let component = component
        .changed(|draft| draft.damping = Damping::Uniform(damping))
        .expect("a component");
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

/// What a bar does at 60 rad/s about its end, against u = ρ ω² / (2 E) (x L² - x³ / 3): u of the tip by that form, and the
/// largest difference of any node from it by u of the tip.
pub fn spun_bar() -> (f64, f64) {
    let (elements, speed) = (8, 60.0);
    let material = SpatialBeam::default().material;
    let (reduced, body) = beam(elements, 48, 0.5);
    let mut scene = Scene::new(Dimension::Spatial, Vector3::zeros());
    let bar = scene.body(&body, &Drawn::default());
    let (ground, end) = (scene.ground([0.0; 3]), scene.on(bar, 0));
    let bearing = scene.join(&revolute(Vector3::z()), ground, end);
    // The angular velocity rises smoothly and stays, to 1e-9 from 0.8 s on.
    let rise = format!("{speed}*(1 + tanh(20*(t - 0.25)))/2");
    let function = TimeFunction::integral_of(&Function::Formula(rise.into()), 4.0).unwrap();
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
    (tip, worst / tip)
}

/// A free soft box, spinning about its intermediate axis, with its first modes deflected.
fn free_box() -> Simulation {
    let superelement = lowest(&reference_hexahedra(), 6).superelement;
    let body = FlexibleBody::from_superelement(&superelement, Compatibility::Strong).unwrap();
    let mut scene = Scene::new(Dimension::Spatial, Vector3::zeros());
    let drawn = Drawn {
        orientation: UnitQuaternion::from_euler_angles(0.3, -0.2, 0.5),
        velocity: Vector3::new(0.3, -0.1, 0.7),
        angular_velocity: Vector3::new(0.4, 20.0, 0.6),
        ..Drawn::default()
    };
    scene.body(&Arc::new(body), &drawn);
    let (system, mut state) = scene.finish();
    for (k, y) in state.coordinates.iter_mut().take(6).enumerate() {
        *y = 0.01 / (1.0 + k as f64);
    }
    start(system, state, method(0.9)).0
}

fn momenta(simulation: &mut Simulation) -> (Vector3<f64>, Vector3<f64>) {
    let (system, state): (_, State) = (simulation.system().clone(), simulation.state().clone());
    let found = Momentum::of_all(&system, &state, simulation.refresh());
    (found.linear, found.angular)
}

/// A free box for 0.2 s: changes of linear momentum, of angular momentum about the world's origin, which the centre has left, and
/// of the energy, each by its start.
pub fn free_body_drifts(steps: usize) -> [f64; 3] {
    let mut simulation = free_box();
    let (p, l) = momenta(&mut simulation);
    simulation.refresh();
    let energy = simulation.energy().0.total();
    run(&mut simulation, 0.2, steps, |_| {});
    let (p_now, l_now) = momenta(&mut simulation);
    simulation.refresh();
    let energy_now = simulation.energy().0.total();
    [
        (p_now - p).norm() / p.norm(),
        (l_now - l).norm() / l.norm(),
        (energy_now / energy - 1.0).abs(),
    ]
}

/// A clamped beam turned from the horizontal by `angle`: what its own weight makes of its end.
pub fn cantilever(angle: f64) -> (f64, f64) {
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

/// What linear theory says of the cantilever's end: drawn in by ρ g L² / (2 E) where it stands on its clamp, sunk by
/// ρ A g L⁴ / (8 E I) where it is horizontal.
pub fn weight_deflections() -> (f64, f64) {
    let material = SpatialBeam::default().material;
    let section = BeamSection::rectangle(0.02, 0.03);
    let weight = material.density * 9.81;
    let sag = weight * section.area / (8.0 * material.youngs_modulus * section.second_moment_y);
    let shortening = weight / (2.0 * material.youngs_modulus);
    (shortening, sag)
}
