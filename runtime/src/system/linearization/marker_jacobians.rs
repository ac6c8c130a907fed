//! Jacobians of markers by the motion of their bodies, and their rates.

use faer::{Mat, MatMut};
use nalgebra::{Matrix6, Vector3};

use crate::kinematics::frame_motion::Six;
use crate::kinematics::rotation_vector::left_jacobian_transpose_derivative;
use crate::system::evaluation::Evaluation;
use crate::system::marker::{halves, six, turned};
use crate::system::state::rates;
use crate::system::{State, System};

/// Columns of S_u and S_θ.
pub(super) struct Shapes<'a> {
    columns: &'a [f64],
    n: usize,
}

impl<'a> Shapes<'a> {
    pub(super) fn of(columns: &'a [f64], n: usize) -> Self {
        Self { columns, n }
    }

    pub(super) fn three(&self, first: usize, k: usize) -> Vector3<f64> {
        if self.columns.is_empty() {
            return Vector3::zeros();
        }
        Vector3::from_fn(|i, _| self.columns[(first + i) * self.n + k])
    }

    pub(super) fn place(&self, k: usize) -> Vector3<f64> {
        self.three(0, k)
    }

    pub(super) fn turn(&self, k: usize) -> Vector3<f64> {
        self.three(3, k)
    }
}

/// How the rates of displacement and turn change with each coordinate: −K y' by slots, (n).
pub(super) fn rate_changes(stiffening: &[(usize, Mat<f64>)], rates: &[f64]) -> Vec<Six> {
    let mut changes = vec![Six::zeros(); rates.len()];
    for (slot, matrix) in stiffening {
        for (column, rate) in matrix.col_iter().zip(rates) {
            for (change, k) in changes.iter_mut().zip(column.iter()) {
                change[*slot] -= k * rate;
            }
        }
    }
    changes
}

/// World twists of the markers by the coordinates of their bodies, and of their velocities' change with the pose.
pub(super) struct MarkerJacobians {
    first: Vec<Option<usize>>,
    /// (6, 6 + n) for each marker.
    twist: Vec<Mat<f64>>,
    /// Change of (velocity, spin) at fixed velocities of the body, (6, 6 + n).
    rate: Vec<Mat<f64>>,
}

impl MarkerJacobians {
    pub(super) fn of(system: &System, state: &State, evaluation: &Evaluation) -> Self {
        let mut this = Self {
            first: Vec::new(),
            twist: Vec::new(),
            rate: Vec::new(),
        };
        for (index, marker) in system.markers.iter().enumerate() {
            let Some(body_index) = marker.body else {
                this.first.push(None);
                this.twist.push(Mat::zeros(6, 0));
                this.rate.push(Mat::zeros(6, 0));
                continue;
            };
            let body = &system.bodies[body_index];
            let n = body.flexible.coordinate_count();
            let (place, pose) = (&evaluation.places[index], &evaluation.poses[body_index]);
            let velocities = &state.velocities[body.velocities.clone()];
            let spin = rates(velocities).angular;
            let (u_rate, turn_rate) = marker.with_extra(place, &velocities[6..], &place.extra_rate);
            let relative = spin.cross(&place.arm) + u_rate;
            let turning = spin + place.turn_jacobian * turn_rate;
            let jacobian_slope = -left_jacobian_transpose_derivative(&-place.turn, &turn_rate);
            let shapes = Shapes::of(marker.current_shapes(place), n);
            let stiffening = rate_changes(&marker.stiffening, &velocities[6..]);
            let (mut twist, mut rate) = (Mat::zeros(6, 6 + n), Mat::zeros(6, 6 + n));
            let mut y = vec![0.0; n];
            for column in 0..6 + n {
                let mut rigid = Six::zeros();
                let change = if column < 6 {
                    rigid[column] = 1.0;
                    let turn = halves(&rigid).1;
                    six(&turn.cross(&relative), &turn.cross(&turning))
                } else {
                    y[column - 6] = 1.0;
                    let (u, o) = (shapes.place(column - 6), shapes.turn(column - 6));
                    let (u_change, turn_change) = halves(&stiffening[column - 6]);
                    six(
                        &(spin.cross(&u) + u_change),
                        &(jacobian_slope * o + place.turn_jacobian * turn_change),
                    )
                };
                let moved = turned(&pose.axes, &marker.twist(place, &rigid, &y));
                let changed = turned(&pose.axes, &change);
                if column >= 6 {
                    y[column - 6] = 0.0;
                }
                for i in 0..6 {
                    twist[(i, column)] = moved[i];
                    rate[(i, column)] = changed[i];
                }
            }
            this.first.push(Some(body.velocities.start));
            this.twist.push(twist);
            this.rate.push(rate);
        }
        this
    }

    /// `into += Nᵀ wrench`
    pub(super) fn add_transposed(&self, marker: usize, wrench: &Six, into: &mut [f64]) {
        Self::add(self.first[marker], &self.twist[marker], wrench, into);
    }

    /// The same with the change of the marker's velocities in place of its displacement.
    pub(super) fn add_rate_transposed(&self, marker: usize, wrench: &Six, into: &mut [f64]) {
        Self::add(self.first[marker], &self.rate[marker], wrench, into);
    }

    pub(super) fn add(first: Option<usize>, matrix: &Mat<f64>, wrench: &Six, into: &mut [f64]) {
        let Some(first) = first else { return };
        for (column, entry) in matrix.col_iter().zip(&mut into[first..]) {
            *entry += column
                .iter()
                .zip(wrench.iter())
                .map(|(a, b)| a * b)
                .sum::<f64>();
        }
    }

    /// `matrix -= N_aᵀ block N_b`; with `block` the change of the wrench at `a` by the twist of `b`, this is stiffness.
    pub(super) fn subtract_block(
        &self,
        a: usize,
        b: usize,
        block: &Matrix6<f64>,
        matrix: MatMut<'_, f64>,
    ) {
        let (Some(row), Some(column)) = (self.first[a], self.first[b]) else {
            return;
        };
        let block = Mat::from_fn(6, 6, |i, j| block[(i, j)]);
        let product = self.twist[a].transpose() * (block * &self.twist[b]);
        let mut target = matrix.submatrix_mut(row, column, product.nrows(), product.ncols());
        target -= product;
    }
}
