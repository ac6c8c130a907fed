//! A scene written in Rust, without a file: a crank that a motor turns and a block that hangs on it by a spring.
//!
//! `cargo run --release -p dcb-runtime --example mechanism_in_rust` prints time, the block's height and the motor's torque.

use dcb_formats::Function;
use dcb_formats::mesh::Dimension;
use dcb_formats::scene::{
    AtPlace, AxisJoint, Body, BodyKind, Characteristic, Drive, DriveFunction, Integrator, Joint,
    LineSpring, Named, OfDrive, Output, Point, RigidBody, RotaryInertia, Spring,
};
use dcb_runtime::{Error, Mechanism, Scene};

fn rigid(mass: f64, inertia: f64, points: &[(&str, [f64; 2])]) -> BodyKind {
    let point = |(name, at): &(&str, [f64; 2])| {
        let coordinates = Point::Coordinates(at.to_vec());
        ((*name).to_owned(), coordinates)
    };
    BodyKind::Rigid(RigidBody {
        mass,
        inertia: RotaryInertia::Planar(inertia),
        center_of_mass: None,
        points: points.iter().map(point).collect::<Named<Point>>(),
    })
}

fn scene() -> Scene {
    let mut scene = Scene::new(Dimension::Planar);
    scene.gravity = Some(vec![0.0, -9.81]);
    let crank = rigid(0.5, 2e-3, &[("axle", [0.0, 0.0]), ("pin", [0.1, 0.0])]);
    let block = rigid(1.0, 5e-3, &[("hook", [0.0, 0.05])]);
    scene.bodies.insert("crank".into(), Body::at_origin(crank));
    scene.bodies.insert(
        "block".into(),
        Body {
            position: Some(vec![0.1, -0.4]),
            ..Body::at_origin(block)
        },
    );
    let axle = Joint::Revolute(AxisJoint {
        a: "ground".into(),
        b: "crank/axle".into(),
        ..AxisJoint::default()
    });
    scene.joints.insert("axle".into(), axle);
    let motor = Drive::Speed(DriveFunction {
        joint: "axle".into(),
        function: Function::Formula("5*(1 - exp(-4*t))".into()),
    });
    scene.drives.insert("motor".into(), motor);
    let spring = Spring::Spring(LineSpring {
        a: "crank/pin".into(),
        b: "block/hook".into(),
        stiffness: Characteristic::Linear(400.0),
        damping: Characteristic::Linear(2.0),
        ..LineSpring::default()
    });
    scene.springs.insert("spring".into(), spring);
    let hook = AtPlace {
        at: "block/hook".into(),
    };
    scene.outputs.insert("hook".into(), Output::Position(hook));
    let torque = OfDrive {
        drive: "motor".into(),
    };
    scene
        .outputs
        .insert("torque".into(), Output::DriveEffort(torque));
    scene.integrator = Some(Integrator::generalized_alpha(1e-3, 2.0));
    scene
}

/// Runs the scene for two seconds.
///
/// # Errors
/// Any error of the start or of a step.
pub fn main() -> Result<(), Error> {
    let mut mechanism = Mechanism::start(&scene())?;
    println!("time [s], height [m], torque [N m]");
    for step in 1..=2000 {
        mechanism.step(1e-3)?;
        if step % 200 == 0 {
            let height = mechanism.output("hook")?[1];
            let torque = mechanism.output("torque")?[0];
            println!("{:.1}, {height:.4}, {torque:.4}", mechanism.time());
        }
    }
    Ok(())
}
