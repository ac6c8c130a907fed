//! Radau IIA methods for the condensed equations: steps as large as an accuracy allows.
//!
//! The stages hold the equations of motion with the constraints differentiated twice, so that accelerations and λ are functions of place and
//! velocity, and all of them are of the method's order; after a step, place and velocities are brought back to the constraints:
//!
//! ```text
//! f(q_i, q'_i, q''_i) - Bᵀ λ_i = 0,       e''(q_i, q'_i, q''_i) = f''(t_i)
//! q'_i = q'_n + h Σ_j A_ij q''_j,         q_i = q_n ∘ exp(θ_i),  θ_i = h Σ_j A_ij J_r⁻¹(θ_j) q'_j
//! ```
//! With A = T diag(μ) T⁻¹ an iteration over all stages falls apart into one linear solve for each μ, with the matrix that a step of any other
//! method has at the shift 1/(h μ): real for one μ, complex for one of each pair.
//! (Hairer and Wanner, Solving Ordinary Differential Equations II, IV.8 and VII; on the group as Munthe-Kaas 1999.)

mod coefficients;
mod control;
mod crossing;
mod dense;
mod estimate;
mod finish;
mod iterate;
mod predict;
mod restart;
mod scale;
mod stage;

use faer::c64;
use nalgebra::Vector3;

pub use coefficients::Stages;

use self::coefficients::Coefficients;
use self::control::StepControl;
use self::crossing::Crossing;
use self::scale::Scale;
use self::stage::Stage;
use super::newton::Corrector;
use crate::energy::Works;
use crate::error::Error;
use crate::integrator::{Effort, Profile};
use crate::system::condensed::Condensed;
use crate::system::{State, System};

/// Bodies turn by no more in a step, rad.
const LONGEST_TURN: f64 = 1.5;

/// How accurate a run is to be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Accuracy {
    /// Error allowed, relative to the lengths of the bodies and to their largest deflections.
    pub tolerance: f64,
    /// Error allowed of the forces that deflect bodies, relative to the largest in each of them; infinite where forces aren't looked at.
    pub of_forces: f64,
    /// The method.
    pub stages: Stages,
    /// Longest step; infinite where nothing limits it.
    pub longest: f64,
    /// Time up to which functions of time are searched for their jumps.
    pub horizon: f64,
}

/// The solver of steps, but for what it shares with other methods: the real factor, the trial state and its evaluation.
pub(crate) struct Radau {
    accuracy: Accuracy,
    coefficients: Coefficients,
    pub control: StepControl,
    scale: Scale,
    stages: Vec<Stage>,
    /// Factors at the complex shifts.
    pairs: Vec<Condensed<c64>>,
    /// Right-hand sides of the real shift and of the complex ones: residuals, then changes of the rows.
    real: [Vec<f64>; 2],
    complex: [Vec<c64>; 2],
    /// The last step, by start and stages.
    past: Past,
    /// Numbers by start and stages.
    weights: Vec<f64>,
    /// Places, rates and what they are mixed to, laid out as velocities.
    scratch: [Vec<f64>; 3],
    /// The step that the factors were made for.
    factored_step: Option<f64>,
    /// How much of the error an iteration with the present factors leaves.
    contraction: f64,
    /// The accelerations at given places and velocities.
    mass: Option<Box<Condensed>>,
    /// Times at which functions of time may jump, once they are known.
    jumps: Option<Vec<f64>>,
    /// A dead centre that is being passed.
    crossing: Option<Crossing>,
    /// Whether the last step was one of it.
    has_crossed: bool,
}

/// What a step leaves for the next one and for times within it.
struct Past {
    /// Its length.
    step: f64,
    /// Whether the next one goes on from it: not before the first, and not after a jump.
    is_continued: bool,
    /// q'' at the start and the stages.
    accelerations: Vec<Vec<f64>>,
    /// λ there.
    forces: Vec<Vec<f64>>,
    /// J_r⁻¹(θ) ω there, by bodies.
    turn_rates: Vec<Vec<Vector3<f64>>>,
}

/// A step that has been made.
pub(crate) struct Made {
    pub effort: Effort,
    /// Estimate of its error, in tolerances.
    pub error: f64,
}

impl Radau {
    /// For a system, starting anywhere.
    ///
    /// # Errors
    /// [`Error::Description`] for bodies whose interfaces move beside the coordinates; [`Error::OutOfMemory`].
    pub fn of(system: &System, accuracy: Accuracy) -> Result<Self, Error> {
        if system.residual_row_count() > 0 {
            return Err(Error::described(
                "integrator.radau",
                "needs \"compatibility\": \"strong\" with mass in every direction of the interfaces; use generalized_alpha, or strong",
            ));
        }
        let coefficients = Coefficients::of(accuracy.stages);
        let (s, n, rows) = (
            coefficients.count(),
            system.velocity_count(),
            system.rows.len(),
        );
        let pairs = coefficients.pairs.iter().map(|_| Condensed::of(system));
        Ok(Self {
            control: StepControl::of(&accuracy, coefficients.count()),
            scale: Scale::of(system),
            stages: (0..s).map(|_| Stage::of(system)).collect(),
            pairs: pairs.collect::<Result<_, _>>()?,
            real: [vec![0.0; n], vec![0.0; rows]],
            complex: [vec![c64::new(0.0, 0.0); n], vec![c64::new(0.0, 0.0); rows]],
            past: Past {
                step: 0.0,
                is_continued: false,
                accelerations: vec![vec![0.0; n]; s + 1],
                forces: vec![vec![0.0; rows]; s + 1],
                turn_rates: vec![vec![Vector3::zeros(); system.bodies.len()]; s + 1],
            },
            weights: vec![0.0; s + 1],
            scratch: [vec![0.0; n], vec![0.0; n], vec![0.0; n]],
            factored_step: None,
            contraction: 1.0,
            mass: None,
            jumps: None,
            crossing: None,
            has_crossed: false,
            coefficients,
            accuracy,
        })
    }

    /// Forgets factors and the past, so that what follows depends on the state alone.
    pub fn forget(&mut self) {
        self.forget_past();
        self.factored_step = None;
        self.contraction = 1.0;
        self.crossing = None;
        self.control.forget();
    }

    /// Forgets the motion before a jump.
    pub fn forget_past(&mut self) {
        self.past.is_continued = false;
    }

    /// Advances `start` by `step` into the corrector's trial state; functions of time are looked at no later than `until`.
    ///
    /// # Errors
    /// [`Error::NotConverged`], [`Error::NotFinite`], [`Error::LongTurn`], [`Error::Contradiction`] and those of a factorization.
    pub fn step(
        &mut self,
        corrector: &mut Corrector,
        system: &System,
        start: &State,
        (step, until): (f64, f64),
    ) -> Result<Made, Error> {
        self.has_crossed = false;
        let mut watch = super::profile::Watch::start(corrector.profile.as_ref());
        self.predict(corrector, system, start, (step, until));
        watch.lap(&mut corrector.profile, Profile::of_prediction);
        let effort = self.iterate(corrector, system, start, step, &mut watch)?;
        let error = self.estimate(corrector, system, start, step);
        watch.lap(&mut corrector.profile, Profile::of_solves);
        self.finish(corrector, system, start, step)?;
        watch.lap(&mut corrector.profile, Profile::of_evaluations);
        Ok(Made { effort, error })
    }

    /// Finds a first step where there is none.
    pub fn begin(&mut self, system: &System, start: &State) {
        self.scale.go_on_from(start);
        self.scale.look_at(system, start);
        let size = self.scale.size(system, &start.accelerations);
        self.control.begin(start.earlier_step, size);
    }

    /// The step to try when `left` remains.
    pub fn step_up_to(&self, system: &System, start: &State, left: f64) -> f64 {
        let by_turn = self.scale.step_by_turn(system, start, LONGEST_TURN);
        self.control.up_to(left, by_turn)
    }

    /// The next time after this one at which a function of time may jump.
    pub fn next_jump(&mut self, system: &System, time: f64) -> f64 {
        let jumps = self.jumps.get_or_insert_with(|| {
            let breaks = system
                .signals
                .iter()
                .flat_map(|signal| signal.function.breaks(self.accuracy.horizon));
            let mut all: Vec<f64> = breaks.collect();
            all.sort_by(f64::total_cmp);
            all
        });
        let next = jumps.partition_point(|jump| *jump <= time);
        jumps.get(next).copied().unwrap_or(f64::INFINITY)
    }

    /// Adds the works of the last step, by the method's own quadrature.
    pub fn add_works(&self, system: &System, step: f64, works: &mut Works) {
        let weights = &self.coefficients.weights[self.stages.len() - 1];
        for (stage, weight) in self.stages.iter().zip(weights) {
            works.add(system, &stage.state, &stage.evaluation, step * weight);
        }
    }

    /// Whether the last step was no step of its own, but one of passing a dead centre.
    pub fn has_crossed(&self) -> bool {
        self.has_crossed
    }

    /// Accepts the step that was made last, to `end`: what comes next starts from it.
    pub fn accept(
        &mut self,
        condensed: &mut Condensed,
        system: &System,
        start: &State,
        step: f64,
        end: &mut State,
    ) {
        self.scale.look_at(system, end);
        self.scale.write_to(end);
        if self.has_crossed {
            return;
        }
        // Of a unit of acceleration: the factor's rows are of places.
        let shift = self
            .factored_step
            .map_or(0.0, |step| step * self.coefficients.real.value);
        let force = condensed.largest_force() * shift * shift;
        self.control.saw_force(force);
        self.past.step = step;
        self.past.is_continued = true;
        self.past.accelerations[0].copy_from_slice(&start.accelerations);
        self.past.forces[0].copy_from_slice(&start.forces);
        for (index, body) in system.bodies.iter().enumerate() {
            self.past.turn_rates[0][index] = stage::spin(start, body);
        }
        for (node, stage) in self.stages.iter().enumerate() {
            self.past.accelerations[node + 1].copy_from_slice(&stage.state.accelerations);
            self.past.forces[node + 1].copy_from_slice(&stage.state.forces);
            self.past.turn_rates[node + 1].copy_from_slice(&stage.turn_rates);
        }
    }
}
