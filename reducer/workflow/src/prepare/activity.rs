//! Activity of every coordinate of every body in a run, beyond following its interface forces.
//!
//! A coordinate that is left out of a superelement leaves its static response to interface forces in F_res. What is lost is
//!
//! ```text
//! d_j(t) = y_j(t) − (L_b ψ_j)ᵀ g(t) / ω_j²
//! ```
//! its vibration and its response to inertia forces. |d_j| / √m is a displacement: coordinates of different bodies compare by it.

use dcb_runtime::simulation::Simulation;
use dcb_runtime::system::Body;

/// The largest |d_j| / √m of each coordinate so far, body by body in the order of the system.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Activity {
    bodies: Vec<Vec<f64>>,
}

impl Activity {
    /// Looks at the state of a run.
    pub fn watch(&mut self, simulation: &Simulation) {
        let system = simulation.system();
        self.bodies.resize_with(system.bodies.len(), Vec::new);
        for (index, (body, most)) in system.bodies.iter().zip(&mut self.bodies).enumerate() {
            let y = &simulation.state().coordinates[body.coordinates.clone()];
            most.resize(y.len(), 0.0);
            let forces = simulation.interface_forces(index);
            let scale = body.flexible.inertia.mass().sqrt().recip();
            for (coordinate, (y, most)) in y.iter().zip(most).enumerate() {
                let own = y - followed(body, coordinate, &forces);
                *most = most.max(scale * own.abs());
            }
        }
    }

    /// Those of one body.
    pub fn of_body(&self, index: usize) -> &[f64] {
        self.bodies.get(index).map_or(&[], Vec::as_slice)
    }
}

/// The static response of a coordinate to forces on the interface rows; none of one without stiffness.
fn followed(body: &Body, coordinate: usize, forces: &[f64]) -> f64 {
    let flexible = &body.flexible;
    let stiffness = flexible.stiffness[coordinate];
    if stiffness <= 0.0 {
        return 0.0;
    }
    let shape = flexible.interface_shapes.col(coordinate);
    let work: f64 = shape
        .iter()
        .zip(forces)
        .map(|(shape, force)| shape * force)
        .sum();
    work / stiffness
}
