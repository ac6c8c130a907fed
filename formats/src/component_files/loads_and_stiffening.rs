//! Optional files with a name of their own: loads inside the component, and geometric stiffness.
//!
//! `part.load.NAME.mtx` is a load vector, (n_e, 1). `part.stiffening.xx.mtx` … are stiffness matrices per product of spins, planar
//! `part.stiffening.zz.mtx`; `part.stiffening.INTERFACE.ux.mtx` is one per unit force along a row of an interface.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use super::stem;
use crate::SparseMatrix;
use crate::component::{ComponentDraft, GeometricStiffness, Interface, NamedLoad, RowStiffness};
use crate::error::Error;
use crate::matrix::MatrixReader;
use crate::mesh::Direction;

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
    let products = GeometricStiffness::spin_products(draft.dimension());
    let mut spins: Vec<Option<SparseMatrix>> = products.iter().map(|_| None).collect();
    let mut rows = Vec::new();
    for (name, path) in files {
        let (matrix, report) = reader.read_symmetric_operator(path)?;
        draft.took(&format!("stiffening.{name}"), &report);
        match products.iter().position(|product| product == name) {
            Some(product) => spins[product] = Some(matrix),
            None => rows.push(RowStiffness {
                row: row_of(name, &draft.interfaces).ok_or_else(|| Error::File {
                    path: path.clone(),
                    message: unknown(name, products, &draft.interfaces),
                })?,
                matrix,
            }),
        }
    }
    let absent: Vec<&str> = (products.iter().zip(&spins))
        .filter(|(_, matrix)| matrix.is_none())
        .map(|(product, _)| *product)
        .collect();
    if absent.len() == products.len() {
        spins.clear();
    } else if !absent.is_empty() {
        draft.notes.push(format!(
            "geometric stiffness: no file for the spin products {}; taken as zero",
            absent.join(", ")
        ));
    }
    draft.geometric_stiffness = Some(GeometricStiffness { spins, rows });
    Ok(())
}

/// Interface and direction of a name such as `big-end.ux`; only attachments have rows that forces act on.
fn row_of(name: &str, interfaces: &[Interface]) -> Option<(usize, Direction)> {
    let (interface, direction) = name.rsplit_once('.')?;
    let index = interfaces.iter().position(|one| one.name == interface)?;
    let direction = Direction::from_name(direction)?;
    interfaces[index]
        .has_row_of_forces()
        .then_some((index, direction))
}

fn unknown(name: &str, products: &[&str], interfaces: &[Interface]) -> String {
    let rows: Vec<&str> = interfaces.iter().map(|one| one.name.as_str()).collect();
    format!(
        "{name:?} is neither a product of spins ({}) nor INTERFACE.ux, .uy, … of an attached interface that moves as one ({})",
        products.join(", "),
        rows.join(", ")
    )
}
