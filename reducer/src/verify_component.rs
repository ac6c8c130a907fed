//! `reduce verify --component`: a superelement against the component that it was made from.
//!
//! The inputs' digests, mass properties, interfaces and rows; then every identity on the stored shapes with K and M, interface
//! matrices, invariants and the eigenvalue count. Without complete nodal fields the component is reduced anew and the
//! results compared.

use dcb_formats::component::Component;
use dcb_formats::superelement::{FrameKind, Inertia};
use dcb_formats::{RecoveryBasis, Superelement};
use dcb_sparse::block_algebra::{largest_entry, symmetric_product};
use dcb_sparse::factorization::SymmetricFactor;
use faer::Mat;

use crate::condensation::Model;
use crate::diagnosis;
use crate::enrichment::Reducing;
use crate::error::Error;
use crate::error_estimate::PowerMoments;
use crate::free_modes::{FreeModes, residuals};
use crate::interface_reduction::InterfaceReduction;
use crate::invariants::inertia_invariants;
use crate::localization::Localization;
use crate::memory_limit::MemoryLimit;
use crate::quality::{Quality, Sturm};
use crate::residual::ResidualFlexibility;
use crate::rigid_body::{MassProperties, RigidBodyModes};
use crate::shift::{AbsoluteForces, SpectrumScale};
use crate::summary::quality_lines;
use crate::verify::{AGREEMENT, Findings, is_selection};
use crate::verify_further::{check_further, check_loads, check_stiffening};
use crate::verify_interfaces::{check_interface_reduction, reported_reduction};
use crate::verify_layout::{check_mass_properties, has_same_layout};
use crate::verify_moments::check_moments;
use crate::{
    EigenSolver, EstimateChoice, Grounding, InterfaceModes, LoosePieces, ModeSelection, Reduction,
    reduce,
};

/// Modes found twice agree only as closely as their residuals allow, a pair of close ones less.
pub const SHAPE_AGREEMENT: f64 = 1e-6;

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
            return check_fields(
                element,
                basis,
                component,
                &properties,
                &model,
                &localization,
                findings,
            );
        }
        Some(basis) => findings.note(&format!(
            "nodal fields are stored for {} dofs of {}: the component was reduced anew",
            basis.dofs.len(),
            component.dofs.len()
        )),
        None => findings.note("no nodal fields are stored: the component was reduced anew"),
    }
    check_by_reduction(element, component, findings)
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

/// Every identity on the stored shapes.
fn check_fields(
    element: &Superelement,
    basis: &RecoveryBasis,
    component: &Component,
    properties: &MassProperties,
    model: &Model,
    localization: &Localization,
    findings: &mut Findings,
) -> Result<(), Error> {
    let same_dofs = basis.dofs == component.dofs.dofs();
    findings.require(
        "dofs of the fields are those of the component",
        same_dofs,
        if same_dofs { "yes" } else { "no" },
    );
    if !same_dofs {
        return Ok(());
    }
    let geometric = RigidBodyModes::of(component, model, properties)?;
    let defects = geometric.stiffness_defects(model);
    let scale = SpectrumScale::of(model, &geometric, component.dimension(), properties.centre);
    let rigid = match element.frame_kind {
        FrameKind::MeanAxis => geometric,
        FrameKind::Given => geometric.none(),
    };
    let shapes = model.contract(basis.modes.as_ref());
    let attachments = model.contract(basis.residual.as_ref());
    let rigidity = |full: &Mat<f64>, model_columns: &Mat<f64>| {
        let expanded = model.expand(model_columns.as_ref());
        largest_entry((expanded.as_ref() - full).as_ref())
            / largest_entry(full.as_ref()).max(f64::MIN_POSITIVE)
    };
    findings.check(
        "rigid interfaces move rigidly in the fields",
        rigidity(&basis.modes, &shapes).max(rigidity(&basis.residual, &attachments)),
        AGREEMENT,
    );

    let eigenvalues = element.modes.eigenvalues.clone();
    let zero_count = eigenvalues
        .iter()
        .take_while(|value| **value == 0.0)
        .count();
    let mass_shapes = symmetric_product(&model.mass, shapes.as_ref());
    let absolute = AbsoluteForces::of(&model.stiffness, shapes.as_ref());
    let (mode_residuals, residual_roundings) = residuals(
        &model.stiffness,
        shapes.as_ref(),
        mass_shapes.as_ref(),
        &eigenvalues,
        zero_count,
        &absolute.norms,
        rigid.stiffness_precision,
    );
    let eigenvalue_roundings = absolute
        .energies
        .iter()
        .zip(&eigenvalues)
        .map(|(energy, value)| {
            if *value > 0.0 {
                rigid.stiffness_precision * energy / value
            } else {
                0.0
            }
        })
        .collect();
    let modes = FreeModes {
        shapes,
        mass_shapes,
        eigenvalues,
        residuals: mode_residuals,
        residual_roundings,
        eigenvalue_roundings,
        zero_count,
        first_omitted: element.modes.first_omitted_eigenvalue,
        iterations: 0,
        added_for_cluster: 0,
    };
    let mut factor = SymmetricFactor::analyse(&model.stiffness, &model.mass, &model.points())?;
    let further_shapes = (basis.enrichment.as_ref()).map(|shapes| model.contract(shapes.as_ref()));
    let reduction = reported_reduction(element).filter(InterfaceReduction::leaves_out);
    let mut moments = None;
    let residual = match (&reduction, &element.moments) {
        (None, None) => {
            ResidualFlexibility::from_shapes(model, localization, &rigid, &modes, attachments)?
        }
        _ => {
            let shift = scale.shift();
            let positive = match factor.factorize(&model.stiffness, &model.mass, shift) {
                Ok(positive) => positive,
                Err(why) => return Err(diagnosis::unfactorized(model, &scale, &mut factor, why)),
            };
            let whole = match &reduction {
                Some(_) => ResidualFlexibility::compute(
                    model,
                    localization,
                    &rigid,
                    &modes,
                    &positive,
                    &mut (),
                )?,
                None => ResidualFlexibility::from_shapes(
                    model,
                    localization,
                    &rigid,
                    &modes,
                    attachments.clone(),
                )?,
            };
            if element.moments.is_some() {
                let of = Reducing {
                    component,
                    properties,
                    model,
                    localization,
                    rigid: &rigid,
                    modes: &modes,
                    residual: &whole,
                };
                let further = further_shapes.as_ref().map(|shapes| shapes.as_ref());
                match PowerMoments::compute(&of, further, &positive, shift, &mut ()) {
                    Ok(computed) => moments = Some(computed),
                    Err(why) => {
                        findings.require("error estimate recomputed", false, &why.to_string());
                    }
                }
            }
            match &reduction {
                Some(report) => {
                    let expected = whole.keeping(report.wanted, model, localization, &modes)?;
                    check_interface_reduction(report, &expected, &attachments, findings);
                    expected.with_shapes(model, localization, &modes, attachments)?
                }
                None => whole,
            }
        }
    };
    let (phi, x) = (
        model.expand(modes.shapes.as_ref()),
        model.expand(residual.shapes.as_ref()),
    );
    let further = basis.enrichment.as_ref();
    let shapes = [phi.as_ref(), x.as_ref()];
    let blocks: Vec<_> = shapes
        .into_iter()
        .chain(further.map(|further| further.as_ref()))
        .collect();
    let (inertia, _) = inertia_invariants(component, properties, &blocks);
    let of = Reducing {
        component,
        properties,
        model,
        localization,
        rigid: &rigid,
        modes: &modes,
        residual: &residual,
    };
    check_further(element, further, &of, findings)?;
    check_stiffening(element, &blocks, &of, findings);
    check_loads(element, &blocks, &of, findings);
    let sturm: Sturm = crate::certificate(model, &rigid, &modes, &mut factor);
    if let (Some(stored), Some(computed)) = (&element.moments, moments) {
        let certified = sturm.counted == sturm.found;
        check_moments(
            stored,
            &computed.certified(&modes, sturm),
            certified,
            findings,
        );
    }
    let quality = Quality::of(
        model,
        properties,
        &rigid,
        &defects.per_column,
        &modes,
        &residual,
        None,
        &inertia,
        sturm,
    );
    findings.text += &quality_lines(&quality, &component.units.time);
    let broken = quality.broken_limits();
    findings.require(
        "identities recomputed with K and M",
        broken.is_empty(),
        &format!("{} broken", broken.len()),
    );
    findings.broken.extend(broken);

    let root = |matrix: &Mat<f64>, i: usize| matrix[(i, i)].abs().max(f64::MIN_POSITIVE).sqrt();
    let difference = |stored: &Mat<f64>, computed: &Mat<f64>, reference: &dyn Fn(usize) -> f64| {
        let scaled = Mat::from_fn(stored.nrows(), stored.ncols(), |i, j| {
            let unit = reference(i) * reference(j);
            if unit > 0.0 {
                (stored[(i, j)] - computed[(i, j)]) / unit
            } else {
                stored[(i, j)] - computed[(i, j)]
            }
        });
        largest_entry(scaled.as_ref())
    };
    let mass_scale = |i: usize| residual.mass_diagonal0[i].sqrt();
    let shapes_seen = localization.apply(modes.shapes.as_ref());
    let seen_defect = (&shapes_seen - &element.modes.interface_shapes).norm_max()
        / largest_entry(modes.shapes.as_ref()).max(f64::MIN_POSITIVE);
    findings.check("L_b Φ", seen_defect, AGREEMENT);
    findings.check(
        "F_res",
        difference(&element.residual.flexibility, &residual.flexibility, &|i| {
            root(&residual.flexibility0, i)
        }),
        AGREEMENT,
    );
    findings.check(
        "M_res",
        difference(&element.residual.mass, &residual.mass, &mass_scale),
        AGREEMENT,
    );
    check_invariants(
        &element.inertia,
        &inertia,
        element.mode_count(),
        &residual.mass_diagonal0,
        findings,
    );
    Ok(())
}

/// I1, L3 and I2 against their recomputation, each column divided by the size of its basis vector.
fn check_invariants(
    stored: &Inertia,
    computed: &Inertia,
    n_k: usize,
    mass_diagonal0: &[f64],
    findings: &mut Findings,
) {
    let norm = |k: usize| {
        // Further columns have unit norm with no mode kept.
        let attachment = k.checked_sub(n_k).and_then(|k| mass_diagonal0.get(k));
        attachment.map_or(1.0, |mass| mass.sqrt())
    };
    let n = computed.i1.len();
    let largest_moment = (0..3)
        .map(|a| computed.tensor[a][a])
        .fold(0.0, f64::max)
        .sqrt();
    let mut first = 0.0_f64;
    for k in (0..n).filter(|k| norm(*k) > 0.0) {
        for a in 0..3 {
            for b in 0..3 {
                first = first.max(
                    (stored.i1[k][a][b] - computed.i1[k][a][b]).abs() / (norm(k) * largest_moment),
                );
            }
        }
    }
    findings.check("I1", first, AGREEMENT);
    for (what, x, y) in [
        ("L3", &stored.l3, &computed.l3),
        ("I2", &stored.i2, &computed.i2),
    ] {
        let mut worst = 0.0_f64;
        for (x, y) in x.iter().zip(y) {
            let scaled = Mat::from_fn(n, n, |k, l| {
                let unit = norm(k) * norm(l);
                if unit > 0.0 {
                    (x[(k, l)] - y[(k, l)]) / unit
                } else {
                    0.0
                }
            });
            worst = worst.max(largest_entry(scaled.as_ref()));
        }
        findings.check(what, worst, AGREEMENT);
    }
}

/// The component reduced again with the same number of modes.
fn check_by_reduction(
    element: &Superelement,
    component: &Component,
    findings: &mut Findings,
) -> Result<(), Error> {
    let options = Reduction {
        modes: ModeSelection::Lowest(element.mode_count()),
        estimate: match element.moments {
            Some(_) => EstimateChoice::Computed,
            None => EstimateChoice::LeftOut,
        },
        interface_modes: reported_reduction(element)
            .map_or(InterfaceModes::All, |it| InterfaceModes::Softest(it.wanted)),
        enrichment: Vec::new(),
        grounding: if element.frame_kind == FrameKind::Given {
            Grounding::Allow
        } else {
            Grounding::Refuse
        },
        loose_pieces: if element.modes.eigenvalues.first() == Some(&0.0) {
            LoosePieces::Allow
        } else {
            LoosePieces::Refuse
        },
        eigen_solver: EigenSolver::BlockLanczos,
        memory: MemoryLimit::default(),
    };
    let again = reduce(component, &options, &mut ())?.superelement;
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
        check_moments(stored, computed, true, findings);
    }
    // The sum over modes is the same whatever the signs, and the axes of a multiple root.
    let seen =
        |of: &Superelement| &of.modes.interface_shapes * of.modes.interface_shapes.transpose();
    let (stored, computed) = (seen(element), seen(&again));
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
    let mass = |i: usize| again.residual.mass_diagonal0[i].sqrt();
    for (what, x, y) in [
        ("M_res", &element.residual.mass, &again.residual.mass),
        (
            "F_res",
            &element.residual.flexibility,
            &again.residual.flexibility,
        ),
    ] {
        let largest = largest_entry(y.as_ref()).max(f64::MIN_POSITIVE);
        let scaled = Mat::from_fn(x.nrows(), x.ncols(), |i, j| {
            let unit = if what == "M_res" {
                (mass(i) * mass(j)).max(f64::MIN_POSITIVE)
            } else {
                largest
            };
            (x[(i, j)] - y[(i, j)]) / unit
        });
        findings.check(what, largest_entry(scaled.as_ref()), AGREEMENT);
    }
    Ok(())
}
