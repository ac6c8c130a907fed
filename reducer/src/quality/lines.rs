//! The quality report for people.

use std::cmp::Ordering;
use std::fmt::Write as _;

use dcb_formats::units::{hertz_unit, si_factor};

use super::Quality;
use crate::attachments::interface_reduction::InterfaceReduction;
use crate::modes::certificate::{ModeCount, Proof};
use crate::scientific::scientific;

/// The quality report for people; `time` is the part's unit of it.
pub fn quality_lines(quality: &Quality, time: &str) -> String {
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
    if let Some(further) = &quality.enrichment {
        line("residual of further columns X", further.residual);
        line("Φᵀ M X", further.mass_orthogonality);
        line("Φᵀ K X", further.stiffness_orthogonality);
    }
    if let Some(reduction) = &quality.interface_reduction {
        text += &interface_lines(reduction, time);
    }
    let ModeCount {
        limit,
        counted,
        found,
        proof,
    } = quality.mode_count;
    let complete = match (limit, proof) {
        (Some(limit), Proof::Inertia) => format!(
            "{counted} eigenvalues counted below {}, {found} found (Sturm sequence check)",
            scientific(limit, 6),
        ),
        (Some(limit), Proof::RandomStart) => format!(
            "{found} eigenvalues below {}, all found: proven by the search's random start, chance of error below 1e-12",
            scientific(limit, 6),
        ),
        (None, _) => "no elastic motion to count".into(),
    };
    let _ = writeln!(text, "  {:<46} {complete}", "no mode missing");
    let _ = writeln!(
        text,
        "  {:<46} {} from geometry, {} by the count",
        "motions without stiffness", quality.rigid_motions, quality.nullity
    );
    if quality.added_modes > 0 {
        let _ = writeln!(
            text,
            "  {:<46} {}",
            "modes added, so that a multiple root is whole", quality.added_modes
        );
    }
    if quality.static_directions > 0 {
        let _ = writeln!(
            text,
            "  {:<46} {}",
            "attachment directions with hardly any mass", quality.static_directions
        );
    }
    if let Some(scene) = &quality.scene {
        text += &scene.text();
    }
    text
}

/// Contents that an interface reduction kept and lost.
fn interface_lines(reduction: &InterfaceReduction, time: &str) -> String {
    let InterfaceReduction {
        wanted,
        kept,
        available,
        ..
    } = reduction;
    let mut text = String::new();
    let mut line = |what: &str, found: &str| {
        let _ = writeln!(text, "  {what:<46} {found}");
    };
    let why = match kept.cmp(wanted) {
        Ordering::Less => format!(": all, {wanted} were asked for"),
        Ordering::Equal => String::new(),
        Ordering::Greater => format!(": {wanted} were asked for, a multiple one is not cut"),
    };
    line("interface modes", &format!("{kept} of {available}{why}"));
    if !reduction.leaves_out() {
        return text;
    }
    let number = |value: f64| scientific(value, 1);
    let row = reduction.stiffened_most.as_deref().unwrap_or("");
    line(
        "  residual flexibility lost at a row, up to",
        &number(reduction.residual_error),
    );
    line(
        "  static flexibility lost at a row, up to",
        &format!("{} at {row}", number(reduction.flexibility_error)),
    );
    line(
        "  static flexibility lost in any direction",
        &number(reduction.worst_direction_error),
    );
    line(
        "  largest scaled eigenvalue left out",
        &number(reduction.largest_left_out),
    );
    if let Some(frequency) = reduction.lowest_left_out {
        let second = si_factor(time).unwrap_or(1.0);
        let told = format!("{:.4} {}", frequency / second, hertz_unit(time));
        line("  lowest frequency left out", &told);
    }
    text
}
