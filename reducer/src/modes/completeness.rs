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
/// Ritz values that are within four times this part of each other are looked at together, as one root; wide groups say less about how many eigenvalues they
/// hold, narrow ones less about what is between them. The first is also the largest relative half width of an interval around a group.
const WIDTHS: [f64; 5] = [1e-2, 1e-3, 1e-4, 1e-5, 1e-6];
/// An interval takes this part of what is between two groups, on either side: inside one more has to be excluded than between them.
const PART_OF_GAP: f64 = 0.25;
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
        let allowed = self.allowed(found + 2);
        self.has_all_from(found, limit, &allowed)
            || self.has_all_beside_next(found, limit, &allowed)
    }

    /// Whether a limit is below the first `found` Ritz values and above the next one, and that above zero.
    fn is_between(&self, found: usize, limit: f64) -> bool {
        let is_above = found == 0 || self.values.get(found - 1).is_some_and(|last| *last > limit);
        let next = self.values.get(found).copied();
        is_above && next.is_some_and(|next| limit > next && next > 0.0)
    }

    /// The same by what is around the limit.
    pub(super) fn has_all_from(&self, found: usize, limit: f64, allowed: &[f64]) -> bool {
        if !self.is_between(found, limit) {
            return false;
        }
        let mut groups = Vec::from(WIDTHS.map(|width| self.groups(width, found, limit)));
        groups.dedup();
        groups
            .iter()
            .any(|groups| self.has_all_beside(groups, found, limit, allowed))
    }

    /// The same by what is around a lower limit, below the next Ritz value, where that is close to the limit: there are no others from
    /// the lower limit on, and the next one is where its Ritz value is.
    fn has_all_beside_next(&self, found: usize, limit: f64, allowed: &[f64]) -> bool {
        let (Some(next), Some(pole)) = (self.values.get(found), self.values.get(found + 1)) else {
            return false;
        };
        let lower = 0.5 * (next + pole);
        let error = self.error(found + 1);
        self.is_between(found, limit)
            && next + error < limit
            && lower < next - error
            && self.has_all_from(found + 1, lower, allowed)
    }

    /// How far the last of the first Ritz values is at most from the last of as many eigenvalues of S, which they belong to one by one (Kahan 1967, as in Parlett, The
    /// Symmetric Eigenvalue Problem, theorem 11.5.1): the norm of what S makes of their vectors beyond them; and rounding.
    fn error(&self, count: usize) -> f64 {
        let last = self.values[count - 1];
        let leaving = self.leaving.subcols(0, count).norm_l2();
        leaving + self.rounding * last * last + PROJECTED * self.values[0]
    }

    /// δ √mass_part for shares of 1, 2, … of so many eigenvectors.
    ///
    /// If more eigenvalues than were found are above a limit, one of the largest, as many and one, is outside of all intervals, or one interval has more of these than Ritz
    /// values. So that many eigenvectors, and as many runs of each length among them, must not have small shares.
    pub(super) fn allowed(&self, eigenvectors: usize) -> Vec<f64> {
        let block = self.start.nrows();
        let chance = self.chance / (eigenvectors as f64 * block as f64);
        (1..=block)
            .map(|count| smallest_singular_value(block, count, chance) * self.mass_part.sqrt())
            .collect()
    }

    /// With intervals around these groups; there are more Ritz values than `found`.
    fn has_all_beside(&self, groups: &[Group], found: usize, limit: f64, allowed: &[f64]) -> bool {
        let pole = self.values[found];
        let mut low = limit;
        for _ in 0..CELLS {
            let reach = (low - pole) / (1.0 - CELL);
            let cell = Cell {
                centre: pole + reach,
                half: CELL * reach,
                low,
            };
            let left_out = self.left_out(&cell, found);
            let share =
                |theta: f64, but: Range<usize>| left_out + self.of_found(theta, &cell, found, but);
            // No eigenvalue of its own between the intervals,
            let ends = groups.iter().flat_map(|group| [group.least, group.most]);
            let ends = ends
                .chain([low, cell.high()])
                .filter(|end| cell.has(*end) && !groups.iter().any(|group| group.is_around(*end)));
            let mut is_excluded = ends
                .map(|end| share(end, 0..0) / low)
                .all(|alone| alone <= allowed[0]);
            // and in each none beside those that were found.
            for group in groups {
                let [first, last] = [group.least.max(low), group.most.min(cell.high())];
                if first > last {
                    continue;
                }
                let count = group.values.len();
                let more = ((count + 1) as f64).sqrt();
                let most =
                    share(first, group.values.clone()).max(share(last, group.values.clone()));
                is_excluded &= more * most / first <= allowed.get(count).copied().unwrap_or(0.0);
            }
            if !is_excluded {
                return false;
            }
            low = cell.centre + cell.half;
            let top = groups.first().map_or(self.values[0], |first| first.most);
            if low > 2.0 * top && self.bound_beyond(low) <= allowed[0] {
                return true;
            }
        }
        false
    }

    /// Found Ritz values that are nearly one, with intervals above the limit that don't overlap.
    fn groups(&self, width: f64, found: usize, limit: f64) -> Vec<Group> {
        let mut groups: Vec<Range<usize>> = Vec::new();
        for i in 0..found {
            match groups.last_mut() {
                Some(group) if self.gap(i) <= 4.0 * width * self.values[i - 1] => group.end = i + 1,
                _ => groups.push(i..i + 1),
            }
        }
        let group = |values: Range<usize>| {
            let [first, last] = [self.values[values.start], self.values[values.end - 1]];
            let above = match values.start {
                0 => f64::INFINITY,
                start => PART_OF_GAP * self.gap(start),
            };
            let below = match values.end == found {
                true => last - limit,
                false => PART_OF_GAP * self.gap(values.end),
            };
            let half_width = above.min(below).min(WIDTHS[0] * last);
            Group {
                least: last - half_width,
                most: first + half_width,
                values,
            }
        };
        groups.into_iter().map(group).collect()
    }

    /// Between a Ritz value and the one above it.
    fn gap(&self, i: usize) -> f64 {
        self.values[i - 1] - self.values[i]
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

    /// What the Ritz values left out, and rounding in the start, add to |z| in a cell.
    fn left_out(&self, cell: &Cell, found: usize) -> f64 {
        let rounded = (found..self.values.len())
            .map(|i| self.rounded(i, cell.high()) / (cell.low - self.values[i]));
        self.series(cell, found) + rounded.sum::<f64>() + self.start_rounding(cell.high())
    }

    /// What the Ritz values found, but for some, add to |z| at θ in a cell. Between them this is convex: the most of a piece of the axis is at its ends.
    fn of_found(&self, theta: f64, cell: &Cell, found: usize, but: Range<usize>) -> f64 {
        (0..found)
            .filter(|i| !but.contains(i))
            .map(|i| (self.size(i) + self.rounded(i, cell.high())) / (theta - self.values[i]).abs())
            .sum()
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

/// Ritz values that are looked at as one root.
#[derive(PartialEq)]
struct Group {
    /// Their places.
    values: Range<usize>,
    /// Ends of the interval in which its eigenvalues are.
    least: f64,
    most: f64,
}

impl Group {
    /// Whether a value is inside the interval.
    fn is_around(&self, value: f64) -> bool {
        self.least < value && value < self.most
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

    fn has(&self, value: f64) -> bool {
        self.low <= value && value <= self.high()
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
