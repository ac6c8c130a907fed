//! A component some of whose dofs have no mass: they follow statically, K_mm - K_ms K_ss⁻¹ K_sm against M_mm.

use dcb_formats::Component;
use faer::Mat;

use crate::dense::{dense, solve, symmetric};
use crate::hard::reduction::plain_methods::eigenpairs;

/// Dofs with and without mass, and the dense matrices.
pub struct Massless {
    /// Rows with mass.
    pub with_mass: Vec<usize>,
    /// Rows without.
    pub without: Vec<usize>,
    stiffness: Mat<f64>,
    mass: Mat<f64>,
}

fn part_of(matrix: &Mat<f64>, rows: &[usize], columns: &[usize]) -> Mat<f64> {
    Mat::from_fn(rows.len(), columns.len(), |i, j| {
        matrix[(rows[i], columns[j])]
    })
}

impl Massless {
    /// By the diagonal of M; what is zero there has to be zero all along the row.
    pub fn of(component: &Component) -> Self {
        let (stiffness, mass) = (dense(&component.stiffness), dense(&component.mass));
        let (with_mass, without): (Vec<usize>, Vec<usize>) =
            (0..mass.nrows()).partition(|i| mass[(*i, *i)] > 0.0);
        for i in &without {
            assert!((0..mass.ncols()).all(|j| mass[(*i, j)] == 0.0), "row {i}");
        }
        Self {
            with_mass,
            without,
            stiffness,
            mass,
        }
    }

    /// Every finite ω², ascending, rigid motions first.
    pub fn eigenvalues(&self) -> Vec<f64> {
        let coupling = part_of(&self.stiffness, &self.without, &self.with_mass);
        let following = solve(
            &part_of(&self.stiffness, &self.without, &self.without),
            &coupling,
        );
        let condensed = part_of(&self.stiffness, &self.with_mass, &self.with_mass)
            - coupling.transpose() * following;
        let mass = part_of(&self.mass, &self.with_mass, &self.with_mass);
        let (values, _) = eigenpairs(&symmetric(&condensed), &mass).expect("a positive mass");
        values
    }

    /// L_s K_ss⁻¹ L_sᵀ: the flexibility that all finite modes together leave out, seen at the rows of `localization`.
    pub fn flexibility(&self, localization: &Mat<f64>) -> Mat<f64> {
        let all: Vec<usize> = (0..localization.nrows()).collect();
        let seen = part_of(localization, &all, &self.without);
        let inner = part_of(&self.stiffness, &self.without, &self.without);
        &seen * solve(&inner, &seen.transpose().to_owned())
    }
}
