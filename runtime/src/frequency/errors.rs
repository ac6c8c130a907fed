//! What the modes that files leave out do to responses: an estimate from the bounds in the files.
//!
//! A body's superelement answers forces on its interface rows by Ẽ(ω), its mesh by E(ω), and its file bounds E − Ẽ ([`dcb_superelement::error_bounds`]). To first order
//!
//! ```text
//! δH_yu = Σ_b w_byᵀ (E_b − Ẽ_b) w_bu
//! ```
//! w are forces on the rows of body b, by the input u and by a unit force along the output y: the mechanism is at rest, so that it is reciprocal. First order is no bound:
//! tests compare it with responses of the whole mesh.

use dcb_superelement::{ErrorBounds, ErrorsBetween};
use faer::linalg::solvers::SolveLstsq;
use faer::{Mat, c64};

use crate::linear::Linearized;

/// Errors of responses of a linear mechanism.
pub(super) struct Errors<'a> {
    bodies: Vec<OfBody<'a>>,
    duals: &'a [Option<usize>],
    loss: f64,
}

struct OfBody<'a> {
    bounds: &'a ErrorBounds,
    /// Between all of its rows; `None` if no force acts on them.
    errors: Option<ErrorsBetween<'a>>,
    /// From forces on the body's rows to those on the rows of the bounds, (amounts, rows).
    amounts: Mat<f64>,
    /// First of the body's rows among the outputs of the mechanism.
    first: usize,
}

impl<'a> Errors<'a> {
    /// Of a mechanism that has the forces on the rows of all bodies with bounds as its last outputs, and forces along its outputs as its last inputs; `None` if no
    /// body's file tells.
    pub fn of(
        bounds: &'a [Option<ErrorBounds>],
        linear: &'a Linearized,
        loss: f64,
    ) -> Option<Self> {
        let own: Vec<(&ErrorBounds, Mat<f64>)> = (bounds.iter().flatten())
            .map(|bounds| (bounds, bounds.forces()))
            .collect();
        let all: usize = own.iter().map(|(_, forces)| forces.nrows()).sum();
        let mut first = linear.system.c.nrows().checked_sub(all)?;
        let mut bodies = Vec::with_capacity(own.len());
        for (bounds, forces) in own {
            let rows = forces.nrows();
            let all: Vec<usize> = (0..forces.ncols()).collect();
            let unit = Mat::<f64>::identity(rows, rows);
            bodies.push(OfBody {
                bounds,
                errors: bounds.between(&all).ok(),
                amounts: forces.qr().solve_lstsq(&unit),
                first,
            });
            first += rows;
        }
        (!bodies.is_empty()).then_some(Self {
            bodies,
            duals: &linear.duals,
            loss,
        })
    }

    /// Sizes of the errors of the first outputs by the first inputs, from all responses at a frequency; NaN where an output has no force along it. `None` beyond what
    /// the files tell.
    pub fn at(
        &self,
        found: &Mat<c64>,
        frequency: f64,
        [outputs, inputs]: [usize; 2],
    ) -> Option<Mat<f64>> {
        let omega = std::f64::consts::TAU * frequency;
        let square = omega * omega;
        let mut errors = Mat::from_fn(outputs, inputs, |_, _| 0.0);
        let mut sums = Mat::from_fn(outputs, inputs, |_, _| c64::new(0.0, 0.0));
        for body in &self.bodies {
            if square >= body.bounds.eigenvalue_bound() {
                return None;
            }
            let (amounts, rows) = (body.amounts.nrows(), body.amounts.ncols());
            let part = |part: fn(&c64) -> f64| {
                let all = Mat::from_fn(rows, found.ncols(), |i, j| {
                    part(&found[(body.first + i, j)])
                });
                &body.amounts * all
            };
            let (real, imaginary) = (part(|x| x.re), part(|x| x.im));
            let amount = |row: usize, j: usize| c64::new(real[(row, j)], imaginary[(row, j)]);
            let of_body = body.errors.as_ref()?.at(square, self.loss).ok()?;
            for j in 0..inputs {
                // How far the rows are off by the forces of the input.
                let moved: Vec<(c64, f64)> = (0..amounts)
                    .map(|row| {
                        let terms = of_body.forced.iter().enumerate();
                        terms.fold((c64::new(0.0, 0.0), 0.0), |(sum, rest), (c, forced)| {
                            let force = amount(*forced, j);
                            (
                                sum + of_body.difference[(row, c)] * force,
                                rest + of_body.radius[(row, c)] * force.norm(),
                            )
                        })
                    })
                    .collect();
                for i in 0..outputs {
                    let Some(dual) = self.duals[i] else { continue };
                    for (row, (known, rest)) in moved.iter().enumerate() {
                        let force = amount(row, dual);
                        sums[(i, j)] += force * *known;
                        errors[(i, j)] += force.norm() * rest;
                    }
                }
            }
        }
        Some(Mat::from_fn(outputs, inputs, |i, j| match self.duals[i] {
            Some(_) => errors[(i, j)] + sums[(i, j)].norm(),
            None => f64::NAN,
        }))
    }
}
