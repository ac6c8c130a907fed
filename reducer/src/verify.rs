//! `reduce verify`: recomputes what can be recomputed, from the file alone or, given the component, everything.
//!
//! From the file: every digest, the identities of the residual transform, symmetry and sign of the matrices, the mean-axis
//! condition, nodal rows against the stored fields, and the limits of the stored quality report. From the component: the
//! inputs' digests, mass properties, every identity on the stored shapes with K and M, interface matrices, invariants and the
//! eigenvalue count. Without stored fields the component is reduced anew and the results compared.

use std::fmt::Write as _;
use std::path::Path;

use dcb_formats::component::{Component, Role};
use dcb_formats::component_files::{ComponentFiles, Overrides, read_component};
use dcb_formats::dcb::SuperelementFile;
use dcb_formats::superelement::{FrameKind, Inertia};
use dcb_formats::{RecoveryBasis, Superelement};
use faer::{Mat, MatRef};

use crate::block_algebra::{largest_entry, symmetric_eigen, symmetric_product, symmetrized};
use crate::cli_reduce::{Outcome, quality_lines};
use crate::condensation::Model;
use crate::error::Error;
use crate::factorization::SymmetricFactor;
use crate::free_modes::{FreeModes, residuals};
use crate::inspect::stored_quality;
use crate::invariants::inertia_invariants;
use crate::localization::Localization;
use crate::quality::{ORTHOGONALITY_LIMIT, Quality, Sturm};
use crate::residual::ResidualFlexibility;
use crate::residual_filter::MASS_TOLERANCE;
use crate::rigid_body::{MassProperties, RigidBodyModes};
use crate::shift::absolute_energies;
use crate::{Grounding, LoosePieces, ModeSelection, Reduction, reduce};

/// Stored and recomputed matrices may differ by this, relative to their scale.
const AGREEMENT: f64 = 1e-8;
/// The transform's identities hold to rounding over the tolerance that it was cut at.
const TRANSFORM_LIMIT: f64 = 1e-4;

/// What was checked, line by line.
struct Findings {
    text: String,
    broken: Vec<String>,
}

impl Findings {
    fn check(&mut self, what: &str, value: f64, limit: f64) {
        let holds = value <= limit;
        let mark = if holds { "ok  " } else { "FAIL" };
        let _ = writeln!(self.text, "  {mark} {what:<58} {value:.1e}  (limit {limit:.0e})");
        if !holds {
            self.broken.push(format!("{what}: {value:.1e}, above its limit {limit:.0e}"));
        }
    }

    fn require(&mut self, what: &str, holds: bool, found: &str) {
        let mark = if holds { "ok  " } else { "FAIL" };
        let _ = writeln!(self.text, "  {mark} {what:<58} {found}");
        if !holds {
            self.broken.push(format!("{what}: {found}"));
        }
    }

    fn note(&mut self, line: &str) {
        let _ = writeln!(self.text, "       {line}");
    }
}

/// Runs the command.
///
/// # Errors
/// If the file is not an intact superelement, or the component can't be read.
pub fn run(path: &Path, stiffness: Option<&Path>) -> Result<Outcome, Error> {
    let file = SuperelementFile::open(path)?;
    let mut findings = Findings { text: format!("{}\n", path.display()), broken: Vec::new() };
    let datasets = file.verify_digests()?;
    findings.require("digests of all datasets", true, &format!("{datasets} agree"));
    let element = file.superelement()?;
    let recovery = file.recovery()?;
    check_transform(&element, &mut findings)?;
    check_inertia(&element, &mut findings)?;
    if let Some(basis) = &recovery {
        findings.check("nodal rows of L_b Ψ against the stored fields", nodal_row_defect(&element, basis), AGREEMENT);
    }
    report_drops(&element, &mut findings);
    match stored_quality(&element) {
        Some(quality) => {
            let broken = quality.broken_limits();
            findings.require("limits of the stored quality report", broken.is_empty(), &format!("{} broken", broken.len()));
            findings.broken.extend(broken);
        }
        None => findings.note("no quality report of this program is stored; its limits were not checked"),
    }
    if let Some(stiffness) = stiffness {
        let files = ComponentFiles::beside(stiffness, &Overrides::default())?;
        let component = read_component(&files)?;
        check_sources(&element, &component, &mut findings);
        check_against_component(&element, recovery.as_ref(), &component, &mut findings)?;
    }
    let verdict = if findings.broken.is_empty() { "verified\n" } else { "NOT verified\n" };
    Ok(Outcome { output: findings.text + verdict, broken_limits: findings.broken })
}

fn unit_defect(matrix: MatRef<'_, f64>, diagonal: impl Fn(usize) -> f64, scale: impl Fn(usize, usize) -> f64) -> f64 {
    let defect = Mat::from_fn(matrix.nrows(), matrix.ncols(), |i, j| {
        (matrix[(i, j)] - if i == j { diagonal(i) } else { 0.0 }) / scale(i, j)
    });
    largest_entry(defect.as_ref())
}

/// T_rᵀ M_res T_r = I and T_rᵀ F_res T_r = diag(σ²); F_res and M_res positive semi-definite; the rank is the one that M_res has.
fn check_transform(element: &Superelement, findings: &mut Findings) -> Result<(), Error> {
    let failed = || Error::NotFinite { what: "the residual matrices" };
    let residual = &element.residual;
    let t = &residual.transform;
    let mass = t.transpose() * &residual.mass * t;
    let stiffness = t.transpose() * &residual.flexibility * t;
    let sigma = |i: usize| residual.sigma_squared[i];
    let largest = residual.sigma_squared.last().copied().unwrap_or(1.0).max(f64::MIN_POSITIVE);
    findings.check("T_rᵀ M_res T_r = I", unit_defect(mass.as_ref(), |_| 1.0, |_, _| 1.0), TRANSFORM_LIMIT);
    findings.check("T_rᵀ F_res T_r = diag(σ²)", unit_defect(stiffness.as_ref(), sigma, |_, _| largest), TRANSFORM_LIMIT);
    let d: Vec<f64> =
        residual.mass_diagonal0.iter().map(|m| if *m > 0.0 { 1.0 / m.sqrt() } else { 0.0 }).collect();
    let n_b = d.len();
    let scaled = |matrix: &Mat<f64>| Mat::from_fn(n_b, n_b, |i, j| d[i] * matrix[(i, j)] * d[j]);
    for (matrix, what) in [(&residual.mass, "M_res"), (&residual.flexibility, "F_res")] {
        let (values, _) = symmetric_eigen(symmetrized(scaled(matrix).as_ref()).as_ref()).ok_or_else(failed)?;
        let largest = values.last().copied().unwrap_or(0.0).max(f64::MIN_POSITIVE);
        let negative = values.first().map_or(0.0, |smallest| (-smallest / largest).max(0.0));
        findings.check(&format!("{what} is positive semi-definite (negative part)"), negative, ORTHOGONALITY_LIMIT);
    }
    let seen = &element.modes.interface_shapes;
    let attached = |i: usize| element.interfaces[element.rows[i].interface].role == Role::Attachment;
    let mass0 = Mat::from_fn(n_b, n_b, |i, j| {
        let modal: f64 = (0..element.mode_count())
            .filter(|k| element.modes.eigenvalues[*k] > 0.0 && attached(i) && attached(j))
            .map(|k| seen[(i, k)] * seen[(j, k)] / element.modes.eigenvalues[k].powi(2))
            .sum();
        residual.mass[(i, j)] + modal
    });
    let diagonal_defect = (0..n_b)
        .map(|i| (mass0[(i, i)] - residual.mass_diagonal0[i]).abs() * d[i] * d[i])
        .fold(0.0, f64::max);
    findings.check("diag(M_res) with no mode kept", diagonal_defect, AGREEMENT);
    let (reference, _) = symmetric_eigen(symmetrized(scaled(&mass0).as_ref()).as_ref()).ok_or_else(failed)?;
    let (values, _) = symmetric_eigen(symmetrized(scaled(&residual.mass).as_ref()).as_ref()).ok_or_else(failed)?;
    let limit = MASS_TOLERANCE * reference.last().copied().unwrap_or(0.0);
    let rank = values.iter().filter(|value| **value > limit).count();
    findings.require("rank of the residual transform", rank == t.ncols(), &format!("{} stored, {rank} found", t.ncols()));
    Ok(())
}

/// Mean axes, antisymmetry of L3, a positive inertia tensor, and second-order terms with the trace they must have.
fn check_inertia(element: &Superelement, findings: &mut Findings) -> Result<(), Error> {
    let inertia = &element.inertia;
    if element.frame_kind == FrameKind::MeanAxis {
        let norms: Vec<f64> = std::iter::repeat_n(1.0, element.mode_count())
            .chain(element.residual.mass_diagonal0.iter().map(|m| m.sqrt()))
            .chain(std::iter::repeat(1.0))
            .take(element.basis_count())
            .collect();
        let properties = MassProperties {
            mass: inertia.mass,
            centre: element.origin,
            tensor: inertia.tensor,
            defect: 0.0,
        };
        let (l1, i3) = crate::quality::mean_axis_defects(&properties, inertia, &norms);
        findings.check("L1 Ψ = 0 (Eq. 39)", l1, ORTHOGONALITY_LIMIT);
        findings.check("I3 Ψ = 0 (Eq. 40)", i3, ORTHOGONALITY_LIMIT);
    }
    let antisymmetry = inertia
        .l3
        .iter()
        .map(|l3| {
            let sum = l3 + l3.transpose();
            largest_entry(sum.as_ref()) / largest_entry(l3.as_ref()).max(f64::MIN_POSITIVE)
        })
        .fold(0.0, f64::max);
    findings.check("L3 is antisymmetric", antisymmetry, ORTHOGONALITY_LIMIT);
    let tensor = Mat::from_fn(3, 3, |i, j| inertia.tensor[i][j]);
    let (moments, _) =
        symmetric_eigen(symmetrized(tensor.as_ref()).as_ref()).ok_or(Error::NotFinite { what: "the inertia tensor" })?;
    let largest = moments.last().copied().unwrap_or(0.0);
    // No principal moment of a body exceeds the sum of the other two; a planar part stores only one.
    let possible = inertia.l3.len() == 1 || largest <= (1.0 + AGREEMENT) * (moments[0] + moments[1]);
    findings.require(
        "the inertia tensor is that of a body",
        largest > 0.0 && moments[0] >= -AGREEMENT * largest && possible,
        &format!("principal moments {:.6e} {:.6e} {:.6e}", moments[0], moments[1], moments[2]),
    );
    Ok(())
}

/// Rows of `nodes` interfaces are entries of the fields.
fn nodal_row_defect(element: &Superelement, basis: &RecoveryBasis) -> f64 {
    let position: std::collections::HashMap<(i64, i64), usize> =
        basis.dofs.iter().enumerate().map(|(i, dof)| ((i64::from(dof.node), dof.direction.index() as i64), i)).collect();
    let shapes = &element.modes.interface_shapes;
    let scale = largest_entry(basis.modes.as_ref()).max(f64::MIN_POSITIVE);
    let mut defect = 0.0_f64;
    for (i, row) in element.rows.iter().enumerate() {
        if let Some(at) = position.get(&(row.node, row.direction)) {
            for k in 0..element.mode_count() {
                defect = defect.max((shapes[(i, k)] - basis.modes[(*at, k)]).abs() / scale);
            }
        }
    }
    defect
}

fn report_drops(element: &Superelement, findings: &mut Findings) {
    let (kept, rows) = (element.residual.sigma_squared.len(), element.rows.len());
    let outputs = element.rows.iter().filter(|row| element.interfaces[row.interface].role == Role::Output).count();
    findings.note(&format!(
        "a reader keeps {kept} attachment coordinates of {} attachment rows ({outputs} output rows), dropping {}",
        rows - outputs,
        (rows - outputs).saturating_sub(kept)
    ));
    if let Some(quality) = stored_quality(element) {
        for row in &quality.dependent_rows {
            findings.note(&match row.depends_on.is_empty() {
                true => format!("row {} sees no elastic motion", row.row),
                false => format!("row {} is a combination of {}", row.row, row.depends_on.join(", ")),
            });
        }
        if quality.static_directions > 0 {
            findings.note(&format!("{} direction(s) without mass of their own are kept statically", quality.static_directions));
        }
    }
}

fn check_sources(element: &Superelement, component: &Component, findings: &mut Findings) {
    for source in &component.sources {
        let recorded = element.provenance.inputs.iter().find(|input| input.role == source.role);
        let same = recorded.is_some_and(|input| input.sha256 == source.sha256);
        let found = match recorded {
            None => "was not an input of this superelement".to_owned(),
            Some(_) if same => "same bytes".to_owned(),
            Some(input) => format!("{} had other contents then", input.file_name),
        };
        findings.require(&format!("{} ({})", source.role, source.file_name), same, &found);
    }
}

fn check_against_component(
    element: &Superelement,
    recovery: Option<&RecoveryBasis>,
    component: &Component,
    findings: &mut Findings,
) -> Result<(), Error> {
    let properties = MassProperties::of(component)?;
    let mass_defect = (properties.mass - element.inertia.mass).abs() / properties.mass;
    findings.check("mass", mass_defect, AGREEMENT);
    match recovery.filter(|basis| basis.dofs.len() == component.dofs.len()) {
        Some(basis) => check_fields(element, basis, component, &properties, findings),
        None => {
            findings.note("no complete nodal fields are stored: the component was reduced anew");
            check_by_reduction(element, component, findings)
        }
    }
}

/// Every identity on the stored shapes.
fn check_fields(
    element: &Superelement,
    basis: &RecoveryBasis,
    component: &Component,
    properties: &MassProperties,
    findings: &mut Findings,
) -> Result<(), Error> {
    let same_dofs = basis.dofs == component.dofs.dofs();
    findings.require("dofs of the fields are those of the component", same_dofs, if same_dofs { "yes" } else { "no" });
    if !same_dofs {
        return Ok(());
    }
    let model = Model::of(component)?;
    let localization = Localization::of(component, &model)?;
    let geometric = RigidBodyModes::of(component, &model, properties)?;
    let defects = geometric.stiffness_defects(&model);
    let rigid = match element.frame_kind {
        FrameKind::MeanAxis => geometric,
        FrameKind::Given => geometric.none(),
    };
    let shapes = model.contract(basis.modes.as_ref());
    let attachments = model.contract(basis.residual.as_ref());
    let rigidity = |full: &Mat<f64>, model_columns: &Mat<f64>| {
        let expanded = model.expand(model_columns.as_ref());
        largest_entry((expanded.as_ref() - full).as_ref()) / largest_entry(full.as_ref()).max(f64::MIN_POSITIVE)
    };
    findings.check("rigid interfaces move rigidly in the fields", rigidity(&basis.modes, &shapes).max(rigidity(&basis.residual, &attachments)), AGREEMENT);

    let eigenvalues = element.modes.eigenvalues.clone();
    let zero_count = eigenvalues.iter().take_while(|value| **value == 0.0).count();
    let mass_shapes = symmetric_product(&model.mass, shapes.as_ref());
    let (mode_residuals, residual_roundings) =
        residuals(&model.stiffness, shapes.as_ref(), mass_shapes.as_ref(), &eigenvalues, zero_count);
    let energies = absolute_energies(&model.stiffness, shapes.as_ref());
    let eigenvalue_roundings = energies
        .iter()
        .zip(&eigenvalues)
        .map(|(energy, value)| if *value > 0.0 { f64::EPSILON * energy / value } else { 0.0 })
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
    let residual = ResidualFlexibility::from_shapes(&model, &localization, &rigid, &modes, attachments)?;
    let inertia = inertia_invariants(component, properties, crate::joined(&model, &modes, &residual).as_ref());
    let mut factor = SymmetricFactor::analyse(&model.stiffness, &model.mass, &model.points())?;
    let sturm: Sturm = crate::certificate(&model, &rigid, &modes, &mut factor);
    let quality =
        Quality::of(&model, properties, &rigid, &defects.per_column, &modes, &residual, &inertia, sturm);
    findings.text += &quality_lines(&quality);
    let broken = quality.broken_limits();
    findings.require("identities recomputed with K and M", broken.is_empty(), &format!("{} broken", broken.len()));
    findings.broken.extend(broken);

    let scale = |matrix: &Mat<f64>, i: usize| matrix[(i, i)].abs().max(f64::MIN_POSITIVE).sqrt();
    let difference = |stored: &Mat<f64>, computed: &Mat<f64>, reference: &dyn Fn(usize) -> f64| {
        let scaled = Mat::from_fn(stored.nrows(), stored.ncols(), |i, j| {
            let unit = reference(i) * reference(j);
            if unit > 0.0 { (stored[(i, j)] - computed[(i, j)]) / unit } else { stored[(i, j)] - computed[(i, j)] }
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
        difference(&element.residual.flexibility, &residual.flexibility, &|i| scale(&residual.flexibility0, i)),
        AGREEMENT,
    );
    findings.check("M_res", difference(&element.residual.mass, &residual.mass, &mass_scale), AGREEMENT);
    check_invariants(&element.inertia, &inertia, element.mode_count(), &residual.mass_diagonal0, findings);
    Ok(())
}

/// I1, L3 and I2 against their recomputation, each column divided by the size of its basis vector.
fn check_invariants(stored: &Inertia, computed: &Inertia, n_k: usize, mass_diagonal0: &[f64], findings: &mut Findings) {
    let norm = |k: usize| if k < n_k { 1.0 } else { mass_diagonal0[k - n_k].sqrt() };
    let n = computed.i1.len();
    let largest_moment = (0..3).map(|a| computed.tensor[a][a]).fold(0.0, f64::max).sqrt();
    let mut first = 0.0_f64;
    for k in (0..n).filter(|k| norm(*k) > 0.0) {
        for a in 0..3 {
            for b in 0..3 {
                first = first.max((stored.i1[k][a][b] - computed.i1[k][a][b]).abs() / (norm(k) * largest_moment));
            }
        }
    }
    findings.check("I1", first, AGREEMENT);
    for (what, x, y) in [("L3", &stored.l3, &computed.l3), ("I2", &stored.i2, &computed.i2)] {
        let mut worst = 0.0_f64;
        for (x, y) in x.iter().zip(y) {
            let scaled = Mat::from_fn(n, n, |k, l| {
                let unit = norm(k) * norm(l);
                if unit > 0.0 { (x[(k, l)] - y[(k, l)]) / unit } else { 0.0 }
            });
            worst = worst.max(largest_entry(scaled.as_ref()));
        }
        findings.check(what, worst, AGREEMENT);
    }
}

/// The component reduced again with the same number of modes.
fn check_by_reduction(element: &Superelement, component: &Component, findings: &mut Findings) -> Result<(), Error> {
    let options = Reduction {
        modes: ModeSelection::Lowest(element.mode_count()),
        grounding: if element.frame_kind == FrameKind::Given { Grounding::Allow } else { Grounding::Refuse },
        loose_pieces: if element.modes.eigenvalues.first() == Some(&0.0) { LoosePieces::Allow } else { LoosePieces::Refuse },
    };
    let again = reduce(component, &options, &mut ())?.superelement;
    let same = again.mode_count() == element.mode_count() && again.rows.len() == element.rows.len();
    findings.require(
        "number of modes and rows",
        same,
        &format!("{} and {}, recomputed {} and {}", element.mode_count(), element.rows.len(), again.mode_count(), again.rows.len()),
    );
    if !same {
        return Ok(());
    }
    let eigenvalues = element.modes.eigenvalues.iter().zip(&again.modes.eigenvalues);
    let worst = eigenvalues.map(|(a, b)| (a - b).abs() / b.abs().max(f64::MIN_POSITIVE)).fold(0.0, f64::max);
    findings.check("eigenvalues", worst, AGREEMENT);
    let mass = |i: usize| again.residual.mass_diagonal0[i].sqrt();
    for (what, x, y) in [
        ("M_res", &element.residual.mass, &again.residual.mass),
        ("F_res", &element.residual.flexibility, &again.residual.flexibility),
    ] {
        let largest = largest_entry(y.as_ref()).max(f64::MIN_POSITIVE);
        let scaled = Mat::from_fn(x.nrows(), x.ncols(), |i, j| {
            let unit = if what == "M_res" { (mass(i) * mass(j)).max(f64::MIN_POSITIVE) } else { largest };
            (x[(i, j)] - y[(i, j)]) / unit
        });
        findings.check(what, largest_entry(scaled.as_ref()), AGREEMENT);
    }
    Ok(())
}
