//! How fast the forces and motions are that a scene prescribes, where they alone decide how fast bodies deflect.

use std::f64::consts::TAU;

use nalgebra::Complex;

use super::course::{Course, is_zero};
use super::transmission::{acts, acts_along};
use crate::Error;
use dcb_formats::function::Function;
use dcb_formats::scene::{
    Actuator, Attachment, Bushing, Characteristic, Joint, Load, Scene, Spring,
};

/// Oscillation that doesn't count, by the deflection under the largest force as if it didn't change.
pub(super) const NEGLIGIBLE: f64 = 0.01;
/// Of the highest frequency that samples have, how much of it a spectrum may reach to be known.
const SETTLED: f64 = 0.5;
/// A change of place between both sides of an instant, by the largest rate times the length of the run, that no rate leads to.
const JUMP: f64 = 1e-6;

/// Up to which frequency something excites deflections.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Excitation {
    /// Cycles per time unit, and what is fastest.
    UpTo(f64, String),
    /// All frequencies, for these reasons.
    Unlimited(Vec<String>),
}

impl Excitation {
    /// Of a transient of a checked scene.
    pub(super) fn of(scene: &Scene, end: f64) -> Result<Self, Error> {
        let mut broad = far_motion(scene);
        broad.extend(release(scene));
        let mut fastest = (0.0, "nothing acts on it".to_owned());
        let mut add = |by: String, content: Content| match content {
            Content::UpTo(frequency) if frequency > fastest.0 => fastest = (frequency, by),
            Content::UpTo(_) => {}
            Content::Unlimited(why) => broad.push(format!("{by} {why}")),
        };
        for (name, drive) in &scene.drives {
            let course = Course::of_drive(drive, end)
                .map_err(|error| error.within(&format!("drives.{name}.{}", drive.kind())))?;
            add(
                format!("drives.{name}"),
                Content::of_motion(course.as_ref()),
            );
        }
        for (name, load) in &scene.loads {
            let functions = match load {
                Load::Force(load) | Load::Torque(load) => load.components.iter().collect(),
                Load::PartLoad(load) => vec![&load.factor],
            };
            for function in functions.into_iter().filter(|function| !is_zero(function)) {
                let course = Course::of(function, end)
                    .map_err(|error| error.within(&format!("loads.{name}")))?;
                add(format!("loads.{name}"), Content::of_force(course.as_ref()));
            }
        }
        for (name, actuator) in &scene.actuators {
            let by = format!("actuators.{name}");
            let function = actuator.function();
            let course = function.map(|function| Course::of(function, end));
            let course = course
                .transpose()
                .map_err(|error| error.within(&format!("actuators.{name}")))?
                .flatten();
            add(by, Content::of_actuator(actuator, course.as_ref()));
        }
        Ok(match broad.is_empty() {
            true => Self::UpTo(fastest.0, fastest.1),
            false => Self::Unlimited(broad),
        })
    }
}

/// Why bodies may move far, or by forces that aren't proportional to their motion.
fn far_motion(scene: &Scene) -> Vec<String> {
    let mut reasons = Vec::new();
    for (name, joint) in &scene.joints {
        match joint {
            Joint::Fixed(_) | Joint::Prismatic(_) => {}
            other => reasons.push(format!(
                "joints.{name} is {}: bodies that turn have harmonics of every order",
                other.kind()
            )),
        }
    }
    for (name, spring) in &scene.springs {
        match spring {
            Spring::Bushing(bushing) if is_linear(bushing) => {}
            Spring::Bushing(_) => reasons.push(format!("springs.{name} is not linear")),
            Spring::Spring(_) => {
                reasons.push(format!("springs.{name} pulls along a line that turns"));
            }
            // Its joint has been named.
            Spring::TorsionSpring(_) => {}
        }
    }
    let unheld = unheld(scene);
    reasons.extend(unheld.map(|body| format!("bodies.{body} is not held in every direction")));
    reasons
}

/// Releases at time zero.
fn release(scene: &Scene) -> Vec<String> {
    let mut reasons = Vec::new();
    if scene.gravity_in_space().norm() > 0.0 {
        reasons.push("gravity acts from the start on bodies placed undeformed".to_owned());
    }
    for (name, body) in &scene.bodies {
        let placement = body.placement();
        if placement.velocity.norm() + placement.angular_velocity.norm() > 0.0 {
            reasons.push(format!("bodies.{name} starts with a velocity"));
        }
    }
    reasons
}

fn is_linear(bushing: &Bushing) -> bool {
    let lists = [
        &bushing.translation,
        &bushing.rotation,
        &bushing.translation_damping,
        &bushing.rotation_damping,
    ];
    let mut all = lists.into_iter().flatten().flatten();
    all.all(|one| matches!(one, Characteristic::Linear(_)))
}

/// Bodies that neither joints nor bushings of every direction connect to the ground.
fn unheld(scene: &Scene) -> impl Iterator<Item = &str> {
    let directions = scene.dimension.coordinate_count();
    let turns = if directions == 2 { 1 } else { 3 };
    let mut links: Vec<[&str; 2]> = Vec::new();
    for joint in scene.joints.values() {
        links.extend(joint.attachments());
    }
    for spring in scene.springs.values() {
        if let Spring::Bushing(bushing) = spring {
            let everywhere = (0..directions).all(|axis| acts_along(&bushing.translation, axis));
            let every_turn = bushing.rotation.as_ref();
            let every_turn = every_turn.is_some_and(|list| list.iter().take(turns).all(acts));
            if everywhere && every_turn {
                links.push([&bushing.a, &bushing.b]);
            }
        }
    }
    let mut held: Vec<&str> = Vec::new();
    loop {
        let mut next = None;
        for [a, b] in &links {
            let [a, b] = [a, b].map(|place| Attachment::parse(place).and_then(|on| on.body()));
            for (from, to) in [(a, b), (b, a)] {
                if from.is_none_or(|from| held.contains(&from)) {
                    next = next.or(to.filter(|to| !held.contains(to)));
                }
            }
        }
        match next {
            Some(body) => held.push(body),
            None => break,
        }
    }
    let names = scene.bodies.keys().map(String::as_str);
    names.filter(move |name| !held.contains(name))
}

/// How fast one function of time is.
#[derive(Clone, Debug, PartialEq)]
enum Content {
    /// Cycles per time unit.
    UpTo(f64),
    /// Why there is no end.
    Unlimited(&'static str),
}

impl Content {
    /// Of a force; `None` is an input.
    fn of_force(course: Option<&Course>) -> Self {
        let Some(course) = course else {
            return Self::Unlimited("is set from outside");
        };
        let start = course.at(0.0);
        let mut jumps = [start.value, start.rate, start.second_rate].map(f64::abs);
        for time in course.special.iter().filter(|time| **time > 0.0) {
            let [before, after] = course.both_sides(*time);
            jumps[0] = jumps[0].max((after.value - before.value).abs());
            jumps[1] = jumps[1].max((after.rate - before.rate).abs());
            jumps[2] = jumps[2].max((after.second_rate - before.second_rate).abs());
        }
        Self::of_course(course, jumps, |value| value.value)
    }

    /// Of an actuator; `None` is an effort or a target that is set from outside or by a controller.
    fn of_actuator(actuator: &Actuator, course: Option<&Course>) -> Self {
        match actuator {
            Actuator::Torque(_) | Actuator::Force(_) => Self::of_force(course),
            Actuator::Servo(servo) if servo.sample.is_some() => Self::Unlimited("is sampled"),
            Actuator::Servo(servo) if servo.limit.is_some() => Self::Unlimited("has a limit"),
            Actuator::Servo(servo) => {
                let is_constant = matches!(servo.target, Function::Constant(_));
                match servo.derivative > 0.0 && !is_constant {
                    true => Self::Unlimited("follows the rate of its target"),
                    false => Self::of_force(course),
                }
            }
            Actuator::Friction(_) => Self::Unlimited("is friction, which bends at rest"),
            Actuator::EndStop(_) => Self::Unlimited("is met by an impact"),
        }
    }

    /// Of a driven translation, whose acceleration is what bodies feel.
    fn of_motion(course: Option<&Course>) -> Self {
        let Some(course) = course else {
            return Self::Unlimited("is set from outside");
        };
        let start = course.at(0.0);
        let largest = course.largest(|value| value.rate).unwrap_or(f64::INFINITY);
        if start.rate.abs() > NEGLIGIBLE * largest {
            return Self::Unlimited("starts with a velocity: an impulse");
        }
        let mut jump = start.second_rate.abs();
        for time in course.special.iter().filter(|time| **time > 0.0) {
            let [before, after] = course.both_sides(*time);
            // Beside a jump the way is larger than any rate would lead to.
            if (after.value - before.value).abs() > JUMP * largest * course.end {
                return Self::Unlimited("changes its place at once: an impulse");
            }
            if (after.rate - before.rate).abs() > NEGLIGIBLE * largest {
                return Self::Unlimited("changes its velocity at once: an impulse");
            }
            jump = jump.max((after.second_rate - before.second_rate).abs());
        }
        let beside = course.end / course.samples as f64;
        let slope = (course.at(beside).second_rate - start.second_rate) / beside;
        Self::of_course(course, [jump, slope.abs(), 0.0], |value| value.second_rate)
    }

    /// A jump J_k of the k-th derivative of a force f lets a motion of angular frequency ω, at rest before, oscillate by
    /// `J_k / ω^k` of what the force f deflects it.
    fn of_course(
        course: &Course,
        jumps: [f64; 3],
        of: impl Fn(&dcb_formats::function::FunctionValue) -> f64,
    ) -> Self {
        let Some(largest) = course.largest(&of) else {
            return Self::Unlimited("is not finite everywhere");
        };
        if largest == 0.0 {
            return Self::UpTo(0.0);
        }
        let allowed = NEGLIGIBLE * largest;
        if jumps[0] > allowed {
            return Self::Unlimited("acts at once: a step");
        }
        let by_slope = jumps[1] / allowed / TAU;
        let by_curvature = (jumps[2] / allowed).sqrt() / TAU;
        let own = match course.frequency {
            Some(frequency) => Some(frequency),
            None => spectrum_end(&course.sampled(&of), course.end),
        };
        match own {
            Some(own) => Self::UpTo(own.max(by_slope).max(by_curvature)),
            None => Self::Unlimited("is too rough, or too fast for its samples"),
        }
    }
}

/// The frequency above which the spectrum stays below [`NEGLIGIBLE`] of its largest, cycles per time unit; `None` where that isn't far below
/// what the samples can show.
fn spectrum_end(samples: &[f64], end: f64) -> Option<f64> {
    let count = samples.len();
    // Hann's window: where the run starts and ends is no part of the spectrum.
    let window = |index: usize| 0.5 - 0.5 * (TAU * index as f64 / count as f64).cos();
    let windowed = samples.iter().enumerate();
    let windowed: Vec<Complex<f64>> = windowed
        .map(|(index, value)| Complex::new(value * window(index), 0.0))
        .collect();
    let spectrum = fourier(&windowed);
    let half = &spectrum[..count / 2];
    let largest = half.iter().map(|entry| entry.norm()).fold(0.0, f64::max);
    let last = half
        .iter()
        .rposition(|entry| entry.norm() > NEGLIGIBLE * largest)?;
    let is_settled = (last as f64) < SETTLED * half.len() as f64;
    is_settled.then(|| (last + 1) as f64 / end)
}

/// Discrete Fourier transform of 2^m values.
fn fourier(values: &[Complex<f64>]) -> Vec<Complex<f64>> {
    let count = values.len();
    if count < 2 {
        return values.to_vec();
    }
    let every_second = |first: usize| -> Vec<Complex<f64>> {
        fourier(
            &values
                .iter()
                .skip(first)
                .step_by(2)
                .copied()
                .collect::<Vec<_>>(),
        )
    };
    let (even, odd) = (every_second(0), every_second(1));
    let mut all = vec![Complex::new(0.0, 0.0); count];
    for index in 0..count / 2 {
        let turned = Complex::from_polar(1.0, -TAU * index as f64 / count as f64) * odd[index];
        all[index] = even[index] + turned;
        all[index + count / 2] = even[index] - turned;
    }
    all
}

#[cfg(test)]
#[allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]
mod tests {
    use super::*;

    #[test]
    fn transform_of_a_pulse_and_of_a_sine() {
        let count = 64;
        let shifted = 5;
        let mut pulse = vec![Complex::new(0.0, 0.0); count];
        pulse[shifted] = Complex::new(1.0, 0.0);
        for (k, entry) in fourier(&pulse).iter().enumerate() {
            let expected = Complex::from_polar(1.0, -TAU * (shifted * k) as f64 / count as f64);
            assert!((entry - expected).norm() < 1e-13);
        }
    }

    #[test]
    fn spectrum_of_a_gaussian_ends_where_its_own_does() {
        // exp(-(t/τ)²) has the spectrum exp(-(ω τ/2)²), which is 1 % at ω = 2 √ln 100 / τ.
        let (end, width) = (10.0, 0.2);
        let samples: Vec<f64> = (0..4096)
            .map(|index| end * f64::from(index) / 4096.0 - 5.0)
            .map(|time| (-(time / width).powi(2)).exp())
            .collect();
        let expected = 2.0 * 100.0_f64.ln().sqrt() / width / TAU;
        let found = spectrum_end(&samples, end).unwrap();
        assert!((found / expected - 1.0).abs() < 0.05, "{found} {expected}");
    }

    #[test]
    fn a_rough_course_has_no_end() {
        let noise = |index: u32| f64::from(index.wrapping_mul(2_654_435_761) >> 16) - 32768.0;
        let samples: Vec<f64> = (0..1024).map(noise).collect();
        assert_eq!(spectrum_end(&samples, 1.0), None);
    }
}
