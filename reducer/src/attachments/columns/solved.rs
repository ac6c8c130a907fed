//! Attachment columns with what they leave of their equation, entered block by block.

use dcb_sparse::block_algebra::{copy, set_columns, some_columns};
use dcb_sparse::column_products::{BLOCK, StiffnessProducts};
use faer::Mat;

use super::iteration::Solution;
use super::{AttachmentProblem, ProjectedForces, RESIDUAL_LIMIT, residual_limit};

/// Attachment columns with what they leave of their equation.
pub struct SolvedColumns {
    /// X, (n_c, n_b).
    pub columns: Mat<f64>,
    /// Xᵀ K X and Φᵀ K X.
    pub stiffness: StiffnessProducts,
    /// Rows whose force only moves the part rigidly.
    pub inert: Vec<bool>,
    /// Rows whose force only excites rigid and kept motions; the inert ones among them.
    pub spent: Vec<bool>,
    /// Preconditioned iterations made, the most of any block.
    pub iterations: usize,
    /// The column whose residual exceeds its limit most; `None` without columns.
    pub worst: Option<WorstColumn>,
}

/// Residual of an attachment column.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WorstColumn {
    /// Its row of L_b, or its place among the forces.
    pub row: usize,
    /// ‖K x - f‖ / ‖f‖.
    pub residual: f64,
    /// The part of it that rounding in K x explains, ε ‖|K| |x|‖ / ‖f‖.
    pub rounding: f64,
}

/// Columns on the way: those entered so far are the first ones.
pub(super) struct Collected<'a> {
    problem: &'a AttachmentProblem<'a>,
    columns: Mat<f64>,
    stiffness: StiffnessProducts,
    inert: Vec<bool>,
    spent: Vec<bool>,
    residuals: Vec<f64>,
    /// Norms of the forces.
    norms: Vec<f64>,
    iterations: usize,
}

impl<'a> Collected<'a> {
    /// None are entered yet of these columns.
    pub fn new(problem: &'a AttachmentProblem<'a>, columns: Mat<f64>) -> Self {
        Self {
            stiffness: StiffnessProducts::empty(problem.kept.shapes.ncols(), columns.ncols()),
            problem,
            columns,
            inert: Vec::new(),
            spent: Vec::new(),
            residuals: Vec::new(),
            norms: Vec::new(),
            iterations: 0,
        }
    }

    /// Some of the columns as they are now.
    pub fn some(&self, rows: &[usize]) -> Mat<f64> {
        some_columns(self.columns.as_ref(), rows)
    }

    /// Enters the next columns.
    pub fn enter(&mut self, forces: ProjectedForces, solution: Solution) {
        let (first, count) = (self.residuals.len(), solution.residuals.len());
        let block = self.columns.as_mut().subcols_mut(first, count);
        copy(solution.x.as_ref(), block);
        let known = self.columns.as_ref().subcols(0, first + count);
        let product = solution.product.as_ref();
        let modes = self.problem.kept.shapes;
        self.stiffness
            .enter(modes, known, first..first + count, product);
        self.residuals.extend(solution.residuals);
        self.norms.extend(forces.norms);
        self.inert.extend(forces.inert);
        self.spent.extend(forces.spent);
        self.iterations = self.iterations.max(solution.iterations);
    }

    /// Enters columns of these rows anew.
    pub fn replace(&mut self, rows: &[usize], solution: Solution) {
        set_columns(self.columns.as_mut(), rows, solution.x.as_ref());
        let known = self.columns.as_ref().subcols(0, self.residuals.len());
        let product = solution.product.as_ref();
        let modes = self.problem.kept.shapes;
        self.stiffness
            .enter(modes, known, rows.iter().copied(), product);
        for (row, residual) in rows.iter().zip(solution.residuals) {
            self.residuals[*row] = residual;
        }
        self.iterations = self.iterations.max(solution.iterations);
    }

    /// All of them.
    pub fn finish(self) -> SolvedColumns {
        SolvedColumns {
            worst: self.worst(),
            columns: self.columns,
            stiffness: self.stiffness,
            inert: self.inert,
            spent: self.spent,
            iterations: self.iterations,
        }
    }

    /// The column whose residual exceeds its limit most. Rounding is evaluated where it matters: for residuals above the limit, and for the
    /// largest one.
    fn worst(&self) -> Option<WorstColumn> {
        let residuals = &self.residuals;
        let largest =
            (0..residuals.len()).max_by(|a, b| residuals[*a].total_cmp(&residuals[*b]))?;
        let asked: Vec<usize> = (0..residuals.len())
            .filter(|j| *j == largest || residuals[*j] > RESIDUAL_LIMIT)
            .collect();
        let candidates = asked.chunks(BLOCK).flat_map(|asked| {
            let scales: Vec<f64> = asked.iter().map(|j| self.norms[*j]).collect();
            let roundings = self.problem.roundings(&self.some(asked), &scales);
            let rows = asked.iter().zip(roundings);
            rows.map(|(row, rounding)| WorstColumn {
                row: *row,
                residual: residuals[*row],
                rounding,
            })
            .collect::<Vec<_>>()
        });
        let excess = |column: &WorstColumn| column.residual / residual_limit(column.rounding);
        candidates.max_by(|a, b| excess(a).total_cmp(&excess(b)))
    }
}
