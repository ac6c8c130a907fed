//! Tables, pictures and the page of a study.

use std::fmt::Write as _;
use std::path::Path;

use dcb_report::{Cell, Column, PARETO_FRONT, Page, Table};

use super::charts::{Cost, drawn};

use dcb_formats::output::{write_json, write_text};
use serde::Serialize;

use super::best::{Best, best_rows};
use super::errors::ResponseDeviation;
use super::record::{ComponentRow, Measure, ReferenceRecord, StoredCurves};
use super::variant::Variant;
use dcb_formats::units::hertz;
use dcb_reducer::error::Error;
use dcb_reducer::scientific::scientific;

/// All that is said of a study.
pub struct Report<'a> {
    pub(super) reference: &'a ReferenceRecord,
    pub(super) rows: &'a [ComponentRow],
    best: Vec<Best>,
    tolerance: f64,
}

/// `study.json`.
#[derive(Serialize)]
struct StudyFile<'a> {
    tolerance: f64,
    best: &'a [Best],
    front: Fronts,
    reference: &'a ReferenceRecord,
    rows: &'a [ComponentRow],
}

/// Rows of the Pareto fronts, error of the response against a cost: places among the rows, by rising cost.
#[derive(Serialize)]
struct Fronts {
    reduction_seconds: Vec<usize>,
    unknowns: Vec<usize>,
}

impl<'a> Report<'a> {
    /// Judges the rows by a wanted error.
    pub fn new(reference: &'a ReferenceRecord, rows: &'a [ComponentRow], tolerance: f64) -> Self {
        Self {
            best: best_rows(rows, tolerance),
            reference,
            rows,
            tolerance,
        }
    }

    /// Writes `study.csv`, `study.json`, `pareto.svg` and `report.html`.
    ///
    /// # Errors
    /// [`Error::File`] where a file can't be written.
    pub fn write(&self, folder: &Path) -> Result<(), Error> {
        self.table().write_csv(&folder.join("study.csv"))?;
        // Pictures are on the page, curves in the ledger; here they would be in the way of what is read.
        let reference = ReferenceRecord {
            pictures: Vec::new(),
            curves: StoredCurves::default(),
            ..self.reference.clone()
        };
        let rows: Vec<ComponentRow> = (self.rows.iter())
            .map(|row| ComponentRow {
                curves: StoredCurves::default(),
                ..row.clone()
            })
            .collect();
        let whole = StudyFile {
            tolerance: self.tolerance,
            best: &self.best,
            front: self.fronts(),
            reference: &reference,
            rows: &rows,
        };
        write_json(&folder.join("study.json"), &whole)?;
        let pareto = drawn(&self.pareto())?;
        write_text(&folder.join("pareto.svg"), &pareto)?;
        self.page(&pareto)?.write(&folder.join("report.html"))?;
        Ok(())
    }

    fn fronts(&self) -> Fronts {
        Fronts {
            reduction_seconds: self.front(Cost::Time),
            unknowns: self.front(Cost::Unknowns),
        }
    }

    fn hertz(&self, eigenvalue: f64) -> f64 {
        hertz(eigenvalue, &self.reference.time_unit)
    }

    pub(super) fn frequencies(&self) -> Vec<f64> {
        let band = self.reference.band.iter();
        band.map(|square| self.hertz(*square)).collect()
    }

    fn table(&self) -> Table {
        let column = Column::new;
        let mut columns = vec![
            column("variant", "variant", ""),
            column("modes", "modes", ""),
            column("interface_modes", "interface modes", ""),
            column("enrichment", "further columns", ""),
            column("attachments", "attachments", ""),
            column("unknowns", "unknowns", ""),
            column("reduction_time", "reduction", "s"),
            column("file_size", "file", "MB"),
        ];
        columns.extend(
            (Measure::ALL.iter()).map(|measure| column(measure.column(), measure.title(), "1")),
        );
        columns.extend([
            column("collocated_level", "collocated level", "dB"),
            column("transfer_level", "transfer level", "dB"),
            column("interface_force_level", "interface force level", "dB"),
            column("next_free_frequency_error", "next free frequency", "1"),
            column("spin_error", "response to spin", "1"),
        ]);
        for interface in &self.reference.interfaces {
            let name = format!("static_error_{interface}");
            columns.push(column(&name, &format!("static, {interface}"), "1"));
        }
        columns.extend([
            column("pareto_front_time", "Pareto front, time", ""),
            column("pareto_front_unknowns", "Pareto front, unknowns", ""),
        ]);
        let fronts = self.fronts();
        let rows = self.rows.iter().enumerate().map(|(index, row)| {
            let errors = &row.errors;
            let count = |value: usize| Cell::Count(value as u64);
            let mut cells = vec![
                Cell::Text(row.variant.name().to_owned()),
                count(row.modes),
                row.asked_interface_modes.map_or(Cell::Empty, count),
                match row.enrichment.is_empty() {
                    true => Cell::Empty,
                    false => Cell::Text(row.enrichment.to_string()),
                },
                count(row.attachments),
                count(row.unknowns),
                Cell::Number(row.reduction_seconds),
                Cell::Number(row.file_bytes as f64 / 1e6),
            ];
            cells.extend((Measure::ALL.iter()).map(|measure| Cell::maybe(row.error(*measure))));
            let level = |deviation: Option<ResponseDeviation>| {
                Cell::maybe(deviation.and_then(|deviation| deviation.level_db))
            };
            cells.extend([
                level(Some(errors.collocated)),
                level(errors.transfer),
                level(errors.interface_force),
                Cell::maybe(errors.next_free_frequency),
                Cell::maybe(self.spin_error(row)),
            ]);
            let of_interfaces = errors.static_response.iter();
            cells.extend(of_interfaces.map(|one| Cell::Number(one.error)));
            let yes = |front: &[usize]| match front.contains(&index) {
                true => Cell::Text("yes".to_owned()),
                false => Cell::Text("no".to_owned()),
            };
            cells.extend([yes(&fronts.reduction_seconds), yes(&fronts.unknowns)]);
            cells
        });
        Table {
            rows: rows.collect(),
            columns,
        }
    }

    /// Rows that don't say it have no further columns.
    fn spin_error(&self, row: &ComponentRow) -> Option<f64> {
        let by_modes = &self.reference.spin;
        row.spin_error.or_else(|| by_modes.get(row.modes).copied())
    }

    fn introduction(&self) -> Vec<String> {
        let reference = self.reference;
        let frequencies = self.frequencies();
        let ends = [frequencies.first(), frequencies.last()];
        let [first, last] = ends.map(|end| end.copied().unwrap_or(0.0));
        let [rows, independent] = reference.rows;
        let held = match reference.held_eigenvalues.len() {
            0 => "no frequency with held interfaces lies in the band".to_owned(),
            1 => "1 frequency with held interfaces lies in the band".to_owned(),
            count => format!("{count} frequencies with held interfaces lie in the band"),
        };
        vec![
            format!(
                "{}: {} dofs; forces act on {rows} rows ({independent} independent) of {}",
                reference.name,
                reference.dofs,
                reference.interfaces.join(", ")
            ),
            format!(
                "band {first:.4} to {last:.4} Hz, {} points, loss factor {}; {held}",
                frequencies.len(),
                reference.loss_factor
            ),
            format!(
                "reference: {} modes and {} terms in {:.2} s; it leaves {:.1e} of the unreduced equations",
                reference.free_eigenvalues.len(),
                reference.terms,
                reference.seconds,
                reference.residual
            ),
        ]
    }

    /// A line for each measure: which row to take.
    fn advice(&self) -> Vec<String> {
        (self.best.iter())
            .map(|best| {
                let what = match best.measures.as_slice() {
                    [measure] => measure.title(),
                    _ => "all of them",
                };
                let named = best.row.zip(best.error).map(|(row, error)| {
                    let row = &self.rows[row];
                    format!(
                        "{} ({} unknowns, reduction {:.3} s): error {}",
                        row.title(),
                        row.unknowns,
                        row.reduction_seconds,
                        scientific(error, 1)
                    )
                });
                format!("{what}: {}", named.unwrap_or_else(|| "no row".to_owned()))
            })
            .collect()
    }

    /// The rows of the fronts, a line for each cost.
    fn fronts_told(&self) -> Vec<String> {
        [
            ("error of the response against time", Cost::Time),
            ("error of the response against unknowns", Cost::Unknowns),
        ]
        .map(|(what, cost)| {
            let rows = self.front(cost).into_iter();
            let rows: Vec<String> = rows.map(|row| self.rows[row].title()).collect();
            format!("{what}: {}", rows.join("; "))
        })
        .to_vec()
    }

    /// Proposal for a component that spins; `None` where modes alone are as good as the tolerance.
    fn proposal(&self) -> Option<String> {
        let most = self.rows.iter().map(|row| row.modes).max()?;
        let lacking = *self.reference.spin.get(most)?;
        (lacking > self.tolerance).then(|| {
            format!(
                "if the part spins: {most} modes lack {} of its response to centrifugal forces; --enrich spin adds it",
                scientific(lacking, 1),
            )
        })
    }

    /// For the terminal.
    pub fn text(&self) -> String {
        let mut text = String::new();
        for line in self.introduction() {
            let _ = writeln!(text, "{line}");
        }
        let forms = self.rows.iter().map(|row| row.form().len());
        let width = forms.max().unwrap_or(0).max("variant".len());
        let _ = writeln!(
            text,
            "{:<width$} {:>6} {:>9} {:>9} {:>10} {:>8}  largest errors: held     static   collocated  transfer   forces    spin",
            "variant", "modes", "interface", "unknowns", "time [s]", "MB"
        );
        for row in self.rows {
            let interface = row.asked_interface_modes;
            let interface = interface.map_or_else(|| "all".to_owned(), |count| count.to_string());
            let _ = write!(
                text,
                "{:<width$} {:>6} {:>9} {:>9} {:>10.4} {:>8.2}                 ",
                row.form(),
                row.modes,
                if row.variant == Variant::Free {
                    "-"
                } else {
                    &interface
                },
                row.unknowns,
                row.reduction_seconds,
                row.file_bytes as f64 / 1e6
            );
            let measured = Measure::ALL.map(|measure| row.error(measure));
            for error in measured.into_iter().chain([self.spin_error(row)]) {
                let error = error.map_or_else(|| "-".to_owned(), |error| scientific(error, 1));
                let _ = write!(text, " {error:>9} ");
            }
            let _ = writeln!(text);
        }
        let _ = writeln!(text, "{PARETO_FRONT}");
        for line in self.fronts_told() {
            let _ = writeln!(text, "  {line}");
        }
        let tolerance = scientific(self.tolerance, 0);
        let _ = writeln!(text, "fewest unknowns with an error up to {tolerance}");
        for line in self.advice() {
            let _ = writeln!(text, "  {line}");
        }
        if let Some(proposal) = self.proposal() {
            let _ = writeln!(text, "{proposal}");
        }
        text
    }

    fn page(&self, pareto: &str) -> Result<Page, Error> {
        let mut page = Page::new(&format!(
            "{}: a study of its reduction",
            self.reference.name
        ));
        page.heading(&format!(
            "Which variant to take: fewest unknowns with a relative error up to {}",
            scientific(self.tolerance, 0)
        ));
        page.list(&self.advice());
        if let Some(proposal) = self.proposal() {
            page.paragraph(&proposal);
        }
        page.heading("What an error costs");
        page.paragraph(&format!(
            "{PARETO_FRONT} Point at a mark to see which variant it is."
        ));
        page.picture(
            pareto,
            "The error is the largest of the response over the band, collocated or transfer.",
        );
        let shown = self.with_curves().len();
        let same = format!(
            "{shown} of {} rows: of the Pareto front against unknowns, evenly chosen. The tables below and study.csv have all.",
            self.rows.len()
        );
        page.heading("Responses");
        for (title, chart) in self.responses() {
            let caption = format!("{title}. The unreduced part, and {same}");
            page.picture(&drawn(&[chart])?, &caption);
        }
        page.heading("Where the error is");
        page.picture(
            &drawn(&[self.errors()])?,
            &format!("All entries of the receptance together; {same} Where a row is exact there is nothing to draw."),
        );
        if !self.reference.pictures.is_empty() {
            page.heading("Free modes");
            page.paragraph("Pale places hardly move, red ones most.");
            page.pictures(&self.reference.pictures);
        }
        page.heading("All rows");
        page.list(&self.fronts_told());
        let marked: Vec<usize> = self.best.iter().filter_map(|best| best.row).collect();
        page.folded_table(
            &format!("Table of {} rows; those to take stand out", self.rows.len()),
            &self.table(),
            &marked,
        );
        page.paragraph(
            "Errors are relative, the largest of the band; rows of the interfaces are scaled by their own flexibility. An empty field: the row has no such response. \
             Further columns are static responses beside modes and attachments, as reduce --enrich makes them: krylov is the interfaces' second Krylov block, spin the \
             response to centrifugal forces, loads that to the part's named loads.",
        );
        page.heading("How it was measured");
        page.list(&self.introduction());
        Ok(page)
    }
}
