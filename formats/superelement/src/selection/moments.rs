//! Power moments of a smaller superelement, for its error estimate: those of `docs/error-estimate.md` with the modes that were left out among the omitted.
//!
//! ```text
//! M_1' = M_1 + Σ c cᵀ / ω²                  M_2' = M_2 + Σ c cᵀ / ω⁴                    c = L φ of the modes left out
//! M_3' = M_3 + Σ c cᵀ / (ω⁴ (ω² + σ))       M_4' = M_4 + Σ c cᵀ / (ω⁴ (ω² + σ)²)
//! ```
//! They are those of every row, whichever forces act. The forces B that a superelement is made for stand beside them, with a bound of their own: modes that
//! B doesn't move don't count for it (`idle_modes.rs`).

use dcb_dense::symmetrized;
use dcb_formats::superelement::{LoadedForces, Moments, Superelement};
use faer::{Mat, MatRef};

use super::idle_modes::Shares;

/// Modes, rows and columns of a superelement that stay, by their places in it.
pub(super) struct Kept<'a> {
    /// L_b Φ after the turn, (n_b, n_k).
    pub shapes: MatRef<'a, f64>,
    /// Combinations of modes of one multiple root, (n_k, n_k).
    pub turn: Option<&'a Mat<f64>>,
    pub modes: &'a [usize],
    pub left_out: &'a [usize],
    pub rows: &'a [usize],
    /// Whether rows that stay are only observed.
    pub observed: &'a [bool],
    pub further: &'a [usize],
    /// B over all rows, (n_b, n_p).
    pub forces: &'a Mat<f64>,
    /// Whether they are fewer than the rows that they act on.
    pub is_cut: bool,
}

/// The modes left out as the moments see them, over the rows and further columns that stay.
struct LeftOut<'a> {
    whole: &'a Superelement,
    of: &'a Moments,
    kept: &'a Kept<'a>,
    /// Rows and further columns that stay, by their places in the moments.
    places: Vec<usize>,
    /// L φ of the modes left out, (places, modes left out); zero in further columns.
    shapes: Mat<f64>,
}

impl<'a> LeftOut<'a> {
    /// Further columns stay with all modes only, so that no mode's work on their loads is needed.
    fn new(whole: &'a Superelement, of: &'a Moments, kept: &'a Kept<'a>) -> Self {
        let n_b = whole.rows.len();
        let further = kept.further.iter().map(|place| n_b + place);
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
        let elastic = (kept.modes.iter()).filter(|mode| self.squares()[**mode] > 0.0);
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
            observed: (0..rows).filter(|row| kept.observed[*row]).collect(),
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
            let spread = 4.0 * spread(self.squares(), kept.turn, *mode);
            for row in (0..kept.rows.len()).filter(|_| spread > 0.0) {
                rounding[row] += spread * shares.cosines[(row, k)].powi(2);
            }
        }
        rounding
    }

    /// Relative error of a mode's ω².
    fn eigenvalue_error(&self, mode: usize) -> f64 {
        let (squares, turn) = (self.squares(), self.kept.turn);
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

/// The moments of the superelement that is kept.
pub(super) fn moments(whole: &Superelement, of: &Moments, kept: &Kept) -> Moments {
    let left_out = LeftOut::new(whole, of, kept);
    let [first, second, third, fourth] = [
        left_out.added_to(&of.first, 0),
        left_out.added_to(&of.second, 1),
        left_out.added_to(&of.third, 2),
        left_out.added_to(&of.fourth, 3),
    ];
    let forces = acting(kept);
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
    let errors = kept.modes.iter();
    Moments {
        eigenvalue_bound: left_out.eigenvalue_bound(of.eigenvalue_bound, |_| true),
        eigenvalue_errors: errors
            .map(|mode| left_out.eigenvalue_error(*mode))
            .collect(),
        rigid_shapes: Mat::from_fn(kept.rows.len(), of.rigid_shapes.ncols(), |i, k| {
            of.rigid_shapes[(kept.rows[i], k)]
        }),
        shift: of.shift,
        rounding: left_out.rounding(&shares, &idle),
        first,
        second,
        third,
        fourth,
        loaded: (kept.is_cut || before.is_some() || !idle.is_empty()).then_some(loaded),
    }
}

/// B over the rows that stay, without columns that don't act on them.
fn acting(kept: &Kept) -> Mat<f64> {
    let picked = |force: usize| kept.rows.iter().map(move |row| kept.forces[(*row, force)]);
    let columns: Vec<usize> = (0..kept.forces.ncols())
        .filter(|force| picked(*force).any(|entry| entry != 0.0))
        .collect();
    Mat::from_fn(kept.rows.len(), columns.len(), |row, j| {
        kept.forces[(kept.rows[row], columns[j])]
    })
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
