//! Puts the results of the stages together as a superelement, positions and all in the body frame.

use dcb_formats::component::Damping;
use dcb_formats::mesh::Direction;
use dcb_formats::superelement::{
    BoundaryRow, Derivation, FrameKind, InterfaceDirections, InterfaceFrame, Modes, Provenance,
    Residual, Superelement,
};

use crate::model::frame::offset;
use crate::pipeline::Reduced;
use crate::pipeline::basis::Basis;
use crate::pipeline::diagnosis::Support;
use crate::pipeline::effort::Work;
use crate::pipeline::free_body::FreeBody;
use crate::pipeline::projection::Projection;
use crate::pipeline::row_shapes::{RowShapes, WholeReduction};
use crate::quality::Quality;
use dcb_superelement::MASS_TOLERANCE;

/// The superelement, its shapes and its report from the results of all stages.
pub(crate) fn assembled(
    body: FreeBody<'_>,
    basis: Basis,
    projection: Projection,
    quality: Quality,
    work: Work,
    warnings: Vec<String>,
) -> WholeReduction {
    let component = body.component;
    let (modes, residual) = (basis.modes, basis.residual);
    let (damping, residual_damping) = damping_ratios(
        &component.damping,
        &modes.eigenvalues,
        &residual.sigma_squared,
    );
    let superelement = Superelement {
        name: component.name.clone(),
        dimension: component.dimension(),
        units: component.units.clone(),
        origin: body.properties.centre,
        frame_kind: match body.support {
            Support::Free => FrameKind::MeanAxis,
            Support::Grounded => FrameKind::Given,
        },
        interfaces: interfaces(&body),
        rows: rows(&body),
        modes: Modes {
            eigenvalues: modes.eigenvalues,
            damping,
            residual_damping,
            interface_shapes: body.localization.apply(modes.shapes.as_ref()),
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
        inertia: projection.inertia,
        stiffening: projection.stiffening,
        enrichment: projection.enrichment,
        moments: basis.moments,
        loads: projection.loads,
        stresses: projection.stresses,
        derivation: Some(derivation(&quality, component.dofs.internal_count())),
        provenance: Provenance {
            generator: format!("dcb-reducer {}", env!("CARGO_PKG_VERSION")),
            inputs: component.sources.clone(),
            options: serde_json::Value::Null,
            quality: serde_json::to_value(&quality).unwrap_or_default(),
            warnings,
        },
    };
    let shapes = RowShapes {
        modes: projection.modes.unwrap_or(modes.shapes),
        residual: projection.residual.unwrap_or(residual.shapes),
        enrichment: projection.further,
    };
    let (recovery, rows) = shapes.fields(&component.dofs);
    let reduced = Reduced {
        superelement,
        recovery,
        quality,
        work,
    };
    WholeReduction::new(reduced, rows)
}

/// The part of the report that other programs need.
fn derivation(quality: &Quality, internal_rows: usize) -> Derivation {
    let reduction = quality.interface_reduction.as_ref();
    let reduction = reduction.filter(|of| of.leaves_out());
    let further = quality.enrichment.as_ref();
    Derivation {
        coupling_source: quality.couplings.unwrap_or_default(),
        interface_directions: reduction.map(|of| InterfaceDirections {
            kept: of.kept,
            available: of.available,
        }),
        left_out_columns: further.map_or_else(Vec::new, |of| of.left_out.clone()),
        internal_rows,
        selections: Vec::new(),
    }
}

fn interfaces(body: &FreeBody<'_>) -> Vec<InterfaceFrame> {
    let placed = body.localization.interfaces.iter();
    placed
        .map(|placed| InterfaceFrame {
            name: placed.name.clone(),
            kind: placed.kind,
            role: placed.role,
            position: offset(placed.position, body.properties.centre),
            orientation: placed.orientation,
        })
        .collect()
}

fn rows(body: &FreeBody<'_>) -> Vec<BoundaryRow> {
    let index = |direction: Direction| direction.index() as i64;
    let rows = body.localization.rows.iter();
    rows.map(|row| BoundaryRow {
        interface: row.interface,
        direction: row.direction.map_or(-1, index),
        node: row.node.map_or(-1, i64::from),
        position: offset(row.position, body.properties.centre),
    })
    .collect()
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
