//! Which rows of a study are worth their cost: those that no other row beats in cost and in error.

use crate::chart::{Axis, Chart, Note, Series, Style};

/// One row of a study as a buyer sees it. Both numbers are positive or zero; a row with one that isn't finite is never chosen.
#[derive(Clone, Debug, PartialEq)]
pub struct Candidate {
    /// Short name, for example the number of modes.
    pub label: String,
    /// Its cost: a time, a number of unknowns.
    pub cost: f64,
    /// How far it is off.
    pub error: f64,
}

impl Candidate {
    fn is_finite(&self) -> bool {
        self.cost.is_finite() && self.error.is_finite()
    }
}

/// Rows that belong together, for example one method with different numbers of modes.
#[derive(Clone, Debug, PartialEq)]
pub struct Family {
    /// Name in the legend.
    pub name: String,
    /// Its rows, in the order in which they are joined.
    pub candidates: Vec<Candidate>,
}

impl Family {
    /// Candidates in families by name, both in the order in which they come.
    pub fn of(named: impl IntoIterator<Item = (String, Candidate)>) -> Vec<Self> {
        let mut families: Vec<Self> = Vec::new();
        for (name, candidate) in named {
            match families.iter_mut().find(|family| family.name == name) {
                Some(family) => family.candidates.push(candidate),
                None => families.push(Self {
                    name,
                    candidates: vec![candidate],
                }),
            }
        }
        families
    }
}

/// Indices of the rows that no other row beats, by rising cost and falling error. Of rows that agree in both the first is taken.
pub fn pareto_front(candidates: &[Candidate]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..candidates.len())
        .filter(|index| candidates[*index].is_finite())
        .collect();
    // Stable: equal rows stay in order.
    order.sort_by(|a, b| {
        let (a, b) = (&candidates[*a], &candidates[*b]);
        (a.cost.total_cmp(&b.cost)).then(a.error.total_cmp(&b.error))
    });
    let mut best = f64::INFINITY;
    order.retain(|index| {
        let improves = candidates[*index].error < best;
        if improves {
            best = candidates[*index].error;
        }
        improves
    });
    order
}

/// The cheapest row with an error up to `tolerance`; of equally cheap ones that with the least error.
pub fn cheapest_within(candidates: &[Candidate], tolerance: f64) -> Option<usize> {
    (0..candidates.len())
        .filter(|index| candidates[*index].is_finite() && candidates[*index].error <= tolerance)
        .min_by(|a, b| {
            let (a, b) = (&candidates[*a], &candidates[*b]);
            (a.cost.total_cmp(&b.cost)).then(a.error.total_cmp(&b.error))
        })
}

/// Error against cost, both logarithmic: a curve for each family with its labels, and the front of all of them as steps.
pub fn pareto_chart(title: &str, cost: &str, error: &str, families: &[Family]) -> Chart {
    let all: Vec<Candidate> = families
        .iter()
        .flat_map(|family| family.candidates.iter().cloned())
        .collect();
    let front: Vec<&Candidate> = pareto_front(&all).into_iter().map(|i| &all[i]).collect();
    let mut steps = Vec::new();
    for (index, candidate) in front.iter().enumerate() {
        if let Some(before) = index.checked_sub(1).map(|before| front[before]) {
            steps.push([candidate.cost, before.error]);
        }
        steps.push([candidate.cost, candidate.error]);
    }
    let mut series: Vec<Series> = families
        .iter()
        .map(|family| Series {
            name: family.name.clone(),
            points: (family.candidates.iter())
                .map(|candidate| [candidate.cost, candidate.error])
                .collect(),
            style: Style::LineAndMarks,
        })
        .collect();
    series.push(Series {
        name: "not beaten".to_owned(),
        points: steps,
        style: Style::Line,
    });
    Chart {
        title: title.to_owned(),
        horizontal: Axis::logarithmic(cost),
        vertical: Axis::logarithmic(error),
        series,
        slopes: Vec::new(),
        notes: (all.iter())
            .map(|candidate| Note {
                text: candidate.label.clone(),
                at: [candidate.cost, candidate.error],
            })
            .collect(),
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    fn candidates(rows: &[[f64; 2]]) -> Vec<Candidate> {
        let named = rows.iter().enumerate();
        named
            .map(|(index, [cost, error])| Candidate {
                label: index.to_string(),
                cost: *cost,
                error: *error,
            })
            .collect()
    }

    #[test]
    fn the_front_is_what_nothing_beats() {
        let rows = candidates(&[
            [3.0, 1e-3],
            [1.0, 1e-1],
            [2.0, 2e-1],
            [2.0, 1e-2],
            [2.0, 1e-2],
            [4.0, 1e-3],
            [0.5, f64::NAN],
            [f64::INFINITY, 0.0],
        ]);
        let front = pareto_front(&rows);
        assert_eq!(front, [1, 3, 0]);
        // The definition, row by row.
        for (index, row) in rows.iter().enumerate().filter(|(_, row)| row.is_finite()) {
            let is_beaten = rows.iter().any(|other| {
                other.cost <= row.cost
                    && other.error <= row.error
                    && (other.cost < row.cost || other.error < row.error)
            });
            assert!(
                is_beaten || front.iter().any(|kept| rows[*kept].cost == row.cost),
                "{index}"
            );
            assert!(!(is_beaten && front.contains(&index)), "{index}");
        }
        assert_eq!(cheapest_within(&rows, 1e-2), Some(3));
        assert_eq!(cheapest_within(&rows, 1e-3), Some(0));
        assert_eq!(cheapest_within(&rows, 1e-4), None);
        assert!(pareto_front(&[]).is_empty());
    }

    #[test]
    fn the_chart_steps_along_the_front() {
        let families = [Family {
            name: "all".into(),
            candidates: candidates(&[[1.0, 1e-1], [2.0, 1e-2]]),
        }];
        let chart = pareto_chart("", "time [s]", "error [1]", &families);
        let front = chart.series.last().unwrap();
        assert_eq!(front.points, [[1.0, 1e-1], [2.0, 1e-1], [2.0, 1e-2]]);
        assert_eq!(chart.notes.len(), 2);
    }
}
