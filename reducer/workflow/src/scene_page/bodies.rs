//! Bodies of a page: their meshes and solids, and where they are.

use dcb_formats::scene::Geometry;
use dcb_runtime::error::Error;
use dcb_view::{Arrays, Body, Shape};
use faer::Mat;
use nalgebra::Vector3;

use super::box_of_all::BoxOfAll;
use super::moments::Moments;
use super::solids::Solids;
use super::{Run, meshes};
use crate::drawn_interfaces::{place, rods};
use crate::page_room;

/// Name of what doesn't move.
const GROUND: &str = "ground";

/// Meshes and bodies of a page.
pub struct Drawn {
    pub shapes: Vec<Shape>,
    /// Those of the scene in its order, then the ground if it has a geometry.
    pub bodies: Vec<Body>,
    /// Diagonal of the box around everything, over the whole motion.
    pub size: f64,
    /// What isn't shown, for people.
    pub notes: Vec<String>,
}

impl Drawn {
    /// How exact the deflections are, for people; none where nothing deflects.
    pub fn exactness(&self) -> Option<String> {
        let deflecting = self.shapes.iter().filter(|shape| !shape.columns.is_empty());
        let largest = deflecting.map(|shape| shape.error).reduce(f64::max)?;
        Some(format!(
            "At these times a deflection in the view is within {:.2} % of the largest one of its part: so much do rounding to integers and left-out patterns do together, at most.",
            // Rounded up: it is a bound.
            (1e4 * largest).ceil() / 100.0
        ))
    }
}

pub fn drawn(run: &Run, moments: &Moments, arrays: &mut Arrays) -> Result<Drawn, Error> {
    let system = &run.model.system;
    let mut drawn = Drawn {
        shapes: Vec::new(),
        bodies: Vec::new(),
        size: 0.0,
        notes: Vec::new(),
    };
    let mut solids = Solids::of(&run.scene);
    let mut of_bodies = Vec::new();
    for body in &system.bodies {
        let geometry = run.scene.bodies.get(&body.name);
        let geometry: &[Geometry] = geometry.map_or(&[], |body| &body.geometry);
        let origin = Vector3::from(body.flexible.origin);
        of_bodies.push(solids.of_body(geometry, origin, arrays)?);
    }
    let of_ground = solids.of_body(&run.scene.ground.geometry, Vector3::zeros(), arrays)?;
    let mut shape_of = vec![None; system.bodies.len()];
    let mut amplitudes = vec![None; system.bodies.len()];
    let mut meshes = meshes::of(run, moments)?;
    let frame_bytes = 4 * moments.times().len() * run.motion_columns();
    let room = page_room::BYTES.saturating_sub(arrays.byte_count() + frame_bytes);
    let room = room.max(page_room::LEAST_BYTES_OF_SHAPES);
    drawn.notes.extend(meshes::fit(&mut meshes, room));
    for mesh in &meshes {
        let name = run.file_name_of(mesh.body_name());
        let others = mesh.others().iter();
        let others = others.map(|kind| format!("{name}: cells of type {kind} aren't drawn"));
        drawn.notes.extend(others);
        let corners = box_corners(&mesh.positions());
        for (body, history) in mesh.bodies.iter().zip(mesh.amplitudes(arrays)) {
            shape_of[*body] = Some(drawn.shapes.len());
            amplitudes[*body] = Some(history);
            of_bodies[*body].corners.extend(&corners);
        }
        drawn.shapes.push(mesh.shape(&name, arrays));
    }
    let mut box_of_all = BoxOfAll::default();
    for (index, (body, mut looks)) in system.bodies.iter().zip(of_bodies).enumerate() {
        let frames = moments.frames(run, &body.name)?;
        let points: Vec<_> = body.flexible.interfaces.iter().map(place).collect();
        let is_rigid = run.file_name_of(&body.name).is_empty();
        if shape_of[index].is_none() && !is_rigid {
            drawn.notes.push(format!(
                "body {}: its superelement has no nodal fields (or is spatial in a planar scene), so that its mesh isn't drawn",
                body.name
            ));
        }
        if looks.corners.is_empty() {
            looks.solids.push(rods(&points));
            looks.corners.push(Vector3::zeros());
        }
        let places = points.iter().map(|point| Vector3::from(point.position));
        looks.corners.extend(places);
        for frame in &frames {
            box_of_all.include(frame, &looks.corners);
        }
        drawn.bodies.push(Body {
            name: body.name.clone(),
            shape: shape_of[index],
            solids: looks.solids,
            points,
            frames: Some(arrays.reals(frames.iter().flatten().copied())),
            rest: frames.first().copied().unwrap_or(AT_ORIGIN),
            amplitudes: amplitudes[index],
        });
    }
    if !of_ground.solids.is_empty() {
        box_of_all.include(&AT_ORIGIN, &of_ground.corners);
        drawn.bodies.push(Body {
            name: GROUND.to_owned(),
            shape: None,
            solids: of_ground.solids,
            points: Vec::new(),
            frames: None,
            rest: AT_ORIGIN,
            amplitudes: None,
        });
    }
    drawn.size = box_of_all.diagonal();
    Ok(drawn)
}

/// Axes of the world.
const AT_ORIGIN: [f64; 7] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0];

impl Run<'_> {
    /// Name of the superelement file of a body; empty for a rigid one.
    pub(super) fn file_name_of(&self, body: &str) -> String {
        let mut all = self.scene.superelements();
        let found = all.find(|(name, _)| *name == body);
        let path = found.map(|(_, body)| body.file.clone());
        let path = path.unwrap_or_default();
        path.file_name()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned()
    }

    /// A channel at some rows; nothing where there is none.
    pub(super) fn history_at(&self, path: &str, rows: &[usize]) -> Result<Option<Mat<f64>>, Error> {
        if !self
            .results
            .channels()
            .iter()
            .any(|channel| channel.path == path)
        {
            return Ok(None);
        }
        let whole = self.results.history(path)?;
        Ok(Some(Mat::from_fn(
            rows.len(),
            whole.ncols(),
            |row, column| whole[(rows[row], column)],
        )))
    }
}

fn box_corners(positions: &[[f64; 3]]) -> Vec<Vector3<f64>> {
    let mut limits = [[f64::MAX; 3], [f64::MIN; 3]];
    for position in positions {
        for axis in 0..3 {
            limits[0][axis] = limits[0][axis].min(position[axis]);
            limits[1][axis] = limits[1][axis].max(position[axis]);
        }
    }
    if positions.is_empty() {
        return Vec::new();
    }
    (0..8_usize)
        .map(|corner| Vector3::from_fn(|axis, _| limits[(corner >> axis) & 1][axis]))
        .collect()
}
