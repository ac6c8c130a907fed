//! The exact linearization of a mechanism at a state, dense.
//!
//! For variations δq = (Aᵀ δR, δφ, δy) of each body and rows (Aᵀ F_R, F_φ, F_y),
//!
//! ```text
//! δ(inertia + elastic + damping - applied - Bᵀ λ)  =  M δq'' + C δq' + K δq - Bᵀ δλ
//! δ(e - f)                                         =  B δq + c δλ
//! ```
//! B holds the constraints; springs are in K and C. K includes what the forces of constraints, springs and loads change by when
//! frames turn and interfaces move. c is the flexibility of interfaces that follow their forces beside the coordinates; what
//! forces change by when those displacements carry them along is left out, of relative order displacement over length.

mod marker_jacobians;

use faer::Mat;
use nalgebra::{Matrix3, Matrix6};

use marker_jacobians::{MarkerJacobians, Shapes};

use super::condensed::keep_rows_in_world;
use super::evaluation::Evaluation;
use super::marker::{halves, six, turned_back};
use super::residual::row_flexibility;
use super::{Body, Demand, LoadAxes, Row, State, System};
use crate::actuator::{Sense, Timing};
use crate::body::Compatibility;
use crate::error::Error;
use crate::frame::InertiaTangent;
use crate::kinematics::rotation_vector::left_jacobian_transpose_derivative;

/// M, C, K and B.
#[derive(Clone, Debug)]
pub struct Linearization {
    /// M, (N, N) with N the length of velocity arrays.
    pub mass: Mat<f64>,
    /// C, (N, N).
    pub damping: Mat<f64>,
    /// K, (N, N).
    pub stiffness: Mat<f64>,
    /// B, one row for each constraint of `constraints`.
    pub jacobian: Mat<f64>,
    /// c over the constraints; `None` where every displacement is one of coordinates.
    pub compliance: Option<Mat<f64>>,
    /// Rows of the system that are constraints.
    pub constraints: Vec<usize>,
}

impl Linearization {
    /// At a state whose evaluation, velocities of markers included, is up to date.
    ///
    /// # Errors
    /// [`Error::NotHandled`] for bodies of weak compatibility, whose interface forces are coordinates, and for springs on
    /// interfaces that follow their forces beside the coordinates.
    pub fn at(system: &System, state: &State, evaluation: &Evaluation) -> Result<Self, Error> {
        refuse_unhandled(system)?;
        let n = system.velocity_count();
        let constraints = system.constraints();
        let mut this = Self {
            mass: Mat::zeros(n, n),
            damping: Mat::zeros(n, n),
            stiffness: Mat::zeros(n, n),
            jacobian: Mat::zeros(constraints.len(), n),
            compliance: row_flexibility(system, evaluation).map(|all| {
                Mat::from_fn(constraints.len(), constraints.len(), |i, j| {
                    all[(constraints[i], constraints[j])]
                })
            }),
            constraints,
        };
        for body in 0..system.bodies.len() {
            this.add_inertia(system, state, evaluation, body);
            this.add_carried_wrenches(system, evaluation, body);
            this.add_inner_loads(system, state, body);
        }
        let motions = MarkerJacobians::of(system, state, evaluation);
        this.add_rows(system, state, evaluation, &motions);
        this.add_follower_loads(system, state, evaluation, &motions);
        Ok(this)
    }

    /// The same for solvers that take joints as rigid: constraints without compliance of their own.
    ///
    /// # Errors
    /// [`Error::NotHandled`] where interfaces follow their forces beside the coordinates; those of [`Linearization::at`].
    pub fn with_rigid_joints(
        system: &System,
        state: &State,
        evaluation: &Evaluation,
    ) -> Result<Self, Error> {
        let this = Self::at(system, state, evaluation)?;
        let compliant = system
            .bodies
            .iter()
            .find(|body| !body.residual_rows.is_empty());
        match (&this.compliance, compliant) {
            (Some(_), Some(body)) => Err(Error::NotHandled {
                body: body.name.clone(),
                what: "its interfaces follow their forces without inertia, which equilibrium and eigenmodes don't handle",
                remedy: "use strong compatibility",
            }),
            _ => Ok(this),
        }
    }

    fn add_inertia(
        &mut self,
        system: &System,
        state: &State,
        evaluation: &Evaluation,
        index: usize,
    ) {
        let body = &system.bodies[index];
        let n = body.flexible.coordinate_count();
        let (at, acceleration) = system.body_motion(state, &evaluation.poses[index], index);
        let mut tangent = InertiaTangent::for_coordinates(n);
        let (mut elastic_damping, mut elastic_stiffness) = (Mat::zeros(n, n), Mat::zeros(n, n));
        let terms = &evaluation.inertia[index];
        let inertia = &body.flexible.inertia;
        inertia.evaluate_tangent(&at, &acceleration, terms, &mut tangent);
        inertia.write_elastic_tangent(
            &at.spin,
            &acceleration.spin_rate,
            elastic_damping.as_mut(),
            elastic_stiffness.as_mut(),
        );
        keep_rows_in_world(&mut tangent, &evaluation.inertia_forces[index].force_body);
        let first = body.velocities.start;
        for (matrix, block) in [
            (&mut self.mass, &tangent.mass),
            (&mut self.damping, &tangent.damping),
            (&mut self.stiffness, &tangent.stiffness),
        ] {
            for i in 0..6 {
                for j in 0..6 {
                    matrix[(first + i, first + j)] += block.rigid[(i, j)];
                }
                for k in 0..n {
                    matrix[(first + i, first + 6 + k)] += block.rigid_by_elastic[i * n + k];
                    matrix[(first + 6 + k, first + i)] += block.elastic_by_rigid[i * n + k];
                }
            }
        }
        for k in 0..n {
            let stiffness = body.flexible.stiffness[k];
            let entry = (first + 6 + k, first + 6 + k);
            self.mass[entry] += 1.0;
            self.damping[entry] += body.flexible.damping_coefficient(k);
            self.stiffness[entry] += stiffness;
            for l in 0..n {
                self.damping[(first + 6 + k, first + 6 + l)] += elastic_damping[(k, l)];
                self.stiffness[(first + 6 + k, first + 6 + l)] += elastic_stiffness[(k, l)];
            }
        }
    }

    /// How the generalised forces of wrenches that stay in world axes change with the body's coordinates.
    fn add_carried_wrenches(&mut self, system: &System, evaluation: &Evaluation, index: usize) {
        let body = &system.bodies[index];
        let (n, first) = (body.flexible.coordinate_count(), body.velocities.start);
        for &marker in &body.markers {
            let place = &evaluation.places[marker];
            let axes = &evaluation.poses[index].axes;
            let (f, t) = halves(&turned_back(axes, &evaluation.wrenches[marker]));
            let shapes = Shapes::of(system.markers[marker].current_shapes(place), n);
            let by_slot = system.markers[marker].forces_by_slot(place, &six(&f, &t));
            for (slot, stiffening) in &system.markers[marker].stiffening {
                for k in 0..n {
                    for l in 0..n {
                        self.stiffness[(first + 6 + k, first + 6 + l)] +=
                            by_slot[*slot] * stiffening[(k, l)];
                    }
                }
            }
            // F_φ = r × f + τ,  δf = f × δφ,  δτ = τ × δφ,  δr = S_u δy
            let turning = place.arm.cross_matrix() * f.cross_matrix() + t.cross_matrix();
            self.subtract_block(first + 3, first + 3, &turning);
            let share = left_jacobian_transpose_derivative(&place.turn, &t);
            for k in 0..n {
                let (u, o) = (shapes.place(k), shapes.turn(k));
                let moment = u.cross(&f);
                // F_y = S_uᵀ f + S_θᵀ Jᵀ τ
                let own_turn = place.turn_jacobian * o;
                let row = -(f.cross(&u)) - t.cross(&own_turn);
                for i in 0..3 {
                    self.stiffness[(first + 3 + i, first + 6 + k)] -= moment[i];
                    self.stiffness[(first + 6 + k, first + 3 + i)] -= row[i];
                }
                for l in 0..n {
                    let change = o.dot(&(share * shapes.turn(l)));
                    self.stiffness[(first + 6 + k, first + 6 + l)] -= change;
                }
            }
        }
    }

    /// Loads on the inside turn with the body: in rows along world axes δ(A F) = A (δφ × F).
    fn add_inner_loads(&mut self, system: &System, state: &State, index: usize) {
        let first = system.bodies[index].velocities.start;
        for (factor, load) in system.inside(state, index) {
            let turning = -factor * load.force.cross_matrix();
            self.subtract_block(first, first + 3, &turning);
        }
    }

    fn subtract_block(&mut self, row: usize, column: usize, block: &Matrix3<f64>) {
        for i in 0..3 {
            for j in 0..3 {
                self.stiffness[(row + i, column + j)] -= block[(i, j)];
            }
        }
    }

    /// Constraints to B, springs to K and C, and the change of both's gradients to K.
    fn add_rows(
        &mut self,
        system: &System,
        state: &State,
        evaluation: &Evaluation,
        motions: &MarkerJacobians,
    ) {
        let n = system.velocity_count();
        let mut constraint = 0;
        for (index, row) in system.rows.iter().enumerate() {
            let mut gradient = vec![0.0; n];
            let mut rate_gradient = vec![0.0; n];
            for (term, slope) in system.terms[row.terms.clone()]
                .iter()
                .zip(&evaluation.gradients[row.terms.clone()])
            {
                let (a, b) = (&evaluation.motions[term.a], &evaluation.motions[term.b]);
                motions.add_transposed(term.a, &slope.a, &mut gradient);
                motions.add_transposed(term.b, &slope.b, &mut gradient);
                let second = term.measure.gradient_derivative(a, b);
                let (twist_a, twist_b) = (six(&a.velocity, &a.spin), six(&b.velocity, &b.spin));
                let weight = term.weight;
                let of_a = (second.aa.tr_mul(&twist_a) + second.ba.tr_mul(&twist_b)) * weight;
                let of_b = (second.ab.tr_mul(&twist_a) + second.bb.tr_mul(&twist_b)) * weight;
                motions.add_transposed(term.a, &of_a, &mut rate_gradient);
                motions.add_transposed(term.b, &of_b, &mut rate_gradient);
                motions.add_rate_transposed(term.a, &slope.a, &mut rate_gradient);
                motions.add_rate_transposed(term.b, &slope.b, &mut rate_gradient);
                let force = state.forces[index] * weight;
                for (rows, columns, block) in [
                    (term.a, term.a, &second.aa),
                    (term.a, term.b, &second.ab),
                    (term.b, term.a, &second.ba),
                    (term.b, term.b, &second.bb),
                ] {
                    motions.subtract_block(
                        rows,
                        columns,
                        &(block * force),
                        self.stiffness.as_mut(),
                    );
                }
            }
            if let Some(controller) = system.controller_of(row) {
                self.add_control(system, evaluation, motions, controller, &gradient);
            }
            match &row.demand {
                Demand::Answer(_) | Demand::Actuate(_) => {
                    let (by_value, by_rate) = slopes(row, index, evaluation);
                    for i in 0..n {
                        for j in 0..n {
                            self.stiffness[(i, j)] -=
                                gradient[i] * (by_value * gradient[j] + by_rate * rate_gradient[j]);
                            self.damping[(i, j)] -= gradient[i] * by_rate * gradient[j];
                        }
                    }
                }
                Demand::Hold(_) | Demand::Follow(_) => {
                    for (j, entry) in gradient.into_iter().enumerate() {
                        self.jacobian[(constraint, j)] = entry;
                    }
                    constraint += 1;
                }
            }
        }
    }

    /// An effort that follows coordinates of any joints, where `gradient` is that of its own.
    fn add_control(
        &mut self,
        system: &System,
        evaluation: &Evaluation,
        motions: &MarkerJacobians,
        controller: usize,
        gradient: &[f64],
    ) {
        let Timing::Continuous { senses, first } = &system.controllers[controller].timing else {
            return;
        };
        let n = gradient.len();
        let slopes = &evaluation.control_slopes[*first..first + senses.len()];
        for (sense, slope) in senses.iter().zip(slopes) {
            let (Sense::Value(index) | Sense::Rate(index)) = *sense;
            let sensor = &system.sensors[index];
            let found = &evaluation.sensed[index].gradient;
            let (mut by_place, mut by_rate) = (vec![0.0; n], vec![0.0; n]);
            motions.add_transposed(sensor.a, &found.a, &mut by_place);
            motions.add_transposed(sensor.b, &found.b, &mut by_place);
            let (a, b) = (&evaluation.motions[sensor.a], &evaluation.motions[sensor.b]);
            let second = sensor.measure.gradient_derivative(a, b);
            let (twist_a, twist_b) = (six(&a.velocity, &a.spin), six(&b.velocity, &b.spin));
            let of_a = second.aa.tr_mul(&twist_a) + second.ba.tr_mul(&twist_b);
            let of_b = second.ab.tr_mul(&twist_a) + second.bb.tr_mul(&twist_b);
            motions.add_transposed(sensor.a, &of_a, &mut by_rate);
            motions.add_transposed(sensor.b, &of_b, &mut by_rate);
            motions.add_rate_transposed(sensor.a, &found.a, &mut by_rate);
            motions.add_rate_transposed(sensor.b, &found.b, &mut by_rate);
            for (i, along) in gradient.iter().enumerate() {
                let by = along * slope;
                for j in 0..n {
                    match sense {
                        Sense::Value(_) => self.stiffness[(i, j)] -= by * by_place[j],
                        Sense::Rate(_) => {
                            self.stiffness[(i, j)] -= by * by_rate[j];
                            self.damping[(i, j)] -= by * by_place[j];
                        }
                    }
                }
            }
        }
    }

    fn add_follower_loads(
        &mut self,
        system: &System,
        state: &State,
        evaluation: &Evaluation,
        motions: &MarkerJacobians,
    ) {
        for load in &system.loads {
            if load.axes == LoadAxes::Follower {
                let motion = &evaluation.motions[load.marker];
                let (f, t) = halves(&system.load(load, state, motion));
                // δf = δψ × f
                let mut block = Matrix6::zeros();
                let (by_turn, moment) = (-f.cross_matrix(), -t.cross_matrix());
                block.fixed_view_mut::<3, 3>(0, 3).copy_from(&by_turn);
                block.fixed_view_mut::<3, 3>(3, 3).copy_from(&moment);
                let at = load.marker;
                motions.subtract_block(at, at, &block, self.stiffness.as_mut());
            }
        }
    }
}

/// Derivatives of the force of a row that is no constraint, by its measure and by the rate.
fn slopes(row: &Row, index: usize, evaluation: &Evaluation) -> (f64, f64) {
    match &row.demand {
        Demand::Answer(law) => {
            law.derivatives(evaluation.values[index], evaluation.value_rates[index])
        }
        Demand::Actuate(actuator) => {
            let effort = &evaluation.efforts[*actuator];
            (effort.by_value, effort.by_rate)
        }
        Demand::Hold(_) | Demand::Follow(_) => (0.0, 0.0),
    }
}

fn refuse_unhandled(system: &System) -> Result<(), Error> {
    let refused = |body: &Body, what, remedy| Error::NotHandled {
        body: body.name.clone(),
        what,
        remedy,
    };
    for body in &system.bodies {
        if body.flexible.compatibility == Compatibility::Weak {
            let what = "its weak compatibility has no linearization in displacements";
            return Err(refused(body, what, "use strong or static compatibility"));
        }
    }
    for row in &system.rows {
        if row.is_constraint() {
            continue;
        }
        for term in &system.terms[row.terms.clone()] {
            let owners = [term.a, term.b].map(|marker| system.markers[marker].body);
            for body in owners
                .into_iter()
                .flatten()
                .map(|body| &system.bodies[body])
            {
                if !body.residual_rows.is_empty() {
                    let what = "a spring or an actuator acts on an interface that its forces deflect statically";
                    return Err(refused(body, what, "use strong compatibility"));
                }
            }
        }
    }
    Ok(())
}
