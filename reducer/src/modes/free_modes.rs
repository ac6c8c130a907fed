//! Free-free elastic modes: the lowest eigenpairs of K φ = ω² M φ that are M-orthogonal to the rigid motions.
//!
//! Lanczos (`crate::modes::lanczos`) finds the subspace, one step of inverse iteration on its less accurate vectors and a Rayleigh–Ritz
//! step on K and M themselves sharpen it, and the true residuals decide. A multiple root's copies stay together: the number of
//! modes is raised to the next gap. Signs, and the basis inside a multiple root, follow a fixed rule (`crate::modes::multiplet`).

use dcb_dense::{symmetric_eigen, symmetrized};
use dcb_formats::SparseMatrix;
use dcb_sparse::block_algebra::{
    add_scaled_columns, column_norms, combination, gram, set_columns, some_columns,
    symmetric_product, symmetric_product_into, turn,
};
use dcb_sparse::column_products::BLOCK;
use dcb_sparse::factorization::PositiveFactor;
use dcb_superelement::extended_to_gap;
use faer::{Mat, MatRef, concat};

use crate::error::{Error, MatrixRefusal};
use crate::model::condensation::Model;
use crate::model::rigid_body::RigidBodyModes;
use crate::model::shift::AbsoluteForces;
use crate::modes::certificate::prove_by_search;
use crate::modes::lanczos::{Lanczos, RitzPairs};
use crate::modes::multiplet::{canonical_basis, clusters};
use crate::observer::Observer;
use crate::resources::basis_size::{BasisSize, block_width};

/// Ritz pairs, an eigenproblem as large as the basis, are looked at from so many halves of the wanted modes' number of vectors on,
const WORTH_A_LOOK: usize = 3;
/// and then after each of these parts of it: many modes would cost as much time for that as for the basis.
const LOOKS_APART: usize = 24;
/// Largest ‖K φ - ω² M φ‖ / ‖K φ‖ of an accepted mode, where double precision can tell that much.
pub const RESIDUAL_TOLERANCE: f64 = 1e-8;
/// Otherwise the residual may be this many times the rounding in K φ itself, ε ‖|K| |φ|‖ / ‖K φ‖ (slender and thin parts).
pub const RESIDUAL_OVER_ROUNDING: f64 = 10.0;
/// An eigenvalue below this many times the rounding in its own Rayleigh quotient is a zero: a mechanism or a loose piece.
pub const ZERO_OVER_ROUNDING: f64 = 1e3;
/// The same for entries that are known to fewer digits: the bound itself is rarely reached.
const ZERO_OVER_PRECISION: f64 = 3.0;
/// A Ritz value below this fraction of the shift may be a zero; the sharpened value decides.
const ZERO_BESIDE_SHIFT: f64 = 1e-8;
/// The eigenvalue count is made this far below the first eigenvalue left out, relatively, or in the middle of a narrower gap.
const CERTIFICATE_ROOM: f64 = 1e-2;
/// A direction with this part of the M-norm² of sharpened vectors, which are nearly orthogonal, is none of its own: a motion without mass
/// that rounding took for a mode, and sharpening turned into low ones.
const DEPENDENT: f64 = 1e-6;
/// How often the whole space is sharpened before the last time.
const SHARPENED_AGAIN: usize = 2;
/// Wanted accuracy of a Ritz vector under S.
const RITZ_TOLERANCE: f64 = 1e-8;
/// A Ritz vector of this accuracy is as good as rounding allows; sharpening it would gain nothing.
const SHARP: f64 = 1e-12;

/// Which search a factorization serves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Search {
    /// Number of lowest modes wanted (more are returned where that would cut a multiple root).
    pub wanted: usize,
    /// How often the search was made before and missed modes: widens the block and changes the start.
    pub attempt: usize,
    /// Copies that one root may have, by the searches before: those found of any, and all modes that they missed. Only a block as wide
    /// finds them together. 0 where nothing was missed.
    pub copies: usize,
    /// How large the Krylov basis is.
    pub basis: BasisSize,
    /// Part of uᵀ diag(M) u that at least is mass of every motion u; where that isn't known, a search can't tell that it found all.
    pub mass_part: Option<f64>,
}

impl Search {
    /// The first search for the `wanted` lowest modes, with no limit of memory.
    pub fn lowest(wanted: usize) -> Self {
        Self {
            wanted,
            attempt: 0,
            copies: 0,
            basis: BasisSize::Comfortable,
            mass_part: None,
        }
    }
}

/// Motions without stiffness that are known before the search.
#[derive(Clone, Copy)]
pub struct KnownMotions<'a> {
    /// Those of the whole, which are no modes.
    pub rigid: &'a RigidBodyModes,
    /// Those of its pieces beyond these, M-orthonormal to each other and to them, (n_c, l): the first modes.
    pub loose: &'a Mat<f64>,
}

/// Kept modes of the model, mass-normalised.
#[derive(Clone, Debug)]
pub struct FreeModes {
    /// Φ over the model's dofs, (n_c, n_k).
    pub shapes: Mat<f64>,
    /// M Φ, (n_c, n_k).
    pub mass_shapes: Mat<f64>,
    /// ω², ascending; exact zeros for mechanism modes.
    pub eigenvalues: Vec<f64>,
    /// ‖K φ - ω² M φ‖ / ‖K φ‖ per mode; 0 for mechanism modes.
    pub residuals: Vec<f64>,
    /// ε ‖|K| |φ|‖ / ‖K φ‖ per mode: what rounding alone does to the residual; 0 for mechanism modes.
    pub residual_roundings: Vec<f64>,
    /// ε |φ|ᵀ |K| |φ| / ω² per mode: what rounding in K can do to the eigenvalue, relatively; 0 for mechanism modes.
    pub eigenvalue_roundings: Vec<f64>,
    /// How many of the first modes are mechanism or loose-piece modes without stiffness.
    pub zero_count: usize,
    /// The lowest eigenvalue left out; infinite if every finite mode is kept.
    pub first_omitted: f64,
    /// Block steps made.
    pub iterations: usize,
    /// Modes added because the wanted number would have cut a multiple root.
    pub added_for_cluster: usize,
    /// An eigenvalue below which there are no others, but for a chance of 10⁻¹², if the search itself can tell.
    pub complete_below: Option<f64>,
}

impl FreeModes {
    /// Finds the lowest modes.
    ///
    /// # Errors
    /// [`Error::ModesNotConverged`], or those of [`Lanczos`]; [`Error::Matrix`] if a negative eigenvalue shows the stiffness to be indefinite.
    pub fn compute(
        model: &Model,
        known: KnownMotions<'_>,
        factor: &PositiveFactor,
        shift: f64,
        search: Search,
        observer: &mut dyn Observer,
    ) -> Result<Self, Error> {
        let n = model.len();
        let KnownMotions { rigid, loose } = known;
        if rigid.count() + loose.ncols() >= n {
            return Self::of_subspace(model, known, Mat::zeros(n, 0), 0, search.wanted, 0);
        }
        let joined = rigid.joined_by(model, loose);
        let elastic = search.wanted.saturating_sub(loose.ncols());
        let block = (block_width(elastic) << search.attempt)
            .max(search.copies + block_width(elastic))
            .min(n);
        let mut guarded = elastic + block;
        let capacity = |guarded: usize| search.basis.columns(guarded, block).min(n + block);
        let seed = 0x5eed + search.attempt as u64;
        let start = |guarded: usize| {
            let capacity = capacity(guarded);
            Lanczos::start(model, &joined, factor, shift, block, capacity, seed)
        };
        let mut lanczos = start(guarded)?;
        let step_limit = 200 + 20 * guarded / block;
        let mut iterations = 0;
        let mut tolerance = RITZ_TOLERANCE;
        // The basis at which its Ritz pairs are looked at next.
        let mut due = WORTH_A_LOOK * (elastic + 2) / 2;
        let mut progress = 0.0;
        loop {
            // Without room for another block the best vectors restart the basis.
            if lanczos.is_full() {
                let pairs = lanczos.ritz_pairs()?;
                let keep = (guarded + block)
                    .min(pairs.eigenvalues.len())
                    .min(capacity(guarded).saturating_sub(2 * block));
                lanczos.restart(&pairs, keep);
                due = 0;
            }
            if !lanczos.is_exhausted() {
                lanczos.step()?;
                iterations += 1;
            }
            let is_last = lanczos.is_exhausted() || lanczos.is_full() || iterations >= step_limit;
            if lanczos.column_count() < due && !is_last {
                observer.advance(progress)?;
                continue;
            }
            due = lanczos.column_count() + lanczos.column_count() / LOOKS_APART;
            let pairs = lanczos.ritz_pairs()?;
            let available = pairs.eigenvalues.len();
            // Where a multiple root ends shows only on converged values: two beyond the last kept one.
            let without_energy = motions_without_energy(&pairs.eigenvalues, shift);
            let kept = extended_to_gap(&pairs.eigenvalues, elastic.max(without_energy));
            let needed = (kept + 2).min(available);
            let converged = pairs
                .residuals
                .iter()
                .take(needed)
                .take_while(|r| **r < tolerance)
                .count();
            progress = converged as f64 / (kept + 2) as f64;
            observer.advance(progress)?;
            let complete = lanczos.is_exhausted() || (available >= kept + 2 && converged == needed);
            if !complete && iterations < step_limit {
                continue;
            }
            if kept + 2 > guarded && !lanczos.is_exhausted() && complete {
                // The multiple root reaches beyond the guard vectors: look further before deciding where it ends.
                guarded = kept + 2 * block;
                drop(lanczos);
                lanczos = start(guarded)?;
                continue;
            }
            let sharp = match lanczos.is_exhausted() {
                true => 0.0,
                false => SHARP,
            };
            let mut x = sharpened(&lanczos, &pairs, kept, sharp)?;
            let mut modes = Self::of_subspace(model, known, x, kept, search.wanted, iterations)?;
            if modes.unconverged().count() > 0 && sharp > 0.0 {
                x = sharpened(&lanczos, &pairs, kept, 0.0)?;
                modes = Self::of_subspace(model, known, x, kept, search.wanted, iterations)?;
            }
            if modes.unconverged().count() == 0 {
                if let Some(part) = search.mass_part {
                    let refined = factor.least_accurate().residual / f64::EPSILON;
                    let rounding = modes.rounding() * refined.max(1.0);
                    prove_by_search(&mut modes, &mut lanczos, pairs, kept, rounding, part)?;
                }
                return Ok(modes);
            }
            if lanczos.is_exhausted() {
                let whole = sharpened_again(model, &lanczos, &pairs)?;
                return Self::of_subspace(model, known, whole, kept, search.wanted, iterations);
            }
            if iterations >= step_limit {
                return Err(modes.not_converged(kept));
            }
            tolerance *= 1e-2;
        }
    }

    /// Rayleigh–Ritz and the fixed basis rule on a polished subspace: the `kept` lowest pairs and a few further ones, all
    /// without rigid and `loose` motion; the loose ones come before them.
    pub(crate) fn of_subspace(
        model: &Model,
        known: KnownMotions<'_>,
        x: Mat<f64>,
        kept: usize,
        wanted: usize,
        iterations: usize,
    ) -> Result<Self, Error> {
        let KnownMotions { rigid, loose } = known;
        let (mut eigenvalues, mut x) = rayleigh_ritz(model, x)?;
        if loose.ncols() > 0 {
            x = concat![[loose, x]];
            eigenvalues.splice(0..0, vec![0.0; loose.ncols()]);
        }
        let kept = (loose.ncols() + kept).min(eigenvalues.len());
        let bounds = AbsoluteForces::of(&model.stiffness, x.as_ref().subcols(0, kept));
        let absolute = &bounds.energies;
        let precision = rigid.stiffness_precision;
        let zero = (ZERO_OVER_ROUNDING * f64::EPSILON).max(ZERO_OVER_PRECISION * precision);
        if let Some(j) = (0..kept).find(|j| eigenvalues[*j] < -zero * absolute[*j]) {
            return Err(MatrixRefusal::NegativeEigenvalue {
                eigenvalue: eigenvalues[j],
                place: model.dof_name(largest_dof(x.as_ref().subcols(j, 1))),
            }
            .into());
        }
        let zero_count = (0..kept)
            .take_while(|j| *j < loose.ncols() || eigenvalues[*j] < zero * absolute[*j])
            .count();
        let first_omitted = eigenvalues.get(kept).copied().unwrap_or(f64::INFINITY);
        let mut eigenvalues = eigenvalues[..kept].to_vec();
        eigenvalues[..zero_count].fill(0.0);
        x.truncate(model.len(), kept);
        let mut shapes = x;
        for (first, count) in clusters(&eigenvalues) {
            canonical_basis(shapes.as_mut().subcols_mut(first, count), |dof| {
                model.is_internal(dof)
            });
        }
        rigid.project_out(&mut shapes);
        let mass_shapes = symmetric_product(&model.mass, shapes.as_ref());
        let (residuals, residual_roundings) = residuals(
            &model.stiffness,
            shapes.as_ref(),
            mass_shapes.as_ref(),
            &eigenvalues,
            zero_count,
            &bounds.norms,
            precision,
        );
        let eigenvalue_roundings = (0..kept)
            .map(|j| {
                if j < zero_count {
                    0.0
                } else {
                    precision * absolute[j] / eigenvalues[j]
                }
            })
            .collect();
        Ok(Self {
            shapes,
            mass_shapes,
            eigenvalues,
            residuals,
            residual_roundings,
            eigenvalue_roundings,
            zero_count,
            first_omitted,
            iterations,
            added_for_cluster: kept.saturating_sub(wanted.max(zero_count)),
            complete_below: None,
        })
    }

    /// n_k.
    pub fn count(&self) -> usize {
        self.eigenvalues.len()
    }

    /// The most that rounding in K adds to one of their ω², 1/time²; 0 if none has stiffness.
    fn rounding(&self) -> f64 {
        let pairs = self.eigenvalue_roundings.iter().zip(&self.eigenvalues);
        pairs
            .map(|(relative, value)| relative * value)
            .fold(0.0, f64::max)
    }

    /// Modes whose residual is above both limits.
    pub(crate) fn unconverged(&self) -> impl Iterator<Item = usize> {
        (0..self.count())
            .filter(|j| !residual_is_accepted(self.residuals[*j], self.residual_roundings[*j]))
    }

    fn not_converged(&self, wanted: usize) -> Error {
        let residuals = self.unconverged().map(|j| self.residuals[j]);
        Error::ModesNotConverged {
            converged: self.count() - self.unconverged().count(),
            wanted,
            iterations: self.iterations,
            residual: residuals.fold(0.0, f64::max),
            tolerance: RESIDUAL_TOLERANCE,
        }
    }

    /// Most copies of a root among them.
    pub fn largest_multiplicity(&self) -> usize {
        let runs = clusters(&self.eigenvalues).into_iter();
        runs.map(|(_, count)| count).max().unwrap_or(0)
    }

    /// Where an eigenvalue count certifies the kept modes, and how far it may be moved: in the gap above the highest one, close to the
    /// first one left out, because the count bounds that from below; or above all if every finite mode is kept. `None` for a part without
    /// elastic motion.
    pub fn certificate_shift(&self) -> Option<(f64, f64)> {
        let last = self.eigenvalues.last().copied().unwrap_or(0.0);
        if self.first_omitted.is_finite() {
            let half_gap = 0.5 * (self.first_omitted - last);
            let room = half_gap.min(CERTIFICATE_ROOM * self.first_omitted);
            Some((self.first_omitted - room, room))
        } else {
            (last > 0.0).then_some((2.0 * last, last))
        }
    }
}

/// The `kept` lowest Ritz vectors, and two more, which tell where the spectrum goes on: after an inverse iteration those that are less
/// accurate than `sharp`, and those that may have no stiffness.
fn sharpened(
    lanczos: &Lanczos,
    pairs: &RitzPairs,
    kept: usize,
    sharp: f64,
) -> Result<Mat<f64>, Error> {
    let subspace = (kept + 2).min(pairs.eigenvalues.len());
    let mut x = lanczos.ritz_vectors(pairs, subspace);
    let is_blunt =
        |j: &usize| pairs.residuals[*j] >= sharp || lanczos.is_soft(pairs.eigenvalues[*j]);
    let blunt: Vec<usize> = (0..subspace).filter(is_blunt).collect();
    if blunt.is_empty() {
        return Ok(x);
    }
    if blunt.len() == subspace {
        return lanczos.polish(x.as_ref());
    }
    let some = lanczos.polish(some_columns(x.as_ref(), &blunt).as_ref())?;
    set_columns(x.as_mut(), &blunt, some.as_ref());
    Ok(x)
}

/// Every Ritz vector of a basis that spans all that S reaches, sharpened until rounding in the basis is gone.
///
/// The last vectors of such a basis may be made of rounding: motions with hardly any mass, which are large for their M norm. Sharpening and
/// the Rayleigh–Ritz step drop them, but spread parts of motions without mass over the others, 1e-5 of them. Inverse iteration
/// takes those out of vectors that are of ordinary size; and in the whole space nothing depends on gaps.
fn sharpened_again(model: &Model, lanczos: &Lanczos, pairs: &RitzPairs) -> Result<Mat<f64>, Error> {
    let mut x = lanczos.ritz_vectors(pairs, pairs.eigenvalues.len());
    for _ in 0..SHARPENED_AGAIN {
        (_, x) = rayleigh_ritz(model, lanczos.polish(x.as_ref())?)?;
    }
    lanczos.polish(x.as_ref())
}

/// Values that can't be told from zero beside the shift. They are kept whatever is wanted: static flexibility exists only
/// in the complement of every motion without energy.
pub(crate) fn motions_without_energy(eigenvalues: &[f64], shift: f64) -> usize {
    eigenvalues
        .iter()
        .take_while(|lambda| **lambda < ZERO_BESIDE_SHIFT * shift)
        .count()
}

/// Eigenpairs of (XᵀKX, XᵀMX), ascending, M-orthonormal: as many as X has independent columns.
fn rayleigh_ritz(model: &Model, x: Mat<f64>) -> Result<(Vec<f64>, Mat<f64>), Error> {
    if x.ncols() == 0 {
        return Ok((Vec::new(), x));
    }
    let failed = || Error::NotFinite {
        what: "the Rayleigh–Ritz step",
    };
    let mut mass_x = symmetric_product(&model.mass, x.as_ref());
    let mut x = x;
    // Orthonormalised twice: the second time removes what rounding left of the first. M x turns with x.
    for _ in 0..2 {
        let mass = symmetrized(gram(x.as_ref(), mass_x.as_ref()).as_ref());
        // Columns of comparable size before the small eigenproblem.
        let sizes: Vec<f64> = (0..mass.ncols())
            .map(|j| mass[(j, j)].max(0.0).sqrt())
            .map(|size| if size > 0.0 { size } else { 1.0 })
            .collect();
        let scaled = Mat::from_fn(mass.nrows(), mass.ncols(), |i, j| {
            mass[(i, j)] / (sizes[i] * sizes[j])
        });
        let (values, vectors) = symmetric_eigen(scaled.as_ref()).ok_or_else(failed)?;
        let dependent = values.iter().filter(|value| **value < DEPENDENT).count();
        let forward = Mat::from_fn(vectors.nrows(), vectors.ncols() - dependent, |i, j| {
            vectors[(i, dependent + j)] / (sizes[i] * values[dependent + j].sqrt())
        });
        if dependent == 0 {
            turn(x.as_mut(), forward.as_ref());
            turn(mass_x.as_mut(), forward.as_ref());
        } else {
            x = combination(x.as_ref(), forward.as_ref());
            mass_x = combination(mass_x.as_ref(), forward.as_ref());
        }
    }
    let mut forces = mass_x;
    symmetric_product_into(&model.stiffness, x.as_ref(), forces.as_mut());
    let stiffness = symmetrized(gram(x.as_ref(), forces.as_ref()).as_ref());
    let (values, vectors) = symmetric_eigen(stiffness.as_ref()).ok_or_else(failed)?;
    turn(x.as_mut(), vectors.as_ref());
    Ok((values, x))
}

/// Whether a mode's residual is as small as it should be, or as rounding allows.
pub fn residual_is_accepted(residual: f64, rounding: f64) -> bool {
    residual <= RESIDUAL_TOLERANCE.max(RESIDUAL_OVER_ROUNDING * rounding)
}

/// ‖K φ - ω² M φ‖ / ‖K φ‖ per column, and the part of it that the precision ε of K's entries explains, ε ‖|K| |φ|‖ / ‖K φ‖, from
/// the norms of |K| |φ|.
pub fn residuals(
    stiffness: &SparseMatrix,
    shapes: MatRef<'_, f64>,
    mass_shapes: MatRef<'_, f64>,
    eigenvalues: &[f64],
    zero_count: usize,
    absolute_norms: &[f64],
    precision: f64,
) -> (Vec<f64>, Vec<f64>) {
    let (mut norms, mut left) = (Vec::new(), Vec::new());
    let opposite: Vec<f64> = eigenvalues.iter().map(|eigenvalue| -eigenvalue).collect();
    for first in (0..shapes.ncols()).step_by(BLOCK) {
        let count = BLOCK.min(shapes.ncols() - first);
        let mut forces = symmetric_product(stiffness, shapes.subcols(first, count));
        norms.extend(column_norms(forces.as_ref()));
        add_scaled_columns(
            forces.as_mut(),
            &opposite[first..first + count],
            mass_shapes.subcols(first, count),
        );
        left.extend(column_norms(forces.as_ref()));
    }
    let relative = |sizes: &[f64], factor: f64| {
        let mut ratios: Vec<f64> = sizes
            .iter()
            .zip(&norms)
            .map(|(value, norm)| factor * value / norm.max(f64::MIN_POSITIVE))
            .collect();
        ratios[..zero_count].fill(0.0);
        ratios
    };
    (relative(&left, 1.0), relative(absolute_norms, precision))
}

/// The dof that moves most.
fn largest_dof(x: MatRef<'_, f64>) -> usize {
    (0..x.nrows())
        .max_by(|a, b| x[(*a, 0)].abs().total_cmp(&x[(*b, 0)].abs()))
        .unwrap_or(0)
}
