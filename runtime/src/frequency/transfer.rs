//! Responses of a linear mechanism over frequencies.
//!
//! ```text
//! (−ω² M + iω C + (1 + iη) K) ζ = F u − (−ω² M_d + iω C_d + (1 + iη) K_d) ζ_d        y = C₁ ζ + iω C₂ ζ + D u
//! ```
//! With C₁ (1 + iη) for forces and accelerations, which see places through the stiffness. ζ are independent coordinates, ζ_d those of drives. At rest M and K are symmetric: in their modes, all of them, what is static is kept exactly. Where damping
//! doesn't couple the modes a frequency costs O(n); where it does, complex modes do the same. Both are checked against a direct solution. About a motion, and
//! where the check fails, each frequency is solved directly, O(n³).

use dcb_dense::{symmetric_eigen, symmetrized};
use dcb_formats::scene::{FrequencyResponse, ModalRatios, ResponseDamping};
use faer::linalg::solvers::Solve;
use faer::{Mat, c64};

use crate::error::Error;
use crate::linear::{Linearized, SecondOrder};

/// Couplings below this part of the damping are rounding.
const ROUNDING: f64 = 1e-8;
/// Asymmetry of what would be symmetric at rest: that of differences, and of a rest that was found to a tolerance. What is believed is checked below.
const ASYMMETRY: f64 = 1e-5;
/// σ times these are tried where a mechanism that runs away makes K + σ M indefinite.
const SHIFTS: [f64; 3] = [1.0, 1e3, 1e6];
/// Parts of the largest μ below this are rounding.
const LEAST: f64 = 1e-18;
/// Loads on a mode below this part of those on all modes are rounding.
const UNEXCITED: f64 = 1e-10;
/// Rates below this part of the fastest are none.
const STILL: f64 = 1e-9;
/// Relative difference to a direct solution that is believed.
const BELIEVED: f64 = 1e-7;

/// How frequencies are solved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Solution {
    /// By real modes: O(n) a frequency.
    Modes,
    /// By complex modes: O(n) a frequency.
    ComplexModes,
    /// Each by itself: O(n³).
    Direct,
}

/// Responses of outputs to inputs.
pub(super) struct Transfer<'a> {
    linear: &'a Linearized,
    /// Coordinates that are free.
    free: usize,
    loss: f64,
    /// K, C in real modes where there are some.
    modal: Option<Modal>,
    complex: Option<Complex>,
}

/// Modes of unit mass: shapes (free, n), ω², and damping over them (n, n).
struct Modal {
    shapes: Mat<c64>,
    squares: Vec<f64>,
    damping: Mat<f64>,
    is_diagonal: bool,
    /// M Φ D Φᵀ M, (free, free), where ratios take the place of the damping.
    given: Option<Mat<f64>>,
}

/// (z, z') = V exp(Λ t): poles, V over z (n, 2 n), and V⁻¹ over the rates (2 n, n).
struct Complex {
    poles: Vec<c64>,
    shapes: Mat<c64>,
    amounts: Mat<c64>,
}

/// A pole of the mechanism, damping of the analysis included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Resonance {
    /// Cycles per time.
    pub frequency: f64,
    pub ratio: f64,
}

impl<'a> Transfer<'a> {
    pub fn of(linear: &'a Linearized, asked: &FrequencyResponse) -> Result<Self, Error> {
        let SecondOrder {
            matrices, units, ..
        } = &linear.second_order;
        let free = units.len();
        let loss = asked.loss_factor();
        let scaled =
            |of: &Mat<f64>| Mat::from_fn(free, free, |i, j| units[i] * of[(i, j)] * units[j]);
        let [mass, damping, stiffness] = [0, 1, 2].map(|k| scaled(&matrices[k]));
        let apart = |of: &Mat<f64>| (of - of.transpose()).norm_l2() <= ASYMMETRY * of.norm_l2();
        let is_at_rest = free > 0 && apart(&mass) && apart(&stiffness) && apart(&damping);
        let symmetric = [&mass, &damping, &stiffness].map(symmetrized);
        let wanted = match &asked.damping {
            Some(ResponseDamping::AssembledModal(ratios)) => Some(ratios),
            _ => None,
        };
        if wanted.is_some() && !is_at_rest {
            return Err(Error::described(
                "analysis.frequency_response.damping.assembled_modal",
                "needs modes that don't turn into each other, but the mechanism moves here; take another damping, or a rest",
            ));
        }
        let modal = match is_at_rest {
            true => Modal::of(&symmetric, units, wanted, shift(asked)).map(Some)?,
            false => None,
        };
        let complex = modal
            .as_ref()
            .filter(|modal| !modal.is_diagonal)
            .and_then(|modal| Complex::of(modal, loss));
        let mut transfer = Self {
            linear,
            free,
            loss,
            modal,
            complex,
        };
        transfer.check(asked);
        Ok(transfer)
    }

    pub fn solution(&self) -> Solution {
        match (&self.modal, &self.complex) {
            (Some(modal), _) if modal.is_diagonal => Solution::Modes,
            (_, Some(_)) => Solution::ComplexModes,
            _ => Solution::Direct,
        }
    }

    /// Falls back on direct solutions where the modes don't reproduce them.
    fn check(&mut self, asked: &FrequencyResponse) {
        if self.solution() == Solution::Direct {
            return;
        }
        let highest = asked.highest();
        let holds = [0.13, 0.47, 0.91].iter().all(|part| {
            let omega = std::f64::consts::TAU * part * highest;
            match (self.coordinates(omega), self.direct(omega)) {
                (Some(fast), Some(exact)) => {
                    (&fast - &exact).norm_l2() <= BELIEVED * exact.norm_l2()
                }
                _ => true,
            }
        });
        if !holds {
            self.complex = None;
            if let Some(modal) = &mut self.modal {
                // What was asked for stays: the damping over the modes.
                modal.is_diagonal = false;
            }
        }
    }

    /// Outputs by inputs at a frequency, (n_y, n_u).
    ///
    /// # Errors
    /// [`Error::Resonant`] where that isn't finite.
    pub fn at(&self, frequency: f64) -> Result<Mat<c64>, Error> {
        let omega = std::f64::consts::TAU * frequency;
        let free = self
            .coordinates(omega)
            .ok_or(Error::Resonant { frequency })?;
        let system = &self.linear.system;
        let drives = &self.linear.second_order.drives;
        let k = system.a.nrows() / 2;
        let zero = c64::new(0.0, 0.0);
        let rate = c64::new(0.0, omega);
        let (rows, columns) = (system.c.nrows(), system.b.ncols());
        let responses = Mat::from_fn(rows, columns, |i, j| {
            // What a force or an acceleration has of places it has through the stiffness.
            let loss = match self.linear.follows_forces[i] {
                true => self.loss,
                false => 0.0,
            };
            let mut sum = zero;
            for coordinate in 0..k {
                let amount = match coordinate < self.free {
                    true => free[(coordinate, j)],
                    false if drives[j] == Some(coordinate) => c64::new(1.0, 0.0),
                    false => continue,
                };
                sum += amount
                    * (c64::new(1.0, loss) * system.c[(i, coordinate)]
                        + rate * system.c[(i, k + coordinate)]);
            }
            // u of a drive is its acceleration.
            let amplitude = if drives[j].is_some() {
                -omega * omega
            } else {
                1.0
            };
            sum + c64::new(system.d[(i, j)] * amplitude, 0.0)
        });
        match (0..rows).all(|i| {
            (0..columns)
                .all(|j| responses[(i, j)].re.is_finite() && responses[(i, j)].im.is_finite())
        }) {
            true => Ok(responses),
            false => Err(Error::Resonant { frequency }),
        }
    }

    /// Forces over the free coordinates by unit inputs, drives by unit displacement, (free, n_u).
    fn loads(&self, omega: f64) -> Mat<c64> {
        let SecondOrder {
            matrices,
            forces,
            drives,
            ..
        } = &self.linear.second_order;
        Mat::from_fn(self.free, drives.len(), |i, j| match drives[j] {
            None => c64::new(forces[(i, j)], 0.0),
            Some(drive) => -self.dynamic(matrices, omega, i, drive),
        })
    }

    fn dynamic(
        &self,
        [mass, damping, stiffness]: &[Mat<f64>; 3],
        omega: f64,
        i: usize,
        j: usize,
    ) -> c64 {
        let k = stiffness[(i, j)];
        c64::new(
            k - omega * omega * mass[(i, j)],
            omega * damping[(i, j)] + self.loss * k,
        )
    }

    /// ζ of the free coordinates, (free, n_u); `None` at an undamped resonance.
    fn coordinates(&self, omega: f64) -> Option<Mat<c64>> {
        let loads = self.loads(omega);
        match (self.solution(), &self.modal, &self.complex) {
            (Solution::Modes, Some(modal), _) => {
                let mut amounts = modal.shapes.transpose() * &loads;
                let excited = column_norms(&amounts);
                for (n, square) in modal.squares.iter().enumerate() {
                    let resists = c64::new(
                        square - omega * omega,
                        omega * modal.damping[(n, n)] + self.loss * square,
                    );
                    let is_resonant = resists.norm() <= f64::EPSILON * square.abs();
                    respond(&mut amounts, n, resists, is_resonant, &excited)?;
                }
                Some(&modal.shapes * amounts)
            }
            (Solution::ComplexModes, Some(modal), Some(of)) => {
                let mut amounts = &of.amounts * (modal.shapes.transpose() * &loads);
                let excited = column_norms(&amounts);
                for (n, pole) in of.poles.iter().enumerate() {
                    let resists = c64::new(0.0, omega) - *pole;
                    let is_resonant = resists.norm() <= f64::EPSILON * pole.norm();
                    respond(&mut amounts, n, resists, is_resonant, &excited)?;
                }
                Some(&modal.shapes * (&of.shapes * amounts))
            }
            _ => self.direct(omega),
        }
    }

    /// The same by solving the equations themselves.
    fn direct(&self, omega: f64) -> Option<Mat<c64>> {
        let SecondOrder {
            matrices, units, ..
        } = &self.linear.second_order;
        let loads = self.loads(omega);
        if self.free == 0 {
            return Some(loads);
        }
        // Damping that was asked for of the modes replaces the other.
        let own = self.modal.as_ref().and_then(|modal| modal.given.as_ref());
        let resists = Mat::from_fn(self.free, self.free, |i, j| {
            let mut entry = self.dynamic(matrices, omega, i, j);
            if let Some(own) = own {
                entry.im += omega * (own[(i, j)] - matrices[1][(i, j)]);
            }
            entry * (units[i] * units[j])
        });
        let loads = Mat::from_fn(self.free, loads.ncols(), |i, j| loads[(i, j)] * units[i]);
        // Not with complete pivoting: faer's solution of complex equations (0.24) was off by 1e-3 of the loads.
        let solved = resists.partial_piv_lu().solve(&loads);
        let solved = Mat::from_fn(self.free, loads.ncols(), |i, j| solved[(i, j)] * units[i]);
        let is_finite =
            (0..self.free).all(|i| (0..loads.ncols()).all(|j| solved[(i, j)].norm().is_finite()));
        is_finite.then_some(solved)
    }

    /// Resonances by rising frequency.
    pub fn resonances(&self) -> Vec<Resonance> {
        let mut all: Vec<Resonance> = match (self.solution(), &self.modal, &self.complex) {
            (Solution::Modes, Some(modal), _) => (modal.squares.iter().enumerate())
                .filter(|(_, square)| **square > 0.0)
                .map(|(n, square)| Resonance {
                    frequency: square.sqrt() / std::f64::consts::TAU,
                    ratio: 0.5 * (modal.damping[(n, n)] / square.sqrt() + self.loss),
                })
                .collect(),
            (Solution::ComplexModes, _, Some(of)) => (of.poles.iter())
                .filter(|pole| pole.im > 0.0)
                .map(|pole| Resonance {
                    frequency: pole.norm() / std::f64::consts::TAU,
                    ratio: -pole.re / pole.norm(),
                })
                .collect(),
            _ => (self.linear.system.poles.iter())
                .filter(|pole| pole.angular_frequency > 0.0)
                .map(|pole| Resonance {
                    frequency: pole.magnitude() / std::f64::consts::TAU,
                    ratio: pole.damping_ratio() + 0.5 * self.loss,
                })
                .collect(),
        };
        all.sort_by(|a, b| a.frequency.total_cmp(&b.frequency));
        all
    }
}

/// σ: of the frequency in the middle of those asked for, on a scale of ratios.
fn shift(asked: &FrequencyResponse) -> f64 {
    let highest = asked.highest();
    let middle = (asked.lowest().max(1e-3 * highest) * highest).sqrt();
    (std::f64::consts::TAU * middle).powi(2)
}

impl Modal {
    /// Of symmetric matrices in units of about equal coordinates; `wanted` are ratios in place of the damping.
    fn of(
        [mass, damping, stiffness]: &[Mat<f64>; 3],
        units: &[f64],
        wanted: Option<&ModalRatios>,
        shift: f64,
    ) -> Result<Self, Error> {
        let n = mass.nrows();
        let (squares, unit) = (SHIFTS.iter())
            .find_map(|factor| undamped(mass, stiffness, factor * shift))
            .ok_or(Error::NoEigenvalues)?;
        let damping = match wanted {
            None => unit.transpose() * (damping * &unit),
            Some(ratios) => {
                let moving: Vec<usize> = (0..n).filter(|k| squares[*k] > 0.0).collect();
                let rate = |k: usize| {
                    let place = moving.iter().position(|own| *own == k);
                    place.map_or(0.0, |place| 2.0 * ratios.of_mode(place) * squares[k].sqrt())
                };
                Mat::from_fn(n, n, |i, j| if i == j { rate(i) } else { 0.0 })
            }
        };
        let scale = damping.norm_max();
        let coupled =
            (0..n).any(|i| (0..n).any(|j| i != j && damping[(i, j)].abs() > ROUNDING * scale));
        // In coordinates without their units.
        let given = wanted.map(|_| {
            let own = mass * &unit;
            let whole = &own * &damping * own.transpose();
            Mat::from_fn(n, n, |i, j| whole[(i, j)] / (units[i] * units[j]))
        });
        Ok(Self {
            shapes: Mat::from_fn(n, n, |i, k| c64::new(units[i] * unit[(i, k)], 0.0)),
            squares,
            damping,
            is_diagonal: wanted.is_some() || !coupled,
            given,
        })
    }
}

fn column_norms(of: &Mat<c64>) -> Vec<f64> {
    of.col_iter().map(|column| column.norm_l2()).collect()
}

/// Turns what excites a mode into its response. `None` for a resonance without damping that is excited; one that isn't stays at rest.
fn respond(
    amounts: &mut Mat<c64>,
    mode: usize,
    resists: c64,
    is_resonant: bool,
    excited: &[f64],
) -> Option<()> {
    for (j, whole) in excited.iter().enumerate() {
        amounts[(mode, j)] = match is_resonant {
            false => amounts[(mode, j)] / resists,
            true if amounts[(mode, j)].norm() <= UNEXCITED * whole => c64::new(0.0, 0.0),
            true => return None,
        };
    }
    Some(())
}

/// ω² and shapes of unit mass, by rising ω², of K + σ M = L Lᵀ and L⁻¹ M L⁻ᵀ = V diag(μ) Vᵀ: ω² = 1/μ − σ and φ = L⁻ᵀ v/√μ.
///
/// The largest μ, the slowest modes, are the most accurate, and the static response of all modes together keeps its digits, however stiff the stiffest are.
fn undamped(mass: &Mat<f64>, stiffness: &Mat<f64>, shift: f64) -> Option<(Vec<f64>, Mat<f64>)> {
    let n = mass.nrows();
    let sum = stiffness + faer::Scale(shift) * mass;
    let factor = symmetrized(&sum).llt(faer::Side::Lower).ok()?;
    let lower = factor.L();
    let solved = |matrix: &Mat<f64>| {
        let mut columns = matrix.clone();
        lower.solve_lower_triangular_in_place(&mut columns);
        columns
    };
    let half = solved(mass).transpose().to_owned();
    let (values, vectors) = symmetric_eigen(symmetrized(solved(&half)).as_ref())?;
    let most = values.last().copied().filter(|most| *most > 0.0)?;
    let mut shapes = vectors;
    lower
        .transpose()
        .solve_upper_triangular_in_place(&mut shapes);
    // By falling μ.
    let order: Vec<usize> = (0..n).rev().collect();
    let mu = |k: usize| values[k].max(LEAST * most);
    let squares = order.iter().map(|k| 1.0 / mu(*k) - shift).collect();
    let unit = Mat::from_fn(n, n, |i, k| shapes[(i, order[k])] / mu(order[k]).sqrt());
    Some((squares, unit))
}

impl Complex {
    /// Of modes that damping couples; `None` where their state matrix has no complete set of eigenvectors. The state is (ω z, z'), in which modes that
    /// damping doesn't couple have orthonormal eigenvectors.
    fn of(modal: &Modal, loss: f64) -> Option<Self> {
        let n = modal.squares.len();
        let zero = c64::new(0.0, 0.0);
        let rates: Vec<f64> = (modal.squares.iter())
            .map(|square| square.abs().sqrt())
            .collect();
        let fastest = rates.iter().copied().fold(0.0, f64::max);
        // Modes without stiffness count as the slowest of the others.
        let slowest = (rates.iter().copied())
            .filter(|rate| *rate > STILL * fastest)
            .fold(fastest, f64::min);
        let rates: Vec<f64> = rates.iter().map(|rate| rate.max(slowest)).collect();
        let matrix = Mat::from_fn(2 * n, 2 * n, |i, j| match (i < n, j < n) {
            (true, false) if j - n == i => c64::new(rates[i], 0.0),
            (true, _) => zero,
            (false, true) if i - n == j => {
                let square = modal.squares[j];
                c64::new(-square, -loss * square) / rates[j]
            }
            (false, true) => zero,
            (false, false) => c64::new(-modal.damping[(i - n, j - n)], 0.0),
        });
        let eigen = matrix.eigen().ok()?;
        let vectors = eigen.U().to_owned();
        let right = Mat::from_fn(2 * n, n, |i, j| {
            c64::new(f64::from(u8::from(i == n + j)), 0.0)
        });
        let amounts = vectors.partial_piv_lu().solve(&right);
        let values = eigen.S().column_vector();
        Some(Self {
            poles: (0..2 * n).map(|k| values[k]).collect(),
            shapes: Mat::from_fn(n, 2 * n, |i, k| vectors[(i, k)] / rates[i]),
            amounts,
        })
    }
}
