//! Springs, dampers and bushings: measures that answer with a force.

use dcb_formats::mesh::Dimension;
use dcb_formats::scene::{Characteristic, Scene, Spring};
use nalgebra::Vector3;

use crate::Error;
use crate::measure::Measure;
use crate::part::Part;
use crate::spot::{Place, Spot, lacking, refuse_observed, rotations};

/// A measure with a stiffness and a damping.
#[derive(Clone, Debug)]
pub(crate) struct Sprung {
    pub measure: Measure,
    pub stiffness: f64,
    pub damping: f64,
}

fn linear(of: Option<&Characteristic>) -> f64 {
    match of {
        Some(Characteristic::Linear(value)) => *value,
        _ => 0.0,
    }
}

/// The measures of one spring of the assembly.
///
/// # Errors
/// [`Error::Place`] for places that have not what the spring needs, or a negative stiffness or damping.
pub(crate) fn sprung(
    name: &str,
    spring: &Spring,
    scene: &Scene,
    dimension: Dimension,
    parts: &[Part],
) -> Result<Vec<Sprung>, Error> {
    let found = match spring {
        Spring::Spring(of) => {
            let location = format!("springs.{name}.spring");
            let [a, b] = ends(&location, [&of.a, &of.b], scene, parts)?;
            let distance = b.position - a.position;
            let length = distance.norm();
            if length <= 0.0 {
                return Err(Error::place(
                    location,
                    "joins two places that coincide, so that it has no direction; use a bushing",
                ));
            }
            let direction = distance / length;
            let mut measure = Measure::default();
            for axis in (0..3).filter(|axis| direction[*axis] != 0.0) {
                measure = measure
                    .plus(direction[axis], &translation(&location, &b, axis, &of.b)?)
                    .plus(-direction[axis], &translation(&location, &a, axis, &of.a)?);
            }
            vec![Sprung {
                measure,
                stiffness: linear(Some(&of.stiffness)),
                damping: linear(Some(&of.damping)),
            }]
        }
        Spring::TorsionSpring(of) => {
            let location = format!("springs.{name}.torsion_spring");
            let joint = scene.joints.get(&of.joint);
            let places = joint.and_then(|joint| joint.attachments());
            let (Some(joint), Some([a, b])) = (joint, places) else {
                return Err(Error::place(
                    location,
                    format!("no joint is called {:?}", of.joint),
                ));
            };
            let [first, second] = ends(&location, [a, b], scene, parts)?;
            let axis = joint.axis().map_or(Vector3::z(), |axis| axis.a);
            let axis = (first.axes * axis).normalize();
            let measure = relative_turn(&location, &first, &second, axis, [a, b], parts)?;
            vec![Sprung {
                measure,
                stiffness: linear(Some(&of.stiffness)),
                damping: linear(Some(&of.damping)),
            }]
        }
        Spring::Bushing(of) => {
            let location = format!("springs.{name}.bushing");
            let [a, b] = ends(&location, [&of.a, &of.b], scene, parts)?;
            let entry = |list: &Option<Vec<Characteristic>>, k: usize| {
                linear(list.as_ref().and_then(|list| list.get(k)))
            };
            let mut all = Vec::new();
            for k in 0..dimension.coordinate_count() {
                let (stiffness, damping) =
                    (entry(&of.translation, k), entry(&of.translation_damping, k));
                if stiffness == 0.0 && damping == 0.0 {
                    continue;
                }
                let direction = a.axes.column(k);
                let mut measure = Measure::default();
                for axis in (0..3).filter(|axis| direction[*axis] != 0.0) {
                    // The point of a that lies at b: a rigid motion of both stretches nothing.
                    let of_a = a
                        .linked(axis, b.position, parts)
                        .ok_or_else(|| lacking(&location, &of.a, axis))?;
                    measure = measure
                        .plus(direction[axis], &translation(&location, &b, axis, &of.b)?)
                        .plus(-direction[axis], &of_a);
                }
                all.push(Sprung {
                    measure,
                    stiffness,
                    damping,
                });
            }
            for (k, about) in rotations(dimension).iter().enumerate() {
                let (stiffness, damping) = (entry(&of.rotation, k), entry(&of.rotation_damping, k));
                if stiffness == 0.0 && damping == 0.0 {
                    continue;
                }
                let direction = a.axes.column(*about).into_owned();
                let measure = relative_turn(&location, &a, &b, direction, [&of.a, &of.b], parts)?;
                all.push(Sprung {
                    measure,
                    stiffness,
                    damping,
                });
            }
            all
        }
    };
    for one in &found {
        for (what, value) in [("stiffness", one.stiffness), ("damping", one.damping)] {
            if value < 0.0 || !value.is_finite() {
                return Err(Error::place(
                    format!("springs.{name}"),
                    format!(
                        "has the {what} {value}; an assembly at rest needs one that is not negative"
                    ),
                ));
            }
        }
    }
    Ok(found)
}

fn ends(
    location: &str,
    names: [&str; 2],
    scene: &Scene,
    parts: &[Part],
) -> Result<[Spot; 2], Error> {
    let [a, b] = names;
    Ok([
        end(location, a, scene, parts)?,
        end(location, b, scene, parts)?,
    ])
}

fn end(location: &str, name: &str, scene: &Scene, parts: &[Part]) -> Result<Spot, Error> {
    refuse_observed(location, name, parts)?;
    let mut place = Place::of(location, name, scene, parts)?;
    match (place.spots.len(), place.spots.pop()) {
        (1, Some(spot)) => Ok(spot),
        (count, _) => Err(Error::place(
            location,
            format!(
                "{name:?} has {count} nodes; a spring needs one place: a frame (kind \"average\" or \"rigid\") or a single node"
            ),
        )),
    }
}

fn translation(location: &str, spot: &Spot, axis: usize, name: &str) -> Result<Measure, Error> {
    spot.translation[axis]
        .clone()
        .ok_or_else(|| lacking(location, name, axis))
}

fn relative_turn(
    location: &str,
    a: &Spot,
    b: &Spot,
    direction: Vector3<f64>,
    names: [&str; 2],
    parts: &[Part],
) -> Result<Measure, Error> {
    let mut measure = Measure::default();
    for axis in (0..3).filter(|axis| direction[*axis] != 0.0) {
        let turning = |spot: &Spot, name: &str| {
            let found = spot.turning(axis, parts);
            found.ok_or_else(|| {
                Error::place(
                    location,
                    format!("{name:?} doesn't turn: it is a point mass"),
                )
            })
        };
        measure = measure
            .plus(direction[axis], &turning(b, names[1])?)
            .plus(-direction[axis], &turning(a, names[0])?);
    }
    Ok(measure)
}
