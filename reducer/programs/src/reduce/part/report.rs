//! Output of `reduce PART.mtx`.

use std::fmt::Write as _;
use std::path::Path;

use dcb_formats::Superelement;
use dcb_formats::units::{hertz, hertz_unit};

use crate::program::Detail;
use crate::reduce::part::timing::StageTime;
use crate::reduce::superelement::error_report;
use crate::reduce::superelement::inspect::{frequency_table, interface_table, mass_lines};
use dcb_reducer::Proof;
use dcb_reducer::quality::Quality;
use dcb_reducer::quality::lines::quality_lines;
use dcb_reducer::scientific::scientific;

/// Output of a reduction.
pub fn summary(
    element: &Superelement,
    quality: &Quality,
    n_e: usize,
    target: &Path,
    stages: &[StageTime],
    detail: Detail,
) -> String {
    let mut text = String::new();
    let _ = writeln!(
        text,
        "{}: {n_e} degrees of freedom{} reduced to {} modes and {} attachment rows (rank {}){}",
        element.name,
        match internal_rows(element) {
            0 => String::new(),
            count => format!(", {count} of them internal rows,"),
        },
        element.mode_count(),
        element.boundary_row_count(),
        quality.residual_rank,
        further_columns(element),
    );
    text += &verdict(element, Some(quality));
    let _ = writeln!(text, "  {}", checks(quality));
    if detail == Detail::Tables {
        text += &mass_lines(element);
        text += &frequency_table(element, Some(quality), usize::MAX);
        text += &interface_table(element);
        text += &quality_lines(quality, &element.units.time);
        text += &stage_lines(stages);
    }
    let _ = writeln!(text, "wrote {}", target.display());
    text
}

/// Mass, band and accuracy of a superelement, a line each. What was made for a scene is as accurate as it is there.
pub fn verdict(element: &Superelement, quality: Option<&Quality>) -> String {
    let units = &element.units;
    let mut text = format!(
        "  mass {} {}; {}\n",
        scientific(element.inertia.mass, 5),
        units.mass,
        band(element)
    );
    if element.interfaces.is_empty() {
        text += "  no interface: nothing can be attached\n";
    }
    if let Some(accuracy) = accuracy(element, quality) {
        text += &format!("  {accuracy}\n");
    }
    if let Some(scene) = quality.and_then(|quality| quality.scene.as_ref()) {
        text += &format!("  {}\n", scene.kept());
    }
    text
}

/// How far responses may be off; `None` where that isn't known.
fn accuracy(element: &Superelement, quality: Option<&Quality>) -> Option<String> {
    if let Some(scene) = quality.and_then(|quality| quality.scene.as_ref()) {
        return scene.verdict();
    }
    let interface_modes = quality.and_then(|quality| quality.interface_reduction.as_ref());
    let is_whole = !element.modes.first_omitted_eigenvalue.is_finite()
        && !interface_modes.is_some_and(|reduction| reduction.leaves_out());
    if is_whole && element.mode_count() > 0 {
        return Some("every mode of the matrices is kept: the reduction adds no error".into());
    }
    // A file without moments has no bounds.
    error_report::accuracy(element)
}

fn band(element: &Superelement) -> String {
    let time = &element.units.time;
    let unit = hertz_unit(time);
    let omitted = element.modes.first_omitted_eigenvalue;
    let left_out = match omitted.is_finite() {
        true => format!(", the first left out at {:.6} {unit}", hertz(omitted, time)),
        false => ", none left out".to_owned(),
    };
    match element.modes.eigenvalues.as_slice() {
        [] => format!("no mode is kept{left_out}"),
        [one] => format!("one mode at {:.6} {unit}{left_out}", hertz(*one, time)),
        [first, .., last] => format!(
            "modes from {:.6} to {:.6} {unit}{left_out}",
            hertz(*first, time),
            hertz(*last, time)
        ),
    }
}

/// That the checks hold: a broken limit ends before.
fn checks(quality: &Quality) -> String {
    let largest = quality.mode_residuals.iter().copied().fold(0.0, f64::max);
    let count = quality.mode_count;
    let complete = match count.limit {
        Some(_) if count.counted == count.found => match count.proof {
            Proof::Inertia => "no mode is missed (counted)",
            Proof::RandomStart => "no mode is missed (proven)",
        },
        Some(_) => "the eigenvalue count is in the report",
        None => "there was nothing to count",
    };
    format!(
        "all checks hold: {complete}, largest mode residual {} (-v lists modes, interfaces and checks)",
        scientific(largest, 2)
    )
}

/// Rows of the component that belong to no node.
pub fn internal_rows(element: &Superelement) -> usize {
    element
        .derivation
        .as_ref()
        .map_or(0, |derivation| derivation.internal_rows)
}

/// Times and memory.
pub fn stage_lines(stages: &[StageTime]) -> String {
    let mut text = String::from("stages, with the peak memory so far\n");
    for stage in stages {
        let memory = stage
            .peak_megabytes
            .map_or(String::new(), |mb| format!("  {mb:8.0} MB"));
        let _ = writeln!(
            text,
            "  {:<12} {:9.3} s{memory}",
            stage.stage, stage.seconds
        );
    }
    text
}

/// Names of the columns beside modes and attachments; empty without any.
pub fn further_columns(element: &Superelement) -> String {
    let mut text = String::new();
    if let Some(enrichment) = &element.enrichment {
        let count = enrichment.interface_shapes.ncols();
        let names = enrichment.names.join(", ");
        let _ = write!(text, ", {count} further columns ({names})");
    }
    let stiffening = &element.stiffening;
    if !(stiffening.centrifugal.is_empty() && stiffening.interface.is_empty()) {
        text += ", geometric stiffening";
    }
    text
}
