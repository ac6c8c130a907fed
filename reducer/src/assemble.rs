//! Puts the results of the stages together as a superelement, positions and all in the body frame.

use dcb_formats::component::{Component, Damping};
use dcb_formats::superelement::{
    BoundaryRow, Enrichment, FrameKind, Inertia, InterfaceFrame, Modes, Moments, PartLoad,
    Provenance, RecoveryBasis, Residual, Stiffening, Superelement,
};
use faer::Mat;

use crate::Reduced;
use crate::cell_coupling::cell_warning;
use crate::diagnosis::Support;
use crate::frame::offset;
use crate::free_modes::FreeModes;
use crate::localization::Localization;
use crate::plausibility::unit_warnings;
use crate::quality::Quality;
use crate::residual::ResidualFlexibility;
use crate::residual_filter::MASS_TOLERANCE;
use crate::rigid_body::MassProperties;
use crate::work::Work;

/// A mass matrix whose directions disagree by more than this, relatively, does not move as a rigid body.
const MASS_DEFECT: f64 = 1e-6;

/// Results of the stages.
pub struct Parts<'a> {
    /// The component.
    pub component: &'a Component,
    /// Mass properties.
    pub properties: MassProperties,
    /// L_b.
    pub localization: Localization,
    /// Modes.
    pub modes: FreeModes,
    /// Attachments.
    pub residual: ResidualFlexibility,
    /// Further columns over all dofs of the component, (n_e, n_x).
    pub further_fields: Option<Mat<f64>>,
    /// Invariants.
    pub inertia: Inertia,
    /// Geometric stiffness.
    pub stiffening: Stiffening,
    /// Further columns as the interfaces see them.
    pub enrichment: Option<Enrichment>,
    /// What the modes leave out.
    pub moments: Option<Moments>,
    /// Loads on the inside.
    pub loads: Vec<PartLoad>,
    /// Free or held.
    pub support: Support,
}

impl Parts<'_> {
    /// The superelement, its nodal shapes and its report; `expanded` are modes and attachments over all dofs of the component,
    /// where these are not the model's.
    pub fn into_reduced(
        self,
        expanded: (Option<Mat<f64>>, Option<Mat<f64>>),
        quality: Quality,
        work: Work,
        warnings: Vec<String>,
    ) -> Reduced {
        let Self {
            component,
            properties,
            localization,
            modes,
            residual,
            further_fields,
            inertia,
            stiffening,
            enrichment,
            moments,
            loads,
            support,
        } = self;
        let body = |position: [f64; 3]| offset(position, properties.centre);
        let interfaces = localization
            .interfaces
            .iter()
            .map(|placed| InterfaceFrame {
                name: placed.name.clone(),
                kind: placed.kind,
                role: placed.role,
                position: body(placed.position),
                orientation: placed.orientation,
            })
            .collect();
        let rows = localization
            .rows
            .iter()
            .map(|row| BoundaryRow {
                interface: row.interface,
                direction: row
                    .direction
                    .map_or(-1, |direction| direction.index() as i64),
                node: row.node.map_or(-1, i64::from),
                position: body(row.position),
            })
            .collect();
        let interface_shapes = localization.apply(modes.shapes.as_ref());
        let (damping, residual_damping) = damping_ratios(
            &component.damping,
            &modes.eigenvalues,
            &residual.sigma_squared,
        );
        let superelement = Superelement {
            name: component.name.clone(),
            dimension: component.dimension(),
            units: component.units.clone(),
            origin: properties.centre,
            frame_kind: match support {
                Support::Free => FrameKind::MeanAxis,
                Support::Grounded => FrameKind::Given,
            },
            interfaces,
            rows,
            modes: Modes {
                eigenvalues: modes.eigenvalues,
                damping,
                residual_damping,
                interface_shapes,
                first_omitted_eigenvalue: modes.first_omitted,
            },
            residual: Residual {
                flexibility: residual.flexibility,
                mass: residual.mass,
                mass_diagonal0: residual.mass_diagonal0,
                transform: residual.transform,
                sigma_squared: residual.sigma_squared,
                tolerance: MASS_TOLERANCE,
                output_shapes: residual.output_shapes,
            },
            inertia,
            stiffening,
            enrichment,
            moments,
            loads,
            provenance: Provenance {
                generator: format!("dcb-reducer {}", env!("CARGO_PKG_VERSION")),
                inputs: component.sources.clone(),
                options: serde_json::Value::Null,
                quality: serde_json::to_value(&quality).unwrap_or_default(),
                warnings,
            },
        };
        let recovery = RecoveryBasis {
            dofs: component.dofs.dofs().to_vec(),
            modes: expanded.0.unwrap_or(modes.shapes),
            residual: expanded.1.unwrap_or(residual.shapes),
            enrichment: further_fields,
        };
        Reduced {
            superelement,
            recovery,
            quality,
            work,
        }
    }
}

/// Ratios to critical of the modes, and of the attachments (Rayleigh: at the lowest attachment frequency).
fn damping_ratios(
    damping: &Damping,
    eigenvalues: &[f64],
    sigma_squared: &[f64],
) -> (Vec<f64>, f64) {
    match damping {
        Damping::None => (vec![0.0; eigenvalues.len()], 0.0),
        Damping::Uniform(ratio) => (vec![*ratio; eigenvalues.len()], *ratio),
        Damping::PerMode(ratios) => {
            let last = ratios.last().copied().unwrap_or(0.0);
            (
                (0..eigenvalues.len())
                    .map(|i| ratios.get(i).copied().unwrap_or(last))
                    .collect(),
                last,
            )
        }
        Damping::Rayleigh { alpha, beta } => {
            // C = α M + β K gives 2 ζ ω = α + β ω².
            let ratio = |squared: f64| {
                if squared > 0.0 {
                    0.5 * (alpha / squared.sqrt() + beta * squared.sqrt())
                } else {
                    0.0
                }
            };
            let attachments = sigma_squared.first().map_or(0.0, |squared| ratio(*squared));
            (
                eigenvalues.iter().map(|squared| ratio(*squared)).collect(),
                attachments,
            )
        }
    }
}

/// What the user should be told, most important first.
pub fn warnings(
    component: &Component,
    properties: &MassProperties,
    support: Support,
    modes: &FreeModes,
    quality: &Quality,
) -> Vec<String> {
    let mut warnings = Vec::new();
    if support == Support::Grounded {
        warnings.push("the part is held, so its modes are not free-free and the frame is not on mean axes (frame kind `given`)".into());
    }
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
    if modes.added_for_cluster > 0 {
        warnings.push(format!(
            "{} mode(s) were added so that a multiple root is not cut: {} kept",
            modes.added_for_cluster,
            modes.count()
        ));
    }
    if component.dofs.has_rotations() && component.component_masses.is_none() {
        warnings.push("nodes have rotations: L3 (and I2) from the mass matrix alone are approximate; give the component masses (part.mass.xx.mtx …) for exact ones".into());
    }
    let incomplete = crate::invariants::nodes_with_missing_translations(component);
    if incomplete > 0 {
        warnings.push(format!(
            "{incomplete} node(s) lack a translation: L3 and I2 take it as zero"
        ));
    }
    for row in &quality.dependent_rows {
        warnings.push(match row.depends_on.is_empty() {
            true => format!("row {} sees no elastic motion; readers drop it", row.row),
            false => format!(
                "row {} is a combination of {}; readers keep one of them",
                row.row,
                row.depends_on.join(", ")
            ),
        });
    }
    if quality.static_directions > 0 {
        warnings.push(format!(
            "{} attachment direction(s) have flexibility but hardly any mass of their own: kept statically",
            quality.static_directions
        ));
    }
    for name in quality
        .enrichment
        .iter()
        .flat_map(|further| &further.left_out)
    {
        warnings.push(format!(
            "the response to {name} has nothing beyond the kept modes and rigid motions: no column"
        ));
    }
    warnings.extend(cell_warning(component));
    warnings.extend(component.notes.iter().cloned());
    warnings
}
