//! Bodies of a page: their meshes with the patterns in which they deflect, and where they are.

use dcb_formats::superelement::InterfaceFrame;
use dcb_runtime::error::Error;
use dcb_runtime::model::FieldPlan;
use dcb_view::{Array, Arrays, Body, Drawing, Pattern, Place, Shape, Solid};
use faer::Mat;
use nalgebra::{Matrix3, Quaternion, Rotation3, UnitQuaternion, Vector3};

use super::Run;

/// Patterns whose largest displacement in the run is less than this part of the largest one of the body are left out.
const SEEN: f64 = 1e-4;
/// Frames in which the largest displacement is looked for.
const LOOKED_AT: usize = 40;
/// Radius of the rods of a rigid body over the reach of its points.
const ROD: f64 = 0.035;

/// Meshes and bodies of a page.
pub struct Drawn {
    pub shapes: Vec<Shape>,
    pub bodies: Vec<Body>,
    /// Diagonal of the box around everything, over the whole motion.
    pub size: f64,
    /// What isn't shown, for people.
    pub notes: Vec<String>,
}

/// A mesh that bodies of one superelement share.
struct Shared<'a> {
    plan: &'a FieldPlan,
    drawing: Drawing,
    bodies: Vec<usize>,
}

pub fn drawn(run: &Run, rows: &[usize], arrays: &mut Arrays) -> Result<Drawn, Error> {
    let system = &run.model.system;
    let mut shared: Vec<Shared> = Vec::new();
    for plan in &run.model.fields {
        let body = system
            .bodies
            .iter()
            .position(|body| body.name == plan.body_name());
        let Some(body) = body else { continue };
        match shared
            .iter_mut()
            .find(|known| known.plan.field() == plan.field())
        {
            Some(known) => known.bodies.push(body),
            None => shared.push(Shared {
                plan,
                drawing: Drawing::of(plan.mesh()),
                bodies: vec![body],
            }),
        }
    }
    let mut box_of_all = BoxOfAll::default();
    let mut drawn = Drawn {
        shapes: Vec::new(),
        bodies: Vec::new(),
        size: 0.0,
        notes: Vec::new(),
    };
    let mut shape_of = vec![None; system.bodies.len()];
    let mut amplitudes: Vec<Option<Array>> = vec![None; system.bodies.len()];
    let mut corners = vec![Vec::new(); system.bodies.len()];
    for mesh in &shared {
        let positions: Vec<[f64; 3]> = (mesh.drawing.nodes.iter())
            .map(|node| mesh.plan.field().positions()[*node as usize].into())
            .collect();
        let mut coordinates = Vec::new();
        for body in &mesh.bodies {
            coordinates.push(amplitude_history(run, *body, rows)?);
            shape_of[*body] = Some(drawn.shapes.len());
            corners[*body] = box_corners(&positions);
        }
        let (kept, patterns, error) = seen_patterns(mesh, &coordinates);
        for (body, history) in mesh.bodies.iter().zip(&coordinates) {
            let numbers = (0..history.nrows())
                .flat_map(|row| kept.iter().map(move |column| history[(row, *column)]));
            amplitudes[*body] = Some(arrays.reals(numbers));
        }
        let name = run.file_name_of(mesh.plan.body_name());
        drawn.notes.extend(
            mesh.drawing
                .others
                .iter()
                .map(|kind| format!("{name}: cells of type {kind} aren't drawn")),
        );
        drawn.shapes.push(Shape::rounded(
            &name,
            &mesh.drawing,
            &positions,
            &patterns,
            error,
            arrays,
        ));
    }
    for (index, body) in system.bodies.iter().enumerate() {
        let frames = frames(run, &body.name, rows)?;
        let points: Vec<Place> = body.flexible.interfaces.iter().map(place).collect();
        if corners[index].is_empty() {
            corners[index] = points.iter().map(|point| point.position.into()).collect();
            corners[index].push(Vector3::zeros());
        }
        for frame in &frames {
            box_of_all.include(frame, &corners[index]);
        }
        let is_rigid = run.file_name_of(&body.name).is_empty();
        let solids = match shape_of[index] {
            Some(_) => Vec::new(),
            None => simple(&points),
        };
        if shape_of[index].is_none() && !is_rigid {
            drawn.notes.push(format!(
                "body {}: its superelement has no nodal fields (or is spatial in a planar scene), so that only its interfaces are drawn",
                body.name
            ));
        }
        drawn.bodies.push(Body {
            name: body.name.clone(),
            shape: shape_of[index],
            solids,
            points,
            frames: Some(arrays.reals(frames.iter().flatten().copied())),
            rest: frames
                .first()
                .copied()
                .unwrap_or([0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]),
            amplitudes: amplitudes[index],
        });
    }
    drawn.size = box_of_all.diagonal();
    Ok(drawn)
}

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

/// Elastic coordinates and, with static compatibility, forces on interface rows: (frames, columns).
fn amplitude_history(run: &Run, body: usize, rows: &[usize]) -> Result<Mat<f64>, Error> {
    let name = &run.model.system.bodies[body].name;
    let read = |what: &str| run.history_at(&format!("motion/{name}/{what}"), rows);
    let parts = [read("coordinates")?, read("forces")?];
    let width = parts.iter().flatten().map(Mat::ncols).sum();
    let mut all = Mat::zeros(rows.len(), width);
    let mut first = 0;
    for part in parts.iter().flatten() {
        all.as_mut()
            .subcols_mut(first, part.ncols())
            .copy_from(part);
        first += part.ncols();
    }
    let expected = run.model.fields.iter();
    let expected = expected.filter(|plan| plan.body_name() == name);
    match expected.map(|plan| plan.field().pattern_count()).next() {
        Some(count) if count != width => Err(run.refused(&format!(
            "has {width} coordinates of body {name:?}, but its superelement has {count} in this scene; run the scene again"
        ))),
        _ => Ok(all),
    }
}

/// The columns that are seen, their patterns, and a bound of what the others do, over the largest displacement.
fn seen_patterns(mesh: &Shared, histories: &[Mat<f64>]) -> (Vec<usize>, Vec<Pattern>, f64) {
    let field = mesh.plan.field();
    let patterns = (0..field.pattern_count()).map(|column| {
        let all = field.pattern(column);
        let drawn = mesh.drawing.nodes.iter();
        Pattern {
            name: format!("coordinate {}", column + 1),
            displacements: drawn.map(|node| all[*node as usize].into()).collect(),
        }
    });
    let patterns: Vec<Pattern> = patterns.collect();
    let reach = |column: usize, pattern: &Pattern| {
        let values = histories
            .iter()
            .flat_map(|history| history.col(column).iter());
        values.fold(0.0_f64, |largest, value| largest.max(value.abs())) * pattern.largest()
    };
    let reaches: Vec<f64> = patterns
        .iter()
        .enumerate()
        .map(|(column, pattern)| reach(column, pattern))
        .collect();
    let largest_reach = reaches.iter().copied().fold(0.0, f64::max);
    let is_seen = |column: &usize| reaches[*column] > SEEN * largest_reach;
    let kept: Vec<usize> = (0..patterns.len()).filter(is_seen).collect();
    let lost: f64 = (0..patterns.len())
        .filter(|column| !is_seen(column))
        .map(|column| reaches[column])
        .sum();
    let largest = histories
        .iter()
        .map(|history| largest_displacement(history, &patterns, &kept))
        .fold(0.0, f64::max);
    let error = if largest > 0.0 { lost / largest } else { 0.0 };
    let kept_patterns = kept.iter().map(|column| patterns[*column].clone());
    (kept.clone(), kept_patterns.collect(), error)
}

/// In some of the frames.
fn largest_displacement(history: &Mat<f64>, patterns: &[Pattern], kept: &[usize]) -> f64 {
    let nodes = patterns
        .first()
        .map_or(0, |pattern| pattern.displacements.len());
    let mut largest = 0.0_f64;
    for row in super::spread(history.nrows(), LOOKED_AT) {
        let mut sums = vec![Vector3::zeros(); nodes];
        for column in kept {
            let amplitude = history[(row, *column)];
            for (sum, of_node) in sums.iter_mut().zip(&patterns[*column].displacements) {
                *sum += Vector3::from(*of_node) * amplitude;
            }
        }
        largest = sums.iter().map(Vector3::norm).fold(largest, f64::max);
    }
    largest
}

/// Origin and quaternion of a body's frame.
fn frames(run: &Run, body: &str, rows: &[usize]) -> Result<Vec<[f64; 7]>, Error> {
    let Some(history) = run.history_at(&format!("motion/{body}/frame"), rows)? else {
        return Err(run.refused(&format!("has no motion of body {body:?}")));
    };
    Ok((0..history.nrows())
        .map(|row| match history.ncols() {
            3 => {
                let half = 0.5 * history[(row, 2)];
                [
                    history[(row, 0)],
                    history[(row, 1)],
                    0.0,
                    half.cos(),
                    0.0,
                    0.0,
                    half.sin(),
                ]
            }
            _ => std::array::from_fn(|column| history[(row, column)]),
        })
        .collect())
}

fn place(interface: &InterfaceFrame) -> Place {
    let rows = interface.orientation;
    let axes = Matrix3::from_fn(|i, j| rows[i][j]);
    let turn = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(axes));
    Place {
        name: interface.name.clone(),
        position: interface.position,
        axes: [turn.w, turn.i, turn.j, turn.k],
    }
}

/// A body of which nothing but its points is known: rods from the first to the others, or a ball.
fn simple(points: &[Place]) -> Vec<Solid> {
    let mut ends = vec![[0.0; 3]];
    ends.extend(points.iter().map(|point| point.position));
    let reach = ends
        .iter()
        .map(|end| Vector3::from(*end).norm())
        .fold(0.0, f64::max);
    match reach > 0.0 {
        true => vec![Solid::Stick {
            ends,
            radius: ROD * reach,
        }],
        // Its size is for the page to choose.
        false => vec![Solid::Sphere {
            radius: 0.0,
            position: [0.0; 3],
        }],
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

/// The box around places in the world.
struct BoxOfAll {
    low: Vector3<f64>,
    high: Vector3<f64>,
}

impl Default for BoxOfAll {
    fn default() -> Self {
        Self {
            low: Vector3::repeat(f64::MAX),
            high: Vector3::repeat(f64::MIN),
        }
    }
}

impl BoxOfAll {
    fn include(&mut self, frame: &[f64; 7], places: &[Vector3<f64>]) {
        let [x, y, z, w, i, j, k] = *frame;
        let turn = UnitQuaternion::from_quaternion(Quaternion::new(w, i, j, k));
        for place in places {
            let at = Vector3::new(x, y, z) + turn * place;
            self.low = self.low.inf(&at);
            self.high = self.high.sup(&at);
        }
    }

    fn diagonal(&self) -> f64 {
        let diagonal = (self.high - self.low).norm();
        if diagonal.is_finite() && diagonal > 0.0 {
            diagonal
        } else {
            1.0
        }
    }
}
