//! What joints hold: measures that are zero.

use dcb_formats::mesh::Dimension;
use dcb_formats::scene::{
    ExertedDirections, Joint, JointAxis, OrientationSource, SecondAxis, Side,
};
use nalgebra::{Matrix3, Vector3};

use crate::Error;
use crate::measure::Measure;
use crate::part::Part;
use crate::spot::{Place, Spot, lacking, rotations};

/// A measure that a joint holds at zero.
#[derive(Clone, Debug)]
pub(crate) struct Held {
    pub name: String,
    pub measure: Measure,
}

/// How well two places meet, as drawn.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Meeting {
    /// The joint.
    pub joint: String,
    /// Distance in held directions, length unit.
    pub gap: f64,
    /// The same by the size of the whole.
    pub relative_gap: f64,
    /// Angle between the frames, less the nearest of the 24 turns that map axes to axes, rad; `None` where it says nothing.
    pub angle: Option<f64>,
}

/// Size and limits that joints are judged by.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Fit<'a> {
    pub dimension: Dimension,
    /// Diagonal of the whole.
    pub size: f64,
    /// Gap that is bridged.
    pub allowed: f64,
    pub length_unit: &'a str,
}

/// Angles up to this are told as misalignment, larger ones are meant so.
const MEANT: f64 = 0.1;
/// Angles above this are told, rad.
pub(crate) const TOLD_ANGLE: f64 = 1e-6;

/// The measures that a joint holds.
///
/// # Errors
/// [`Error::Place`] where places don't meet or have not what the joint needs.
pub(crate) fn held(
    name: &str,
    joint: &Joint,
    places: &[Place; 2],
    fit: &Fit<'_>,
    parts: &[Part],
) -> Result<(Vec<Held>, Meeting), Error> {
    let location = format!("joints.{name}.{}", joint.kind());
    let [a, b] = places;
    if a.spots.len() > 1 || b.spots.len() > 1 {
        return match joint {
            Joint::Fixed(_) => nodes(name, &location, places, fit, parts),
            _ => Err(Error::place(
                location,
                format!(
                    "{:?} has several nodes, to which a {} joint can't be; join a frame (kind \"average\" or \"rigid\"), or use a fixed joint",
                    if a.spots.len() > 1 { &a.name } else { &b.name },
                    joint.kind()
                ),
            )),
        };
    }
    let (Some(first), Some(second)) = (a.spots.first(), b.spots.first()) else {
        return Err(Error::place(location, "a place has no rows"));
    };
    let [force, moment] = joint.exerts(Side::A);
    let axis = joint.axis().map(|axis| (axis, first.axes * axis.a));
    let along = axis.as_ref().map(|(_, axis)| axis.normalize());
    let gap_vector = second.position - first.position;
    let translations = match joint {
        Joint::Distance(_) => {
            let length = gap_vector.norm();
            if length <= fit.allowed {
                return Err(Error::place(
                    location,
                    "joins two places that coincide: a distance of zero has no direction; use a spherical (planar: revolute) joint",
                ));
            }
            vec![("distance".to_owned(), gap_vector / length)]
        }
        _ => directions(force, along, fit.dimension, "translation"),
    };
    let turns = match (joint, &axis) {
        (
            Joint::Universal(_),
            Some((
                JointAxis {
                    b: SecondAxis::Given(second_axis),
                    ..
                },
                axis,
            )),
        ) => {
            let normal = axis.cross(&(second.axes * second_axis));
            match normal.norm() > 0.0 {
                true => vec![("rotation".to_owned(), normal.normalize())],
                false => {
                    return Err(Error::place(
                        location,
                        "has parallel axes; those of a universal joint are perpendicular",
                    ));
                }
            }
        }
        (Joint::Revolute(_), _) if fit.dimension == Dimension::Planar => Vec::new(),
        _ => directions(moment, along, fit.dimension, "rotation"),
    };
    if !turns.is_empty() && joint.orientation() != Some(OrientationSource::Body) {
        for (place, spot) in [(a, first), (b, second)] {
            if !spot.turns(fit.dimension) {
                return Err(Error::place(
                    location,
                    format!(
                        "{:?} has no rotation rows that a {} joint needs; make it a frame (kind \"average\" or \"rigid\") with rotations, use a spherical (planar: revolute) joint, or take the body's rotation with \"orientation\": \"body\"",
                        place.name,
                        joint.kind()
                    ),
                ));
            }
        }
    }
    let is_distance = matches!(joint, Joint::Distance(_));
    let gap = match is_distance {
        true => 0.0,
        false => translations
            .iter()
            .map(|(_, d)| d.dot(&gap_vector).powi(2))
            .sum::<f64>()
            .sqrt(),
    };
    let angle =
        misalignment(&first.axes, &second.axes).filter(|_| matches!(joint, Joint::Fixed(_)));
    refuse_gap(&location, a, b, gap, angle, fit)?;
    let mut all = Vec::new();
    for (told, direction) in &translations {
        let mut measure = Measure::default();
        for axis in (0..3).filter(|axis| direction[*axis] != 0.0) {
            let missing = |place: &Place| lacking(&location, &place.name, axis);
            let of_first = first.translation[axis].clone().ok_or_else(|| missing(a))?;
            let of_second = match is_distance {
                true => second.translation[axis].clone(),
                false => second.linked(axis, first.position, parts),
            };
            let of_second = of_second.ok_or_else(|| missing(b))?;
            measure = measure
                .plus(direction[axis], &of_second)
                .plus(-direction[axis], &of_first);
        }
        all.push(Held {
            name: format!("{name}: {told}"),
            measure,
        });
    }
    for (told, direction) in &turns {
        let mut measure = Measure::default();
        for axis in (0..3).filter(|axis| direction[*axis] != 0.0) {
            let turning = |spot: &Spot, place: &Place| {
                let found = spot.turning(axis, parts);
                found.ok_or_else(|| Error::place(&location, format!("{:?} doesn't turn: it is a point mass; use a spherical (planar: revolute) joint", place.name)))
            };
            measure = measure
                .plus(direction[axis], &turning(second, b)?)
                .plus(-direction[axis], &turning(first, a)?);
        }
        all.push(Held {
            name: format!("{name}: {told}"),
            measure,
        });
    }
    let meeting = Meeting {
        joint: name.to_owned(),
        gap,
        relative_gap: gap / fit.size,
        angle,
    };
    Ok((all, meeting))
}

/// Directions of forces or moments with their names.
fn directions(
    of: ExertedDirections,
    along: Option<Vector3<f64>>,
    dimension: Dimension,
    what: &str,
) -> Vec<(String, Vector3<f64>)> {
    let is_rotation = what == "rotation";
    let axes: Vec<usize> = match (is_rotation, dimension) {
        (true, _) => rotations(dimension).to_vec(),
        (false, Dimension::Planar) => vec![0, 1],
        (false, Dimension::Spatial) => vec![0, 1, 2],
    };
    let every = || {
        let named = axes.iter().map(|axis| {
            (
                format!("{what} {}", ["x", "y", "z"][*axis]),
                Vector3::ith(*axis, 1.0),
            )
        });
        named.collect::<Vec<_>>()
    };
    match (of, along) {
        (ExertedDirections::None, _) => Vec::new(),
        (ExertedDirections::All, _) | (_, None) => every(),
        (ExertedDirections::Along, Some(along)) => vec![(format!("{what} along the axis"), along)],
        // In the plane every rotation is across an axis that lies in it.
        (ExertedDirections::Across, Some(_)) if is_rotation && dimension == Dimension::Planar => {
            every()
        }
        (ExertedDirections::Across, Some(along)) => across(along, dimension)
            .into_iter()
            .enumerate()
            .map(|(k, direction)| (format!("{what} across the axis, {}", k + 1), direction))
            .collect(),
    }
}

/// Unit vectors perpendicular to one: one in the plane, two in space.
fn across(along: Vector3<f64>, dimension: Dimension) -> Vec<Vector3<f64>> {
    if dimension == Dimension::Planar {
        return vec![Vector3::new(-along[1], along[0], 0.0)];
    }
    let least = along.iamin();
    let first = along.cross(&Vector3::ith(least, 1.0)).normalize();
    vec![first, along.cross(&first)]
}

/// Nodes to nodes, or nodes to a frame that carries them rigidly.
fn nodes(
    name: &str,
    location: &str,
    [a, b]: &[Place; 2],
    fit: &Fit<'_>,
    parts: &[Part],
) -> Result<(Vec<Held>, Meeting), Error> {
    let mut all = Vec::new();
    let mut worst = 0.0_f64;
    let (carrier, carried) = match (a.spots.len(), b.spots.len()) {
        (1, _) => (a, b),
        (_, 1) => (b, a),
        _ => {
            let pairs = matched(location, a, b, fit)?;
            for (i, (first, second, gap)) in pairs.into_iter().enumerate() {
                worst = worst.max(gap);
                let mut any = false;
                for (is_rotation, own, other) in [
                    (false, &first.translation, &second.translation),
                    (true, &first.rotation, &second.rotation),
                ] {
                    for axis in 0..3 {
                        let (Some(one), Some(_)) = (&own[axis], &other[axis]) else {
                            continue;
                        };
                        let two = match is_rotation {
                            true => second.rotation[axis].clone(),
                            false => second.linked(axis, first.position, parts),
                        };
                        let Some(two) = two else { continue };
                        any = true;
                        let what = if is_rotation {
                            "rotation"
                        } else {
                            "translation"
                        };
                        all.push(Held {
                            name: format!(
                                "{name}: {what} {} of node {}",
                                ["x", "y", "z"][axis],
                                i + 1
                            ),
                            measure: two.plus(-1.0, one),
                        });
                    }
                }
                if !any {
                    return Err(Error::place(
                        location,
                        format!(
                            "{:?} and {:?} have no direction in common at their nodes",
                            a.name, b.name
                        ),
                    ));
                }
            }
            let meeting = Meeting {
                joint: name.to_owned(),
                gap: worst,
                relative_gap: worst / fit.size,
                angle: None,
            };
            return Ok((all, meeting));
        }
    };
    let frame = &carrier.spots[0];
    if !frame.turns(fit.dimension) {
        return Err(Error::place(
            location,
            format!(
                "{:?} carries several nodes and has no rotation rows; make it a frame with rotations",
                carrier.name
            ),
        ));
    }
    let gap = beyond(frame.position, &carried.spots);
    refuse_gap(location, carrier, carried, gap, None, fit)?;
    for (i, node) in carried.spots.iter().enumerate() {
        for axis in 0..3 {
            if let Some(own) = &node.translation[axis]
                && let Some(linked) = frame.linked(axis, node.position, parts)
            {
                all.push(Held {
                    name: format!(
                        "{name}: translation {} of node {}",
                        ["x", "y", "z"][axis],
                        i + 1
                    ),
                    measure: own.clone().plus(-1.0, &linked),
                });
            }
            if let (Some(own), Some(turning)) = (&node.rotation[axis], &frame.rotation[axis]) {
                all.push(Held {
                    name: format!(
                        "{name}: rotation {} of node {}",
                        ["x", "y", "z"][axis],
                        i + 1
                    ),
                    measure: own.clone().plus(-1.0, turning),
                });
            }
        }
    }
    let meeting = Meeting {
        joint: name.to_owned(),
        gap,
        relative_gap: gap / fit.size,
        angle: None,
    };
    Ok((all, meeting))
}

/// How far a frame is outside of the ball about the middle of the nodes that it carries, in which all of them are: a frame may be inside of a ring of nodes, but not away from it.
fn beyond(frame: Vector3<f64>, nodes: &[Spot]) -> f64 {
    let sum: Vector3<f64> = nodes.iter().map(|node| node.position).sum();
    let middle = sum / nodes.len() as f64;
    let from_middle = |place: Vector3<f64>| (place - middle).norm();
    let radius = (nodes.iter())
        .map(|node| from_middle(node.position))
        .fold(0.0, f64::max);
    (from_middle(frame) - radius).max(0.0)
}

/// Each node of `a` with the node of `b` at its place.
fn matched<'s>(
    location: &str,
    a: &'s Place,
    b: &'s Place,
    fit: &Fit<'_>,
) -> Result<Vec<(&'s Spot, &'s Spot, f64)>, Error> {
    if a.spots.len() != b.spots.len() {
        return Err(Error::place(
            location,
            format!(
                "{:?} has {} nodes and {:?} has {}; nodes are joined one to one: mesh both alike, or join frames (kind \"average\" or \"rigid\")",
                a.name,
                a.spots.len(),
                b.name,
                b.spots.len()
            ),
        ));
    }
    let mut free: Vec<&Spot> = b.spots.iter().collect();
    let mut pairs = Vec::with_capacity(a.spots.len());
    for spot in &a.spots {
        let distance = |other: &Spot| (other.position - spot.position).norm();
        let nearest =
            (0..free.len()).min_by(|i, j| distance(free[*i]).total_cmp(&distance(free[*j])));
        let Some(nearest) = nearest else { break };
        let other = free.swap_remove(nearest);
        let gap = distance(other);
        refuse_gap(location, a, b, gap, None, fit)?;
        pairs.push((spot, other, gap));
    }
    Ok(pairs)
}

fn refuse_gap(
    location: &str,
    a: &Place,
    b: &Place,
    gap: f64,
    angle: Option<f64>,
    fit: &Fit<'_>,
) -> Result<(), Error> {
    if gap <= fit.allowed {
        return Ok(());
    }
    let unit = fit.length_unit;
    let turned = angle.filter(|angle| *angle > TOLD_ANGLE).map(|angle| {
        format!(", and their frames are turned by {angle:.1e} rad against each other")
    });
    Err(Error::place(
        location,
        format!(
            "{:?} and {:?} don't meet: they are {gap:.6e} {unit} apart, {:.1e} of the size of the whole ({:.3e} {unit}), allowed {:.1e} {unit}{}; correct `position` and `orientation` (a factor of 1000 is a mix of m and mm), or bridge the gap rigidly with \"allow_gap\"",
            a.name,
            b.name,
            gap / fit.size,
            fit.size,
            fit.allowed,
            turned.unwrap_or_default()
        ),
    ))
}

/// Angle from one frame to the nearest of the 24 right-handed frames along another's axes, where it isn't meant so.
fn misalignment(a: &Matrix3<f64>, b: &Matrix3<f64>) -> Option<f64> {
    let turn = a.transpose() * b;
    // The nearest signed permutation has the largest entry of each column.
    let mut nearest = Matrix3::zeros();
    for column in 0..3 {
        let largest = turn.column(column).iamax();
        nearest[(largest, column)] = turn[(largest, column)].signum();
    }
    let rest = nearest.transpose() * turn;
    let sine = Vector3::new(
        rest[(2, 1)] - rest[(1, 2)],
        rest[(0, 2)] - rest[(2, 0)],
        rest[(1, 0)] - rest[(0, 1)],
    )
    .norm()
        / 2.0;
    let angle = sine.atan2((rest.trace() - 1.0) / 2.0);
    (angle.is_finite() && angle < MEANT).then_some(angle)
}
