//! Whether the search for the modes can have missed one, decided from the search itself: its start block is random.
//!
//! A block Krylov space of S doesn't see an eigenvector u to which its start block is orthogonal. A random block isn't, but for a chance
//! that is known. So what the space leaves out is bounded by how far its polynomials damp the rest of the spectrum: the probabilistic bounds of
//! Kuczyński and Woźniakowski (1992) and of Van Dorsselaer, Hochstenbach and Van der Vorst (2001), here for a block, with the
//! recurrence's own numbers, and for roots with several copies (theory.md section 5).
//!
//! With `S V = V H + W C Eᵀ`, Ritz pairs `(θ_i, s_i)` of H, `ρ_i = C Eᵀ s_i`, the start block `V₁ R` and `γ_i = Rᵀ (s_i)₁`, an eigenvector u with
//! eigenvalue θ of S has in the start block the share
//!
//! ```text
//! z = Rᵀ V₁ᵀ M u = Σ_i γ_i (ρ_iᵀ w) / (θ - θ_i),   w = Wᵀ M u,   |w| ≤ 1.
//! ```
//!
//! The start block is `S D^-½ G` with standard normal G and `D = diag(M)`. `z_j / θ_j` is normal with the variance `uᵀ M D⁻¹ M u ≥ 1 / uᵀ D u`, and
//! motions with mass have `uᵀ D u ≤ 1/mass_part`. So the shares of any m eigenvectors are, as a matrix, at least `√mass_part` times a standard
//! normal one. Its smallest singular value is below δ with a chance given by Edelman (1988). If the sum above is smaller than what that leaves,
//! there is no such u.

use std::ops::Range;

use faer::{Mat, MatRef};

/// The chance of an error that is accepted, for all eigenvectors together.
pub(super) const CHANCE: f64 = 1e-12;
/// Relative half widths of the intervals around the Ritz values that were found; wide ones say more about how many eigenvalues they hold, narrow ones keep
/// close roots apart.
const WIDTHS: [f64; 5] = [1e-2, 1e-3, 1e-4, 1e-5, 1e-6];
/// Rounding in H and its eigenvectors, over its largest eigenvalue: some times what was found with exact solutions.
const PROJECTED: f64 = 200.0 * f64::EPSILON;
/// A cell of the axis is this part of its centre's distance from the Ritz values left out,
const CELL: f64 = 1.0 / 16.0;
/// and its series has so many terms: what they leave is below rounding.
const TERMS: usize = 14;
/// More cells than the axis ever has.
const CELLS: usize = 4000;

/// What a search knows at its end.
pub(super) struct KrylovSpace<'a> {
    /// θ_i, descending.
    pub values: &'a [f64],
    /// γ_i, (block, pairs).
    pub start: MatRef<'a, f64>,
    /// ρ_i, (next block, pairs).
    pub leaving: MatRef<'a, f64>,
    /// n.
    pub dofs: usize,
    /// The chance of an error that is accepted.
    pub chance: f64,
    /// A motion u has mass if uᵀ M u is more than this part of uᵀ D u.
    pub mass_part: f64,
    /// The largest of ε|u|ᵀ|K||u| over M-normalised modes, ω²: what rounding in solutions adds to an eigenvalue. An estimate for what was not found.
    pub rounding: f64,
}

impl KrylovSpace<'_> {
    /// Whether S has no other eigenvalues from `limit` on than the first `found` Ritz values, but for that chance.
    pub fn has_all(&self, found: usize, limit: f64) -> bool {
        let Some(pole) = self.values.get(found).copied() else {
            return false;
        };
        if !(limit > pole && pole > 0.0) {
            return false;
        }
        // The interval of the last one found is above the limit.
        let is_apart = |width: &f64| match found {
            0 => true,
            _ => self.values[found - 1] * (1.0 - width) > limit,
        };
        let allowed = self.allowed();
        WIDTHS
            .iter()
            .filter(|width| is_apart(width))
            .any(|width| self.has_all_at(*width, found, limit, &allowed))
    }

    /// δ √mass_part for shares of 1, 2, … eigenvectors. Any that follow each other may be the ones: as many choices as dofs.
    fn allowed(&self) -> Vec<f64> {
        let block = self.start.nrows();
        let chance = self.chance / (self.dofs as f64 * block as f64);
        (1..=block)
            .map(|count| smallest_singular_value(block, count, chance) * self.mass_part.sqrt())
            .collect()
    }

    /// With intervals of one width; there are more Ritz values than `found`.
    fn has_all_at(&self, width: f64, found: usize, limit: f64, allowed: &[f64]) -> bool {
        let (groups, pole) = (self.groups(width, found), self.values[found]);
        let mut low = limit;
        for _ in 0..CELLS {
            let reach = (low - pole) / (1.0 - CELL);
            let cell = Cell {
                centre: pole + reach,
                half: CELL * reach,
                low,
            };
            let left_out = self.series(&cell, found);
            // No eigenvalue of its own,
            let alone = self.share(&cell, left_out, width, found, 0..0) / low;
            let mut is_excluded = alone <= allowed[0];
            // and none beside those that were found.
            for group in &groups {
                let (least, most) = self.interval(width, group);
                if most < low || least > cell.high() {
                    continue;
                }
                let more = ((group.len() + 1) as f64).sqrt();
                let share = self.share(&cell, left_out, width, found, group.clone()) / least;
                is_excluded &= more * share <= allowed.get(group.len()).copied().unwrap_or(0.0);
            }
            if !is_excluded {
                return false;
            }
            low = cell.centre + cell.half;
            let top = self.values[0] * (1.0 + width);
            if low > 2.0 * top && self.bound_beyond(low) <= allowed[0] {
                return true;
            }
        }
        false
    }

    /// Found Ritz values whose intervals touch, or nearly.
    fn groups(&self, width: f64, found: usize) -> Vec<Range<usize>> {
        let mut groups: Vec<Range<usize>> = Vec::new();
        for i in 0..found {
            let value = self.values[i];
            match groups.last_mut() {
                Some(group) if self.values[i - 1] - value <= 4.0 * width * self.values[i - 1] => {
                    group.end = i + 1;
                }
                _ => groups.push(i..i + 1),
            }
        }
        groups
    }

    /// Where eigenvalues close to those of a group are.
    fn interval(&self, width: f64, group: &Range<usize>) -> (f64, f64) {
        (
            self.values[group.end - 1] * (1.0 - width),
            self.values[group.start] * (1.0 + width),
        )
    }

    /// The most that the Ritz values left out let through in a cell, ‖Σ γ_i ρ_iᵀ / (θ - θ_i)‖: a series about its centre.
    pub(super) fn series(&self, cell: &Cell, found: usize) -> f64 {
        let next = self.leaving.nrows();
        let rest = found..self.values.len();
        let mut weights: Vec<f64> = rest
            .clone()
            .map(|i| 1.0 / (cell.centre - self.values[i]))
            .collect();
        let ratios: Vec<f64> = weights.iter().map(|weight| weight * cell.half).collect();
        let mut sum = 0.0;
        for _ in 0..TERMS {
            let weighted = Mat::from_fn(weights.len(), next, |i, k| {
                weights[i] * self.leaving[(k, found + i)]
            });
            let start = self.start.subcols(found, weights.len());
            let term: Mat<f64> = start * &weighted;
            sum += term.norm_l2();
            weights.iter_mut().zip(&ratios).for_each(|(w, r)| *w *= r);
        }
        let remainder = rest
            .zip(weights.iter().zip(&ratios))
            .map(|(i, (weight, ratio))| self.size(i) * weight / (1.0 - ratio));
        sum + remainder.sum::<f64>()
    }

    /// The largest |z| in a cell of an eigenvector that is at least `width` from the Ritz values found, those of `but` aside.
    fn share(
        &self,
        cell: &Cell,
        left_out: f64,
        width: f64,
        found: usize,
        but: Range<usize>,
    ) -> f64 {
        let mut sum = left_out + self.start_rounding(cell.high());
        for i in (0..self.values.len()).filter(|i| !but.contains(i)) {
            let mut apart = cell.distance(self.values[i]);
            if i < found {
                apart = apart.max(width * self.values[i]);
                sum += self.size(i) / apart;
            }
            sum += self.rounded(i, cell.high()) / apart;
        }
        sum
    }

    /// The largest |z|/θ from a value on that is above all Ritz values.
    fn bound_beyond(&self, low: f64) -> f64 {
        let parts = (0..self.values.len())
            .map(|i| (self.size(i) + self.rounded(i, low)) / (low - self.values[i]));
        (parts.sum::<f64>() + self.start_rounding(low)) / low
    }

    /// What rounding adds to ‖γ_i‖ ρ_iᵀ w, for an eigenvector with θ: in the solutions and in the projected problem.
    fn rounded(&self, i: usize, theta: f64) -> f64 {
        let solutions = self.rounding * self.values[i] * theta;
        self.start.col(i).norm_l2() * (solutions + PROJECTED * self.values[0])
    }

    /// What rounding adds to the share z itself.
    fn start_rounding(&self, theta: f64) -> f64 {
        self.start.norm_l2() * (self.rounding * theta + PROJECTED)
    }

    /// ‖γ_i‖ ‖ρ_i‖.
    fn size(&self, i: usize) -> f64 {
        self.start.col(i).norm_l2() * self.leaving.col(i).norm_l2()
    }
}

/// A piece of the axis of θ.
pub(super) struct Cell {
    pub centre: f64,
    pub half: f64,
    pub low: f64,
}

impl Cell {
    fn high(&self) -> f64 {
        self.centre + self.half
    }

    fn distance(&self, value: f64) -> f64 {
        (self.low - value).max(value - self.high()).max(0.0)
    }
}

/// δ so that a standard normal matrix of `rows` rows and `columns` columns, not more than rows, has a singular value below it with at most this
/// chance (Edelman 1988: the density of the smallest eigenvalue λ of GᵀG is at most L λ^((rows - columns - 1)/2)).
pub(super) fn smallest_singular_value(rows: usize, columns: usize, chance: f64) -> f64 {
    let (rows, columns) = (rows as f64, columns as f64);
    let excess = rows - columns + 1.0;
    let log_l = 0.5 * (rows - columns - 1.0) * std::f64::consts::LN_2
        + libm::lgamma(0.5 * (rows + 1.0))
        - libm::lgamma(0.5 * columns)
        - libm::lgamma(excess);
    ((chance.ln() - log_l + (0.5 * excess).ln()) / excess).exp()
}
