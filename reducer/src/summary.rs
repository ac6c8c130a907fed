//! What `reduce PART.mtx` prints when it is done.

use std::fmt::Write as _;
use std::path::Path;

use crate::Reduced;
use crate::inspect::{frequency_table, interface_table, mass_lines};
use crate::quality::Quality;
use crate::scientific::scientific;
use crate::timing::StageTime;

/// All of it, with the first `listed` modes.
pub fn summary(
    reduced: &Reduced,
    n_e: usize,
    target: &Path,
    stages: &[StageTime],
    listed: usize,
) -> String {
    let element = &reduced.superelement;
    let mut text = String::new();
    let _ = writeln!(
        text,
        "{}: {n_e} dofs reduced to {} modes and {} attachment rows (rank {})",
        element.name,
        element.mode_count(),
        element.boundary_row_count(),
        reduced.quality.residual_rank,
    );
    text += &mass_lines(element);
    text += &frequency_table(element, Some(&reduced.quality), listed);
    text += &interface_table(element);
    text += &quality_lines(&reduced.quality);
    let _ = writeln!(text, "stages, with the peak memory so far");
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
    let _ = writeln!(text, "wrote {}", target.display());
    text
}

/// The quality report for people.
pub fn quality_lines(quality: &Quality) -> String {
    let largest = |values: &[f64]| values.iter().copied().fold(0.0, f64::max);
    let mut text = String::from("quality\n");
    let mut line = |what: &str, value: f64| {
        let _ = writeln!(text, "  {what:<46} {}", scientific(value, 1));
    };
    line(
        "largest mode residual |Kφ-ω²Mφ|/|Kφ|",
        largest(&quality.mode_residuals),
    );
    line(
        "  of which rounding explains up to",
        largest(&quality.mode_residual_roundings),
    );
    line(
        "rounding in ω², relative",
        largest(&quality.eigenvalue_roundings),
    );
    line("attachment residual", quality.attachment_residual);
    line(
        "Φᵀ K G_res        (Eq. 29)",
        quality.stiffness_orthogonality,
    );
    line("Φᵀ M G_res        (Eq. 30)", quality.mass_orthogonality);
    line("Φᵀ M Φ - I        (Eq. 31)", quality.mass_orthonormality);
    line("Φᵀ K Φ - Ω²       (Eq. 31)", quality.stiffness_diagonality);
    line("G_resᵀKG_res-G_res (Eq. 32)", quality.flexibility_identity);
    line("L1 Ψ              (Eq. 39)", quality.l1_norm);
    line("I3 Ψ              (Eq. 40)", quality.i3_norm);
    line("rigid motions, |K r|", largest(&quality.rigid_defects));
    line("mass matrix as a rigid body", quality.mass_defect);
    line("condition of F_res (scaled)", quality.flexibility_condition);
    let sturm = match quality.sturm.limit {
        Some(limit) => format!(
            "{} eigenvalues counted below {}, {} found",
            quality.sturm.counted,
            scientific(limit, 6),
            quality.sturm.found
        ),
        None => "no elastic motion to count".into(),
    };
    let _ = writeln!(text, "  {:<46} {sturm}", "Sturm count");
    let _ = writeln!(
        text,
        "  {:<46} {} from geometry, {} by the count",
        "motions without stiffness", quality.rigid_motions, quality.nullity
    );
    text
}
