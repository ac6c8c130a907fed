//! Saved states of a run.

use super::Simulation;
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

impl Simulation {
    /// The state with all that its continuation depends on. Both runs, this one and a restored one, go on from here alike to
    /// the last bit.
    pub fn save(&mut self) -> Snapshot {
        self.corrector.forget();
        self.resolution.forget();
        Snapshot {
            state: self.state.clone(),
            works: self.works,
            reference_energy: self.reference_energy,
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
        self.corrector.forget();
        self.resolution.forget();
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
