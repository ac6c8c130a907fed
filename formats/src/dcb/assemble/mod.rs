//! The data model from a file's datasets; every shape has been checked already.

mod derivation;
mod older;
mod provenance;
mod stresses;

use faer::Mat;

use super::names;
use super::read::SuperelementFile;
use super::second_order;
use crate::component::Units;
use crate::hdf5_files::FormatVersion;
use crate::hdf5_files::attributes::Value;
use crate::hdf5_files::inventory::Finding;
use crate::hdf5_files::version::text_attribute;
use crate::mesh::{Dimension, Direction, Dof};
use crate::superelement::{
    BoundaryRow, Enrichment, Inertia, InterfaceFrame, LoadedForces, Modes, Moments, PartLoad,
    Residual, Stiffening, Superelement,
};
use crate::terminal::shortened;

/// Whether a file says in datasets how it was made: those of 1.4 and later do.
pub(super) fn says_derivation(file: &SuperelementFile) -> bool {
    file.format_version() >= FormatVersion { major: 1, minor: 4 }
}

/// Everything but the nodal fields and the mesh.
pub(super) fn superelement(file: &SuperelementFile) -> Result<Superelement, Finding> {
    let inventory = file.inventory();
    let text = |path, name| text_attribute(inventory, path, name);
    let kind = text("/frame", "kind")?;
    let frame_kind = names::frame_kind_of(kind).ok_or_else(|| {
        Finding::at(
            "/frame",
            format!(
                "kind is {:?}; it must be \"mean-axis\" or \"given\"",
                shortened(kind)
            ),
        )
    })?;
    let (interfaces, rows) = (interfaces(file)?, rows(file)?);
    let provenance = provenance::provenance(file)?;
    Ok(Superelement {
        derivation: match says_derivation(file) {
            true => derivation::derivation(file, &interfaces, &rows)?,
            false => older::derivation(&provenance, &interfaces, &rows),
        },
        name: text("/", "name")?.to_owned(),
        dimension: file.counts().dimension,
        units: units(text("/", "units")?)?,
        origin: point(&file.reals("/frame/origin")?),
        frame_kind,
        interfaces,
        rows,
        modes: modes(file)?,
        residual: residual(file)?,
        inertia: inertia(file)?,
        stiffening: Stiffening {
            centrifugal: optional_layers(file, "/stiffening/centrifugal")?,
            interface: optional_layers(file, "/stiffening/interface")?,
        },
        enrichment: enrichment(file)?,
        moments: moments(file)?,
        loads: loads(file)?,
        stresses: stresses::stresses(file)?,
        provenance,
    })
}

/// The dofs of the field columns.
pub(super) fn field_dofs(file: &SuperelementFile) -> Result<Vec<Dof>, Finding> {
    let path = "/fields/dofs";
    let values = file.integers(path)?;
    let (pairs, _) = values.as_chunks::<2>();
    pairs
        .iter()
        .enumerate()
        .map(|(column, &[node, direction])| {
            let direction = usize::try_from(direction)
                .ok()
                .and_then(Direction::from_index);
            match (u32::try_from(node), direction) {
                (Ok(node), Some(direction)) => Ok(Dof { node, direction }),
                _ => Err(Finding::at(
                    path,
                    format!("column {column} isn't a node and a dof index from 0 to 5"),
                )),
            }
        })
        .collect()
}

fn units(text: &str) -> Result<Units, Finding> {
    let json: serde_json::Value = serde_json::from_str(text)
        .map_err(|error| Finding::at("/", format!("attribute units isn't JSON: {error}")))?;
    let unit = |name: &str| {
        let unit = json.get(name).and_then(serde_json::Value::as_str);
        unit.map(str::to_owned)
            .ok_or_else(|| Finding::at("/", format!("attribute units names no {name}")))
    };
    Ok(Units {
        length: unit("length")?,
        mass: unit("mass")?,
        time: unit("time")?,
    })
}

/// Two or three coordinates; the third of two is 0.
pub(super) fn point(coordinates: &[f64]) -> [f64; 3] {
    let mut point = [0.0; 3];
    point
        .iter_mut()
        .zip(coordinates)
        .for_each(|(to, from)| *to = *from);
    point
}

fn interfaces(file: &SuperelementFile) -> Result<Vec<InterfaceFrame>, Finding> {
    let names = file.texts("/interfaces/names")?;
    let kinds = file.texts("/interfaces/kinds")?;
    let roles = file.texts("/interfaces/roles")?;
    let positions = file.reals("/interfaces/positions")?;
    let orientations = file.reals("/interfaces/orientations")?;
    let dimension = file.counts().dimension;
    let mut interfaces = Vec::with_capacity(names.len());
    for (index, name) in names.into_iter().enumerate() {
        let unknown = |path: &str, word: &str| {
            Finding::at(
                path,
                format!(
                    "entry {index} is {:?}, which this version doesn't know",
                    shortened(word)
                ),
            )
        };
        let d = dimension.coordinate_count();
        interfaces.push(InterfaceFrame {
            kind: names::interface_kind_of(&kinds[index])
                .ok_or_else(|| unknown("/interfaces/kinds", &kinds[index]))?,
            role: names::role_of(&roles[index])
                .ok_or_else(|| unknown("/interfaces/roles", &roles[index]))?,
            position: point(&positions[d * index..d * (index + 1)]),
            orientation: match dimension {
                Dimension::Planar => turn(orientations[index]),
                Dimension::Spatial => tensor(&orientations[9 * index..9 * (index + 1)]),
            },
            name,
        });
    }
    Ok(interfaces)
}

/// Rotation about z.
fn turn(angle: f64) -> [[f64; 3]; 3] {
    let (sine, cosine) = angle.sin_cos();
    [[cosine, -sine, 0.0], [sine, cosine, 0.0], [0.0, 0.0, 1.0]]
}

fn tensor(values: &[f64]) -> [[f64; 3]; 3] {
    std::array::from_fn(|a| std::array::from_fn(|b| values[3 * a + b]))
}

/// Only the (z, z) entry.
fn planar_tensor(value: f64) -> [[f64; 3]; 3] {
    [[0.0; 3], [0.0; 3], [0.0, 0.0, value]]
}

fn rows(file: &SuperelementFile) -> Result<Vec<BoundaryRow>, Finding> {
    let dofs = file.integers("/interfaces/dofs")?;
    let nodes = file.integers("/interfaces/row_nodes")?;
    let positions = file.reals("/interfaces/row_positions")?;
    let d = file.counts().dimension.coordinate_count();
    let (pairs, _) = dofs.as_chunks::<2>();
    let rows = pairs
        .iter()
        .zip(nodes)
        .zip(positions.chunks_exact(d))
        .enumerate();
    rows.map(|(row, ((&[interface, direction], node), position))| {
        let interface = usize::try_from(interface).map_err(|_| {
            Finding::at(
                "/interfaces/dofs",
                format!("row {row} names interface {interface}"),
            )
        })?;
        Ok(BoundaryRow {
            interface,
            direction,
            node,
            position: point(position),
        })
    })
    .collect()
}

fn modes(file: &SuperelementFile) -> Result<Modes, Finding> {
    let counts = file.counts();
    Ok(Modes {
        eigenvalues: file.reals("/modes/eigenvalues")?,
        damping: file.reals("/modes/damping")?,
        residual_damping: real(file, "/modes/damping", "residual")?,
        interface_shapes: matrix(file, "/modes/interface_shapes", counts.rows, counts.modes)?,
        first_omitted_eigenvalue: real(file, "/modes", "first_omitted_eigenvalue")?,
    })
}

fn residual(file: &SuperelementFile) -> Result<Residual, Finding> {
    let counts = file.counts();
    let (n_b, rank) = (counts.rows, counts.rank);
    let output = "/residual/output_shapes";
    Ok(Residual {
        flexibility: matrix(file, "/residual/flexibility", n_b, n_b)?,
        mass: matrix(file, "/residual/mass", n_b, n_b)?,
        mass_diagonal0: file.reals("/residual/mass_diagonal0")?,
        transform: matrix(file, "/residual/transform", n_b, rank)?,
        sigma_squared: file.reals("/residual/sigma2")?,
        tolerance: real(file, "/residual/transform", "tolerance")?,
        output_shapes: if file.has(output) {
            Some(matrix(file, output, n_b, n_b)?)
        } else {
            None
        },
    })
}

fn inertia(file: &SuperelementFile) -> Result<Inertia, Finding> {
    let n = basis_count(file);
    let dimension = file.counts().dimension;
    let planar = dimension == Dimension::Planar;
    let tensors = |path: &str| -> Result<Vec<[[f64; 3]; 3]>, Finding> {
        let values = file.reals(path)?;
        Ok(match dimension {
            Dimension::Planar => values.into_iter().map(planar_tensor).collect(),
            Dimension::Spatial => values.chunks_exact(9).map(tensor).collect(),
        })
    };
    let scalar = |path: &str| -> Result<f64, Finding> {
        Ok(file.reals(path)?.first().copied().unwrap_or(f64::NAN))
    };
    Ok(Inertia {
        mass: scalar("/inertia/mass")?,
        tensor: tensors("/inertia/tensor")?
            .pop()
            .unwrap_or([[f64::NAN; 3]; 3]),
        l1: matrix(file, "/inertia/L1", dimension.coordinate_count(), n)?,
        i1: tensors("/inertia/I1")?,
        i3: matrix(file, "/inertia/I3", if planar { 1 } else { 3 }, n)?,
        l3: layers(file, "/inertia/L3")?,
        i2: if planar {
            Vec::new()
        } else {
            second_order::from_values(&file.reals("/inertia/I2")?, n)?
        },
    })
}

fn enrichment(file: &SuperelementFile) -> Result<Option<Enrichment>, Finding> {
    if !file.has("/enrichment/interface_shapes") {
        return Ok(None);
    }
    let n = basis_count(file);
    Ok(Some(Enrichment {
        names: match file.has("/enrichment/names") {
            true => file.texts("/enrichment/names")?,
            false => Vec::new(),
        },
        interface_shapes: matrix(
            file,
            "/enrichment/interface_shapes",
            file.counts().rows,
            file.counts().enrichment,
        )?,
        reduced_mass: matrix(file, "/reduced/mass", n, n)?,
        reduced_stiffness: matrix(file, "/reduced/stiffness", n, n)?,
    }))
}

fn moments(file: &SuperelementFile) -> Result<Option<Moments>, Finding> {
    if !file.has("/error/moment_1") {
        return Ok(None);
    }
    let counts = file.counts();
    let n = counts.length(super::contract::Axis::Residual);
    let moment = |path| matrix(file, path, n, n);
    Ok(Some(Moments {
        eigenvalue_bound: real(file, "/error", "eigenvalue_bound")?,
        eigenvalue_errors: file.reals("/error/eigenvalue_errors")?,
        rigid_shapes: matrix(file, "/error/rigid_shapes", counts.rows, counts.rigid)?,
        shift: real_or_zero(file, "/error", "shift")?,
        first: moment("/error/moment_1")?,
        second: moment("/error/moment_2")?,
        third: moment("/error/moment_3")?,
        fourth: moment("/error/moment_4")?,
        rounding: file.reals("/error/rounding")?,
        loaded: loaded(file)?,
    }))
}

fn loaded(file: &SuperelementFile) -> Result<Option<LoadedForces>, Finding> {
    if !file.has("/error/forces") {
        return Ok(None);
    }
    let counts = file.counts();
    Ok(Some(LoadedForces {
        forces: matrix(file, "/error/forces", counts.rows, counts.forces)?,
        eigenvalue_bound: real(file, "/error", "forces_eigenvalue_bound")?,
    }))
}

fn loads(file: &SuperelementFile) -> Result<Vec<PartLoad>, Finding> {
    if !file.has("/loads/names") {
        return Ok(Vec::new());
    }
    let names = file.texts("/loads/names")?;
    let (forces, moments) = (file.reals("/loads/forces")?, file.reals("/loads/moments")?);
    let work = file.reals("/loads/work")?;
    let d = file.counts().dimension.coordinate_count();
    let n = basis_count(file);
    let load = |(index, name): (usize, String)| PartLoad {
        name,
        force: point(&forces[index * d..(index + 1) * d]),
        moment: match file.counts().dimension {
            Dimension::Planar => [0.0, 0.0, moments[index]],
            Dimension::Spatial => point(&moments[3 * index..3 * index + 3]),
        },
        work: work[index * n..(index + 1) * n].to_vec(),
    };
    Ok(names.into_iter().enumerate().map(load).collect())
}

fn basis_count(file: &SuperelementFile) -> usize {
    file.counts().length(super::contract::Axis::Basis)
}

fn matrix(
    file: &SuperelementFile,
    path: &str,
    rows: usize,
    columns: usize,
) -> Result<Mat<f64>, Finding> {
    let values = file.reals(path)?;
    Ok(Mat::from_fn(rows, columns, |i, j| values[i * columns + j]))
}

/// Square matrices, one after the other.
fn layers(file: &SuperelementFile, path: &str) -> Result<Vec<Mat<f64>>, Finding> {
    let n = basis_count(file);
    let values = file.reals(path)?;
    if n == 0 {
        let planar = file.counts().dimension == Dimension::Planar;
        return Ok(vec![Mat::zeros(0, 0); if planar { 1 } else { 3 }]);
    }
    Ok(values
        .chunks_exact(n * n)
        .map(|layer| Mat::from_fn(n, n, |k, l| layer[k * n + l]))
        .collect())
}

fn optional_layers(file: &SuperelementFile, path: &str) -> Result<Vec<Mat<f64>>, Finding> {
    if file.has(path) && basis_count(file) > 0 {
        layers(file, path)
    } else {
        Ok(Vec::new())
    }
}

fn real_or_zero(file: &SuperelementFile, path: &str, name: &str) -> Result<f64, Finding> {
    match file.inventory().attribute(path, name) {
        None => Ok(0.0),
        Some(_) => real(file, path, name),
    }
}

fn real(file: &SuperelementFile, path: &str, name: &str) -> Result<f64, Finding> {
    match file.inventory().attribute(path, name) {
        Some(Value::Real(real)) => Ok(*real),
        Some(other) => Err(Finding::at(
            path,
            format!("attribute {name} is {other:?}; it must be a 64-bit float"),
        )),
        None => Err(Finding::at(path, format!("attribute {name} is missing"))),
    }
}
