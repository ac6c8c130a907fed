//! The moments that a page shows: recorded times of a run, or modes one after another.
//!
//! A mode goes through one period in one unit of the page's time. With its shape = a − i b its motion is
//!
//! ```text
//! δq(φ)  =  Re(shape exp(iφ))  =  a cos φ + b sin φ,      φ from 0 to 2π
//! ```
//!
//! of the frame (translation and rotation in body axes) and of the elastic coordinates, without growth or decay.

use std::f64::consts::TAU;

use dcb_formats::results::{ModeShapes, SystemModes};
use dcb_runtime::error::Error;
use faer::Mat;
use nalgebra::{Quaternion, UnitQuaternion, Vector3};

use super::Run;
use super::box_of_all::BoxOfAll;

/// Frames of a period.
const PHASES: usize = 24;
/// Part of a unit of time that a period takes; in the rest the page goes to the next mode.
const PERIOD: f64 = 0.999;
/// Largest motion of a mode over the size of the mechanism.
const AMPLITUDE: f64 = 0.1;
/// Numbers of a body's frame in a mode.
const OF_FRAME: usize = 6;

/// Rows of the results that the page has, or the modes about one of them.
pub struct Moments {
    rows: Vec<usize>,
    times: Vec<f64>,
    modes: Option<ScaledModes>,
}

struct ScaledModes {
    modes: SystemModes,
    scale: f64,
}

impl Moments {
    /// The modes if the run has any, else rows that are spread evenly, at most so many.
    pub fn of(run: &Run, time: &[f64], most: usize) -> Result<Self, Error> {
        let modes = run.results.modes()?;
        let Some(modes) = modes.filter(|modes| !modes.frequency.is_empty()) else {
            let rows = super::spread(time.len(), most);
            let times = rows.iter().map(|row| time[*row]).collect();
            return Ok(Self {
                rows,
                times,
                modes: None,
            });
        };
        let rows = vec![time.len() - 1];
        let mut around = BoxOfAll::default();
        for body in &run.model.system.bodies {
            let places = body.flexible.interfaces.iter();
            let mut places: Vec<_> = places.map(|one| Vector3::from(one.position)).collect();
            places.push(Vector3::zeros());
            for frame in recorded_frames(run, &body.name, &rows)? {
                around.include(&frame, &places);
            }
        }
        let count = modes.frequency.len();
        let times =
            (0..count).flat_map(|mode| (0..=PHASES).map(move |k| mode as f64 + PERIOD * share(k)));
        Ok(Self {
            rows,
            times: times.collect(),
            // In the results the largest motion of a body is one length.
            modes: Some(ScaledModes {
                modes,
                scale: AMPLITUDE * around.diagonal(),
            }),
        })
    }

    /// Times of the page.
    pub fn times(&self) -> &[f64] {
        &self.times
    }

    /// Rows of the results at these times; none where the page shows modes.
    pub fn rows(&self) -> Option<&[usize]> {
        match self.modes {
            None => Some(&self.rows),
            Some(_) => None,
        }
    }

    /// The modes that the page shows.
    pub fn modes(&self) -> Option<&SystemModes> {
        self.modes.as_ref().map(|scaled| &scaled.modes)
    }

    /// Origin and quaternion of a body's frame at each time.
    pub fn frames(&self, run: &Run, body: &str) -> Result<Vec<[f64; 7]>, Error> {
        let recorded = recorded_frames(run, body, &self.rows)?;
        let (Some(scaled), Some(rest)) = (&self.modes, recorded.first()) else {
            return Ok(recorded);
        };
        let shape = scaled.of(body);
        let moved = scaled.phases().map(|(mode, k)| {
            let value =
                |column: usize| shape.map_or(0.0, |shape| scaled.value(shape, mode, k, column));
            moved(rest, std::array::from_fn(value))
        });
        Ok(moved.collect())
    }

    /// Elastic coordinates of a body at each time, and, with static compatibility, forces on interface rows: (times, columns).
    pub fn amplitudes(&self, run: &Run, body: &str) -> Result<Mat<f64>, Error> {
        let read = |what: &str| run.history_at(&format!("motion/{body}/{what}"), &self.rows);
        let parts = [read("coordinates")?, read("forces")?];
        let width: usize = parts.iter().flatten().map(Mat::ncols).sum();
        let mut recorded = Mat::zeros(self.rows.len(), width);
        let mut first = 0;
        for part in parts.iter().flatten() {
            recorded
                .as_mut()
                .subcols_mut(first, part.ncols())
                .copy_from(part);
            first += part.ncols();
        }
        let Some(scaled) = &self.modes else {
            return Ok(recorded);
        };
        let phases: Vec<_> = scaled.phases().collect();
        let shape = scaled.of(body);
        Ok(Mat::from_fn(phases.len(), width, |row, column| {
            let (mode, k) = phases[row];
            let moved = shape.map_or(0.0, |shape| scaled.value(shape, mode, k, OF_FRAME + column));
            recorded[(0, column)] + moved
        }))
    }
}

impl ScaledModes {
    fn of(&self, body: &str) -> Option<&ModeShapes> {
        let mut all = self.modes.shapes.iter();
        all.find(|shape| shape.body == body)
    }

    /// Mode and phase of each time.
    fn phases(&self) -> impl Iterator<Item = (usize, usize)> + use<> {
        let count = self.modes.frequency.len();
        (0..count).flat_map(|mode| (0..=PHASES).map(move |k| (mode, k)))
    }

    fn value(&self, shape: &ModeShapes, mode: usize, phase: usize, column: usize) -> f64 {
        let width = shape.columns.len();
        if column >= width {
            return 0.0;
        }
        let part = |part: usize| shape.values.get((2 * mode + part) * width + column);
        let part = |index: usize| part(index).copied().unwrap_or_default();
        let (sin, cos) = (TAU * share(phase)).sin_cos();
        self.scale * (part(0) * cos + part(1) * sin)
    }
}

fn share(phase: usize) -> f64 {
    phase as f64 / PHASES as f64
}

/// A frame after a small motion in its own axes: translation, then rotation.
fn moved(rest: &[f64; 7], motion: [f64; OF_FRAME]) -> [f64; 7] {
    let [x, y, z, w, i, j, k] = *rest;
    let turn = UnitQuaternion::from_quaternion(Quaternion::new(w, i, j, k));
    let [tx, ty, tz, rx, ry, rz] = motion;
    let origin = Vector3::new(x, y, z) + turn * Vector3::new(tx, ty, tz);
    let turn = turn * UnitQuaternion::from_scaled_axis(Vector3::new(rx, ry, rz));
    [origin.x, origin.y, origin.z, turn.w, turn.i, turn.j, turn.k]
}

/// Origin and quaternion of a body's frame at some rows.
fn recorded_frames(run: &Run, body: &str, rows: &[usize]) -> Result<Vec<[f64; 7]>, Error> {
    let Some(history) = run.history_at(&format!("motion/{body}/frame"), rows)? else {
        return Err(run.refused(&format!("has no motion of body {body:?}")));
    };
    let planar = |row: usize| {
        let half = 0.5 * history[(row, 2)];
        let (x, y) = (history[(row, 0)], history[(row, 1)]);
        [x, y, 0.0, half.cos(), 0.0, 0.0, half.sin()]
    };
    Ok((0..history.nrows())
        .map(|row| match history.ncols() {
            3 => planar(row),
            _ => std::array::from_fn(|column| history[(row, column)]),
        })
        .collect())
}
