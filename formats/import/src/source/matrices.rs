//! Stiffness and mass as their files store them.

use std::path::{Path, PathBuf};

use dcb_formats::Error;
use dcb_formats::component::Source;

use crate::source::choice::{chosen, mass_of};
use crate::source::matrix_file::MatrixFile;
use crate::source::named_file::NamedFile;
use crate::source::partner::mass_file;
use crate::stored::StoredMatrix;

/// A matrix with the file that it comes from.
pub(crate) struct Sourced {
    pub matrix: StoredMatrix,
    pub path: PathBuf,
    pub format: &'static str,
}

/// Stiffness and mass.
pub(crate) struct SourceMatrices {
    pub stiffness: Sourced,
    pub mass: Sourced,
    pub sources: Vec<Source>,
    pub notes: Vec<String>,
}

/// Where the mass is, if it isn't named: in the stiffness's own file, or in a file beside it that is named like it.
pub fn mass_beside(stiffness: &NamedFile) -> Result<Option<NamedFile>, Error> {
    let file = MatrixFile::open(&stiffness.path)?;
    let own = chosen(&file, stiffness.name.as_deref())?;
    Ok(partner(&file, own, &stiffness.path))
}

/// The mass in the stiffness's own file, or in one beside it.
fn partner(file: &MatrixFile, stiffness: usize, path: &Path) -> Option<NamedFile> {
    match mass_of(file, stiffness) {
        Some(mass) => Some(NamedFile {
            path: path.to_path_buf(),
            name: Some(name_or_number(file, mass)),
        }),
        None => mass_file(path).map(|path| NamedFile::only(&path)),
    }
}

fn name_or_number(file: &MatrixFile, at: usize) -> String {
    match file.listed()[at].name.as_str() {
        "" => (at + 1).to_string(),
        name => name.to_owned(),
    }
}

impl SourceMatrices {
    /// Finds and reads both; a file that has both is read once.
    ///
    /// # Errors
    /// What is wrong with the files, or which one is missing.
    pub fn read(stiffness: &NamedFile, mass: Option<&NamedFile>) -> Result<Self, Error> {
        let file = MatrixFile::open(&stiffness.path)?;
        let own = chosen(&file, stiffness.name.as_deref())?;
        let mut notes: Vec<String> = file.misleading_name().into_iter().collect();
        let mass = match mass {
            Some(mass) => mass.clone(),
            None => {
                let found = partner(&file, own, &stiffness.path).ok_or_else(|| no_mass(&file))?;
                notes.push(match found.path == stiffness.path {
                    true => format!(
                        "mass: {} of the same file",
                        found.name.as_deref().unwrap_or_default()
                    ),
                    false => format!(
                        "mass: {}, found by the name of the stiffness",
                        file_name(&found.path)
                    ),
                });
                found
            }
        };
        if is_same(&mass.path, &stiffness.path) {
            let partner = match &mass.name {
                Some(name) => chosen(&file, Some(name))?,
                None => mass_of(&file, own).unwrap_or(own),
            };
            if partner == own {
                return Err(
                    file.refused("stiffness and mass are the same matrix; name both, FILE#NAME")
                );
            }
            let reading = file.read(&[own, partner])?;
            let sources = vec![
                source("stiffness", &stiffness.path, &reading.sha256),
                source("mass", &stiffness.path, &reading.sha256),
            ];
            let of_file = |matrix| Sourced {
                matrix,
                path: stiffness.path.clone(),
                format: file.format_name(),
            };
            let mut both = reading.matrices.into_iter();
            let (Some(stiffness), Some(mass)) = (both.next(), both.next()) else {
                return Err(file.refused("the matrices that it lists can't be found again"));
            };
            return Ok(Self {
                stiffness: of_file(stiffness),
                mass: of_file(mass),
                sources,
                notes,
            });
        }
        let (stiffness_matrix, stiffness_source) = one(&file, own, "stiffness", &stiffness.path)?;
        let mass_file = MatrixFile::open(&mass.path)?;
        notes.extend(mass_file.misleading_name());
        let partner = match mass.name.as_deref() {
            None => only_mass(&mass_file)?,
            name => chosen(&mass_file, name)?,
        };
        let (mass_matrix, mass_source) = one(&mass_file, partner, "mass", &mass.path)?;
        Ok(Self {
            stiffness: stiffness_matrix,
            mass: mass_matrix,
            sources: vec![stiffness_source, mass_source],
            notes,
        })
    }
}

/// The mass in a file of its own: the mass of its only pair, or its only matrix.
fn only_mass(file: &MatrixFile) -> Result<usize, Error> {
    let first = chosen(file, None)?;
    Ok(mass_of(file, first).unwrap_or(first))
}

fn one(
    file: &MatrixFile,
    number: usize,
    role: &str,
    path: &Path,
) -> Result<(Sourced, Source), Error> {
    let reading = file.read(&[number])?;
    let source = source(role, path, &reading.sha256);
    let matrix = reading.matrices.into_iter().next();
    let matrix =
        matrix.ok_or_else(|| file.refused("the matrix that it lists can't be found again"))?;
    let sourced = Sourced {
        matrix,
        path: path.to_path_buf(),
        format: file.format_name(),
    };
    Ok((sourced, source))
}

fn no_mass(file: &MatrixFile) -> Error {
    file.refused(format!(
        "is a stiffness ({}) without a mass: neither this file nor one beside it has the mass that goes with it; name it: `reduce import STIFFNESS MASS`, `reduce STIFFNESS --mass MASS`",
        file.format_name()
    ))
}

/// A file in its use.
pub(crate) fn source(role: &str, path: &Path, sha256: &str) -> Source {
    Source {
        role: role.to_owned(),
        file_name: file_name(path),
        sha256: sha256.to_owned(),
    }
}

/// Name without its folder.
pub(crate) fn file_name(path: &Path) -> String {
    let name = path.file_name().unwrap_or_default();
    name.to_string_lossy().into_owned()
}

fn is_same(a: &Path, b: &Path) -> bool {
    a == b || dcb_formats::output::is_same_file(a, b)
}
