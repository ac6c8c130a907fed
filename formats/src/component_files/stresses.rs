//! Stress and strain matrices: `part.stress.NAME.mtx`, (places x components, n_e), whose rows the component file describes under `stresses`.

use super::ComponentFiles;
use crate::component::{ComponentDraft, NamedStress};
use crate::description::{StressRows, suggestion};
use crate::error::Error;
use crate::matrix::MatrixReader;

/// Reads the stress matrices.
///
/// # Errors
/// A matrix without an entry in the component file, an entry without a matrix, and what is wrong in a file.
pub(super) fn read_stresses(
    files: &ComponentFiles,
    rows: Vec<StressRows>,
    reader: &mut MatrixReader,
    draft: &mut ComponentDraft,
) -> Result<(), Error> {
    if let Some((name, path)) =
        (files.stresses.iter()).find(|(name, _)| !rows.iter().any(|rows| rows.name == *name))
    {
        let described = || rows.iter().map(|rows| rows.name.as_str());
        return Err(Error::File {
            path: path.clone(),
            message: format!(
                "{} doesn't say what its rows are: component.stresses.{name} is missing{}; add for example \"stresses\": {{\"{name}\": {{\"nodes\": [0]}}}}",
                super::file_name(&files.description),
                suggestion(name, described())
            ),
        });
    }
    for StressRows {
        name,
        quantity,
        components,
        points,
    } in rows
    {
        let Some((_, path)) = files.stresses.iter().find(|(own, _)| *own == name) else {
            return Err(Error::Location {
                path: files.description.clone(),
                location: format!("component.stresses.{name}"),
                message: format!(
                    "its matrix is not there; put it beside the stiffness matrix as {}.stress.{name}.mtx, or remove the key",
                    super::file_name(&super::stem(&files.stiffness))
                ),
            });
        };
        let (matrix, report) = reader.read_matrix(path)?;
        draft.took(&format!("stress.{name}"), &report);
        draft.stresses.push(NamedStress {
            name,
            quantity,
            components,
            points,
            matrix,
        });
    }
    // In the order of the files, which faults count by.
    draft.stresses.sort_by(|a, b| a.name.cmp(&b.name));
    Ok(())
}
