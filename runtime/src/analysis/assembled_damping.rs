//! Damping of the modes of a mechanism as it is put together, as forces on the deflections of its bodies.
//!
//! With Y the deflections y of all bodies in the modes (unit modal mass) and K_y their stiffness, the amplitudes of the modes are read
//! from the deflections alone, and each is damped:
//!
//! ```text
//! a = (Yᵀ K_y Y)⁻¹ Yᵀ K_y y,    C = Aᵀ diag(2 ζ ω) A,    Yᵀ C Y = diag(2 ζ ω)
//! ```
//! Motions without deflection are not damped, wherever the mechanism has gone, and C turns with the bodies' frames. Where all stiffness
//! is that of the bodies, `Yᵀ K_y Y = diag(ω²)`, and the other modes of the linearized mechanism don't meet C.

use dcb_formats::component::Damping;
use dcb_formats::scene::{AssembledDamping, ModalRatios};
use faer::linalg::solvers::Solve;
use faer::{Mat, Side};

use super::effective_damping::{AssembledModes, ELASTIC};
use crate::error::Error;
use crate::force_law::{Characteristic, Law};
use crate::system::{State, System};

/// A larger mechanism isn't damped: every mode is a force on every body.
const LARGEST: usize = 300;

/// What the coordinates of each body contribute to the amplitude of a mode, a length, and the damper of that.
pub type DampedAmplitude = (Vec<Vec<f64>>, Law);

/// For each damped mode, by frequency: what the coordinates of each body contribute to its amplitude, a length, and the damper of that.
///
/// # Errors
/// [`Error::Description`] where more ratios are listed than there are modes, where a frequency is above that of all modes, where no mode
/// deflects a superelement and for systems with more than 300 degrees of freedom; those of the linearization.
pub fn damped_amplitudes(
    system: &System,
    state: &State,
    asked: &AssembledDamping,
) -> Result<Vec<DampedAmplitude>, Error> {
    let key = format!("damping.{}", asked.key());
    let refused = |message: String| Err(Error::described(key.clone(), message));
    let count = system.velocity_count();
    if count > LARGEST {
        return refused(format!(
            "needs all modes of the mechanism, which has {count} coordinates; at most {LARGEST} are handled: keep fewer modes, or damp the parts by themselves"
        ));
    }
    let found = AssembledModes::at(system, state)?;
    let modes: Vec<_> = (found.modes.iter())
        .filter(|mode| mode.elastic_share(system) > ELASTIC)
        .collect();
    if modes.is_empty() {
        return refused("finds no mode of the mechanism in which a superelement deflects".into());
    }
    let highest = modes
        .iter()
        .fold(0.0_f64, |most, mode| most.max(mode.frequency));
    let ratios = ratios(
        asked,
        &modes.iter().map(|m| m.frequency).collect::<Vec<_>>(),
    );
    if let Some(ModalRatios::PerMode(list)) = &asked.assembled_modal
        && list.len() > modes.len()
    {
        return refused(format!(
            "lists {} ratios, but superelements deflect in {} modes of the mechanism",
            list.len(),
            modes.len()
        ));
    }
    if let Some(points) = &asked.assembled_rayleigh {
        let most = points.frequencies[0].max(points.frequencies[1]);
        if most > highest {
            return refused(format!(
                "has the frequency {most}, above that of every mode of the mechanism (the highest is {highest:.4e}): the ratio there is nobody's"
            ));
        }
    }
    // Yᵀ K_y over the elastic coordinates of all bodies.
    let elastic: Vec<(usize, f64)> = (system.bodies.iter())
        .flat_map(|body| {
            body.velocities
                .clone()
                .skip(6)
                .zip(&body.flexible.stiffness)
        })
        .map(|(at, stiffness)| (at, *stiffness))
        .collect();
    let forces = Mat::from_fn(modes.len(), elastic.len(), |j, k| {
        modes[j].motion[elastic[k].0] * elastic[k].1
    });
    let deflections = Mat::from_fn(elastic.len(), modes.len(), |k, j| {
        modes[j].motion[elastic[k].0]
    });
    let energies = (&forces * &deflections).llt(Side::Lower);
    let amplitudes = energies.map_err(|_| Error::NoEigenvalues)?.solve(&forces);
    let mass: f64 = (system.bodies.iter())
        .map(|body| body.flexible.inertia.mass())
        .sum();
    let length = 1.0 / mass.sqrt();
    let damped = modes.iter().zip(ratios).enumerate();
    let damped = damped.filter(|(_, (_, ratio))| *ratio > 0.0);
    damped
        .map(|(j, (mode, ratio))| {
            let mut next = 0;
            let by_body = system.bodies.iter().map(|body| {
                let own = next..next + body.coordinates.len();
                next = own.end;
                own.map(|k| length * amplitudes[(j, k)]).collect()
            });
            let by_body = by_body.collect();
            let slope = 2.0 * ratio * std::f64::consts::TAU * mode.frequency * mass;
            let law = Law::new(
                0.0,
                Characteristic::Linear { slope: 0.0 },
                Characteristic::Linear { slope },
            )?;
            Ok((by_body, law))
        })
        .collect()
}

/// The ratio that is asked at each frequency; of a scene that has been checked.
fn ratios(asked: &AssembledDamping, frequencies: &[f64]) -> Vec<f64> {
    let factors = asked.assembled_rayleigh.as_ref().map(|points| {
        Damping::rayleigh_through(points.frequencies, points.ratios).unwrap_or_default()
    });
    let ratio = |(index, frequency): (usize, &f64)| match (&asked.assembled_modal, factors) {
        (Some(ratios), _) => ratios.of_mode(index),
        (None, Some([alpha, beta])) => {
            let omega = std::f64::consts::TAU * frequency;
            0.5 * (alpha / omega + beta * omega)
        }
        (None, None) => 0.5 * asked.assembled_structural.unwrap_or(0.0),
    };
    frequencies.iter().enumerate().map(ratio).collect()
}
