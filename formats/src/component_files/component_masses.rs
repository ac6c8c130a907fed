//! Component masses from their files.

use super::ComponentFiles;
use crate::component::{ComponentDraft, ComponentMasses};
use crate::error::Error;
use crate::matrix::MatrixReader;

/// Reads the component masses, if there is any file of them.
///
/// # Errors
/// The first file that is missing or can't be read.
pub(super) fn read_component_masses(
    files: &ComponentFiles,
    reader: &mut MatrixReader,
    draft: &mut ComponentDraft,
) -> Result<(), Error> {
    let names = ComponentMasses::names(draft.dimension());
    let paths = files.component_masses(names);
    let present = paths.iter().filter(|path| path.exists()).count();
    if present == 0 {
        return Ok(());
    }
    if let Some(absent) = paths.iter().find(|path| !path.exists()) {
        return Err(Error::File {
            path: absent.clone(),
            message: format!(
                "missing, while {present} of the {} component masses ({}) are there; give all of them or none",
                names.len(),
                names.join(" ")
            ),
        });
    }
    let mut matrices = Vec::with_capacity(paths.len());
    for (path, name) in paths.iter().zip(names) {
        let (matrix, report) = reader.read_matrix(path)?;
        draft.took(&format!("mass.{name}"), &report);
        matrices.push(matrix);
    }
    draft.component_masses = Some(ComponentMasses { matrices });
    Ok(())
}
