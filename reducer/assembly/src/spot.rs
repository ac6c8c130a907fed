//! Places where parts are joined: a frame, or a node, and the measures of its motion.

use dcb_formats::component::Role;
use dcb_formats::mesh::Dimension;
use dcb_formats::scene::{Attachment, Point, Scene};
use nalgebra::{Matrix3, Vector3};

use crate::Error;
use crate::measure::Measure;
use crate::part::{Part, PartKind};

/// Entries of axes below this are rounding.
pub(crate) const ALONG: f64 = 1e-12;

/// A frame or a node.
#[derive(Clone, Debug)]
pub(crate) struct Spot {
    /// The body; `None` on the ground.
    pub body: Option<usize>,
    /// In the assembly.
    pub position: Vector3<f64>,
    /// Its axes in axes of the assembly.
    pub axes: Matrix3<f64>,
    /// Translation along each axis of the assembly, where its rows say it.
    pub translation: [Option<Measure>; 3],
    /// Rotation about each axis of the assembly, where its rows say it.
    pub rotation: [Option<Measure>; 3],
}

/// One frame, or the nodes of an interface.
#[derive(Clone, Debug)]
pub(crate) struct Place {
    pub name: String,
    pub spots: Vec<Spot>,
}

impl Place {
    /// A place by its name.
    ///
    /// # Errors
    /// [`Error::Place`] at `location` where there is none, or its rows can't be joined.
    pub fn of(location: &str, name: &str, scene: &Scene, parts: &[Part]) -> Result<Self, Error> {
        let spots = match Attachment::parse(name) {
            Some(Attachment::Ground) => {
                vec![Spot::on_ground(Vector3::zeros(), Matrix3::identity())]
            }
            Some(Attachment::GroundPoint(point)) => {
                let point = &scene.ground.points.get(point);
                let point = point.ok_or_else(|| {
                    Error::place(location, format!("the ground has no point {name:?}"))
                })?;
                let axes = point.rotation().to_rotation_matrix().into_inner();
                vec![Spot::on_ground(point.position(), axes)]
            }
            Some(Attachment::Body { body, point }) => {
                let index = parts.iter().position(|part| part.name == body);
                let index = index
                    .ok_or_else(|| Error::place(location, format!("no body is called {body:?}")))?;
                match &parts[index].kind {
                    PartKind::Rigid(rigid) => {
                        let found = rigid.points.get(point).ok_or_else(|| {
                            Error::place(location, format!("body {body:?} has no point {point:?}"))
                        })?;
                        vec![Spot::on_rigid(
                            index,
                            &parts[index],
                            found,
                            rigid.is_point_mass(),
                        )]
                    }
                    PartKind::Flexible(_) => {
                        on_interface(location, name, index, point, &parts[index])?
                    }
                }
            }
            None => return Err(Error::place(location, format!("{name:?} is no place"))),
        };
        Ok(Self {
            name: name.to_owned(),
            spots,
        })
    }
}

impl Spot {
    fn on_ground(position: Vector3<f64>, axes: Matrix3<f64>) -> Self {
        Self {
            body: None,
            position,
            axes,
            translation: [(); 3].map(|()| Some(Measure::default())),
            rotation: [(); 3].map(|()| Some(Measure::default())),
        }
    }

    fn on_rigid(body: usize, part: &Part, point: &Point, is_point_mass: bool) -> Self {
        let PartKind::Rigid(rigid) = &part.kind else {
            return Self::on_ground(part.centre, part.axes);
        };
        let position = part.centre + part.axes * (point.position() - rigid.center());
        let axes = part.axes * point.rotation().to_rotation_matrix().into_inner();
        let arm = position - part.centre;
        let rotation = |axis: usize| match is_point_mass {
            true => None,
            false => Some(Measure::of_frame(body, turn(axis))),
        };
        Self {
            body: Some(body),
            position,
            axes,
            translation: [0, 1, 2].map(|axis| Some(Measure::of_frame(body, shift(axis, arm)))),
            rotation: [0, 1, 2].map(rotation),
        }
    }

    /// Whether all rotations that bodies of this dimension have are known.
    pub fn turns(&self, dimension: Dimension) -> bool {
        rotations(dimension)
            .iter()
            .all(|axis| self.rotation[*axis].is_some())
    }

    /// Rotation about an axis of the assembly: that of its rows, or of the body's frame where it has none.
    pub fn turning(&self, axis: usize, parts: &[Part]) -> Option<Measure> {
        if let Some(own) = &self.rotation[axis] {
            return Some(own.clone());
        }
        let body = self.body?;
        let has_inertia = parts[body].rigid_count() > parts[body].dimension.coordinate_count();
        has_inertia.then(|| Measure::of_frame(body, turn(axis)))
    }

    /// Translation along an axis of the assembly of the point of the body at `position`, which moves with the spot as if rigidly linked.
    pub fn linked(&self, axis: usize, position: Vector3<f64>, parts: &[Part]) -> Option<Measure> {
        let arm = position - self.position;
        let mut linked = self.translation[axis].clone()?;
        // (θ × arm) · e = θ · (arm × e)
        let lever = arm.cross(&Vector3::ith(axis, 1.0));
        for about in 0..3 {
            if lever[about].abs() > 0.0
                && let Some(turning) = self.turning(about, parts)
            {
                linked = linked.plus(lever[about], &turning);
            }
        }
        Some(linked)
    }
}

/// Axes of rotation that bodies have.
pub(crate) fn rotations(dimension: Dimension) -> &'static [usize] {
    match dimension {
        Dimension::Planar => &[2],
        Dimension::Spatial => &[0, 1, 2],
    }
}

fn shift(axis: usize, arm: Vector3<f64>) -> [f64; 6] {
    let mut weights = [0.0; 6];
    weights[axis] = 1.0;
    let lever = arm.cross(&Vector3::ith(axis, 1.0));
    weights[3..].copy_from_slice(lever.as_slice());
    weights
}

fn turn(axis: usize) -> [f64; 6] {
    let mut weights = [0.0; 6];
    weights[3 + axis] = 1.0;
    weights
}

/// The frame of an interface, or its nodes.
fn on_interface(
    location: &str,
    name: &str,
    body: usize,
    interface: &str,
    part: &Part,
) -> Result<Vec<Spot>, Error> {
    let Some(flexible) = part.flexible() else {
        return Ok(Vec::new());
    };
    let element = &flexible.element;
    let Some(index) = element
        .interfaces
        .iter()
        .position(|of| of.name == interface)
    else {
        let names: Vec<&str> = element
            .interfaces
            .iter()
            .map(|of| of.name.as_str())
            .collect();
        return Err(Error::place(
            location,
            format!(
                "{:?} has no interface {interface:?} (there are: {})",
                part.name,
                names.join(", ")
            ),
        ));
    };
    let frame = &element.interfaces[index];
    let orientation = Matrix3::from_fn(|a, b| frame.orientation[a][b]);
    let axes = part.frame(orientation);
    let mut spots: Vec<(i64, Vec<usize>)> = Vec::new();
    for (row, of) in element.rows.iter().enumerate() {
        if of.interface != index {
            continue;
        }
        if of.direction < 0 {
            return Err(Error::place(
                location,
                format!(
                    "{name:?} has explicit rows (--boundary), which don't say how a rigid motion moves them; make it an interface of nodes or a frame"
                ),
            ));
        }
        match spots.iter_mut().find(|(node, _)| *node == of.node) {
            Some((_, rows)) => rows.push(row),
            None => spots.push((of.node, vec![row])),
        }
    }
    Ok(spots
        .into_iter()
        .map(|(_, rows)| {
            let position = part.place(element.rows[rows[0]].position);
            let along = |is_rotation: bool, matrix: Matrix3<f64>| {
                [0, 1, 2].map(|axis| combination(body, element, &rows, is_rotation, &matrix, axis))
            };
            Spot {
                body: Some(body),
                position,
                axes,
                translation: along(false, part.axes),
                rotation: along(true, part.axial()),
            }
        })
        .collect())
}

/// Rows of one spot that make the motion along or about an axis of the assembly; `None` where one is missing.
fn combination(
    body: usize,
    element: &dcb_formats::Superelement,
    rows: &[usize],
    is_rotation: bool,
    axes: &Matrix3<f64>,
    axis: usize,
) -> Option<Measure> {
    let mut weights = Vec::new();
    for own in 0..3 {
        let weight = axes[(axis, own)];
        if weight.abs() <= ALONG {
            continue;
        }
        let direction = if is_rotation { 3 + own } else { own } as i64;
        let row = rows
            .iter()
            .find(|row| element.rows[**row].direction == direction)?;
        weights.push((*row, weight));
    }
    Some(Measure::of_rows(body, weights))
}

/// That no force acts on a place that is only observed.
///
/// # Errors
/// [`Error::Place`].
pub(crate) fn refuse_observed(location: &str, name: &str, parts: &[Part]) -> Result<(), Error> {
    let Some(Attachment::Body { body, point }) = Attachment::parse(name) else {
        return Ok(());
    };
    let part = parts.iter().find(|part| part.name == body);
    let interfaces = part
        .and_then(Part::flexible)
        .map(|of| &of.element.interfaces);
    let found = interfaces.and_then(|all| all.iter().find(|of| of.name == point));
    match found.is_some_and(|of| of.role == Role::Output) {
        false => Ok(()),
        true => Err(Error::place(
            location,
            format!(
                "{name:?} is an output: the part has no attachment there, so no force can act on it; reduce the part with this interface as an attachment"
            ),
        )),
    }
}

/// That a place has no row along an axis of the assembly.
pub(crate) fn lacking(location: &str, name: &str, axis: usize) -> Error {
    Error::place(
        location,
        format!(
            "{name:?} has no row that moves along {} of the assembly; take the interface with all translations",
            ["x", "y", "z"][axis]
        ),
    )
}
