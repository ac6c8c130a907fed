//! Charts of a study: what an error costs, responses, and errors over the band.

use dcb_report::{Axis, Candidate, Chart, Family, Series, Style, pareto_chart, svg};

use super::record::{ComponentRow, Measure, StoredCurves};
use super::report::Report;
use dcb_reducer::error::Error;

/// Errors below this are rounding; the Pareto pictures show them here.
const ROUNDING: f64 = 1e-14;

impl Report<'_> {
    /// Response error against time, and against unknowns.
    pub(super) fn pareto(&self) -> Vec<Chart> {
        let error = |row: &ComponentRow| {
            let transfer = row.error(Measure::TransferResponse).unwrap_or(0.0);
            row.errors.collocated.largest.max(transfer).max(ROUNDING)
        };
        let families = |cost: &dyn Fn(&ComponentRow) -> f64| {
            Family::of(self.rows.iter().map(|row| {
                let candidate = Candidate {
                    label: row.modes.to_string(),
                    cost: cost(row),
                    error: error(row),
                };
                (row.family(), candidate)
            }))
        };
        let what = "largest error of the response";
        vec![
            pareto_chart(
                "Error against the time of the reduction; numbers are modes",
                "reduction and writing [s]",
                what,
                &families(&|row: &ComponentRow| row.reduction_seconds),
            ),
            pareto_chart(
                "Error against the unknowns of a simulation",
                "unknowns of the body beside its frame",
                what,
                &families(&|row: &ComponentRow| row.unknowns as f64),
            ),
        ]
    }

    fn over_frequency(&self, title: &str, vertical: &str, series: Vec<Series>) -> Chart {
        Chart {
            title: title.to_owned(),
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
            style: Style::Line,
        }
    }

    /// The responses that are drawn: the reference, and each form with the fewest modes, where they differ most.
    pub(super) fn responses(&self) -> Vec<Chart> {
        let mut shown: Vec<&ComponentRow> = Vec::new();
        for row in self.rows {
            if !shown.iter().any(|known| known.family() == row.family()) {
                shown.push(row);
            }
        }
        let chart = |title: &str, take: &dyn Fn(&StoredCurves) -> Vec<Option<f64>>| {
            let mut series = vec![self.curve("unreduced", &take(&self.reference.curves))];
            let rows = shown.iter();
            series.extend(rows.map(|row| self.curve(&row.title(), &take(&row.curves))));
            self.over_frequency(title, "|H|, scaled", series)
        };
        let [own, between] = &self.reference.drawn;
        let mut charts = Vec::new();
        if let Some(what) = own {
            charts.push(chart(what, &|curves: &StoredCurves| {
                curves.collocated.clone()
            }));
        }
        if let Some(what) = between {
            charts.push(chart(what, &|curves: &StoredCurves| {
                curves.transfer.clone()
            }));
        }
        charts
    }

    /// For each form the error over the band, a curve for each number of modes.
    pub(super) fn errors(&self) -> Vec<Chart> {
        let mut forms: Vec<(String, Vec<Series>)> = Vec::new();
        for row in self.rows {
            let series = self.curve(&row.title(), &row.curves.error);
            let form = row.form();
            match forms.iter_mut().find(|(known, _)| *known == form) {
                Some((_, all)) => all.push(series),
                None => forms.push((form, vec![series])),
            }
        }
        let charts = forms.into_iter().map(|(form, series)| {
            let title = format!("Error over the band: {form}");
            self.over_frequency(&title, "|H - H_ref| / |H_ref|", series)
        });
        charts.collect()
    }
}

/// Charts below each other, as SVG.
pub(super) fn drawn(charts: &[Chart]) -> Result<String, Error> {
    svg(charts).map_err(|_| Error::NotFinite {
        what: "the pictures",
    })
}
