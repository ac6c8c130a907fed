//! MATLAB files of version 7.3 (`save -v7.3`), which are HDF5 behind a block of text, and matrices in HDF5 files of other programs.
//!
//! A sparse matrix is a group with `data`, `ir` and `jc`, compressed columns; Python programs write such groups with `data`, `indices` and
//! `indptr`, compressed rows. A full matrix is a dataset, in MATLAB's files its transpose. Structures are groups: `/` in names.

mod dataset;

use std::collections::HashMap;
use std::fs::File;
use std::path::Path;

use dcb_formats::Error;
use dcb_formats::hdf5_files::container::{Container, on_large_stack};
use dcb_formats::terminal::shortened;
use hdf5_pure::{AttrValue, Dataset, Group};

use self::dataset::Numbers;
use crate::binary::file::regular;
use crate::binary::hashed::hashed;
use crate::matrix::labels::{DOF_REF, IntegerTable};
use crate::matrix::storage::collected::{obstacle_of_shape, square};
use crate::matrix::storage::compressed::{Along, Pattern};
use crate::matrix::storage::dense::dense;
use crate::matrix::storage::stream::{indices, integers};
use crate::stored::{Content, Listed, Reading, Rows, StoredMatrix, Triangles};

/// Groups in groups, at most.
const DEEPEST: usize = 6;
/// Objects of a file, at most.
const MOST_OBJECTS: usize = 100_000;
/// Groups in which MATLAB keeps what other variables refer to.
const HIDDEN: [&str; 2] = ["#refs#", "#subsystem#"];
/// Names of the pieces of a sparse matrix: values, places, starts.
const PIECES: [([&str; 3], Along); 2] = [
    (["data", "ir", "jc"], Along::Columns),
    (["data", "indices", "indptr"], Along::Rows),
];

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

/// An array or matrix of a file.
#[derive(Debug)]
struct Found {
    name: String,
    /// Rows and columns, where there are two axes.
    shape: Option<(u64, u64)>,
    obstacle: Option<String>,
    storage: Storage,
}

#[derive(Debug)]
enum Storage {
    /// What can't be read.
    None,
    Dense {
        numbers: Numbers,
        along: Along,
    },
    /// Values and places are missing where there are none.
    Sparse {
        along: Along,
        starts: Numbers,
        entries: Option<Box<(Numbers, Numbers)>>,
    },
}

/// All arrays and matrices of a file.
fn objects(path: &Path, file: &Container) -> Result<Vec<Found>, Error> {
    let root = file.root();
    let attributes = attributes(&root);
    if let Some(format) =
        text(&attributes, "format").filter(|_| attributes.contains_key("format_version"))
    {
        return Err(Error::File {
            path: path.into(),
            message: format!(
                "is a file of this project ({}), not of another program; `inspect` and `simulate` take it",
                shortened(&format)
            ),
        });
    }
    let mut walk = Walk {
        path,
        file,
        objects: 0,
        found: Vec::new(),
    };
    walk.group(&root, "", 0)?;
    Ok(walk.found)
}

/// Attributes that can be read.
fn attributes(group: &Group) -> HashMap<String, AttrValue> {
    group.attrs().unwrap_or_default()
}

fn text(attributes: &HashMap<String, AttrValue>, name: &str) -> Option<String> {
    let value = attributes.get(name)?;
    Some(value.as_str()?.trim_end_matches('\0').to_owned())
}

struct Walk<'a> {
    path: &'a Path,
    file: &'a Container,
    objects: usize,
    found: Vec<Found>,
}

impl Walk<'_> {
    /// Visits a group; its name is empty for the root.
    fn group(&mut self, group: &Group, name: &str, depth: usize) -> Result<(), Error> {
        let told = |message: String| refused(self.path, &format!("/{name}"), message);
        let unreadable = |error: hdf5_pure::Error| told(format!("can't be read: {error}"));
        let datasets: Vec<(String, Dataset)> = group.iter_datasets().map_err(unreadable)?.collect();
        let groups: Vec<(String, Group)> = group.iter_groups().map_err(unreadable)?.collect();
        self.objects += datasets.len() + groups.len();
        if depth > DEEPEST || self.objects > MOST_OBJECTS {
            return Err(told(format!(
                "is more than {DEEPEST} groups deep, or the file has more than {MOST_OBJECTS} objects"
            )));
        }
        let pieces = PIECES
            .iter()
            .find(|(pieces, _)| datasets.iter().any(|(found, _)| found == pieces[2]));
        if let Some((pieces, along)) = pieces {
            let found = self.sparse(group, name, datasets, *pieces, *along)?;
            self.found.push(found);
            return Ok(());
        }
        let within = |member: &str| match name {
            "" => member.to_owned(),
            _ => format!("{name}/{member}"),
        };
        for (member, dataset) in datasets {
            let found = dense_of(dataset, within(&member), self.file);
            self.found.extend(found);
        }
        for (member, group) in groups {
            if !HIDDEN.contains(&member.as_str()) {
                self.group(&group, &within(&member), depth + 1)?;
            }
        }
        Ok(())
    }

    fn sparse(
        &self,
        group: &Group,
        name: &str,
        datasets: Vec<(String, Dataset)>,
        pieces: [&str; 3],
        along: Along,
    ) -> Result<Found, Error> {
        let mut parts = pieces.map(|_| None);
        let mut obstacle = None;
        for (member, dataset) in datasets {
            let Some(at) = pieces.iter().position(|piece| *piece == member) else {
                continue;
            };
            match Numbers::of(dataset, format!("/{name}/{member}"), self.file) {
                Ok(numbers) if numbers.shape().len() == 1 => parts[at] = Some(numbers),
                Ok(_) => obstacle = Some(format!("with {member} of several axes")),
                Err(message) => obstacle = Some(message),
            }
        }
        let attributes = attributes(group);
        if text(&attributes, "MATLAB_class").as_deref() == Some("logical") {
            obstacle = Some("logical".into());
        }
        let [values, places, starts] = parts;
        let lines = starts
            .as_ref()
            .map_or(0, |starts| starts.count().saturating_sub(1));
        let across = match attributes.get("MATLAB_sparse") {
            Some(rows) => rows
                .as_i64()
                .and_then(|rows| u64::try_from(rows).ok())
                .ok_or_else(|| {
                    refused(
                        self.path,
                        name,
                        "attribute MATLAB_sparse is no number of rows".into(),
                    )
                })?,
            None => lines,
        };
        let shape = match along {
            Along::Columns => (across, lines),
            Along::Rows => (lines, across),
        };
        let storage = match (starts, places, values) {
            _ if obstacle.is_some() => Storage::None,
            (Some(starts), Some(places), Some(values)) => Storage::Sparse {
                along,
                starts,
                entries: Some(Box::new((places, values))),
            },
            (Some(starts), None, None) => Storage::Sparse {
                along,
                starts,
                entries: None,
            },
            _ => {
                return Err(refused(
                    self.path,
                    name,
                    format!("has not all of {}", pieces.join(", ")),
                ));
            }
        };
        Ok(Found {
            name: name.into(),
            shape: Some(shape),
            obstacle: obstacle.or_else(|| obstacle_of_shape(shape.0, shape.1)),
            storage,
        })
    }
}

/// A full matrix or another array of numbers; `None` for text, what is empty and what has no axes.
fn dense_of(dataset: Dataset, name: String, file: &Container) -> Option<Found> {
    let attributes = dataset.attrs().unwrap_or_default();
    let class = text(&attributes, "MATLAB_class");
    let shape = dataset.shape().ok()?;
    if attributes.contains_key("MATLAB_empty")
        || class.as_deref() == Some("char")
        || shape.is_empty()
    {
        return None;
    }
    let (shape, along) = match (shape[..].len(), &class) {
        (2, Some(_)) => (Some((shape[1], shape[0])), Along::Columns),
        (2, None) => (Some((shape[0], shape[1])), Along::Rows),
        (1, _) => (Some((shape[0], 1)), Along::Columns),
        _ => (None, Along::Rows),
    };
    let (storage, obstacle) = match Numbers::of(dataset, format!("/{name}"), file) {
        _ if class.as_deref() == Some("logical") => (Storage::None, Some("logical".into())),
        Ok(numbers) => {
            let obstacle = match shape {
                Some((rows, columns)) => obstacle_of_shape(rows, columns),
                None => Some(format!("{} dimensions", numbers.shape().len())),
            };
            (Storage::Dense { numbers, along }, obstacle)
        }
        Err(message) => (Storage::None, Some(message)),
    };
    Some(Found {
        name,
        shape,
        obstacle,
        storage,
    })
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
            name: self.name.clone(),
            size: size as usize,
            triangles: Triangles::Unsaid,
            content,
            rows: Rows::Unlabelled,
            digits: None,
            notes: Vec::new(),
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
