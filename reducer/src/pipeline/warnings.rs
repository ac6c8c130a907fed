//! Warnings of a reduction that succeeded, most important first.

use crate::inertia::invariants::nodes_with_missing_translations;
use crate::inertia::stiffening::unused_rows;
use crate::mode_selection::ModeSelection;
use crate::model::cell_coupling::cell_warning;
use crate::model::plausibility::unit_warnings;
use crate::modes::free_modes::FreeModes;
use crate::pipeline::diagnosis::Support;
use crate::pipeline::free_body::FreeBody;
use crate::quality::{EnrichmentQuality, Quality};

/// A mass matrix whose directions disagree by more than this, relatively, does not move as a rigid body.
const MASS_DEFECT: f64 = 1e-6;

/// Warnings of the steps, at most one each.
#[derive(Debug, Default)]
pub(crate) struct Warnings {
    /// K has few digits, or the part a weak support.
    pub stiffness: Option<String>,
    /// The factor went to disk.
    pub memory: Option<String>,
    /// The factor isn't as accurate as it was to be.
    pub precision: Option<String>,
    /// There are fewer modes than were asked for.
    pub modes: Option<String>,
}

impl Warnings {
    /// With what follows from the results.
    pub fn with(self, body: &FreeBody<'_>, modes: &FreeModes, quality: &Quality) -> Vec<String> {
        let estimate = quality.missing_estimate.as_ref();
        let estimate = estimate.map(|why| format!("no error estimate: {why}"));
        let steps = [
            self.stiffness,
            self.memory,
            self.precision,
            self.modes,
            estimate,
        ];
        let mut warnings: Vec<String> = steps.into_iter().flatten().collect();
        if body.support == Support::Grounded {
            warnings.push("the part is held, so its modes are not free-free and the frame is not on mean axes (frame kind `given`)".into());
        }
        warnings.extend(of_body(body, modes));
        warnings.extend(of_columns(quality));
        warnings.extend(cell_warning(body.component));
        warnings.extend(body.component.notes.iter().cloned());
        warnings.extend(unused_rows(body.component, &body.localization));
        warnings
    }
}

/// Told where the mass matrix has too low a rank for as many modes as are asked for.
pub(crate) fn fewer_modes(
    body: &FreeBody<'_>,
    asked: ModeSelection,
    modes: &FreeModes,
) -> Option<String> {
    let (found, rows) = (modes.count(), body.model.len());
    let rank = found + body.rigid.count();
    match asked {
        ModeSelection::Lowest(count) if count > found && !modes.first_omitted.is_finite() => {
            (rank < rows).then(|| format!(
                "{count} modes were asked for, and there are {found}: the mass matrix has rank {rank} of {rows}, so no other motion has a finite frequency. What has flexibility and no mass stays in the residual flexibility"
            ))
        }
        _ => None,
    }
}

fn of_body(body: &FreeBody<'_>, modes: &FreeModes) -> Vec<String> {
    let (component, properties) = (body.component, &body.properties);
    let mut warnings = Vec::new();
    if modes.zero_count > 0 {
        warnings.push(format!(
            "{} mode(s) without stiffness are kept (loose pieces or mechanisms)",
            modes.zero_count
        ));
    }
    let first_elastic = modes.eigenvalues.get(modes.zero_count).copied();
    warnings.extend(unit_warnings(component, properties, first_elastic));
    if properties.defect > MASS_DEFECT {
        warnings.push(format!(
            "the mass matrix does not move as a rigid body: its directions disagree by {:.1e} of the mass",
            properties.defect
        ));
    }
    if component.dofs.has_rotations() && component.component_masses.is_none() {
        warnings.push("nodes have rotations: L3 (and I2) from the mass matrix alone are approximate; give the component masses (part.mass.xx.mtx …) for exact ones".into());
    }
    if component.dofs.internal_count() > 0 && component.component_masses.is_none() {
        warnings.push(format!(
            "{} rows are internal: L3 (and I2) from the mass matrix alone take the motion inside elements from the nodes, approximately; give the component masses (part.mass.xx.mtx …) for exact ones",
            component.dofs.internal_count()
        ));
    }
    let incomplete = nodes_with_missing_translations(component);
    if incomplete > 0 {
        warnings.push(format!(
            "{incomplete} node(s) lack a translation: L3 and I2 take it as zero"
        ));
    }
    warnings
}

fn of_columns(quality: &Quality) -> Vec<String> {
    let mut warnings = Vec::new();
    for row in &quality.dependent_rows {
        warnings.push(match row.depends_on.is_empty() {
            true => format!("row {} does not move with any deflection: nothing attached there bends the part (simulations leave it out)", row.row),
            false => format!(
                "row {} is a combination of {}: simulations keep one of them",
                row.row,
                row.depends_on.join(", ")
            ),
        });
    }
    let left_out = (quality.enrichment.iter()).flat_map(|further| &further.left_out);
    warnings.extend(left_out.map(|name| EnrichmentQuality::warning(name)));
    warnings
}
