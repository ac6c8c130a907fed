//! MATLAB files of version 7.3 (`save -v7.3`), which are HDF5 behind a block of text, and matrices in HDF5 files of other programs.
//!
//! A sparse matrix is a group with `data`, `ir` and `jc`, compressed columns; Python programs write such groups with `data`, `indices` and
//! `indptr`, compressed rows. A full matrix is a dataset, in MATLAB's files its transpose. Structures are groups: `/` in names.

mod dataset;
mod objects;

use std::fs::File;
use std::path::Path;

use dcb_formats::Error;
use dcb_formats::hdf5_files::container::{Container, on_large_stack};
use dcb_formats::terminal::shortened;

use self::dataset::Numbers;
use self::objects::{Found, Storage, objects};
use crate::binary::file::regular;
use crate::binary::hashed::hashed;
use crate::matrix::labels::{DOF_REF, IntegerTable};
use crate::matrix::storage::collected::square;
use crate::matrix::storage::compressed::{Along, Pattern};
use crate::matrix::storage::dense::dense;
use crate::matrix::storage::stream::{indices, integers};
use crate::stored::{Content, Listed, Reading, StoredMatrix};

/// Whether a file begins as one of version 7.3, or as HDF5.
pub fn recognises(start: &[u8]) -> bool {
    start.starts_with(b"MATLAB 7.3") || start.starts_with(b"\x89HDF\r\n\x1a\n")
}

/// The matrices of a file.
///
/// # Errors
/// [`Error::Location`] with the path in the file, [`Error::File`] for what isn't HDF5 or is damaged; [`Error::Io`].
pub fn list(path: &Path) -> Result<Vec<Listed>, Error> {
    let found = with_file(path, |file| objects(path, file))?;
    let matrices = found.into_iter().filter(|found| !found.is_table());
    Ok(matrices
        .map(|found| Listed {
            name: found.name,
            shape: found.shape,
            obstacle: found.obstacle,
        })
        .collect())
}

/// Reads matrices by their place in the list; a table `dof_ref` labels their rows.
///
/// # Errors
/// As [`list`]; for places outside, values that aren't finite, labels that can't be.
pub fn read(path: &Path, wanted: &[usize]) -> Result<Reading, Error> {
    let (matrices, sha256) = hashed(path, || {
        with_file(path, |file| read_matrices(path, file, wanted))
    })?;
    Ok(Reading { matrices, sha256 })
}

fn read_matrices(
    path: &Path,
    file: &Container,
    wanted: &[usize],
) -> Result<Vec<StoredMatrix>, Error> {
    let (tables, matrices): (Vec<Found>, Vec<Found>) =
        objects(path, file)?.into_iter().partition(Found::is_table);
    let matrix = |number: &usize| match matrices.get(*number) {
        Some(found) => found.matrix(path, file),
        None => Err(refused(
            path,
            "/",
            format!("has {} matrices, not {}", matrices.len(), number + 1),
        )),
    };
    let mut read = wanted.iter().map(matrix).collect::<Result<Vec<_>, _>>()?;
    if let Some(table) = tables.first() {
        let labelled = table.table(path, file)?.label_rows(&mut read);
        labelled.map_err(|message| refused(path, &table.name, message))?;
    }
    Ok(read)
}

/// Reads an array of integers with one or two columns, by name without regard to case.
pub(crate) fn table(path: &Path, name: &str) -> Result<Option<IntegerTable>, Error> {
    with_file(path, |file| {
        let found = objects(path, file)?;
        let found = found
            .iter()
            .find(|found| found.name.eq_ignore_ascii_case(name));
        found.map(|found| found.table(path, file)).transpose()
    })
}

fn refused(path: &Path, place: &str, message: String) -> Error {
    Error::Location {
        path: path.into(),
        location: shortened(place),
        message,
    }
}

/// Opens a file on a stack that no file exhausts.
fn with_file<T: Send>(
    path: &Path,
    work: impl FnOnce(&Container) -> Result<T, Error> + Send,
) -> Result<T, Error> {
    let length = regular(path)?.len();
    let cannot_read = |source| Error::io(path, "cannot read", source);
    let file = File::open(path).map_err(cannot_read)?;
    let done = on_large_stack(|| {
        let meant = "expected a MATLAB file of version 7.3 or another HDF5 file with matrices";
        let file = Container::open(file, length, meant).map_err(|message| Error::File {
            path: path.into(),
            message,
        })?;
        file.allow_reading();
        work(&file)
    });
    done.map_err(cannot_read)?
}

impl Found {
    fn is_table(&self) -> bool {
        self.name.eq_ignore_ascii_case(DOF_REF)
    }

    fn matrix(&self, path: &Path, file: &Container) -> Result<StoredMatrix, Error> {
        let told = |message: String| refused(path, &self.name, message);
        if let Some(obstacle) = &self.obstacle {
            return Err(told(format!(
                "is {obstacle}; stiffness and mass are real and square"
            )));
        }
        let (rows, columns) = self.shape.unwrap_or_default();
        let size = square(rows, columns).map_err(told)?;
        let content = match &self.storage {
            Storage::None => return Err(told("can't be read".into())),
            Storage::Dense { numbers, along } => dense(
                &mut numbers.stream(path, file),
                numbers.number,
                *along,
                size,
            )?,
            Storage::Sparse {
                along,
                starts,
                entries,
            } => sparse(path, file, size, *along, starts, entries.as_deref())?,
        };
        Ok(StoredMatrix {
            digits: self.storage.digits(),
            ..StoredMatrix::unlabelled(self.name.clone(), size as usize, content)
        })
    }

    fn table(&self, path: &Path, file: &Container) -> Result<IntegerTable, Error> {
        let told = |message: String| refused(path, &self.name, message);
        let (Storage::Dense { numbers, along }, Some((_, columns))) = (&self.storage, self.shape)
        else {
            return Err(told(
                "is no full matrix of integers; a table of dofs is one".into(),
            ));
        };
        if !matches!(columns, 1 | 2) {
            return Err(told(format!(
                "{columns} columns; a table of dofs has one or two"
            )));
        }
        let values = integers(
            &mut numbers.stream(path, file),
            numbers.number,
            numbers.count(),
        )?;
        IntegerTable::of(columns, values, *along == Along::Columns).map_err(told)
    }
}

fn sparse(
    path: &Path,
    file: &Container,
    size: u32,
    along: Along,
    starts: &Numbers,
    entries: Option<&(Numbers, Numbers)>,
) -> Result<Content, Error> {
    let list = |numbers: &Numbers| {
        indices(
            &mut numbers.stream(path, file),
            numbers.number,
            numbers.count(),
        )
    };
    let places = match entries {
        Some((places, _)) => list(places)?,
        None => Vec::new(),
    };
    let pattern = Pattern::checked(along, size, list(starts)?, places);
    let place = entries.map_or(&starts.place, |(places, _)| &places.place);
    let pattern = pattern.map_err(|message| refused(path, place, message))?;
    match entries {
        Some((_, values)) if values.count() < pattern.len() => {
            let message = format!(
                "has {} numbers, but there are {} places",
                values.count(),
                pattern.len()
            );
            Err(refused(path, &values.place, message))
        }
        Some((_, values)) => pattern.with_values(&mut values.stream(path, file), values.number),
        None => Ok(Content::Entries(Vec::new())),
    }
}
