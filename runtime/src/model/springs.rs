//! Springs and bushings of a scene, to rows with force laws.

use dcb_formats::mesh::Dimension;
use nalgebra::Vector3;

use super::Names;
use super::couplings::coordinate;
use super::places::{RotationNeeded, Turned, find, marker};
use crate::error::Error;
use crate::force_law::{self, Law, Table};
use crate::measure::{Angle, Displacement, Elongation, Measure, Rotation as Turn};
use crate::system::builder::{JointCoordinate, SystemBuilder};
use dcb_formats::scene::{Bushing, Characteristic, LineSpring, Scene, Spring};

/// Adds a spring.
pub(super) fn add_spring(
    scene: &Scene,
    builder: &mut SystemBuilder,
    names: &mut Names,
    name: &str,
    spring: &Spring,
) -> Result<(), Error> {
    let connection = match spring {
        Spring::Spring(spring) => add_line_spring(scene, builder, names, name, spring)?,
        Spring::TorsionSpring(spring) => {
            let location = format!("springs.{name}.torsion_spring");
            let found = coordinate(names, &spring.joint, JointCoordinate::Rotation);
            let Some((joint, measure)) = found else {
                return Err(Error::described(
                    format!("{location}.joint"),
                    "has no angle",
                ));
            };
            let drawn = measure.value(&builder.frame(joint.a), &builder.frame(joint.b));
            let free = spring.free_angle.unwrap_or(drawn);
            let law = law_of(&location, free, &spring.stiffness, &spring.damping)?;
            builder.spring(name, joint.a, joint.b, [(measure, law)])
        }
        Spring::Bushing(bushing) => add_bushing(scene, builder, names, name, bushing)?,
    };
    names.springs.insert(name.to_owned(), connection);
    Ok(())
}

fn add_line_spring(
    scene: &Scene,
    builder: &mut SystemBuilder,
    names: &Names,
    name: &str,
    spring: &LineSpring,
) -> Result<usize, Error> {
    let location = format!("springs.{name}.spring");
    let [a, b] = ends(
        scene,
        builder,
        names,
        &location,
        [&spring.a, &spring.b],
        &RotationNeeded::None,
    )?;
    let drawn = (builder.frame(b).position - builder.frame(a).position).norm();
    let free = spring.free_length.unwrap_or(drawn);
    if drawn == 0.0 {
        return Err(Error::described(
            location,
            "joins places that coincide as drawn: a spring along a line has no direction there; use a bushing",
        ));
    }
    let law = law_of(&location, free, &spring.stiffness, &spring.damping)?;
    let measure = Measure::Elongation(Elongation { length: drawn });
    Ok(builder.spring(name, a, b, [(measure, law)]))
}

fn add_bushing(
    scene: &Scene,
    builder: &mut SystemBuilder,
    names: &Names,
    name: &str,
    bushing: &Bushing,
) -> Result<usize, Error> {
    let location = format!("springs.{name}.bushing");
    let turns = bushing.rotation.is_some() || bushing.rotation_damping.is_some();
    let needed = if turns {
        RotationNeeded::All
    } else {
        RotationNeeded::None
    };
    let [a, b] = ends(
        scene,
        builder,
        names,
        &location,
        [&bushing.a, &bushing.b],
        &needed,
    )?;
    let (frame_a, frame_b) = (builder.frame(a), builder.frame(b));
    let axes = [Vector3::x_axis(), Vector3::y_axis(), Vector3::z_axis()];
    let mut laws = Vec::new();
    let mut add =
        |measure: Measure, stiffness: Option<&Characteristic>, damping: Option<&Characteristic>| {
            if stiffness.is_none() && damping.is_none() {
                return Ok(());
            }
            let free = measure.value(&frame_a, &frame_b);
            let none = Characteristic::Linear(0.0);
            let law = law_of(
                &location,
                free,
                stiffness.unwrap_or(&none),
                damping.unwrap_or(&none),
            )?;
            laws.push((measure, law));
            Ok::<(), Error>(())
        };
    let entry = |list: &Option<Vec<Characteristic>>, index: usize| -> Option<Characteristic> {
        list.as_ref().and_then(|list| list.get(index).cloned())
    };
    for (index, direction) in axes.into_iter().enumerate() {
        add(
            Measure::Displacement(Displacement { direction }),
            entry(&bushing.translation, index).as_ref(),
            entry(&bushing.translation_damping, index).as_ref(),
        )?;
    }
    let rotations: Vec<Measure> = match scene.dimension {
        Dimension::Planar => vec![Measure::Angle(Angle::in_plane())],
        Dimension::Spatial => axes
            .into_iter()
            .map(|direction| {
                let rest = frame_a.axes.tr_mul(&frame_b.axes);
                Measure::Rotation(Turn { direction, rest })
            })
            .collect(),
    };
    for (index, measure) in rotations.into_iter().enumerate() {
        add(
            measure,
            entry(&bushing.rotation, index).as_ref(),
            entry(&bushing.rotation_damping, index).as_ref(),
        )?;
    }
    Ok(builder.spring(name, a, b, laws))
}

fn ends(
    scene: &Scene,
    builder: &mut SystemBuilder,
    names: &Names,
    location: &str,
    references: [&str; 2],
    rotation: &RotationNeeded,
) -> Result<[usize; 2], Error> {
    let mut markers = [0; 2];
    for ((key, reference), found) in ["a", "b"].into_iter().zip(references).zip(&mut markers) {
        let at = format!("{location}.{key}");
        let place = find(scene, builder, names, &at, reference)?;
        *found = marker(builder, &at, &place, rotation, Turned::Interface)?;
    }
    Ok(markers)
}

fn law_of(
    location: &str,
    free: f64,
    stiffness: &Characteristic,
    damping: &Characteristic,
) -> Result<Law, Error> {
    let part = |characteristic: &Characteristic| {
        Ok::<_, Error>(match characteristic {
            Characteristic::Linear(slope) => force_law::Characteristic::Linear { slope: *slope },
            Characteristic::Table(points) => {
                let points: Vec<(f64, f64)> = points.iter().map(|[x, y]| (*x, *y)).collect();
                force_law::Characteristic::Tabulated(Table::through(&points)?)
            }
        })
    };
    let law = || Law::new(free, part(stiffness)?, part(damping)?);
    law().map_err(|error: Error| Error::described(location, error.to_string()))
}
