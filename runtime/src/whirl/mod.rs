//! Whirl of a rotor over its speed: the Campbell diagram, and critical speeds.
//!
//! All bodies spin with one angular velocity Ω about a fixed axis, on supports that are alike in all directions. Axes that turn along see everything stand still, and
//! the modes there, [`Eigenmodes`] with gyroscopic and centrifugal terms, are those of constant equations. A point that moves as Re(U exp(sₜ t)) across the axis in
//! turning axes is a sum of two circular motions, exp(iωt) and exp(−iωt), of the sizes |U₁ ± i U₂|/2; in fixed axes they have the angular frequencies
//!
//! ```text
//! Ω + ω   and   Ω − ω        positive: forward whirl, with the spin; negative: backward
//! ```
//! With equal supports each mode is one of the two. A critical speed of the order k is where a whirl has the frequency kΩ: the number of modes above kΩ changes there,
//! bisection finds it, and interpolation between speeds beside it.

mod circular;

use dcb_formats::scene::Scene;
use faer::Mat;
use faer::linalg::solvers::SolveLstsq;
use nalgebra::{UnitQuaternion, Vector3};

use crate::analysis::eigenmodes::Eigenmodes;
use crate::analysis::independent::IndependentMotion;
use crate::error::Error;
use crate::initial::Starter;
use crate::model::Model;
use crate::run::{Observer, check_gaps, start_notes};
use crate::system::state::rates;
use crate::system::{State, System};

pub use circular::Whirl;
use circular::{Axis, whirl};

/// Velocities that differ by less, as a part of those of the rotor, are the same.
const SAME: f64 = 1e-9;
/// Matrices at another angle of the rotor that differ by more tell of supports that aren't alike in all directions.
const ALIKE: f64 = 1e-6;
/// Critical speeds are searched to this part of the highest speed by counting, which sees no whirl that turning axes see stand still.
const SEARCHED: f64 = 1e-6;
/// From speeds so far to both sides they are interpolated, as a part of themselves.
const BESIDE: f64 = 1e-3;
/// Sizes of frequencies that differ by less, as a part of themselves, are listed with the backward one first.
const AS_FAST: f64 = 1e-9;
/// An angle at which nothing is as at the start.
const ANOTHER_ANGLE: f64 = 0.6180339887;

/// What is asked of a rotor.
#[derive(Clone, Debug, PartialEq)]
pub struct CampbellRequest {
    /// Speeds in rad/time, rising from above zero.
    pub speeds: Vec<f64>,
    /// Excitations per revolution that critical speeds are wanted of; 1 is an unbalance, negative ones go against the spin.
    pub orders: Vec<f64>,
    /// The body whose angular velocity in the scene is the direction of the spin; the fastest where `None`.
    pub rotor: Option<String>,
}

/// A mode at one speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WhirlMode {
    /// Cycles per time in fixed axes: negative against the spin, zero or positive for motions along and about the axis.
    pub frequency: f64,
    /// Across the axis, or along and about it.
    pub whirl: Whirl,
    /// Damping as a part of the critical one, of the motion in turning axes; negative where it grows.
    pub damping: f64,
}

/// Modes at one speed, by rising size of the frequency.
#[derive(Clone, Debug, PartialEq)]
pub struct SpeedPoint {
    /// rad/time.
    pub speed: f64,
    /// Modes that oscillate.
    pub modes: Vec<WhirlMode>,
}

/// A speed at which a whirl has a multiple of its frequency.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CriticalSpeed {
    /// rad/time.
    pub speed: f64,
    /// Excitations per revolution.
    pub order: f64,
    /// How many whirls meet there.
    pub count: usize,
}

/// The Campbell diagram of a rotor.
#[derive(Clone, Debug, PartialEq)]
pub struct Campbell {
    /// Name of the rotor.
    pub rotor: String,
    /// At each speed asked for.
    pub points: Vec<SpeedPoint>,
    /// By order, then by speed.
    pub criticals: Vec<CriticalSpeed>,
}

/// The whirl of a scene's rotor over its speed; `None` if the observer stopped it. Gravity is left out: about a rotor it isn't steady.
///
/// # Errors
/// Those of [`Model::load`] and of a start; [`Error::Description`] for a scene that is no rotor on supports alike in all directions.
pub fn campbell(
    scene: &Scene,
    request: &CampbellRequest,
    observer: &mut dyn Observer,
) -> Result<Option<Campbell>, Error> {
    let rotor = Rotor::of(scene, request, observer)?;
    rotor.refuse_unlike_supports(request.speeds.last().copied().unwrap_or(rotor.speed))?;
    let mut points = Vec::with_capacity(request.speeds.len());
    let last = request.speeds.last().copied().unwrap_or(0.0);
    for speed in &request.speeds {
        if observer.is_stopped() {
            return Ok(None);
        }
        points.push(SpeedPoint {
            speed: *speed,
            modes: rotor.modes(*speed, 0.0)?,
        });
        observer.progress(*speed, last);
    }
    let mut criticals = Vec::new();
    for order in &request.orders {
        for pair in points.windows(2) {
            let [a, b] = [&pair[0], &pair[1]]
                .map(|point| (point.speed, above(&point.modes, point.speed, *order)));
            rotor.search(*order, a, b, SEARCHED * last, &mut criticals)?;
        }
    }
    Ok(Some(Campbell {
        rotor: rotor.name.clone(),
        points,
        criticals,
    }))
}

/// Whether two bases, by columns, have the same combinations.
fn spans_same(a: &Mat<f64>, b: &Mat<f64>) -> bool {
    if a.ncols() != b.ncols() {
        return false;
    }
    let factor = b.qr();
    let left = a - b * factor.solve_lstsq(a);
    left.norm_l2() <= ALIKE * a.norm_l2()
}

/// How many whirls are faster than so many cycles per revolution, in its direction.
fn above(modes: &[WhirlMode], speed: f64, order: f64) -> usize {
    let limit = order * speed / std::f64::consts::TAU;
    let lateral = modes.iter().filter(|mode| mode.whirl == Whirl::Across);
    lateral
        .filter(|mode| match order >= 0.0 {
            true => mode.frequency > limit,
            false => mode.frequency < limit,
        })
        .count()
}

/// A mechanism that spins, and how fast it does as it is drawn.
struct Rotor {
    name: String,
    system: System,
    drawn: State,
    speed: f64,
    axis: Axis,
}

impl Rotor {
    fn of(
        scene: &Scene,
        request: &CampbellRequest,
        observer: &mut dyn Observer,
    ) -> Result<Self, Error> {
        let mut quiet = scene.clone();
        quiet.gravity = None;
        let Model {
            system,
            mut drawn,
            held,
            notes,
            ..
        } = Model::load(&quiet)?;
        for note in &notes {
            observer.note(0.0, note);
        }
        let mut starter = Starter::of(&system)?.holding(&held);
        let report = starter.start(&mut drawn, scene.redundant_constraints)?;
        check_gaps(&report, scene)?;
        for note in start_notes(&report, scene) {
            observer.note(0.0, &note);
        }
        let spin_of = |index: usize| {
            let body = &system.bodies[index];
            let own = rates(&drawn.velocities[body.velocities.clone()]).angular;
            drawn.pose(index).axes * own
        };
        let fastest = || {
            let speeds = (0..system.bodies.len()).map(|index| (index, spin_of(index).norm()));
            speeds
                .max_by(|a, b| a.1.total_cmp(&b.1))
                .map(|(index, _)| index)
        };
        let index = match &request.rotor {
            Some(name) => {
                let place = system.bodies.iter().position(|body| body.name == *name);
                Some(place.ok_or_else(|| {
                    Error::described("bodies", format!("there is no body {name:?}"))
                })?)
            }
            None => fastest(),
        };
        let Some(index) = index else {
            return Err(Error::described(
                "bodies",
                "the scene has no body that could spin",
            ));
        };
        let (name, spin) = (system.bodies[index].name.clone(), spin_of(index));
        let speed = spin.norm();
        if speed == 0.0 {
            return Err(Error::described(
                format!("bodies.{name}.angular_velocity"),
                "is zero; give the rotor any angular velocity, whose direction is that of the spin: speeds come from the command",
            ));
        }
        let axis = Axis {
            point: drawn.origins[index],
            direction: spin / speed,
        };
        let rotor = Self {
            name,
            system,
            drawn,
            speed,
            axis,
        };
        rotor.refuse_other_motions(spin)?;
        Ok(rotor)
    }

    /// Everything has to spin with the rotor, or axes that turn along don't see it stand still.
    fn refuse_other_motions(&self, spin: Vector3<f64>) -> Result<(), Error> {
        for (index, body) in self.system.bodies.iter().enumerate() {
            let own = rates(&self.drawn.velocities[body.velocities.clone()]);
            let turning = self.drawn.pose(index).axes * own.angular;
            let at = |key: &str| format!("bodies.{}.{key}", body.name);
            if (turning - spin).norm() > SAME * self.speed || body.flexible.is_point_mass() {
                return Err(Error::described(
                    at("angular_velocity"),
                    format!(
                        "isn't that of {:?}: all bodies have to spin as one about its axis; put what stands still on the ground, as springs, bushings and joints do",
                        self.name
                    ),
                ));
            }
            let carried = spin.cross(&(self.drawn.origins[index] - self.axis.point));
            if (own.linear - carried).norm() > SAME * self.speed * body.length {
                return Err(Error::described(
                    at("velocity"),
                    format!(
                        "isn't that of a turn about the axis through the centre of mass of {:?}, which doesn't move",
                        self.name
                    ),
                ));
            }
        }
        for connection in &self.system.connections {
            if connection.kind == crate::system::ConnectionKind::Drive {
                return Err(Error::described(
                    format!("drives.{}", connection.name),
                    "holds the rotor at its own speed; leave drives out, the speeds come from the command",
                ));
            }
        }
        Ok(())
    }

    /// The state at a speed, the rotor turned on by an angle.
    fn state(&self, speed: f64, angle: f64) -> Result<State, Error> {
        let factor = speed / self.speed;
        let mut state = self.drawn.clone();
        for rate in [&mut state.velocities, &mut state.residual_rates] {
            rate.iter_mut().for_each(|entry| *entry *= factor);
        }
        let second = [&mut state.accelerations, &mut state.residual_accelerations];
        for rate in second {
            rate.iter_mut().for_each(|entry| *entry *= factor * factor);
        }
        if angle != 0.0 {
            let direction = nalgebra::Unit::new_normalize(self.axis.direction);
            let turn = UnitQuaternion::from_axis_angle(&direction, angle);
            for (index, body) in self.system.bodies.iter().enumerate() {
                let arm = state.origins[index] - self.axis.point;
                state.origins[index] = self.axis.point + turn * arm;
                state.orientations[index] = turn * state.orientations[index];
                for of in [&mut state.velocities, &mut state.accelerations] {
                    let first = body.velocities.start;
                    let linear = turn * Vector3::new(of[first], of[first + 1], of[first + 2]);
                    of[first..first + 3].copy_from_slice(linear.as_slice());
                }
            }
        }
        Ok(state)
    }

    fn modes(&self, speed: f64, angle: f64) -> Result<Vec<WhirlMode>, Error> {
        let state = self.state(speed, angle)?;
        let found = Eigenmodes::at(&self.system, &state)?;
        let mut modes: Vec<WhirlMode> = (found.modes.iter())
            .filter(|mode| mode.angular_frequency > 0.0)
            .map(|mode| {
                let (whirl, frequency) = whirl(&self.system, &state, &self.axis, speed, mode);
                WhirlMode {
                    frequency: frequency / std::f64::consts::TAU,
                    whirl,
                    damping: mode.damping_ratio(),
                }
            })
            .collect();
        modes.sort_by(|a, b| a.frequency.abs().total_cmp(&b.frequency.abs()));
        for at in 1..modes.len() {
            let [earlier, later] = [at - 1, at].map(|at| modes[at].frequency);
            if earlier > 0.0 && (earlier + later).abs() <= AS_FAST * earlier {
                modes.swap(at - 1, at);
            }
        }
        Ok(modes)
    }

    /// At another angle supports that aren't alike have other matrices over motions in axes that turn along, or hold other motions.
    fn refuse_unlike_supports(&self, speed: f64) -> Result<(), Error> {
        let [here, there] = [0.0, ANOTHER_ANGLE].map(|angle| {
            let state = self.state(speed, angle)?;
            IndependentMotion::at(&self.system, &state, &[])
        });
        let (here, there) = (here?, there?);
        let of = |motion: &IndependentMotion| {
            let linear = &motion.linearization;
            [&linear.mass, &linear.damping, &linear.stiffness].map(Mat::clone)
        };
        let apart = |(a, b): (&Mat<f64>, &Mat<f64>)| (a - b).norm_l2() > ALIKE * a.norm_l2();
        let differ = of(&here).iter().zip(&of(&there)).any(apart);
        if differ || !spans_same(&here.places, &there.places) {
            return Err(Error::described(
                "springs",
                format!(
                    "aren't alike in all directions across the axis of {:?}, or joints aren't: its equations change with its angle, so that there are no steady modes; give both directions the same stiffness and damping",
                    self.name
                ),
            ));
        }
        Ok(())
    }

    /// Critical speeds between two speeds, with the number of whirls above the line at each.
    fn search(
        &self,
        order: f64,
        a: (f64, usize),
        b: (f64, usize),
        width: f64,
        found: &mut Vec<CriticalSpeed>,
    ) -> Result<(), Error> {
        if a.1 == b.1 {
            return Ok(());
        }
        let speed = 0.5 * (a.0 + b.0);
        if b.0 - a.0 <= width {
            return self.interpolate(order, speed, a.1.abs_diff(b.1), found);
        }
        let middle = (speed, above(&self.modes(speed, 0.0)?, speed, order));
        self.search(order, a, middle, width, found)?;
        self.search(order, middle, b, width, found)
    }

    /// Where so many whirls cross the line near a speed.
    fn interpolate(
        &self,
        order: f64,
        near: f64,
        count: usize,
        found: &mut Vec<CriticalSpeed>,
    ) -> Result<(), Error> {
        let sides = [1.0 - BESIDE, 1.0 + BESIDE].map(|part| {
            let speed = part * near;
            let modes = self.modes(speed, 0.0)?;
            let across = modes.iter().filter(|mode| mode.whirl == Whirl::Across);
            let mut gaps: Vec<f64> = across
                .map(|mode| std::f64::consts::TAU * mode.frequency - order * speed)
                .collect();
            gaps.sort_by(|a, b| a.abs().total_cmp(&b.abs()));
            gaps.truncate(count);
            Ok::<_, Error>((speed, gaps))
        });
        let [a, b] = sides;
        let ((low, below), (high, above)) = (a?, b?);
        let mut speeds: Vec<f64> = (below.iter().zip(&above))
            .map(|(a, b)| match a * b < 0.0 {
                true => low + (high - low) * a / (a - b),
                false => near,
            })
            .collect();
        speeds.sort_by(f64::total_cmp);
        for speed in speeds {
            match found.last_mut() {
                Some(last) if last.order == order && (last.speed - speed).abs() < SAME * speed => {
                    last.count += 1;
                }
                _ => found.push(CriticalSpeed {
                    speed,
                    order,
                    count: 1,
                }),
            }
        }
        Ok(())
    }
}
