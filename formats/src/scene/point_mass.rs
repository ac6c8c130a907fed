//! Point masses: rigid bodies without inertia. They have a place and no rotation, so nothing may hold, turn or show one.

use nalgebra::Vector3;

use super::check::Checker;
use super::values::in_space;
use super::{Attachment, BodyKind, ExertedDirections, Joint, RigidBody, Side};
use crate::Error;

/// Distance of a point from the centre of mass, in parts of their distance from the origin, that rounding explains.
const ROUNDING: f64 = 1e-9;

impl RigidBody {
    /// Whether it is a point mass: its inertia is zero about every axis.
    pub fn is_point_mass(&self) -> bool {
        self.inertia.matrix() == nalgebra::Matrix3::zeros()
    }

    /// Centre of mass in component coordinates.
    pub fn center(&self) -> Vector3<f64> {
        in_space(self.center_of_mass.as_deref().unwrap_or_default())
    }

    /// Whether the points of a point mass are where it is.
    pub(super) fn check_points_of_mass(&self, location: &str) -> Result<(), Error> {
        let center = self.center();
        for (name, point) in &self.points {
            let position = point.position();
            let off = (position - center).norm();
            if off > ROUNDING * (position.norm() + center.norm()) {
                return Err(Error::described(
                    format!("{location}.points.{name}"),
                    format!(
                        "is {off} away from the centre of mass of a point mass (its `inertia` is zero); expected the centre of mass, or a \
                         body with an inertia"
                    ),
                ));
            }
        }
        Ok(())
    }
}

impl Checker<'_> {
    /// The point mass that a place is on.
    fn point_mass<'r>(&self, place: &'r str) -> Option<&'r str> {
        let body = Attachment::parse(place)?.body()?;
        self.is_point_mass(body).then_some(body)
    }

    fn is_point_mass(&self, body: &str) -> bool {
        let found = self.body_named(body);
        found.is_some_and(
            |found| matches!(&found.kind, BodyKind::Rigid(rigid) if rigid.is_point_mass()),
        )
    }

    /// That a place is not on a point mass, which has no rotation for `what`.
    pub(super) fn turns(&self, location: &str, place: &str, what: &str) -> Result<(), Error> {
        self.point_mass(place)
            .map_or(Ok(()), |body| Err(unturned(location, body, what)))
    }

    /// That a body is not a point mass, which has no rotation for `what`.
    pub(super) fn body_turns(&self, location: &str, body: &str, what: &str) -> Result<(), Error> {
        match self.is_point_mass(body) {
            true => Err(unturned(location, body, what)),
            false => Ok(()),
        }
    }

    /// That the angle of a joint is one between bodies that turn.
    pub(super) fn has_turning_angle(&self, location: &str, joint: &Joint) -> Result<(), Error> {
        for place in joint.attachments().into_iter().flatten() {
            let what = format!("the angle of a {} joint", joint.kind());
            self.turns(location, place, &what)?;
        }
        Ok(())
    }

    /// That a joint holds no rotation of a point mass: its sides exert forces through the point alone.
    pub(super) fn holds_no_point_mass(&self, location: &str, joint: &Joint) -> Result<(), Error> {
        let Some(places) = joint.attachments() else {
            return Ok(());
        };
        let is_pin = self.is_planar() && matches!(joint, Joint::Revolute(_));
        for (side, place) in Side::BOTH.into_iter().zip(places) {
            let [_, moments] = joint.exerts(side);
            let Some(body) = self.point_mass(place) else {
                continue;
            };
            if moments == ExertedDirections::None || is_pin {
                continue;
            }
            let (key, other) = match side {
                Side::A => ("a", "b"),
                Side::B => ("b", "a"),
            };
            let instead = match (joint, self.is_planar()) {
                (Joint::PointOnLine(_), _) => {
                    format!("make the point mass `{other}`, the point on the line, or ")
                }
                (Joint::Prismatic(_) | Joint::Cylindrical(_), _) => {
                    "use point_on_line with the point mass as `b`, or ".to_owned()
                }
                (Joint::Planar(_), _) => String::new(),
                (_, true) => "use revolute, which holds its place, or ".to_owned(),
                (_, false) => "use spherical, which holds its place, or ".to_owned(),
            };
            return Err(Error::described(
                format!("{location}.{key}"),
                format!(
                    "{place:?} is on the point mass {body:?} (its `inertia` is zero), which has no rotation for a {} joint; {instead}give \
                     the body an inertia",
                    joint.kind()
                ),
            ));
        }
        Ok(())
    }
}

fn unturned(location: &str, body: &str, what: &str) -> Error {
    Error::described(
        location,
        format!(
            "body {body:?} is a point mass (its `inertia` is zero), which has no rotation for {what}; give it an inertia"
        ),
    )
}
