//! Where the time of steps goes.

use std::time::Instant;

/// Where the time of steps goes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Profile {
    /// Predicting the state at the end of the step, s.
    pub predict: f64,
    /// Evaluating frames, rows and forces.
    pub evaluate: f64,
    /// Assembling and factoring the iteration matrix.
    pub factor: f64,
    /// Solving with it.
    pub solve: f64,
    /// Correcting the state.
    pub correct: f64,
}

impl Profile {
    pub(super) fn of_prediction(&mut self) -> &mut f64 {
        &mut self.predict
    }

    pub(super) fn of_evaluations(&mut self) -> &mut f64 {
        &mut self.evaluate
    }

    pub(super) fn of_factors(&mut self) -> &mut f64 {
        &mut self.factor
    }

    pub(super) fn of_solves(&mut self) -> &mut f64 {
        &mut self.solve
    }

    pub(super) fn of_corrections(&mut self) -> &mut f64 {
        &mut self.correct
    }

    /// Time in all stages.
    pub fn total(&self) -> f64 {
        self.predict + self.evaluate + self.factor + self.solve + self.correct
    }
}

/// A clock that runs only where somebody wants to know.
pub(super) struct Watch {
    running: Option<Instant>,
}

impl Watch {
    pub(super) fn start(profile: Option<&Profile>) -> Self {
        Self {
            running: profile.map(|_| Instant::now()),
        }
    }

    /// Adds the time since the last call to a stage.
    pub(super) fn lap(
        &mut self,
        profile: &mut Option<Profile>,
        stage: fn(&mut Profile) -> &mut f64,
    ) {
        if let (Some(since), Some(profile)) = (self.running, profile) {
            let now = Instant::now();
            *stage(profile) += (now - since).as_secs_f64();
            self.running = Some(now);
        }
    }
}
