//! The unreduced part as its interfaces see it, exact to rounding: what every row of a study is compared with.
//!
//! With the free modes below ω_N certified, what they leave of H(λ) is a power series that the sparse matrices themselves give:
//!
//! ```text
//! H(λ) = Σ_{p ≤ N} s_p s_pᵀ / (λ_p - λ)  +  Σ_j λ^j L_b X_j,     X_0 = G_res L_bᵀ,   X_{j+1} = G_res M X_j
//! ```
//! It converges like (λ/ω²_{N+1})^j, and a study takes N so large that λ stays below half of ω²_{N+1}. The series is summed until nothing is left of it; its
//! solutions don't depend on the frequency, so that any number of points costs the same. The result is then put into the unreduced equations,
//! (K - λ M) u = L_bᵀ at the upper end of the band, and what it leaves of them is reported.

use dcb_dense::{symmetric_eigen, symmetrized};
use dcb_formats::{Component, RecoveryBasis, Superelement};
use dcb_sparse::block_algebra::{
    add_combination, column_norms, copy, gram, largest_entry, symmetric_product,
};
use dcb_sparse::factorization::{PositiveFactor, SymmetricFactor};
use faer::{Mat, MatRef};

use super::rows::InterfaceRows;
use super::spin::SpinStrain;
use dcb_reducer::error::{Error, Lacking, Shortfall};
use dcb_reducer::model::condensation::Model;
use dcb_reducer::model::localization::Localization;
use dcb_reducer::model::piece_motions::Pieces;
use dcb_reducer::model::rigid_body::{MassProperties, RigidBodyModes};
use dcb_reducer::model::shift::SpectrumScale;
use dcb_reducer::observer::{Observer, Stage};
use dcb_reducer::pipeline::diagnosis;
use dcb_reducer::resources::forecast::Forecast;
use dcb_reducer::resources::memory_limit::MemoryLimit;
use dcb_reducer::{
    EnrichmentSource, ModeSelection, Reduced, Reduction, WholeReduction, reduce_whole,
};
use dcb_superelement::held_frequencies::counted_eigenvalues;
use dcb_superelement::{FrequencyBand, Receptance};

/// ω²_{N+1} is at least this many times λ at the upper end of the band.
const REACH: f64 = 2.0;
/// If it isn't, modes are computed up to this many times λ.
const WIDER_REACH: f64 = 2.25;
/// A term of the series below this fraction of the flexibility ends it.
const LAST_TERM: f64 = 1e-17;
/// Terms after which a series is given up; at [`REACH`] sixty are enough.
const MOST_TERMS: usize = 90;
/// Passes of refinement of a term, and the relative residual at which they end.
const PASSES: usize = 4;
const TERM_RESIDUAL: f64 = 1e-13;
/// Limit of the reference's residual in the unreduced equations.
const RESIDUAL_LIMIT: f64 = 1e-7;
/// Directions of the interfaces' flexibility below this fraction of the largest are dependent rows.
const DEPENDENT: f64 = 1e-10;

/// The unreduced part.
#[derive(Clone, Debug)]
pub struct ComponentReference {
    /// Rows that forces act on.
    pub rows: InterfaceRows,
    /// H between them, scaled.
    pub response: Receptance,
    /// Independent combinations W of the rows, orthonormal, (m, k).
    pub independent: Mat<f64>,
    /// Flexibility with the inertia relieved between the rows, scaled, (m, m).
    pub flexibility: Mat<f64>,
    /// Free elastic ω², ascending, and the first one beyond.
    pub free: Vec<f64>,
    /// ω² with all interfaces held, below the upper end of the band.
    pub held: Vec<f64>,
    /// Motions that the interfaces leave free when they are held.
    pub loose: usize,
    /// The band.
    pub band: FrequencyBand,
    /// Largest ‖(K - λ M) u - f‖ over ‖f‖ + ‖K u‖ of a unit force at the upper end of the band.
    pub residual: f64,
    /// Terms of the series.
    pub terms: usize,
    /// The strain that centrifugal forces make; `None` where no spin strains the part.
    pub spin: Option<SpinStrain>,
    /// The reduction that it starts from.
    pub element: Superelement,
    /// Its shapes at the nodes.
    pub recovery: RecoveryBasis,
}

/// The band that is asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BandChoice {
    /// Up to half the frequency of the highest mode of the largest row.
    HalfOfHighest,
    /// Between two eigenvalues (angular frequencies squared).
    Between {
        /// Lower end, ω².
        from: f64,
        /// Upper end, ω².
        to: f64,
    },
}

impl ComponentReference {
    /// Computes it with at least `modes` modes.
    ///
    /// # Errors
    /// Those of [`reduce_whole`]; [`Error::Lacking`] without interfaces or elastic modes; [`Error::Shortfall`] if the reference leaves more of
    /// the unreduced equations than it may.
    pub fn compute(
        component: &Component,
        modes: usize,
        choice: BandChoice,
        points: usize,
        memory: &MemoryLimit,
        observer: &mut dyn Observer,
    ) -> Result<Self, Error> {
        let options = |modes| Reduction {
            modes,
            memory: memory.clone(),
            enrichment: vec![EnrichmentSource::Spin],
            ..Reduction::lowest(0)
        };
        let fewest = options(ModeSelection::Lowest(modes));
        let mut whole = reduce_whole(component, &fewest, observer)?.accepted()?;
        let Some(highest) = whole.reduced.superelement.modes.eigenvalues.last().copied() else {
            return Err(Lacking::ElasticModes.into());
        };
        let (from, to) = match choice {
            BandChoice::HalfOfHighest => (None, 0.25 * highest),
            BandChoice::Between { from, to } => (Some(from), to),
        };
        if whole.reduced.superelement.modes.first_omitted_eigenvalue < REACH * to {
            let eigenvalue = WIDER_REACH * to;
            let more = options(ModeSelection::Below { eigenvalue });
            whole = reduce_whole(component, &more, observer)?.accepted()?;
        }
        let eigenvalues = &whole.reduced.superelement.modes.eigenvalues;
        let band = FrequencyBand::new(from, to, points, eigenvalues);
        Self::from_reduced(component, whole, band, memory, observer)
    }

    fn from_reduced(
        component: &Component,
        whole: WholeReduction,
        band: FrequencyBand,
        memory: &MemoryLimit,
        observer: &mut dyn Observer,
    ) -> Result<Self, Error> {
        let element = &whole.reduced.superelement;
        let stored = whole.shapes();
        let properties = MassProperties::of(component)?;
        let model = Model::of(component)?;
        let localization = Localization::of(component, &model)?;
        let rigid = RigidBodyModes::of(component, &model, &properties)?;
        let eigenvalues = &element.modes.eigenvalues;
        let flexibility = static_flexibility(element);
        let rows = InterfaceRows::of(
            &localization,
            flexibility.as_ref(),
            localization.apply(rigid.shapes.as_ref()).as_ref(),
            eigenvalues[0],
        );
        if rows.is_empty() {
            return Err(Lacking::Forces.into());
        }
        let problem = Unreduced::of(&model, &rigid, eigenvalues, stored.modes);
        let scaled = |columns: &Mat<f64>| {
            Mat::from_fn(model.len(), rows.len(), |i, j| {
                columns[(i, rows.places[j])] * rows.scale[j]
            })
        };
        let first = scaled(&model.contract(stored.residual));
        let forces = scaled(&localization.attachment_columns(model.len(), 0..localization.len()));
        let scale = SpectrumScale::of(
            &model,
            &rigid,
            &Pieces::of(&model, &rigid),
            component.dimension(),
            properties.centre,
        );
        let at_rows = |x: MatRef<'_, f64>| rows.scaled(localization.apply(x).as_ref());
        let sizes = (&localization, eigenvalues.len());
        let (series, sum) =
            problem.with_factor(sizes, &scale, memory, observer, |positive, observer| {
                problem.series(positive, first, band.top(), at_rows, observer)
            })?;
        let residual = problem.residual(&forces, sum, band.top());
        if residual.is_nan() || residual > RESIDUAL_LIMIT {
            let limit = RESIDUAL_LIMIT;
            return Err(Shortfall::ReferenceResidual { residual, limit }.into());
        }
        let flexibility = rows.scaled_square(flexibility.as_ref());
        let (shapes, poles) = (at_rows(problem.kept.as_ref()), problem.poles);
        let response = Receptance::symmetric(poles.clone(), shapes, series, band.top());
        let what = |what| Error::NotFinite { what };
        let (independent, loose) = independent_rows(&rows, &flexibility, eigenvalues[0])
            .ok_or(what("the interfaces' flexibility"))?;
        let held = counted_eigenvalues(&response.between(&independent), &poles, loose, band.top())
            .ok_or(what("the held frequencies"))?;
        let beyond = element.modes.first_omitted_eigenvalue;
        let beyond = Some(beyond).filter(|value| value.is_finite());
        let free = eigenvalues.iter().copied().chain(beyond).collect();
        let spin = SpinStrain::of(component, &properties, element, stored);
        let Reduced {
            superelement,
            recovery,
            ..
        } = whole.reduced;
        Ok(Self {
            spin,
            terms: response.series.len(),
            free,
            rows,
            response,
            independent,
            flexibility,
            held,
            loose,
            band,
            residual,
            element: superelement,
            recovery,
        })
    }
}

/// Flexibility with the inertia relieved between all rows of L_b: that of the modes and what they leave.
fn static_flexibility(element: &Superelement) -> Mat<f64> {
    let (shapes, eigenvalues) = (&element.modes.interface_shapes, &element.modes.eigenvalues);
    let flexible = Mat::from_fn(shapes.nrows(), shapes.ncols(), |i, k| {
        shapes[(i, k)] / eigenvalues[k]
    });
    &element.residual.flexibility + flexible * shapes.transpose()
}

/// Independent combinations of the rows, and the number of rigid motions that holding them leaves.
fn independent_rows(
    rows: &InterfaceRows,
    flexibility: &Mat<f64>,
    eigenvalue: f64,
) -> Option<(Mat<f64>, usize)> {
    let inertia = faer::Scale(1.0 / eigenvalue) * (&rows.rigid * rows.rigid.transpose());
    let whole = symmetrized((flexibility + inertia).as_ref());
    let (values, vectors) = symmetric_eigen(whole.as_ref())?;
    let limit = DEPENDENT * values.last().copied().unwrap_or(0.0);
    let first = values.iter().filter(|value| **value <= limit).count();
    let independent = vectors.subcols(first, values.len() - first).to_owned();
    let (motions, _) = symmetric_eigen((rows.rigid.transpose() * &rows.rigid).as_ref())?;
    let limit = DEPENDENT * motions.last().copied().unwrap_or(0.0);
    let loose = motions.iter().filter(|motion| **motion <= limit).count();
    Some((independent, loose))
}

/// The matrices with the motions that are taken out of them.
struct Unreduced<'a> {
    model: &'a Model<'a>,
    /// Rigid motions and modes, M-orthonormal.
    kept: Mat<f64>,
    mass_kept: Mat<f64>,
    /// Their eigenvalues.
    poles: Vec<f64>,
}

impl<'a> Unreduced<'a> {
    fn of(
        model: &'a Model<'a>,
        rigid: &RigidBodyModes,
        eigenvalues: &[f64],
        modes: MatRef<'_, f64>,
    ) -> Self {
        let modes = model.contract(modes);
        let mut kept = Mat::zeros(model.len(), rigid.count() + eigenvalues.len());
        let (of_rigid, of_modes) = kept.as_mut().split_at_col_mut(rigid.count());
        copy(rigid.shapes.as_ref(), of_rigid);
        copy(modes.as_ref(), of_modes);
        let mut poles = vec![0.0; rigid.count()];
        poles.extend(eigenvalues);
        Self {
            model,
            mass_kept: symmetric_product(&model.mass, kept.as_ref()),
            kept,
            poles,
        }
    }

    /// Work with the factor of the stiffness at a shift, of as many modes; the factor is kept in memory or on disk and goes thereafter.
    fn with_factor<T>(
        &self,
        (localization, modes): (&Localization, usize),
        scale: &SpectrumScale,
        memory: &MemoryLimit,
        observer: &mut dyn Observer,
        work: impl FnOnce(&PositiveFactor, &mut dyn Observer) -> Result<T, Error>,
    ) -> Result<T, Error> {
        observer.enter(Stage::Order)?;
        let model = self.model;
        let mut factor = SymmetricFactor::analyse(&model.stiffness, &model.mass, &model.points())?;
        let modes = ModeSelection::Lowest(modes);
        let forecast = memory.fitted(Forecast::of(model, localization, &factor, modes));
        factor.keep_in(memory.choose(&forecast)?, memory.fallback(&forecast))?;
        observer.enter(Stage::Factor)?;
        let positive = match factor.factorize(&model.stiffness, &model.mass, scale.shift()) {
            Ok(positive) => positive,
            Err(why) => return Err(diagnosis::unfactorized(model, scale, &mut factor, why)),
        };
        observer.enter(Stage::Attachments)?;
        work(&positive, observer)
    }

    /// L_b X_j λ₀^j until nothing is left of them, and Σ_j λ₀^j X_j.
    fn series(
        &self,
        factor: &PositiveFactor,
        first: Mat<f64>,
        unit: f64,
        at_rows: impl Fn(MatRef<'_, f64>) -> Mat<f64>,
        observer: &mut dyn Observer,
    ) -> Result<(Vec<Mat<f64>>, Mat<f64>), Error> {
        let mut terms = vec![symmetrized(at_rows(first.as_ref()).as_ref())];
        let mut sum = first.clone();
        let mut columns = first;
        loop {
            let size = terms
                .last()
                .map_or(0.0, |term| largest_entry(term.as_ref()));
            // The scale makes the whole flexibility's diagonal about 1.
            if size <= LAST_TERM {
                return Ok((terms, sum));
            }
            if !size.is_finite() || terms.len() == MOST_TERMS {
                let (left, terms) = (size, terms.len());
                return Err(Shortfall::ReferenceSeries { left, terms }.into());
            }
            observer.advance((size.max(LAST_TERM).log10() / LAST_TERM.log10()).clamp(0.0, 1.0))?;
            columns = self.next(factor, &columns, unit)?;
            sum += &columns;
            terms.push(symmetrized(at_rows(columns.as_ref()).as_ref()));
        }
    }

    /// λ₀ G_res M X.
    fn next(
        &self,
        factor: &PositiveFactor,
        columns: &Mat<f64>,
        unit: f64,
    ) -> Result<Mat<f64>, Error> {
        let mut forces = faer::Scale(unit) * symmetric_product(&self.model.mass, columns.as_ref());
        self.project_force(&mut forces);
        let whole = column_norms(forces.as_ref());
        let mut found = Mat::<f64>::zeros(columns.nrows(), columns.ncols());
        let mut left = forces.clone();
        for _ in 0..PASSES {
            let mut step = left;
            factor.solve_in_place(step.as_mut())?;
            found += &step;
            self.project_motion(&mut found);
            left = &forces - symmetric_product(&self.model.stiffness, found.as_ref());
            self.project_force(&mut left);
            let worst = (column_norms(left.as_ref()).iter().zip(&whole))
                .map(|(left, whole)| if *whole > 0.0 { left / whole } else { 0.0 })
                .fold(0.0, f64::max);
            if worst <= TERM_RESIDUAL {
                break;
            }
        }
        Ok(found)
    }

    /// Residual of u(λ) in (K - λ M) u = f; `sum` is its part beyond the modes.
    fn residual(&self, forces: &Mat<f64>, sum: Mat<f64>, lambda: f64) -> f64 {
        let mut amounts = gram(self.kept.as_ref(), forces.as_ref());
        for (k, pole) in self.poles.iter().enumerate() {
            for j in 0..amounts.ncols() {
                amounts[(k, j)] /= pole - lambda;
            }
        }
        let mut motion = sum;
        add_combination(motion.as_mut(), self.kept.as_ref(), amounts.as_ref(), 1.0);
        let elastic = symmetric_product(&self.model.stiffness, motion.as_ref());
        let inertia = symmetric_product(&self.model.mass, motion.as_ref());
        let left = &elastic - faer::Scale(lambda) * inertia - forces;
        let [left, elastic, forces] =
            [&left, &elastic, forces].map(|columns| column_norms(columns.as_ref()));
        (0..left.len())
            .filter(|j| forces[*j] > 0.0)
            .map(|j| left[j] / (forces[j] + elastic[j]))
            .fold(0.0, |most: f64, one| {
                if one > most || one.is_nan() {
                    one
                } else {
                    most
                }
            })
    }

    fn project_force(&self, forces: &mut Mat<f64>) {
        for _ in 0..2 {
            let amounts = gram(self.kept.as_ref(), forces.as_ref());
            add_combination(
                forces.as_mut(),
                self.mass_kept.as_ref(),
                amounts.as_ref(),
                -1.0,
            );
        }
    }

    fn project_motion(&self, motion: &mut Mat<f64>) {
        let amounts = gram(self.mass_kept.as_ref(), motion.as_ref());
        add_combination(motion.as_mut(), self.kept.as_ref(), amounts.as_ref(), -1.0);
    }
}
