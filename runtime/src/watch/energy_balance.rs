//! How well the energy balance of a run closes.

use crate::model::RecordedStep;

/// Part of the energy that gravity, or a motion through a body's own length in the time of the run, would have: less of it is rounding.
const ROUNDING: f64 = 1e-12;

/// Largest defect and largest energies among the states looked at.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EnergyBalance {
    /// Largest size of the defect.
    pub defect: f64,
    /// Largest energy that was stored (kinetic, strain, springs), or that drives, loads and dampers exchanged.
    pub largest: f64,
    /// Energies up to this are rounding.
    rounding: f64,
}

impl EnergyBalance {
    /// Looks at a recorded state.
    pub fn look_at(&mut self, at: &RecordedStep) {
        let (system, state) = (at.system, at.state);
        let stored = at.energy.kinetic + at.energy.strain + at.energy.springs;
        let exchanged = [at.works.drives, at.works.loads, at.works.dissipated];
        self.defect = self.defect.max(at.defect.abs());
        self.largest = exchanged
            .iter()
            .fold(self.largest.max(stored), |most, work| most.max(work.abs()));
        let gravity = system.gravity.norm();
        let bodies = system.bodies.iter().zip(&state.origins);
        self.rounding = bodies.fold(0.0, |sum, (body, origin)| {
            let fall = gravity * (origin.norm() + body.length);
            let travel = match state.time > 0.0 {
                true => (body.length / state.time).powi(2),
                false => 0.0,
            };
            sum + ROUNDING * body.flexible.inertia.mass() * (fall + travel)
        });
    }

    /// The defect as a part of the largest energy; `None` where all energies are rounding, so that there is nothing to compare with.
    pub fn share(&self) -> Option<f64> {
        (self.largest > self.rounding).then(|| self.defect / self.largest)
    }
}
