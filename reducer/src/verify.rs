//! `reduce verify`: recomputes what can be recomputed, from the file alone or, given the component, everything.
//!
//! From the file: every digest, the identities of the residual transform, symmetry and sign of the matrices, the mean-axis
//! condition, nodal rows against the stored fields, and the limits of the stored quality report. From the component: see
//! [`crate::verify_component`].

use std::fmt::Write as _;

use dcb_formats::component::Role;
use dcb_formats::component_files::{ComponentFiles, Overrides, read_component};
use dcb_formats::dcb::SuperelementFile;
use dcb_formats::superelement::FrameKind;
use dcb_formats::{RecoveryBasis, Superelement};
use faer::{Mat, MatRef};

use crate::block_algebra::{largest_entry, symmetric_eigen, symmetrized};
use crate::cli::VerifyArguments;
use crate::cli_reduce::{Outcome, naming_the_file};
use crate::error::Error;
use crate::inspect::stored_quality;
use crate::quality::ORTHOGONALITY_LIMIT;
use crate::residual_filter::MASS_TOLERANCE;
use crate::rigid_body::MassProperties;
use crate::scientific::scientific;
use crate::verify_component;

/// Stored and recomputed matrices may differ by this, relative to their scale.
pub const AGREEMENT: f64 = 1e-8;
/// The transform's identities hold to rounding over the tolerance that it was cut at.
const TRANSFORM_LIMIT: f64 = 1e-4;
/// Masses of rows below this part of the largest of their kind are rounding.
const MASS_ROUNDING: f64 = 1e-18;

/// What was checked, line by line.
pub struct Findings {
    /// A line for each check.
    pub text: String,
    /// Those that failed.
    pub broken: Vec<String>,
}

impl Findings {
    /// A number that must not exceed its limit.
    pub fn check(&mut self, what: &str, value: f64, limit: f64) {
        let holds = value <= limit;
        let mark = if holds { "ok  " } else { "FAIL" };
        let _ = writeln!(
            self.text,
            "  {mark} {what:<58} {}  (limit {limit:.0e})",
            scientific(value, 1)
        );
        if !holds {
            self.broken
                .push(format!("{what}: {value:.1e}, above its limit {limit:.0e}"));
        }
    }

    /// A fact, with what was found.
    pub(crate) fn require(&mut self, what: &str, holds: bool, found: &str) {
        let mark = if holds { "ok  " } else { "FAIL" };
        let _ = writeln!(self.text, "  {mark} {what:<58} {found}");
        if !holds {
            self.broken.push(format!("{what}: {found}"));
        }
    }

    /// Something to know that can't fail.
    pub fn note(&mut self, line: &str) {
        let _ = writeln!(self.text, "       {line}");
    }
}

/// Runs the command.
///
/// # Errors
/// If the file is not an intact superelement, or the component can't be read.
pub fn run(arguments: &VerifyArguments) -> Result<Outcome, Error> {
    let path = &arguments.file;
    let file = SuperelementFile::open(path)?;
    let mut findings = Findings {
        text: format!("{}\n", path.display()),
        broken: Vec::new(),
    };
    let datasets = file.verify_digests()?;
    findings.require(
        "digests of all datasets",
        true,
        &format!("{datasets} agree"),
    );
    let element = file.superelement()?;
    let recovery = file.recovery()?;
    check_transform(&element, &mut findings)?;
    check_inertia(&element, &mut findings)?;
    if let Some(basis) = &recovery {
        findings.check(
            "nodal rows of L_b Ψ against the stored fields",
            nodal_row_defect(&element, basis),
            AGREEMENT,
        );
    }
    report_drops(&element, &mut findings);
    match stored_quality(&element) {
        Some(quality) => {
            let broken = quality.broken_limits();
            findings.require(
                "limits of the stored quality report",
                broken.is_empty(),
                &format!("{} broken", broken.len()),
            );
            findings.broken.extend(broken);
        }
        None => findings
            .note("no quality report of this program is stored; its limits were not checked"),
    }
    if let Some(stiffness) = &arguments.component {
        let overrides = Overrides {
            mass: arguments.mass.clone(),
            description: arguments.mesh.clone(),
            boundary: arguments.boundary.clone(),
        };
        let files = ComponentFiles::beside(stiffness, &overrides)?;
        let component = read_component(&files)?;
        verify_component::check(&element, recovery.as_ref(), &component, &mut findings)
            .map_err(|error| naming_the_file(error, &files))?;
    }
    let verdict = if findings.broken.is_empty() {
        "verified\n"
    } else {
        "NOT verified\n"
    };
    let what = format!("{}: not verified", path.display());
    Ok(Outcome::unless(
        findings.text + verdict,
        &what,
        &findings.broken,
    ))
}

fn unit_defect(
    matrix: MatRef<'_, f64>,
    diagonal: impl Fn(usize) -> f64,
    scale: impl Fn(usize, usize) -> f64,
) -> f64 {
    let defect = Mat::from_fn(matrix.nrows(), matrix.ncols(), |i, j| {
        (matrix[(i, j)] - if i == j { diagonal(i) } else { 0.0 }) / scale(i, j)
    });
    largest_entry(defect.as_ref())
}

/// T_rᵀ M_res T_r = I and T_rᵀ F_res T_r = diag(σ²); F_res and M_res positive semi-definite; the rank is the one that M_res has.
fn check_transform(element: &Superelement, findings: &mut Findings) -> Result<(), Error> {
    let failed = || Error::NotFinite {
        what: "the residual matrices",
    };
    let residual = &element.residual;
    let t = &residual.transform;
    let mass = t.transpose() * &residual.mass * t;
    let stiffness = t.transpose() * &residual.flexibility * t;
    let sigma = |i: usize| residual.sigma_squared[i];
    let largest = residual
        .sigma_squared
        .last()
        .copied()
        .unwrap_or(1.0)
        .max(f64::MIN_POSITIVE);
    findings.check(
        "T_rᵀ M_res T_r = I",
        unit_defect(mass.as_ref(), |_| 1.0, |_, _| 1.0),
        TRANSFORM_LIMIT,
    );
    findings.check(
        "T_rᵀ F_res T_r = diag(σ²)",
        unit_defect(stiffness.as_ref(), sigma, |_, _| largest),
        TRANSFORM_LIMIT,
    );
    let d = row_scales(element);
    let n_b = d.len();
    let scaled = |matrix: &Mat<f64>| Mat::from_fn(n_b, n_b, |i, j| d[i] * matrix[(i, j)] * d[j]);
    for (matrix, what) in [(&residual.mass, "M_res"), (&residual.flexibility, "F_res")] {
        let (values, _) =
            symmetric_eigen(symmetrized(scaled(matrix).as_ref()).as_ref()).ok_or_else(failed)?;
        let largest = values.last().copied().unwrap_or(0.0).max(f64::MIN_POSITIVE);
        let negative = values
            .first()
            .map_or(0.0, |smallest| (-smallest / largest).max(0.0));
        findings.check(
            &format!("{what} is positive semi-definite (negative part)"),
            negative,
            ORTHOGONALITY_LIMIT,
        );
    }
    let seen = &element.modes.interface_shapes;
    let attached =
        |i: usize| element.interfaces[element.rows[i].interface].role == Role::Attachment;
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
    let (reference, _) =
        symmetric_eigen(symmetrized(scaled(&mass0).as_ref()).as_ref()).ok_or_else(failed)?;
    let (values, _) = symmetric_eigen(symmetrized(scaled(&residual.mass).as_ref()).as_ref())
        .ok_or_else(failed)?;
    let limit = MASS_TOLERANCE * reference.last().copied().unwrap_or(0.0);
    let rank = values.iter().filter(|value| **value > limit).count();
    // The inertia of attachments may be left out on purpose.
    let fewer = is_selection(element) && t.ncols() < rank;
    findings.require(
        "rank of the residual transform",
        fewer || rank == t.ncols(),
        &format!("{} stored, {rank} found", t.ncols()),
    );
    Ok(())
}

/// 1/√diag(M_res) with no mode kept; zero for rows without, and for those of which a selection has left rounding beside the largest of their kind,
/// forces or moments.
fn row_scales(element: &Superelement) -> Vec<f64> {
    let masses = &element.residual.mass_diagonal0;
    let is_force = |row: usize| (0..3).contains(&element.rows[row].direction);
    let largest = [false, true].map(|force| {
        let own = (0..masses.len()).filter(|row| is_force(*row) == force);
        own.fold(0.0, |most: f64, row| most.max(masses[row]))
    });
    let scale = |(row, mass): (usize, &f64)| {
        let least = MASS_ROUNDING * largest[usize::from(is_force(row))];
        if *mass > least {
            mass.sqrt().recip()
        } else {
            0.0
        }
    };
    masses.iter().enumerate().map(scale).collect()
}

/// Whether it was taken out of a larger superelement.
pub(crate) fn is_selection(element: &Superelement) -> bool {
    let selections = element.provenance.options["selections"].as_array();
    selections.is_some_and(|selections| !selections.is_empty())
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
        symmetric_eigen(symmetrized(tensor.as_ref()).as_ref()).ok_or(Error::NotFinite {
            what: "the inertia tensor",
        })?;
    let largest = moments.last().copied().unwrap_or(0.0);
    // No principal moment of a body exceeds the sum of the other two; a planar part stores only one.
    let possible =
        inertia.l3.len() == 1 || largest <= (1.0 + AGREEMENT) * (moments[0] + moments[1]);
    findings.require(
        "the inertia tensor is that of a body",
        largest > 0.0 && moments[0] >= -AGREEMENT * largest && possible,
        &format!(
            "principal moments{}",
            moments
                .iter()
                .map(|m| format!("  {}", scientific(*m, 6)))
                .collect::<String>()
        ),
    );
    Ok(())
}

/// Rows of `nodes` interfaces are entries of the fields.
fn nodal_row_defect(element: &Superelement, basis: &RecoveryBasis) -> f64 {
    let position: std::collections::HashMap<(i64, i64), usize> = basis
        .dofs
        .iter()
        .enumerate()
        .map(|(i, dof)| ((i64::from(dof.node), dof.direction.index() as i64), i))
        .collect();
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
    let outputs = element
        .rows
        .iter()
        .filter(|row| element.interfaces[row.interface].role == Role::Output)
        .count();
    findings.note(&format!(
        "a reader keeps {kept} attachment coordinates of {} attachment rows ({outputs} output rows), dropping {}",
        rows - outputs,
        (rows - outputs).saturating_sub(kept)
    ));
    if let Some(quality) = stored_quality(element) {
        for row in &quality.dependent_rows {
            findings.note(&match row.depends_on.is_empty() {
                true => format!("row {} sees no elastic motion", row.row),
                false => format!(
                    "row {} is a combination of {}",
                    row.row,
                    row.depends_on.join(", ")
                ),
            });
        }
        if let Some(reduction) = quality.interface_reduction.filter(|it| it.leaves_out()) {
            findings.note(&format!(
                "interface reduction: {} of {} directions of F_res are kept",
                reduction.kept, reduction.available
            ));
        }
        if quality.static_directions > 0 {
            findings.note(&format!(
                "{} direction(s) without mass of their own are kept statically",
                quality.static_directions
            ));
        }
    }
}
