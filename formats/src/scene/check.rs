//! Whether the members of a scene fit each other: names, sizes, and who refers to whom.

use crate::description::{listed, suggestion};
use crate::mesh::Dimension;

use super::{Attachment, Body, BodyKind, Joint, Scene};
use crate::Error;

/// Context of the checks: facts of the whole scene that its members are checked against.
pub(super) struct Checker<'a> {
    scene: &'a Scene,
}

impl<'a> Checker<'a> {
    pub(super) fn new(scene: &'a Scene) -> Self {
        Self { scene }
    }

    /// 2 or 3.
    pub(super) fn dimension_count(&self) -> usize {
        self.scene.dimension.coordinate_count()
    }

    /// Axes of rotation: 1 or 3.
    pub(super) fn rotation_count(&self) -> usize {
        if self.is_planar() { 1 } else { 3 }
    }

    pub(super) fn is_planar(&self) -> bool {
        self.scene.dimension == Dimension::Planar
    }

    /// A point or direction: as many finite numbers as the scene has dimensions.
    pub(super) fn vector(&self, location: &str, components: &[f64]) -> Result<(), Error> {
        vector(location, components, self.dimension_count())
    }

    /// A direction: not of zero length.
    pub(super) fn direction(&self, location: &str, components: &[f64]) -> Result<(), Error> {
        self.vector(location, components)?;
        if components
            .iter()
            .any(|component| component.abs() > f64::MIN_POSITIVE)
        {
            Ok(())
        } else {
            Err(Error::described(
                location,
                "has length zero, expected a direction",
            ))
        }
    }

    pub(super) fn body_named(&self, name: &str) -> Option<&'a Body> {
        self.scene.bodies.get(name)
    }

    pub(super) fn body(&self, location: &str, name: &str) -> Result<&'a Body, Error> {
        let bodies = &self.scene.bodies;
        bodies
            .get(name)
            .ok_or_else(|| unknown(location, "body", name, bodies.keys().map(String::as_str)))
    }

    /// That there are bodies.
    pub(super) fn any_body(&self, location: &str) -> Result<(), Error> {
        match self.scene.bodies.is_empty() {
            true => Err(Error::described(
                location,
                "is of all bodies, but the scene has none",
            )),
            false => Ok(()),
        }
    }

    /// A body that has a mesh and coordinates of its own.
    pub(super) fn superelement(&self, location: &str, name: &str) -> Result<(), Error> {
        match self.body(location, name)?.kind {
            BodyKind::Superelement(_) => Ok(()),
            BodyKind::Rigid(_) => Err(Error::described(
                location,
                format!("body {name:?} is rigid; expected a superelement"),
            )),
        }
    }

    pub(super) fn joint(&self, location: &str, name: &str) -> Result<&'a Joint, Error> {
        let joints = &self.scene.joints;
        joints
            .get(name)
            .ok_or_else(|| unknown(location, "joint", name, joints.keys().map(String::as_str)))
    }

    pub(super) fn drive(&self, location: &str, name: &str) -> Result<(), Error> {
        let drives = &self.scene.drives;
        match drives.get(name) {
            Some(_) => Ok(()),
            None => Err(unknown(
                location,
                "drive",
                name,
                drives.keys().map(String::as_str),
            )),
        }
    }

    pub(super) fn spring(&self, location: &str, name: &str) -> Result<(), Error> {
        let springs = &self.scene.springs;
        match springs.get(name) {
            Some(_) => Ok(()),
            None => Err(unknown(
                location,
                "spring",
                name,
                springs.keys().map(String::as_str),
            )),
        }
    }

    pub(super) fn actuator(&self, location: &str, name: &str) -> Result<(), Error> {
        let names = self.scene.actuators.keys().map(String::as_str);
        one_of(location, "actuator", name, names)
    }

    pub(super) fn controller(&self, location: &str, name: &str) -> Result<(), Error> {
        let names = self.scene.controllers.keys().map(String::as_str);
        one_of(location, "controller", name, names)
    }

    /// The outputs of the scene.
    pub(super) fn outputs(&self) -> &'a super::Named<super::Output> {
        &self.scene.outputs
    }

    /// Where something is attached. An interface of a superelement is known only to its file.
    pub(super) fn attachment<'r>(
        &self,
        location: &str,
        reference: &'r str,
    ) -> Result<Attachment<'r>, Error> {
        let place = Attachment::parse(reference)
            .ok_or_else(|| Error::described(location, self.no_attachment(reference)))?;
        match place {
            Attachment::Ground => {}
            Attachment::GroundPoint(point) => {
                let points = &self.scene.ground.points;
                if !points.contains_key(point) {
                    return Err(unknown(
                        location,
                        "point of the ground",
                        point,
                        points.keys().map(String::as_str),
                    ));
                }
            }
            Attachment::Body { body, point } => {
                let bodies = &self.scene.bodies;
                let Some(found) = bodies.get(body) else {
                    let names = bodies.keys().map(String::as_str).chain(["ground"]);
                    return Err(unknown(location, "body", body, names));
                };
                if let BodyKind::Rigid(rigid) = &found.kind
                    && !rigid.points.contains_key(point)
                {
                    return Err(unknown(
                        location,
                        &format!("point of body {body:?}"),
                        point,
                        rigid.points.keys().map(String::as_str),
                    ));
                }
            }
        }
        Ok(place)
    }

    /// Why a text names no place, and what does.
    fn no_attachment(&self, reference: &str) -> String {
        let Some(body) = self.scene.bodies.get(reference) else {
            return format!(
                "{reference:?} is no attachment; expected \"ground\", \"ground/point\", \"body/interface\" or \"body/point\""
            );
        };
        let places = match &body.kind {
            BodyKind::Rigid(rigid) => {
                let points = rigid.points.keys();
                let places: Vec<String> =
                    points.map(|point| format!("{reference}/{point}")).collect();
                match places.is_empty() {
                    true => format!("{reference}/NAME, once the body has \"points\""),
                    false => listed(places.iter().map(String::as_str)),
                }
            }
            BodyKind::Superelement(of) => format!(
                "{reference}/INTERFACE (`reduce inspect {}` lists the interfaces)",
                of.file.display()
            ),
        };
        format!("{reference:?} names a body, but a place on it is needed: {places}")
    }

    /// The two places that something connects: on different bodies.
    pub(super) fn connection(&self, location: &str, a: &str, b: &str) -> Result<(), Error> {
        let first = self.attachment(&format!("{location}.a"), a)?;
        let second = self.attachment(&format!("{location}.b"), b)?;
        if first.body() == second.body() {
            let both = first.body().unwrap_or("ground");
            return Err(Error::described(
                format!("{location}.b"),
                format!("{b:?} is on {both:?} like {a:?}; expected another body"),
            ));
        }
        Ok(())
    }
}

/// Names are not empty, printable and without `/`, which separates a body from its interface.
pub(crate) fn name(location: &str, name: &str) -> Result<(), Error> {
    if name.trim().is_empty() || name.contains('/') || name.contains(char::is_control) {
        return Err(Error::described(
            location,
            format!("{name:?} is no name; expected printable text without `/`"),
        ));
    }
    Ok(())
}

/// Every member of a list with its place: the names, then what `check` says of each.
pub(super) fn each<T>(
    list: &str,
    parts: &super::Named<T>,
    check: impl Fn(&str, &T) -> Result<(), Error>,
) -> Result<(), Error> {
    for (key, part) in parts {
        name(list, key)?;
        check(&format!("{list}.{key}"), part)?;
    }
    Ok(())
}

/// Every member of a list without names, with its place.
pub(super) fn each_of<T>(
    list: &str,
    parts: &[T],
    check: impl Fn(&str, &T) -> Result<(), Error>,
) -> Result<(), Error> {
    let mut numbered = parts.iter().enumerate();
    numbered.try_for_each(|(index, part)| check(&format!("{list}[{index}]"), part))
}

pub(super) fn finite(location: &str, number: f64) -> Result<(), Error> {
    if number.is_finite() {
        Ok(())
    } else {
        Err(Error::described(
            location,
            format!("is {number}, expected a finite number"),
        ))
    }
}

pub(super) fn vector(location: &str, components: &[f64], count: usize) -> Result<(), Error> {
    if components.len() != count {
        return Err(Error::described(
            location,
            format!("has {} components, expected {count}", components.len()),
        ));
    }
    for (index, component) in components.iter().enumerate() {
        finite(&format!("{location}[{index}]"), *component)?;
    }
    Ok(())
}

fn one_of<'n>(
    location: &str,
    what: &str,
    name: &str,
    mut known: impl Iterator<Item = &'n str> + Clone,
) -> Result<(), Error> {
    let all = known.clone();
    match known.any(|known| known == name) {
        true => Ok(()),
        false => Err(unknown(location, what, name, all)),
    }
}

fn unknown<'n>(
    location: &str,
    what: &str,
    found: &str,
    known: impl Iterator<Item = &'n str> + Clone,
) -> Error {
    let hint = suggestion(found, known.clone());
    let known = match listed(known) {
        none if none.is_empty() => "there is none".to_owned(),
        names => format!("there are: {names}"),
    };
    Error::described(
        location,
        format!("no {what} is called {found:?}{hint} ({known})"),
    )
}
