//! Joints, drives, springs and loads of a scene, to rows and loads of the system.

use dcb_formats::description::{listed, suggestion};
use dcb_formats::mesh::Dimension;
use nalgebra::Vector3;

use super::places::{Place, RotationNeeded, Turned, find, marker};
use super::{NamedJoint, Names};
use crate::body::Compatibility;
use crate::error::Error;
use crate::joint::{JointKind, RestPlacement};
use crate::kinematics::frame_motion::FrameMotion;
use crate::measure::Measure;
use crate::system::builder::{BuiltJoint, JointCoordinate, SystemBuilder};
use crate::system::{LoadAxes, Signal};
use dcb_formats::function::{Function, TimeFunction};
use dcb_formats::scene::{
    self, ActuatedCoordinate, Drive, Joint, Load, OrientationSource, PartLoadFunction, Scene,
    Spring,
};

/// Adds a joint.
pub(super) fn add_joint(
    scene: &Scene,
    builder: &mut SystemBuilder,
    names: &mut Names,
    name: &str,
    joint: &Joint,
    notes: &mut Vec<String>,
) -> Result<(), Error> {
    let location = format!("joints.{name}.{}", joint.kind());
    let added = match joint {
        Joint::Gear(gear) => {
            let first = coordinate(names, &gear.first, JointCoordinate::Rotation);
            let second = coordinate(names, &gear.second, JointCoordinate::Rotation);
            add_gear(builder, name, &location, first, second, gear.ratio)?
        }
        Joint::Rack(rack) => {
            let first = coordinate(names, &rack.rotation, JointCoordinate::Rotation);
            let second = coordinate(names, &rack.translation, JointCoordinate::Translation);
            add_gear(builder, name, &location, first, second, rack.radius)?
        }
        _ => add_held(scene, builder, names, name, joint, &location, notes)?,
    };
    names.joints.insert(name.to_owned(), added);
    Ok(())
}

/// A joint that holds two places.
fn add_held(
    scene: &Scene,
    builder: &mut SystemBuilder,
    names: &Names,
    name: &str,
    joint: &Joint,
    location: &str,
    notes: &mut Vec<String>,
) -> Result<NamedJoint, Error> {
    let [a, b] = joint.attachments().unwrap_or_default();
    let (at_a, at_b) = (format!("{location}.a"), format!("{location}.b"));
    let place_a = find(scene, builder, names, &at_a, a)?;
    let place_b = find(scene, builder, names, &at_b, b)?;
    let frames = [frame(builder, &place_a), frame(builder, &place_b)];
    let kind = JointKind::of(joint, location, &frames)?;
    let within = |error: Error| Error::described(location, error.to_string());
    let rest = RestPlacement::of(&frames[0], &frames[1]);
    let mut rows = kind.rows(scene.dimension, &rest).map_err(within)?;
    if matches!(joint, Joint::Distance(_)) && is_driven(scene, name) {
        // The drive holds the distance in its place, an actuator acts along it.
        rows.held.clear();
    }
    let source = joint.orientation();
    if source == Some(OrientationSource::Body) {
        notes.push(format!(
            "joint {name:?}: rotations are those of the body frames, not of the interfaces"
        ));
    }
    let driven = rows.rotation.is_some() && is_turned(scene, name);
    let mut directions = [rows.turned_a.clone(), rows.turned_b.clone()];
    if let (true, Some(rotation)) = (driven, &rows.rotation) {
        directions[0].push(rotation.axis_a);
        directions[1].push(rotation.axis_b);
    }
    let [of_a, of_b] = &directions;
    let turned = Turned::AsJointSays(source);
    let a = marker(builder, &at_a, &place_a, &rotation_needed(of_a), turned)?;
    let b = marker(builder, &at_b, &place_b, &rotation_needed(of_b), turned)?;
    let built = builder.joint_of(name, a, b, rows);
    let zero = [JointCoordinate::Rotation, JointCoordinate::Translation].map(|which| {
        let measure = built.coordinate(which);
        let is_distance = matches!(measure, Some(Measure::Elongation(_) | Measure::Angle(_)));
        match measure {
            Some(measure) if !is_distance => {
                measure.value(&builder.frame(built.a), &builder.frame(built.b))
            }
            _ => 0.0,
        }
    });
    Ok(NamedJoint {
        connection: built.connection,
        built: Some(built),
        zero,
    })
}

fn rotation_needed<'a>(directions: &'a [nalgebra::Unit<Vector3<f64>>]) -> RotationNeeded<'a> {
    if directions.is_empty() {
        RotationNeeded::None
    } else {
        RotationNeeded::About(directions)
    }
}

/// Whether a drive or an actuator acts on a joint.
fn is_driven(scene: &Scene, name: &str) -> bool {
    let mut drives = scene.drives.values();
    let mut actuators = scene.actuators.values();
    drives.any(|drive| drive.motion().joint == name)
        || actuators.any(|actuator| actuator.joint() == name)
}

/// Whether a drive, a torsion spring, an actuator, a gear or a rack acts on the angle of a joint.
fn is_turned(scene: &Scene, name: &str) -> bool {
    let drives = scene
        .drives
        .values()
        .any(|drive| !matches!(drive, Drive::Position(_)) && drive.motion().joint == name);
    let springs = scene
        .springs
        .values()
        .any(|spring| matches!(spring, Spring::TorsionSpring(spring) if spring.joint == name));
    let gears = scene.joints.values().any(|joint| match joint {
        Joint::Gear(gear) => gear.first == name || gear.second == name,
        Joint::Rack(rack) => rack.rotation == name,
        _ => false,
    });
    let joint = scene.joints.get(name);
    let actuators = scene.actuators.values().any(|actuator| {
        actuator.joint() == name
            && joint.is_some_and(|joint| actuator.coordinate(joint) == ActuatedCoordinate::Angle)
    });
    drives || springs || actuators || gears
}

fn add_gear(
    builder: &mut SystemBuilder,
    name: &str,
    location: &str,
    first: Option<(BuiltJoint, Measure)>,
    second: Option<(BuiltJoint, Measure)>,
    ratio: f64,
) -> Result<NamedJoint, Error> {
    let (Some((first, first_measure)), Some((second, second_measure))) = (first, second) else {
        return Err(Error::described(
            location,
            "couples joints that have no such coordinate",
        ));
    };
    let connection = builder.gear(
        name,
        (&first, first_measure),
        (&second, second_measure),
        ratio,
    );
    Ok(NamedJoint {
        connection,
        built: None,
        zero: [0.0; 2],
    })
}

/// A free coordinate of a joint that exists already.
pub(super) fn coordinate(
    names: &Names,
    joint: &str,
    which: JointCoordinate,
) -> Option<(BuiltJoint, Measure)> {
    let built = names.joints.get(joint)?.built.clone()?;
    let measure = built.coordinate(which)?;
    Some((built, measure))
}

/// A place as drawn, before it has a marker.
fn frame(builder: &SystemBuilder, place: &Place) -> FrameMotion {
    match place {
        Place::Ground { position, axes } => FrameMotion::at_rest(*position, *axes),
        Place::Body { body, interface } => builder.interface_frame(*body, *interface),
    }
}

/// Adds a drive.
pub(super) fn add_drive(
    builder: &mut SystemBuilder,
    names: &mut Names,
    name: &str,
    drive: &Drive,
    end: f64,
) -> Result<(), Error> {
    let location = format!("drives.{name}.{}", drive.kind());
    let motion = drive.motion();
    let Some(joint) = names.joints.get(&motion.joint) else {
        return Err(Error::described(location, "drives no joint"));
    };
    let missing = || Error::described(format!("{location}.joint"), "has no such coordinate");
    let built = joint.built.clone().ok_or_else(missing)?;
    let which = match drive {
        Drive::Angle(_) => JointCoordinate::Rotation,
        Drive::Position(_) => JointCoordinate::Translation,
        Drive::Speed(_) if built.rows.rotation.is_some() => JointCoordinate::Rotation,
        Drive::Speed(_) => JointCoordinate::Translation,
    };
    let measure = built.coordinate(which).ok_or_else(missing)?;
    let offset = match drive {
        // A speed starts from the coordinate as drawn.
        Drive::Speed(_) => measure.value(&builder.frame(built.a), &builder.frame(built.b)),
        Drive::Angle(_) | Drive::Position(_) => joint.zero(which),
    };
    let function = drive
        .coordinate(end)
        .map_err(|error| error.within(&location))?;
    let input = input_of(builder, name, &motion.function);
    let signal = builder.signal(Signal {
        function,
        input,
        offset,
    });
    let connection = builder.drive(name, &built, measure, signal);
    names.drives.insert(name.to_owned(), connection);
    Ok(())
}

pub(super) fn input_of(
    builder: &mut SystemBuilder,
    name: &str,
    function: &Function,
) -> Option<usize> {
    match function {
        Function::Input(input) => Some(builder.input(name, input.initial)),
        _ => None,
    }
}

/// Adds a load.
pub(super) fn add_load(
    scene: &Scene,
    builder: &mut SystemBuilder,
    names: &Names,
    name: &str,
    load: &Load,
) -> Result<(), Error> {
    let (kind, rotation, function) = match load {
        Load::PartLoad(part) => return add_part_load(builder, names, name, part),
        Load::Force(function) => ("force", RotationNeeded::None, function),
        Load::Torque(function) => ("torque", RotationNeeded::All, function),
    };
    let location = format!("loads.{name}.{kind}");
    let at = format!("{location}.at");
    let place = find(scene, builder, names, &at, &function.at)?;
    let marker = marker(builder, &at, &place, &rotation, Turned::Interface)?;
    let inputs = function
        .components
        .iter()
        .filter(|component| matches!(component, Function::Input(_)))
        .count();
    let mut signals = [None; 3];
    for (index, component) in function.components.iter().enumerate() {
        if *component == Function::Constant(0.0) {
            continue;
        }
        let place = format!("{location}.components[{index}]");
        let time_function = TimeFunction::new(component).map_err(|error| error.within(&place))?;
        let input_name = if inputs > 1 {
            format!("{name}/{index}")
        } else {
            name.to_owned()
        };
        let input = input_of(builder, &input_name, component);
        let slot = match (&rotation, scene.dimension) {
            (RotationNeeded::All, Dimension::Planar) => 2,
            _ => index,
        };
        signals[slot] = Some(builder.signal(Signal {
            function: time_function,
            input,
            offset: 0.0,
        }));
    }
    let axes = match function.axes {
        scene::LoadAxes::World => LoadAxes::World,
        scene::LoadAxes::Follower => LoadAxes::Follower,
    };
    let (force, torque) = match rotation {
        RotationNeeded::All => ([None; 3], signals),
        _ => (signals, [None; 3]),
    };
    builder.load(name, marker, axes, force, torque);
    Ok(())
}

fn add_part_load(
    builder: &mut SystemBuilder,
    names: &Names,
    name: &str,
    part: &PartLoadFunction,
) -> Result<(), Error> {
    let location = format!("loads.{name}.part_load");
    let body = names.bodies[part.body.as_str()];
    let flexible = &builder.system().bodies[body].flexible;
    if flexible.compatibility != Compatibility::Strong {
        return Err(Error::described(
            location,
            "needs strong compatibility: the others leave out what loads off the interfaces do to them",
        ));
    }
    let known = flexible.loads.iter().map(|load| load.name.as_str());
    let index = known.clone().position(|known| known == part.load);
    let Some(index) = index else {
        let names = match listed(known.clone()) {
            none if none.is_empty() => "its file has none".to_owned(),
            names => format!("there are: {names}"),
        };
        return Err(Error::described(
            format!("{location}.load"),
            format!(
                "no load of body {:?} is called {:?}{} ({names})",
                part.body,
                part.load,
                suggestion(&part.load, known)
            ),
        ));
    };
    let function = TimeFunction::new(&part.factor)
        .map_err(|error| error.within(&format!("{location}.factor")))?;
    let input = input_of(builder, name, &part.factor);
    let factor = builder.signal(Signal {
        function,
        input,
        offset: 0.0,
    });
    builder.part_load(name, body, index, factor);
    Ok(())
}
