//! Which rows of a study are worth their cost: the Pareto front.

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

/// What the front is, for readers.
pub const PARETO_FRONT: &str = "Pareto front: the variants for which no other variant has both a lower cost and a smaller error.";

/// Indices of the rows of the Pareto front, by rising cost and falling error: no other row is at least as good in cost and in error, and
/// better in one of them. Of rows that agree in both the first is taken.
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

/// At most `most` rows of a front, evenly chosen from one end to the other; from three on `wanted` is among them, if it is a row of the front.
pub fn thinned(front: &[usize], most: usize, wanted: Option<usize>) -> Vec<usize> {
    let (count, most) = (front.len(), most.max(1));
    if count <= most {
        return front.to_vec();
    }
    let mut places: Vec<usize> = match most {
        1 => vec![0],
        _ => (0..most)
            .map(|index| (index * (count - 1) + (most - 1) / 2) / (most - 1))
            .collect(),
    };
    let wanted = front.iter().position(|row| Some(*row) == wanted);
    if let Some(wanted) = wanted.filter(|place| !places.contains(place)) {
        // The ends stay.
        let inner = places.iter_mut().skip(1).take(most.saturating_sub(2));
        if let Some(nearest) = inner.min_by_key(|place| place.abs_diff(wanted)) {
            *nearest = wanted;
        }
    }
    places.into_iter().map(|place| front[place]).collect()
}

/// Error against cost, both logarithmic: the Pareto front as steps with the labels of its rows, and the other rows as small marks. The pointer
/// over a mark shows what `told` says of its row, in the order of the candidates.
pub fn pareto_chart(
    title: &str,
    cost: &str,
    error: &str,
    candidates: &[Candidate],
    told: &[String],
) -> Chart {
    let front = pareto_front(candidates);
    let at = |index: &usize| [candidates[*index].cost, candidates[*index].error];
    let others: Vec<usize> = (0..candidates.len())
        .filter(|index| candidates[*index].is_finite() && !front.contains(index))
        .collect();
    let series = |name: &str, rows: &[usize], style: Style| Series {
        name: name.to_owned(),
        points: rows.iter().map(at).collect(),
        style,
    };
    let note = |index: &usize, label: &str| Note {
        label: label.to_owned(),
        told: told.get(*index).cloned().unwrap_or_default(),
        at: at(index),
    };
    Chart {
        title: title.to_owned(),
        horizontal: Axis::logarithmic(cost),
        vertical: Axis::logarithmic(error),
        series: vec![
            series("other rows", &others, Style::FaintMarks),
            series("Pareto front", &front, Style::Steps),
        ],
        slopes: Vec::new(),
        notes: (others.iter().map(|index| note(index, "")))
            .chain((front.iter()).map(|index| note(index, &candidates[*index].label)))
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
    fn a_thinned_front_keeps_its_ends_and_the_wanted_row() {
        let front: Vec<usize> = (100..113).collect();
        for most in 3..14 {
            for wanted in front.iter().copied().map(Some).chain([None, Some(7)]) {
                let thin = thinned(&front, most, wanted);
                assert_eq!(thin.len(), most.min(13));
                assert!(thin.windows(2).all(|pair| pair[0] < pair[1]), "{thin:?}");
                assert_eq!((thin.first(), thin.last()), (Some(&100), Some(&112)));
                assert!(wanted.is_none_or(|wanted| wanted == 7 || thin.contains(&wanted)));
            }
        }
        assert_eq!(thinned(&front, 5, None), [100, 103, 106, 109, 112]);
        assert_eq!(thinned(&front, 5, Some(107)), [100, 103, 107, 109, 112]);
        assert_eq!(thinned(&front[..3], 6, None), [100, 101, 102]);
        assert!(thinned(&[], 6, Some(1)).is_empty());
    }

    /// Non-dominated rows by the definition, pair by pair.
    fn by_definition(rows: &[Candidate]) -> Vec<usize> {
        let dominates = |a: &Candidate, b: &Candidate| {
            a.cost <= b.cost && a.error <= b.error && (a.cost < b.cost || a.error < b.error)
        };
        let mut front: Vec<usize> = (0..rows.len())
            .filter(|index| !rows.iter().any(|other| dominates(other, &rows[*index])))
            .collect();
        front.sort_by(|a, b| rows[*a].cost.total_cmp(&rows[*b].cost));
        front
    }

    #[test]
    fn the_chart_names_the_front_and_tells_of_every_row() {
        // A scatter without order, and no two alike.
        let rows: Vec<[f64; 2]> = (1..60_u32)
            .map(|index| {
                [
                    f64::from(index * 37 % 101),
                    1.0 / f64::from(index * 53 % 97),
                ]
            })
            .collect();
        let rows = candidates(&rows);
        let told: Vec<String> = (0..rows.len())
            .map(|row| format!("row <{row}>, 1 s"))
            .collect();
        let chart = pareto_chart("", "time [s]", "error [1]", &rows, &told);
        let front = by_definition(&rows);
        assert!(front.len() > 3 && front.len() < 20, "{front:?}");
        let points: Vec<[f64; 2]> = (front.iter())
            .map(|index| [rows[*index].cost, rows[*index].error])
            .collect();
        let drawn = chart.series.last().unwrap();
        assert_eq!(
            (drawn.name.as_str(), &drawn.points),
            ("Pareto front", &points)
        );
        assert_eq!(chart.series[0].points.len(), rows.len() - front.len());
        let labels = chart.notes.iter().filter(|note| !note.label.is_empty());
        assert_eq!(labels.map(|note| note.at).collect::<Vec<_>>(), points);
        let svg = crate::svg(&[chart]).unwrap();
        assert_eq!(svg.matches("<title>row &lt;").count(), rows.len());
        for row in 0..rows.len() {
            assert!(
                svg.contains(&format!("<title>row &lt;{row}&gt;, 1 s</title>")),
                "{row}"
            );
        }
        assert_eq!(svg.matches(">\nPareto front\n<").count(), 1, "{svg}");
    }
}
