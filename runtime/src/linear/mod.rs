//! The linear system of a mechanism about a state: A, B, C and D in independent coordinates.
//!
//! States are amounts ζ of independent coordinates and their rates; ζ are variations of bodies' coordinates, in body axes that move along with
//! the motion, then the coordinates of drives that are inputs ([`crate::analysis::independent`]). With u of loads their amplitudes and of drives
//! the accelerations of what they drive
//!
//! ```text
//! Zᵀ M T ζ'' + Zᵀ (C T + 2 M T') ζ' + Zᵀ (K T + C T' + M T'') ζ  =  Zᵀ F u        ζ'' = u for drives
//! ```
//! Accelerations and forces of constraints follow from the same linear equations; outputs are differentiated along them by differences.

mod balanced;
mod coordinates;
mod input;
mod operating_point;
mod output;
mod paths;
mod separation;

pub(crate) use operating_point::settled;
pub(crate) use paths::{Path, cut, paths};

use faer::Mat;
use faer::linalg::solvers::Solve;

use crate::actuator::{Source, Timing};
use crate::analysis::eigenmodes::Eigenmodes;
use crate::analysis::independent::IndependentMotion;
use crate::error::Error;
use crate::model::Recorder;
use crate::system::{Demand, State, System};
use dcb_formats::linear_system::{LinearSystem, Pole};
use dcb_formats::scene::Scene;
use input::{Input, Kind};
use output::Outputs;

/// What a linear system is to have.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LinearRequest {
    /// Names of inputs: loads or one component of a load as `NAME/INDEX`, drives. Empty: those that are declared as `input`, or all loads and
    /// drives of a scene that declares none.
    pub inputs: Vec<String>,
    /// Names of outputs or of whatever else a run records, for example `reactions/JOINT`. Empty: the scene's outputs.
    pub outputs: Vec<String>,
    /// Number of states, by balanced truncation; all of them where `None`.
    pub order: Option<usize>,
}

/// The linear system at a state with consistent positions and velocities.
pub(crate) fn linear_system(
    scene: &Scene,
    system: &System,
    state: &State,
    recorder: &mut Recorder,
    request: &LinearRequest,
) -> Result<LinearSystem, Error> {
    let wanted = Wanted::of(Coordinates::Named);
    linearized(scene, system, state, recorder, request, &wanted).map(|of| of.system)
}

/// Which coordinates a linear system is in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Coordinates {
    /// Coordinates of bodies, which have names.
    Named,
    /// Orthonormal free directions, which are conditioned best. The inputs that are loads oscillate about zero.
    Orthonormal,
}

/// What is wanted of a linear system beside the request.
pub(crate) struct Wanted {
    coordinates: Coordinates,
    /// Rows whose forces come after the outputs.
    pub forces: Vec<usize>,
    /// Bodies the forces on whose interface rows come after these.
    pub interfaces: Vec<usize>,
    /// Rows of given efforts that come after the inputs.
    pub efforts: Vec<usize>,
    /// Whether forces along the outputs that are displacements come after these.
    pub duals: Duals,
}

/// Forces along displacements.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Duals {
    Without,
    /// One for each output that is a displacement of a place on a body.
    With,
}

impl Wanted {
    pub fn of(coordinates: Coordinates) -> Self {
        Self {
            coordinates,
            forces: Vec::new(),
            interfaces: Vec::new(),
            efforts: Vec::new(),
            duals: Duals::Without,
        }
    }
}

/// A linear system, and the equations of second order that it was made of.
pub(crate) struct Linearized {
    pub system: LinearSystem,
    pub second_order: SecondOrder,
    /// Of each row of C whether it is a force or an acceleration: at rest what it has of places it has through the stiffness.
    pub follows_forces: Vec<bool>,
    /// Forces of the rows that were wanted, at the state.
    pub forces: Vec<f64>,
    /// For each output the input that is a force along it, where there is one.
    pub duals: Vec<Option<usize>>,
}

/// `M ζ'' + C ζ' + K ζ = F u` over the free coordinates, and those of drives.
pub(crate) struct SecondOrder {
    /// M, C and K, (free, k): free coordinates, then drives.
    pub matrices: [Mat<f64>; 3],
    /// F, (free, n_u); zero for drives.
    pub forces: Mat<f64>,
    /// The coordinate of each input that is a drive.
    pub drives: Vec<Option<usize>>,
    /// Amounts of the free coordinates that are about as large as each other.
    pub units: Vec<f64>,
}

/// The mechanism without the loads that are inputs: about its rest they oscillate.
///
/// # Errors
/// [`Error::Description`] for names that are no inputs.
pub(crate) fn without_inputs(
    scene: &Scene,
    system: &System,
    state: &State,
    names: &[String],
) -> Result<System, Error> {
    let inputs = input::chosen(system, state, scene, names)?;
    Ok(input::without_loads(system, &inputs))
}

/// The same with its equations of second order.
pub(crate) fn linearized(
    scene: &Scene,
    system: &System,
    state: &State,
    recorder: &mut Recorder,
    request: &LinearRequest,
    wanted: &Wanted,
) -> Result<Linearized, Error> {
    refuse_memory(system)?;
    let mut inputs = input::chosen(system, state, scene, &request.inputs)?;
    inputs.extend(input::efforts(system, &wanted.efforts));
    let outputs = Outputs::chosen(recorder, &request.outputs, wanted)?;
    let displaced = match wanted.duals {
        Duals::With => outputs.displaced(recorder),
        Duals::Without => Vec::new(),
    };
    let pushed = input::pushed(system, &displaced, &mut inputs);
    let system = &pushed.system;
    let quiet;
    let system = match wanted.coordinates {
        Coordinates::Named => system,
        Coordinates::Orthonormal => {
            quiet = input::without_loads(system, &inputs);
            &quiet
        }
    };
    let driven: Vec<usize> = inputs.iter().filter_map(Input::driven_row).collect();
    let mut motion = IndependentMotion::at(system, state, &driven)?;
    // Forces of joints that balanced the loads at the start have a stiffness of their own.
    let without_loads;
    let state = match wanted.coordinates {
        Coordinates::Named => state,
        Coordinates::Orthonormal => {
            without_loads = operating_point::with_reactions(system, state, &motion);
            motion = IndependentMotion::at(system, &without_loads, &driven)?;
            &without_loads
        }
    };
    let (state, listed) = (
        &operating_point::with_reactions(system, state, &motion),
        driven.len() + motion.free_count(),
    );
    if listed == 0 {
        return Err(Error::described(
            "bodies",
            "can't move: joints and drives leave no degree of freedom; name a drive as an input, or free a joint",
        ));
    }
    let names = match wanted.coordinates {
        Coordinates::Named => coordinates::choose(scene, system, &mut motion, &inputs)?,
        Coordinates::Orthonormal => Vec::new(),
    };
    let modes = Eigenmodes::of(system, &motion)?;
    let forces = Mat::from_fn(system.velocity_count(), inputs.len(), |_, _| 0.0);
    let forces = inputs
        .iter()
        .enumerate()
        .fold(forces, |mut all, (j, input)| {
            for (i, force) in input.force(system, state).into_iter().enumerate() {
                all[(i, j)] = force;
            }
            all
        });
    let equations = Equations::of(&motion, &inputs, &forces);
    let (a, b) = equations.first_order();
    let directions = (0..a.ncols() + b.ncols()).map(|j| equations.variation(&motion, &forces, j));
    let (at, slopes) = outputs.sensitivities(system, state, recorder, &inputs, directions);
    let (c, d) = slopes.split_at(a.ncols());
    let [c, d] = [c, d].map(|columns| Mat::from_fn(at.len(), columns.len(), |i, j| columns[j][i]));
    let mut poles: Vec<Pole> = (modes.poles().into_iter())
        .chain(std::iter::repeat_n([0.0; 2], 2 * driven.len()))
        .map(|[growth, angular_frequency]| Pole {
            growth,
            angular_frequency,
        })
        .collect();
    poles.sort_by(|a, b| a.magnitude().total_cmp(&b.magnitude()));
    let units = coordinates::units(system, &motion, &inputs);
    let mut next_drive = motion.free_count();
    let second_order = SecondOrder {
        matrices: motion.reduced(),
        forces: motion
            .places
            .as_ref()
            .subcols(0, motion.free_count())
            .transpose()
            * &forces,
        drives: (inputs.iter())
            .map(|input| {
                input.driven_row().map(|_| {
                    next_drive += 1;
                    next_drive - 1
                })
            })
            .collect(),
        units: motion.units.clone(),
    };
    let linear = LinearSystem {
        units: scene.units.clone(),
        time: state.time,
        is_equilibrium: operating_point::is_at_rest(
            system,
            state,
            poles.last().map_or(0.0, Pole::magnitude),
        ),
        a,
        b,
        c,
        d,
        states: names,
        inputs: inputs.into_iter().map(|input| input.variable).collect(),
        outputs: outputs.variables(recorder, &at),
        poles,
        truncation: None,
    };
    let system = match request.order {
        Some(order) => balanced::truncated(linear, order, &units)?,
        None => linear,
    };
    Ok(Linearized {
        system,
        second_order,
        follows_forces: outputs.follow_forces(recorder, at.len()),
        duals: (0..at.len())
            .map(|output| {
                let mut duals = pushed.along.iter();
                duals.find(|(of, _)| *of == output).map(|(_, input)| *input)
            })
            .collect(),
        forces: wanted.forces.iter().map(|row| state.forces[*row]).collect(),
    })
}

/// Efforts that follow what was have no linear system in coordinates and rates alone.
fn refuse_memory(system: &System) -> Result<(), Error> {
    let has_memory = |source: &Source| match source {
        Source::Servo(servo, _) => servo.sample.is_some() || servo.remembers(),
        Source::Controlled(controller) => {
            matches!(
                system.controllers[*controller].timing,
                Timing::Sampled { .. }
            )
        }
        Source::Given(_) | Source::Friction(_) | Source::EndStop(_) => false,
    };
    for connection in &system.connections {
        for row in connection.rows.clone() {
            if let Demand::Actuate(actuator) = system.rows[row].demand
                && has_memory(&system.actuators[actuator].source)
            {
                return Err(Error::described(
                    format!("actuators/{}", connection.name),
                    "has a sample, a period or an integral, which coordinates and rates don't tell; take a torque or force with an input in its place, and close the loop outside",
                ));
            }
        }
    }
    Ok(())
}

/// ζ'' by ζ, ζ' and u: k coordinates, the free ones first.
struct Equations {
    /// (k, 2 k + n_u).
    second_rates: Mat<f64>,
    coordinates: usize,
}

impl Equations {
    fn of(motion: &IndependentMotion, inputs: &[Input], forces: &Mat<f64>) -> Self {
        let [mass, damping, stiffness] = motion.reduced();
        let (free, k) = (motion.free_count(), motion.places.ncols());
        let mut second_rates = Mat::zeros(k, 2 * k + inputs.len());
        let mut drive = free;
        let mut right = Mat::zeros(free, 2 * k + inputs.len());
        for i in 0..free {
            for j in 0..k {
                right[(i, j)] = -stiffness[(i, j)];
                right[(i, k + j)] = -damping[(i, j)];
            }
        }
        let applied = motion.places.as_ref().subcols(0, free).transpose() * forces;
        for (j, input) in inputs.iter().enumerate() {
            let column = 2 * k + j;
            match input.kind {
                Kind::Drive { .. } => {
                    for i in 0..free {
                        right[(i, column)] = -mass[(i, drive)];
                    }
                    second_rates[(drive, column)] = 1.0;
                    drive += 1;
                }
                Kind::Load { .. } | Kind::PartLoad { .. } | Kind::Actuator { .. } => {
                    for i in 0..free {
                        right[(i, column)] = applied[(i, j)];
                    }
                }
            }
        }
        if free > 0 {
            let own = mass.as_ref().subcols(0, free).to_owned();
            let solved = own.partial_piv_lu().solve(&right);
            second_rates
                .as_mut()
                .subrows_mut(0, free)
                .copy_from(&solved);
        }
        Self {
            second_rates,
            coordinates: k,
        }
    }

    /// A and B over (ζ, ζ').
    fn first_order(&self) -> (Mat<f64>, Mat<f64>) {
        let k = self.coordinates;
        let entry = |i: usize, j: usize| match i < k {
            true => f64::from(u8::from(j == i + k)),
            false => self.second_rates[(i - k, j)],
        };
        let inputs = self.second_rates.ncols() - 2 * k;
        (
            Mat::from_fn(2 * k, 2 * k, entry),
            Mat::from_fn(2 * k, inputs, |i, j| entry(i, 2 * k + j)),
        )
    }

    /// x, x', x'' and the λ of the constraints for a unit of a column: ζ, ζ', then u.
    fn variation(
        &self,
        motion: &IndependentMotion,
        forces: &Mat<f64>,
        column: usize,
    ) -> output::Direction {
        let k = self.coordinates;
        let second = self.second_rates.col(column);
        let mut places = faer::Col::zeros(motion.places.nrows());
        let mut rates = places.clone();
        let mut second_rates = &motion.places * second;
        if column < k {
            places += motion.places.col(column);
            rates += motion.rates.col(column);
            second_rates += motion.second_rates.col(column);
        } else if column < 2 * k {
            rates += motion.places.col(column - k);
            second_rates += motion.rates.col(column - k) * faer::Scale(2.0);
        }
        let of = &motion.linearization;
        let mut residual =
            &of.mass * &second_rates + &of.damping * &rates + &of.stiffness * &places;
        if column >= 2 * k {
            residual -= forces.col(column - 2 * k);
        }
        let list = |of: &faer::Col<f64>| of.iter().copied().collect::<Vec<f64>>();
        let reactions = motion.directions.reactions(&list(&residual));
        output::Direction {
            place: list(&places),
            rate: list(&rates),
            second_rate: list(&second_rates),
            constraints: of.constraints.iter().copied().zip(reactions).collect(),
            input: column.checked_sub(2 * k),
        }
    }
}
