//! The estimate of a file, for people and as JSON.

use dcb_assembly::AssemblyReport;
use dcb_formats::scene::Compatibility;
use std::fmt::Write as _;

use dcb_formats::Superelement;
use dcb_superelement::LOSS_FACTOR;
use serde_json::{Value, json};

use dcb_formats::units::{hertz, hertz_unit, si_factor};
use dcb_reducer::error::{BandRefusal, Error};
use dcb_reducer::scientific::scientific;
use dcb_superelement::FrequencyBand;
use dcb_superelement::error_bounds::{Bracket, ErrorBounds, Estimate, POINTS};

/// One line: how far responses at the interfaces may be off over the usual band, and up to which frequency; `None` without a bound.
pub fn accuracy(element: &Superelement) -> Option<String> {
    let bounds = ErrorBounds::of(element, Compatibility::Strong).ok()??;
    let rows = bounds.attached_rows();
    let band = bounds.usual_band(POINTS).filter(|_| !rows.is_empty())?;
    let [collocated, transfer] = bounds.responses(&rows, &band, LOSS_FACTOR).ok()?;
    let largest = collocated.largest.upper.max(transfer.largest.upper);
    let time = &element.units.time;
    let (end, unit) = (hertz(band.top(), time), hertz_unit(time));
    // The parts' omitted motions are in the moments of an assembly; the shapes of its modes are taken as they are.
    let of_what = match AssemblyReport::stored(element).is_some() {
        true => "bound with the parts' truncation, to first order in the shapes of the modes",
        false => "rigorous bound",
    };
    largest.is_finite().then(|| {
        format!(
            "responses at the interfaces are right within {} up to {end:.4} {unit} ({of_what}, loss factor {LOSS_FACTOR})",
            scientific(largest, 2)
        )
    })
}

/// Errors of a superelement in both forms.
pub struct Report {
    time_unit: String,
    band: FrequencyBand,
    /// Name of an interface that is loaded along some forces only, how many, and of how many rows.
    loaded_along: Vec<(String, [usize; 2])>,
    forms: Vec<(Compatibility, Estimate)>,
}

impl Report {
    /// Over a band in Hz, or over the usual one; `None` where a file has no moments, or nothing that could be off.
    pub fn of(element: &Superelement, hertz: Option<[f64; 2]>) -> Result<Option<Self>, Error> {
        let mut forms = Vec::new();
        let mut used = None;
        let mut loaded_along = Vec::new();
        for form in [Compatibility::Strong, Compatibility::Static] {
            let Some(estimate) = ErrorBounds::of(element, form)? else {
                break;
            };
            let rows = estimate.attached_rows();
            let named =
                |(place, counts): (usize, _)| (element.interfaces[place].name.clone(), counts);
            loaded_along = estimate
                .loaded_along(element)
                .into_iter()
                .map(named)
                .collect();
            let band = match hertz {
                Some(ends) => Some(between(&estimate, element, ends)?),
                None => estimate.usual_band(POINTS),
            };
            let Some(band) = band.filter(|_| !rows.is_empty()) else {
                break;
            };
            forms.push((form, estimate.over(&rows, &band, LOSS_FACTOR)?));
            used = Some(band);
        }
        match (used, hertz) {
            (Some(band), _) => Ok(Some(Self {
                time_unit: element.units.time.clone(),
                band,
                loaded_along,
                forms,
            })),
            (None, None) => Ok(None),
            (None, Some(_)) => Err(BandRefusal::NoMoments {
                superelement: element.name.clone(),
            }
            .into()),
        }
    }

    /// Lines of `reduce inspect`.
    pub fn text(&self) -> String {
        let ends = self.ends().map(|end| format!("{end:.4}"));
        let unit = hertz_unit(&self.time_unit);
        let mut text = format!(
            "errors, rigorous bounds from {} to {} {unit}, loss factor {LOSS_FACTOR}\n",
            ends[0], ends[1]
        );
        if !self.loaded_along.is_empty() {
            let of = |(name, [along, all]): &(String, [usize; 2])| {
                format!("{name} along {along} of {all} directions")
            };
            let along: Vec<String> = self.loaded_along.iter().map(of).collect();
            let _ = writeln!(
                text,
                "  for the forces that it is made for: {}",
                along.join(", ")
            );
        }
        let shown = |bracket: Option<Bracket>| match bracket {
            Some(Bracket { lower, upper }) => {
                format!("{} to {}", scientific(lower, 2), scientific(upper, 2))
            }
            None => "none".to_owned(),
        };
        let mut line = |what: &str, found: [String; 2]| {
            let _ = writeln!(text, "  {what:<34} {:<24} {}", found[0], found[1]);
        };
        line("", ["strong".into(), "static".into()]);
        for (what, take) in MEASURES {
            let both: Vec<String> = self.forms.iter().map(|(_, of)| shown(take(of))).collect();
            if let Ok(both) = <[String; 2]>::try_from(both) {
                line(what, both);
            }
        }
        let free = self.forms.iter().map(|(_, of)| of.free_frequency);
        let free = free.fold(0.0, f64::max);
        let _ = writeln!(
            text,
            "  {:<34} up to {}",
            "kept free frequencies",
            scientific(free, 2)
        );
        text
    }

    /// For programs.
    pub fn json(&self) -> Value {
        let squares = [self.band.squares.first(), self.band.squares.last()];
        let mut value = json!({
            "band_eigenvalues": squares,
            "band_hz": si_factor(&self.time_unit).map(|_| self.ends()),
            "points": self.band.squares.len(),
            "loss_factor": LOSS_FACTOR,
        });
        if !self.loaded_along.is_empty() {
            let along = self.loaded_along.iter().map(|(name, [along, all])| {
                (name.clone(), json!({ "forces": along, "rows": all }))
            });
            value["loaded_along"] = along.collect();
        }
        for (form, estimate) in &self.forms {
            value[form.name()] = json!(estimate);
        }
        value
    }

    fn ends(&self) -> [f64; 2] {
        let square = |value: Option<&f64>| value.copied().unwrap_or(0.0);
        let squares = &self.band.squares;
        [squares.first(), squares.last()].map(|end| hertz(square(end), &self.time_unit))
    }
}

/// Title of a measure, and where it stands in an estimate.
type Measure = (&'static str, fn(&Estimate) -> Option<Bracket>);

const MEASURES: [Measure; 4] = [
    ("held frequency", |of| of.held_frequency),
    ("static response", |of| Some(of.static_response)),
    ("collocated response", |of| Some(of.collocated.largest)),
    ("transfer response", |of| {
        of.transfer.map(|transfer| transfer.largest)
    }),
];

fn between(
    estimate: &ErrorBounds,
    element: &Superelement,
    ends: [f64; 2],
) -> Result<FrequencyBand, Error> {
    let time = &element.units.time;
    let second = si_factor(time).ok_or_else(|| BandRefusal::UnknownTimeUnit {
        superelement: element.name.clone(),
        unit: time.clone(),
    })?;
    let [from, to] = ends.map(|hertz| (2.0 * std::f64::consts::PI * hertz * second).powi(2));
    let bound = estimate.eigenvalue_bound();
    if to >= bound {
        return Err(BandRefusal::BeyondHertz {
            superelement: element.name.clone(),
            end: ends[1],
            bound: hertz(bound, time),
        }
        .into());
    }
    Ok(estimate.band(Some(from), to, POINTS))
}
