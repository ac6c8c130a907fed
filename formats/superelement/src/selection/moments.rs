//! Power moments of a smaller superelement, for its error estimate: those of `docs/error-estimate.md` with the modes that were left out among the omitted.
//!
//! ```text
//! M_1' = M_1 + Σ c cᵀ / ω²                  M_2' = M_2 + Σ c cᵀ / ω⁴                    c = L φ of the modes left out
//! M_3' = M_3 + Σ c cᵀ / (ω⁴ (ω² + σ))       M_4' = M_4 + Σ c cᵀ / (ω⁴ (ω² + σ)²)
//! ```
//! They are those of every row, whichever forces act. The forces B that a superelement is made for stand beside them, with a bound of their own: modes
//! left out that B doesn't move don't count for it, whatever their frequency is, such as those that lead out of a plane of symmetry, under forces in it. A
//! share below [`MOVED`] is what rounding and meshes leave of a symmetry; what it can do at a resonance counts as rounding of the rows.

use crate::LOSS_FACTOR;
use dcb_dense::symmetrized;
use dcb_formats::superelement::{LoadedForces, Moments, Superelement};
use faer::Mat;

use super::basis::Basis;
use super::interface::{InterfaceSelection, loaded_forces};
use super::plane::SYMMETRIC;

/// A mode is moved by a force from this fraction on of the most that it could be, as a cosine.
const MOVED: f64 = SYMMETRIC;
/// How far a resonance enlarges a response over its static one.
const RESONANCE: f64 = 1.0 / LOSS_FACTOR;

/// Effect of modes left out on rows.
struct Shares {
    /// c over the root of μ and of the row's moment, the largest of the four moments, (rows, modes).
    cosines: Mat<f64>,
    /// The same over the root of the moment with all modes in it.
    of_all: Mat<f64>,
    /// Rows that forces act on, one each.
    acting: Vec<usize>,
    /// Rows that are only observed.
    observed: Vec<usize>,
}

impl Shares {
    /// Places of the modes that no force moves.
    fn idle(&self) -> Vec<usize> {
        let moved = |mode: usize| {
            let mut rows = self.acting.iter();
            rows.any(|row| self.of_all[(*row, mode)] > MOVED)
        };
        match self.acting.is_empty() {
            true => Vec::new(),
            false => (0..self.of_all.ncols())
                .filter(|mode| !moved(*mode))
                .collect(),
        }
    }

    /// Adds to each row's rounding what an idle mode could do: the root of the product of two rows' is not below 1/η of the product of their cosines.
    fn add_leak(&self, mode: usize, rounding: &mut [f64]) {
        let cosine = |row: &usize| self.cosines[(*row, mode)];
        let of_acting = self.acting.iter().map(cosine).fold(0.0, f64::max);
        let of_all = self.observed.iter().map(cosine).fold(of_acting, f64::max);
        for row in &self.acting {
            rounding[*row] += RESONANCE * cosine(row) * of_all;
        }
        for row in &self.observed {
            rounding[*row] += RESONANCE * cosine(row) * of_acting;
        }
    }
}

/// The modes left out as the moments see them, over the rows and further columns that stay.
struct LeftOut<'a> {
    whole: &'a Superelement,
    of: &'a Moments,
    kept: &'a Basis,
    /// Rows and further columns that stay, by their places in the moments.
    places: Vec<usize>,
    /// L φ of the modes left out, (places, modes left out); zero in further columns.
    shapes: Mat<f64>,
}

impl<'a> LeftOut<'a> {
    /// Further columns stay with all modes only, so that no mode's work on their loads is needed.
    fn new(whole: &'a Superelement, of: &'a Moments, kept: &'a Basis) -> Self {
        let n_b = whole.rows.len();
        let further = kept.selection.enrichment.iter().map(|place| n_b + place);
        let places: Vec<usize> = kept.rows.iter().copied().chain(further).collect();
        let shapes = Mat::from_fn(places.len(), kept.left_out.len(), |i, k| {
            match places[i] < n_b {
                true => kept.shapes[(places[i], kept.left_out[k])],
                false => 0.0,
            }
        });
        Self {
            whole,
            of,
            kept,
            places,
            shapes,
        }
    }

    fn squares(&self) -> &'a [f64] {
        &self.whole.modes.eigenvalues
    }

    /// Factors of c cᵀ of a mode in M_1 to M_4: 1/ω², 1/ω⁴ and so on.
    fn weights(&self, mode: usize) -> [f64; 4] {
        let square = self.squares()[mode];
        let shifted = square + self.of.shift;
        [
            1.0 / square,
            square.powi(-2),
            1.0 / (square.powi(2) * shifted),
            (square * shifted).powi(-2),
        ]
    }

    /// The moment of this power with the modes left out among the omitted.
    fn added_to(&self, moment: &Mat<f64>, power: usize) -> Mat<f64> {
        let (shapes, places) = (&self.shapes, &self.places);
        let weighted = Mat::from_fn(shapes.nrows(), shapes.ncols(), |i, k| {
            shapes[(i, k)] * self.weights(self.kept.left_out[k])[power]
        });
        let added = symmetrized(weighted * shapes.transpose());
        Mat::from_fn(places.len(), places.len(), |i, j| {
            moment[(places[i], places[j])] + added[(i, j)]
        })
    }

    /// Shares of the modes left out in the rows, given the new moments.
    fn shares(&self, moments: [&Mat<f64>; 4], forces: &Mat<f64>) -> Shares {
        let (kept, rows) = (self.kept, self.kept.rows.len());
        let of_omitted: Vec<[f64; 4]> = (0..rows)
            .map(|i| moments.map(|moment| moment[(i, i)]))
            .collect();
        let elastic = (kept.selection.modes.iter()).filter(|mode| self.squares()[**mode] > 0.0);
        let elastic: Vec<usize> = elastic.copied().collect();
        let of_all: Vec<[f64; 4]> = (0..rows)
            .map(|i| {
                elastic.iter().fold(of_omitted[i], |mut sums, mode| {
                    let own = kept.shapes[(kept.rows[i], *mode)].powi(2);
                    for (sum, weight) in sums.iter_mut().zip(self.weights(*mode)) {
                        *sum += own * weight;
                    }
                    sums
                })
            })
            .collect();
        let cosines = |sizes: &[[f64; 4]]| {
            Mat::from_fn(rows, kept.left_out.len(), |i, k| {
                let fractions = sizes[i].iter().zip(self.weights(kept.left_out[k]));
                fractions
                    .filter(|(size, _)| **size > 0.0)
                    .map(|(size, weight)| (self.shapes[(i, k)].powi(2) * weight / size).sqrt())
                    .fold(0.0, f64::max)
            })
        };
        Shares {
            acting: rows_of_plain(forces).unwrap_or_default(),
            observed: (0..rows)
                .filter(|row| !kept.is_loaded(self.whole, kept.rows[*row]))
                .collect(),
            cosines: cosines(&of_omitted),
            of_all: cosines(&of_all),
        }
    }

    /// Rounding of each row and further column, with that of the modes left out.
    fn rounding(&self, shares: &Shares, idle: &[usize]) -> Vec<f64> {
        let kept = self.kept;
        let own = (self.places.iter()).map(|place| self.of.rounding[*place]);
        let mut rounding: Vec<f64> = own.collect();
        for (k, mode) in kept.left_out.iter().enumerate() {
            if idle.contains(&k) {
                shares.add_leak(k, &mut rounding);
            }
            // The root of a moment's entry is as uncertain as its ω² to the fourth power at most.
            let spread = 4.0 * spread(self.squares(), kept.selection.turn.as_ref(), *mode);
            for row in (0..kept.rows.len()).filter(|_| spread > 0.0) {
                rounding[row] += spread * shares.cosines[(row, k)].powi(2);
            }
        }
        rounding
    }

    /// Relative error of a mode's ω².
    fn eigenvalue_error(&self, mode: usize) -> f64 {
        let (squares, turn) = (self.squares(), self.kept.selection.turn.as_ref());
        let group = (0..squares.len()).filter(|other| is_in_turn(turn, *other, mode));
        let own = group.map(|other| self.of.eigenvalue_errors[other]);
        own.fold(0.0, f64::max) + spread(squares, turn, mode)
    }

    /// The least ω² of the modes left out that count, and of those omitted before.
    fn eigenvalue_bound(&self, before: f64, counts: impl Fn(usize) -> bool) -> f64 {
        let modes = self.kept.left_out.iter().enumerate();
        let counted = modes.filter(|(k, _)| counts(*k));
        counted
            .map(|(_, mode)| self.squares()[*mode] * (1.0 - self.eigenvalue_error(*mode)))
            .fold(before, f64::min)
    }
}

impl Basis {
    /// The moments of the superelement that is kept.
    pub(super) fn moments(&self, whole: &Superelement) -> Option<Moments> {
        let of = whole.moments.as_ref()?;
        let left_out = LeftOut::new(whole, of, self);
        let [first, second, third, fourth] = [
            left_out.added_to(&of.first, 0),
            left_out.added_to(&of.second, 1),
            left_out.added_to(&of.third, 2),
            left_out.added_to(&of.fourth, 3),
        ];
        let forces = self.acting(whole);
        let shares = left_out.shares([&first, &second, &third, &fourth], &forces);
        let idle = shares.idle();
        let before = of.loaded.as_ref().map(|loaded| loaded.eigenvalue_bound);
        let of_forces = left_out.eigenvalue_bound(before.unwrap_or(of.eigenvalue_bound), |k| {
            !idle.contains(&k)
        });
        let loaded = LoadedForces {
            eigenvalue_bound: of_forces,
            forces,
        };
        let is_cut =
            |wanted: &InterfaceSelection| matches!(wanted, InterfaceSelection::LoadedAlong(_));
        let is_cut = self.selection.interfaces.iter().any(is_cut);
        let errors = self.selection.modes.iter();
        Some(Moments {
            eigenvalue_bound: left_out.eigenvalue_bound(of.eigenvalue_bound, |_| true),
            eigenvalue_errors: errors
                .map(|mode| left_out.eigenvalue_error(*mode))
                .collect(),
            rigid_shapes: Mat::from_fn(self.rows.len(), of.rigid_shapes.ncols(), |i, k| {
                of.rigid_shapes[(self.rows[i], k)]
            }),
            shift: of.shift,
            rounding: left_out.rounding(&shares, &idle),
            first,
            second,
            third,
            fourth,
            loaded: (is_cut || before.is_some() || !idle.is_empty()).then_some(loaded),
        })
    }

    /// B over the rows that stay, without columns that don't act on them.
    fn acting(&self, whole: &Superelement) -> Mat<f64> {
        let loaded = loaded_forces(whole, &self.selection.interfaces);
        let picked = |force: usize| self.rows.iter().map(|row| loaded[(*row, force)]).collect();
        let columns: Vec<Vec<f64>> = (0..loaded.ncols()).map(picked).collect();
        let acts = |force: &&Vec<f64>| force.iter().any(|entry| *entry != 0.0);
        let columns: Vec<&Vec<f64>> = columns.iter().filter(acts).collect();
        Mat::from_fn(self.rows.len(), columns.len(), |row, j| columns[j][row])
    }
}

/// Rows that forces act on, if each acts on one row; where they act on several at once it isn't told row by row what they move.
fn rows_of_plain(forces: &Mat<f64>) -> Option<Vec<usize>> {
    let row = |force: usize| {
        let mut rows = (0..forces.nrows()).filter(|row| forces[(*row, force)] != 0.0);
        let first = rows.next();
        first.filter(|_| rows.next().is_none())
    };
    (0..forces.ncols()).map(row).collect()
}

/// Whether a turned mode is made of this other one, too.
fn is_in_turn(turn: Option<&Mat<f64>>, other: usize, mode: usize) -> bool {
    match turn {
        Some(turn) => turn[(other, mode)] != 0.0,
        None => other == mode,
    }
}

/// How far the ω² of the modes that a turned one is made of lie from its own, relatively.
fn spread(squares: &[f64], turn: Option<&Mat<f64>>, mode: usize) -> f64 {
    let own = squares[mode];
    let parts = (0..squares.len()).filter(|other| is_in_turn(turn, *other, mode));
    parts
        .map(|other| match squares[other] == own {
            true => 0.0,
            false => (squares[other] - own).abs() / own,
        })
        .fold(0.0, f64::max)
}
