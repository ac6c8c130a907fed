//! How much of a stress row the kept modes leave out: √(s G_o sᵀ), the norm of the row over the omitted modes, one static response each.
//!
//! By the inequality of Cauchy and Schwarz an error e of the displacements beyond the kept modes changes the stress by no more than that times √(eᵀ K e).

use dcb_formats::component::NamedStress;
use dcb_sparse::factorization::PositiveFactor;

use crate::attachments::columns::{AttachmentProblem, Loads};
use crate::attachments::enrichment::Reducing;
use crate::error::Error;
use crate::model::stresses::rows_as_forces;
use crate::observer::Observer;

/// Responses at a time, to bound memory.
const ROWS_AT_A_TIME: usize = 64;
/// More rows of a part aren't asked for: each costs a static response.
const MOST_ROWS: usize = 2000;

/// Of each field's rows; `None` where there are too many.
///
/// # Errors
/// Those of [`AttachmentProblem::solve`]; a response that doesn't converge.
pub fn omitted_stress(
    of: &Reducing<'_>,
    factor: &PositiveFactor,
    observer: &mut dyn Observer,
) -> Result<Option<Vec<Vec<f64>>>, Error> {
    let fields = &of.component.stresses;
    let count: usize = fields.iter().map(|field| field.matrix.nrows()).sum();
    if fields.is_empty() || count > MOST_ROWS {
        return Ok(None);
    }
    let mut all = Vec::with_capacity(fields.len());
    for field in fields {
        let mut own = Vec::with_capacity(field.matrix.nrows());
        for first in (0..field.matrix.nrows()).step_by(ROWS_AT_A_TIME) {
            let rows = first..field.matrix.nrows().min(first + ROWS_AT_A_TIME);
            let forces = rows_as_forces(of.model, field, rows.clone());
            let names: Vec<String> = rows.map(|row| name(field, row)).collect();
            let loads = Loads::Columns {
                forces: forces.as_ref(),
                names: &names,
            };
            let problem = AttachmentProblem::new(of.model, loads, of.rigid, of.modes);
            let solved = problem.solve(factor, observer)?;
            problem.refuse_unconverged(&solved)?;
            let energies = (0..names.len()).map(|row| solved.stiffness.columns[(row, row)]);
            own.extend(energies.map(|energy| energy.max(0.0).sqrt()));
        }
        all.push(own);
    }
    Ok(Some(all))
}

fn name(field: &NamedStress, row: usize) -> String {
    let count = field.components.len();
    let component = field.components[row % count].name();
    format!("{} {component} at place {}", field.name, row / count)
}
