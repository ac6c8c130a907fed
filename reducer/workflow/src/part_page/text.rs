//! What the page of a part says in words and tables, verdict first.

use std::path::Path;

use dcb_formats::Superelement;
use dcb_formats::units::{hertz, hertz_unit};
use dcb_reducer::error::Error;
use dcb_reducer::quality::Quality;
use dcb_reducer::quality::lines::quality_lines;
use dcb_reducer::scientific::scientific;
use dcb_report::{Cell, Column, Page, Table};
use dcb_superelement::LOSS_FACTOR;

use super::mac::Likeness;
use super::responses::Responses;
use crate::plain_words::plain_words;

/// What a page tells of.
pub struct Found<'a> {
    pub element: &'a Superelement,
    pub path: &'a Path,
    pub notes: &'a [String],
    /// Bound of a displacement's error in a mode, over its largest one.
    pub exactness: Option<f64>,
    pub mac: Option<Likeness>,
    pub responses: &'a Responses,
}

pub fn write(page: &mut Page, found: &Found) -> Result<(), Error> {
    let element = found.element;
    page.paragraph(&verdict(found));
    if !element.provenance.warnings.is_empty() {
        page.heading("Warnings of the reduction");
        page.list(&element.provenance.warnings);
    }
    page.heading("Modes in motion");
    page.markup("<div id=\"view\"></div>\n<noscript><p>The view needs JavaScript; the tables below don't.</p></noscript>\n");
    if let Some(exactness) = found.exactness {
        page.paragraph(&format!(
            "In each mode a displacement in the view is within {} % of the largest one: the page has it rounded to an integer.",
            plain(100.0 * exactness)
        ));
    }
    page.list(found.notes);
    if let Some([from, to]) = found.responses.band {
        let unit = hertz_unit(&element.units.time);
        page.heading("Frequency responses with bounds");
        page.paragraph(&format!(
            "Displacement for a unit force at the same row, with a loss factor of {LOSS_FACTOR}, from {} to {} {unit}. The response of the whole part is inside the band; the line is the superelement's. The last chart has the largest possible error of each of these responses, as a share of the whole part's; 100 % stands for 100 % and more. Where a response is almost zero its share is large. The table has the errors over all directions of an interface together.",
            plain(from),
            plain(to)
        ));
        for (number, chart) in found.responses.charts.iter().enumerate() {
            page.markup(&format!("<h3>{}</h3>\n", dcb_report::escaped(&chart.title)));
            page.markup(&format!(
                "<div class=\"chart\" data-chart=\"{number}\"></div>\n"
            ));
        }
        page.table(&errors(found.responses), &[]);
    }
    page.heading("Modes");
    page.table(&modes(element), &[]);
    if let Some(mac) = &found.mac {
        let said = match mac.largest {
            Some((value, first, second)) => format!(
                "How alike the modes look at the nodes (modal assurance criterion, MAC): 1 is the same shape. The most alike are modes {} and {}: {value:.3}.",
                first + 1,
                second + 1
            ),
            None => {
                "How alike the modes look at the nodes (modal assurance criterion, MAC).".into()
            }
        };
        page.picture(&mac.svg, &said);
    }
    page.heading("Interfaces");
    page.table(&interfaces(element), &[]);
    page.heading("Mass");
    page.table(&mass(element), &[]);
    if let Some(quality) = Quality::stored(element) {
        page.heading("Quality");
        page.paragraph("Each number is a relative defect of an identity that the superelement must keep, as the reduction found it.");
        let lines = quality_lines(&quality, &element.units.time);
        let lines: Vec<&str> = lines.lines().skip(1).map(str::trim).collect();
        page.list(&lines);
    }
    page.heading("Where it comes from");
    page.table(&provenance(found), &[]);
    Ok(())
}

/// What it is, how accurate, up to which frequency.
fn verdict(found: &Found) -> String {
    let element = found.element;
    let (time, unit) = (&element.units.time, hertz_unit(&element.units.time));
    let highest = element.modes.eigenvalues.last();
    let mut said = String::new();
    match (found.responses.worst(), found.responses.band) {
        (Some(worst), Some([_, to])) => {
            let word = match worst {
                worst if worst <= 1e-2 => "Good",
                worst if worst <= 0.1 => "Fair",
                _ => "Poor",
            };
            said += &format!(
                "{word}: up to {} {unit} the superelement moves as the whole part does, within {} %. This is a bound, not an estimate. ",
                grouped(to),
                plain(100.0 * worst)
            );
            if word == "Poor" {
                said += "Reduce with more modes, or use it at lower frequencies. ";
            }
        }
        _ => {
            let omitted = element.modes.first_omitted_eigenvalue;
            if omitted.is_finite() {
                said += &format!(
                    "The first frequency that it lacks is {} {unit}. The file has no data for error bounds. ",
                    plain(hertz(omitted, time))
                );
            }
        }
    }
    said += &format!(
        "It stands for the part with {} modes and {} attachment rows",
        element.mode_count(),
        element.boundary_row_count()
    );
    if let Some(highest) = highest {
        said += &format!(
            "; its modes reach {} {unit}",
            grouped(hertz(*highest, time))
        );
    }
    said += ". ";
    said += match element.provenance.warnings.len() {
        0 => "The reduction had no warnings.",
        _ => "The reduction had warnings: see below.",
    };
    said
}

/// Whole numbers with spaces between thousands where people can read them; else as [`plain`] has it.
fn grouped(value: f64) -> String {
    if !(1e3..1e7).contains(&value) {
        return plain(value);
    }
    let digits = format!("{value:.0}");
    let places = digits.len();
    let each = digits.char_indices().map(|(index, digit)| {
        let starts = index > 0 && (places - index).is_multiple_of(3);
        let space = if starts { "\u{a0}" } else { "" };
        format!("{space}{digit}")
    });
    each.collect()
}

/// Three digits, without an exponent where people don't need one.
fn plain(value: f64) -> String {
    let size = value.abs();
    if !(1e-3..1e7).contains(&size) {
        return scientific(value, 2);
    }
    let decimals = (2 - size.log10().floor() as i32).max(0) as usize;
    format!("{value:.decimals$}")
}

fn table(headings: &[(&str, &str)]) -> Table {
    let columns = headings.iter();
    let columns = columns.map(|(name, unit)| Column::new(name, name, unit));
    Table {
        columns: columns.collect(),
        rows: Vec::new(),
    }
}

fn errors(responses: &Responses) -> Table {
    let mut listed = table(&[
        ("largest relative error of", ""),
        ("at least", ""),
        ("at most", ""),
    ]);
    let Some(estimate) = &responses.estimate else {
        return listed;
    };
    let measures = [
        (
            "frequencies with the interfaces held",
            estimate.held_frequency,
        ),
        ("static response", Some(estimate.static_response)),
        (
            "response at the same interface",
            Some(estimate.collocated.largest),
        ),
        (
            "response between interfaces",
            estimate.transfer.map(|transfer| transfer.largest),
        ),
    ];
    for (what, bracket) in measures {
        listed.rows.push(vec![
            Cell::Text(what.to_owned()),
            Cell::maybe(bracket.map(|bracket| bracket.lower)),
            Cell::maybe(bracket.map(|bracket| bracket.upper)),
        ]);
    }
    listed
}

fn modes(element: &Superelement) -> Table {
    let unit = hertz_unit(&element.units.time);
    let rate = format!("rad/{}", element.units.time);
    let mut listed = table(&[
        ("mode", ""),
        ("frequency", &unit),
        ("angular frequency", &rate),
        ("damping ratio", ""),
    ]);
    for (index, eigenvalue) in element.modes.eigenvalues.iter().enumerate() {
        listed.rows.push(vec![
            Cell::Count(index as u64 + 1),
            Cell::Text(format!("{:.6}", hertz(*eigenvalue, &element.units.time))),
            Cell::Text(format!("{:.4}", eigenvalue.max(0.0).sqrt())),
            Cell::maybe(element.modes.damping.get(index).copied()),
        ]);
    }
    listed
}

fn interfaces(element: &Superelement) -> Table {
    let length = &element.units.length;
    let mut listed = table(&[
        ("interface", ""),
        ("kind", ""),
        ("role", ""),
        ("rows", ""),
        ("x", length),
        ("y", length),
        ("z", length),
    ]);
    for (index, interface) in element.interfaces.iter().enumerate() {
        let rows = element.rows.iter().filter(|row| row.interface == index);
        let mut cells = vec![
            Cell::Text(interface.name.clone()),
            Cell::Text(format!("{:?}", interface.kind).to_lowercase()),
            Cell::Text(format!("{:?}", interface.role).to_lowercase()),
            Cell::Count(rows.count() as u64),
        ];
        let origin = element.origin;
        cells.extend((0..3).map(|axis| Cell::Number(interface.position[axis] + origin[axis])));
        listed.rows.push(cells);
    }
    listed
}

fn mass(element: &Superelement) -> Table {
    let units = &element.units;
    let mut listed = table(&[("quantity", ""), ("value", "")]);
    let mut add = |what: String, value: String| {
        listed.rows.push(vec![Cell::Text(what), Cell::Text(value)]);
    };
    let line = |values: [f64; 3]| values.map(|value| scientific(value, 6)).join("  ");
    add(
        format!("mass [{}]", units.mass),
        scientific(element.inertia.mass, 9),
    );
    add(
        format!("centre of mass [{}], component axes", units.length),
        line(element.origin),
    );
    listed
}

fn provenance(found: &Found) -> Table {
    let element = found.element;
    let mut listed = table(&[("what", ""), ("value", "")]);
    let mut add = |what: &str, value: String| {
        listed
            .rows
            .push(vec![Cell::Text(what.to_owned()), Cell::Text(value)]);
    };
    add(
        "file",
        found
            .path
            .file_name()
            .unwrap_or_default()
            .to_string_lossy()
            .into_owned(),
    );
    add("written by", element.provenance.generator.clone());
    for input in &element.provenance.inputs {
        add(
            &input.role,
            format!("{}, SHA-256 {}", input.file_name, input.sha256),
        );
    }
    for (what, value) in plain_words(&element.provenance.options) {
        add(&format!("option {what}"), value);
    }
    listed
}
