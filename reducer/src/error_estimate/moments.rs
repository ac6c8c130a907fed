//! The power moments of what the modes leave out, and what the kept modes' own residuals say, through the factorization at hand.
//!
//! ```text
//! X = G Lᵀ,  Z = G M X        M_1 = L X,  M_2 = Xᵀ M X,  M_3 = Xᵀ M Z,  M_4 = Zᵀ M Z
//! ```
//! X are the attachments and further columns of the basis, and besides the static responses to forces at output rows; Z is one more block
//! of solutions, for the columns of the basis.

use dcb_formats::superelement::Moments;
use faer::{Mat, MatRef};

use crate::attachment::{AttachmentProblem, Loads, SolvedColumns};
use crate::block_algebra::{column_dots, copy, gram, symmetric_product, symmetrized};
use crate::column_products::BLOCK;
use crate::condensation::CowMat;
use crate::enrichment::Reducing;
use crate::error::Error;
use crate::factorization::PositiveFactor;
use crate::free_modes::FreeModes;
use crate::localization::Localization;
use crate::observer::Observer;
use crate::quality::Sturm;
use crate::shift::AbsoluteForces;

/// Rounding of a moment, whatever its columns are.
pub(super) const DENSE_ROUNDING: f64 = 64.0 * f64::EPSILON;

/// M_1 to M_4 with their rounding; members as in [`Moments`].
#[derive(Clone, Debug)]
pub struct PowerMoments {
    first: Mat<f64>,
    second: Mat<f64>,
    third: Mat<f64>,
    fourth: Mat<f64>,
    rounding: Vec<f64>,
    rigid_shapes: Mat<f64>,
    modes: ModeResiduals,
}

impl PowerMoments {
    /// With the attachments of `of`, all of them, and the shapes of further columns, (n_c, n_x), where there are some.
    ///
    /// # Errors
    /// [`Error::AttachmentsNotConverged`] naming the response that doesn't converge.
    pub fn compute(
        of: &Reducing<'_>,
        further: Option<MatRef<'_, f64>>,
        factor: &PositiveFactor,
        shift: f64,
        observer: &mut dyn Observer,
    ) -> Result<Self, Error> {
        let localization = of.localization;
        let static_shapes = StaticShapes::of(of, further, factor, observer)?;
        let shapes = static_shapes.columns.as_ref();
        let mut forces = symmetric_product(&of.model.mass, shapes);
        let second = symmetrized(gram(shapes, forces.as_ref()).as_ref());
        let names: Vec<String> = (0..shapes.ncols())
            .map(|column| match column < localization.len() {
                true => format!("second response of {}", localization.row_name(column)),
                false => format!("second response of column {}", column - localization.len()),
            })
            .collect();
        // Nothing moves output rows by force: their second responses aren't needed.
        let responding = |column: usize| !is_output(localization, column);
        for column in (0..shapes.ncols()).filter(|column| !responding(*column)) {
            forces.as_mut().col_mut(column).fill(0.0);
        }
        let solved = solve(of, forces.as_ref(), &names, factor, observer)?;
        drop(forces);
        let next = solved.columns.as_ref();
        let mut raw = Mat::zeros(next.ncols(), next.ncols());
        let mut fourth = raw.clone();
        for start in (0..next.ncols()).step_by(BLOCK) {
            let count = BLOCK.min(next.ncols() - start);
            let inertia = symmetric_product(&of.model.mass, next.subcols(start, count));
            for (of, products) in [(shapes, &mut raw), (next, &mut fourth)] {
                let mut to = products.as_mut().subcols_mut(start, count);
                to.copy_from(gram(of, inertia.as_ref()));
            }
        }
        let third = Mat::from_fn(raw.nrows(), raw.ncols(), |i, j| {
            match (responding(i), responding(j)) {
                (true, true) => 0.5 * (raw[(i, j)] + raw[(j, i)]),
                (false, true) => raw[(i, j)],
                (true, false) => raw[(j, i)],
                (false, false) => 0.0,
            }
        });
        let fourth = symmetrized(fourth.as_ref());
        let first = static_shapes.flexibility(of, further);
        let rounding = static_shapes.rounding(of, &first, &third, &solved.stiffness.columns);
        Ok(Self {
            first,
            second,
            third,
            fourth,
            rounding,
            rigid_shapes: localization.apply(of.rigid.shapes.as_ref()),
            modes: ModeResiduals::of(of, factor, shift),
        })
    }

    /// With what an eigenvalue count says of the modes.
    pub fn certified(self, modes: &FreeModes, sturm: Sturm) -> Moments {
        let eigenvalue_bound = match sturm.limit {
            Some(limit) if modes.first_omitted.is_finite() => limit,
            _ => f64::INFINITY,
        };
        Moments {
            eigenvalue_bound,
            eigenvalue_errors: self.modes.eigenvalue_errors(modes, eigenvalue_bound),
            rigid_shapes: self.rigid_shapes,
            first: self.first,
            second: self.second,
            third: self.third,
            fourth: self.fourth,
            rounding: self.rounding,
        }
    }
}

fn is_output(localization: &Localization, column: usize) -> bool {
    column < localization.len() && !localization.is_attachment(column)
}

fn solve(
    of: &Reducing<'_>,
    forces: MatRef<'_, f64>,
    names: &[String],
    factor: &PositiveFactor,
    observer: &mut dyn Observer,
) -> Result<SolvedColumns, Error> {
    let loads = Loads::Columns { forces, names };
    let problem = AttachmentProblem::new(of.model, loads, of.rigid, of.modes);
    let solved = problem.solve(factor, observer);
    problem.refuse_unconverged(&solved)?;
    Ok(solved)
}

/// X: attachments, responses to forces at output rows, further columns; (n_c, n_b + n_x).
struct StaticShapes<'a> {
    columns: CowMat<'a>,
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
            .filter(|row| is_output(localization, *row))
            .collect();
        if outputs.is_empty() && n_x == 0 {
            let columns = CowMat::Borrowed(of.residual.shapes.as_ref());
            return Ok(Self { columns });
        }
        let mut columns = Mat::zeros(n_c, n_b + n_x);
        let (attached, beside) = columns.as_mut().split_at_col_mut(n_b);
        copy(of.residual.shapes.as_ref(), attached);
        if let Some(further) = further {
            copy(further, beside);
        }
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
            let solved = solve(of, forces.as_ref(), &names, factor, observer)?;
            for (column, row) in outputs.iter().enumerate() {
                let mut to = columns.as_mut().col_mut(*row);
                to.copy_from(solved.columns.col(column));
            }
        }
        Ok(Self {
            columns: CowMat::Owned(columns),
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

    /// What rounding in K and unfinished solutions do to each row, relatively.
    fn rounding(
        &self,
        of: &Reducing<'_>,
        first: &Mat<f64>,
        third: &Mat<f64>,
        next_stiffness: &Mat<f64>,
    ) -> Vec<f64> {
        let columns = self.columns.as_ref();
        let absolute = AbsoluteForces::of(&of.model.stiffness, columns).energies;
        let mut energies = Vec::with_capacity(columns.ncols());
        for start in (0..columns.ncols()).step_by(BLOCK) {
            let block = columns.subcols(start, BLOCK.min(columns.ncols() - start));
            let forces = symmetric_product(&of.model.stiffness, block);
            energies.extend(column_dots(block, forces.as_ref()));
        }
        let apart = |a: f64, b: f64| if a > 0.0 { (a - b).abs() / a } else { 0.0 };
        (0..columns.ncols())
            .map(|i| {
                let flexibility = first[(i, i)];
                let of_entries = match flexibility > 0.0 {
                    true => of.rigid.stiffness_precision * absolute[i] / flexibility,
                    false => 0.0,
                };
                let of_solutions = apart(flexibility, energies[i])
                    .max(apart(third[(i, i)], next_stiffness[(i, i)]));
                DENSE_ROUNDING + of_entries + of_solutions
            })
            .collect()
    }
}

/// What the kept modes leave of their equation, ρ = K φ - ω² M φ, in the norm of the factorized matrix: ρᵀ (K + σ M)⁻¹ ρ.
#[derive(Clone, Debug)]
struct ModeResiduals {
    squares: Vec<f64>,
    shift: f64,
}

impl ModeResiduals {
    fn of(of: &Reducing<'_>, factor: &PositiveFactor, shift: f64) -> Self {
        let modes = of.modes;
        let mut squares = Vec::with_capacity(modes.count());
        for first in (0..modes.count()).step_by(BLOCK) {
            let count = BLOCK.min(modes.count() - first);
            let shapes = modes.shapes.as_ref().subcols(first, count);
            let mut left = symmetric_product(&of.model.stiffness, shapes);
            for (j, left) in left.col_iter_mut().enumerate() {
                let eigenvalue = modes.eigenvalues[first + j];
                let inertia = modes.mass_shapes.col(first + j);
                for (left, inertia) in left.iter_mut().zip(inertia.iter()) {
                    *left -= eigenvalue * inertia;
                }
            }
            let mut solved = left.clone();
            factor.solve_in_place(solved.as_mut());
            squares.extend(column_dots(left.as_ref(), solved.as_ref()));
        }
        Self { squares, shift }
    }

    /// Relative bounds of what each ω² is off. With ν = 1/(ω² + σ) the eigenvalues of (K + σ M)⁻¹ M: kept ones differ from exact ones by
    /// ‖E‖² over the distance to those left out, E the residuals of all of them in the same norm; rounding comes on top.
    fn eigenvalue_errors(&self, modes: &FreeModes, eigenvalue_bound: f64) -> Vec<f64> {
        let shifted = |k: usize| modes.eigenvalues[k] + self.shift;
        let elastic = modes.zero_count..modes.count();
        let residual_square: f64 = elastic
            .clone()
            .map(|k| self.squares[k].max(0.0) / shifted(k).powi(3))
            .sum();
        let residual = residual_square.sqrt();
        let omitted = 1.0 / (eigenvalue_bound + self.shift);
        let error = |k: usize| {
            if !elastic.contains(&k) {
                return 0.0;
            }
            let distance = 1.0 / shifted(k) - omitted - residual;
            let apart = match distance > residual {
                true => residual_square / distance,
                false => residual,
            };
            let of_residual = apart * shifted(k) * shifted(k) / modes.eigenvalues[k];
            of_residual + modes.eigenvalue_roundings[k]
        };
        (0..modes.count()).map(error).collect()
    }
}
