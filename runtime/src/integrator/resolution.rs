//! Whether the steps resolve the motion.
//!
//! A motion of angular frequency ω changes its accelerations by ω times as much as its velocities, and by ω² times as much as its place.
//! Over a body's last steps,
//!
//! ```text
//! place        (h ω)² = h² Σ |Δq''|² / Σ |Δq'|²            q' = (V, length ω)
//! deflection   (h ω)² = h² Σ |Δy''ₖ Δyₖ| / Σ Δyₖ²          over the coordinates k
//! ```
//! so that what moves most decides: stiff coordinates that follow their forces count with the frequency of the forces. A period of the motion
//! comes out wrong by a part of about (h ω)²/12, which no balance of energies shows. Motions are told that have too few steps in a period,
//! are no small part of the body's motion, and last longer than numerical damping takes to remove what it removes.

use std::f64::consts::TAU;
use std::ops::Range;

use crate::system::{Body, State, System};
use dcb_formats::scene::Scheme;

/// Steps that are looked at together.
const WINDOW: usize = 8;
/// Fewer steps in a period than these are told: the period is wrong by 1 % or more, the phase by half a radian after ten periods.
const FEWEST: f64 = 20.0;
/// Steps in a period to advise.
const ADVISED: f64 = 50.0;
/// Smaller changes in a step, by the largest size in the run, are no part of the motion that anybody looks at.
const SIGNIFICANT: f64 = 0.05;
/// A ringing is over when it has fallen to this part.
const RUNG_OUT: f64 = 0.01;
/// Most steps that a ringing is waited for.
const LONGEST_RINGING: f64 = 100.0;
/// A run of fewer steps is too short to tell what lasts.
const SHORT_RUN: usize = 200;
/// With fewer steps in a period than these, and velocities that change by this part of their largest size in a step, nothing of the motion
/// is followed.
const HOPELESS: f64 = 5.0;
const OVERTURNED: f64 = 0.5;
/// A body slower than this part of the fastest is not what the mechanism does.
const SLOW: f64 = 0.1;
/// Motions in a step below this fraction of the length are rounding.
const AT_REST: f64 = 1e-11;
/// A motion of less than this part of the body's length is none that anybody looks at.
const NEGLIGIBLE: f64 = 1e-8;
/// A run of fewer periods of a motion has only begun it: that its steps are too long for it can't be told.
const SEEN_PERIODS: f64 = 3.0;

/// Moving part of a body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Part {
    /// Its frame.
    Place,
    /// Its coordinates.
    Deflection,
}

/// A motion that the steps are too long for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unresolved {
    /// Which body, in the order of the system.
    pub body: usize,
    /// Moving part of it.
    pub part: Part,
    /// Steps in a period of the motion, as far as the last steps tell.
    pub steps_per_period: f64,
    /// The size of the steps.
    pub step: f64,
}

impl Unresolved {
    /// A step that would follow the motion.
    pub fn advised_step(&self) -> f64 {
        self.step * self.steps_per_period / ADVISED
    }
}

/// Watches the steps of a run.
#[derive(Clone, Debug)]
pub struct Resolution {
    /// Place and deflection of each body.
    bodies: Vec<[Recent; 2]>,
    lasting: Vec<Lasting>,
    fastest: f64,
    steps: usize,
}

/// A motion that was coarse for longer than it takes to ring out.
#[derive(Clone, Copy, Debug)]
struct Lasting {
    /// As it was when that was first seen.
    found: Unresolved,
    /// Its largest mean change in a step.
    change: f64,
}

/// The last steps of one motion.
#[derive(Clone, Copy, Debug, Default)]
struct Recent {
    /// |Δ|² of what moves, and (h ω)² times that, of the last steps.
    steps: [Change; WINDOW],
    next: usize,
    /// Largest size in the run.
    largest: f64,
    /// Steps in a row with too few in a period.
    coarse: usize,
    /// Steps in a row that follow nothing.
    hopeless: usize,
    /// The motion as it is, where it is told.
    found: Option<Unresolved>,
    /// Its place among the lasting ones.
    lasting: Option<usize>,
}

/// Of one step, or a sum of several.
#[derive(Clone, Copy, Debug, Default)]
struct Change {
    square: f64,
    curvature: f64,
}

impl Change {
    fn steps_per_period(self) -> f64 {
        TAU / (self.curvature / self.square).sqrt()
    }
}

impl Resolution {
    /// For the bodies of a system.
    pub fn of(system: &System) -> Self {
        Self {
            bodies: vec![[Recent::default(); 2]; system.bodies.len()],
            lasting: Vec::with_capacity(2 * system.bodies.len()),
            fastest: 0.0,
            steps: 0,
        }
    }

    /// Motions that the steps have been too long for, each once, in the order of time: those that are no small part of what the body has
    /// done up to now, so that what is asked for at the end of a run is judged over all of it.
    pub fn told(&self) -> Vec<Unresolved> {
        let mattered = self.lasting.iter().filter(|lasting| {
            let Unresolved { body, part, .. } = lasting.found;
            lasting.change > SIGNIFICANT * self.bodies[body][part as usize].largest
        });
        let mattered = mattered.map(|lasting| lasting.found);
        mattered.chain(self.at_end()).collect()
    }

    /// The motions that the steps were too long for at the end of a run too short to tell whether that lasts, of which it has seen some periods.
    fn at_end(&self) -> Vec<Unresolved> {
        if self.steps >= SHORT_RUN {
            return Vec::new();
        }
        let untold = self
            .bodies
            .iter()
            .flatten()
            .filter(|recent| recent.lasting.is_none());
        let found = untold.filter_map(|recent| recent.found);
        let steps = self.steps as f64;
        found
            .filter(|found| {
                self.steps >= 2 * WINDOW && steps >= SEEN_PERIODS * found.steps_per_period
            })
            .collect()
    }

    /// Forgets the last steps, after which the motion goes on from elsewhere.
    pub fn forget(&mut self) {
        self.bodies.fill([Recent::default(); 2]);
        self.fastest = 0.0;
    }

    /// Looks at a step; a motion of which it follows nothing, if such steps have lasted.
    pub(crate) fn observe(
        &mut self,
        system: &System,
        scheme: &Scheme,
        start: &State,
        end: &State,
        step: f64,
    ) -> Option<Unresolved> {
        let damping = RUNG_OUT.ln() / scheme.spectral_radius().ln();
        let patience = 2 * WINDOW + damping.abs().min(LONGEST_RINGING) as usize;
        let mut lost = None;
        self.steps += 1;
        for (index, body) in system.bodies.iter().enumerate() {
            let (change, size) = place_change(body, start, end, step);
            self.fastest = self.fastest.max(size);
            let place = &mut self.bodies[index][0];
            place.look_at(change, size);
            let is_slow = place.largest < SLOW * self.fastest;
            let travels = place.largest * step > AT_REST * body.length;
            if place.is_hopeless() && !is_slow && travels {
                place.hopeless += 1;
                if place.hopeless > patience {
                    lost = Some(Unresolved {
                        body: index,
                        part: Part::Place,
                        steps_per_period: place.total().steps_per_period(),
                        step,
                    });
                }
            } else {
                place.hopeless = 0;
            }
            let (change, size) = deflection_change(body, start, end, step);
            let deflection = &mut self.bodies[index][1];
            deflection.look_at(change, size);
            // Coordinates are displacements by the root of the mass.
            let mean = deflection.largest / body.flexible.inertia.mass().sqrt();
            let bends = mean > NEGLIGIBLE * body.length;
            let swings = self.bodies[index][0].amplitude(step) > NEGLIGIBLE * body.length;
            for ((part, moves), recent) in [(Part::Place, swings), (Part::Deflection, bends)]
                .into_iter()
                .zip(&mut self.bodies[index])
            {
                let coarse = recent.coarse_steps().filter(|_| moves);
                recent.found = coarse.map(|steps_per_period| Unresolved {
                    body: index,
                    part,
                    steps_per_period,
                    step,
                });
                recent.coarse = match recent.found {
                    Some(_) => recent.coarse + 1,
                    None => 0,
                };
                if let Some(found) = recent.found
                    && recent.coarse > patience
                {
                    let change = recent.change();
                    let place = *recent.lasting.get_or_insert_with(|| {
                        self.lasting.push(Lasting { found, change });
                        self.lasting.len() - 1
                    });
                    let lasting = &mut self.lasting[place];
                    lasting.change = lasting.change.max(change);
                }
            }
        }
        lost
    }
}

impl Recent {
    fn look_at(&mut self, change: Change, size: f64) {
        self.steps[self.next] = change;
        self.next = (self.next + 1) % WINDOW;
        self.largest = self.largest.max(size);
    }

    /// Of the last steps together.
    fn total(&self) -> Change {
        let sum = |of: fn(&Change) -> f64| self.steps.iter().map(of).sum::<f64>();
        Change {
            square: sum(|change| change.square),
            curvature: sum(|change| change.curvature),
        }
    }

    /// The mean change in a step.
    fn change(&self) -> f64 {
        (self.total().square / WINDOW as f64).sqrt()
    }

    /// The same by the largest size in the run.
    fn share(&self) -> f64 {
        self.change() / self.largest
    }

    /// Steps in a period where they are too few, and the motion is no small one.
    fn coarse_steps(&self) -> Option<f64> {
        let steps = self.total().steps_per_period();
        (self.share() > SIGNIFICANT && steps < FEWEST).then_some(steps)
    }

    /// How far a motion of this largest speed goes to each side, where it swings with the frequency of the last steps.
    fn amplitude(&self, step: f64) -> f64 {
        self.largest * step * self.total().steps_per_period() / TAU
    }

    fn is_hopeless(&self) -> bool {
        self.share() > OVERTURNED && self.total().steps_per_period() < HOPELESS
    }
}

/// Of velocities, and their size at the end.
fn place_change(body: &Body, start: &State, end: &State, step: f64) -> (Change, f64) {
    let first = body.velocities.start;
    let sum = |range: Range<usize>, of: &dyn Fn(usize) -> f64| {
        range.map(|i| of(first + i).powi(2)).sum::<f64>()
    };
    let both = |of: &dyn Fn(usize) -> f64| sum(0..3, of) + body.length.powi(2) * sum(3..6, of);
    let change = Change {
        square: both(&|i| end.velocities[i] - start.velocities[i]),
        curvature: step * step * both(&|i| end.accelerations[i] - start.accelerations[i]),
    };
    (change, both(&|i| end.velocities[i]).sqrt())
}

/// Of the coordinates that are displacements, and their size at the end.
fn deflection_change(body: &Body, start: &State, end: &State, step: f64) -> (Change, f64) {
    let mut change = Change::default();
    let mut size: f64 = 0.0;
    for k in 0..body.flexible.displacement_count() {
        let (y, a) = (body.coordinates.start + k, body.velocities.start + 6 + k);
        let by = end.coordinates[y] - start.coordinates[y];
        let bent = end.accelerations[a] - start.accelerations[a];
        change.square += by * by;
        change.curvature += step * step * (bent * by).abs();
        size += end.coordinates[y].powi(2);
    }
    (change, size.sqrt())
}
