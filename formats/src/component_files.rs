//! A component from its files: the stiffness matrix, and beside it the mass matrix, the description and what else there is.
//!
//! `part.mtx` (or `part.mtx.gz`) is the stiffness; `part.mass.mtx`, `part.json` and the optional `part.boundary.mtx` and
//! `part.mass.xx.mtx` …, `part.load.NAME.mtx`, `part.stiffening.xx.mtx` … are found beside it, with or without `.gz`, unless named otherwise.

mod component_masses;
mod loads_and_stiffening;
mod mass_moments;
mod sources;

use std::path::{Path, PathBuf};

use component_masses::{Operators, read_component_masses};
use loads_and_stiffening::{named_siblings, read_loads, read_stiffening};

use crate::SparseMatrix;
use crate::component::{Component, Source};
use crate::description::read_description;
use crate::error::Error;
use crate::matrix::{MatrixReader, MatrixReport, check_operator_header};

/// Component masses in stored order.
const SPATIAL_MASSES: [&str; 6] = ["xx", "yy", "zz", "xy", "yz", "zx"];

/// Where a component's files are.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ComponentFiles {
    /// K_ee.
    pub stiffness: PathBuf,
    /// M_ee.
    pub mass: PathBuf,
    /// Description.
    pub description: PathBuf,
    /// L_b, if given or found.
    pub boundary: Option<PathBuf>,
    /// Loads inside the component, by name.
    pub loads: Vec<(String, PathBuf)>,
    /// Geometric stiffness, by what the prestress comes from.
    pub stiffening: Vec<(String, PathBuf)>,
}

/// Locations that override the siblings of the stiffness file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Overrides {
    /// Mass matrix.
    pub mass: Option<PathBuf>,
    /// Description.
    pub description: Option<PathBuf>,
    /// Boundary localization.
    pub boundary: Option<PathBuf>,
}

/// `part` of `PATH/part.mtx` and `PATH/part.mtx.gz`, with its folder.
pub fn stem(stiffness: &Path) -> PathBuf {
    let without = |path: PathBuf, extension: &str| match path.extension() {
        Some(found) if found == extension => path.with_extension(""),
        _ => path,
    };
    without(without(stiffness.to_path_buf(), "gz"), "mtx")
}

/// `stem` + `ending`, or that + `.gz`, whichever exists; the plain one if neither does.
fn sibling(stem: &Path, ending: &str) -> PathBuf {
    let with = |ending: &str| {
        let mut name = stem.as_os_str().to_owned();
        name.push(ending);
        PathBuf::from(name)
    };
    let (plain, packed) = (with(ending), with(&format!("{ending}.gz")));
    if !plain.exists() && packed.exists() {
        packed
    } else {
        plain
    }
}

impl ComponentFiles {
    /// Finds the files beside the stiffness matrix.
    ///
    /// # Errors
    /// [`Error::File`] naming a missing file and the option that points elsewhere; before that, what shows at the beginning
    /// of a file that can't be a stiffness matrix at all.
    pub fn beside(stiffness: &Path, overrides: &Overrides) -> Result<Self, Error> {
        let stem = stem(stiffness);
        if stiffness.is_dir() {
            let message =
                "is a folder; name the stiffness matrix in it, PART.mtx or PART.mtx.gz".into();
            return Err(Error::File {
                path: stiffness.to_path_buf(),
                message,
            });
        }
        if !stiffness.exists() {
            return Err(missing(
                stiffness,
                "the stiffness matrix",
                "expected PART.mtx or PART.mtx.gz",
            ));
        }
        let required = |given: &Option<PathBuf>, ending: &str, what: &str, option: &str| {
            let path = given.clone().unwrap_or_else(|| sibling(&stem, ending));
            let hint = match given {
                Some(_) => format!("{option} must name an existing file"),
                None => format!(
                    "put it beside the stiffness matrix, or name another file with {option}"
                ),
            };
            if path.exists() {
                return Ok(path);
            }
            check_operator_header(stiffness)?;
            Err(missing(&path, what, &hint))
        };
        let mass = required(&overrides.mass, ".mass.mtx", "the mass matrix", "--mass")?;
        let description = required(
            &overrides.description,
            ".json",
            "the component description",
            "--mesh",
        )?;
        let boundary = match &overrides.boundary {
            Some(path) if !path.exists() => {
                return Err(missing(
                    path,
                    "the boundary localization",
                    "--boundary must name an existing file",
                ));
            }
            Some(path) => Some(path.clone()),
            None => Some(sibling(&stem, ".boundary.mtx")).filter(|path| path.exists()),
        };
        Ok(Self {
            stiffness: stiffness.to_path_buf(),
            mass,
            description,
            boundary,
            loads: named_siblings(stiffness, ".load.")?,
            stiffening: named_siblings(stiffness, ".stiffening.")?,
        })
    }

    /// Every file that is read, the component masses where they are there.
    pub fn all(&self) -> Vec<PathBuf> {
        self.by_role().into_iter().map(|(_, path)| path).collect()
    }

    fn component_masses(&self, names: &[&str]) -> Vec<PathBuf> {
        let stem = stem(&self.stiffness);
        names
            .iter()
            .map(|name| sibling(&stem, &format!(".mass.{name}.mtx")))
            .collect()
    }
}

fn missing(path: &Path, what: &str, hint: &str) -> Error {
    Error::File {
        path: path.to_path_buf(),
        message: format!("{what} is not there; {hint}"),
    }
}

/// Reads and cross-checks a component, in so many bytes of memory if there is a limit.
///
/// # Errors
/// The first thing that is wrong, with the file and the place in it; [`Error::NotEnoughMemory`].
pub fn read_component(files: &ComponentFiles, memory: Option<u64>) -> Result<Component, Error> {
    let mut reader = MatrixReader::new(memory);
    // The description first: it is small, and most mistakes are in it.
    let description = read_description(&files.description)?;
    let (stiffness, stiffness_report) = reader.read_symmetric_operator(&files.stiffness)?;
    let (mass, mass_report) = reader.read_symmetric_operator(&files.mass)?;
    if mass.nrows() != stiffness.nrows() {
        return Err(Error::Mismatch {
            message: format!(
                "{} is {} x {} but {} is {} x {}: stiffness and mass must be of one model",
                files.stiffness.display(),
                stiffness.nrows(),
                stiffness.ncols(),
                files.mass.display(),
                mass.nrows(),
                mass.ncols()
            ),
        });
    }
    let n_e = stiffness.nrows();
    let dofs = description.dof_map(n_e, &files.description)?;
    let mut sources = vec![
        source("stiffness", &stiffness_report),
        source("mass", &mass_report),
        Source {
            role: "mesh".into(),
            file_name: file_name(&files.description),
            sha256: description.sha256.clone(),
        },
    ];
    let mut notes = description.notes.clone();
    note_repairs(&stiffness_report, &mut notes);
    note_repairs(&mass_report, &mut notes);

    let component_masses = read_component_masses(
        files,
        &mut reader,
        Operators {
            mass: &mass,
            stiffness: &stiffness,
            mesh: &description.mesh,
            dofs: &dofs,
        },
        &mut sources,
    )?;
    let boundary = files.boundary.as_ref();
    let explicit_boundary = boundary
        .map(|path| read_boundary(path, &mut reader, n_e, &mut sources, &mut notes))
        .transpose()?;
    let loads = read_loads(&files.loads, &mut reader, n_e, &mut sources)?;
    let geometric_stiffness = read_stiffening(
        &files.stiffening,
        &mut reader,
        (n_e, description.mesh.dimension),
        &description.interfaces,
        &mut sources,
        &mut notes,
    )?;
    Ok(Component {
        name: description.name,
        units: description.units,
        mesh: description.mesh,
        dofs,
        stiffness,
        mass,
        component_masses,
        interfaces: description.interfaces,
        explicit_boundary,
        loads,
        geometric_stiffness,
        damping: description.damping,
        sources,
        notes,
    })
}

/// Reads L_b as a matrix.
fn read_boundary(
    path: &Path,
    reader: &mut MatrixReader,
    n_e: usize,
    sources: &mut Vec<Source>,
    notes: &mut Vec<String>,
) -> Result<SparseMatrix, Error> {
    let (matrix, report) = reader.read_matrix(path)?;
    let wrong = |message: String| {
        Err(Error::File {
            path: path.to_owned(),
            message,
        })
    };
    if matrix.ncols() != n_e {
        return wrong(format!(
            "{} columns, but the component has {n_e} dofs; a boundary localization is n_b x n_e",
            matrix.ncols()
        ));
    }
    let values = matrix.as_ref().val();
    if let Some(row) = values.iter().position(|value| !value.is_finite()) {
        return wrong(format!("entry {row} is not finite"));
    }
    sources.push(source("boundary", &report));
    note_repairs(&report, notes);
    Ok(matrix)
}

fn file_name(path: &Path) -> String {
    path.file_name()
        .map(|name| name.to_string_lossy().into_owned())
        .unwrap_or_default()
}

fn source(role: &str, report: &MatrixReport) -> Source {
    Source {
        role: role.into(),
        file_name: report.file_name.clone(),
        sha256: report.sha256.clone(),
    }
}

fn note_repairs(report: &MatrixReport, notes: &mut Vec<String>) {
    let name = &report.file_name;
    if report.duplicates_summed > 0 {
        notes.push(format!(
            "{name}: {} repeated entries were summed",
            report.duplicates_summed
        ));
    }
    if report.largest_asymmetry > 0.0 {
        notes.push(format!(
            "{name}: asymmetry of up to {:.1e} was averaged away",
            report.largest_asymmetry
        ));
    }
}
