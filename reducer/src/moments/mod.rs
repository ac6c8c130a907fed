//! The power moments of what the modes leave out, and what the kept modes' own residuals say, through the factorization at hand.
//!
//! ```text
//! X = G Lᵀ,  Z = G_σ M X      M_1 = L X,  M_2 = Xᵀ M X,  M_3 = Xᵀ M Z,  M_4 = Zᵀ M Z
//! ```
//! X are the attachments and further columns of the basis, and besides the static responses to forces at output rows. G_σ is the inverse of
//! the factorized matrix, K + σ M or K on springs (σ = 0), without rigid and kept motions: one solution for each column.

mod mode_residuals;
mod second_responses;

use dcb_dense::symmetrized;
use dcb_formats::superelement::Moments;
use dcb_sparse::block_algebra::{copy, gram, symmetric_product, zeros};
use dcb_sparse::factorization::PositiveFactor;
use dcb_superelement::error_bounds::DENSE_ROUNDING;
use faer::{Mat, MatRef};

use self::mode_residuals::ModeResiduals;
use self::second_responses::SecondResponses;
use crate::attachments::columns::{AttachmentProblem, Loads};
use crate::attachments::enrichment::Reducing;
use crate::error::Error;
use crate::model::condensation::CowMat;
use crate::model::shift::EnergyBound;
use crate::modes::certificate::ModeCount;
use crate::modes::free_modes::FreeModes;
use crate::observer::Observer;

/// M_1 to M_4 with their rounding; members as in [`Moments`].
#[derive(Clone, Debug)]
pub struct PowerMoments {
    shift: f64,
    first: Mat<f64>,
    second: Mat<f64>,
    third: Mat<f64>,
    fourth: Mat<f64>,
    rounding: Vec<f64>,
    rigid_shapes: Mat<f64>,
    modes: ModeResiduals,
}

impl PowerMoments {
    /// With the attachments of `of`, all of them, and the shapes of further columns, (n_c, n_x), where there are some. `factor` is that of
    /// K + σ M, σ the `shift`, or of K on springs, where that is 0.
    ///
    /// # Errors
    /// [`Error::AttachmentsNotConverged`] naming the response at an output row that doesn't converge.
    pub fn compute(
        of: &Reducing<'_>,
        further: Option<MatRef<'_, f64>>,
        factor: &PositiveFactor,
        shift: f64,
        observer: &mut dyn Observer,
    ) -> Result<Self, Error> {
        let localization = of.localization;
        let static_shapes = StaticShapes::of(of, further, factor, observer)?;
        let bound = EnergyBound::of(&of.model.stiffness);
        let shapes = static_shapes.columns.as_ref();
        let next = SecondResponses::of(of, shapes, factor, &bound, observer)?;
        let first = static_shapes.flexibility(of, further);
        let precision = of.rigid.stiffness_precision;
        let energies = bound.energies(shapes);
        let rounding = (0..shapes.ncols())
            .map(|i| {
                let over = |energy: f64, whole: f64| match whole > 0.0 {
                    true => precision * energy / whole,
                    false => 0.0,
                };
                let of_entries = over(energies[i], first[(i, i)])
                    .max(over(next.energies[i], next.third[(i, i)]));
                let of_solutions = static_shapes.inaccuracy(of, i, first[(i, i)]);
                DENSE_ROUNDING + of_entries + of_solutions.max(next.asymmetry[i])
            })
            .collect();
        Ok(Self {
            shift,
            first,
            second: next.second,
            third: next.third,
            fourth: next.fourth,
            rounding,
            rigid_shapes: localization.apply(of.rigid.shapes.as_ref()),
            modes: ModeResiduals::of(of, factor, shift)?,
        })
    }

    /// With what is known of the number of modes.
    pub fn certified(self, modes: &FreeModes, mode_count: ModeCount) -> Moments {
        let eigenvalue_bound = match mode_count.limit {
            Some(limit) if modes.first_omitted.is_finite() => limit,
            _ => f64::INFINITY,
        };
        Moments {
            eigenvalue_bound,
            eigenvalue_errors: self.modes.eigenvalue_errors(modes, eigenvalue_bound),
            rigid_shapes: self.rigid_shapes,
            shift: self.shift,
            first: self.first,
            second: self.second,
            third: self.third,
            fourth: self.fourth,
            rounding: self.rounding,
            loaded: None,
        }
    }
}

/// X: attachments, responses to forces at output rows, further columns; (n_c, n_b + n_x).
struct StaticShapes<'a> {
    columns: CowMat<'a>,
    /// xᵀ K x of the responses to forces at output rows, by row.
    output_energies: Vec<(usize, f64)>,
}

impl<'a> StaticShapes<'a> {
    fn of(
        of: &Reducing<'a>,
        further: Option<MatRef<'_, f64>>,
        factor: &PositiveFactor,
        observer: &mut dyn Observer,
    ) -> Result<Self, Error> {
        let localization = of.localization;
        let (n_c, n_b) = (of.model.len(), localization.len());
        let n_x = further.map_or(0, |further| further.ncols());
        let outputs: Vec<usize> = (0..n_b)
            .filter(|row| !localization.is_attachment(*row))
            .collect();
        if outputs.is_empty() && n_x == 0 {
            return Ok(Self {
                columns: CowMat::Borrowed(of.residual.shapes.as_ref()),
                output_energies: Vec::new(),
            });
        }
        let mut columns = zeros(n_c, n_b + n_x);
        let (attached, beside) = columns.as_mut().split_at_col_mut(n_b);
        copy(of.residual.shapes.as_ref(), attached);
        if let Some(further) = further {
            copy(further, beside);
        }
        let mut output_energies = Vec::new();
        if !outputs.is_empty() {
            let mut forces = Mat::zeros(n_c, outputs.len());
            for (column, row) in outputs.iter().enumerate() {
                for (dof, value) in &localization.rows[*row].coefficients {
                    forces[(*dof as usize, column)] = *value;
                }
            }
            let names: Vec<String> = (outputs.iter())
                .map(|row| localization.row_name(*row))
                .collect();
            let loads = Loads::Columns {
                forces: forces.as_ref(),
                names: &names,
            };
            let problem = AttachmentProblem::new(of.model, loads, of.rigid, of.modes);
            let solved = problem.solve(factor, observer)?;
            problem.refuse_unconverged(&solved)?;
            for (column, row) in outputs.iter().enumerate() {
                let mut to = columns.as_mut().col_mut(*row);
                to.copy_from(solved.columns.col(column));
                output_energies.push((*row, solved.stiffness.columns[(column, column)]));
            }
        }
        Ok(Self {
            columns: CowMat::Owned(columns),
            output_energies,
        })
    }
    /// M_1: between attachments F_res as it is stored.
    fn flexibility(&self, of: &Reducing<'_>, further: Option<MatRef<'_, f64>>) -> Mat<f64> {
        let n_b = of.localization.len();
        let seen = of.localization.apply(self.columns.as_ref());
        let own = match further {
            Some(further) => gram(
                further,
                symmetric_product(&of.model.stiffness, further).as_ref(),
            ),
            None => Mat::zeros(0, 0),
        };
        let n = seen.ncols();
        let raw = Mat::from_fn(n, n, |i, j| {
            let attached = |row: usize| row < n_b && of.localization.is_attachment(row);
            match (i < n_b, j < n_b) {
                (true, true) if attached(i) && attached(j) => of.residual.flexibility[(i, j)],
                (true, true) if attached(i) => seen[(j, i)],
                (true, _) => seen[(i, j)],
                (false, true) => seen[(j, i)],
                (false, false) => own[(i - n_b, j - n_b)],
            }
        });
        symmetrized(raw.as_ref())
    }

    /// Relative difference of a static shape's flexibility and its energy: zero for an exact solution. Those of further columns are
    /// energies.
    fn inaccuracy(&self, of: &Reducing<'_>, column: usize, flexibility: f64) -> f64 {
        let of_output = (self.output_energies.iter()).find(|(row, _)| *row == column);
        let energy = match of_output {
            Some((_, energy)) => *energy,
            None if column < of.localization.len() => {
                of.residual.stiffness.columns[(column, column)]
            }
            None => flexibility,
        };
        match flexibility > 0.0 {
            true => (flexibility - energy).abs() / flexibility,
            false => 0.0,
        }
    }
}
