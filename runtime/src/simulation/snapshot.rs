//! Saved states of a run.

use super::{Simulation, Stepper};
use crate::energy::Works;
use crate::error::Error;
use crate::system::State;

/// A state and all that its continuation depends on; restoring it continues to the last bit.
#[derive(Clone, Debug, PartialEq)]
pub struct Snapshot {
    state: State,
    works: Works,
    reference_energy: f64,
}

impl Snapshot {
    /// All that is saved as numbers, in an order of its own: for files and messages.
    pub fn numbers(&self) -> Vec<f64> {
        let mut numbers = Vec::new();
        self.clone().visit(&mut |number| numbers.push(*number));
        numbers
    }

    fn visit(&mut self, see: &mut dyn FnMut(&mut f64)) {
        let Self {
            state,
            works,
            reference_energy,
        } = self;
        state.visit(see);
        works.visit(see);
        see(reference_energy);
    }
}

impl Simulation {
    /// What follows depends on the state alone.
    fn forget(&mut self) {
        self.corrector.forget();
        self.resolution.forget();
        if let Stepper::Radau(radau) = &mut self.stepper {
            radau.forget();
        }
    }

    /// The state with all that its continuation depends on. Both runs, this one and a restored one, go on from here alike to
    /// the last bit.
    pub fn save(&mut self) -> Snapshot {
        self.forget();
        Snapshot {
            state: self.state.clone(),
            works: self.works,
            reference_energy: self.reference_energy,
        }
    }

    /// A saved state of the same system by its [`Snapshot::numbers`]; the motion itself stays as it is.
    ///
    /// # Errors
    /// [`Error::ForeignSnapshot`] if there are more or fewer than a state of this system has.
    pub fn snapshot_of(&self, numbers: &[f64]) -> Result<Snapshot, Error> {
        let mut snapshot = Snapshot {
            state: self.state.clone(),
            works: self.works,
            reference_energy: self.reference_energy,
        };
        let mut rest = numbers.iter();
        let mut is_enough = true;
        snapshot.visit(&mut |number| match rest.next() {
            Some(given) => *number = *given,
            None => is_enough = false,
        });
        match is_enough && rest.next().is_none() {
            true => Ok(snapshot),
            false => Err(Error::ForeignSnapshot),
        }
    }

    /// Goes back, or on, to a saved state of the same system.
    ///
    /// # Errors
    /// [`Error::ForeignSnapshot`] if it is of another system.
    pub fn restore(&mut self, snapshot: &Snapshot) -> Result<(), Error> {
        if sizes(&self.state) != sizes(&snapshot.state) {
            return Err(Error::ForeignSnapshot);
        }
        self.forget();
        self.state.copy_from(&snapshot.state);
        self.works = snapshot.works;
        self.reference_energy = snapshot.reference_energy;
        Ok(())
    }
}

/// Bodies, coordinates, rows, angles, inputs and what actuators remember.
fn sizes(state: &State) -> [usize; 6] {
    [
        state.origins.len(),
        state.coordinates.len(),
        state.forces.len(),
        state.angles.len(),
        state.inputs.len(),
        state.memory.len(),
    ]
}
