//! Which row to take for a wanted error.

use dcb_report::{Candidate, cheapest_within};
use serde::Serialize;

use super::record::{ComponentRow, Measure};
use super::variant::Variant;

/// The row with the fewest unknowns whose errors are small enough.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Best {
    /// Measures that it was chosen by.
    pub measures: Vec<Measure>,
    /// Its place among the rows; `None` if no row is good enough.
    pub row: Option<usize>,
    /// Its largest error by these measures.
    pub error: Option<f64>,
}

/// The best row by each measure that any row has, and by all of them together. Weak is never named: it is there to compare with the
/// literature and has motions that grow.
pub fn best_rows(rows: &[ComponentRow], tolerance: f64) -> Vec<Best> {
    let applicable: Vec<Measure> = Measure::ALL
        .into_iter()
        .filter(|measure| rows.iter().any(|row| row.error(*measure).is_some()))
        .collect();
    let mut asked: Vec<Vec<Measure>> = applicable.iter().map(|measure| vec![*measure]).collect();
    if applicable.len() > 1 {
        asked.push(applicable);
    }
    asked
        .into_iter()
        .map(|measures| {
            let candidates: Vec<Candidate> = rows
                .iter()
                .map(|row| Candidate {
                    label: row.title(),
                    cost: row.unknowns as f64,
                    error: match row.variant {
                        Variant::Weak => f64::INFINITY,
                        _ => worst(row, &measures),
                    },
                })
                .collect();
            let row = cheapest_within(&candidates, tolerance);
            Best {
                error: row.map(|row| candidates[row].error),
                row,
                measures,
            }
        })
        .collect()
}

/// A response that a row doesn't have is infinitely wrong.
fn worst(row: &ComponentRow, measures: &[Measure]) -> f64 {
    measures
        .iter()
        .map(|measure| row.error(*measure).unwrap_or(f64::INFINITY))
        .fold(0.0, f64::max)
}
