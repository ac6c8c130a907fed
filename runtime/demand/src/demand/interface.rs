//! Loads on the interfaces of a body, and outputs that observe them.

use std::collections::BTreeSet;

use dcb_formats::mesh::Dimension;
use indexmap::IndexMap;
use nalgebra::{Matrix3, Vector3};
use serde::Serialize;

use super::part::{PartInterface, Parts, find};
use super::transmission::{
    Driven, Transmission, first_torque_axis, kept_orientation, load_directions,
};
use super::wrench_space::{Half, Span, WrenchSpace};
use crate::Error;
use dcb_formats::scene::{
    Attachment, BodyKind, Joint, Load, LoadAxes, LoadFunction, Scene, Side, Spring,
};

/// Demand of a scene on an interface.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct InterfaceDemand {
    /// Name of the interface.
    pub name: String,
    /// Orthonormal basis of the wrenches that can act on its rows: force, then moment, component axes. Empty where it is only
    /// looked at. A direction is that of the undeformed part; it turns with the interface.
    pub wrenches: Vec<[f64; 6]>,
    /// Joints, drives, springs and loads that act there: paths of keys of the scene.
    pub loaded_by: Vec<String>,
    /// Outputs that show its motion or force, and what turns with it without loading it in every direction.
    pub observed_by: Vec<String>,
}

/// Collects what a scene does at the interfaces of one body.
pub(super) struct Gathering<'a> {
    scene: &'a Scene,
    parts: &'a Parts,
    body: &'a str,
    interfaces: &'a [PartInterface],
    found: IndexMap<&'a str, Found>,
}

struct Found {
    orientation: Matrix3<f64>,
    space: WrenchSpace,
    loaded_by: Vec<String>,
    observed_by: BTreeSet<String>,
    is_grounded: bool,
}

/// Loads on the interfaces of a body.
pub(super) struct Gathered {
    pub(super) interfaces: Vec<InterfaceDemand>,
    /// Whether each of them is fixed to the ground.
    pub(super) all_grounded: bool,
}

impl<'a> Gathering<'a> {
    pub(super) fn of(
        scene: &'a Scene,
        parts: &'a Parts,
        body: &'a str,
        interfaces: &'a [PartInterface],
    ) -> Result<Gathered, Error> {
        let mut gathering = Self {
            scene,
            parts,
            body,
            interfaces,
            found: IndexMap::new(),
        };
        gathering.joints()?;
        gathering.springs()?;
        gathering.loads()?;
        gathering.outputs()?;
        Ok(gathering.finish())
    }

    fn finish(self) -> Gathered {
        let mut found = self.found;
        let all_grounded = found.values().all(|interface| interface.is_grounded);
        let interfaces = self.interfaces.iter().filter_map(|known| {
            let found = found.swap_remove(known.name.as_str())?;
            Some(InterfaceDemand {
                name: known.name.clone(),
                wrenches: found.space.basis(),
                loaded_by: found.loaded_by,
                observed_by: found.observed_by.into_iter().collect(),
            })
        });
        Gathered {
            interfaces: interfaces.collect(),
            all_grounded,
        }
    }

    /// The interface at a place, if the place is on the body.
    fn at(&mut self, location: &str, place: &str) -> Result<Option<&mut Found>, Error> {
        match Attachment::parse(place) {
            Some(Attachment::Body { body, point }) if body == self.body => {
                self.interface(location, point).map(Some)
            }
            _ => Ok(None),
        }
    }

    fn interface(&mut self, location: &str, name: &str) -> Result<&mut Found, Error> {
        let known = find(self.interfaces, location, self.body, name)?;
        let in_scene = match self.scene.dimension {
            Dimension::Planar => [true, true, false, false, false, true],
            Dimension::Spatial => [true; 6],
        };
        let reached = std::array::from_fn(|slot| known.directions[slot] && in_scene[slot]);
        Ok(self
            .found
            .entry(known.name.as_str())
            .or_insert_with(|| Found {
                orientation: known.orientation,
                space: WrenchSpace::reaching(reached),
                loaded_by: Vec::new(),
                observed_by: BTreeSet::new(),
                is_grounded: false,
            }))
    }

    fn joints(&mut self) -> Result<(), Error> {
        let (scene, parts) = (self.scene, self.parts);
        for (name, joint) in &scene.joints {
            let Some(places) = joint.attachments() else {
                continue;
            };
            let on_ground = |place: &str| {
                let place = Attachment::parse(place);
                place.is_some_and(|place| place.body().is_none())
            };
            let grounds = matches!(joint, Joint::Fixed(_)) && places.into_iter().any(on_ground);
            let driven = Driven::of(scene, name, joint);
            for (side, place) in Side::BOTH.into_iter().zip(places) {
                let key = if side == Side::A { "a" } else { "b" };
                let at = format!("joints.{name}.{}.{key}", joint.kind());
                let Some(found) = self.at(&at, place)? else {
                    continue;
                };
                found.is_grounded |= grounds;
                let own = Transmission::of_joint(scene, parts, joint, side);
                found.load(&own, format!("joints.{name}"));
                for by in &driven.turned_by {
                    let more = Transmission::about_the_axis(scene, parts, joint, side);
                    found.load(&more, by.clone());
                }
                for by in &driven.pushed_by {
                    let more = Transmission::along_the_axis(scene, parts, joint, side);
                    found.load(&more, by.clone());
                }
            }
        }
        Ok(())
    }

    fn springs(&mut self) -> Result<(), Error> {
        let scene = self.scene;
        for (name, spring) in &scene.springs {
            let (kind, places) = match spring {
                Spring::Spring(spring) => ("spring", [&spring.a, &spring.b]),
                Spring::Bushing(bushing) => ("bushing", [&bushing.a, &bushing.b]),
                // It acts on its joint.
                Spring::TorsionSpring(_) => continue,
            };
            for (side, place) in Side::BOTH.into_iter().zip(places) {
                let key = if side == Side::A { "a" } else { "b" };
                let at = format!("springs.{name}.{kind}.{key}");
                if let Some(found) = self.at(&at, place)? {
                    found.load(
                        &Transmission::of_spring(spring, side),
                        format!("springs.{name}"),
                    );
                }
            }
        }
        Ok(())
    }

    fn loads(&mut self) -> Result<(), Error> {
        let scene = self.scene;
        let to_component = kept_orientation(scene, self.body);
        for (name, load) in &scene.loads {
            let (kind, half, first, load) = match load {
                Load::Force(load) => ("force", Half::Force, 0, load),
                Load::Torque(load) => {
                    let first = first_torque_axis(scene.dimension);
                    ("torque", Half::Moment, first, load)
                }
                Load::PartLoad(_) => continue,
            };
            let Some(found) = self.at(&format!("loads.{name}.{kind}.at"), &load.at)? else {
                continue;
            };
            let directions = found.directions(load, first, to_component.as_ref());
            for direction in &directions {
                found.space.add(half, direction);
            }
            if !directions.is_empty() {
                found.loaded_by.push(format!("loads.{name}"));
                if load.axes == LoadAxes::Follower {
                    found.observed_by.insert(format!("loads.{name}"));
                }
            }
        }
        Ok(())
    }

    fn outputs(&mut self) -> Result<(), Error> {
        let scene = self.scene;
        for (name, output) in &scene.outputs {
            let by = format!("outputs.{name}");
            let at = format!("{by}.{}", output.kind());
            for place in output.observes(scene) {
                if let Some(found) = self.at(&at, &place)? {
                    found.observed_by.insert(by.clone());
                }
            }
        }
        Ok(())
    }
}

impl Found {
    fn load(&mut self, transmission: &Transmission, by: String) {
        let halves = [
            (Half::Force, &transmission.forces),
            (Half::Moment, &transmission.moments),
        ];
        let mut acts = false;
        for (half, spans) in halves {
            for span in spans {
                for vector in span.vectors() {
                    self.space.add(half, &(self.orientation * vector));
                }
                acts |= *span != Span::Nothing;
            }
        }
        if acts {
            self.loaded_by.push(by);
        }
    }

    /// Directions of a load, component axes.
    fn directions(
        &self,
        load: &LoadFunction,
        first_axis: usize,
        to_component: Option<&Matrix3<f64>>,
    ) -> Vec<Vector3<f64>> {
        let given = load_directions(load, first_axis);
        let turned = |by: &Matrix3<f64>| given.iter().map(|direction| by * direction).collect();
        match (load.axes, to_component) {
            (LoadAxes::Follower, _) => turned(&self.orientation),
            (LoadAxes::World, Some(turn)) => turned(turn),
            (LoadAxes::World, None) if given.is_empty() => Vec::new(),
            (LoadAxes::World, None) => Span::Everything.vectors(),
        }
    }
}

/// Whether a body of the scene is a superelement.
///
/// # Errors
/// [`Error::Formats`] if it is rigid or isn't there.
pub(super) fn superelement<'a>(
    scene: &'a Scene,
    name: &str,
) -> Result<&'a dcb_formats::scene::SuperelementBody, Error> {
    let known = scene.bodies.keys().map(String::as_str);
    match scene.bodies.get(name).map(|body| &body.kind) {
        Some(BodyKind::Superelement(body)) => Ok(body),
        Some(BodyKind::Rigid(_)) => Err(Error::described(
            format!("bodies.{name}"),
            "is rigid; expected a superelement",
        )),
        None => Err(Error::described(
            "bodies",
            format!(
                "no body is called {name:?}{}",
                dcb_formats::description::suggestion(name, known)
            ),
        )),
    }
}
