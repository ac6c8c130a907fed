//! Independent coordinates that have names: some of those of the bodies, as many as there are free directions, and drives.

use dcb_formats::linear_system::Variable;
use dcb_formats::scene::Scene;
use faer::Mat;

use super::input::{Input, Kind, is_length};
use crate::analysis::independent::IndependentMotion;
use crate::error::Error;
use crate::model::Quantities;
use crate::system::System;

/// Rows as large as the largest but for this part of it are as good, so that rounding doesn't choose.
const AS_GOOD: f64 = 1e-6;

/// Makes some of the bodies' coordinates the independent ones; the states: these, drives, and the rates of both.
pub(super) fn choose(
    scene: &Scene,
    system: &System,
    motion: &mut IndependentMotion,
    inputs: &[Input],
) -> Result<Vec<Variable>, Error> {
    let chosen = independent_rows(motion);
    motion.follow(&chosen)?;
    let quantities = Quantities::of(&scene.units);
    let coordinates = chosen
        .iter()
        .map(|row| coordinate(system, &quantities, *row));
    let drives = inputs.iter().filter_map(|input| match input.kind {
        Kind::Drive { row } => {
            let unit = match is_length(system, row) {
                true => quantities.length.as_str(),
                false => "rad",
            };
            Some((format!("drives/{}", input.variable.name), unit.to_owned()))
        }
        Kind::Load { .. } | Kind::PartLoad { .. } | Kind::Actuator { .. } => None,
    });
    let places: Vec<(String, String)> = coordinates.chain(drives).collect();
    let rates: Vec<(String, String)> = (places.iter())
        .map(|(name, unit)| {
            let unit = format!("{unit}/{}", quantities.time);
            (format!("rate of {name}"), unit)
        })
        .collect();
    let states = places.into_iter().chain(rates);
    Ok(states
        .map(|(name, unit)| Variable {
            name,
            unit,
            at: 0.0,
        })
        .collect())
}

/// Amounts of the coordinates, drives included, that are about as large as each other: lengths.
pub(super) fn units(system: &System, motion: &IndependentMotion, inputs: &[Input]) -> Vec<f64> {
    let longest = (system.bodies.iter()).map(|body| body.length);
    let longest = longest.fold(f64::MIN_POSITIVE, f64::max);
    let drives = inputs.iter().filter_map(Input::driven_row);
    let drives = drives.map(|row| match is_length(system, row) {
        true => 1.0,
        false => 1.0 / longest,
    });
    motion.units.iter().copied().chain(drives).collect()
}

/// Name and unit of one number of the velocity arrays as a place.
fn coordinate(system: &System, quantities: &Quantities, index: usize) -> (String, String) {
    const FRAME: [&str; 6] = ["x", "y", "z", "rx", "ry", "rz"];
    let owner = (system.bodies.iter()).find(|body| body.velocities.contains(&index));
    let (name, place) = owner.map_or(("", 0), |body| {
        (body.name.as_str(), index - body.velocities.start)
    });
    let unit = match place {
        0..3 => &quantities.length,
        3..6 => "rad",
        _ => &quantities.modal,
    };
    let part = match FRAME.get(place) {
        Some(part) => (*part).to_owned(),
        None => (place - 5).to_string(),
    };
    (format!("{name}/{part}"), unit.to_owned())
}

/// Rows of D⁻¹ Z that determine all others, well conditioned: each time the one with most beside those chosen already.
fn independent_rows(motion: &IndependentMotion) -> Vec<usize> {
    let scale = &motion.directions.scale;
    let free = motion.free_count();
    let mut rest = Mat::from_fn(motion.places.nrows(), free, |i, j| match scale[i] > 0.0 {
        true => motion.places[(i, j)] / scale[i],
        false => 0.0,
    });
    let mut chosen = Vec::with_capacity(free);
    for _ in 0..free {
        let sizes: Vec<f64> = rest.row_iter().map(|row| row.squared_norm_l2()).collect();
        let largest = sizes.iter().fold(0.0, |most: f64, size| most.max(*size));
        let Some(row) = sizes
            .iter()
            .position(|size| *size >= (1.0 - AS_GOOD) * largest)
        else {
            break;
        };
        chosen.push(row);
        let direction = rest.row(row).to_owned() * faer::Scale(1.0 / largest.sqrt());
        let shares = &rest * direction.transpose();
        rest -= shares * direction;
    }
    chosen.sort_unstable();
    chosen
}
