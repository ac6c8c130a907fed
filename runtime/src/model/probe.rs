//! One recorded quantity: how it is computed from a state.

use std::ops::Range;

use dcb_formats::mesh::Dimension;
use nalgebra::{Rotation3, UnitQuaternion, Vector3};

use super::mass_probe::MassProbe;
use super::moment::Moment;
use super::node_shapes::{Chord, NodeShapes};
use super::stresses::StressProbe;
use crate::kinematics::frame_motion::{FrameMotion, Six};
use crate::measure::Measure;
use crate::system::evaluation::unwound;
use crate::system::marker::{Marker, MarkerPlace, halves, six, turned_back};
use crate::system::state::rates;
use dcb_formats::scene::ReactionAxes;

/// Quantities of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum FrameQuantity {
    Position,
    Displacement,
    Velocity,
    Acceleration,
    Orientation,
    AngularVelocity,
}

/// Quantities of a node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum NodeQuantity {
    /// By the deflection, body axes.
    Displacement,
    /// World axes.
    Position,
    /// World axes.
    Velocity,
    /// World axes.
    Acceleration,
}

/// A quantity.
pub(super) enum Probe {
    /// Of a place.
    Frame(Box<FrameProbe>),
    /// Deflection of a node from a chord.
    Chord { body: usize, chord: Box<Chord> },
    /// Of a node.
    Node {
        body: usize,
        node: Box<NodeShapes>,
        quantity: NodeQuantity,
    },
    /// Of masses.
    Mass(MassProbe),
    /// A joint's coordinate or its rate.
    Coordinate(CoordinateProbe),
    /// Force and moment of rows on their first marker.
    Reaction {
        rows: Range<usize>,
        a: usize,
        b: usize,
        axes: ReactionAxes,
    },
    /// Force on the rows of an interface, body axes.
    InterfaceForce { markers: Vec<usize> },
    /// λ of rows.
    Forces { rows: Range<usize> },
    /// Origin and turn of a body's frame.
    BodyFrame { body: usize },
    /// Forces on the rows of a body's interfaces.
    RowForces { body: usize, rows: usize },
    /// Stress inside a body.
    Stress(Box<StressProbe>),
    /// y of a body.
    Modal { coordinates: Range<usize> },
    /// Kinetic, strain, gravity, springs; drives, loads, dissipated; defect.
    Energy,
    /// The energies that are stored.
    StoredEnergy,
    /// Largest violation of the constraints, positions and velocities; lengths and angles.
    Drift,
    /// Step and iterations.
    Steps,
}

/// A quantity of a frame at a place.
pub(super) struct FrameProbe {
    pub marker: Marker,
    pub quantity: FrameQuantity,
    /// Position as drawn.
    pub at_start: Vector3<f64>,
    /// Where a planar angle is counted past half a turn.
    pub angle: Option<usize>,
}

/// A coordinate of a joint, or its rate.
pub(super) struct CoordinateProbe {
    /// Marker on the first body.
    pub a: usize,
    /// Marker on the second body.
    pub b: usize,
    pub measure: Measure,
    /// Where an angle is counted past half a turn.
    pub angle: Option<usize>,
    /// Value as drawn.
    pub zero: f64,
    pub is_rate: Rate,
}

/// Whether a coordinate or its rate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Rate {
    Value,
    Rate,
}

impl Probe {
    /// Appends the quantity's numbers.
    pub fn write(&mut self, at: &Moment, row: &mut Vec<f64>) {
        let dimension = at.system.dimension;
        match self {
            Self::Frame(frame) => frame.write(at, row),
            Self::Chord { body, chord } => {
                let off = chord.deflection(at, *body);
                match dimension {
                    // Across the chord, to the left of its direction.
                    Dimension::Planar => row.push(Vector3::z().cross(&chord.direction).dot(&off)),
                    Dimension::Spatial => row.extend(off.iter()),
                }
            }
            Self::BodyFrame { body } => {
                let pose = at.state.pose(*body);
                push(row, dimension, &pose.origin);
                match dimension {
                    Dimension::Planar => row.push(pose.axes[(1, 0)].atan2(pose.axes[(0, 0)])),
                    Dimension::Spatial => {
                        let axes = Rotation3::from_matrix_unchecked(pose.axes);
                        let turn = UnitQuaternion::from_rotation_matrix(&axes);
                        row.extend([turn.w, turn.i, turn.j, turn.k]);
                    }
                }
            }
            Self::RowForces { body, rows } => {
                let first = row.len();
                row.resize(first + *rows, 0.0);
                at.evaluation
                    .write_interface_forces(at.system, *body, &mut row[first..]);
            }
            Self::Node {
                body,
                node,
                quantity,
            } => {
                let vector = match quantity {
                    NodeQuantity::Displacement => node.displacement(at, *body),
                    NodeQuantity::Position => node.place(at, *body),
                    NodeQuantity::Velocity => node.velocity(at, *body),
                    NodeQuantity::Acceleration => node.acceleration(at, *body),
                };
                push(row, dimension, &vector);
            }
            Self::Mass(mass) => {
                let vector = mass.value(at);
                match (mass.is_angular(), dimension) {
                    (true, Dimension::Planar) => row.push(vector.z),
                    _ => push(row, dimension, &vector),
                }
            }
            Self::Coordinate(coordinate) => row.push(coordinate.value(at)),
            Self::Reaction { rows, a, b, axes } => {
                let world = reaction(at, rows, *a);
                let wrench = match axes {
                    ReactionAxes::World => world,
                    ReactionAxes::First => turned_back(&at.evaluation.motions[*a].axes, &world),
                    ReactionAxes::Second => turned_back(&at.evaluation.motions[*b].axes, &world),
                };
                push_wrench(row, dimension, &wrench);
            }
            Self::InterfaceForce { markers } => {
                push_wrench(row, dimension, &interface_force(at, markers));
            }
            Self::Forces { rows } => row.extend(&at.state.forces[rows.clone()]),
            Self::Stress(stress) => stress.write(at, row),
            Self::Modal { coordinates } => row.extend(&at.state.coordinates[coordinates.clone()]),
            Self::Energy => {
                let works = at.works;
                row.extend(stored(at));
                row.extend([works.drives, works.loads, works.dissipated, at.defect]);
            }
            Self::StoredEnergy => row.extend(stored(at)),
            Self::Drift => row.extend(drift(at)),
            Self::Steps => row.extend([at.step.0, at.step.1 as f64]),
        }
    }
}

impl FrameProbe {
    fn write(&self, at: &Moment, row: &mut Vec<f64>) {
        let dimension = at.system.dimension;
        let motion = frame_motion(at, &self.marker);
        match (self.quantity, dimension) {
            (FrameQuantity::Position, _) => push(row, dimension, &motion.position),
            (FrameQuantity::Displacement, _) => {
                push(row, dimension, &(motion.position - self.at_start));
            }
            (FrameQuantity::Velocity, _) => push(row, dimension, &motion.velocity),
            (FrameQuantity::Acceleration, _) => push(row, dimension, &motion.acceleration),
            (FrameQuantity::AngularVelocity, Dimension::Planar) => row.push(motion.spin.z),
            (FrameQuantity::AngularVelocity, Dimension::Spatial) => {
                push(row, dimension, &motion.spin);
            }
            (FrameQuantity::Orientation, Dimension::Planar) => {
                let value = motion.axes[(1, 0)].atan2(motion.axes[(0, 0)]);
                row.push(unwound(value, self.angle, &at.state.angles));
            }
            (FrameQuantity::Orientation, Dimension::Spatial) => {
                let turn = nalgebra::UnitQuaternion::from_matrix(&motion.axes);
                row.extend([turn.w, turn.i, turn.j, turn.k]);
            }
        }
    }
}

impl CoordinateProbe {
    fn value(&self, at: &Moment) -> f64 {
        let motions = &at.evaluation.motions;
        let (a, b) = (&motions[self.a], &motions[self.b]);
        match self.is_rate {
            Rate::Rate => self.measure.rate(a, b),
            Rate::Value => {
                let value = self.measure.value(a, b);
                unwound(value, self.angle, &at.state.angles) - self.zero
            }
        }
    }
}

/// Kinetic, strain and gravity energy, and that of springs.
fn stored(at: &Moment) -> [f64; 4] {
    let energy = at.energy;
    [
        energy.kinetic,
        energy.strain,
        energy.gravity,
        energy.springs,
    ]
}

/// Force and moment on the rows of an interface, body axes.
fn interface_force(at: &Moment, markers: &[usize]) -> Six {
    let mut total = Six::zeros();
    for &marker in markers {
        let Some(body) = at.system.markers[marker].body else {
            continue;
        };
        let axes = &at.evaluation.poses[body].axes;
        let wrench = turned_back(axes, &at.evaluation.wrenches[marker]);
        let (force, moment) = halves(&wrench);
        // Conjugate to the rotation rows: J_lᵀ τ.
        let turn = at.evaluation.places[marker].turn_jacobian.tr_mul(&moment);
        total += six(&force, &turn);
    }
    total
}

/// Largest violation of the constraints: of lengths their position and velocity, of angles the same.
fn drift(at: &Moment) -> [f64; 4] {
    let (system, state) = (at.system, at.state);
    let mut largest = [0.0_f64; 4];
    for (index, constraint) in system.rows.iter().enumerate() {
        let defect = at.evaluation.velocity_defect(system, state, index);
        let Some(rate) = defect else { continue };
        let is_length = system.terms[constraint.terms.start].measure.is_length();
        let first = if is_length { 0 } else { 2 };
        largest[first] = largest[first].max(at.evaluation.answers[index].abs());
        largest[first + 1] = largest[first + 1].max(rate.abs());
    }
    largest
}

/// Motion of a frame that no coupling needs, at the state.
fn frame_motion(at: &Moment, marker: &Marker) -> FrameMotion {
    let Some(body) = marker.body else {
        return FrameMotion::at_rest(marker.position, marker.axes);
    };
    let pose = &at.evaluation.poses[body];
    let owner = &at.system.bodies[body];
    let y = &at.state.coordinates[owner.coordinates.clone()];
    let velocities = &at.state.velocities[owner.velocities.clone()];
    let accelerations = &at.state.accelerations[owner.velocities.clone()];
    let extra = at.evaluation.extra(at.system, at.state, marker);
    let mut place = MarkerPlace::of(marker);
    let mut motion = marker.place(pose, y, &extra, &mut place);
    if !owner.residual_rows.is_empty() {
        let rows = owner.residual_rows.clone();
        place.extra_rate = marker.share(&at.state.residual_rates[rows.clone()]);
        place.extra_acceleration = marker.share(&at.state.residual_accelerations[rows]);
    }
    marker.add_velocity(
        &place,
        pose,
        &rates(velocities),
        &velocities[6..],
        &mut motion,
    );
    marker.add_acceleration(
        &place,
        pose,
        (&rates(velocities), &velocities[6..]),
        (&rates(accelerations), &accelerations[6..]),
        &mut motion,
    );
    motion
}

/// Force and moment of rows on a marker, world axes.
fn reaction(at: &Moment, rows: &Range<usize>, marker: usize) -> Six {
    let mut wrench = Six::zeros();
    for index in rows.clone() {
        for term in at.system.rows[index].terms.clone() {
            let gradient = &at.evaluation.gradients[term];
            if at.system.terms[term].a == marker {
                wrench += gradient.a * at.state.forces[index];
            }
            if at.system.terms[term].b == marker {
                wrench += gradient.b * at.state.forces[index];
            }
        }
    }
    wrench
}

fn push(row: &mut Vec<f64>, dimension: Dimension, vector: &Vector3<f64>) {
    let count = dimension.coordinate_count();
    row.extend(&vector.as_slice()[..count]);
}

fn push_wrench(row: &mut Vec<f64>, dimension: Dimension, wrench: &Six) {
    match dimension {
        Dimension::Planar => row.extend([wrench[0], wrench[1], wrench[5]]),
        Dimension::Spatial => row.extend(wrench.iter()),
    }
}
