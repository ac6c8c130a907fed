//! The arrays and matrices among the groups and datasets of a file.

use std::collections::HashMap;
use std::path::Path;

use dcb_formats::Error;
use dcb_formats::hdf5_files::container::Container;
use dcb_formats::terminal::shortened;
use hdf5_pure::{AttrValue, Dataset, Group};

use super::dataset::Numbers;
use super::refused;
use crate::matrix::storage::collected::obstacle_of_shape;
use crate::matrix::storage::compressed::Along;

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

/// An array or matrix of a file.
#[derive(Debug)]
pub(super) struct Found {
    pub(super) name: String,
    /// Rows and columns, where there are two axes.
    pub(super) shape: Option<(u64, u64)>,
    pub(super) obstacle: Option<String>,
    pub(super) storage: Storage,
}

/// Storage of an array or matrix.
#[derive(Debug)]
pub(super) enum Storage {
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

impl Storage {
    /// Significant digits of the values, where there are fewer than a result needs.
    pub(super) fn digits(&self) -> Option<u32> {
        match self {
            Self::Dense { numbers, .. } => numbers.number.digits(),
            Self::Sparse { entries, .. } => entries.as_ref()?.1.number.digits(),
            Self::None => None,
        }
    }
}

/// All arrays and matrices of a file.
pub(super) fn objects(path: &Path, file: &Container) -> Result<Vec<Found>, Error> {
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
