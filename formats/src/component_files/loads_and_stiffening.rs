//! Optional files with a name of their own: loads inside the component, and geometric stiffness.
//!
//! `part.load.NAME.mtx` is a load vector, (n_e, 1). `part.stiffening.xx.mtx` … are stiffness matrices per product of spins, planar
//! `part.stiffening.zz.mtx`; `part.stiffening.INTERFACE.ux.mtx` is one per unit force along a row of an interface.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use super::stem;
use crate::component::{ComponentDraft, NamedLoad};
use crate::error::Error;
use crate::matrix::MatrixReader;

/// Files `STEM + infix + NAME + .mtx` (or `.mtx.gz`) beside the stiffness matrix by NAME, sorted.
///
/// # Errors
/// [`Error::Io`] if the folder can't be listed, [`Error::File`] if one name stands twice, plain and packed.
pub(super) fn named_siblings(
    stiffness: &Path,
    infix: &str,
) -> Result<Vec<(String, PathBuf)>, Error> {
    let stem = stem(stiffness);
    let folder = match stem.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    let Some(mut prefix) = stem.file_name().map(OsStr::to_owned) else {
        return Ok(Vec::new());
    };
    prefix.push(infix);
    let failed = |source| Error::io(folder, "cannot list the folder", source);
    let mut found: Vec<(String, PathBuf)> = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(failed)? {
        let file_name = entry.map_err(failed)?.file_name();
        let Some(rest) = (file_name.as_encoded_bytes()).strip_prefix(prefix.as_encoded_bytes())
        else {
            continue;
        };
        let rest = rest.strip_suffix(b".gz").unwrap_or(rest);
        if let Some(name) = rest.strip_suffix(b".mtx").filter(|name| !name.is_empty()) {
            let path = stem.with_file_name(&file_name);
            let name = std::str::from_utf8(name).map_err(|_| Error::File {
                path: path.clone(),
                message: format!("the name after `{infix}` isn't UTF-8; rename the file"),
            })?;
            found.push((name.to_owned(), path));
        }
    }
    found.sort();
    match found.windows(2).find(|pair| pair[0].0 == pair[1].0) {
        Some(pair) => Err(Error::File {
            path: pair[1].1.clone(),
            message: format!("{} is there as well; keep one of them", pair[0].1.display()),
        }),
        None => Ok(found),
    }
}

/// Reads the load vectors.
///
/// # Errors
/// The first file that isn't one column.
pub(super) fn read_loads(
    files: &[(String, PathBuf)],
    reader: &mut MatrixReader,
    draft: &mut ComponentDraft,
) -> Result<(), Error> {
    let n_e = draft.stiffness.nrows();
    for (name, path) in files {
        let (matrix, report) = reader.read_matrix(path)?;
        if (matrix.nrows(), matrix.ncols()) != (n_e, 1) {
            return Err(Error::File {
                path: path.clone(),
                message: format!(
                    "{} x {}, but a load of this component is one column of {n_e} entries, one for each dof",
                    matrix.nrows(),
                    matrix.ncols()
                ),
            });
        }
        let mut forces = vec![0.0; n_e];
        let entries = matrix.row_idx_of_col_raw(0).iter();
        for (row, value) in entries.zip(matrix.val_of_col(0)) {
            forces[*row as usize] = *value;
        }
        draft.took(&format!("load.{name}"), &report);
        draft.loads.push(NamedLoad {
            name: name.clone(),
            forces,
        });
    }
    Ok(())
}

/// Reads the geometric stiffness, if there is any file of it.
///
/// # Errors
/// The first file that isn't a symmetric matrix, or whose name is neither a product of spins nor a row of an attached interface.
pub(super) fn read_stiffening(
    files: &[(String, PathBuf)],
    reader: &mut MatrixReader,
    draft: &mut ComponentDraft,
) -> Result<(), Error> {
    if files.is_empty() {
        return Ok(());
    }
    let mut named = Vec::new();
    for (name, path) in files {
        let (matrix, report) = reader.read_symmetric_operator(path)?;
        draft.took(&format!("stiffening.{name}"), &report);
        named.push((name.clone(), matrix));
    }
    draft.stiffen(named).map_err(|unknown| Error::File {
        path: (files.iter().find(|(name, _)| *name == unknown.name))
            .map_or_else(PathBuf::new, |(_, path)| path.clone()),
        message: unknown.to_string(),
    })
}
