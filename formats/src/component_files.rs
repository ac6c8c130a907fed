//! A component from its files: the stiffness matrix, and beside it the mass matrix, the description and what else there is.
//!
//! `part.mtx` (or `part.mtx.gz`) is the stiffness; `part.mass.mtx`, `part.json` and the optional `part.boundary.mtx` and
//! `part.mass.xx.mtx` …, `part.load.NAME.mtx`, `part.stress.NAME.mtx`, `part.stiffening.xx.mtx` … are found beside it, with or without `.gz`, unless named otherwise.

mod component_masses;
mod loads_and_stiffening;
mod sources;
mod stresses;
mod write;

use std::path::{Path, PathBuf};

pub use write::{write_component, write_description};

use component_masses::read_component_masses;
use loads_and_stiffening::{named_siblings, read_loads, read_stiffening};
use stresses::read_stresses;

use crate::component::{
    Component, ComponentDraft, ComponentFault, ComponentMasses, GeometricStiffness, Place, Source,
    asymmetry_note,
};
use crate::description::read_description;
use crate::error::Error;
use crate::matrix::{MatrixReader, MatrixReport, check_operator_header};
use crate::mesh::Dimension;

/// The least that a component description says: a mesh as meshio-json and the section `component`.
const TEMPLATE: &str = r#"{"format": "meshio-json", "version": 1, "points": [[0, 0, 0], [1, 0, 0]], "component": {"name": "part", "units": {"length": "m", "mass": "kg", "time": "s"}, "dofs": ["ux", "uy", "uz", "rx", "ry", "rz"], "interfaces": [{"name": "base", "nodes": [0], "kind": "nodes"}, {"name": "tip", "nodes": [1], "kind": "nodes"}]}}"#;

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
    /// Stress and strain matrices, by name.
    pub stresses: Vec<(String, PathBuf)>,
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

/// `PATH/part.mass.mtx` of `PATH/part` and `.mass.mtx`: nothing of the stem counts as an ending of it.
pub fn with_ending(stem: &Path, ending: &str) -> PathBuf {
    let mut name = stem.as_os_str().to_owned();
    name.push(ending);
    PathBuf::from(name)
}

/// `stem` + `ending`, or that + `.gz`, whichever exists; the plain one if neither does.
fn sibling(stem: &Path, ending: &str) -> PathBuf {
    let (plain, packed) = (
        with_ending(stem, ending),
        with_ending(stem, &format!("{ending}.gz")),
    );
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
                None if option == "--mesh" => format!(
                    "`reduce init MESH` drafts it from a mesh; or put it beside the stiffness matrix, or name another file with {option}. At least: {TEMPLATE}"
                ),
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
            stresses: named_siblings(stiffness, ".stress.")?,
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
    let dofs = description.dof_map(stiffness.nrows(), &files.description)?;
    let mut draft = ComponentDraft {
        interfaces: description.interfaces,
        damping: description.damping,
        notes: description.notes,
        ..ComponentDraft::new(
            &description.name,
            description.units,
            (description.mesh, dofs),
            stiffness,
            mass,
        )
    };
    draft.took("stiffness", &stiffness_report);
    draft.took("mass", &mass_report);
    draft.sources.push(Source {
        role: "mesh".into(),
        file_name: file_name(&files.description),
        sha256: description.sha256,
    });
    read_component_masses(files, &mut reader, &mut draft)?;
    if let Some(path) = &files.boundary {
        let (matrix, report) = reader.read_matrix(path)?;
        draft.took("boundary", &report);
        draft.explicit_boundary = Some(matrix);
    }
    read_loads(&files.loads, &mut reader, &mut draft)?;
    read_stresses(files, description.stresses, &mut reader, &mut draft)?;
    read_stiffening(&files.stiffening, &mut reader, &mut draft)?;
    let dimension = draft.dimension();
    Component::of_operators(draft).map_err(|fault| files.fault(fault, dimension))
}

impl ComponentFiles {
    /// A fault of the component as one of the file that it is in.
    fn fault(&self, fault: ComponentFault, dimension: Dimension) -> Error {
        let ComponentFault { place, message } = fault;
        let products = GeometricStiffness::spin_products(dimension);
        let mut stiffening = self.stiffening.iter();
        let path = match place {
            Place::Description(location) => {
                return Error::Location {
                    path: self.description.clone(),
                    location,
                    message,
                };
            }
            Place::Stiffness => Some(self.stiffness.clone()),
            Place::Mass => Some(self.mass.clone()),
            Place::Boundary => self.boundary.clone(),
            Place::ComponentMass(index) => {
                let names = ComponentMasses::names(dimension);
                self.component_masses(names).into_iter().nth(index)
            }
            Place::Load(index) => path_of(self.loads.get(index)),
            Place::Stress(index) => path_of(self.stresses.get(index)),
            Place::SpinStiffness(index) => {
                let product = products.get(index).copied();
                path_of(stiffening.find(|(name, _)| Some(name.as_str()) == product))
            }
            Place::RowStiffness(index) => path_of(
                stiffening
                    .filter(|(name, _)| !products.contains(&name.as_str()))
                    .nth(index),
            ),
        };
        Error::File {
            path: path.unwrap_or_else(|| self.stiffness.clone()),
            message,
        }
    }
}

impl ComponentDraft {
    /// Notes where a matrix came from, and its repairs.
    fn took(&mut self, role: &str, report: &MatrixReport) {
        let name = &report.file_name;
        self.sources.push(Source {
            role: role.into(),
            file_name: name.clone(),
            sha256: report.sha256.clone(),
        });
        if report.duplicates_summed > 0 {
            self.notes.push(format!(
                "{name}: {} repeated entries were summed",
                report.duplicates_summed
            ));
        }
        self.notes
            .extend(asymmetry_note(name, report.largest_asymmetry));
    }
}

fn path_of(named: Option<&(String, PathBuf)>) -> Option<PathBuf> {
    named.map(|(_, path)| path.clone())
}

fn file_name(path: &Path) -> String {
    path.file_name()
        .map(|name| name.to_string_lossy().into_owned())
        .unwrap_or_default()
}
