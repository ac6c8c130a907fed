//! What it took to make the start of a motion fit its joints: told, or refused where bodies were drawn far from their joints.

use dcb_formats::scene::Scene;
use dcb_formats::units::{DerivedUnits, four_digits};

use super::{Observer, Session};
use crate::error::Error;
use crate::initial::InitialReport;

/// Shorter ways, by the size of the mechanism, are rounding of the drawing; and smaller turns, rad.
const TOLD: f64 = 1e-6;
/// A body that has to go further, by the sizes of all bodies together, isn't where its joints are.
const FAR: f64 = 0.5;

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
/// [`Error::FarFromJoints`] for the body that went farthest, where that is farther than the scene's `allow_gap`, or than
/// this share of the sizes of all bodies together.
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
        let way = four_digits(moved.translation);
        let turn = four_digits(moved.rotation);
        let is_moved = moved.translation > TOLD * initial.size;
        let what = match (is_moved, moved.rotation > TOLD) {
            (true, true) => format!(
                "moved body {:?} by {way} {length} and turned it by {turn} rad",
                moved.body
            ),
            (true, false) => format!("moved body {:?} by {way} {length}", moved.body),
            (false, _) => format!("turned body {:?} by {turn} rad", moved.body),
        };
        format!("assembly {what} to close the joints")
    });
    let energy = DerivedUnits::of(length, &units.mass, time).energy;
    let strained = initial.strained.iter().map(|(body, strain)| {
        format!(
            "assembly strained body {body:?}: it starts with an elastic energy of {} {energy}",
            four_digits(*strain)
        )
    });
    let sped = initial.sped.iter().map(|sped| {
        let way = (sped.translation > TOLD * sped.rotation.abs() * initial.size).then(|| {
            format!(
                "velocity by {} {length}/{time}",
                four_digits(sped.translation)
            )
        });
        let turn = (sped.rotation * initial.size > TOLD * sped.translation).then(|| {
            format!(
                "angular velocity by {} rad/{time}",
                four_digits(sped.rotation)
            )
        });
        let done: Vec<String> = way.into_iter().chain(turn).collect();
        format!(
            "the joints changed the start of body {:?}: {}",
            sped.body,
            done.join(", ")
        )
    });
    let redundant = initial.redundant.iter().map(|(joint, count)| {
        let s = if *count == 1 { "" } else { "s" };
        format!(
            "{count} redundant constraint{s} in {joint:?}: the motion does not depend on it, but its forces are not unique: those with the least sum of squares are taken"
        )
    });
    moved.chain(strained).chain(sped).chain(redundant).collect()
}
