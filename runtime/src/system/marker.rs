//! A frame on a body: where joints, springs and loads take hold, and how it moves with the body's coordinates.
//!
//! ```text
//! origin       R + A (x + S_u y)                axes   A exp(skew(S_θ y)) A_0
//! variation    δp = δR + A (δφ × r + S_u δy)    δψ = A (δφ + J_l(θ) S_θ δy)       r = x + S_u y, θ = S_θ y
//! force        F_R = f,   F_φ = r × Aᵀf + Aᵀτ,   F_y = S_uᵀ Aᵀf + S_θᵀ J_lᵀ Aᵀτ
//! ```
//! with δφ the turn of the body frame in its own axes, `δA = A skew(δφ)`. Under geometric stiffening displacement and turn are S y − ½ yᵀ K y
//! row by row, and S − (K y)ᵀ stands for S in variations, rates and forces: the force of a row then stiffens the body by K, and does
//! its work on the motion that it belongs to.

use faer::Mat;
use nalgebra::{Matrix3, Rotation3, Vector3};

use super::number::{Number, crossed, rotated, rotated_back};
use crate::kinematics::frame_motion::{FrameMotion, Six, SixOf};
use crate::kinematics::rotation_vector::{left_jacobian, left_jacobian_rate};

/// Motion of a marker by the body's deflection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Elasticity {
    /// Nothing: a point of a rigid body.
    Rigid,
    /// Its place only: its axes are the body frame's.
    Place,
    /// Place and axes.
    PlaceAndAxes,
}

/// A frame on a body, or on the ground.
#[derive(Clone, Debug, PartialEq)]
pub struct Marker {
    /// The body it belongs to; `None` for the ground.
    pub body: Option<usize>,
    /// The interface of the body; `None` for the ground.
    pub interface: Option<usize>,
    /// Origin at rest, body frame (ground: world).
    pub position: Vector3<f64>,
    /// Axes at rest, to body axes (ground: world).
    pub axes: Matrix3<f64>,
    /// S_uᵀ and S_θᵀ, (n, 6) by columns, 1/√mass and 1/(√mass·length).
    pub shapes: Vec<f64>,
    /// Meaning of `shapes`.
    pub elasticity: Elasticity,
    /// Geometric stiffness K per unit force along a slot of the six, (n, n), where there is any.
    pub stiffening: Vec<(usize, Mat<f64>)>,
    /// Rows of the body's interfaces that are the marker's displacement and turn along the body axes, where there are any.
    pub rows: [Option<usize>; 6],
}

/// A marker at one configuration of its body.
#[derive(Clone, Debug, PartialEq)]
pub struct MarkerPlace {
    /// r, from the body frame's origin, body axes.
    pub arm: Vector3<f64>,
    /// θ, the frame's own turn, body axes.
    pub turn: Vector3<f64>,
    /// J_l(θ).
    pub turn_jacobian: Matrix3<f64>,
    /// Rates of the displacement and turn beside those of the coordinates, body axes.
    pub extra_rate: Six,
    /// Second rates of the same.
    pub extra_acceleration: Six,
    /// Sᵀ − K y, (n, 6) by columns, under geometric stiffening; empty where S doesn't change.
    pub shapes: Vec<f64>,
}

impl MarkerPlace {
    /// Of a marker of a body of n coordinates, nowhere yet.
    pub fn of(marker: &Marker) -> Self {
        let room = match marker.stiffening.is_empty() {
            true => 0,
            false => marker.shapes.len(),
        };
        Self {
            arm: Vector3::zeros(),
            turn: Vector3::zeros(),
            turn_jacobian: Matrix3::identity(),
            extra_rate: Six::zeros(),
            extra_acceleration: Six::zeros(),
            shapes: vec![0.0; room],
        }
    }
}

/// Pose of a body frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyPose {
    /// R, world.
    pub origin: Vector3<f64>,
    /// A, body axes to world axes.
    pub axes: Matrix3<f64>,
}

/// Velocities or accelerations of a body frame: V or V' in world axes, ω or ω' in body axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyRates {
    /// World axes.
    pub linear: Vector3<f64>,
    /// Body axes.
    pub angular: Vector3<f64>,
}

impl Marker {
    /// A frame that belongs to the ground.
    pub fn on_ground(position: Vector3<f64>, axes: Matrix3<f64>) -> Self {
        Self {
            body: None,
            interface: None,
            position,
            axes,
            shapes: Vec::new(),
            elasticity: Elasticity::Rigid,
            stiffening: Vec::new(),
            rows: [None; 6],
        }
    }

    /// The frame of a body.
    pub fn on_body(body: usize) -> Self {
        Self {
            body: Some(body),
            ..Self::on_ground(Vector3::zeros(), Matrix3::identity())
        }
    }

    /// Displacement and turn at the coordinates y, body axes.
    pub fn displacement(&self, y: &[f64]) -> (Vector3<f64>, Vector3<f64>) {
        let mut six = self.products(&self.shapes, y);
        for (slot, matrix) in &self.stiffening {
            six[*slot] -= 0.5 * quadratic(matrix, y);
        }
        halves(&six)
    }

    /// S and, under geometric stiffening, S − (K y)ᵀ.
    pub fn current_shapes<'a>(&'a self, place: &'a MarkerPlace) -> &'a [f64] {
        match place.shapes.is_empty() {
            true => &self.shapes,
            false => &place.shapes,
        }
    }

    fn products<T: Number>(&self, shapes: &[f64], x: &[T]) -> SixOf<T> {
        let mut six = [T::of(0.0); 6];
        match self.elasticity {
            Elasticity::Rigid => {}
            Elasticity::Place => T::add_products(&mut six[..3], &shapes[..3 * x.len()], x),
            Elasticity::PlaceAndAxes => T::add_products(&mut six, shapes, x),
        }
        SixOf::from(six)
    }

    /// Brings the shapes of a place up to the coordinates y.
    fn stiffen(&self, y: &[f64], place: &mut MarkerPlace) {
        if self.stiffening.is_empty() {
            return;
        }
        place.shapes.copy_from_slice(&self.shapes);
        let n = y.len();
        for (slot, matrix) in &self.stiffening {
            let row = &mut place.shapes[slot * n..(slot + 1) * n];
            for (column, y) in matrix.col_iter().zip(y) {
                for (entry, k) in row.iter_mut().zip(column.iter()) {
                    *entry -= k * y;
                }
            }
        }
    }

    /// Rates of displacement and turn, those beside the coordinates included.
    pub fn with_extra(
        &self,
        place: &MarkerPlace,
        y_rates: &[f64],
        extra: &Six,
    ) -> (Vector3<f64>, Vector3<f64>) {
        let (displacement, turn) = halves(&self.products(self.current_shapes(place), y_rates));
        let (extra_displacement, extra_turn) = halves(extra);
        (displacement + extra_displacement, turn + extra_turn)
    }

    /// The marker's share of values by rows of the body's interfaces.
    pub fn share<T: Number>(&self, values: &[T]) -> SixOf<T> {
        SixOf::from_fn(|slot, _| self.rows[slot].map_or(T::of(0.0), |row| values[row]))
    }

    /// Wrench `(f, τ)` in body axes on the slots of displacement and turn: `(f, J_lᵀ τ)`.
    pub fn forces_by_slot<T: Number>(&self, place: &MarkerPlace, wrench: &SixOf<T>) -> SixOf<T> {
        let (force, torque) = halves(wrench);
        six(&force, &rotated_back(&place.turn_jacobian, &torque))
    }

    /// Adds it on the rows of the body's interfaces.
    pub fn add_interface_forces<T: Number>(
        &self,
        place: &MarkerPlace,
        wrench: &SixOf<T>,
        forces: &mut [T],
    ) {
        let own = self.forces_by_slot(place, wrench);
        for (slot, row) in self.rows.iter().enumerate() {
            if let Some(row) = row {
                forces[*row] += own[slot];
            }
        }
    }

    /// `(δp, δψ)` in body axes of displacements by rows of the body's interfaces: `(δu, J_l δθ)`.
    pub fn interface_twist<T: Number>(&self, place: &MarkerPlace, displacements: &[T]) -> SixOf<T> {
        let (displacement, turn) = halves(&self.share(displacements));
        six(&displacement, &rotated(&place.turn_jacobian, &turn))
    }

    /// Brings `place`, where the marker is on its body, up to date; returns its motion at rest. `extra` is a displacement and turn of the interface (body
    /// axes) beside those of the coordinates.
    pub fn place(
        &self,
        pose: &BodyPose,
        y: &[f64],
        extra: &Six,
        place: &mut MarkerPlace,
    ) -> FrameMotion {
        self.stiffen(y, place);
        let (displacement, turn) = self.displacement(y);
        let (extra_displacement, extra_turn) = halves(extra);
        place.arm = self.position + displacement + extra_displacement;
        place.extra_rate = Six::zeros();
        place.extra_acceleration = Six::zeros();
        let origin = pose.origin + pose.axes * place.arm;
        if self.elasticity != Elasticity::PlaceAndAxes {
            place.turn = Vector3::zeros();
            place.turn_jacobian = Matrix3::identity();
            return FrameMotion::at_rest(origin, pose.axes * self.axes);
        }
        place.turn = turn + extra_turn;
        place.turn_jacobian = left_jacobian(&place.turn);
        let turned = Rotation3::new(place.turn).into_inner() * self.axes;
        FrameMotion::at_rest(origin, pose.axes * turned)
    }

    /// Fills in velocity and spin.
    pub fn add_velocity(
        &self,
        place: &MarkerPlace,
        pose: &BodyPose,
        rates: &BodyRates,
        y_rates: &[f64],
        motion: &mut FrameMotion,
    ) {
        let (displacement, turn) = self.with_extra(place, y_rates, &place.extra_rate);
        motion.velocity =
            rates.linear + pose.axes * (rates.angular.cross(&place.arm) + displacement);
        motion.spin = pose.axes * (rates.angular + place.turn_jacobian * turn);
    }

    /// Fills in the accelerations, all velocity products included.
    pub fn add_acceleration(
        &self,
        place: &MarkerPlace,
        pose: &BodyPose,
        (rates, y_rates): (&BodyRates, &[f64]),
        (accelerations, y_accelerations): (&BodyRates, &[f64]),
        motion: &mut FrameMotion,
    ) {
        let (u_rate, turn_rate) = self.with_extra(place, y_rates, &place.extra_rate);
        let mut extra = place.extra_acceleration;
        for (slot, matrix) in &self.stiffening {
            extra[*slot] -= quadratic(matrix, y_rates);
        }
        let (u_second, turn_second) = self.with_extra(place, y_accelerations, &extra);
        let (spin, spin_rate) = (rates.angular, accelerations.angular);
        let arm = spin_rate.cross(&place.arm)
            + spin.cross(&(spin.cross(&place.arm) + u_rate * 2.0))
            + u_second;
        motion.acceleration = accelerations.linear + pose.axes * arm;
        let own = place.turn_jacobian * turn_rate;
        let own_rate =
            place.turn_jacobian * turn_second + left_jacobian_rate(&place.turn, &turn_rate);
        motion.spin_rate = pose.axes * (spin_rate + own_rate + spin.cross(&own));
    }

    /// `(δp, δψ)` in body axes of a variation `(Aᵀ δR, δφ)` and δy.
    pub fn twist<T: Number>(&self, place: &MarkerPlace, rigid: &SixOf<T>, y: &[T]) -> SixOf<T> {
        let (origin, turn) = halves(rigid);
        let (displacement, own_turn) = halves(&self.products(self.current_shapes(place), y));
        six(
            &(origin + crossed(&turn, &place.arm) + displacement),
            &(turn + rotated(&place.turn_jacobian, &own_turn)),
        )
    }

    /// Adds the generalised force of a wrench `(f, τ)` in body axes: rows `(Aᵀ F_R, F_φ)` and F_y, times `factor`.
    pub fn add_force<T: Number>(
        &self,
        place: &MarkerPlace,
        wrench: &SixOf<T>,
        factor: f64,
        rigid: &mut SixOf<T>,
        elastic: &mut [T],
    ) {
        let (force, torque) = halves(wrench);
        let moment = torque - crossed(&force, &place.arm);
        *rigid += six(&force, &moment).map(|entry| entry.times(factor));
        let n = elastic.len();
        let shapes = self.current_shapes(place);
        match self.elasticity {
            Elasticity::Rigid => {}
            Elasticity::Place => {
                let own = force.map(|entry| entry.times(factor));
                T::add_columns(elastic, &shapes[..3 * n], own.as_slice());
            }
            Elasticity::PlaceAndAxes => {
                let own = six(&force, &rotated_back(&place.turn_jacobian, &torque));
                let own = own.map(|entry| entry.times(factor));
                T::add_columns(elastic, shapes, own.as_slice());
            }
        }
    }
}

/// `xᵀ K x`
fn quadratic(matrix: &Mat<f64>, x: &[f64]) -> f64 {
    let columns = matrix.col_iter().zip(x);
    columns
        .map(|(column, x_k)| x_k * column.iter().zip(x).map(|(k, x)| k * x).sum::<f64>())
        .sum()
}

/// Both halves in other axes.
pub fn turned<T: Number>(axes: &Matrix3<f64>, six_in: &SixOf<T>) -> SixOf<T> {
    let (first, second) = halves(six_in);
    six(&rotated(axes, &first), &rotated(axes, &second))
}

/// Both halves from world axes to the axes given.
pub fn turned_back<T: Number>(axes: &Matrix3<f64>, six_in: &SixOf<T>) -> SixOf<T> {
    let (first, second) = halves(six_in);
    six(&rotated_back(axes, &first), &rotated_back(axes, &second))
}

/// Two threes as one six.
pub fn six<T: Number>(first: &Vector3<T>, second: &Vector3<T>) -> SixOf<T> {
    SixOf::from([
        first[0], first[1], first[2], second[0], second[1], second[2],
    ])
}

/// One six as two threes.
pub fn halves<T: Number>(six: &SixOf<T>) -> (Vector3<T>, Vector3<T>) {
    (
        Vector3::from([six[0], six[1], six[2]]),
        Vector3::from([six[3], six[4], six[5]]),
    )
}
