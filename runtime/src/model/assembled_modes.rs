//! A scene's damping of the assembled modes, to rows of the system.

use crate::analysis::assembled_damping::damped_amplitudes;
use crate::analysis::equilibrium::{EquilibriumSettings, find_equilibrium};
use crate::error::Error;
use crate::initial::Starter;
use crate::system::builder::SystemBuilder;
use dcb_formats::scene::{AssembledDamping, Linearization, Scene};

/// Damps the modes of everything that the builder has, about the placement that the scene names.
///
/// # Errors
/// Those of the start or of the equilibrium, and of [`damped_amplitudes`].
pub(super) fn damp(
    scene: &Scene,
    builder: &mut SystemBuilder,
    held: &[usize],
    damping: &AssembledDamping,
) -> Result<(), Error> {
    let (system, mut state) = builder.clone().finish();
    match damping.at {
        Linearization::Static => {
            find_equilibrium(&system, &mut state, &EquilibriumSettings::default())?;
        }
        Linearization::Initial => {
            Starter::of(&system)?
                .holding(held)
                .start(&mut state, scene.redundant_constraints)?;
        }
    }
    let amplitudes = damped_amplitudes(&system, &state, damping)?;
    builder.damp_amplitudes("damping", &amplitudes);
    Ok(())
}
