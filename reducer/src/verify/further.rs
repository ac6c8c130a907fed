//! Contents of a superelement beside modes and attachments, against the component: further columns, geometric stiffening, named loads,
//! stress fields.

use dcb_formats::Superelement;
use dcb_formats::superelement::{PartLoad, StressField};
use dcb_sparse::block_algebra::largest_entry;
use faer::{Mat, MatRef};

use super::findings::{AGREEMENT, Findings};
use crate::attachments::columns::residual_limit;
use crate::attachments::enrichment::{FurtherColumns, Reducing};
use crate::error::Error;
use crate::inertia::part_loads::part_loads;
use crate::inertia::stiffening::stiffening;
use crate::model::stresses::stress_fields;
use crate::quality::ORTHOGONALITY_LIMIT;

/// Further columns: that they are the responses that their names say, and the reduced matrices with them.
///
/// # Errors
/// If a load that a column is named after isn't there.
pub fn check_further(
    element: &Superelement,
    fields: Option<&Mat<f64>>,
    of: &Reducing<'_>,
    findings: &mut Findings,
) -> Result<(), Error> {
    let Some(stored) = &element.enrichment else {
        return Ok(());
    };
    let Some(fields) = fields else {
        findings.note("the further columns have no nodal fields: they were not checked");
        return Ok(());
    };
    let shapes = of.model.contract(fields.as_ref());
    let Some(found) = FurtherColumns::recognised(&stored.names, shapes, of)? else {
        findings.note("the further columns have names that this program doesn't know: their forces were not checked");
        return Ok(());
    };
    findings.check(
        "further columns answer to their loads",
        found.residual,
        residual_limit(found.residual_rounding),
    );
    findings.check("Φᵀ M X", found.mass_orthogonality, ORTHOGONALITY_LIMIT);
    findings.check("Φᵀ K X", found.stiffness_orthogonality, ORTHOGONALITY_LIMIT);
    let computed = found.stored(of.model, of.localization, of.modes, of.residual);
    for (what, a, b) in [
        (
            "L_b X",
            &stored.interface_shapes,
            &computed.interface_shapes,
        ),
        ("reduced mass", &stored.reduced_mass, &computed.reduced_mass),
        (
            "reduced stiffness",
            &stored.reduced_stiffness,
            &computed.reduced_stiffness,
        ),
    ] {
        let size = largest_entry(b.as_ref()).max(f64::MIN_POSITIVE);
        findings.check(what, largest_entry((a - b).as_ref()) / size, AGREEMENT);
    }
    Ok(())
}

/// Geometric stiffness against a projection of the component's.
pub fn check_stiffening(
    element: &Superelement,
    basis: &[MatRef<'_, f64>],
    of: &Reducing<'_>,
    findings: &mut Findings,
) {
    let computed = stiffening(of.component, of.localization, basis);
    let stored = &element.stiffening;
    for (what, a, b) in [
        (
            "centrifugal stiffening",
            &stored.centrifugal,
            &computed.centrifugal,
        ),
        (
            "interface stiffening",
            &stored.interface,
            &computed.interface,
        ),
    ] {
        if a.is_empty() && b.is_empty() {
            continue;
        }
        findings.require(
            &format!("{what}: number of matrices"),
            a.len() == b.len(),
            &format!("{}, and {} from the component", a.len(), b.len()),
        );
        let largest = |layers: &[Mat<f64>]| {
            let sizes = layers.iter().map(|layer| largest_entry(layer.as_ref()));
            sizes.fold(f64::MIN_POSITIVE, f64::max)
        };
        let differences = a
            .iter()
            .zip(b)
            .map(|(a, b)| largest_entry((a - b).as_ref()));
        let difference = differences.fold(0.0, f64::max);
        findings.check(what, difference / largest(b), AGREEMENT);
    }
}

/// Named loads against those of the component.
pub fn check_loads(
    element: &Superelement,
    basis: &[MatRef<'_, f64>],
    of: &Reducing<'_>,
    findings: &mut Findings,
) {
    let computed = part_loads(of.component, of.properties.centre, basis);
    if element.loads.is_empty() && computed.is_empty() {
        return;
    }
    let same = element.loads.len() == computed.len();
    findings.require(
        "number of named loads",
        same,
        &format!(
            "{}, and {} of the component",
            element.loads.len(),
            computed.len()
        ),
    );
    let flat =
        |load: &PartLoad| -> Vec<f64> { [&load.force[..], &load.moment, &load.work].concat() };
    let mut worst = 0.0_f64;
    for (a, b) in element.loads.iter().zip(&computed) {
        let (a, b) = (flat(a), flat(b));
        let size = b
            .iter()
            .fold(f64::MIN_POSITIVE, |most, x| most.max(x.abs()));
        let differences = a.iter().zip(&b).map(|(a, b)| (a - b).abs() / size);
        worst = differences.fold(worst, f64::max);
    }
    findings.check("named loads", worst, AGREEMENT);
}

/// Stress fields against products of the component's rows with the basis.
pub fn check_stresses(
    element: &Superelement,
    basis: &[MatRef<'_, f64>],
    of: &Reducing<'_>,
    findings: &mut Findings,
) {
    let computed = stress_fields(of.component, of.properties.centre, basis, None);
    if element.stresses.is_empty() && computed.is_empty() {
        return;
    }
    let is_same = |a: &StressField, b: &StressField| {
        a.name == b.name && a.components == b.components && a.points.len() == b.points.len()
    };
    let pairs = || element.stresses.iter().zip(&computed);
    let same = element.stresses.len() == computed.len() && pairs().all(|(a, b)| is_same(a, b));
    findings.require(
        "stress fields are those of the component",
        same,
        &format!(
            "{}, and {} of the component",
            element.stresses.len(),
            computed.len()
        ),
    );
    if !same {
        return;
    }
    let differences = pairs().map(|(a, b)| {
        let size = largest_entry(b.shapes.as_ref()).max(f64::MIN_POSITIVE);
        largest_entry((&a.shapes - &b.shapes).as_ref()) / size
    });
    findings.check("stress fields", differences.fold(0.0, f64::max), AGREEMENT);
}
