//! The component file: a meshio-compatible JSON mesh with one extra key, `component`.
//!
//! [`read_description`] checks everything that can be known before the matrices are: names, ids, sizes, axes, and that
//! points and dofs are both planar or both spatial. [`Description::dof_map`] then ties the matrix rows to the nodes.
//! `docs/component.md` describes the file, [`component_schema`] is its JSON schema.
//!
//! Left out: `point_data`, `cell_data`, `field_data` and `cell_sets` are skipped; whether the nodes of an interface
//! determine its frame is known only to the reduction.

mod comments;
mod diagnosis;
mod dofs;
mod file;
mod geometry;
mod interfaces;
mod lists;
mod stresses;
mod values;

use std::collections::BTreeMap;
use std::path::Path;

use crate::Error;
use crate::component::{
    ComponentFault, Damping, Interface, Units, check_label, check_units, fault,
};
use crate::mesh::{CellBlock, Direction, DofMap, MatrixRow, Mesh};
use crate::named::Object;
use crate::snapshot::read_small;
use dofs::Dofs;
use file::{CellPart, ComponentPart, DampingPart, FilePart, UnitsPart};
use lists::{Connectivity, PointSets, Points};
use values::{ModalDamping, Number, RayleighDamping};

pub use comments::without_comments;
pub use diagnosis::{json_error, listed, nearest_name, suggestion};
pub use stresses::StressRows;

/// The component file before the matrices are known.
#[derive(Clone, Debug, PartialEq)]
pub struct Description {
    /// Name of the component.
    pub name: String,
    /// Unit system.
    pub units: Units,
    /// Geometry.
    pub mesh: Mesh,
    /// Which dofs the nodes have.
    pub dofs: DofLayout,
    /// Requested interfaces, in row order.
    pub interfaces: Vec<Interface>,
    /// Rows of stress matrices.
    pub stresses: Vec<StressRows>,
    /// Damping.
    pub damping: Damping,
    /// SHA-256 of the file's bytes, hex.
    pub sha256: String,
    /// Notes for the reader of the file.
    pub notes: Vec<String>,
}

/// How the file says which matrix row is which dof.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum DofLayout {
    /// Every node has these directions, node after node.
    Pattern(Vec<Direction>),
    /// The owner of every matrix row.
    Table(Vec<MatrixRow>),
}

/// Reads and checks a component file.
///
/// # Errors
/// [`Error::Io`] if it can't be read, [`Error::File`] if it is empty, not UTF-8 or without `component`,
/// [`Error::Line`] with line and column where the JSON or a key is wrong,
/// [`Error::Location`] with the JSON path where a value doesn't fit the others.
pub fn read_description(path: &Path) -> Result<Description, Error> {
    let (file, sha256) = read_parts(path)?;
    checked(file, sha256).map_err(|fault| located(path, fault))
}

/// A JSON file of a mesh: a component file, or one without the key `component`.
#[derive(Clone, Debug, PartialEq)]
pub enum JsonMesh {
    /// With units, dofs, interfaces.
    Component(Box<Description>),
    /// The mesh alone.
    Alone {
        /// Geometry.
        mesh: Mesh,
        /// SHA-256 of the file's bytes, hex.
        sha256: String,
        /// Notes for the reader of the file.
        notes: Vec<String>,
    },
}

/// Reads a component file, or a mesh in its layout.
///
/// # Errors
/// As [`read_description`], but for a missing `component`.
pub fn read_json_mesh(path: &Path) -> Result<JsonMesh, Error> {
    let (file, sha256) = read_parts(path)?;
    let read = || {
        if file.component.is_some() {
            return Ok(JsonMesh::Component(Box::new(checked(file, sha256)?)));
        }
        check_format(file.format.as_deref(), file.version)?;
        let mut notes = Vec::new();
        let mesh = geometry::mesh_alone(file.points, file.cells, file.point_sets, &mut notes)?;
        Ok(JsonMesh::Alone {
            mesh,
            sha256,
            notes,
        })
    };
    read().map_err(|fault| located(path, fault))
}

/// A mesh in memory, as a component file has it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshArrays {
    /// Point after point, in component axes.
    pub coordinates: Vec<f64>,
    /// Coordinates of each point, 2 or 3.
    pub coordinate_count: usize,
    /// Cells in meshio's names and node order; may be empty.
    pub cells: Vec<CellBlock>,
    /// Named node sets.
    pub point_sets: BTreeMap<String, Vec<u32>>,
}

/// A component whose mesh is in memory. `text` is JSON, what a component file has under its key `component`; `path` stands for the file in errors.
/// The description has no digest.
///
/// # Errors
/// As [`read_description`], but for reading.
pub fn component_in_memory(
    text: &str,
    mesh: MeshArrays,
    path: &Path,
) -> Result<Description, Error> {
    let Object(component) = serde_json::from_str::<Object<ComponentPart>>(text)
        .map_err(|error| json_error(path, text.as_bytes(), &error, example_of))?;
    let points = Points {
        coordinates: mesh.coordinates,
        coordinate_count: mesh.coordinate_count,
    };
    let cells = mesh.cells.into_iter().map(|block| {
        Object(CellPart {
            cell_type: block.cell_type,
            data: Connectivity {
                nodes: block.nodes,
                nodes_per_cell: block.nodes_per_cell,
            },
        })
    });
    let cells = cells.collect();
    let sets = PointSets(mesh.point_sets);
    let mesh = |dofs: &DofLayout, notes: &mut Vec<String>| {
        geometry::mesh(points, cells, sets, dofs, notes)
    };
    described(component, mesh, &[], String::new()).map_err(|fault| located(path, fault))
}

/// The file as it stands on disk, and its digest.
fn read_parts(path: &Path) -> Result<(FilePart, String), Error> {
    let (bytes, sha256) = read_file(path)?;
    let text = &without_comments(json_text(path, &bytes)?, path)?;
    let Object(file) = serde_json::from_slice::<Object<FilePart>>(text)
        .map_err(|error| json_error(path, text, &error, example_of))?;
    Ok((file, sha256))
}

fn located(path: &Path, ComponentFault { place, message }: ComponentFault) -> Error {
    Error::Location {
        path: path.to_owned(),
        location: place.to_string(),
        message,
    }
}

impl Description {
    /// The dof of each of the `matrix_rows` rows; `path` is the component file, for the error.
    ///
    /// # Errors
    /// [`Error::Location`] with both numbers if the dofs of the file are not as many as the rows.
    pub fn dof_map(&self, matrix_rows: usize, path: &Path) -> Result<DofMap, Error> {
        let located = |message| Error::Location {
            path: path.to_owned(),
            location: "component.dofs".into(),
            message,
        };
        let node_count = self.mesh.node_count();
        let (dof_count, map) = match &self.dofs {
            DofLayout::Pattern(pattern) => (
                node_count * pattern.len(),
                DofMap::uniform(node_count, pattern),
            ),
            DofLayout::Table(table) => (table.len(), DofMap::new(table.clone(), node_count)),
        };
        if dof_count != matrix_rows {
            return Err(located(self.dof_count_mismatch(matrix_rows)));
        }
        map.map_err(|error| located(error.to_string()))
    }

    fn dof_count_mismatch(&self, rows: usize) -> String {
        let nodes = self.mesh.node_count();
        let pattern = match &self.dofs {
            DofLayout::Table(table) => {
                return format!(
                    "the matrix has {rows} rows, but the table lists {} dofs; it needs one entry [node, name] per row, [null, \"internal\"] for one of no node",
                    table.len()
                );
            }
            DofLayout::Pattern(pattern) => pattern,
        };
        let names: Vec<&str> = pattern.iter().map(|direction| direction.name()).collect();
        let remedy = match rows / nodes {
            fits @ (2 | 3 | 6) if rows.is_multiple_of(nodes) => {
                format!("{rows} = {nodes} nodes x {fits}, so another pattern may be meant, or another mesh")
            }
            _ => "if dofs were removed or nodes differ, give component.dofs as a table [[node, \"ux\"], ...] \
                  with one entry per row"
                .to_owned(),
        };
        format!(
            "the matrix has {rows} rows, but {nodes} nodes x {} dofs ({}) make {}; {remedy}",
            pattern.len(),
            names.join(" "),
            nodes * pattern.len()
        )
    }
}

/// JSON schema of the whole component file, mesh included.
pub fn component_schema() -> serde_json::Value {
    let mut schema = schemars::schema_for!(FilePart);
    schema.insert("title".into(), "Component description".into());
    schema.to_value()
}

/// Bytes of a component file: more than the largest mesh takes.
const LONGEST_FILE: u64 = 1 << 32;

const UNITS_EXAMPLE: &str = r#""units": {"length": "m", "mass": "kg", "time": "s"}"#;

fn example_of(field: &str) -> Option<&'static str> {
    Some(match field {
        "points" => r#""points": [[0, 0, 0], [1, 0, 0]]"#,
        "name" => r#""name": "connecting-rod""#,
        "units" => UNITS_EXAMPLE,
        "dofs" => r#""dofs": ["ux", "uy", "uz"]"#,
        "kind" => r#""kind": "average" (or "nodes", "rigid")"#,
        _ => return None,
    })
}

/// Bytes and SHA-256.
fn read_file(path: &Path) -> Result<(Vec<u8>, String), Error> {
    if path.is_dir() {
        return Err(Error::File {
            path: path.to_owned(),
            message: "is a folder; expected a component file (JSON)".into(),
        });
    }
    read_small(path, LONGEST_FILE)
}

/// The JSON text without a byte order mark.
fn json_text<'a>(path: &Path, bytes: &'a [u8]) -> Result<&'a [u8], Error> {
    let refuse = |message: &str| {
        Err(Error::File {
            path: path.to_owned(),
            message: message.to_owned(),
        })
    };
    let text = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
    if text.starts_with(b"\xff\xfe") || text.starts_with(b"\xfe\xff") {
        return refuse("is UTF-16; save it as UTF-8");
    }
    if text.starts_with(b"\x1f\x8b") {
        return refuse("is gzip-compressed; expected plain JSON");
    }
    if text.iter().all(u8::is_ascii_whitespace) {
        return refuse("is empty; expected a JSON object with `points`, `cells` and `component`");
    }
    Ok(text)
}

fn checked(file: FilePart, sha256: String) -> Result<Description, ComponentFault> {
    check_format(file.format.as_deref(), file.version)?;
    let Some(Object(component)) = file.component else {
        return Err(fault(
            "component",
            format!(
                "is missing; a mesh alone doesn't say its units and dofs. Add for example \"component\": {{\"name\": \"part\", \
                 {UNITS_EXAMPLE}, \"dofs\": [\"ux\", \"uy\", \"uz\"], \
                 \"interfaces\": [{{\"name\": \"hub\", \"nodes\": [0], \"kind\": \"nodes\"}}]}}"
            ),
        ));
    };
    let FilePart {
        points,
        cells,
        point_sets,
        cell_sets,
        ..
    } = file;
    let mesh = |dofs: &DofLayout, notes: &mut Vec<String>| {
        geometry::mesh(points, cells, point_sets, dofs, notes)
    };
    described(component, mesh, &cell_sets.0, sha256)
}

/// A component whose mesh is made once its dofs are known.
fn described(
    component: ComponentPart,
    mesh: impl FnOnce(&DofLayout, &mut Vec<String>) -> Result<Mesh, ComponentFault>,
    cell_sets: &[String],
    sha256: String,
) -> Result<Description, ComponentFault> {
    let ComponentPart {
        name,
        units: Object(units),
        dofs: Dofs(dofs),
        interfaces,
        stresses,
        damping,
    } = component;
    let mut notes = Vec::new();
    check_label("component.name", &name)?;
    let UnitsPart { length, mass, time } = units;
    let units = Units { length, mass, time };
    check_units(&units)?;
    let mesh = mesh(&dofs, &mut notes)?;
    let interfaces = interfaces::interfaces(interfaces, &mesh, &dofs, cell_sets, &mut notes)?;
    let stresses = stresses::stresses(stresses, &mesh)?;
    let damping = match damping {
        Some(Object(damping)) => checked_damping(damping, &mut notes)?,
        None => Damping::None,
    };
    Ok(Description {
        name,
        units,
        mesh,
        dofs,
        interfaces,
        stresses,
        damping,
        sha256,
        notes,
    })
}

fn check_format(format: Option<&str>, version: Option<Number>) -> Result<(), ComponentFault> {
    match format {
        None | Some("meshio-json") => {}
        Some(other) => {
            return Err(fault(
                "format",
                format!("found \"{other}\", expected \"meshio-json\" or no format"),
            ));
        }
    }
    match version {
        None | Some(Number(1.0)) => Ok(()),
        Some(Number(other)) => Err(fault(
            "version",
            format!("found {other}, but only version 1 is known"),
        )),
    }
}

fn checked_damping(
    damping: DampingPart,
    notes: &mut Vec<String>,
) -> Result<Damping, ComponentFault> {
    let damping = match (damping.modal, damping.rayleigh) {
        (Some(ModalDamping::Uniform(ratio)), None) => Damping::Uniform(ratio),
        (Some(ModalDamping::PerMode(ratios)), None) => Damping::PerMode(ratios),
        (None, Some(rayleigh)) => {
            let [alpha, beta] = rayleigh_factors(rayleigh)?;
            Damping::Rayleigh { alpha, beta }
        }
        (modal, _) => {
            let found = if modal.is_some() {
                "has both `modal` and `rayleigh`"
            } else {
                "is empty"
            };
            return Err(fault(
                "component.damping",
                format!(
                    "{found}; expected one of {{\"modal\": 0.01}}, {{\"rayleigh\": [alpha, beta]}} and {{\"rayleigh\": {{\"frequencies\": [f1, f2], \"ratios\": [z1, z2]}}}}"
                ),
            ));
        }
    };
    damping.check()?;
    notes.extend(damping.above_critical());
    Ok(damping)
}

/// `[alpha, beta]`.
fn rayleigh_factors(rayleigh: RayleighDamping) -> Result<[f64; 2], ComponentFault> {
    const RAYLEIGH: &str = "component.damping.rayleigh";
    match rayleigh {
        RayleighDamping::Factors(factors) => factors.as_slice().try_into().map_err(|_| {
            let found = factors.len();
            fault(
                RAYLEIGH,
                format!("has {found} numbers, expected 2: [alpha, beta]"),
            )
        }),
        RayleighDamping::Through(points) => {
            let two = |key: &str, numbers: &[Number]| match numbers {
                [Number(first), Number(second)] => Ok([*first, *second]),
                _ => Err(fault(
                    format!("{RAYLEIGH}.{key}"),
                    format!("has {} numbers, expected 2", numbers.len()),
                )),
            };
            let frequencies = two("frequencies", &points.frequencies)?;
            let ratios = two("ratios", &points.ratios)?;
            Damping::rayleigh_through(frequencies, ratios)
                .map_err(|message| fault(RAYLEIGH, message))
        }
    }
}
