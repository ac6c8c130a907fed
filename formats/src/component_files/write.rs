//! Writing a component as the files `reduce` reads: Matrix Market matrices and the mesh JSON with its `component` key.
//!
//! Numbers are the shortest decimals that read back to the same bits (at most 17 significant digits). Every file is
//! written whole or not at all.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use rayon::prelude::*;
use serde_json::{Map, Value, json};

use super::with_ending;
use crate::component::{
    ComponentDraft, ComponentMasses, Damping, GeometricStiffness, Interface, NamedStress, Role,
    Weights,
};
use crate::mesh::{MatrixRow, Mesh};
use crate::output::{Replace, WholeFile, write_stream, write_together};
use crate::{Component, Error, SparseMatrix};

/// Which entries of a matrix are stored.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Storage {
    /// The lower triangle of a symmetric matrix.
    Lower,
    /// Everything.
    General,
}

/// Columns turned into text at a time; bounds the memory, not the result.
const COLUMN_BATCH: usize = 8192;

/// Writes a component as the files that [`read_component`](super::read_component) reads, all of them or none: `stem.mtx`, `stem.mass.mtx`, `stem.json`, one
/// `stem.mass.xx.mtx` … per component mass, `stem.boundary.mtx` for explicit rows, `stem.stiffening.xx.mtx` …, `stem.stress.NAME.mtx` and `stem.load.NAME.mtx`; returns their
/// paths. The folder has to be there.
///
/// # Errors
/// [`Error::OutputExists`]; [`Error::NoRoom`] on a full disk; [`Error::Io`] with the path that the operating system refused.
pub fn write_component(
    component: &Component,
    stem: &Path,
    replace: Replace,
) -> Result<Vec<PathBuf>, Error> {
    let mut files: Vec<WholeFile<'_>> = Vec::new();
    for (suffix, matrix, storage) in matrices(component) {
        files.push(WholeFile {
            target: with_ending(stem, &format!("{suffix}.mtx")),
            fill: Box::new(move |out| write_matrix(out, matrix, storage)),
        });
    }
    for stress in &component.stresses {
        files.push(WholeFile {
            target: with_ending(stem, &format!(".stress.{}.mtx", stress.name)),
            fill: Box::new(|out| write_matrix(out, &stress.matrix, Storage::General)),
        });
    }
    for load in &component.loads {
        files.push(WholeFile {
            target: with_ending(stem, &format!(".load.{}.mtx", load.name)),
            fill: Box::new(|out| write_vector(out, &load.forces)),
        });
    }
    files.push(WholeFile {
        target: with_ending(stem, ".json"),
        fill: Box::new(|out| write_mesh_json(out, component)),
    });
    let paths = files.iter().map(|file| file.target.clone()).collect();
    write_together(files, replace)?;
    Ok(paths)
}

/// Writes the description of a component alone, whole or not at all.
///
/// # Errors
/// As [`write_component`].
pub fn write_description(
    component: &ComponentDraft,
    target: &Path,
    replace: Replace,
) -> Result<(), Error> {
    write_stream(target, replace, |out| write_mesh_json(out, component))
}

/// Every matrix with what follows the stem in its file's name.
fn matrices(component: &Component) -> Vec<(String, &SparseMatrix, Storage)> {
    let mut all = vec![
        (String::new(), &component.stiffness, Storage::Lower),
        (".mass".to_owned(), &component.mass, Storage::Lower),
    ];
    if let Some(masses) = &component.component_masses {
        let names = ComponentMasses::names(component.dimension());
        for (pair, component_mass) in names.iter().zip(&masses.matrices) {
            let storage = match *pair {
                "xx" | "yy" | "zz" => Storage::Lower,
                _ => Storage::General,
            };
            all.push((format!(".mass.{pair}"), component_mass, storage));
        }
    }
    if let Some(boundary) = &component.explicit_boundary {
        all.push((".boundary".to_owned(), boundary, Storage::General));
    }
    if let Some(geometric) = &component.geometric_stiffness {
        let products = GeometricStiffness::spin_products(component.dimension());
        for (product, spin) in products.iter().zip(&geometric.spins) {
            if let Some(spin) = spin {
                all.push((format!(".stiffening.{product}"), spin, Storage::Lower));
            }
        }
        for of_row in &geometric.rows {
            let (interface, direction) = of_row.row;
            let name = &component.interfaces[interface].name;
            let suffix = format!(".stiffening.{name}.{}", direction.name());
            all.push((suffix, &of_row.matrix, Storage::Lower));
        }
    }
    all
}

fn write_matrix(out: &mut impl Write, matrix: &SparseMatrix, storage: Storage) -> io::Result<()> {
    let (starts, rows, values) = (matrix.col_ptr(), matrix.row_idx(), matrix.val());
    let kept = |column: usize| {
        (starts[column] as usize..starts[column + 1] as usize)
            .filter(move |&at| storage == Storage::General || rows[at] as usize >= column)
    };
    let count: usize = (0..matrix.ncols())
        .into_par_iter()
        .map(|column| kept(column).count())
        .sum();
    let symmetry = if storage == Storage::Lower {
        "symmetric"
    } else {
        "general"
    };
    writeln!(out, "%%MatrixMarket matrix coordinate real {symmetry}")?;
    writeln!(out, "{} {} {count}", matrix.nrows(), matrix.ncols())?;
    for batch in (0..matrix.ncols()).step_by(COLUMN_BATCH) {
        let texts: Vec<Vec<u8>> = (batch..matrix.ncols().min(batch + COLUMN_BATCH))
            .into_par_iter()
            .map(|column| {
                let mut text = Vec::new();
                for at in kept(column) {
                    // Writing to memory can't fail.
                    let _ = writeln!(text, "{} {} {:e}", rows[at] + 1, column + 1, values[at]);
                }
                text
            })
            .collect();
        for text in texts {
            out.write_all(&text)?;
        }
    }
    Ok(())
}

fn write_vector(out: &mut impl Write, values: &[f64]) -> io::Result<()> {
    writeln!(out, "%%MatrixMarket matrix array real general")?;
    writeln!(out, "{} 1", values.len())?;
    values
        .iter()
        .try_for_each(|value| writeln!(out, "{value:e}"))
}

/// One point and one cell a line, so that small meshes can be read and compared.
fn write_mesh_json(out: &mut impl Write, component: &ComponentDraft) -> io::Result<()> {
    let mesh = &component.mesh;
    writeln!(out, "{{\"format\": \"meshio-json\", \"version\": 1,")?;
    write!(out, "\"points\": ")?;
    write_rows(
        out,
        mesh.coordinates
            .chunks_exact(mesh.dimension.coordinate_count()),
    )?;
    write!(out, ",\n\"cells\": [")?;
    for (at, block) in mesh.cells.iter().enumerate() {
        let comma = if at == 0 { "" } else { ", " };
        write!(
            out,
            "{comma}{{\"type\": {}, \"data\": ",
            Value::from(block.cell_type.as_str())
        )?;
        write_rows(out, block.cells())?;
        write!(out, "}}")?;
    }
    writeln!(
        out,
        "],\n\"point_data\": {{}}, \"cell_data\": {{}}, \"field_data\": {{}}, \"cell_sets\": {{}},"
    )?;
    writeln!(
        out,
        "\"point_sets\": {},",
        serde_json::to_string(&mesh.point_sets)?
    )?;
    write!(out, "\"component\": ")?;
    serde_json::to_writer_pretty(&mut *out, &component_key(component))?;
    writeln!(out, "}}")
}

fn write_rows<'a, T, R>(out: &mut impl Write, rows: R) -> io::Result<()>
where
    T: 'a,
    [T]: SerializeRow,
    R: Iterator<Item = &'a [T]>,
{
    write!(out, "[")?;
    for (at, row) in rows.enumerate() {
        write!(out, "{}", if at == 0 { "\n" } else { ",\n" })?;
        row.write_json(out)?;
    }
    write!(out, "]")
}

/// Coordinates and node ids: the two kinds of rows a mesh has.
trait SerializeRow {
    fn write_json(&self, out: &mut impl Write) -> io::Result<()>;
}

impl SerializeRow for [f64] {
    fn write_json(&self, out: &mut impl Write) -> io::Result<()> {
        Ok(serde_json::to_writer(out, self)?)
    }
}

impl SerializeRow for [u32] {
    fn write_json(&self, out: &mut impl Write) -> io::Result<()> {
        Ok(serde_json::to_writer(out, self)?)
    }
}

/// The `component` object.
fn component_key(component: &ComponentDraft) -> Value {
    let units = &component.units;
    let mut key = Map::new();
    key.insert("name".into(), json!(component.name));
    key.insert(
        "units".into(),
        json!({"length": units.length, "mass": units.mass, "time": units.time}),
    );
    key.insert("dofs".into(), dofs(component));
    let interfaces: Vec<Value> = component
        .interfaces
        .iter()
        .map(|one| interface(one, &component.mesh))
        .collect();
    key.insert("interfaces".into(), Value::from(interfaces));
    if !component.stresses.is_empty() {
        let stresses: Map<String, Value> = (component.stresses.iter())
            .map(|one| (one.name.clone(), stress(one, &component.mesh)))
            .collect();
        key.insert("stresses".into(), Value::Object(stresses));
    }
    match &component.damping {
        Damping::None => None,
        Damping::Uniform(ratio) => Some(json!({"modal": ratio})),
        Damping::PerMode(ratios) => Some(json!({"modal": ratios})),
        Damping::Rayleigh { alpha, beta } => Some(json!({"rayleigh": [alpha, beta]})),
    }
    .and_then(|damping| key.insert("damping".into(), damping));
    Value::Object(key)
}

/// The per-node pattern where every node has the same dofs in the same order, otherwise the table.
fn dofs(component: &ComponentDraft) -> Value {
    match component.dofs.pattern() {
        Some(pattern) => (pattern.iter())
            .map(|direction| Value::from(direction.name()))
            .collect(),
        None => (component.dofs.rows().iter())
            .map(|owner| match owner {
                MatrixRow::Nodal(dof) => json!([dof.node, dof.direction.name()]),
                MatrixRow::Internal => json!([null, "internal"]),
            })
            .collect(),
    }
}

fn stress(stress: &NamedStress, mesh: &Mesh) -> Value {
    let names: Vec<&str> = stress.components.iter().map(|one| one.name()).collect();
    let nodes: Option<Vec<u32>> = stress.points.iter().map(|point| point.node).collect();
    let d = mesh.dimension.coordinate_count();
    let positions = || {
        let points = stress.points.iter();
        points.map(|point| json!(&point.position[..d])).collect()
    };
    let (key, places): (_, Value) = match nodes {
        Some(nodes) => ("nodes", json!(nodes)),
        None => ("positions", positions()),
    };
    json!({"quantity": stress.quantity.name(), "components": names, key: places})
}

fn interface(interface: &Interface, mesh: &Mesh) -> Value {
    let mut object = Map::new();
    object.insert("name".into(), json!(interface.name));
    object.insert("kind".into(), json!(interface.kind.name()));
    match mesh
        .point_sets
        .iter()
        .find(|(_, nodes)| **nodes == interface.nodes)
    {
        Some((set, _)) => object.insert("point_set".into(), json!(set)),
        None => object.insert("nodes".into(), json!(interface.nodes)),
    };
    if let Some(position) = interface.position {
        object.insert(
            "position".into(),
            json!(&position[..mesh.dimension.coordinate_count()]),
        );
    }
    match &interface.weights {
        Weights::Uniform => None,
        Weights::Area => Some(json!("area")),
        Weights::Mass => Some(json!("mass")),
        Weights::Given(weights) => Some(json!(weights)),
    }
    .and_then(|weights| object.insert("weights".into(), weights));
    if let Some(axes) = interface.axes {
        object.insert("axes".into(), json!(axes));
    }
    if let Some(directions) = &interface.directions {
        let names: Vec<&str> = directions
            .iter()
            .map(|direction| direction.name())
            .collect();
        object.insert("dofs".into(), json!(names));
    }
    if interface.role == Role::Output {
        object.insert("role".into(), json!("output"));
    }
    Value::Object(object)
}
