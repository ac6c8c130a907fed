//! Planes that a spatial scene is its own mirror image in: motion that starts there stays there.
//!
//! Seen in a mirror, a mechanism moves as its mirror image does. Where every place, axis, force and initial velocity is its own
//! image and every part is, no motion across the plane is ever excited, and none of the deflections that are unsymmetric. That the parts are
//! symmetric isn't known here: a plane is a claim about the scene, and holds if each superelement has it as a plane of symmetry,
//! its loads included. Motion across the plane that would grow by itself from nothing, as a column buckles, isn't excluded by symmetry.

use dcb_formats::mesh::Dimension;
use nalgebra::{Matrix3, Vector3};
use serde::Serialize;

use super::part::{DrawnPlace, Parts};
use super::transmission::{Driven, acts, axis, first_torque_axis, load_directions};
use dcb_formats::scene::{
    Analysis, Attachment, Body, BodyKind, Bushing, Characteristic, Load, LoadAxes, Placement,
    Scene, Side, Spring, in_space,
};

/// How nearly an axis of a frame is a plane's normal: rounding.
pub const ALIGNED: f64 = 1e-9;
/// Sines of angles, and distances by the size of the scene, below this are what seven written digits leave.
const ROUNDING: f64 = 1e-6;

/// The points x with `normal · x = offset`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PlaneOfMotion {
    /// Unit vector.
    pub normal: [f64; 3],
    /// Length.
    pub offset: f64,
    /// Whether the normal is an axis of the world, of every body's frame and of every place that a joint joins: what joints hold is then
    /// either motion in the plane or out of it.
    pub is_along_frames: bool,
}

/// Planes of a scene.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct PlanesOfMotion {
    /// Those that the motion stays in if the parts are symmetric to them.
    pub planes: Vec<PlaneOfMotion>,
    /// Why others that were tried are none.
    pub refused: Vec<String>,
}

impl PlaneOfMotion {
    /// The same plane of a body as drawn, component coordinates.
    pub fn seen_from(&self, placement: &Placement) -> Self {
        let normal = Vector3::from(self.normal);
        Self {
            normal: (placement.orientation.inverse() * normal).into(),
            offset: self.offset - normal.dot(&placement.position),
            is_along_frames: self.is_along_frames,
        }
    }
}

impl PlanesOfMotion {
    /// In world axes, of a checked scene. Tried are planes across the axes of joints and of the world.
    pub fn of(scene: &Scene, parts: &Parts) -> Self {
        let mut found = Self::default();
        if scene.dimension == Dimension::Planar {
            found.refused.push("the scene is planar".into());
            return found;
        }
        if let Analysis::Modes(_) | Analysis::FrequencyResponse(_) = scene.analysis {
            let why = "oscillations out of a plane are asked for as well";
            found.refused.push(why.into());
            return found;
        }
        let mut tried: Vec<Vector3<f64>> = Vec::new();
        for normal in candidates(scene, parts) {
            if tried.iter().any(|known| is_parallel(known, &normal)) {
                continue;
            }
            tried.push(normal);
            let mirror = Mirror {
                scene,
                parts,
                normal,
            };
            match mirror.plane() {
                Ok(plane) => found.planes.push(plane),
                Err(why) => {
                    let [x, y, z] = <[f64; 3]>::from(normal);
                    let across = format!("across [{x:.4}, {y:.4}, {z:.4}]: {why}");
                    found.refused.push(across);
                }
            }
        }
        found
    }
}

fn candidates(scene: &Scene, parts: &Parts) -> Vec<Vector3<f64>> {
    let of_joints = scene.joints.values().filter_map(|joint| {
        let [a, _] = joint.attachments()?;
        let own = axis(scene, parts, joint, Side::A)?;
        Some((DrawnPlace::of(scene, parts, a)?.axes * own).normalize())
    });
    of_joints
        .chain([Vector3::z(), Vector3::y(), Vector3::x()])
        .collect()
}

fn is_parallel(a: &Vector3<f64>, b: &Vector3<f64>) -> bool {
    a.cross(b).norm() <= ROUNDING * a.norm() * b.norm()
}

fn is_perpendicular(a: &Vector3<f64>, b: &Vector3<f64>) -> bool {
    a.dot(b).abs() <= ROUNDING * a.norm() * b.norm()
}

/// A scene in a mirror across a direction.
struct Mirror<'a> {
    scene: &'a Scene,
    parts: &'a Parts,
    normal: Vector3<f64>,
}

impl Mirror<'_> {
    /// The mirror's plane, or what isn't its own image.
    fn plane(&self) -> Result<PlaneOfMotion, String> {
        if !is_perpendicular(&self.scene.gravity_in_space(), &self.normal) {
            return Err("gravity isn't in the plane".into());
        }
        let mut points = Vec::new();
        self.bodies(&mut points)?;
        self.joints(&mut points)?;
        self.springs(&mut points)?;
        self.loads(&mut points)?;
        let Some((_, first)) = points.first() else {
            return Err("nothing has a place".into());
        };
        let offset = self.normal.dot(first);
        let size = points.iter().map(|(_, point)| (point - first).norm());
        let size = size.fold(f64::EPSILON * first.norm() / ROUNDING, f64::max);
        let off = |point: &Vector3<f64>| (self.normal.dot(point) - offset).abs();
        match points
            .iter()
            .find(|(_, point)| off(point) > ROUNDING * size)
        {
            Some((which, point)) => Err(format!(
                "{which} is {:.3e} off the plane of {}",
                off(point),
                points[0].0
            )),
            None => Ok(PlaneOfMotion {
                normal: self.normal.into(),
                offset,
                is_along_frames: self.is_along_frames(),
            }),
        }
    }

    fn is_along_frames(&self) -> bool {
        let placements = self.scene.bodies.values().map(Body::placement);
        let mut of_bodies =
            placements.map(|placement| placement.orientation.inverse() * self.normal);
        let joints = self
            .scene
            .joints
            .values()
            .filter_map(|joint| joint.attachments());
        let mut of_places = joints.flatten().map(|reference| {
            let place = self.place(reference).ok()?;
            Some(place.axes.tr_mul(&self.normal))
        });
        axis_along(&self.normal).is_some()
            && of_bodies.all(|own| axis_along(&own).is_some())
            && of_places.all(|own| own.is_some_and(|own| axis_along(&own).is_some()))
    }

    fn place(&self, reference: &str) -> Result<DrawnPlace, String> {
        DrawnPlace::of(self.scene, self.parts, reference)
            .ok_or_else(|| format!("where {reference} is isn't known"))
    }

    fn bodies(&self, points: &mut Vec<(String, Vector3<f64>)>) -> Result<(), String> {
        for (name, body) in &self.scene.bodies {
            let placement = body.placement();
            if !is_perpendicular(&placement.velocity, &self.normal) {
                return Err(format!("bodies.{name} starts with a velocity across"));
            }
            if !is_parallel(&placement.angular_velocity, &self.normal) {
                return Err(format!("bodies.{name} starts to turn out of the plane"));
            }
            let BodyKind::Rigid(rigid) = &body.kind else {
                continue;
            };
            let center = in_space(rigid.center_of_mass.as_deref().unwrap_or_default());
            let center = placement.position + placement.orientation * center;
            points.push((format!("the centre of mass of bodies.{name}"), center));
            let normal = placement.orientation.inverse() * self.normal;
            let along = rigid.inertia.matrix() * normal;
            if !is_parallel(&along, &normal) {
                return Err(format!("the normal is no principal axis of bodies.{name}"));
            }
        }
        Ok(())
    }

    fn joints(&self, points: &mut Vec<(String, Vector3<f64>)>) -> Result<(), String> {
        for (name, joint) in &self.scene.joints {
            let Some(places) = joint.attachments() else {
                continue;
            };
            let driven = Driven::of(self.scene, name, joint);
            for (side, reference) in Side::BOTH.into_iter().zip(places) {
                let place = self.place(reference)?;
                points.push((reference.to_owned(), place.position));
                let Some(axis) = axis(self.scene, self.parts, joint, side) else {
                    continue;
                };
                let axis = place.axes * axis;
                let across = is_parallel(&axis, &self.normal);
                if !across && !is_perpendicular(&axis, &self.normal) {
                    return Err(format!("the axis of joints.{name} is oblique"));
                }
                // The image of a turn about an axis in the plane is the opposite turn, and of a translation across it the opposite one.
                let opposed = match across {
                    true => &driven.pushed_by,
                    false => &driven.turned_by,
                };
                if let Some(by) = opposed.first() {
                    return Err(format!("{by} moves joints.{name} out of the plane"));
                }
            }
        }
        Ok(())
    }

    fn springs(&self, points: &mut Vec<(String, Vector3<f64>)>) -> Result<(), String> {
        for (name, spring) in &self.scene.springs {
            let (a, b) = match spring {
                Spring::Spring(spring) => (&spring.a, &spring.b),
                Spring::Bushing(bushing) => (&bushing.a, &bushing.b),
                Spring::TorsionSpring(_) => continue,
            };
            for reference in [a, b] {
                points.push((reference.clone(), self.place(reference)?.position));
            }
            if let Spring::Bushing(bushing) = spring
                && !self.is_symmetric(bushing, &self.place(a)?.axes)
            {
                return Err(format!("springs.{name} isn't symmetric"));
            }
        }
        Ok(())
    }

    /// One of its axes is across the plane, and what it does along that one and about the others is proportional.
    fn is_symmetric(&self, bushing: &Bushing, axes: &Matrix3<f64>) -> bool {
        let across = (0..3).find(|axis| is_parallel(&axes.column(*axis).into(), &self.normal));
        let Some(across) = across else {
            return false;
        };
        let is_linear = |list: &Option<Vec<Characteristic>>, axis: usize| {
            let entry = list.as_ref().and_then(|list| list.get(axis));
            entry.is_none_or(|entry| matches!(entry, Characteristic::Linear(_)) || !acts(entry))
        };
        let about_others = (0..3).filter(|axis| *axis != across);
        let mut turns = about_others.flat_map(|axis| {
            let lists = [&bushing.rotation, &bushing.rotation_damping];
            lists.map(|list| is_linear(list, axis))
        });
        is_linear(&bushing.translation, across)
            && is_linear(&bushing.translation_damping, across)
            && turns.all(|linear| linear)
    }

    fn loads(&self, points: &mut Vec<(String, Vector3<f64>)>) -> Result<(), String> {
        for (name, load) in &self.scene.loads {
            let (given, first) = match load {
                Load::Force(given) => (given, 0),
                Load::Torque(given) => (given, first_torque_axis(self.scene.dimension)),
                Load::PartLoad(_) => continue,
            };
            let place = self.place(&given.at)?;
            let axes = match given.axes {
                LoadAxes::World => Matrix3::identity(),
                LoadAxes::Follower => place.axes,
            };
            for direction in load_directions(given, first) {
                let direction = axes * direction;
                let (stays, what) = match load {
                    Load::Force(_) => (is_perpendicular(&direction, &self.normal), "pushes"),
                    _ => (is_parallel(&direction, &self.normal), "turns"),
                };
                if !stays {
                    return Err(format!("loads.{name} {what} out of the plane"));
                }
            }
            // A torque may act anywhere on a rigid body, but on a superelement its place is one of the part.
            let body = Attachment::parse(&given.at).and_then(|at| at.body());
            let body = body.and_then(|body| self.scene.bodies.get(body));
            let anywhere = matches!(load, Load::Torque(_))
                && body.is_some_and(|body| matches!(body.kind, BodyKind::Rigid(_)));
            if !anywhere {
                points.push((given.at.clone(), place.position));
            }
        }
        Ok(())
    }
}

/// The axis of a frame that is along a unit vector in the frame's axes, either way.
pub fn axis_along(own: &Vector3<f64>) -> Option<usize> {
    let axis = own.iamax();
    let mut across = *own;
    across[axis] = 0.0;
    (across.norm() <= ALIGNED).then_some(axis)
}
