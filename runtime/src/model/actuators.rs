//! Actuators of a scene, to rows of the system.

use super::Names;
use super::couplings::input_of;
use crate::actuator::{EndStop, Friction, Limit, Servo, Source};
use crate::error::Error;
use crate::system::Signal;
use crate::system::builder::{JointCoordinate, SystemBuilder};
use dcb_formats::function::{Function, TimeFunction};
use dcb_formats::scene::{self, ActuatedCoordinate, Actuator, Saturation, Scene};

/// Adds an actuator.
pub(super) fn add_actuator(
    scene: &Scene,
    builder: &mut SystemBuilder,
    names: &mut Names,
    name: &str,
    actuator: &Actuator,
) -> Result<(), Error> {
    let location = format!("actuators.{name}.{}", actuator.kind());
    let at = format!("{location}.joint");
    let missing = || Error::described(&at, "has no such coordinate");
    let described = scene.joints.get(actuator.joint()).ok_or_else(missing)?;
    let which = match actuator.coordinate(described) {
        ActuatedCoordinate::Angle => JointCoordinate::Rotation,
        ActuatedCoordinate::Position => JointCoordinate::Translation,
    };
    let joint = names.joints.get(actuator.joint()).ok_or_else(missing)?;
    let built = joint.built.clone().ok_or_else(missing)?;
    let measure = built.coordinate(which).ok_or_else(missing)?;
    let zero = joint.zero(which);
    let mut signal = |function: &Function, key: &str| {
        let time_function = TimeFunction::new(function)
            .map_err(|error| error.within(&format!("{location}{key}")))?;
        let input = input_of(builder, name, function);
        Ok::<usize, Error>(builder.signal(Signal {
            function: time_function,
            input,
            offset: 0.0,
        }))
    };
    let source = match actuator {
        Actuator::Torque(of) | Actuator::Force(of)
            if let Function::Controller(controller) = &of.function =>
        {
            let index = scene.controllers.get_index_of(controller);
            let unknown = || Error::described(&location, "names no controller of the scene");
            Source::Controlled(index.ok_or_else(unknown)?)
        }
        Actuator::Torque(of) | Actuator::Force(of) => Source::Given(signal(&of.function, "")?),
        Actuator::Servo(of) => Source::Servo(servo(of), signal(&of.target, ".target")?),
        Actuator::Friction(of) => Source::Friction(friction(of)),
        Actuator::EndStop(of) => Source::EndStop(EndStop {
            lower: of.lower.unwrap_or(f64::NEG_INFINITY),
            upper: of.upper.unwrap_or(f64::INFINITY),
            stiffness: of.stiffness,
            damping: of.damping,
            onset: of.onset,
        }),
    };
    let connection = builder.actuator(name, &built, measure, zero, source);
    names.actuators.insert(name.to_owned(), connection);
    Ok(())
}

fn servo(of: &scene::Servo) -> Servo {
    Servo {
        proportional: of.proportional,
        derivative: of.derivative,
        integral: of.integral,
        limit: of.limit.map(|limit| match of.saturation {
            Saturation::Hard => Limit::Hard(limit),
            Saturation::Smooth => Limit::Smooth(limit),
        }),
        tracking_time: of.tracking_time.unwrap_or(of.proportional / of.integral),
        sample: of.sample,
    }
}

fn friction(of: &scene::Friction) -> Friction {
    Friction {
        coulomb: of.coulomb,
        at_rest: of.at_rest.unwrap_or(of.coulomb),
        stribeck_rate: of.stribeck_rate.unwrap_or(f64::INFINITY),
        viscous: of.viscous,
        regularization: of.regularization.unwrap_or(f64::INFINITY),
    }
}
