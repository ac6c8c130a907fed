//! Charts of a study: what an error costs, responses, and errors over the band.

use dcb_report::{Axis, Candidate, Chart, Series, Style, pareto_chart, pareto_front, svg, thinned};

use super::record::{ComponentRow, Measure, StoredCurves};
use super::report::Report;
use dcb_reducer::error::Error;
use dcb_reducer::scientific::scientific;

/// Errors below this are rounding; the Pareto pictures show them here.
const ROUNDING: f64 = 1e-14;
/// Rows of the front that have curves, at most.
const MOST_CURVES: usize = 6;

/// What a row costs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Cost {
    /// Time of the reduction.
    Time,
    /// Unknowns of a simulation.
    Unknowns,
}

impl Report<'_> {
    /// The rows as candidates of the Pareto front: their largest error of the response, and a cost.
    fn candidates(&self, cost: Cost) -> Vec<Candidate> {
        let error = |row: &ComponentRow| {
            let transfer = row.error(Measure::TransferResponse).unwrap_or(0.0);
            row.errors.collocated.largest.max(transfer).max(ROUNDING)
        };
        (self.rows.iter())
            .map(|row| Candidate {
                label: format!("{} {}", row.family(), row.modes),
                cost: match cost {
                    Cost::Time => row.reduction_seconds,
                    Cost::Unknowns => row.unknowns as f64,
                },
                error: error(row),
            })
            .collect()
    }

    /// The rows of the Pareto front, by rising cost.
    pub(super) fn front(&self, cost: Cost) -> Vec<usize> {
        pareto_front(&self.candidates(cost))
    }

    /// Response error against time, and against unknowns.
    pub(super) fn pareto(&self) -> Vec<Chart> {
        let chart = |title: &str, horizontal: &str, cost: Cost| {
            let candidates = self.candidates(cost);
            let told: Vec<String> = (self.rows.iter().zip(&candidates))
                .map(|(row, candidate)| {
                    format!(
                        "{}: {} unknowns; reduction {} s; largest error of the response {} (relative)",
                        row.title(),
                        row.unknowns,
                        short(row.reduction_seconds),
                        scientific(candidate.error, 1)
                    )
                })
                .collect();
            let what = "largest error of the response [1]";
            pareto_chart(title, horizontal, what, &candidates, &told)
        };
        vec![
            chart(
                "Error against the time of the reduction",
                "reduction and writing [s]",
                Cost::Time,
            ),
            chart(
                "Error against the unknowns of a simulation",
                "unknowns of the body beside its frame",
                Cost::Unknowns,
            ),
        ]
    }

    fn over_frequency(&self, vertical: &str, mut series: Vec<Series>) -> Chart {
        let left_out = self.rows.len() - self.with_curves().len();
        if left_out > 0 {
            let remark = |name: String| Series {
                name,
                points: Vec::new(),
                style: Style::Remark,
            };
            series.push(remark(format!(
                "{left_out} of {} rows left out,",
                self.rows.len()
            )));
            series.push(remark("all are in study.csv".to_owned()));
        }
        Chart {
            title: String::new(),
            horizontal: Axis::linear("frequency [Hz]"),
            vertical: Axis::logarithmic(vertical),
            series,
            slopes: Vec::new(),
            notes: Vec::new(),
        }
    }

    fn curve(&self, name: &str, values: &[Option<f64>]) -> Series {
        let points = self.frequencies().into_iter().zip(values);
        Series {
            name: name.to_owned(),
            points: points
                .map(|(frequency, value)| [frequency, value.unwrap_or(f64::NAN)])
                .collect(),
            style: Style::NamedLine,
        }
    }

    /// Rows of the front by unknowns, evenly thinned to those that can be told apart in a picture.
    pub(super) fn with_curves(&self) -> Vec<&ComponentRow> {
        let front = thinned(&self.front(Cost::Unknowns), MOST_CURVES, None);
        front.into_iter().map(|index| &self.rows[index]).collect()
    }

    /// The responses that are drawn, each with its title: the reference, and rows of the front.
    pub(super) fn responses(&self) -> Vec<(String, Chart)> {
        let chart = |take: &dyn Fn(&StoredCurves) -> Vec<Option<f64>>| {
            let mut series = vec![self.curve("unreduced", &take(&self.reference.curves))];
            let rows = self.with_curves().into_iter();
            series.extend(rows.map(|row| self.curve(&row.title(), &take(&row.curves))));
            self.over_frequency("|H|, scaled [1]", series)
        };
        let [own, between] = &self.reference.drawn;
        let mut charts = Vec::new();
        if let Some(what) = own {
            let collocated = |curves: &StoredCurves| curves.collocated.clone();
            charts.push((what.clone(), chart(&collocated)));
        }
        if let Some(what) = between {
            let transfer = |curves: &StoredCurves| curves.transfer.clone();
            charts.push((what.clone(), chart(&transfer)));
        }
        charts
    }

    /// The error over the band of the same rows.
    pub(super) fn errors(&self) -> Chart {
        let rows = self.with_curves().into_iter();
        let series = rows.map(|row| self.curve(&row.title(), &row.curves.error));
        self.over_frequency("|H - H_ref| / |H_ref| [1]", series.collect())
    }
}

/// Seconds with three digits.
fn short(seconds: f64) -> String {
    match seconds < 0.01 {
        true => scientific(seconds, 2),
        false => format!("{seconds:.3}"),
    }
}

/// Charts below each other, as SVG.
pub(super) fn drawn(charts: &[Chart]) -> Result<String, Error> {
    svg(charts).map_err(|_| Error::NotFinite {
        what: "the pictures",
    })
}
