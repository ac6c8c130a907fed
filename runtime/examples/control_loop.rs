//! A controller in the loop: a torque holds a pendulum upright, and from a saved state two different futures are tried.
//!
//! `cargo run --release -p dcb-runtime --example control_loop` prints how far the pendulum is from the upright position.

use std::path::Path;

use dcb_runtime::{Error, Mechanism, Scene};

const SCENE: &str = r#"{
  "dimension": 2, "units": {"length": "m", "mass": "kg", "time": "s"}, "gravity": [0, -9.81],
  "bodies": {"arm": {"rigid": {"mass": 1, "inertia": 0.02, "points": {"pivot": [0, -0.5]}}, "position": [0.1, 0.49], "orientation": -0.2}},
  "joints": {"pivot": {"revolute": {"a": "ground", "b": "arm/pivot"}}},
  "loads": {"motor": {"torque": {"at": "arm/pivot", "components": [{"input": {"initial": 0}}]}}},
  "outputs": {"angle": {"joint_coordinate": {"joint": "pivot"}}, "rate": {"joint_rate": {"joint": "pivot"}}},
  "integrator": {"generalized_alpha": {"step": 1e-3, "end": 1}}
}"#;

/// Proportional and differential control for a time, s; the angle at its end.
fn control(mechanism: &mut Mechanism, gains: [f64; 2], duration: f64) -> Result<f64, Error> {
    let end = mechanism.time() + duration;
    while mechanism.time() < end - 1e-9 {
        let angle = mechanism.output("angle")?[0];
        let rate = mechanism.output("rate")?[0];
        mechanism.set_input("motor", -gains[0] * angle - gains[1] * rate)?;
        mechanism.step(1e-3)?;
    }
    Ok(mechanism.output("angle")?[0])
}

/// Tries two futures of the same pendulum, and one of them twice.
///
/// # Errors
/// Any error of the start or of a step.
pub fn main() -> Result<(), Error> {
    let scene = Scene::parse(SCENE, Path::new("pendulum.json"))?;
    let mut mechanism = Mechanism::start(&scene)?;
    let start = mechanism.output("angle")?[0];
    let saved = mechanism.save();
    println!("at the start          {start:8.4} rad");
    let strong = control(&mut mechanism, [40.0, 5.0], 1.0)?;
    println!("with a strong control {strong:8.4} rad");
    mechanism.restore(&saved)?;
    let weak = control(&mut mechanism, [4.0, 0.5], 1.0)?;
    println!("with a weak control   {weak:8.4} rad");
    mechanism.restore(&saved)?;
    let again = control(&mut mechanism, [40.0, 5.0], 1.0)?;
    println!(
        "and again             {again:8.4} rad, the same to the last bit: {}",
        again == strong
    );
    Ok(())
}
