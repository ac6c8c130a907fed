//! A slider-crank that a drive turns, against closed forms and the balance of power.

use crate::support::mechanisms::{about_z, formula, rigid};
use dcb_formats::mesh::Dimension;
use dcb_runtime::Error;
use dcb_runtime::analysis::driven::DrivenMotion;
use dcb_runtime::energy::Energy;
use dcb_runtime::joint::{JointKind, PointOnLine};
use dcb_runtime::system::builder::{Drawn, JointCoordinate, SystemBuilder, Turning};
use dcb_runtime::system::evaluation::Evaluation;
use dcb_runtime::system::{ConnectionKind, State, System};
use nalgebra::{Matrix3, Vector3};

const CRANK: f64 = 0.15;
const ROD: f64 = 0.4;

/// Crank and rod drawn stretched out along x; the rod's end slides on x.
fn slider_crank(driven: Option<&str>) -> (System, State) {
    let bar = |length: f64, mass: f64| {
        let ends = [-0.5 * length, 0.5 * length].map(|x| Vector3::new(x, 0.0, 0.0));
        let inertia = Vector3::repeat(mass * length * length / 12.0);
        rigid(Dimension::Planar, mass, inertia, &ends)
    };
    let mut builder = SystemBuilder::new(Dimension::Planar, Vector3::new(0.0, -9.81, 0.0));
    let at = |x: f64| Drawn {
        position: Vector3::new(x, 0.0, 0.0),
        ..Drawn::default()
    };
    let crank = builder.body("crank", bar(CRANK, 0.4), &at(0.5 * CRANK));
    let rod = builder.body("rod", bar(ROD, 0.7), &at(CRANK + 0.5 * ROD));
    let mut marker = |body, index| builder.marker(body, index, Turning::Interface).unwrap();
    let [a, b] = [marker(crank, 0), marker(crank, 1)];
    let [c, d] = [marker(rod, 0), marker(rod, 1)];
    let ground = builder.ground(Vector3::zeros(), Matrix3::identity());
    let axle = builder.joint("axle", ground, a, &about_z()).unwrap();
    builder.joint("pin", b, c, &about_z()).unwrap();
    let line = JointKind::PointOnLine(PointOnLine {
        direction: Vector3::x(),
    });
    builder.joint("guide", ground, d, &line).unwrap();
    if let Some(angle) = driven {
        let signal = builder.signal(formula(angle));
        let measure = axle.coordinate(JointCoordinate::Rotation).unwrap();
        builder.drive("motor", &axle, measure, signal);
    }
    builder.finish()
}

/// Evaluation with velocities and accelerations of the markers.
fn evaluated(system: &System, state: &State) -> Evaluation {
    let mut evaluation = Evaluation::of(system);
    evaluation.place(system, state);
    evaluation.add_velocities(system, state);
    evaluation.add_accelerations(system, state);
    evaluation.measure(system, state);
    evaluation
}

#[test]
fn slider_moves_as_the_crank_says_and_the_drive_gives_the_power() {
    let (system, drawn) = slider_crank(Some("0.2+7*t+3*t^2"));
    let (mut motion, _) = DrivenMotion::start(&system, drawn).unwrap();
    let energy = |state: &State| {
        let mut evaluation = evaluated(&system, state);
        Energy::at(&system, state, &mut evaluation).total()
    };
    let drive = system
        .connections
        .iter()
        .find(|connection| connection.kind == ConnectionKind::Drive)
        .unwrap();
    let slider = system.bodies[1].markers[1];
    for step in 1..=100 {
        let time = 0.02 * f64::from(step);
        let small = 1e-5;
        let before = energy(motion.advance_to(time - small).unwrap());
        let state = motion.advance_to(time).unwrap().clone();
        let after = energy(motion.advance_to(time + small).unwrap());
        let (angle, rate, second) = (0.2 + 7.0 * time + 3.0 * time * time, 7.0 + 6.0 * time, 6.0);
        // x = r cos θ + s, s = √(l² - r² sin² θ), s s' = -r² sin θ cos θ θ'
        let (sin, cos) = angle.sin_cos();
        let s = (ROD * ROD - CRANK * CRANK * sin * sin).sqrt();
        let lever = -CRANK * sin - CRANK * CRANK * sin * cos / s;
        let s_slope = -CRANK * CRANK * sin * cos / s;
        let bend = -CRANK * cos - (CRANK * CRANK * (cos * cos - sin * sin) + s_slope * s_slope) / s;
        let found = evaluated(&system, &state).motions[slider];
        let error = (found.position.x - (CRANK * cos + s)).abs();
        assert!(error < 1e-12, "t = {time}: position {error:e}");
        let error = (found.velocity.x - lever * rate).abs();
        assert!(error < 1e-11, "t = {time}: velocity {error:e}");
        let error = (found.acceleration.x - (lever * second + bend * rate * rate)).abs();
        assert!(error < 1e-9, "t = {time}: acceleration {error:e}");
        let power = (after - before) / (2.0 * small);
        let given = state.forces[drive.rows.start] * rate;
        assert!(
            (given - power).abs() < 1e-5,
            "t = {time}: {given} against {power}"
        );
        assert!(found.position.y.abs() < 1e-12);
    }
}

#[test]
fn degrees_of_freedom_without_a_drive_are_counted_and_refused() {
    let (system, drawn) = slider_crank(None);
    match DrivenMotion::start(&system, drawn) {
        Err(Error::NotDriven { count }) => assert_eq!(count, 1),
        Err(other) => panic!("{other}"),
        Ok(_) => panic!("accepted"),
    }
}
