//! Residual flexibility: the static response to unit interface forces that the kept modes leave out.
//!
//! The columns X = G_res L_bᵀ solve K X = P' L_bᵀ with P' = I - M Φₐ Φₐᵀ, Φₐ = [rigid, kept], and Φₐᵀ M X = 0
//! (`docs/theory.md`, mean-axis generalized inverse); [`crate::attachments::columns`] solves for them. Here they become F_res, M_res and
//! the transform that says which of their directions are dynamic coordinates.

use dcb_dense::symmetrized;
use dcb_sparse::column_products::{StiffnessProducts, mass_products};
use dcb_sparse::factorization::PositiveFactor;
use faer::Mat;

use crate::attachments::columns::{AttachmentProblem, Loads, SolvedColumns};
use crate::attachments::dependency::{Dependency, dependencies};
use crate::attachments::interface_reduction::{InterfaceReduction, Truncation};
use crate::attachments::residual_filter::Filter;
use crate::error::Error;
use crate::model::condensation::Model;
use crate::model::localization::Localization;
use crate::model::rigid_body::RigidBodyModes;
use crate::modes::free_modes::FreeModes;
use crate::observer::Observer;

/// 1/ω² of a row below this part of another row's is rounding: some thousand ε, squared.
const MASSLESS: f64 = 1e-26;

/// G_res L_bᵀ and what follows from it. Rows and columns of output interfaces are zero throughout.
#[derive(Clone, Debug)]
pub struct ResidualFlexibility {
    /// G_res L_bᵀ over the model's dofs, (n_c, n_b).
    pub shapes: Mat<f64>,
    /// (G_res L_bᵀ)ᵀ K G_res L_bᵀ and Φᵀ K G_res L_bᵀ, for the report.
    pub stiffness: StiffnessProducts,
    /// F_res, (n_b, n_b).
    pub flexibility: Mat<f64>,
    /// M_res, (n_b, n_b).
    pub mass: Mat<f64>,
    /// F_res with no mode kept, (n_b, n_b).
    pub flexibility0: Mat<f64>,
    /// diag(M_res) with no mode kept.
    pub mass_diagonal0: Vec<f64>,
    /// L_b G_res L_bᵀ with output rows; `None` without output interfaces.
    pub output_shapes: Option<Mat<f64>>,
    /// T_r, (n_b, rank).
    pub transform: Mat<f64>,
    /// σ², ascending.
    pub sigma_squared: Vec<f64>,
    /// Directions with residual flexibility but too little mass for the transform: kept statically.
    pub static_directions: usize,
    /// Condition number of the scaled F_res over the directions that it has.
    pub condition: f64,
    /// Number of directions that the scaled F_res has.
    pub flexibility_rank: usize,
    /// Largest relative residual ‖K x - f‖ / ‖f‖ of the columns.
    pub residual: f64,
    /// The part of it that rounding in K x explains, ε ‖|K| |x|‖ / ‖f‖.
    pub residual_rounding: f64,
    /// Preconditioned iterations made.
    pub iterations: usize,
    /// Rows that depend on others, by name.
    pub dependencies: Vec<Dependency>,
    /// Contents left out on request; `None` if nothing was requested.
    pub interface_reduction: Option<InterfaceReduction>,
    /// Relation of the rows to the attachments.
    rows: RowKinds,
}

/// Relation of the rows of L_b to the attachments.
#[derive(Clone, Debug)]
struct RowKinds {
    /// Rows that act and feel elastic motion.
    elastic: Vec<bool>,
    /// Those among them that feel some beyond the kept modes.
    open: Vec<bool>,
}

impl RowKinds {
    fn of(localization: &Localization, solved: &SolvedColumns) -> Self {
        let elastic: Vec<bool> = (0..localization.len())
            .map(|i| localization.is_attachment(i) && !solved.inert[i])
            .collect();
        let open = elastic
            .iter()
            .zip(&solved.spent)
            .map(|(elastic, spent)| *elastic && !spent)
            .collect();
        Self { elastic, open }
    }
}

impl ResidualFlexibility {
    /// Solves for the attachment columns and forms F_res, M_res and the transform.
    ///
    /// # Errors
    /// [`Error::AttachmentsNotConverged`], or [`Error::NotPositive`] if F_res has a negative eigenvalue beyond rounding.
    pub fn compute(
        model: &Model,
        localization: &Localization,
        rigid: &RigidBodyModes,
        modes: &FreeModes,
        factor: &PositiveFactor,
        observer: &mut dyn Observer,
    ) -> Result<Self, Error> {
        let problem = AttachmentProblem::new(model, Loads::Interfaces(localization), rigid, modes);
        let solved = problem.solve(factor, observer)?;
        problem.refuse_unconverged(&solved)?;
        Self::from_columns(model, localization, modes, solved)
    }

    /// Residual flexibility of given columns X = G_res L_bᵀ, with the residual that they leave in K X = P' L_bᵀ.
    ///
    /// # Errors
    /// [`Error::NotPositive`] if F_res has a negative eigenvalue beyond rounding.
    pub fn from_shapes(
        model: &Model,
        localization: &Localization,
        rigid: &RigidBodyModes,
        modes: &FreeModes,
        columns: Mat<f64>,
    ) -> Result<Self, Error> {
        let problem = AttachmentProblem::new(model, Loads::Interfaces(localization), rigid, modes);
        Self::from_columns(model, localization, modes, problem.judge(columns))
    }

    fn from_columns(
        model: &Model,
        localization: &Localization,
        modes: &FreeModes,
        solved: SolvedColumns,
    ) -> Result<Self, Error> {
        let (residual, residual_rounding) = solved
            .worst
            .map_or((0.0, 0.0), |worst| (worst.residual, worst.rounding));
        let iterations = solved.iterations;
        let rows = RowKinds::of(localization, &solved);
        let (columns, stiffness) = (solved.columns, solved.stiffness);
        let made = Self::assemble(model, localization, modes, rows, columns, stiffness)?;
        Ok(Self {
            dependencies: dependencies(&made.flexibility0, localization),
            residual,
            residual_rounding,
            iterations,
            ..made
        })
    }

    /// The same with only the `wanted` softest directions of F_res; untouched if it has no more than that.
    ///
    /// # Errors
    /// [`Error::NotFinite`] if an eigenproblem fails.
    pub fn keeping(
        self,
        wanted: usize,
        model: &Model,
        localization: &Localization,
        modes: &FreeModes,
    ) -> Result<Self, Error> {
        let truncation = Truncation::of(&self, localization, wanted)?;
        let kept = match truncation.report.leaves_out() {
            true => {
                let shapes = truncation.project(self.shapes.as_ref());
                self.with_shapes(model, localization, modes, shapes)?
            }
            false => self,
        };
        Ok(Self {
            interface_reduction: Some(truncation.report),
            ..kept
        })
    }

    /// Residual flexibility of other columns, (n_c, n_b); everything that was found out on the way to these stays.
    ///
    /// # Errors
    /// [`Error::NotPositive`] if their F_res has a negative eigenvalue beyond rounding.
    pub fn with_shapes(
        self,
        model: &Model,
        localization: &Localization,
        modes: &FreeModes,
        shapes: Mat<f64>,
    ) -> Result<Self, Error> {
        let stiffness =
            StiffnessProducts::of(&model.stiffness, modes.shapes.as_ref(), shapes.as_ref());
        let made = Self::assemble(model, localization, modes, self.rows, shapes, stiffness)?;
        Ok(Self {
            residual: self.residual,
            residual_rounding: self.residual_rounding,
            iterations: self.iterations,
            dependencies: self.dependencies,
            interface_reduction: self.interface_reduction,
            ..made
        })
    }

    /// The matrices and the transform of columns X.
    fn assemble(
        model: &Model,
        localization: &Localization,
        modes: &FreeModes,
        rows: RowKinds,
        shapes: Mat<f64>,
        stiffness: StiffnessProducts,
    ) -> Result<Self, Error> {
        let n_b = localization.len();
        let at_interfaces = localization.apply(shapes.as_ref());
        let raw = Mat::from_fn(n_b, n_b, |i, j| {
            if rows.open[i] && rows.open[j] {
                at_interfaces[(i, j)]
            } else {
                0.0
            }
        });
        let has_outputs = (0..n_b).any(|row| !localization.is_attachment(row));
        let flexibility = symmetrized(raw.as_ref());
        let mut mass = mass_products(&model.mass, shapes.as_ref());
        // With no mode kept: G = Φ Ω⁻² Φᵀ + G_res over the kept elastic modes.
        let seen = localization.apply(modes.shapes.as_ref());
        let with_modes = |base: &Mat<f64>, power: i32| {
            Mat::from_fn(n_b, n_b, |i, j| {
                let from_modes: f64 = match rows.elastic[i] && rows.elastic[j] {
                    true => (modes.zero_count..modes.count())
                        .map(|k| seen[(i, k)] * seen[(j, k)] / modes.eigenvalues[k].powi(power))
                        .sum(),
                    false => 0.0,
                };
                base[(i, j)] + from_modes
            })
        };
        let (flexibility0, mut mass0) = (with_modes(&flexibility, 1), with_modes(&mass, 2));
        for row in rows_of_rounding(&flexibility0, &mass0) {
            clear(&mut mass, row);
            clear(&mut mass0, row);
        }
        let mass_diagonal0: Vec<f64> = (0..n_b).map(|i| mass0[(i, i)].max(0.0)).collect();
        let filter = Filter::of(&flexibility, &mass, &flexibility0, &mass0)?;
        Ok(Self {
            shapes,
            stiffness,
            mass,
            output_shapes: has_outputs.then_some(at_interfaces),
            dependencies: Vec::new(),
            flexibility: filter.flexibility,
            flexibility0,
            mass_diagonal0,
            transform: filter.transform,
            sigma_squared: filter.sigma_squared,
            static_directions: filter.static_directions,
            condition: filter.condition,
            flexibility_rank: filter.flexibility_rank,
            residual: 0.0,
            residual_rounding: 0.0,
            iterations: 0,
            interface_reduction: None,
            rows,
        })
    }

    /// Number of attachment coordinates that a reader keeps.
    pub fn rank(&self) -> usize {
        self.sigma_squared.len()
    }
}

/// Rows of which the mass is the rounding of a response without mass, such as a slender part's turn about its own line. Mass over
/// flexibility is a mean of 1/ω², whatever a row's unit: where it is that small beside another row's, no motion of the part is so fast.
fn rows_of_rounding(flexibility0: &Mat<f64>, mass0: &Mat<f64>) -> Vec<usize> {
    let slowness = |row: usize| match flexibility0[(row, row)] > 0.0 {
        true => mass0[(row, row)] / flexibility0[(row, row)],
        false => 0.0,
    };
    let rows = 0..mass0.nrows();
    let slowest = rows.clone().map(slowness).fold(0.0, f64::max);
    rows.filter(|row| slowness(*row) <= MASSLESS * slowest)
        .collect()
}

fn clear(matrix: &mut Mat<f64>, index: usize) {
    matrix.as_mut().row_mut(index).fill(0.0);
    matrix.as_mut().col_mut(index).fill(0.0);
}
