//! A superelement against itself: identities and bounds between its datasets, the rank of the residual transform, nodal rows against the
//! fields and the mesh, and the limits of the stored quality report.

use dcb_dense::{symmetric_eigen, symmetrized};
use dcb_formats::component::Role;
use dcb_formats::identities;
use dcb_formats::mesh::Mesh;
use dcb_formats::superelement::CouplingSource;
use dcb_formats::{RecoveryBasis, Superelement};
use dcb_superelement::MASS_TOLERANCE;
use faer::Mat;

use super::findings::{AGREEMENT, Findings};
use crate::error::Error;
use crate::quality::Quality;

/// Checks a superelement, its nodal fields and its mesh.
///
/// # Errors
/// [`Error::NotFinite`] if the residual matrices aren't finite.
pub fn check_alone(
    element: &Superelement,
    recovery: Option<&RecoveryBasis>,
    mesh: Option<&Mesh>,
    findings: &mut Findings,
) -> Result<(), Error> {
    check_identities(element, findings);
    check_rank(element, findings)?;
    if let Some(basis) = recovery {
        findings.check(
            "nodal rows of L_b Ψ against the stored fields",
            nodal_row_defect(element, basis),
            AGREEMENT,
        );
    }
    if let Some(mesh) = mesh {
        findings.check(
            "/interfaces/row_positions: rows of nodes are where the mesh has these",
            mesh_defect(element, mesh),
            AGREEMENT,
        );
    }
    report_drops(element, findings);
    match Quality::stored(element) {
        Some(quality) => {
            let broken = quality.broken_limits();
            findings.require(
                "limits of the stored quality report",
                broken.is_empty(),
                &format!("{} broken", broken.len()),
            );
            let broken = broken.iter().map(ToString::to_string);
            findings.broken.extend(broken);
        }
        None => findings
            .note("no quality report of this program is stored; its limits were not checked"),
    }
    Ok(())
}

/// Everything that the numbers have to do with each other.
fn check_identities(element: &Superelement, findings: &mut Findings) {
    for identity in identities::in_full(element) {
        let what = format!("{}: {}", identity.path, identity.what);
        findings.check(&what, identity.defect, identity.limit);
    }
    let inexact = "L3 and I2 are not integrals over the part but what its nodes say: they are compared with the mass only roughly";
    let said = match element.coupling_source() {
        CouplingSource::Integrals => None,
        CouplingSource::Nodal => Some(inexact),
        CouplingSource::Unknown => Some(
            "the file doesn't say whether L3 and I2 are integrals over the part: they are compared with the mass only roughly",
        ),
    };
    if let Some(said) = said {
        findings.note(said);
    }
}

/// The rank of the transform is the one that M_res has.
fn check_rank(element: &Superelement, findings: &mut Findings) -> Result<(), Error> {
    let failed = || Error::NotFinite {
        what: "the residual matrices",
    };
    let residual = &element.residual;
    let d = identities::row_scales(element);
    let n_b = d.len();
    let scaled = |matrix: &Mat<f64>| Mat::from_fn(n_b, n_b, |i, j| d[i] * matrix[(i, j)] * d[j]);
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
    let (reference, _) =
        symmetric_eigen(symmetrized(scaled(&mass0).as_ref()).as_ref()).ok_or_else(failed)?;
    let (values, _) = symmetric_eigen(symmetrized(scaled(&residual.mass).as_ref()).as_ref())
        .ok_or_else(failed)?;
    let limit = MASS_TOLERANCE * reference.last().copied().unwrap_or(0.0);
    let rank = values.iter().filter(|value| **value > limit).count();
    let stored = residual.transform.ncols();
    // The inertia of attachments may be left out on purpose.
    let fewer = is_selection(element) && stored < rank;
    findings.require(
        "rank of the residual transform",
        fewer || rank == stored,
        &format!("{stored} stored, {rank} found"),
    );
    Ok(())
}

/// Whether it was taken out of a larger superelement.
pub(crate) fn is_selection(element: &Superelement) -> bool {
    !element.selections().is_empty()
}

/// Rows of `nodes` interfaces are entries of the fields, of modes, attachments and further columns alike.
fn nodal_row_defect(element: &Superelement, basis: &RecoveryBasis) -> f64 {
    let position: std::collections::HashMap<(i64, i64), usize> = basis
        .dofs
        .iter()
        .enumerate()
        .map(|(i, dof)| ((i64::from(dof.node), dof.direction.index() as i64), i))
        .collect();
    let residual = &element.residual;
    // What an interface reduction leaves of an attachment can be rounding beside the whole of it.
    let whole = identities::flexibilities(element);
    let answers = residual
        .output_shapes
        .as_ref()
        .unwrap_or(&residual.flexibility);
    let further = element
        .enrichment
        .as_ref()
        .map(|further| &further.interface_shapes);
    let pairs = [
        (&element.modes.interface_shapes, Some(&basis.modes)),
        (answers, Some(&basis.residual)),
    ];
    let pairs = pairs
        .into_iter()
        .chain(further.map(|rows| (rows, basis.enrichment.as_ref())));
    let mut defect = 0.0_f64;
    for (rows, fields) in pairs.filter_map(|(rows, fields)| Some((rows, fields?))) {
        let is_residual = std::ptr::eq(rows, answers);
        for k in 0..rows.ncols() {
            let largest = fields.col(k).norm_max();
            for (i, row) in element.rows.iter().enumerate() {
                if let Some(at) = position.get(&(row.node, row.direction)) {
                    let found = (rows[(i, k)] - fields[(*at, k)]).abs();
                    let scale = match is_residual {
                        true => largest.max((whole[i] * whole[k]).sqrt()),
                        false => largest,
                    };
                    if found > 0.0 {
                        defect = defect.max(found / scale);
                    }
                }
            }
        }
    }
    defect
}

/// Rows of nodes are where the mesh has these.
fn mesh_defect(element: &Superelement, mesh: &Mesh) -> f64 {
    let size = mesh
        .coordinates
        .iter()
        .fold(f64::MIN_POSITIVE, |most, x| most.max(x.abs()));
    let mut defect = 0.0_f64;
    for row in &element.rows {
        if let Some(node) = u32::try_from(row.node)
            .ok()
            .filter(|node| (*node as usize) < mesh.node_count())
        {
            let place = mesh.position(node);
            for ((place, origin), position) in place.iter().zip(&element.origin).zip(&row.position)
            {
                defect = defect.max((place - origin - position).abs() / size);
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
    if let Some(quality) = Quality::stored(element) {
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
        let derivation = element.derivation.as_ref();
        let said = derivation.and_then(|derivation| derivation.interface_directions);
        let said = said.filter(|of| of.leave_out());
        let said = said.map(|of| (of.kept, of.available));
        let reduction = quality.interface_reduction.filter(|it| it.leaves_out());
        if said != reduction.as_ref().map(|of| (of.kept, of.available)) {
            findings.require(
                "/derivation/interface_directions are those of the quality report",
                false,
                "they differ",
            );
        }
        if let Some(reduction) = reduction {
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
