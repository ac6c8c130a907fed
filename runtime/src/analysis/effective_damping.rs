//! Damping of the lowest modes of a mechanism as it is put together.
//!
//! Modal ratios ζ hold for the coordinates of each part by itself, `2 ζₖ ωₖ y'ₖ` (free-free modes and attachments). A mode of the mechanism
//! with the lower frequency ω moves many of them slowly. With the undamped mode z, ω² = zᵀKz / zᵀMz,
//!
//! ```text
//! ratio  =  zᵀ C z / (2 ω zᵀ M z)          exact to second order in the damping
//! ```
//! and C is a sum over bodies, springs and actuators, so that each has its share of the ratio. Modal ratios make
//! stiff coordinates damp slow motions by about ω/ωₖ of what was given for them.

use crate::analysis::eigenmodes::undamped;
use crate::error::Error;
use crate::system::evaluation::Evaluation;
use crate::system::free_directions::FreeDirections;
use crate::system::linearization::Linearization;
use crate::system::{ConnectionKind, Demand, State, System};
use nalgebra::Vector3;

/// Modes that are told.
const MODES: usize = 4;
/// A larger system isn't looked at: its eigenvalues would take longer than a second.
const LARGEST: usize = 300;
/// Modes with less of their energy than this in superelements aren't what their damping damps.
pub(crate) const ELASTIC: f64 = 0.1;
/// What controllers feed back below this part of the whole is rounding.
const ROUNDING: f64 = 1e-10;

/// One mode of the mechanism.
#[derive(Clone, Debug, PartialEq)]
pub struct EffectiveDamping {
    /// Cycles per time.
    pub frequency: f64,
    /// Part of the critical damping: the sum of the shares.
    pub ratio: f64,
    /// What each part has of the ratio, in one order for all modes of a mechanism.
    pub shares: Vec<DampingShare>,
}

/// What one part contributes to the ratio of a mode.
#[derive(Clone, Debug, PartialEq)]
pub struct DampingShare {
    /// Kind of part.
    pub part: DampedPart,
    /// Name of the part in the scene.
    pub name: String,
    /// Its part of the critical damping; negative where it feeds the mode.
    pub ratio: f64,
}

/// What damps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DampedPart {
    /// Deflection of a body.
    Body,
    /// Spring or bushing.
    Spring,
    /// Actuator, friction included.
    Actuator,
    /// The scene's damping of the assembled modes.
    AssembledModes,
    /// What continuous controllers feed back, all together.
    Controllers,
    /// Loss factor of all stiffness in a frequency analysis.
    LossFactor,
}

impl DampedPart {
    /// Name of the kind in tables and files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Body => "body",
            Self::Spring => "spring",
            Self::Actuator => "actuator",
            Self::AssembledModes => "assembled modes",
            Self::Controllers => "controllers",
            Self::LossFactor => "loss factor",
        }
    }
}

/// Of the lowest modes in which damped parts act, at a state taken as being at rest. Empty where no superelement with damping is
/// in a joint or on a spring, for systems with more than 300 degrees of freedom, and for compatibilities that have no linearization.
pub fn effective_damping(system: &System, state: &State) -> Vec<EffectiveDamping> {
    if !has_damped_parts(system) || system.velocity_count() > LARGEST {
        return Vec::new();
    }
    // It is told beside a run, which it must not stop.
    let Ok(found) = AssembledModes::at(system, state) else {
        return Vec::new();
    };
    let elastic = (found.modes.iter()).filter(|mode| mode.elastic_share(system) > ELASTIC);
    let told = elastic.take(MODES);
    told.map(|mode| found.damping_of(system, mode)).collect()
}

/// Of the lowest `count` modes with a frequency, at a state taken as being at rest, whatever deflects in them.
///
/// # Errors
/// Those of the linearization; [`Error::NoEigenvalues`].
pub fn damping_by_part(
    system: &System,
    state: &State,
    count: usize,
) -> Result<Vec<EffectiveDamping>, Error> {
    let found = AssembledModes::at(system, state)?;
    let modes = found.modes.iter().take(count);
    Ok(modes.map(|mode| found.damping_of(system, mode)).collect())
}

/// Whether something holds a superelement, and something damps its deflection.
fn has_damped_parts(system: &System) -> bool {
    let is_damped = |marker: usize| {
        let body = system.markers[marker].body;
        body.is_some_and(|body| {
            let flexible = &system.bodies[body].flexible;
            (0..flexible.displacement_count()).any(|k| flexible.damping_coefficient(k) > 0.0)
        })
    };
    let mut connections = system.connections.iter();
    let mut terms = system.terms.iter();
    connections.any(|connection| connection.kind == ConnectionKind::AssembledModes)
        || terms.any(|term| is_damped(term.a) || is_damped(term.b))
}

/// The undamped modes of a mechanism at rest.
pub(crate) struct AssembledModes {
    /// Those with a frequency, lowest first.
    pub modes: Vec<AssembledMode>,
    still: State,
    evaluation: Evaluation,
    linear: Linearization,
}

/// One of them.
pub(crate) struct AssembledMode {
    /// Cycles per time.
    pub frequency: f64,
    /// δq of unit modal mass, laid out as velocities, translations in body axes.
    pub motion: Vec<f64>,
}

impl AssembledMode {
    fn omega(&self) -> f64 {
        std::f64::consts::TAU * self.frequency
    }

    /// The part of the mode's energy that is in the deflection of bodies.
    pub fn elastic_share(&self, system: &System) -> f64 {
        let of = |body: &crate::system::Body| -> f64 {
            let y = &self.motion[body.velocities.clone()][6..];
            let stiffness = body.flexible.stiffness.iter();
            stiffness.zip(y).map(|(k, y)| k * y * y).sum()
        };
        system.bodies.iter().map(of).sum::<f64>() / self.omega().powi(2)
    }
}

impl AssembledModes {
    pub fn at(system: &System, state: &State) -> Result<Self, Error> {
        let still = state.without_motion();
        let evaluation = Evaluation::at(system, &still);
        let linear = Linearization::with_rigid_joints(system, &still, &evaluation)?;
        let directions = FreeDirections::of(system, &linear.jacobian)?;
        let mut modes = Vec::new();
        if directions.count() > 0 {
            let [mass, _, stiffness] = directions.reduced(&linear);
            let mut found = undamped(&mass, &stiffness)?;
            found.retain(|mode| mode.angular_frequency > 0.0);
            found.sort_by(|a, b| a.angular_frequency.total_cmp(&b.angular_frequency));
            for mode in found {
                let mut motion = vec![0.0; system.velocity_count()];
                directions.add_motion(&mode.shape, &mut motion);
                let unit = form(&linear.mass, &motion).sqrt();
                motion.iter_mut().for_each(|entry| *entry /= unit);
                modes.push(AssembledMode {
                    frequency: mode.frequency(),
                    motion,
                });
            }
        }
        Ok(Self {
            modes,
            still,
            evaluation,
            linear,
        })
    }

    fn damping_of(&self, system: &System, mode: &AssembledMode) -> EffectiveDamping {
        let scale = 0.5 / mode.omega();
        let mut shares = Vec::new();
        for body in &system.bodies {
            let y = &mode.motion[body.velocities.clone()][6..];
            let y = &y[..body.flexible.displacement_count()];
            let damped = y.iter().enumerate();
            let power = damped.map(|(k, y)| body.flexible.damping_coefficient(k) * y * y);
            shares.push(DampingShare {
                part: DampedPart::Body,
                name: body.name.clone(),
                ratio: scale * power.sum::<f64>(),
            });
        }
        let rates = self.row_rates(system, mode);
        for connection in &system.connections {
            let part = match connection.kind {
                ConnectionKind::Joint | ConnectionKind::Drive => continue,
                ConnectionKind::Spring => DampedPart::Spring,
                ConnectionKind::Actuator => DampedPart::Actuator,
                ConnectionKind::AssembledModes => DampedPart::AssembledModes,
            };
            let power = connection.rows.clone().map(|row| {
                let by_rate = match &system.rows[row].demand {
                    Demand::Answer(law) => {
                        let rest = &self.evaluation;
                        law.derivatives(rest.values[row], rest.value_rates[row]).1
                    }
                    Demand::Actuate(actuator) => self.evaluation.efforts[*actuator].by_rate,
                    Demand::Hold(_) | Demand::Follow(_) => 0.0,
                };
                -by_rate * rates[row] * rates[row]
            });
            shares.push(DampingShare {
                part,
                name: connection.name.clone(),
                ratio: scale * power.sum::<f64>(),
            });
        }
        let sum = |shares: &[DampingShare]| shares.iter().map(|share| share.ratio).sum::<f64>();
        if !system.controllers.is_empty() {
            let whole = scale * form(&self.linear.damping, &mode.motion);
            let rest = whole - sum(&shares);
            let size = shares
                .iter()
                .fold(whole.abs(), |size, share| size + share.ratio.abs());
            shares.push(DampingShare {
                part: DampedPart::Controllers,
                name: "controllers".into(),
                ratio: if rest.abs() > ROUNDING * size {
                    rest
                } else {
                    0.0
                },
            });
        }
        EffectiveDamping {
            frequency: mode.frequency,
            ratio: sum(&shares),
            shares,
        }
    }

    /// Rates of all rows' measures when the mechanism moves along a mode.
    fn row_rates(&self, system: &System, mode: &AssembledMode) -> Vec<f64> {
        let mut moving = self.still.clone();
        moving.velocities.copy_from_slice(&mode.motion);
        for (pose, body) in self.evaluation.poses.iter().zip(&system.bodies) {
            let own = &mut moving.velocities[body.velocities.clone()];
            let world = pose.axes * Vector3::from_column_slice(&own[..3]);
            own[..3].copy_from_slice(world.as_slice());
        }
        Evaluation::at(system, &moving).value_rates
    }
}

/// `zᵀ A z`
fn form(matrix: &faer::Mat<f64>, z: &[f64]) -> f64 {
    let columns = matrix.col_iter().zip(z);
    let of_column = |column: faer::ColRef<'_, f64>| -> f64 {
        column.iter().zip(z).map(|(entry, z)| entry * z).sum()
    };
    columns
        .map(|(column, z)| of_column(column) * z)
        .sum::<f64>()
}
