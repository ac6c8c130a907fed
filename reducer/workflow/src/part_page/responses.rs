//! Frequency responses of a superelement with bounds for those of the whole part.

use dcb_formats::Superelement;
use dcb_formats::scene::Compatibility;
use dcb_formats::units::{DerivedUnits, hertz, hertz_unit};
use dcb_reducer::error::Error;
use dcb_superelement::LOSS_FACTOR;
use dcb_superelement::error_bounds::{Bracket, ErrorBounds, Estimate, POINTS};
use dcb_view::{Arrays, Band, Chart, ChartAxis, Curve};

/// Interfaces whose response is drawn, at most.
const MOST: usize = 4;

/// Charts, and the estimate over their band.
pub struct Responses {
    pub charts: Vec<Chart>,
    /// Frequencies between which the estimate holds, Hz where the time unit is known.
    pub band: Option<[f64; 2]>,
    pub estimate: Option<Estimate>,
}

impl Responses {
    /// The largest upper bound of a relative error of a response.
    pub fn worst(&self) -> Option<f64> {
        let estimate = self.estimate.as_ref()?;
        let upper = |bracket: Bracket| bracket.upper;
        let collocated = upper(estimate.collocated.largest);
        let transfer = estimate
            .transfer
            .map_or(0.0, |transfer| upper(transfer.largest));
        Some(collocated.max(transfer))
    }
}

pub fn of(element: &Superelement, arrays: &mut Arrays) -> Result<Responses, Error> {
    let mut found = Responses {
        charts: Vec::new(),
        band: None,
        estimate: None,
    };
    let Some(bounds) = ErrorBounds::of(element, Compatibility::Strong)? else {
        return Ok(found);
    };
    let rows = bounds.attached_rows();
    let Some(band) = bounds.usual_band(POINTS).filter(|_| !rows.is_empty()) else {
        return Ok(found);
    };
    let time = &element.units.time;
    let frequencies: Vec<f64> = band
        .squares
        .iter()
        .map(|square| hertz(*square, time))
        .collect();
    found.band = frequencies
        .first()
        .copied()
        .zip(frequencies.last().copied())
        .map(<[f64; 2]>::from);
    found.estimate = Some(bounds.over(&rows, &band, LOSS_FACTOR)?);
    let x = arrays.reals(frequencies.iter().copied());
    let frequency = || ChartAxis {
        label: format!("frequency [{}]", hertz_unit(time)),
        log: true,
    };
    let mut errors = Vec::new();
    for row in first_rows(element, &rows) {
        let mut drawn: [Vec<f64>; 4] = Default::default();
        let of_row = bounds.between(&[row])?;
        for square in &band.squares {
            let at = of_row.at(*square, LOSS_FACTOR)?;
            let (reduced, radius) = (at.reduced[(0, 0)], at.radius[(0, 0)]);
            let whole = (reduced + at.difference[(0, 0)]).norm();
            drawn[0].push(reduced.norm());
            drawn[1].push((whole - radius).max(0.0));
            drawn[2].push(whole + radius);
            let off = at.difference[(0, 0)].norm() + radius;
            // Of the whole part's response, which is at least the lower end of the band.
            let least = (whole - radius).max(0.0);
            drawn[3].push(if off < least {
                100.0 * off / least
            } else {
                100.0
            });
        }
        let [reduced, low, high, error] = drawn.map(|values| {
            // Single precision ends at 1e-38: a compliance in small units may be there.
            arrays.reals(values)
        });
        errors.push(Curve {
            name: element.row_name(row),
            x,
            y: error,
        });
        found.charts.push(Chart {
            title: element.row_name(row),
            x: frequency(),
            y: ChartAxis {
                label: format!("receptance [{}]", compliance_unit(element, row)),
                log: true,
            },
            curves: vec![Curve {
                name: "superelement".into(),
                x,
                y: reduced,
            }],
            bands: vec![Band {
                name: "whole part".into(),
                x,
                low,
                high,
            }],
        });
    }
    found.charts.push(Chart {
        title: "Error of the response at the same interface, at most".into(),
        x: frequency(),
        y: ChartAxis {
            label: "error of the response [%]".into(),
            log: true,
        },
        curves: errors,
        bands: Vec::new(),
    });
    Ok(found)
}

/// Of a displacement or a turn by a force or a moment along the same row.
fn compliance_unit(element: &Superelement, row: usize) -> String {
    let units = &element.units;
    let derived = DerivedUnits::of(&units.length, &units.mass, &units.time);
    match element.rows.get(row).is_some_and(|row| row.direction >= 3) {
        true => format!("rad/({})", derived.moment),
        false => match derived.force.contains(['*', '/']) {
            true => format!("{}/({})", units.length, derived.force),
            false => format!("{}/{}", units.length, derived.force),
        },
    }
}

/// The first row of each of some interfaces.
fn first_rows(element: &Superelement, rows: &[usize]) -> Vec<usize> {
    let mut firsts: Vec<usize> = Vec::new();
    for row in rows {
        let interface = element.rows[*row].interface;
        let is_translation = (0..3).contains(&element.rows[*row].direction);
        let is_new = firsts
            .iter()
            .all(|known| element.rows[*known].interface != interface);
        if is_new && is_translation && firsts.len() < MOST {
            firsts.push(*row);
        }
    }
    firsts
}
