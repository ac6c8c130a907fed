//! What the error estimate of a smaller superelement knows: the moments of `docs/error-estimate.md` with the modes that were left out among the omitted.
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

/// What stays of a superelement, by places in it.
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

/// The moments of what is kept. Further columns stay with all modes only, so that no mode's work on their loads is needed.
pub(super) fn moments(whole: &Superelement, of: &Moments, kept: &Kept) -> Moments {
    let (n_b, rows) = (whole.rows.len(), kept.rows.len());
    let further = kept.further.iter().map(|place| n_b + place);
    let places: Vec<usize> = kept.rows.iter().copied().chain(further).collect();
    let squares = &whole.modes.eigenvalues;
    let shapes = Mat::from_fn(places.len(), kept.left_out.len(), |i, k| {
        match places[i] < n_b {
            true => kept.shapes[(places[i], kept.left_out[k])],
            false => 0.0,
        }
    });
    // c cᵀ counts by 1/ω², 1/ω⁴ and so on.
    let weights = |mode: usize| {
        let square = squares[mode];
        let shifted = square + of.shift;
        [
            1.0 / square,
            square.powi(-2),
            1.0 / (square.powi(2) * shifted),
            (square * shifted).powi(-2),
        ]
    };
    let with = |moment: &Mat<f64>, power: usize| {
        let weighted = Mat::from_fn(shapes.nrows(), shapes.ncols(), |i, k| {
            shapes[(i, k)] * weights(kept.left_out[k])[power]
        });
        let added = symmetrized(weighted * shapes.transpose());
        Mat::from_fn(places.len(), places.len(), |i, j| {
            moment[(places[i], places[j])] + added[(i, j)]
        })
    };
    let [first, second, third, fourth] = [
        with(&of.first, 0),
        with(&of.second, 1),
        with(&of.third, 2),
        with(&of.fourth, 3),
    ];
    let of_omitted: Vec<[f64; 4]> = (0..rows)
        .map(|i| [&first, &second, &third, &fourth].map(|moment| moment[(i, i)]))
        .collect();
    let elastic = kept.modes.iter().filter(|mode| squares[**mode] > 0.0);
    let elastic: Vec<usize> = elastic.copied().collect();
    let of_all: Vec<[f64; 4]> = (0..rows)
        .map(|i| {
            elastic.iter().fold(of_omitted[i], |mut sums, mode| {
                let own = kept.shapes[(kept.rows[i], *mode)].powi(2);
                for (sum, weight) in sums.iter_mut().zip(weights(*mode)) {
                    *sum += own * weight;
                }
                sums
            })
        })
        .collect();
    let cosines = |sizes: &[[f64; 4]]| {
        Mat::from_fn(rows, kept.left_out.len(), |i, k| {
            let parts = sizes[i].iter().zip(weights(kept.left_out[k]));
            parts
                .filter(|(size, _)| **size > 0.0)
                .map(|(size, weight)| (shapes[(i, k)].powi(2) * weight / size).sqrt())
                .fold(0.0, f64::max)
        })
    };
    let forces = acting(kept);
    let shares = Shares {
        acting: rows_of_plain(&forces).unwrap_or_default(),
        observed: (0..rows).filter(|row| kept.observed[*row]).collect(),
        cosines: cosines(&of_omitted),
        of_all: cosines(&of_all),
    };
    let idle = shares.idle();
    let mut rounding: Vec<f64> = places.iter().map(|place| of.rounding[*place]).collect();
    for (k, mode) in kept.left_out.iter().enumerate() {
        if idle.contains(&k) {
            shares.add_leak(k, &mut rounding);
        }
        // The root of a moment's entry is as uncertain as its ω² to the fourth power at most.
        let spread = 4.0 * spread(squares, kept.turn, *mode);
        for row in (0..rows).filter(|_| spread > 0.0) {
            rounding[row] += spread * shares.cosines[(row, k)].powi(2);
        }
    }
    let error = |mode: &usize| {
        let group = (0..squares.len()).filter(|other| is_part(kept.turn, *other, *mode));
        let own = group.map(|other| of.eigenvalue_errors[other]);
        own.fold(0.0, f64::max) + spread(squares, kept.turn, *mode)
    };
    let least = |from: f64, counts: &dyn Fn(usize) -> bool| {
        let modes = kept.left_out.iter().enumerate();
        let counted = modes.filter(|(k, _)| counts(*k));
        counted
            .map(|(_, mode)| squares[*mode] * (1.0 - error(mode)))
            .fold(from, f64::min)
    };
    let before = of.loaded.as_ref().map(|loaded| loaded.eigenvalue_bound);
    let loaded = LoadedForces {
        eigenvalue_bound: least(before.unwrap_or(of.eigenvalue_bound), &|k| {
            !idle.contains(&k)
        }),
        forces,
    };
    Moments {
        eigenvalue_bound: least(of.eigenvalue_bound, &|_| true),
        eigenvalue_errors: kept.modes.iter().map(error).collect(),
        rigid_shapes: Mat::from_fn(rows, of.rigid_shapes.ncols(), |i, k| {
            of.rigid_shapes[(kept.rows[i], k)]
        }),
        shift: of.shift,
        first,
        second,
        third,
        fourth,
        rounding,
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

fn is_part(turn: Option<&Mat<f64>>, other: usize, mode: usize) -> bool {
    match turn {
        Some(turn) => turn[(other, mode)] != 0.0,
        None => other == mode,
    }
}

/// How far the ω² of the modes that a turned one is made of lie from its own, relatively.
fn spread(squares: &[f64], turn: Option<&Mat<f64>>, mode: usize) -> f64 {
    let own = squares[mode];
    let parts = (0..squares.len()).filter(|other| is_part(turn, *other, mode));
    parts
        .map(|other| match squares[other] == own {
            true => 0.0,
            false => (squares[other] - own).abs() / own,
        })
        .fold(0.0, f64::max)
}
