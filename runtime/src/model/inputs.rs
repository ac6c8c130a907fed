//! What a program can set between steps: names, units, and what they are.

use dcb_formats::scene::{ActuatedCoordinate, Actuator, Drive, Joint, Load, Scene};

use super::quantities::Quantities;

/// A value that a program sets between steps.
#[derive(Clone, Debug, PartialEq)]
pub struct Input {
    /// That of the drive, load or actuator; `NAME/INDEX` where several components of a load have one.
    pub name: String,
    /// Value at the start.
    pub initial: f64,
    /// Unit, for example `N`; `1` where it has none.
    pub unit: String,
    /// One sentence for people.
    pub description: String,
}

impl Input {
    /// The input of this name.
    pub(super) fn of(scene: &Scene, name: &str, initial: f64) -> Self {
        let quantities = Quantities::of(&scene.units);
        let of_load = |name: &str| scene.loads.get(name).map(|load| loading(&quantities, load));
        let of_component = || name.rsplit_once('/').and_then(|(load, _)| of_load(load));
        let driven = scene.drives.get(name);
        let driven = driven.map(|drive| driving(scene, &quantities, drive));
        let acting = || {
            let actuator = scene.actuators.get(name)?;
            Some(acting(
                &quantities,
                actuator,
                scene.joints.get(actuator.joint())?,
            ))
        };
        let found = driven
            .or_else(|| of_load(name))
            .or_else(acting)
            .or_else(of_component);
        let (unit, description) = found.unwrap_or_else(|| ("1".into(), String::new()));
        Self {
            name: name.to_owned(),
            initial,
            unit,
            description,
        }
    }
}

/// Unit and meaning of a driven coordinate.
fn driving(scene: &Scene, quantities: &Quantities, drive: &Drive) -> (String, String) {
    let joint = &drive.motion().joint;
    let turns = match drive {
        Drive::Angle(_) => true,
        Drive::Position(_) => false,
        Drive::Speed(_) => scene.joints.get(joint).is_some_and(Joint::has_angle),
    };
    let unit = match (drive, turns) {
        (Drive::Speed(_), true) => &quantities.angular_velocity,
        (Drive::Speed(_), false) => &quantities.velocity,
        (_, true) => "rad",
        (_, false) => &quantities.length,
    };
    let what = format!("{} of joint {joint:?}, driven", drive.kind());
    (unit.to_owned(), what)
}

/// Unit and meaning of what an actuator follows: its effort, or its target.
fn acting(quantities: &Quantities, actuator: &Actuator, joint: &Joint) -> (String, String) {
    let what = match actuator {
        Actuator::Servo(_) => "target of a servo",
        _ => "effort of an actuator",
    };
    let is_angle = actuator.coordinate(joint) == ActuatedCoordinate::Angle;
    let unit = match (actuator, is_angle) {
        (Actuator::Servo(_), true) => "rad",
        (Actuator::Servo(_), false) => &quantities.length,
        (_, true) => &quantities.moment,
        (_, false) => &quantities.force,
    };
    (
        unit.to_owned(),
        format!("{what} on joint {:?}", actuator.joint()),
    )
}

/// Unit and meaning of a load.
fn loading(quantities: &Quantities, load: &Load) -> (String, String) {
    match load {
        Load::Force(load) => (
            quantities.force.clone(),
            format!("component of a force at {:?}", load.at),
        ),
        Load::Torque(load) => (
            quantities.moment.clone(),
            format!("component of a torque at {:?}", load.at),
        ),
        Load::PartLoad(load) => (
            "1".into(),
            format!("factor of load {:?} on body {:?}", load.load, load.body),
        ),
    }
}
