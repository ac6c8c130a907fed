//! How fast a body turns, as far as a scene tells without integrating it.

use indexmap::IndexMap;
use serde::Serialize;

use super::course::Course;
use crate::Error;
use dcb_formats::scene::{Analysis, Attachment, Drive, Joint, Scene};

/// Deflections of interest are this part of a body's radius of gyration: what spin does to the body is compared with them.
pub const DEFLECTION_OF_INTEREST: f64 = 0.01;

/// The largest angular velocity of a body during a run.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Spin {
    /// rad/time; a bound where known, else the largest rate that the scene mentions.
    pub rate: f64,
    /// Whether the joints and drives between the ground and the body determine it. Turns by deflection are not counted.
    pub known: bool,
    /// Acceleration of gravity where nothing else, but the motion of the start and drives of known rates, can make the bodies turn: no loads, springs or actuators.
    pub falls: Option<f64>,
    /// Why.
    pub reason: String,
}

impl Spin {
    pub(super) fn of(scene: &Scene, body: &str) -> Result<Self, Error> {
        if !matches!(scene.analysis, Analysis::Transient | Analysis::Kinematic) {
            return Ok(Self {
                rate: 0.0,
                known: true,
                falls: None,
                reason: "nothing turns in an analysis that isn't over time".into(),
            });
        }
        let driven = drive_rates(scene)?;
        let is_left_alone = driven.iter().all(Option::is_some)
            && scene.loads.is_empty()
            && scene.springs.is_empty()
            && scene.actuators.is_empty();
        let falls = is_left_alone.then(|| scene.gravity_in_space().norm());
        let rates = relative_rates(scene, &driven);
        let bounds = bounds(scene, &rates);
        if let Some((rate, through)) = bounds.get(body) {
            let reason = match through.is_empty() {
                true => "held to the ground".to_owned(),
                false => format!("at most the sum of the rates of {}", through.join(", ")),
            };
            return Ok(Self {
                rate: *rate,
                known: true,
                falls,
                reason,
            });
        }
        let of_bodies = scene.bodies.iter().map(|(name, other)| {
            let rate = other.placement().angular_velocity.norm();
            (rate, format!("bodies.{name}.angular_velocity"))
        });
        let of_joints = rates
            .iter()
            .map(|(joint, rate)| (*rate, format!("joints.{joint}")));
        let (rate, from) = of_bodies
            .chain(of_joints)
            .fold((0.0, String::new()), |most, other| match other.0 > most.0 {
                true => other,
                false => most,
            });
        let reason = match rate > 0.0 {
            true => format!(
                "drives do not determine it; this is the largest rate in the scene, that of {from}"
            ),
            false => "drives do not determine it, and the scene has no rate".into(),
        };
        Ok(Self {
            rate,
            known: false,
            falls,
            reason,
        })
    }
}

/// The largest rate of each drive during the run, where it is known.
fn drive_rates(scene: &Scene) -> Result<Vec<Option<f64>>, Error> {
    let end = scene.integrator.map_or(0.0, |integrator| integrator.end);
    let drives = scene.drives.iter();
    drives
        .map(|(name, drive)| {
            let course = Course::of_drive(drive, end)
                .map_err(|error| error.within(&format!("drives.{name}.{}", drive.kind())))?;
            Ok(course.and_then(|course| course.largest(|value| value.rate)))
        })
        .collect()
}

/// How fast the bodies of each joint turn against each other at most, where that is known.
fn relative_rates<'a>(scene: &'a Scene, driven: &[Option<f64>]) -> IndexMap<&'a str, f64> {
    let mut turns: IndexMap<&str, f64> = IndexMap::new();
    let mut slides: IndexMap<&str, f64> = IndexMap::new();
    for (name, joint) in &scene.joints {
        if matches!(joint, Joint::Fixed(_) | Joint::Prismatic(_)) {
            turns.insert(name, 0.0);
        }
    }
    for (drive, rate) in scene.drives.values().zip(driven) {
        let joint = drive.motion().joint.as_str();
        let turning = match drive {
            Drive::Angle(_) => true,
            Drive::Position(_) => false,
            Drive::Speed(_) => scene.joints.get(joint).is_some_and(Joint::has_angle),
        };
        if let Some(rate) = *rate {
            match turning {
                true => turns.insert(joint, rate),
                false => slides.insert(joint, rate),
            };
        }
    }
    // Gears pass a rate on, from either side, through as many as there are.
    for _ in 0..scene.joints.len() {
        for joint in scene.joints.values() {
            match joint {
                Joint::Gear(gear) => {
                    let (first, second) = (gear.first.as_str(), gear.second.as_str());
                    if let Some(rate) = turns.get(first).copied() {
                        turns.entry(second).or_insert(rate * gear.ratio.abs());
                    } else if let Some(rate) = turns.get(second).copied() {
                        turns.insert(first, rate / gear.ratio.abs());
                    }
                }
                Joint::Rack(rack) => {
                    if let Some(rate) = slides.get(rack.translation.as_str()) {
                        turns
                            .entry(&rack.rotation)
                            .or_insert(rate / rack.radius.abs());
                    }
                }
                _ => {}
            }
        }
    }
    turns
}

/// Bodies that joints of known rates connect to the ground: the least sum of rates, and the joints that turn on the way.
fn bounds<'a>(
    scene: &'a Scene,
    rates: &IndexMap<&'a str, f64>,
) -> IndexMap<&'a str, (f64, Vec<String>)> {
    let mut bounds: IndexMap<&str, (f64, Vec<String>)> = IndexMap::new();
    let body_of = |place: &'a str| Attachment::parse(place).and_then(|place| place.body());
    for _ in 0..scene.bodies.len() {
        for (name, rate) in rates {
            let joint = scene.joints.get(*name).and_then(Joint::attachments);
            let Some([a, b]) = joint else { continue };
            for (from, to) in [(a, b), (b, a)] {
                let start = match body_of(from) {
                    None => Some((0.0, Vec::new())),
                    Some(body) => bounds.get(body).cloned(),
                };
                let (Some((before, mut through)), Some(to)) = (start, body_of(to)) else {
                    continue;
                };
                let sum = before + rate;
                if bounds.get(to).is_none_or(|(known, _)| sum < *known) {
                    if *rate > 0.0 {
                        through.push(format!("joints.{name}"));
                    }
                    bounds.insert(to, (sum, through));
                }
            }
        }
    }
    bounds
}
