//! `reduce verify --component`: a superelement against the component that it was made from.
//!
//! The inputs' digests, mass properties, interfaces and rows; then every identity on the stored shapes with K and M, interface
//! matrices, invariants and the eigenvalue count. Without complete nodal fields the component is reduced anew and the
//! results compared.

use dcb_formats::component::Component;
use dcb_formats::superelement::{FrameKind, Residual};
use dcb_formats::{RecoveryBasis, Superelement};
use dcb_sparse::block_algebra::largest_entry;
use faer::Mat;

use super::alone::is_selection;
use super::fields::check_fields;
use super::findings::{AGREEMENT, Findings, SHAPE_AGREEMENT};
use super::interfaces::reported_reduction;
use super::layout::{check_mass_properties, has_same_layout};
use super::moments::check_moments;
use super::stored_shapes::check_stored_shapes;
use crate::error::Error;
use crate::model::condensation::Model;
use crate::model::localization::Localization;
use crate::model::rigid_body::{MassProperties, RigidBodyModes};
use crate::pipeline::diagnosis::Support;
use crate::pipeline::free_body::FreeBody;
use crate::{Reduction, reduce};

/// Checks everything that the component determines.
///
/// # Errors
/// If the component can't be reduced.
pub fn check(
    element: &Superelement,
    recovery: Option<&RecoveryBasis>,
    component: &Component,
    findings: &mut Findings,
) -> Result<(), Error> {
    check_sources(element, component, findings);
    check_internal_rows(element, component, findings);
    if is_selection(element) && element.dimension != component.dimension() {
        findings.note("it is what moves in a plane of a spatial superelement: it isn't compared with the component");
        return Ok(());
    }
    let same_kind = element.dimension == component.dimension() && element.units == component.units;
    findings.require(
        "dimension and units",
        same_kind,
        if same_kind {
            "the same"
        } else {
            "the component has others"
        },
    );
    if !same_kind {
        return Ok(());
    }
    let properties = MassProperties::of(component)?;
    check_mass_properties(element, component, &properties, findings);
    if is_selection(element) {
        findings.note("it was taken out of a larger superelement: its rows and modes aren't compared with the component");
        return Ok(());
    }
    let model = Model::of(component)?;
    let localization = Localization::of(component, &model)?;
    if !has_same_layout(
        element,
        component,
        &localization,
        properties.centre,
        findings,
    ) {
        return Ok(());
    }
    match recovery {
        Some(basis) if basis.dofs.len() == component.dofs.len() => {
            let rigid = RigidBodyModes::of(component, &model, &properties)?;
            let body = FreeBody {
                component,
                properties,
                model,
                localization,
                rigid,
                support: Support::Free,
                mass_part: None,
            };
            return check_fields(element, basis, body, findings);
        }
        Some(basis) => findings.note(&format!(
            "nodal fields are stored for {} rows of {}{}: the component was reduced anew",
            basis.dofs.len(),
            component.dofs.len(),
            match component.dofs.internal_count() {
                0 => String::new(),
                internal => format!(", of which {internal} are internal"),
            }
        )),
        None => findings.note("no nodal fields are stored: the component was reduced anew"),
    }
    check_by_reduction(element, recovery, component, findings)
}

fn check_sources(element: &Superelement, component: &Component, findings: &mut Findings) {
    for source in &component.sources {
        let recorded = element
            .provenance
            .inputs
            .iter()
            .find(|input| input.role == source.role);
        let same = recorded.is_some_and(|input| input.sha256 == source.sha256);
        let found = match recorded {
            None => "was not an input of this superelement".to_owned(),
            Some(_) if same => "same bytes".to_owned(),
            Some(input) => format!("{} had other contents then", input.file_name),
        };
        findings.require(
            &format!("{} ({})", source.role, source.file_name),
            same,
            &found,
        );
    }
}

/// As many rows belong to no node as the file says, where it says so.
fn check_internal_rows(element: &Superelement, component: &Component, findings: &mut Findings) {
    let found = component.dofs.internal_count();
    if let Some(derivation) = &element.derivation
        && (found, derivation.internal_rows) != (0, 0)
    {
        findings.require(
            "/derivation/internal_rows",
            derivation.internal_rows == found,
            &format!("{}, the component has {found}", derivation.internal_rows),
        );
    }
}

/// The reduction that gives as many modes and columns.
fn same_reduction(element: &Superelement) -> Reduction {
    let is_loose = element.modes.eigenvalues.first() == Some(&0.0);
    Reduction {
        interface_modes: reported_reduction(element).map(|it| it.wanted).into(),
        estimate: element.moments.is_none().into(),
        grounding: (element.frame_kind == FrameKind::Given).into(),
        loose_pieces: is_loose.into(),
        ..Reduction::lowest(element.mode_count())
    }
}

/// The component reduced again with the same number of modes.
fn check_by_reduction(
    element: &Superelement,
    recovery: Option<&RecoveryBasis>,
    component: &Component,
    findings: &mut Findings,
) -> Result<(), Error> {
    let options = same_reduction(element);
    let reduced = reduce(component, &options, &mut ())?;
    let again = &reduced.superelement;
    let same = again.mode_count() == element.mode_count() && again.rows.len() == element.rows.len();
    findings.require(
        "number of modes and rows",
        same,
        &format!(
            "{} and {}, recomputed {} and {}",
            element.mode_count(),
            element.rows.len(),
            again.mode_count(),
            again.rows.len()
        ),
    );
    if !same {
        return Ok(());
    }
    let eigenvalues = element
        .modes
        .eigenvalues
        .iter()
        .zip(&again.modes.eigenvalues);
    let worst = eigenvalues
        .map(|(a, b)| (a - b).abs() / b.abs().max(f64::MIN_POSITIVE))
        .fold(0.0, f64::max);
    findings.check("eigenvalues", worst, AGREEMENT);
    if let (Some(stored), Some(computed), None) =
        (&element.moments, &again.moments, &element.enrichment)
    {
        check_moments(element, stored, computed, true, findings);
    }
    // The sum over modes is the same whatever the signs, and the axes of a multiple root.
    let seen =
        |of: &Superelement| &of.modes.interface_shapes * of.modes.interface_shapes.transpose();
    let (stored, computed) = (seen(element), seen(again));
    let scaled = Mat::from_fn(stored.nrows(), stored.ncols(), |i, j| {
        let unit = (computed[(i, i)] * computed[(j, j)])
            .sqrt()
            .max(f64::MIN_POSITIVE);
        (stored[(i, j)] - computed[(i, j)]) / unit
    });
    findings.check(
        "L_b Φ Φᵀ L_bᵀ",
        largest_entry(scaled.as_ref()),
        SHAPE_AGREEMENT,
    );
    check_residual(&element.residual, &again.residual, findings);
    if let Some(basis) = recovery {
        check_stored_shapes(basis, &reduced, findings);
    }
    Ok(())
}

fn check_residual(stored: &Residual, again: &Residual, findings: &mut Findings) {
    let mass = |i: usize| again.mass_diagonal0[i].sqrt();
    let largest = largest_entry(again.flexibility.as_ref()).max(f64::MIN_POSITIVE);
    let of_mass = |i: usize, j: usize| (mass(i) * mass(j)).max(f64::MIN_POSITIVE);
    let of_flexibility = |_: usize, _: usize| largest;
    let mut check = |what: &str, x: &Mat<f64>, y: &Mat<f64>, unit: &dyn Fn(usize, usize) -> f64| {
        let scaled = Mat::from_fn(x.nrows(), x.ncols(), |i, j| {
            (x[(i, j)] - y[(i, j)]) / unit(i, j)
        });
        findings.check(what, largest_entry(scaled.as_ref()), AGREEMENT);
    };
    check("M_res", &stored.mass, &again.mass, &of_mass);
    check(
        "F_res",
        &stored.flexibility,
        &again.flexibility,
        &of_flexibility,
    );
}
