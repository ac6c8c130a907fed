//! Small vibrations of a mechanism about a state: frequencies, damping and shapes.
//!
//! In independent coordinates z (`independent.rs`)
//!
//! ```text
//! M z'' + C z' + K z = 0
//! ```
//! At rest and without damping this is a symmetric problem with ω² as eigenvalues; otherwise (z, z') grow as exp(s t) with s complex.
//! About a motion the modes are those of an instant: exact where body axes see the motion stand still, as for a body that spins steadily.

use dcb_dense::{symmetric_eigen, symmetric_eigenvalues, symmetrized};
use faer::linalg::solvers::Solve;
use faer::{Mat, Side};

use super::independent::IndependentMotion;
use crate::error::Error;
use crate::system::free_directions::FreeDirections;
use crate::system::{State, System};

/// Stiffness along a motion below this part of the mechanism's is that of a free motion.
const RIGID: f64 = 1e-12;
/// Damping, and asymmetry of the stiffness, below this part of their scale are rounding.
const ROUNDING: f64 = 1e-8;

/// One mode of vibration, `Re(shape exp(s t))`.
#[derive(Clone, Debug, PartialEq)]
pub struct Eigenmode {
    /// Real part of s, 1/time: negative where the mode decays, positive where it grows.
    pub growth: f64,
    /// Imaginary part of s, rad/time; zero where the mode doesn't oscillate.
    pub angular_frequency: f64,
    /// δq, laid out as velocities, translations in body axes. Largest motion of a body one length; the part in phase.
    pub shape: Vec<f64>,
    /// The part of δq a quarter period behind; zero for undamped modes.
    pub shape_behind: Vec<f64>,
}

impl Eigenmode {
    /// Frequency in cycles by time.
    pub fn frequency(&self) -> f64 {
        self.angular_frequency / std::f64::consts::TAU
    }

    /// Damping as a part of the critical one, in [-1, 1]; zero for a free motion.
    pub fn damping_ratio(&self) -> f64 {
        let size = self.growth.hypot(self.angular_frequency);
        if size > 0.0 { -self.growth / size } else { 0.0 }
    }

    /// Whether the mode grows, by more than rounding.
    pub fn is_unstable(&self) -> bool {
        self.growth > ROUNDING * self.growth.hypot(self.angular_frequency)
    }
}

/// The modes of a mechanism, by increasing |s|.
#[derive(Clone, Debug, PartialEq)]
pub struct Eigenmodes {
    /// Modes; a complex pair is one of them.
    pub modes: Vec<Eigenmode>,
    /// Number of modes without frequency: motions that meet no stiffness.
    pub rigid_count: usize,
    /// Degrees of freedom.
    pub dof_count: usize,
    /// Whether the mechanism is at rest and undamped: then each mode is a pair of roots.
    is_conservative: bool,
}

impl Eigenmodes {
    /// Of a mechanism at a state.
    ///
    /// # Errors
    /// [`Error::NoEigenvalues`].
    pub fn at(system: &System, state: &State) -> Result<Self, Error> {
        Self::of(system, &IndependentMotion::at(system, state, &[])?)
    }

    /// Of a mechanism in independent coordinates, of which those of driven rows stand still.
    ///
    /// # Errors
    /// [`Error::NoEigenvalues`].
    pub fn of(system: &System, motion: &IndependentMotion) -> Result<Self, Error> {
        let dof_count = motion.free_count();
        if dof_count == 0 {
            return Ok(Self {
                modes: Vec::new(),
                rigid_count: 0,
                dof_count,
                is_conservative: true,
            });
        }
        let units = &motion.units;
        let [mass, damping, stiffness] = motion.reduced().map(|matrix| {
            Mat::from_fn(dof_count, dof_count, |i, j| {
                units[i] * matrix[(i, j)] * units[j]
            })
        });
        let asymmetry = (&stiffness - stiffness.transpose()).norm_l2();
        let damping_scale = (mass.norm_l2() * stiffness.norm_l2()).sqrt();
        let conservative = asymmetry <= ROUNDING * stiffness.norm_l2()
            && damping.norm_l2() <= ROUNDING * damping_scale;
        let mut modes = if conservative {
            undamped(&mass, &stiffness)?
        } else {
            damped(&mass, &damping, &stiffness)?
        };
        for mode in &mut modes {
            for shape in [&mut mode.shape, &mut mode.shape_behind] {
                for (amount, unit) in shape.iter_mut().zip(units) {
                    *amount *= unit;
                }
            }
            mode.express(system, &motion.directions);
        }
        let size = |mode: &Eigenmode| mode.growth.hypot(mode.angular_frequency);
        modes.sort_by(|a, b| size(a).total_cmp(&size(b)));
        Ok(Self {
            rigid_count: modes.iter().filter(|mode| size(mode) == 0.0).count(),
            modes,
            dof_count,
            is_conservative: conservative,
        })
    }

    /// All roots s as (real part, imaginary part), two for each degree of freedom, by increasing |s|.
    pub fn poles(&self) -> Vec<[f64; 2]> {
        let mut poles = Vec::with_capacity(2 * self.dof_count);
        for mode in &self.modes {
            let (growth, frequency) = (mode.growth, mode.angular_frequency);
            if frequency > 0.0 {
                poles.extend([[growth, frequency], [growth, -frequency]]);
            } else if self.is_conservative && growth != 0.0 {
                poles.extend([[growth, 0.0], [-growth, 0.0]]);
            } else {
                poles.push([growth, 0.0]);
            }
        }
        // Motions without stiffness have a constant rate besides.
        let missing = (2 * self.dof_count).saturating_sub(poles.len());
        poles.splice(0..0, std::iter::repeat_n([0.0; 2], missing));
        poles
    }

    /// Modes that grow, the fastest first.
    pub fn unstable(&self) -> Vec<&Eigenmode> {
        let mut growing: Vec<_> = self
            .modes
            .iter()
            .filter(|mode| mode.is_unstable())
            .collect();
        growing.sort_by(|a, b| b.growth.total_cmp(&a.growth));
        growing
    }
}

impl Eigenmode {
    /// Turns amounts of free directions into δq of unit size.
    fn express(&mut self, system: &System, directions: &FreeDirections) {
        for shape in [&mut self.shape, &mut self.shape_behind] {
            let mut motion = vec![0.0; system.velocity_count()];
            directions.add_motion(shape, &mut motion);
            *shape = motion;
        }
        let size = |shape: &[f64], body: &crate::system::Body| {
            let own = &shape[body.velocities.clone()];
            let squares = |part: &[f64]| part.iter().map(|x| x * x).sum::<f64>();
            squares(&own[..3])
                + body.length.powi(2) * squares(&own[3..6])
                + squares(&own[6..]) / body.flexible.inertia.mass()
        };
        let largest = system
            .bodies
            .iter()
            .map(|body| size(&self.shape, body) + size(&self.shape_behind, body))
            .fold(0.0, f64::max)
            .sqrt();
        let shapes = self.shape.iter_mut().chain(&mut self.shape_behind);
        shapes.for_each(|entry| *entry /= largest);
    }
}

/// `K z = ω² M z`. The problem is solved the other way round, `M z = (K + σ M) z / (ω² + σ)`, where low frequencies are the large
/// eigenvalues and come out to rounding; σ makes K positive.
pub(crate) fn undamped(mass: &Mat<f64>, stiffness: &Mat<f64>) -> Result<Vec<Eigenmode>, Error> {
    let n = mass.nrows();
    let symmetric = symmetrized(stiffness.as_ref());
    let range = relative_eigenvalues(&symmetric, mass)?;
    let least = range.iter().fold(0.0, |least: f64, x| least.min(*x));
    let largest = range.iter().fold(0.0, |most: f64, x| most.max(x.abs()));
    let scale = symmetric.norm_l2();
    let shift = (2.0 * -least + 1e-10 * largest).max(f64::MIN_POSITIVE);
    let lifted = &symmetric + faer::Scale(shift) * mass;
    let root = lifted.llt(Side::Lower).map_err(|_| Error::NoEigenvalues)?;
    let inner = scaled_by(root.L(), mass);
    let (_, mut vectors) = symmetric_eigen(inner.as_ref()).ok_or(Error::NoEigenvalues)?;
    faer::linalg::triangular_solve::solve_upper_triangular_in_place(
        root.L().transpose(),
        vectors.as_mut(),
        faer::Par::Seq,
    );
    let form =
        |matrix: &Mat<f64>, vector: faer::ColRef<'_, f64>| vector.transpose() * (matrix * vector);
    Ok(vectors
        .col_iter()
        .map(|vector| {
            let meets = form(&symmetric, vector);
            let squared = meets / form(mass, vector);
            let (growth, angular_frequency) =
                if meets.abs() <= RIGID * scale * vector.squared_norm_l2() {
                    (0.0, 0.0)
                } else if squared < 0.0 {
                    ((-squared).sqrt(), 0.0)
                } else {
                    (0.0, squared.sqrt())
                };
            Eigenmode {
                growth,
                angular_frequency,
                shape: vector.iter().copied().collect(),
                shape_behind: vec![0.0; n],
            }
        })
        .collect())
}

/// `(s² M + s C + K) z = 0` in first-order form over the rates z' and the elongations `p = V₁ᵀ z` of `K = U₁ Σ V₁ᵀ`, so that
/// motions without stiffness come out exactly.
fn damped(
    mass: &Mat<f64>,
    damping: &Mat<f64>,
    stiffness: &Mat<f64>,
) -> Result<Vec<Eigenmode>, Error> {
    let n = mass.nrows();
    let factors = stiffness.svd().map_err(|_| Error::NoEigenvalues)?;
    let (u, v, sigma) = (factors.U(), factors.V(), factors.S().column_vector());
    let rank = sigma.iter().filter(|s| **s > RIGID * sigma[0]).count();
    let elastic = Mat::from_fn(n, rank, |i, k| u[(i, k)] * sigma[k]);
    let factor = mass.partial_piv_lu();
    let (by_rate, by_place) = (factor.solve(damping), factor.solve(&elastic));
    // Time in units of the stiffest mode.
    let unit = (by_place.norm_max().sqrt())
        .max(by_rate.norm_max())
        .max(f64::MIN_POSITIVE);
    let matrix = Mat::from_fn(n + rank, n + rank, |i, j| match (i < n, j < n) {
        (true, true) => -by_rate[(i, j)] / unit,
        (true, false) => -by_place[(i, j - n)] / (unit * unit),
        (false, true) => v[(j, i - n)],
        (false, false) => 0.0,
    });
    let eigen = matrix.eigen().map_err(|_| Error::NoEigenvalues)?;
    let values = eigen.S().column_vector();
    let size = |k: usize| values[k].re.hypot(values[k].im);
    let largest = (0..n + rank).map(size).fold(0.0, f64::max);
    let mut modes: Vec<Eigenmode> = (rank..n)
        .map(|k| Eigenmode {
            growth: 0.0,
            angular_frequency: 0.0,
            shape: v.col(k).iter().copied().collect(),
            shape_behind: vec![0.0; n],
        })
        .collect();
    for k in 0..n + rank {
        let value = values[k];
        // A pair is one mode. Rates that stay belong to the free motions above.
        if value.im >= 0.0 && size(k) > RIGID * largest {
            modes.push(Eigenmode {
                growth: value.re * unit,
                angular_frequency: value.im * unit,
                shape: (0..n).map(|i| eigen.U()[(i, k)].re).collect(),
                shape_behind: (0..n).map(|i| -eigen.U()[(i, k)].im).collect(),
            });
        }
    }
    Ok(modes)
}

/// Eigenvalues of K z = x M z for symmetric K.
fn relative_eigenvalues(stiffness: &Mat<f64>, mass: &Mat<f64>) -> Result<Vec<f64>, Error> {
    let root = mass.llt(Side::Lower).map_err(|_| Error::NoEigenvalues)?;
    symmetric_eigenvalues(scaled_by(root.L(), stiffness).as_ref()).ok_or(Error::NoEigenvalues)
}

/// L⁻¹ A L⁻ᵀ
fn scaled_by(lower: faer::MatRef<'_, f64>, matrix: &Mat<f64>) -> Mat<f64> {
    let mut half = matrix.clone();
    for _ in 0..2 {
        faer::linalg::triangular_solve::solve_lower_triangular_in_place(
            lower,
            half.as_mut(),
            faer::Par::Seq,
        );
        half = half.transpose().to_owned();
    }
    half
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    /// I - 2 v vᵀ / vᵀ v.
    fn reflection(n: usize) -> Mat<f64> {
        let v = |i: usize| (1.0 + i as f64).sqrt().fract() - 0.5;
        let square: f64 = (0..n).map(|i| v(i).powi(2)).sum();
        Mat::from_fn(n, n, |i, j| {
            f64::from(u8::from(i == j)) - 2.0 * v(i) * v(j) / square
        })
    }

    /// ω² of 1, 4 and 9, each many times, turned, whatever the units of mass and stiffness.
    #[test]
    fn modes_of_repeated_roots_are_modes() {
        for n in [60, 130, 300] {
            let turn = reflection(n);
            for (mass_size, stiffness_size) in
                [(1.0, 1.0), (1e-30, 1e30), (1e30, 1e-30), (1e-9, 1e-20)]
            {
                let root = |k: usize| [1.0, 4.0, 9.0][3 * k / n];
                let mass = Mat::<f64>::identity(n, n) * faer::Scale(mass_size);
                let roots = Mat::from_fn(n, n, |i, k| turn[(i, k)] * root(k) * stiffness_size);
                let stiffness = &roots * turn.transpose();
                let unit = stiffness_size / mass_size;
                let modes = undamped(&mass, &stiffness).unwrap();
                let mut found: Vec<f64> = modes
                    .iter()
                    .map(|mode| mode.angular_frequency.powi(2) / unit)
                    .collect();
                found.sort_by(f64::total_cmp);
                for (k, square) in found.iter().enumerate() {
                    assert!((square - root(k)).abs() < 1e-11, "{n}, {unit:e}: {square}");
                }
                for mode in &modes {
                    let z = Mat::from_fn(n, 1, |i, _| mode.shape[i]);
                    let force = &stiffness * &z;
                    let inertia = &mass * &z * faer::Scale(mode.angular_frequency.powi(2));
                    let defect = (&force - inertia).norm_l2() / force.norm_l2();
                    assert!(defect < 1e-11, "{n}, {unit:e}: {defect:e}");
                }
            }
        }
    }
}
