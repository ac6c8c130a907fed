//! Block Lanczos on S = (K + σ M)⁻¹ M with the M inner product, full reorthogonalisation and thick restart.
//!
//! Rigid motions are deflated from geometry, never computed. Every basis vector is in the range of S, so a positive
//! *semi*-definite M (massless rotations) needs no special care. The projected matrix is computed as inner products of all
//! basis vectors with S V, not assembled from the recurrence, so rounding, dropped directions and injected random
//! blocks don't disturb it. Largest eigenvalues θ = 1/(λ + σ) of S are the lowest λ.

use faer::{Mat, MatRef};

use crate::block_algebra::{add_combination, combination, gram, symmetric_eigen, symmetric_product};
use crate::condensation::Model;
use crate::error::Error;
use crate::factorization::PositiveFactor;
use crate::rigid_body::RigidBodyModes;

/// A new direction whose M norm has fallen below this fraction of the block's before orthogonalisation is dropped.
const DEPENDENT: f64 = 1e-12;

/// Approximate eigenpairs of S.
pub struct RitzPairs {
    /// λ = 1/θ - σ, ascending.
    pub eigenvalues: Vec<f64>,
    /// Relative error bound of each pair's vector under S: ‖S x - θ x‖_M / θ.
    pub residuals: Vec<f64>,
    /// Coefficients over the basis, (basis, pairs).
    coefficients: Mat<f64>,
}

/// A Krylov basis that grows block by block.
pub struct Lanczos<'a> {
    model: &'a Model<'a>,
    rigid: &'a RigidBodyModes,
    factor: &'a PositiveFactor<'a>,
    shift: f64,
    /// M-orthonormal basis in the first `filled` columns, then the next block in `width` more.
    basis: Mat<f64>,
    filled: usize,
    width: usize,
    /// M times the next block.
    mass_block: Mat<f64>,
    /// Vᵀ M S V over the `filled` columns.
    projected: Mat<f64>,
    /// Coupling of the next block to the last `S V` block, (width, columns of that block), and where that block stood.
    coupling: Mat<f64>,
    coupled_at: usize,
    random_state: u64,
    block_width: usize,
    exhausted: bool,
}

impl<'a> Lanczos<'a> {
    /// Starts with a pseudo-random block of `block_width` columns; `capacity` bounds the basis.
    ///
    /// # Errors
    /// [`Error::NotPositive`] if the mass matrix is indefinite on the block.
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
        let mut lanczos = Self {
            model,
            rigid,
            factor,
            shift,
            basis: Mat::zeros(n, capacity + block_width),
            filled: 0,
            width: 0,
            mass_block: Mat::zeros(n, 0),
            projected: Mat::zeros(capacity + block_width, capacity + block_width),
            coupling: Mat::zeros(0, 0),
            coupled_at: 0,
            random_state: seed,
            block_width,
            exhausted: false,
        };
        lanczos.inject_random_block()?;
        Ok(lanczos)
    }

    /// Whether the whole space that S can reach has been spanned.
    pub fn is_exhausted(&self) -> bool {
        self.exhausted
    }

    /// Whether another block fits.
    pub fn is_full(&self) -> bool {
        self.filled + self.width + self.block_width > self.basis.ncols()
    }

    /// `S x` without its rigid part.
    fn apply(&self, mass_times_x: MatRef<'_, f64>) -> Mat<f64> {
        let mut y = mass_times_x.to_owned();
        self.factor.solve_in_place(y.as_mut());
        self.rigid.project_out(&mut y);
        y
    }

    /// One block step: applies S to the last block and orthonormalises the result into the next one.
    ///
    /// # Errors
    /// As [`Lanczos::start`].
    pub fn step(&mut self) -> Result<(), Error> {
        let image = self.apply(self.mass_block.as_ref());
        let first = self.filled;
        self.filled += self.width;
        let known = self.filled;
        let (next, amounts) = self.orthogonalized(image)?;
        for j in 0..amounts.ncols() {
            for i in 0..known {
                let value = amounts[(i, j)];
                self.projected[(i, first + j)] = value;
                self.projected[(first + j, i)] = value;
            }
        }
        self.coupled_at = first;
        self.accept_block(next.vectors, next.coupling);
        if self.width == 0 {
            self.inject_random_block()?;
        }
        Ok(())
    }

    /// Continues with a fresh pseudo-random block, orthogonal to everything so far: finds what the Krylov space missed.
    ///
    /// # Errors
    /// As [`Lanczos::start`].
    pub fn inject_random_block(&mut self) -> Result<(), Error> {
        let width = self.block_width.min(self.basis.ncols().saturating_sub(self.filled));
        let state = &mut self.random_state;
        let random = Mat::from_fn(self.model.len(), width, |_, _| {
            *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (*state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        });
        let mass_random = symmetric_product(&self.model.mass, random.as_ref());
        let image = self.apply(mass_random.as_ref());
        let (next, _) = self.orthogonalized(image)?;
        let columns = next.vectors.ncols();
        self.exhausted = columns == 0;
        self.accept_block(next.vectors, Mat::zeros(columns, 0));
        Ok(())
    }

    fn accept_block(&mut self, vectors: Mat<f64>, coupling: Mat<f64>) {
        self.width = vectors.ncols();
        self.basis.as_mut().subcols_mut(self.filled, self.width).copy_from(&vectors);
        self.mass_block = symmetric_product(&self.model.mass, vectors.as_ref());
        self.coupling = coupling;
    }

    /// Removes the basis from a block (twice) and orthonormalises what is left. Returns the new block with its coupling
    /// to the old one and the amounts removed.
    fn orthogonalized(&self, mut block: Mat<f64>) -> Result<(NextBlock, Mat<f64>), Error> {
        let known = self.basis.as_ref().subcols(0, self.filled);
        let before = self.mass_norms_squared(&block);
        let mut amounts = Mat::zeros(self.filled, block.ncols());
        for _ in 0..2 {
            amounts += self.remove(known, &mut block);
        }
        let (first, first_coupling) = self.orthonormalized(block, &before)?;
        // Directions that were nearly dependent carry the rounding of what was removed: clean and normalise once more.
        let mut cleaned = first;
        self.remove(known, &mut cleaned);
        self.rigid.project_out(&mut cleaned);
        let ones = vec![1.0; cleaned.ncols()];
        let (vectors, second_coupling) = self.orthonormalized(cleaned, &ones)?;
        let coupling = &second_coupling * &first_coupling;
        Ok((NextBlock { vectors, coupling }, amounts))
    }

    fn remove(&self, known: MatRef<'_, f64>, block: &mut Mat<f64>) -> Mat<f64> {
        let mass_block = symmetric_product(&self.model.mass, block.as_ref());
        let amounts = gram(known, mass_block.as_ref());
        add_combination(block.as_mut(), known, amounts.as_ref(), -1.0);
        amounts
    }

    fn mass_norms_squared(&self, block: &Mat<f64>) -> Vec<f64> {
        let mass_block = symmetric_product(&self.model.mass, block.as_ref());
        (0..block.ncols()).map(|j| block.col(j).transpose() * mass_block.col(j)).collect()
    }

    /// `block = vectors · coupling` with M-orthonormal vectors; directions below [`DEPENDENT`] of `reference` are dropped.
    fn orthonormalized(&self, block: Mat<f64>, reference: &[f64]) -> Result<(Mat<f64>, Mat<f64>), Error> {
        // Columns scaled to their size before orthogonalisation, so that none is dropped for its own smallness.
        let scale: Vec<f64> = reference.iter().map(|r| if *r > 0.0 { r.sqrt() } else { f64::INFINITY }).collect();
        let mass_block = symmetric_product(&self.model.mass, block.as_ref());
        let plain = gram(block.as_ref(), mass_block.as_ref());
        let scaled = Mat::from_fn(plain.nrows(), plain.ncols(), |i, j| {
            0.5 * (plain[(i, j)] + plain[(j, i)]) / (scale[i] * scale[j])
        });
        let (values, vectors) =
            symmetric_eigen(scaled.as_ref()).ok_or(Error::NotFinite { what: "orthonormalising a Lanczos block" })?;
        let largest = values.last().copied().unwrap_or(0.0);
        if let Some(smallest) = values.first().copied().filter(|value| *value < -1e-8 * largest.max(1e-8)) {
            return Err(Error::NotPositive { what: "the mass matrix", smallest, largest, tolerance: 1e-8 });
        }
        let kept: Vec<usize> = (0..values.len()).filter(|i| values[*i] > DEPENDENT * DEPENDENT).rev().collect();
        let forward = Mat::from_fn(values.len(), kept.len(), |i, j| {
            vectors[(i, kept[j])] / (values[kept[j]].sqrt() * scale[i])
        });
        let backward = Mat::from_fn(kept.len(), values.len(), |i, j| {
            let s = if scale[j].is_finite() { scale[j] } else { 0.0 };
            vectors[(j, kept[i])] * values[kept[i]].sqrt() * s
        });
        Ok((combination(block.as_ref(), forward.as_ref()), backward))
    }

    /// Eigenpairs of the projected matrix, best first.
    ///
    /// # Errors
    /// [`Error::NotFinite`] if numbers overflowed.
    pub fn ritz_pairs(&self) -> Result<RitzPairs, Error> {
        let m = self.filled;
        let (theta, vectors) = symmetric_eigen(self.projected.as_ref().submatrix(0, 0, m, m))
            .ok_or(Error::NotFinite { what: "the projected eigenproblem" })?;
        let order: Vec<usize> = (0..m).rev().filter(|i| theta[*i] > 0.0).collect();
        let coefficients = Mat::from_fn(m, order.len(), |i, j| vectors[(i, order[j])]);
        let last = coefficients.as_ref().subrows(self.coupled_at, self.coupling.ncols());
        let leaving = &self.coupling * last;
        Ok(RitzPairs {
            eigenvalues: order.iter().map(|i| 1.0 / theta[*i] - self.shift).collect(),
            residuals: order.iter().enumerate().map(|(j, i)| leaving.col(j).norm_l2() / theta[*i]).collect(),
            coefficients,
        })
    }

    /// The first `count` Ritz vectors, (n_c, count).
    pub fn ritz_vectors(&self, pairs: &RitzPairs, count: usize) -> Mat<f64> {
        let coefficients = pairs.coefficients.as_ref().subcols(0, count);
        combination(self.basis.as_ref().subcols(0, self.filled), coefficients)
    }

    /// Thick restart: keeps the first `count` Ritz vectors and the next block, and forgets the rest.
    pub fn restart(&mut self, pairs: &RitzPairs, count: usize) {
        let kept = self.ritz_vectors(pairs, count);
        let next = self.basis.as_ref().subcols(self.filled, self.width).to_owned();
        self.basis.as_mut().subcols_mut(0, count).copy_from(&kept);
        self.basis.as_mut().subcols_mut(count, self.width).copy_from(&next);
        self.projected.fill(0.0);
        for (i, lambda) in pairs.eigenvalues.iter().take(count).enumerate() {
            self.projected[(i, i)] = 1.0 / (lambda + self.shift);
        }
        // Couplings of the kept vectors to the next block: the next step computes them as inner products. Until then
        // the coupling that residuals are judged by is the old one, seen from the kept vectors.
        let last = pairs.coefficients.as_ref().submatrix(self.coupled_at, 0, self.coupling.ncols(), count);
        self.coupling = &self.coupling * last;
        self.coupled_at = 0;
        self.filled = count;
    }

    /// One step of inverse iteration on any block: `(K + σ M)⁻¹ M x` without its rigid part, with M times the result.
    pub fn polish(&self, x: MatRef<'_, f64>) -> Mat<f64> {
        self.apply(symmetric_product(&self.model.mass, x).as_ref())
    }
}

struct NextBlock {
    vectors: Mat<f64>,
    coupling: Mat<f64>,
}
