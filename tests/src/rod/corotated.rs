//! A planar flexible rod between a crank that turns as prescribed and a slider: the classical co-rotated equations with all
//! their unknowns, solved for the accelerations and integrated by extrapolation. An oracle that shares nothing with the runtime.
//!
//! ```text
//! m R''      + A (θ'' J p - θ'² p + 2 θ' J p' + L1 y'')                                           = forces
//! (J p)·AᵀR'' + (I + 2 I1 y + yᵀ M y) θ'' + (I3 + yᵀ L3) y'' + 2 θ' (I1 + yᵀ M) y'               = moments
//! L1ᵀ AᵀR''  + (I3ᵀ + L3ᵀ y) θ'' + M y'' - θ'² (I1ᵀ + M y) - 2 θ' L3 y' + K y                    = forces on y
//! ```
//! with p = L1 y and J a quarter turn. The slider's mass sits at the rod's end b. Constraints: end a on the crank pin, end b
//! on the x axis. They are differentiated twice; the integration is so accurate that they don't drift.

use nalgebra::{DMatrix, DVector, Matrix2, RowDVector, Vector2};

/// One end of the rod.
#[derive(Clone, Debug)]
pub struct RodEnd {
    /// From the centre of mass at rest, body axes.
    pub position: Vector2<f64>,
    /// Displacement of unit coordinates, (2, n).
    pub shapes: DMatrix<f64>,
}

/// A rod over n coordinates of any kind, about its centre of mass at rest.
#[derive(Clone, Debug)]
pub struct CorotatedRod {
    /// m.
    pub mass: f64,
    /// I of the undeformed rod.
    pub inertia: f64,
    /// L1 = ∫ρ ψ, (2, n).
    pub l1: DMatrix<f64>,
    /// I1 = ∫ρ x·ψ, (n).
    pub i1: RowDVector<f64>,
    /// I3 = ∫ρ x×ψ, (n).
    pub i3: RowDVector<f64>,
    /// L3 = ∫ρ ψ_k×ψ_l, (n, n).
    pub l3: DMatrix<f64>,
    /// M, (n, n).
    pub reduced_mass: DMatrix<f64>,
    /// K, (n, n).
    pub stiffness: DMatrix<f64>,
    /// Ends a and b.
    pub ends: [RodEnd; 2],
}

/// The mechanism around the rod.
#[derive(Clone, Debug)]
pub struct CorotatedSliderCrank {
    /// The rod.
    pub rod: CorotatedRod,
    /// Length of the crank.
    pub crank: f64,
    /// Its angle is `speed t`.
    pub speed: f64,
    /// Mass of the slider.
    pub slider: f64,
}

/// Position and velocity: (R, θ, y) and its rates.
#[derive(Clone, Debug)]
pub struct Motion {
    /// Time.
    pub time: f64,
    /// R, θ, y.
    pub position: DVector<f64>,
    /// Rates of them.
    pub velocity: DVector<f64>,
}

/// What the constraints do: forces of the crank pin on the rod, force of the guide on its end b.
pub type Reactions = DVector<f64>;

/// Substeps of the midpoint rules that one step extrapolates from: order 10.
const SUBSTEPS: [usize; 5] = [2, 4, 6, 8, 10];

impl CorotatedSliderCrank {
    /// The start with the crank along x and the rod's frame with it, at coordinates `y` with `rates` and the spin of the rod.
    pub fn start(&self, y: &[f64], rates: &[f64], spin: f64) -> Motion {
        let end = &self.rod.ends[0];
        let (y, rates) = (
            DVector::from_column_slice(y),
            DVector::from_column_slice(rates),
        );
        let arm = end.position + Vector2::from_iterator((&end.shapes * &y).iter().copied());
        let moving = Vector2::from_iterator((&end.shapes * &rates).iter().copied());
        let origin = Vector2::new(self.crank, 0.0) - arm;
        let velocity =
            Vector2::new(0.0, self.crank * self.speed) - moving - spin * quarter_turn() * arm;
        let joined = |rigid: Vector2<f64>, angle: f64, coordinates: &DVector<f64>| {
            let all = [rigid.x, rigid.y, angle].into_iter();
            let all: Vec<f64> = all.chain(coordinates.iter().copied()).collect();
            DVector::from_vec(all)
        };
        Motion {
            time: 0.0,
            position: joined(origin, 0.0, &y),
            velocity: joined(velocity, spin, &rates),
        }
    }

    /// Accelerations and the three forces of the constraints at a motion.
    pub fn accelerations(&self, motion: &Motion) -> (DVector<f64>, Reactions) {
        let rod = &self.rod;
        let n = rod.i1.len();
        let theta = motion.position[2];
        let spin = motion.velocity[2];
        let y = motion.position.rows(3, n);
        let rates = motion.velocity.rows(3, n);
        let turn = Matrix2::new(theta.cos(), -theta.sin(), theta.sin(), theta.cos());
        let quarter = quarter_turn();
        let (p, dp) = (&rod.l1 * y, &rod.l1 * rates);
        let my = &rod.reduced_mass * y;
        let turned_l1 = turn * &rod.l1;
        let jp = turn * quarter * &p;
        let coupling = &rod.i3 + y.transpose() * &rod.l3;

        let mut system = DMatrix::zeros(n + 6, n + 6);
        let mut right = DVector::zeros(n + 6);
        for i in 0..2 {
            system[(i, i)] = rod.mass;
            system[(i, 2)] = jp[i];
            system[(2, i)] = jp[i];
            for k in 0..n {
                system[(i, 3 + k)] = turned_l1[(i, k)];
                system[(3 + k, i)] = turned_l1[(i, k)];
            }
        }
        system[(2, 2)] = rod.inertia + 2.0 * (&rod.i1 * y)[0] + y.dot(&my);
        for k in 0..n {
            system[(2, 3 + k)] = coupling[k];
            system[(3 + k, 2)] = coupling[k];
        }
        system.view_mut((3, 3), (n, n)).copy_from(&rod.reduced_mass);
        let centrifugal = turn * (spin * spin * p - 2.0 * spin * quarter * dp);
        right.rows_mut(0, 2).copy_from(&centrifugal);
        right[2] = -2.0 * spin * ((&rod.i1 * rates)[0] + rates.dot(&my));
        let elastic = spin * spin * (rod.i1.transpose() + my) + 2.0 * spin * &rod.l3 * rates
            - &rod.stiffness * y;
        right.rows_mut(3, n).copy_from(&elastic);

        let [(a, bias_a), (b, bias_b)] = [0, 1].map(|end| self.point(end, motion));
        // The slider moves with end b along x.
        let along: DVector<f64> = b.row(0).transpose();
        for i in 0..n + 3 {
            for j in 0..n + 3 {
                system[(i, j)] += self.slider * along[i] * along[j];
            }
            right[i] -= self.slider * along[i] * bias_b.x;
        }
        let angle = self.speed * motion.time;
        let pin = -self.crank * self.speed * self.speed * Vector2::new(angle.cos(), angle.sin());
        for (row, (gradient, target)) in [
            (a.row(0), pin.x - bias_a.x),
            (a.row(1), pin.y - bias_a.y),
            (b.row(1), -bias_b.y),
        ]
        .into_iter()
        .enumerate()
        {
            for k in 0..n + 3 {
                system[(n + 3 + row, k)] = gradient[k];
                system[(k, n + 3 + row)] = -gradient[k];
            }
            right[n + 3 + row] = target;
        }
        let solution = system.lu().solve(&right).expect("a regular system");
        (
            solution.rows(0, n + 3).into_owned(),
            solution.rows(n + 3, 3).into_owned(),
        )
    }

    /// Gradient of an end's position (2, n + 3), and its acceleration at zero second rates.
    fn point(&self, end: usize, motion: &Motion) -> (DMatrix<f64>, Vector2<f64>) {
        let end = &self.rod.ends[end];
        let n = self.rod.i1.len();
        let (theta, spin) = (motion.position[2], motion.velocity[2]);
        let turn = Matrix2::new(theta.cos(), -theta.sin(), theta.sin(), theta.cos());
        let arm = self.arm(end, motion);
        let moving = &end.shapes * motion.velocity.rows(3, n);
        let mut gradient = DMatrix::zeros(2, n + 3);
        gradient[(0, 0)] = 1.0;
        gradient[(1, 1)] = 1.0;
        gradient
            .column_mut(2)
            .copy_from(&(turn * quarter_turn() * arm));
        gradient
            .view_mut((0, 3), (2, n))
            .copy_from(&(turn * &end.shapes));
        let moving = Vector2::new(moving[0], moving[1]);
        let bias = turn * (2.0 * spin * quarter_turn() * moving - spin * spin * arm);
        (gradient, bias)
    }

    /// Acceleration of the slider along the x axis.
    pub fn slider_acceleration(&self, motion: &Motion) -> f64 {
        let (gradient, bias) = self.point(1, motion);
        (gradient * self.accelerations(motion).0)[0] + bias.x
    }

    fn arm(&self, end: &RodEnd, motion: &Motion) -> Vector2<f64> {
        let n = self.rod.i1.len();
        let displacement = &end.shapes * motion.position.rows(3, n);
        end.position + Vector2::new(displacement[0], displacement[1])
    }

    /// Place of the slider on the x axis.
    pub fn slider_position(&self, motion: &Motion) -> f64 {
        let arm = self.arm(&self.rod.ends[1], motion);
        let theta = motion.position[2];
        motion.position[0] + theta.cos() * arm.x - theta.sin() * arm.y
    }

    /// Advances by `steps` steps of size `step`.
    pub fn advance(&self, motion: &mut Motion, step: f64, steps: usize) {
        for _ in 0..steps {
            self.step(motion, step);
        }
    }

    /// Gragg's midpoint rule with several substeps, extrapolated.
    fn step(&self, motion: &mut Motion, step: f64) {
        let n = motion.position.len();
        let mut table: Vec<DVector<f64>> = Vec::new();
        for (row, &substeps) in SUBSTEPS.iter().enumerate() {
            let h = step / substeps as f64;
            let start = joined(motion);
            let mut before = start.clone();
            let mut now = &before + h * self.slope(motion.time, &before);
            for substep in 1..substeps {
                let time = motion.time + h * substep as f64;
                let after = &before + 2.0 * h * self.slope(time, &now);
                before = std::mem::replace(&mut now, after);
            }
            let end = motion.time + step;
            let smoothed = 0.5 * (&before + &now + h * self.slope(end, &now));
            table.push(smoothed);
            for column in (0..row).rev() {
                let ratio = (substeps as f64 / SUBSTEPS[column] as f64).powi(2);
                let better =
                    &table[column + 1] + (&table[column + 1] - &table[column]) / (ratio - 1.0);
                table[column] = better;
            }
        }
        motion.time += step;
        motion.position.copy_from(&table[0].rows(0, n));
        motion.velocity.copy_from(&table[0].rows(n, n));
    }

    fn slope(&self, time: f64, joined: &DVector<f64>) -> DVector<f64> {
        let n = joined.len() / 2;
        let motion = Motion {
            time,
            position: joined.rows(0, n).into_owned(),
            velocity: joined.rows(n, n).into_owned(),
        };
        let (accelerations, _) = self.accelerations(&motion);
        let mut slope = joined.clone();
        slope.rows_mut(0, n).copy_from(&motion.velocity);
        slope.rows_mut(n, n).copy_from(&accelerations);
        slope
    }
}

fn joined(motion: &Motion) -> DVector<f64> {
    let all = motion.position.iter().chain(motion.velocity.iter());
    DVector::from_iterator(2 * motion.position.len(), all.copied())
}

fn quarter_turn() -> Matrix2<f64> {
    Matrix2::new(0.0, -1.0, 1.0, 0.0)
}
