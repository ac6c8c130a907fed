//! Output of `reduce PART.mtx`.

use std::fmt::Write as _;
use std::path::Path;

use dcb_formats::Superelement;

use crate::reduce::part::timing::StageTime;
use crate::reduce::superelement::inspect::{frequency_table, interface_table, mass_lines};
use dcb_reducer::quality::Quality;
use dcb_reducer::quality::lines::quality_lines;

/// All of it, with the first `listed` modes.
pub fn summary(
    element: &Superelement,
    quality: &Quality,
    n_e: usize,
    target: &Path,
    stages: &[StageTime],
    listed: usize,
) -> String {
    let mut text = String::new();
    let _ = writeln!(
        text,
        "{}: {n_e} dofs{} reduced to {} modes and {} attachment rows (rank {}){}",
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
    text += &mass_lines(element);
    text += &frequency_table(element, Some(quality), listed);
    text += &interface_table(element);
    text += &quality_lines(quality, &element.units.time);
    text += &stage_lines(stages);
    let _ = writeln!(text, "wrote {}", target.display());
    text
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
