//! Sparse factorizations of `K + σ M` (Cholesky, for solving) and `K - μ M` (LDLᵀ, for counting eigenvalues) over one
//! symbolic analysis.
//!
//! The order is nested dissection on the nodes (`crate::ordering`), the numbers are made by [`crate::multifrontal`].

use std::sync::Mutex;
use std::sync::atomic::Ordering;

use dcb_formats::SparseMatrix;
use faer::Mat;

use crate::Error;
use crate::factor_store::{FactorStorage, FactorValues, Place, Precision};
pub use crate::inertia::Inertia;
use crate::inertia::counted;
use crate::multifrontal::{Cholesky, Fronts, Matrix, NotPositive, Real, eliminate};
use crate::ordering::{QuotientGraph, nested_dissection};
pub use crate::positive_factor::PositiveFactor;
use crate::positive_factor::{Entries, FEW_COLUMNS, Solves};
#[cfg(feature = "ranks")]
use crate::ranks::Ranks;
use crate::refinement::{Refined, Refinement};
pub use crate::unfactorized::Unfactorized;

/// The pattern of `K + σ M` analysed once, with room for one factor.
pub struct SymmetricFactor {
    fronts: Fronts,
    storage: FactorStorage,
    /// Where the factor goes in double precision if single precision turns out not to be enough.
    fallback: FactorStorage,
    values: Option<FactorValues>,
    warning: Option<String>,
    solves: Solves,
    /// Processes that hold the factor in place of this one, and count.
    #[cfg(feature = "ranks")]
    ranks: Option<Ranks>,
}

impl SymmetricFactor {
    /// Orders and analyses the union of the patterns of two symmetric matrices in full storage; rows of the same
    /// `group` (a node) are kept together.
    ///
    /// # Errors
    /// [`Error::OutOfMemory`] if the factor doesn't fit the machine.
    pub fn analyse(
        stiffness: &SparseMatrix,
        mass: &SparseMatrix,
        groups: &[u32],
    ) -> Result<Self, Error> {
        let graph = QuotientGraph::of_points(&[stiffness, mass], groups);
        let fronts = Fronts::analyse(&graph, &nested_dissection(&graph));
        Ok(Self {
            fronts,
            storage: FactorStorage::default(),
            fallback: FactorStorage::default(),
            values: None,
            warning: None,
            solves: Solves::default(),
            #[cfg(feature = "ranks")]
            ranks: None,
        })
    }

    /// Analysis of the factor before any number is computed.
    pub fn fronts(&self) -> &Fronts {
        &self.fronts
    }

    /// Number of stored entries of the factor, padding included.
    pub fn stored_entries(&self) -> usize {
        self.fronts.stored_entries()
    }

    /// Number of entries of the factor's lower triangle, padding of the fronts included.
    pub fn factor_entries(&self) -> usize {
        self.fronts.factor_entries()
    }

    /// Room that a factor takes.
    pub fn stored_bytes(&self) -> usize {
        self.fronts.stored_entries() * self.storage.entry_bytes()
    }

    /// Gives up the factor's room; the next factorization takes it again.
    pub fn release(&mut self) {
        self.values = None;
        #[cfg(feature = "ranks")]
        if let Some(ranks) = &self.ranks {
            ranks.release();
        }
    }

    /// Most memory that each process with a part of the factor has had in use, bytes; none where this one has all of it.
    ///
    /// # Errors
    /// [`Error::Ranks`].
    pub fn rank_peak_bytes(&self) -> Result<Vec<u64>, Error> {
        #[cfg(feature = "ranks")]
        if let Some(ranks) = &self.ranks {
            return ranks.peak_bytes();
        }
        Ok(Vec::new())
    }

    /// Floating-point operations of a factorization.
    pub fn flops(&self) -> f64 {
        self.fronts.flops()
    }

    /// Columns solved so far, by all factors together.
    pub fn solve_columns(&self) -> u64 {
        self.solves.columns.load(Ordering::Relaxed)
    }

    /// Passes over the factor so far: one forward and one backward sweep for a block of up to 32 columns.
    pub fn solve_passes(&self) -> u64 {
        self.solves.passes.load(Ordering::Relaxed)
    }

    /// Decides how and where factors are kept from now on (at first: double precision in memory). `fallback` is for a matrix
    /// for which single precision is not enough; it is always used in double precision. Ranks are started.
    ///
    /// # Errors
    /// [`Error::CannotStart`], [`Error::Ranks`], [`Error::File`] of ranks.
    pub fn keep_in(&mut self, storage: FactorStorage, fallback: Place) -> Result<(), Error> {
        self.values = None;
        #[cfg(feature = "ranks")]
        {
            self.ranks = match &storage.place {
                Place::Ranks(run) => Some(Ranks::start(run)?),
                _ => None,
            };
        }
        self.storage = storage;
        self.fallback = FactorStorage {
            precision: Precision::Double,
            place: fallback,
        };
        Ok(())
    }

    /// Warning about the factor's precision.
    pub fn warning(&self) -> Option<&str> {
        self.warning.as_deref()
    }

    /// Factorizes `K + shift · M`. A factor in single precision is tried on a block of columns, and made again in double precision if
    /// refinement doesn't make up for what was rounded.
    ///
    /// # Errors
    /// [`Unfactorized`]: not positive definite, or no room.
    pub fn factorize<'a>(
        &'a mut self,
        stiffness: &'a SparseMatrix,
        mass: &'a SparseMatrix,
        shift: f64,
    ) -> Result<PositiveFactor<'a>, Unfactorized> {
        let matrix = Matrix {
            stiffness,
            mass,
            shift,
        };
        self.compute(matrix)?;
        if let Some(refined) = self.trial(matrix)?.filter(|trial| !trial.is_accurate()) {
            self.keep_in_double(refined);
            self.compute(matrix)?;
        }
        self.factor(matrix)
            .ok_or_else(|| Error::OutOfMemory { what: "the factor" }.into())
    }

    /// Gives up single precision, after refinements that ended so.
    pub fn keep_in_double(&mut self, refined: Refined) {
        self.warning = Some(format!(
            "the factor was made again in double precision: in single precision a solution had the scaled residual {:.0e} after {} refinements",
            refined.residual, refined.steps
        ));
        self.values = None;
        self.storage = self.fallback.clone();
    }

    /// Computes the entries.
    fn compute(&mut self, matrix: Matrix<'_>) -> Result<(), Unfactorized> {
        #[cfg(feature = "ranks")]
        if let Some(ranks) = &self.ranks {
            return ranks.factorize(matrix, &self.fronts);
        }
        let mut values = match self.values.take() {
            Some(values) => values,
            None => FactorValues::zeros(&self.storage, self.fronts.stored_entries())?,
        };
        let done = match &mut values {
            FactorValues::Double(values) => self.eliminate(matrix, values),
            FactorValues::Single(values) => self.eliminate(matrix, values),
        };
        self.values = Some(values);
        Ok(done?)
    }

    fn eliminate<T: Real>(&self, matrix: Matrix<'_>, values: &mut [T]) -> Result<(), NotPositive> {
        eliminate(&self.fronts, matrix, &Cholesky::<T>::default(), values)
    }

    fn factor<'a>(&'a self, matrix: Matrix<'a>) -> Option<PositiveFactor<'a>> {
        #[cfg(feature = "ranks")]
        if let Some(ranks) = &self.ranks {
            return Some(self.made(Entries::OnRanks(ranks), None));
        }
        let values = self.values.as_ref()?;
        let fronts = &self.fronts;
        let refinement = matches!(values, FactorValues::Single(_)).then(|| Refinement::of(matrix));
        Some(self.made(Entries::Here { fronts, values }, refinement))
    }

    fn made<'a>(
        &'a self,
        entries: Entries<'a>,
        refinement: Option<Refinement<'a>>,
    ) -> PositiveFactor<'a> {
        PositiveFactor {
            entries,
            solves: &self.solves,
            refinement,
            least_accurate: Mutex::default(),
        }
    }

    /// How well a rounded factor solves for a block of pseudo-random forces, which excite every motion.
    fn trial(&self, matrix: Matrix<'_>) -> Result<Option<Refined>, Error> {
        let rounded = self
            .factor(matrix)
            .filter(|factor| factor.refinement.is_some());
        let Some(factor) = rounded else {
            return Ok(None);
        };
        let mut state = 0x5eed_u64;
        let mut block = Mat::from_fn(self.fronts.dof_count(), FEW_COLUMNS, |_, _| {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        });
        factor.solve_in_place(block.as_mut())?;
        Ok(Some(factor.least_accurate()))
    }

    /// Counts the negative eigenvalues of `K - shift · M`, which are the eigenvalues of the pencil below `shift`
    /// (Sylvester), by a factorization with pivoting inside supernodes. Leaves the factor as it is.
    ///
    /// # Errors
    /// [`Error::Ranks`] or [`Error::File`] if other processes count and don't answer.
    pub fn inertia(
        &self,
        stiffness: &SparseMatrix,
        mass: &SparseMatrix,
        shift: f64,
    ) -> Result<Inertia, Error> {
        let matrix = Matrix {
            stiffness,
            mass,
            shift: -shift,
        };
        self.counted(&self.fronts, matrix)
    }

    /// The same for other matrices over some of the dofs, in full storage, in this order but with the fronts of their own pattern: cheap where
    /// that is sparser, as that of a mass matrix without entries between directions. `dofs` are those of their rows.
    ///
    /// # Errors
    /// As [`SymmetricFactor::inertia`].
    pub fn inertia_of(
        &self,
        dofs: &[u32],
        first: &SparseMatrix,
        second: &SparseMatrix,
        shift: f64,
    ) -> Result<Inertia, Error> {
        let graph = QuotientGraph::of_pattern(&[first, second]);
        let place = |vertex: &u32| {
            let members = graph.members(*vertex).iter();
            let dofs = members.map(|row| dofs[*row as usize] as usize);
            dofs.map(|dof| self.fronts.inverse[dof]).min()
        };
        let mut order: Vec<u32> = (0..graph.vertex_count() as u32).collect();
        order.sort_by_cached_key(place);
        let matrix = Matrix {
            stiffness: first,
            mass: second,
            shift: -shift,
        };
        let found = self.counted(&Fronts::analyse(&graph, &order), matrix)?;
        let rows = found.negative_dofs.iter();
        Ok(Inertia {
            negative_dofs: rows.map(|row| dofs[*row] as usize).collect(),
            ..found
        })
    }

    fn counted(&self, fronts: &Fronts, matrix: Matrix<'_>) -> Result<Inertia, Error> {
        #[cfg(feature = "ranks")]
        if let Some(ranks) = &self.ranks {
            return ranks.count(matrix, fronts);
        }
        Ok(counted(fronts, matrix))
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use faer::Mat;
    use faer::sparse::Triplet;

    #[test]
    fn another_matrix_is_counted_over_its_own_pattern() {
        let (stiffness, mass) = chain(50);
        let groups: Vec<u32> = (0..50).collect();
        let factor = SymmetricFactor::analyse(&stiffness, &mass, &groups).unwrap();
        let of = |first: &SparseMatrix, shift: f64| {
            factor.inertia_of(&groups, first, &mass, shift).unwrap()
        };
        assert_eq!(of(&mass, -1.0).negative, 0);
        let mut signed = mass.clone();
        signed.val_mut()[17] = -1.0;
        signed.val_mut()[44] = -2.0;
        let inertia = of(&signed, -0.5);
        let mut places = inertia.negative_dofs.clone();
        places.sort_unstable();
        assert_eq!((inertia.negative, places), (2, vec![17, 44]));
        assert_eq!(of(&stiffness, 0.0).negative, 0);
    }

    /// Fixed-free chain of `n` unit springs and masses: eigenvalues 4 sin²((2k+1)π/(4n+2)).
    fn chain(n: u32) -> (SparseMatrix, SparseMatrix) {
        let mut k = Vec::new();
        for i in 0..n {
            k.push(Triplet::new(i, i, if i + 1 == n { 1.0 } else { 2.0 }));
            if i > 0 {
                k.push(Triplet::new(i, i - 1, -1.0));
                k.push(Triplet::new(i - 1, i, -1.0));
            }
        }
        let m: Vec<_> = (0..n).map(|i| Triplet::new(i, i, 1.0)).collect();
        let size = n as usize;
        (
            SparseMatrix::try_new_from_triplets(size, size, &k).unwrap(),
            SparseMatrix::try_new_from_triplets(size, size, &m).unwrap(),
        )
    }

    #[test]
    fn inertia_counts_the_eigenvalues_below_the_shift() {
        let n = 200;
        let (stiffness, mass) = chain(n);
        let groups: Vec<u32> = (0..n).collect();
        let factor = SymmetricFactor::analyse(&stiffness, &mass, &groups).unwrap();
        let eigenvalue = |k: u32| {
            let angle = f64::from(2 * k + 1) * std::f64::consts::PI / f64::from(4 * n + 2);
            4.0 * angle.sin().powi(2)
        };
        for k in [0, 1, 7, 100, 198] {
            let between = 0.5 * (eigenvalue(k) + eigenvalue(k + 1));
            let inertia = factor.inertia(&stiffness, &mass, between).unwrap();
            assert_eq!((inertia.negative, inertia.zero), (k as usize + 1, 0));
            assert_eq!(
                inertia.negative_dofs.len(),
                (k as usize + 1).min(Inertia::LISTED)
            );
        }
    }

    #[test]
    fn solutions_satisfy_the_shifted_system() {
        let (stiffness, mass) = chain(500);
        let groups: Vec<u32> = (0..500).map(|i| i / 3).collect();
        let mut factor = SymmetricFactor::analyse(&stiffness, &mass, &groups).unwrap();
        let rhs = Mat::from_fn(500, 41, |i, j| ((i * (j + 1)) as f64).sin());
        let mut x = rhs.clone();
        factor
            .factorize(&stiffness, &mass, 0.01)
            .unwrap()
            .solve_in_place(x.as_mut())
            .unwrap();
        assert_eq!((factor.solve_columns(), factor.solve_passes()), (41, 2));
        let product = crate::block_algebra::symmetric_product(&stiffness, x.as_ref())
            + faer::Scale(0.01) * crate::block_algebra::symmetric_product(&mass, x.as_ref());
        assert!(crate::block_algebra::largest_entry((&product - &rhs).as_ref()) < 1e-11);
        // Below the lowest eigenvalue the matrix is indefinite and says so.
        assert!(factor.factorize(&stiffness, &mass, -1.0).is_err());
    }

    fn solved(
        (stiffness, mass, shift): (&SparseMatrix, &SparseMatrix, f64),
        storage: FactorStorage,
        rhs: &Mat<f64>,
    ) -> (Mat<f64>, Option<String>) {
        let groups: Vec<u32> = (0..rhs.nrows() as u32).map(|i| i / 3).collect();
        let mut factor = SymmetricFactor::analyse(stiffness, mass, &groups).unwrap();
        factor.keep_in(storage, Place::Memory).unwrap();
        let mut x = rhs.clone();
        factor
            .factorize(stiffness, mass, shift)
            .unwrap()
            .solve_in_place(x.as_mut())
            .unwrap();
        (x, factor.warning().map(str::to_owned))
    }

    fn stored(precision: Precision, place: Place) -> FactorStorage {
        FactorStorage { precision, place }
    }

    #[test]
    fn a_factor_on_disk_solves_to_the_same_last_bit() {
        let (stiffness, mass) = chain(2000);
        let rhs = Mat::from_fn(2000, 19, |i, j| ((i * (j + 1)) as f64).sin());
        let folder = tempfile::tempdir().unwrap();
        for precision in [Precision::Double, Precision::Single] {
            let disk = Place::Disk {
                folder: folder.path().into(),
            };
            let problem = (&stiffness, &mass, 0.01);
            let (in_memory, _) = solved(problem, stored(precision, Place::Memory), &rhs);
            let (on_disk, _) = solved(problem, stored(precision, disk), &rhs);
            assert_eq!(in_memory, on_disk);
        }
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }

    #[test]
    fn single_precision_refines_to_double_or_gives_way_to_it() {
        let (stiffness, mass) = chain(2000);
        let rhs = Mat::from_fn(2000, 19, |i, j| ((i * (j + 1)) as f64).sin());
        let largest = |x: &Mat<f64>| crate::block_algebra::largest_entry(x.as_ref());
        let both = |shift: f64| {
            let problem = (&stiffness, &mass, shift);
            let (double, _) = solved(problem, stored(Precision::Double, Place::Memory), &rhs);
            let (single, warning) = solved(problem, stored(Precision::Single, Place::Memory), &rhs);
            (largest(&(&single - &double)) / largest(&double), warning)
        };
        let (difference, warning) = both(0.01);
        assert!(difference < 1e-12 && warning.is_none(), "{difference:e}");
        // A shift just above minus the lowest eigenvalue: nearly singular, with a condition number of 1e15.
        let angle = std::f64::consts::PI / f64::from(4 * 2000 + 2);
        let lowest = 4.0 * angle.sin().powi(2);
        let (difference, warning) = both(-lowest * (1.0 - 1e-8));
        assert_eq!(difference, 0.0);
        assert!(warning.is_some_and(|w| w.contains("double precision")));
    }
}
