//! Actuators: efforts on the coordinates of joints, equal and opposite on both bodies.
//!
//! An effort is a moment on an angle or a force on a translation or distance; it is positive where it makes the coordinate grow. An
//! actuator on a distance joint frees the distance.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::Joint;
use super::check::{Checker, finite};
use super::drive::DriveFunction;
use super::gear::{with_angle, with_length};
use super::values::{not_negative, positive};
use crate::Error;
use crate::function::{Function, TimeFunction};
use crate::named::object;

/// One actuator.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Actuator {
    /// A moment about the axis of a revolute or cylindrical joint.
    Torque(DriveFunction),
    /// A force along a prismatic, cylindrical or distance joint.
    Force(DriveFunction),
    /// A servo motor: a PID controller with a limit.
    #[serde(deserialize_with = "object")]
    Servo(Servo),
    /// Dry and viscous friction.
    #[serde(deserialize_with = "object")]
    Friction(Friction),
    /// One-sided springs with dampers at the ends of the way.
    #[serde(deserialize_with = "object")]
    EndStop(EndStop),
}

/// Which coordinate of a joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum ActuatedCoordinate {
    /// Angle of a revolute or cylindrical joint, rad.
    Angle,
    /// Translation of a prismatic or cylindrical joint, or length of a distance joint.
    Position,
}

/// How an effort stays within its limit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Saturation {
    /// Cut off at the limit.
    #[default]
    Hard,
    /// limit · tanh(effort / limit).
    Smooth,
}

/// effort = proportional (target - q) + derivative (target' - q') + integral ∫ (target - q) dt.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Servo {
    /// Name of the joint.
    pub joint: String,
    /// `angle` or `position`; needed for a cylindrical joint, which has both.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub coordinate: Option<ActuatedCoordinate>,
    /// Target of the coordinate: a function of time or an input.
    pub target: Function,
    /// Effort per deviation.
    #[serde(default)]
    pub proportional: f64,
    /// Effort per rate of the deviation.
    #[serde(default)]
    pub derivative: f64,
    /// Effort per deviation and time.
    #[serde(default)]
    pub integral: f64,
    /// Largest effort, either way; none where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub limit: Option<f64>,
    /// How the effort stays within the limit.
    #[serde(default)]
    pub saturation: Saturation,
    /// Time in which the integral follows an effort at its limit (anti-windup by back-calculation); proportional / integral where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tracking_time: Option<f64>,
    /// Interval of time at which the effort is computed; it is held in between. Continuous where absent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sample: Option<f64>,
}

/// effort = -[coulomb + (static - coulomb) exp(-(q'/stribeck_rate)²)] tanh(q'/regularization) - viscous q'.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Friction {
    /// Name of the joint.
    pub joint: String,
    /// `angle` or `position`; needed for a cylindrical joint, which has both.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub coordinate: Option<ActuatedCoordinate>,
    /// Moment or force of dry friction in motion.
    #[serde(default)]
    pub coulomb: f64,
    /// Largest moment or force of dry friction at rest; coulomb where absent.
    #[serde(default, rename = "static", skip_serializing_if = "Option::is_none")]
    pub at_rest: Option<f64>,
    /// Rate at which the friction at rest has fallen to that in motion, by 1/e of the difference.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stribeck_rate: Option<f64>,
    /// Effort per rate.
    #[serde(default)]
    pub viscous: f64,
    /// Rate below which dry friction goes to zero; needed where there is dry friction.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub regularization: Option<f64>,
}

/// Springs with dampers that act beyond a lower and an upper value of the coordinate, and never pull.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EndStop {
    /// Name of the joint.
    pub joint: String,
    /// `angle` or `position`; needed for a cylindrical joint, which has both.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub coordinate: Option<ActuatedCoordinate>,
    /// Value of the coordinate below which the stop acts.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lower: Option<f64>,
    /// Value of the coordinate above which the stop acts.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub upper: Option<f64>,
    /// Effort per way beyond the stop.
    pub stiffness: f64,
    /// Effort per rate beyond the stop.
    #[serde(default)]
    pub damping: f64,
    /// Way beyond the stop on which stiffness and damping grow from zero to their values; at once where absent.
    #[serde(default)]
    pub onset: f64,
}

impl Actuator {
    /// The kind, as the scene writes it.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Torque(_) => "torque",
            Self::Force(_) => "force",
            Self::Servo(_) => "servo",
            Self::Friction(_) => "friction",
            Self::EndStop(_) => "end_stop",
        }
    }

    /// The joint that it acts on.
    pub fn joint(&self) -> &str {
        match self {
            Self::Torque(of) | Self::Force(of) => &of.joint,
            Self::Servo(of) => &of.joint,
            Self::Friction(of) => &of.joint,
            Self::EndStop(of) => &of.joint,
        }
    }

    /// Which coordinate of a joint of this kind it acts on.
    pub fn coordinate(&self, joint: &Joint) -> ActuatedCoordinate {
        let given = match self {
            Self::Torque(_) => Some(ActuatedCoordinate::Angle),
            Self::Force(_) => Some(ActuatedCoordinate::Position),
            Self::Servo(of) => of.coordinate,
            Self::Friction(of) => of.coordinate,
            Self::EndStop(of) => of.coordinate,
        };
        given.unwrap_or(match joint.has_angle() {
            true => ActuatedCoordinate::Angle,
            false => ActuatedCoordinate::Position,
        })
    }

    /// Its function of time, or what gives its effort.
    pub fn function(&self) -> Option<&Function> {
        match self {
            Self::Torque(of) | Self::Force(of) => Some(&of.function),
            Self::Servo(of) => Some(&of.target),
            Self::Friction(_) | Self::EndStop(_) => None,
        }
    }

    pub(super) fn function_mut(&mut self) -> Option<&mut Function> {
        match self {
            Self::Torque(of) | Self::Force(of) => Some(&mut of.function),
            Self::Servo(of) => Some(&mut of.target),
            Self::Friction(_) | Self::EndStop(_) => None,
        }
    }

    /// The interval at which it computes its effort by itself.
    pub fn sample(&self) -> Option<f64> {
        match self {
            Self::Servo(of) => of.sample,
            _ => None,
        }
    }

    pub(super) fn check(&self, location: &str, checker: &Checker) -> Result<(), Error> {
        let location = &format!("{location}.{}", self.kind());
        let at = format!("{location}.joint");
        match self {
            Self::Torque(of) => {
                with_angle(&at, &of.joint, checker)?;
                check_effort(location, &of.function, checker)
            }
            Self::Force(of) => {
                with_length(&at, &of.joint, checker)?;
                check_effort(location, &of.function, checker)
            }
            Self::Servo(of) => {
                with_coordinate(location, &of.joint, of.coordinate, checker)?;
                of.check(location)
            }
            Self::Friction(of) => {
                with_coordinate(location, &of.joint, of.coordinate, checker)?;
                of.check(location)
            }
            Self::EndStop(of) => {
                with_coordinate(location, &of.joint, of.coordinate, checker)?;
                of.check(location)
            }
        }
    }
}

/// A joint with this coordinate, or with one where none is said.
fn with_coordinate(
    location: &str,
    name: &str,
    coordinate: Option<ActuatedCoordinate>,
    checker: &Checker,
) -> Result<(), Error> {
    let at = format!("{location}.joint");
    match coordinate {
        Some(ActuatedCoordinate::Angle) => with_angle(&at, name, checker),
        Some(ActuatedCoordinate::Position) => with_length(&at, name, checker),
        None => {
            let joint = checker.joint(&at, name)?;
            match (joint.has_angle(), joint.has_length()) {
                (true, true) => Err(Error::described(
                    format!("{location}.coordinate"),
                    format!(
                        "is missing: joint {name:?} is cylindrical and has two; add \"coordinate\": \"angle\" or \"position\""
                    ),
                )),
                (false, false) => Err(Error::described(
                    at,
                    format!(
                        "joint {name:?} is {}, which has no coordinate; expected a revolute, prismatic, cylindrical or distance joint",
                        joint.kind()
                    ),
                )),
                (true, false) => with_angle(&at, name, checker),
                (false, true) => Ok(()),
            }
        }
    }
}

fn check_effort(location: &str, function: &Function, checker: &Checker) -> Result<(), Error> {
    if let Function::Controller(name) = function {
        return checker.controller(&format!("{location}.controller"), name);
    }
    starts_finite(location, function)
}

fn starts_finite(location: &str, function: &Function) -> Result<(), Error> {
    let start = TimeFunction::new(function)
        .map_err(|error| error.within(location))?
        .evaluate(0.0, 0.0);
    match start.value.is_finite() && start.rate.is_finite() {
        true => Ok(()),
        false => Err(Error::described(
            location,
            format!(
                "is {} with the rate {} at t = 0; both must be finite",
                start.value, start.rate
            ),
        )),
    }
}

impl Servo {
    fn check(&self, location: &str) -> Result<(), Error> {
        if let Function::Controller(_) = self.target {
            return Err(Error::described(
                format!("{location}.target"),
                "is a controller; expected a function of time or an input: a servo is a controller itself",
            ));
        }
        starts_finite(&format!("{location}.target"), &self.target)?;
        for (key, gain) in [
            ("proportional", self.proportional),
            ("derivative", self.derivative),
            ("integral", self.integral),
        ] {
            not_negative(&format!("{location}.{key}"), gain)?;
        }
        if self.proportional == 0.0 && self.derivative == 0.0 && self.integral == 0.0 {
            return Err(Error::described(
                location,
                "has no gain; add for example \"proportional\": 100, \"derivative\": 5",
            ));
        }
        for (key, number) in [
            ("limit", self.limit),
            ("tracking_time", self.tracking_time),
            ("sample", self.sample),
        ] {
            if let Some(number) = number {
                positive(&format!("{location}.{key}"), number)?;
            }
        }
        let winds_up = self.integral > 0.0 && self.limit.is_some();
        if winds_up && self.proportional == 0.0 && self.tracking_time.is_none() {
            return Err(Error::described(
                format!("{location}.tracking_time"),
                "is missing: an integral with a limit needs the time in which it follows an effort at the limit, \
                 proportional / integral by itself",
            ));
        }
        Ok(())
    }
}

impl Friction {
    fn check(&self, location: &str) -> Result<(), Error> {
        not_negative(&format!("{location}.coulomb"), self.coulomb)?;
        not_negative(&format!("{location}.viscous"), self.viscous)?;
        let at_rest = self.at_rest.unwrap_or(self.coulomb);
        let location_of = |key: &str| format!("{location}.{key}");
        not_negative(&location_of("static"), at_rest)?;
        if at_rest < self.coulomb {
            return Err(Error::described(
                location_of("static"),
                format!("is {at_rest}, less than coulomb, which is {}", self.coulomb),
            ));
        }
        for (key, rate) in [
            ("stribeck_rate", self.stribeck_rate),
            ("regularization", self.regularization),
        ] {
            if let Some(rate) = rate {
                positive(&location_of(key), rate)?;
            }
        }
        let missing = |key: &str, why: &str| Err(Error::described(location_of(key), why));
        if at_rest > self.coulomb && self.stribeck_rate.is_none() {
            return missing(
                "stribeck_rate",
                "is missing: a rate at which the friction at rest falls to that in motion",
            );
        }
        if at_rest > 0.0 && self.regularization.is_none() {
            return missing(
                "regularization",
                "is missing: a rate, small beside those of the motion, below which dry friction goes to zero",
            );
        }
        Ok(())
    }
}

impl EndStop {
    fn check(&self, location: &str) -> Result<(), Error> {
        match (self.lower, self.upper) {
            (None, None) => {
                return Err(Error::described(
                    location,
                    "has neither lower nor upper; add one or both",
                ));
            }
            (Some(lower), Some(upper)) if lower >= upper => {
                return Err(Error::described(
                    format!("{location}.upper"),
                    format!("is {upper}, not above lower, which is {lower}"),
                ));
            }
            _ => {}
        }
        for (key, end) in [("lower", self.lower), ("upper", self.upper)] {
            finite(&format!("{location}.{key}"), end.unwrap_or_default())?;
        }
        positive(&format!("{location}.stiffness"), self.stiffness)?;
        not_negative(&format!("{location}.damping"), self.damping)?;
        not_negative(&format!("{location}.onset"), self.onset)
    }
}
