//! What it took to make the start of a motion fit its joints: told, or refused where bodies were drawn far from their joints.

use dcb_formats::scene::Scene;

use super::{Observer, Session};
use crate::error::Error;
use crate::initial::InitialReport;

/// Shorter ways, by the size of the mechanism, are rounding of the drawing; and smaller turns, rad.
const TOLD: f64 = 1e-6;
/// A body that has to go further, by the sizes of all bodies together, isn't where its joints are.
const FAR: f64 = 1.0;

/// Tells what it took to make the start consistent.
///
/// # Errors
/// Those of [`check_gaps`].
pub(super) fn tell_start(
    initial: &InitialReport,
    scene: &Scene,
    observer: &mut dyn Observer,
    session: &mut Session,
) -> Result<(), Error> {
    check_gaps(initial, scene)?;
    for message in start_notes(initial, scene) {
        session.tell(observer, 0.0, &message);
    }
    Ok(())
}

/// Refuses a start for which a body had to go far: a joint is given wrong, or the body isn't where it was meant to be.
///
/// # Errors
/// [`Error::FarFromJoints`] for the body that went farthest, where that is farther than the scene's `allow_gap`, or the
/// sizes of all bodies together.
pub fn check_gaps(initial: &InitialReport, scene: &Scene) -> Result<(), Error> {
    let farthest = initial
        .moved
        .iter()
        .max_by(|one, other| one.translation.total_cmp(&other.translation));
    let Some(moved) = farthest else { return Ok(()) };
    let allowed = scene.initial.allow_gap.unwrap_or(FAR * initial.size);
    if moved.translation <= allowed {
        return Ok(());
    }
    Err(Error::FarFromJoints {
        body: moved.body.clone(),
        distance: moved.translation,
        extent: initial.size,
        unit: scene.units.length.clone(),
    })
}

/// Notes on what made a start consistent.
pub fn start_notes(initial: &InitialReport, scene: &Scene) -> Vec<String> {
    let units = &scene.units;
    let (length, time) = (&units.length, &units.time);
    let told = initial
        .moved
        .iter()
        .filter(|moved| moved.translation > TOLD * initial.size || moved.rotation > TOLD);
    let moved = told.map(|moved| {
        format!(
            "assembly moved body {:?} by {:.3e} {length} and turned it by {:.3e} rad to close the joints",
            moved.body, moved.translation, moved.rotation
        )
    });
    let energy = format!("{}*{length}^2/{time}^2", units.mass);
    let strained = initial.strained.iter().map(|(body, strain)| {
        format!("assembly strained body {body:?}: it starts with an elastic energy of {strain:.3e} {energy}")
    });
    let sped = initial.sped.iter().map(|sped| {
        format!(
            "the joints ask for another velocity of body {:?}: changed by {:.3e} {length}/{time}, spin by {:.3e} rad/{time}",
            sped.body, sped.translation, sped.rotation
        )
    });
    let redundant = initial.redundant.iter().map(|(joint, count)| {
        let s = if *count == 1 { "" } else { "s" };
        format!(
            "{count} redundant constraint{s} in {joint:?}: its forces are not unique and shared out in the minimum-norm sense"
        )
    });
    moved.chain(strained).chain(sped).chain(redundant).collect()
}
