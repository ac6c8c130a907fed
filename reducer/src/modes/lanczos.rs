//! Block Lanczos on S = (K + σ M)⁻¹ M with the M inner product, full reorthogonalisation and thick restart. Without a shift K is held by
//! springs (`crate::model::regularization`), which the inertia of vectors without rigid motion doesn't feel.
//!
//! Rigid motions are deflated from geometry, never computed. Every basis vector is in the range of S, so a positive
//! *semi*-definite M (massless rotations, few integration points) has a place only for its motions with mass; what rounding leaves of
//! the others is told by its size and dropped. The projected matrix is computed as inner products of all
//! basis vectors with S V, not assembled from the recurrence, so rounding, dropped directions and injected random
//! blocks don't disturb it. Largest eigenvalues θ = 1/(λ + σ) of S are the lowest λ.

use dcb_dense::symmetric_eigen;
use dcb_sparse::block_algebra::{
    add_combination, column_dots, combination, copy, gram, symmetric_product,
    symmetric_product_into, zeros,
};
use dcb_sparse::factorization::PositiveFactor;
use dcb_sparse::krylov_basis::KrylovBasis;
use faer::{Mat, MatRef};
use rand_distr::{Distribution, StandardNormal};
use rand_pcg::Pcg64;
use rand_pcg::rand_core::SeedableRng;

use crate::error::Error;
use crate::model::condensation::Model;
use crate::model::mass_sign::diagonal;
use crate::model::rigid_body::RigidBodyModes;
use crate::modes::completeness::{CHANCE, KrylovSpace};
use crate::modes::orthonormal_block::orthonormalize;

/// A new direction whose M norm has fallen below this fraction of the block's before orthogonalisation is dropped.
const DEPENDENT: f64 = 1e-12;

/// A normalised direction that cleaning shortens below this was made of rounding and is dropped.
const ROUNDING: f64 = 0.5;
/// A block of which less than this fraction is left by cleaning is cleaned again: rounding in what was removed counts beside what is left.
const ENOUGH: f64 = 0.03;
/// A motion has mass if xᵀ M x is more than this part of xᵀ diag(M) x: elements keep more than 1e-4 in every motion that they give
/// mass, and rounding, or printing with ten digits, makes 1e-10 of those that they give none.
const MASSLESS: f64 = 1e-9;

/// Approximate eigenpairs of S.
pub struct RitzPairs {
    /// λ = 1/θ - σ, ascending.
    pub eigenvalues: Vec<f64>,
    /// Relative error bound of each pair's vector under S: ‖S x - θ x‖_M / θ.
    pub residuals: Vec<f64>,
    /// Coefficients over the basis, (basis, pairs).
    coefficients: Mat<f64>,
    /// What S makes of each pair's vector beyond θ times it, in the next block, (next block, pairs).
    leaving: Mat<f64>,
}

/// A Krylov basis that grows block by block.
pub struct Lanczos<'a> {
    model: &'a Model<'a>,
    rigid: &'a RigidBodyModes,
    factor: &'a PositiveFactor<'a>,
    shift: f64,
    /// diag(M), not negative.
    mass_diagonal: Vec<f64>,
    /// M-orthonormal basis in the first `filled` columns, then the next block in `width` more.
    basis: KrylovBasis,
    filled: usize,
    width: usize,
    /// M times the next block.
    mass_block: Mat<f64>,
    /// Vᵀ M S V over the `filled` columns.
    projected: Mat<f64>,
    /// Vᵀ M V - I over the `filled` columns, as far as it was measured.
    defect: Mat<f64>,
    defect_is_known: bool,
    /// Coupling of the next block to the last `S V` block, (width, columns of that block), and where that block stood.
    coupling: Mat<f64>,
    coupled_at: usize,
    random: Pcg64,
    /// R, the start block over the first block of the basis, as long as one Krylov space of all its columns is what the basis spans.
    start: Option<Mat<f64>>,
    block_width: usize,
    exhausted: bool,
}

impl<'a> Lanczos<'a> {
    /// Starts with a pseudo-random block of `block_width` columns; `capacity` bounds the basis.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`], [`Error::NotFinite`] if numbers overflowed.
    pub fn start(
        model: &'a Model,
        rigid: &'a RigidBodyModes,
        factor: &'a PositiveFactor,
        shift: f64,
        block_width: usize,
        capacity: usize,
        seed: u64,
    ) -> Result<Self, Error> {
        let n = model.len();
        let columns = capacity + block_width;
        let mut lanczos = Self {
            model,
            rigid,
            factor,
            shift,
            mass_diagonal: diagonal(&model.mass)
                .into_iter()
                .map(|mass| mass.max(0.0))
                .collect(),
            basis: KrylovBasis::with_capacity(n, columns)?,
            filled: 0,
            width: 0,
            mass_block: Mat::zeros(n, 0),
            projected: Mat::zeros(columns, columns),
            defect: Mat::zeros(columns, columns),
            defect_is_known: true,
            coupling: Mat::zeros(0, 0),
            coupled_at: 0,
            random: Pcg64::seed_from_u64(seed),
            start: None,
            block_width,
            exhausted: false,
        };
        let start = lanczos.inject_random_block()?;
        let is_whole = start.nrows() == block_width && start.ncols() == block_width;
        lanczos.start = is_whole.then_some(start);
        Ok(lanczos)
    }

    /// Whether the whole space that S can reach has been spanned.
    pub fn is_exhausted(&self) -> bool {
        self.exhausted
    }

    /// Vectors of the basis.
    pub fn column_count(&self) -> usize {
        self.filled
    }

    /// Whether another block fits.
    pub fn is_full(&self) -> bool {
        self.filled + self.width + self.block_width > self.basis.capacity()
    }

    /// `S x` without its rigid part, from M x.
    fn apply(&self, mass_times_x: Mat<f64>) -> Result<Mat<f64>, Error> {
        let mut y = mass_times_x;
        self.factor.solve_in_place(y.as_mut())?;
        self.rigid.project_out(&mut y);
        Ok(y)
    }

    /// One block step: applies S to the last block and orthonormalises the result into the next one.
    ///
    /// # Errors
    /// As [`Lanczos::start`].
    pub fn step(&mut self) -> Result<(), Error> {
        let mass_block = std::mem::replace(&mut self.mass_block, Mat::new());
        let (n, width) = mass_block.shape();
        // M times the image of the block, and M times the block.
        let mut inertia = zeros(n, 2 * width);
        copy(
            mass_block.as_ref(),
            inertia.as_mut().subcols_mut(width, width),
        );
        let mut image = self.apply(mass_block)?;
        symmetric_product_into(
            &self.model.mass,
            image.as_ref(),
            inertia.as_mut().subcols_mut(0, width),
        );
        let before = column_dots(image.as_ref(), inertia.as_ref().subcols(0, width));
        let first = self.filled;
        self.filled += self.width;
        let products = gram(self.vectors(), inertia.as_ref());
        drop(inertia);
        let mut amounts = products.as_ref().subcols(0, width).to_owned();
        self.measure(first, products.as_ref().subcols(width, width));
        let defect = self.defect.as_ref();
        amounts = &amounts - defect.submatrix(0, 0, self.filled, self.filled) * &amounts;
        let mut mass_image = zeros(n, width);
        self.remove(&mut image, amounts.as_ref(), &mut mass_image);
        let after = column_dots(image.as_ref(), mass_image.as_ref());
        let mut sizes = before.iter().zip(&after);
        let is_enough = sizes.all(|(before, after)| *after > ENOUGH * ENOUGH * before);
        if !(is_enough && self.defect_is_known) {
            amounts += self.clean(&mut image, &mut mass_image);
            self.defect_is_known = true;
        }
        let next = self.orthonormalized(image, mass_image, &before)?;
        for j in 0..amounts.ncols() {
            for i in 0..self.filled {
                let value = amounts[(i, j)];
                self.projected[(i, first + j)] = value;
                self.projected[(first + j, i)] = value;
            }
        }
        self.coupled_at = first;
        if next.vectors.ncols() < width {
            self.start = None;
        }
        self.accept_block(next);
        if self.width == 0 {
            self.inject_random_block()?;
        }
        Ok(())
    }

    /// The basis.
    pub(super) fn vectors(&self) -> MatRef<'_, f64> {
        self.basis.columns(0, self.filled)
    }

    /// Takes over Vᵀ M of the columns from `first` on.
    fn measure(&mut self, first: usize, products: MatRef<'_, f64>) {
        for j in 0..products.ncols() {
            for i in 0..products.nrows() {
                let whole = f64::from(u8::from(i == first + j));
                let value = products[(i, j)] - whole;
                self.defect[(i, first + j)] = value;
                self.defect[(first + j, i)] = value;
            }
        }
    }

    /// Removes amounts of the basis, and rigid motions, from a block; M times what is left.
    fn remove(&self, block: &mut Mat<f64>, amounts: MatRef<'_, f64>, mass_block: &mut Mat<f64>) {
        add_combination(block.as_mut(), self.vectors(), amounts, -1.0);
        // The basis carries rigid motion at rounding level, and every step would feed it back amplified.
        self.rigid.project_out(block);
        symmetric_product_into(&self.model.mass, block.as_ref(), mass_block.as_mut());
    }

    /// Removes the basis from a block, of which M times is known; returns how much it had.
    fn clean(&self, block: &mut Mat<f64>, mass_block: &mut Mat<f64>) -> Mat<f64> {
        let amounts = gram(self.vectors(), mass_block.as_ref());
        self.remove(block, amounts.as_ref(), mass_block);
        amounts
    }

    /// Continues with the images of fresh pseudo-random motions, orthogonal to everything so far: finds what the Krylov space missed. Returns
    /// what these images are over the new block, as far as they are not of the basis before.
    ///
    /// The motions are normal, divided by √diag(M), without rigid parts: what `crate::modes::completeness` is based on.
    ///
    /// # Errors
    /// As [`Lanczos::start`].
    fn inject_random_block(&mut self) -> Result<Mat<f64>, Error> {
        let width = self
            .block_width
            .min(self.basis.capacity().saturating_sub(self.filled));
        let mut motions = Mat::zeros(self.model.len(), width);
        for column in motions.col_iter_mut() {
            for (x, mass) in column.iter_mut().zip(&self.mass_diagonal) {
                let normal: f64 = StandardNormal.sample(&mut self.random);
                if *mass > 0.0 {
                    *x = normal / mass.sqrt();
                }
            }
        }
        self.rigid.project_out(&mut motions);
        let inertia = symmetric_product(&self.model.mass, motions.as_ref());
        let mut image = self.apply(inertia)?;
        let mut mass_image = symmetric_product(&self.model.mass, image.as_ref());
        let before = column_dots(image.as_ref(), mass_image.as_ref());
        for _ in 0..2 {
            self.clean(&mut image, &mut mass_image);
        }
        let mut next = self.orthonormalized(image, mass_image, &before)?;
        // A random block is coupled to nothing before it.
        let made_of = std::mem::replace(&mut next.coupling, Mat::zeros(next.vectors.ncols(), 0));
        self.exhausted = next.vectors.ncols() == 0;
        self.accept_block(next);
        Ok(made_of)
    }

    fn accept_block(&mut self, next: NextBlock) {
        self.width = next.vectors.ncols();
        self.basis.set(self.filled, next.vectors.as_ref());
        self.mass_block = next.mass_vectors;
        self.coupling = next.coupling;
    }

    /// Orthonormalises what cleaning has left of a block; `before` is its M norm before that, squared.
    fn orthonormalized(
        &self,
        mut block: Mat<f64>,
        mut mass_block: Mat<f64>,
        before: &[f64],
    ) -> Result<NextBlock, Error> {
        match orthonormalize(&mut block, &mut mass_block, before)? {
            Some(coupling) => Ok(NextBlock {
                vectors: block,
                mass_vectors: mass_block,
                coupling,
            }),
            None => Ok(self.orthonormalized_one_by_one(block, before)),
        }
    }

    /// Orthonormalises a block with nearly dependent columns: largest remainder first, each direction cleaned of the basis
    /// and of the rigid motions before it is used, so that small genuine directions are told from rounding.
    fn orthonormalized_one_by_one(&self, mut block: Mat<f64>, reference: &[f64]) -> NextBlock {
        let (n, width) = (block.nrows(), block.ncols());
        let scale: Vec<f64> = reference.iter().map(|r| r.max(0.0).sqrt()).collect();
        for (j, s) in scale.iter().enumerate() {
            let factor = if *s > 0.0 { 1.0 / s } else { 0.0 };
            block
                .as_mut()
                .col_mut(j)
                .iter_mut()
                .for_each(|x| *x *= factor);
        }
        let (mut vectors, mut mass_vectors) = (Mat::zeros(n, width), Mat::zeros(n, width));
        let mut coupling = Mat::zeros(width, width);
        let mut count = 0;
        for _ in 0..width {
            let mass_block = symmetric_product(&self.model.mass, block.as_ref());
            let norms = column_dots(block.as_ref(), mass_block.as_ref());
            let largest = (0..width).max_by(|a, b| norms[*a].total_cmp(&norms[*b]).then(b.cmp(a)));
            let Some(pivot) = largest.filter(|j| norms[*j] > DEPENDENT * DEPENDENT) else {
                break;
            };
            let mut v = block.as_ref().subcols(pivot, 1).to_owned();
            v *= faer::Scale(1.0 / norms[pivot].sqrt());
            let known = [
                self.basis.columns(0, self.filled),
                vectors.as_ref().subcols(0, count),
            ];
            for basis in known.into_iter().chain(known) {
                let amounts = gram(
                    basis,
                    symmetric_product(&self.model.mass, v.as_ref()).as_ref(),
                );
                add_combination(v.as_mut(), basis, amounts.as_ref(), -1.0);
            }
            self.rigid.project_out(&mut v);
            let mut mass_v = symmetric_product(&self.model.mass, v.as_ref());
            let norm = column_dots(v.as_ref(), mass_v.as_ref())[0].max(0.0).sqrt();
            if norm < ROUNDING {
                block.as_mut().col_mut(pivot).fill(0.0);
                continue;
            }
            v *= faer::Scale(1.0 / norm);
            mass_v *= faer::Scale(1.0 / norm);
            if MASSLESS * self.size(v.as_ref()) > 1.0 {
                block.as_mut().col_mut(pivot).fill(0.0);
                continue;
            }
            let row = gram(mass_v.as_ref(), block.as_ref());
            add_combination(block.as_mut(), v.as_ref(), row.as_ref(), -1.0);
            for (j, s) in scale.iter().enumerate() {
                coupling[(count, j)] = row[(0, j)] * s;
            }
            vectors.as_mut().col_mut(count).copy_from(v.col(0));
            mass_vectors
                .as_mut()
                .col_mut(count)
                .copy_from(mass_v.col(0));
            count += 1;
        }
        NextBlock {
            vectors: vectors.as_ref().subcols(0, count).to_owned(),
            mass_vectors: mass_vectors.as_ref().subcols(0, count).to_owned(),
            coupling: coupling.as_ref().subrows(0, count).to_owned(),
        }
    }

    /// xᵀ diag(M) x of one column.
    fn size(&self, x: MatRef<'_, f64>) -> f64 {
        let pairs = x.col(0).iter().zip(&self.mass_diagonal);
        pairs.map(|(x, mass)| mass * x * x).sum()
    }

    /// Eigenpairs of the projected matrix, best first.
    ///
    /// # Errors
    /// [`Error::NotFinite`] if numbers overflowed.
    pub fn ritz_pairs(&self) -> Result<RitzPairs, Error> {
        let m = self.filled;
        let (theta, vectors) = symmetric_eigen(self.projected.as_ref().submatrix(0, 0, m, m))
            .ok_or(Error::NotFinite {
                what: "the projected eigenproblem",
            })?;
        let order: Vec<usize> = (0..m).rev().filter(|i| theta[*i] > 0.0).collect();
        let coefficients = Mat::from_fn(m, order.len(), |i, j| vectors[(i, order[j])]);
        let last = coefficients
            .as_ref()
            .subrows(self.coupled_at, self.coupling.ncols());
        let leaving = &self.coupling * last;
        Ok(RitzPairs {
            eigenvalues: order.iter().map(|i| 1.0 / theta[*i] - self.shift).collect(),
            residuals: order
                .iter()
                .enumerate()
                .map(|(j, i)| leaving.col(j).norm_l2() / theta[*i])
                .collect(),
            coefficients,
            leaving,
        })
    }

    /// Whether S has no other eigenvalue from 1/(λ + σ) on, λ the `limit`, than the `found` best Ritz values, but for a chance of 10⁻¹². `rounding` is what
    /// rounding in K adds to an eigenvalue λ, `mass_part` the least part of uᵀ diag(M) u that is mass. False where that can't be told.
    pub fn has_all_below(
        &self,
        pairs: &RitzPairs,
        found: usize,
        limit: f64,
        rounding: f64,
        mass_part: f64,
    ) -> bool {
        let Some(start) = &self.start else {
            return false;
        };
        if pairs.eigenvalues.len() < self.filled {
            return false;
        }
        let inverse = |lambda: f64| 1.0 / (lambda + self.shift);
        let values: Vec<f64> = pairs.eigenvalues.iter().map(|l| inverse(*l)).collect();
        let first = pairs.coefficients.as_ref().subrows(0, start.nrows());
        let shares = start.transpose() * first;
        let space = KrylovSpace {
            values: &values,
            start: shares.as_ref(),
            leaving: pairs.leaving.as_ref(),
            chance: CHANCE,
            mass_part,
            rounding,
        };
        space.has_all(found, inverse(limit))
    }

    /// Whether the basis is one Krylov space of its start block, without which nothing is known of what it left out.
    pub fn is_of_one_start(&self) -> bool {
        self.start.is_some()
    }

    /// Whether a Ritz value can't be told from that of a motion without stiffness before its vector is sharpened.
    pub fn is_soft(&self, eigenvalue: f64) -> bool {
        eigenvalue <= self.shift
    }

    /// The first `count` Ritz vectors, (n_c, count).
    pub fn ritz_vectors(&self, pairs: &RitzPairs, count: usize) -> Mat<f64> {
        let coefficients = pairs.coefficients.as_ref().subcols(0, count);
        combination(self.basis.columns(0, self.filled), coefficients)
    }

    /// Thick restart: keeps the first `count` Ritz vectors and the next block, and forgets the rest.
    pub fn restart(&mut self, pairs: &RitzPairs, count: usize) {
        let kept = self.ritz_vectors(pairs, count);
        self.basis.shift(self.filled, count, self.width);
        self.basis.set(0, kept.as_ref());
        self.projected.fill(0.0);
        for (i, lambda) in pairs.eigenvalues.iter().take(count).enumerate() {
            self.projected[(i, i)] = 1.0 / (lambda + self.shift);
        }
        // Couplings of the kept vectors to the next block: the next step computes them as inner products. Until then
        // the coupling that residuals are judged by is the old one, seen from the kept vectors.
        let last =
            pairs
                .coefficients
                .as_ref()
                .submatrix(self.coupled_at, 0, self.coupling.ncols(), count);
        self.coupling = &self.coupling * last;
        self.coupled_at = 0;
        self.filled = count;
        self.defect.fill(0.0);
        self.defect_is_known = false;
        self.start = None;
    }

    /// One step of inverse iteration on any block: `(K + σ M)⁻¹ M x` without its rigid part, with M times the result.
    pub fn polish(&self, x: MatRef<'_, f64>) -> Result<Mat<f64>, Error> {
        self.apply(symmetric_product(&self.model.mass, x))
    }
}

/// An M-orthonormal block, `old = vectors · coupling`.
struct NextBlock {
    vectors: Mat<f64>,
    mass_vectors: Mat<f64>,
    coupling: Mat<f64>,
}
