//! Static equilibrium against closed forms and against a motion that has died out.

use std::sync::Arc;

use crate::support::Part;
use crate::support::mechanisms::{about_z, linear, method, rigid};
use dcb_formats::mesh::Dimension;
use dcb_formats::scene::RedundantConstraints;
use dcb_runtime::Error;
use dcb_runtime::analysis::equilibrium::{
    EquilibriumReport, EquilibriumSettings, find_equilibrium,
};
use dcb_runtime::integrator::Formulation;
use dcb_runtime::joint::{Fixed, JointKind, Spherical};
use dcb_runtime::measure::{Displacement, Elongation, Measure, Rotation};
use dcb_runtime::simulation::Simulation;
use dcb_runtime::system::builder::{Drawn, SystemBuilder, Turning};
use dcb_runtime::system::{State, System};
use dcb_samples::spatial_beam::BeamSection;
use dcb_samples::{Material, SpatialBeam, spatial_beam};
use nalgebra::{Matrix3, UnitQuaternion, Vector3};

const GRAVITY: Vector3<f64> = Vector3::new(0.0, -9.81, 0.0);

fn rest(system: &System, state: &mut State) -> EquilibriumReport {
    find_equilibrium(system, state, &EquilibriumSettings::default()).unwrap()
}

/// 1 m × 0.1 m × 0.1 m, E = 1e8 Pa, 1000 kg/m³.
fn soft_beam() -> Part {
    let beam = SpatialBeam {
        section: BeamSection::rectangle(0.1, 0.1),
        material: Material {
            youngs_modulus: 1e8,
            poisson_ratio: 0.3,
            density: 1000.0,
        },
        ..SpatialBeam::default()
    };
    Part::reduced(spatial_beam(&beam), 8)
}

fn height(system: &System, state: &State, marker: usize) -> f64 {
    let mut evaluation = dcb_runtime::system::evaluation::Evaluation::of(system);
    evaluation.place(system, state);
    evaluation.motions[marker].position.y
}

#[test]
fn clamped_beam_hangs_down_by_its_own_weight() {
    let mut builder = SystemBuilder::new(Dimension::Spatial, GRAVITY);
    let body = builder.body("beam", Arc::new(soft_beam().body), &Drawn::default());
    let root = builder.marker(body, 0, Turning::Interface).unwrap();
    let tip = builder.marker(body, 1, Turning::Interface).unwrap();
    let ground = builder.ground(Vector3::zeros(), Matrix3::identity());
    builder
        .joint("clamp", ground, root, &JointKind::Fixed(Fixed))
        .unwrap();
    let (system, mut state) = builder.finish();
    let report = rest(&system, &mut state);
    // ρ A g L⁴ / (8 E I)
    let found = -height(&system, &state, tip);
    assert!((found / 0.014715 - 1.0).abs() < 2e-3, "{found} {report:?}");
    // The clamp carries the weight and its moment.
    assert!(
        (state.forces[1].abs() / (10.0 * 9.81) - 1.0).abs() < 1e-8,
        "{:?}",
        state.forces
    );
}

#[test]
fn pendulum_hangs_down_wherever_it_starts() {
    // Level too, where gravity gives it no stiffness.
    let level = std::f64::consts::FRAC_PI_2 - 1e-3;
    for angle in [0.3, 1.5, level, 3.0, std::f64::consts::PI, 4.0] {
        let body = rigid(
            Dimension::Spatial,
            2.0,
            Vector3::new(0.1, 0.2, 0.3),
            &[Vector3::new(0.0, 0.5, 0.0)],
        );
        let mut builder = SystemBuilder::new(Dimension::Spatial, GRAVITY);
        let turn = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), angle + 1e-3);
        let drawn = Drawn {
            position: turn * Vector3::new(0.1, -0.5, 0.0),
            orientation: turn,
            ..Drawn::default()
        };
        let bar = builder.body("bar", body, &drawn);
        let end = builder.marker(bar, 0, Turning::Interface).unwrap();
        let ground = builder.ground(Vector3::zeros(), Matrix3::identity());
        builder.joint("hinge", ground, end, &about_z()).unwrap();
        let (system, mut state) = builder.finish();
        let report = rest(&system, &mut state);
        let off = (state.origins[0] - Vector3::new(0.0, -0.5, 0.0)).norm();
        assert!(off < 1e-9, "{angle}: {off:e} {report:?}");
        let carried = Vector3::new(state.forces[0], state.forces[1], state.forces[2]).norm();
        assert!((carried / (2.0 * 9.81) - 1.0).abs() < 1e-9);
        let stiffness = 2.0 * 9.81 * 0.5 / (0.3 + 2.0 * 0.25);
        assert!((report.least_stiffness / stiffness - 1.0).abs() < 1e-6);
    }
}

/// Two bodies in series, soft and very stiff: elongations are weights over stiffnesses.
#[test]
fn springs_and_stiff_bushings_share_the_weight() {
    let body = |mass| {
        let ends = [Vector3::new(0.0, 0.2, 0.0), Vector3::new(0.0, -0.2, 0.0)];
        rigid(Dimension::Spatial, mass, Vector3::new(0.1, 0.2, 0.3), &ends)
    };
    let mut builder = SystemBuilder::new(Dimension::Spatial, GRAVITY);
    let drawn = |x: f64, y: f64| Drawn {
        position: Vector3::new(x, y, 0.02),
        orientation: UnitQuaternion::new(Vector3::new(0.1, 0.0, 0.4)),
        ..Drawn::default()
    };
    let upper = builder.body("upper", body(3.0), &drawn(0.1, -0.2));
    let lower = builder.body("lower", body(5.0), &drawn(0.2, -1.3));
    let top = builder.ground(Vector3::zeros(), Matrix3::identity());
    let [a, b] = [0, 1].map(|i| builder.marker(upper, i, Turning::Interface).unwrap());
    let c = builder.marker(lower, 0, Turning::Interface).unwrap();
    let mut bushing = Vec::new();
    for direction in [Vector3::x_axis(), Vector3::y_axis(), Vector3::z_axis()] {
        let place = Measure::Displacement(Displacement { direction });
        let rest = Matrix3::identity();
        let turn = Measure::Rotation(Rotation { direction, rest });
        bushing.push((place, linear(0.0, 1e10, 0.0)));
        bushing.push((turn, linear(0.0, 1e10, 0.0)));
    }
    builder.spring("bushing", top, a, bushing);
    let line = Measure::Elongation(Elongation { length: 1.0 });
    builder.spring("spring", b, c, [(line, linear(0.5, 200.0, 0.0))]);
    let (system, mut state) = builder.finish();
    let report = rest(&system, &mut state);
    let sag = -0.2 - state.origins[0].y;
    assert!(
        (sag / (8.0 * 9.81 / 1e10) - 1.0).abs() < 1e-6,
        "{sag:e} {report:?}"
    );
    let hanging = -0.4 - 0.5 - 5.0 * 9.81 / 200.0 - 0.2;
    assert!(
        (state.origins[1].y - hanging).abs() < 1e-7,
        "{:?} {report:?}",
        state.origins
    );
    assert!(state.origins[1].x.abs() < 1e-7);
}

#[test]
fn a_damped_motion_dies_out_where_the_equilibrium_is() {
    let mut part = soft_beam();
    part.body.damping.fill(0.4);
    let mut builder = SystemBuilder::new(Dimension::Spatial, GRAVITY);
    let body = builder.body("beam", Arc::new(part.body), &Drawn::default());
    let root = builder.marker(body, 0, Turning::Interface).unwrap();
    let tip = builder.marker(body, 1, Turning::Interface).unwrap();
    let ground = builder.ground(Vector3::zeros(), Matrix3::identity());
    builder
        .joint("ball", ground, root, &JointKind::Spherical(Spherical))
        .unwrap();
    let anchor = builder.ground(Vector3::new(1.0, 0.5, 0.3), Matrix3::identity());
    let line = Measure::Elongation(Elongation { length: 1.0 });
    builder.spring("line", anchor, tip, [(line, linear(0.3, 150.0, 40.0))]);
    let side = builder.ground(Vector3::new(1.0, 0.1, -0.7), Matrix3::identity());
    builder.spring("side", side, tip, [(line, linear(0.5, 80.0, 30.0))]);
    let direction = Vector3::x_axis();
    let rest_axes = Matrix3::identity();
    let turn = Measure::Rotation(Rotation {
        direction,
        rest: rest_axes,
    });
    builder.spring("roll", ground, root, [(turn, linear(0.0, 20.0, 5.0))]);
    let (system, drawn) = builder.finish();
    let mut state = drawn.clone();
    rest(&system, &mut state);
    let method = method(Formulation::Index3, 0.5);
    let (mut simulation, _) = Simulation::start(
        system.clone(),
        drawn,
        method,
        RedundantConstraints::MinimumNorm,
    )
    .unwrap();
    for _ in 0..1500 {
        simulation.step(0.01).unwrap();
    }
    let died = simulation.state();
    let off = (died.origins[0] - state.origins[0]).norm();
    let turned = died.orientations[0].angle_to(&state.orientations[0]);
    assert!(off < 1e-6 && turned < 1e-6, "{off:e} {turned:e}");
    for (found, expected) in died.forces.iter().zip(&state.forces) {
        assert!(
            (found - expected).abs() < 1e-4,
            "{:?} {:?}",
            died.forces,
            state.forces
        );
    }
}

#[test]
fn a_body_that_falls_for_ever_is_refused() {
    let body = rigid(Dimension::Spatial, 2.0, Vector3::new(0.1, 0.2, 0.3), &[]);
    let mut builder = SystemBuilder::new(Dimension::Spatial, GRAVITY);
    builder.body("stone", body, &Drawn::default());
    let (system, mut state) = builder.finish();
    match find_equilibrium(&system, &mut state, &EquilibriumSettings::default()) {
        Err(Error::NoEquilibrium { body, .. }) => assert_eq!(body, "stone"),
        other => panic!("{other:?}"),
    }
}
