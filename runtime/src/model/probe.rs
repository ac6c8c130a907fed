//! One recorded quantity: how it is computed from a state.

use std::ops::Range;

use dcb_formats::mesh::Dimension;
use faer::Mat;
use nalgebra::Vector3;

use super::library::FieldsOfNode;
use crate::body::{Compatibility, FlexibleBody};
use crate::energy::{Energy, Works};
use crate::kinematics::frame_motion::{FrameMotion, Six};
use crate::measure::Measure;
use crate::system::evaluation::{Evaluation, unwound};
use crate::system::marker::{Marker, MarkerPlace, halves, turned_back};
use crate::system::state::rates;
use crate::system::{State, System};
use dcb_formats::scene::ReactionAxes;

/// What quantities are computed from: a state, and everything that depends on it.
#[derive(Clone, Copy)]
pub(super) struct Moment<'a> {
    pub system: &'a System,
    pub state: &'a State,
    /// Up to date, with velocities and accelerations of the markers.
    pub evaluation: &'a Evaluation,
    pub energy: &'a Energy,
    pub works: &'a Works,
    /// Defect of the energy balance.
    pub defect: f64,
    /// Size of the last step, and the iterations that it took.
    pub step: (f64, usize),
}

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

/// A quantity.
pub(super) enum Probe {
    /// Of a place; `at_start` is its position as drawn.
    Frame {
        marker: Box<Marker>,
        quantity: FrameQuantity,
        at_start: Vector3<f64>,
        /// Where a planar angle is counted past half a turn.
        angle: Option<usize>,
    },
    /// Deflection of a node from a chord.
    Chord { body: usize, chord: Box<Chord> },
    /// Elastic displacement of a node, body axes.
    NodeDisplacement { body: usize, node: NodeShapes },
    /// Position of a node, world axes.
    NodePosition { body: usize, node: NodeShapes },
    /// A joint's coordinate or its rate.
    Coordinate {
        a: usize,
        b: usize,
        measure: Measure,
        angle: Option<usize>,
        zero: f64,
        is_rate: Rate,
    },
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

/// Whether a coordinate or its rate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Rate {
    Value,
    Rate,
}

/// Displacement of one node by the coordinates.
#[derive(Clone, Debug)]
pub(super) struct NodeShapes {
    /// At rest from the centre of mass, body axes.
    position: Vector3<f64>,
    /// By axes, (n) each.
    shapes: [Vec<f64>; 3],
    /// G_res L_bᵀ at the node by axes, (n_b) each, where interface forces deflect the body beside the coordinates; else empty.
    residual: [Vec<f64>; 3],
}

impl NodeShapes {
    /// Of the node whose fields these are.
    pub fn of(body: &FlexibleBody, fields: &FieldsOfNode) -> Self {
        let basis = &fields.basis;
        let mut shapes = [(); 3].map(|()| vec![0.0; body.coordinate_count()]);
        let rows = match body.compatibility {
            Compatibility::Static => body.rows.len(),
            Compatibility::Strong | Compatibility::Weak => 0,
        };
        let mut residual = [(); 3].map(|()| vec![0.0; rows]);
        for (row, dof) in basis.dofs.iter().enumerate() {
            if dof.direction.is_rotation() {
                continue;
            }
            let own = &mut residual[dof.direction.axis()];
            for (b, entry) in own.iter_mut().enumerate() {
                *entry = basis.residual[(row, b)];
            }
            let shape = &mut shapes[dof.direction.axis()];
            for (k, entry) in shape.iter_mut().enumerate() {
                *entry = if k < body.mode_count {
                    basis.modes[(row, k)]
                } else {
                    let at_row = |fields: &Mat<f64>, transform: &Mat<f64>| -> f64 {
                        let column = transform.col(k - body.mode_count);
                        (0..column.nrows())
                            .map(|b| fields[(row, b)] * column[b])
                            .sum()
                    };
                    let further = basis.enrichment.as_ref();
                    at_row(&basis.residual, &body.attachment_transform)
                        + further.map_or(0.0, |fields| at_row(fields, &body.further_transform))
                };
            }
        }
        Self {
            position: Vector3::from(fields.position) - Vector3::from(body.origin),
            shapes,
            residual,
        }
    }

    /// u, body axes, of a node of body `index`.
    fn displacement(&self, at: &Moment, index: usize) -> Vector3<f64> {
        let body = &at.system.bodies[index];
        let y = &at.state.coordinates[body.coordinates.clone()];
        let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let mut u = Vector3::from_fn(|axis, _| product(&self.shapes[axis], y));
        if !self.residual[0].is_empty() {
            let mut forces = vec![0.0; self.residual[0].len()];
            at.evaluation
                .write_interface_forces(at.system, index, &mut forces);
            u += Vector3::from_fn(|axis, _| product(&self.residual[axis], &forces));
        }
        u
    }
}

/// A node between two interfaces.
#[derive(Clone, Debug)]
pub(super) struct Chord {
    node: NodeShapes,
    ends: [Marker; 2],
    /// Where the node is along the chord, 0 to 1.
    fraction: f64,
    direction: Vector3<f64>,
    length: f64,
}

impl Chord {
    /// `None` if the ends coincide.
    pub fn between(node: NodeShapes, ends: [Marker; 2]) -> Option<Self> {
        let chord = ends[1].position - ends[0].position;
        let length = chord.norm();
        (length > 0.0).then(|| {
            let direction = chord / length;
            Self {
                fraction: direction.dot(&(node.position - ends[0].position)) / length,
                node,
                ends,
                direction,
                length,
            }
        })
    }

    /// Deflection across the chord, divided by its length, body axes.
    fn deflection(&self, at: &Moment, index: usize) -> Vector3<f64> {
        let body = &at.system.bodies[index];
        let y = &at.state.coordinates[body.coordinates.clone()];
        let [a, b] = self.ends.each_ref().map(|end| {
            let extra = at.evaluation.extra(at.system, at.state, end);
            end.displacement(y).0 + halves(&extra).0
        });
        let node = self.node.displacement(at, index);
        let off = node - a * (1.0 - self.fraction) - b * self.fraction;
        (off - self.direction * self.direction.dot(&off)) / self.length
    }
}

impl Probe {
    /// Appends the quantity's numbers.
    pub fn write(&mut self, at: &Moment, row: &mut Vec<f64>) {
        let dimension = at.system.dimension;
        match self {
            Self::Frame {
                marker,
                quantity,
                at_start,
                angle,
            } => {
                let motion = frame_motion(at, marker);
                match (quantity, dimension) {
                    (FrameQuantity::Position, _) => push(row, dimension, &motion.position),
                    (FrameQuantity::Displacement, _) => {
                        push(row, dimension, &(motion.position - *at_start));
                    }
                    (FrameQuantity::Velocity, _) => push(row, dimension, &motion.velocity),
                    (FrameQuantity::Acceleration, _) => push(row, dimension, &motion.acceleration),
                    (FrameQuantity::AngularVelocity, Dimension::Planar) => row.push(motion.spin.z),
                    (FrameQuantity::AngularVelocity, Dimension::Spatial) => {
                        push(row, dimension, &motion.spin);
                    }
                    (FrameQuantity::Orientation, Dimension::Planar) => {
                        let value = motion.axes[(1, 0)].atan2(motion.axes[(0, 0)]);
                        row.push(unwound(value, *angle, &at.state.angles));
                    }
                    (FrameQuantity::Orientation, Dimension::Spatial) => {
                        let turn = nalgebra::UnitQuaternion::from_matrix(&motion.axes);
                        row.extend([turn.w, turn.i, turn.j, turn.k]);
                    }
                }
            }
            Self::Chord { body, chord } => {
                let off = chord.deflection(at, *body);
                match dimension {
                    // Across the chord, to the left of its direction.
                    Dimension::Planar => row.push(Vector3::z().cross(&chord.direction).dot(&off)),
                    Dimension::Spatial => row.extend(off.iter()),
                }
            }
            Self::NodeDisplacement { body, node } => {
                push(row, dimension, &node.displacement(at, *body));
            }
            Self::NodePosition { body, node } => {
                let pose = &at.evaluation.poses[*body];
                let u = node.displacement(at, *body);
                push(
                    row,
                    dimension,
                    &(pose.origin + pose.axes * (node.position + u)),
                );
            }
            Self::Coordinate {
                a,
                b,
                measure,
                angle,
                zero,
                is_rate,
            } => {
                let (a, b) = (&at.evaluation.motions[*a], &at.evaluation.motions[*b]);
                row.push(match is_rate {
                    Rate::Rate => measure.rate(a, b),
                    Rate::Value => unwound(measure.value(a, b), *angle, &at.state.angles) - *zero,
                });
            }
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
                let mut total = Six::zeros();
                for &marker in &*markers {
                    let Some(body) = at.system.markers[marker].body else {
                        continue;
                    };
                    let axes = &at.evaluation.poses[body].axes;
                    let wrench = turned_back(axes, &at.evaluation.wrenches[marker]);
                    let (force, moment) = halves(&wrench);
                    // Conjugate to the rotation rows: J_lᵀ τ.
                    let turn = at.evaluation.places[marker].turn_jacobian.tr_mul(&moment);
                    total += crate::system::marker::six(&force, &turn);
                }
                push_wrench(row, dimension, &total);
            }
            Self::Forces { rows } => row.extend(&at.state.forces[rows.clone()]),
            Self::Modal { coordinates } => row.extend(&at.state.coordinates[coordinates.clone()]),
            Self::Energy => row.extend([
                at.energy.kinetic,
                at.energy.strain,
                at.energy.gravity,
                at.energy.springs,
                at.works.drives,
                at.works.loads,
                at.works.dissipated,
                at.defect,
            ]),
            Self::StoredEnergy => row.extend([
                at.energy.kinetic,
                at.energy.strain,
                at.energy.gravity,
                at.energy.springs,
            ]),
            Self::Drift => {
                let (system, state) = (at.system, at.state);
                // Of lengths: positions, velocities; of angles: the same.
                let mut largest = [0.0_f64; 4];
                for (index, constraint) in system.rows.iter().enumerate() {
                    let defect = at.evaluation.velocity_defect(system, state, index);
                    let Some(rate) = defect else { continue };
                    let is_length = system.terms[constraint.terms.start].measure.is_length();
                    let first = if is_length { 0 } else { 2 };
                    largest[first] = largest[first].max(at.evaluation.answers[index].abs());
                    largest[first + 1] = largest[first + 1].max(rate.abs());
                }
                row.extend(largest);
            }
            Self::Steps => row.extend([at.step.0, at.step.1 as f64]),
        }
    }
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
