//! A superelement to a file.

mod derivation;
mod fields;
mod optional;
mod stresses;

use std::path::Path;

use faer::Mat;

use super::contract::Counts;
use super::sink::Sink;
use super::units::UnitSystem;
use super::{Compression, Contents, FORMAT, FORMAT_VERSION, WriteOptions, check, second_order};
use crate::Error;
use crate::component::StressQuantity;
use crate::hdf5_files::attributes::Value;
use crate::hdf5_files::inventory::Finding;
use crate::hdf5_files::write_hdf5;
use crate::mesh::{Dimension, Mesh};
use crate::superelement::{InterfaceFrame, Superelement};

/// Writes a superelement: complete and durable under its name, or not at all.
///
/// # Errors
/// [`Error::OutputExists`]; [`Error::Location`] where the contents break the contract; [`Error::Io`] where the
/// system refuses, a full disk included.
pub fn write_superelement(
    target: &Path,
    contents: &Contents,
    options: &WriteOptions,
) -> Result<(), Error> {
    let broken = |finding: Finding| Error::Location {
        path: target.to_owned(),
        location: finding.path,
        message: finding.message,
    };
    let of = contents.superelement;
    check::superelement(of).map_err(broken)?;
    if let Some(derivation) = &of.derivation {
        check::derivation::derivation(of, derivation).map_err(broken)?;
    }
    if let Some(mesh) = contents.mesh {
        check::fields::mesh(mesh, of.dimension).map_err(broken)?;
    }
    if let Some(recovery) = contents.recovery {
        check::fields::recovery(
            recovery,
            of.dimension,
            [
                of.mode_count(),
                of.boundary_row_count(),
                of.basis_count() - of.mode_count() - of.boundary_row_count(),
            ],
            contents.mesh.map(Mesh::node_count),
        )
        .map_err(broken)?;
    }
    let stress_rows = stresses::quantities(of);
    let needed = rough_size(contents);
    write_hdf5(target, options.replace_existing, needed, |file| {
        Writer::new(file, contents, &stress_rows, options.compression).write()
    })
}

/// Bytes of the large arrays: the nodal fields and the inertia invariants, uncompressed.
fn rough_size(contents: &Contents) -> u64 {
    let of = contents.superelement;
    let matrix = |rows: usize, columns: usize| (8 * rows * columns) as u64;
    let fields = contents
        .recovery
        .map_or(0, |recovery| matrix(recovery.dofs.len(), of.basis_count()));
    let per_pair = match of.dimension {
        Dimension::Planar => 1,
        Dimension::Spatial => 12,
    };
    let mesh = contents.mesh.map_or(0, |mesh| matrix(mesh.node_count(), 3));
    let stresses = (of.stresses.iter())
        .map(|field| matrix(field.shapes.nrows(), of.basis_count()))
        .sum::<u64>();
    fields + stresses + mesh + per_pair * matrix(of.basis_count(), of.basis_count())
}

/// Puts each part of the contents where the contract has it.
struct Writer<'a> {
    contents: &'a Contents<'a>,
    sink: Sink<'a>,
}

impl<'a> Writer<'a> {
    fn new(
        file: &'a hdf5::File,
        contents: &'a Contents<'a>,
        stress_rows: &'a [StressQuantity],
        compression: Compression,
    ) -> Self {
        let of = contents.superelement;
        let fields = contents
            .recovery
            .map(|recovery| recovery.dofs.as_slice())
            .unwrap_or_default();
        let enrichment = of
            .enrichment
            .as_ref()
            .map_or(0, |enrichment| enrichment.interface_shapes.ncols());
        let left_out = (of.derivation.as_ref()).map_or(0, |of| of.left_out_columns.len());
        let counts = Counts {
            dimension: of.dimension,
            interfaces: of.interfaces.len(),
            rows: of.rows.len(),
            modes: of.mode_count(),
            enrichment,
            rank: of.residual.sigma_squared.len(),
            field_dofs: fields.len(),
            loads: of.loads.len(),
            rigid: (of.moments.as_ref()).map_or(0, |moments| moments.rigid_shapes.ncols()),
            forces: (of.moments.as_ref())
                .and_then(|moments| moments.loaded.as_ref())
                .map_or(0, |loaded| loaded.forces.ncols()),
            left_out_columns: left_out,
            selections: of.selections().len(),
            selected_modes: (of.selections().iter()).map(|record| record.of_modes).sum(),
            selected_forces: derivation::loaded_along_count(of),
            stress_fields: of.stresses.len(),
            stress_points: of.stresses.iter().map(|field| field.points.len()).sum(),
            stress_rows: stress_rows.len(),
        };
        let units = UnitSystem {
            units: &of.units,
            rows: &of.rows,
            mode_count: of.mode_count(),
            enrichment_count: enrichment,
            stress_rows,
            fields_have_rotations: fields.iter().any(|dof| dof.direction.is_rotation()),
        };
        Self {
            contents,
            sink: Sink::new(file, counts, units, compression),
        }
    }

    fn write(mut self) -> hdf5::Result<()> {
        let of = self.contents.superelement;
        self.root(of)?;
        self.interfaces(of)?;
        self.modes(of)?;
        self.residual(of)?;
        self.inertia(of)?;
        self.optional(of)?;
        if let Some(moments) = &of.moments {
            self.error(moments)?;
        }
        if let Some(recovery) = self.contents.recovery {
            self.recovery(recovery)?;
        }
        if let Some(mesh) = self.contents.mesh {
            self.mesh(mesh)?;
        }
        if let Some(derivation) = &of.derivation {
            self.derivation(of, derivation)?;
        }
        self.provenance(of)?;
        self.sink.finish()
    }

    fn root(&mut self, of: &Superelement) -> hdf5::Result<()> {
        let units = serde_json::json!({ "length": of.units.length, "mass": of.units.mass, "time": of.units.time });
        self.sink.attribute("/", "format", text(FORMAT))?;
        self.sink
            .attribute("/", "format_version", text(&FORMAT_VERSION.to_string()))?;
        self.sink.attribute("/", "name", text(&of.name))?;
        self.sink.attribute(
            "/",
            "dimension",
            Value::Integer(of.dimension.coordinate_count() as i64),
        )?;
        self.sink
            .attribute("/", "units", text(&units.to_string()))?;
        self.sink
            .attribute("/", "generator", text(&of.provenance.generator))?;
        for group in ["frame", "interfaces", "modes", "residual", "inertia"] {
            self.sink.group(group)?;
        }
        self.sink
            .attribute("/frame", "kind", text(of.frame_kind.name()))?;
        self.sink.reals(
            "/frame/origin",
            &of.origin[..of.dimension.coordinate_count()],
        )
    }

    fn interfaces(&mut self, of: &Superelement) -> hdf5::Result<()> {
        let d = of.dimension.coordinate_count();
        let all = &of.interfaces;
        let words = |of: fn(&InterfaceFrame) -> &str| -> Vec<String> {
            all.iter().map(|one| of(one).to_owned()).collect()
        };
        let names = words(|one| &one.name);
        self.sink.texts("/interfaces/names", &names)?;
        let kinds = words(|one| one.kind.name());
        self.sink.texts("/interfaces/kinds", &kinds)?;
        let roles = words(|one| one.role.name());
        self.sink.texts("/interfaces/roles", &roles)?;
        self.sink.reals(
            "/interfaces/positions",
            &all.iter()
                .flat_map(|one| one.position[..d].to_vec())
                .collect::<Vec<_>>(),
        )?;
        let orientations: Vec<f64> = match of.dimension {
            Dimension::Planar => all
                .iter()
                .map(|one| one.orientation[1][0].atan2(one.orientation[0][0]))
                .collect(),
            Dimension::Spatial => all
                .iter()
                .flat_map(|one| one.orientation.as_flattened().to_vec())
                .collect(),
        };
        self.sink.reals("/interfaces/orientations", &orientations)?;
        let dofs: Vec<i64> = of
            .rows
            .iter()
            .flat_map(|row| [row.interface as i64, row.direction])
            .collect();
        self.sink.integers("/interfaces/dofs", &dofs)?;
        self.sink.integers(
            "/interfaces/row_nodes",
            &of.rows.iter().map(|row| row.node).collect::<Vec<_>>(),
        )?;
        self.sink.reals(
            "/interfaces/row_positions",
            &of.rows
                .iter()
                .flat_map(|row| row.position[..d].to_vec())
                .collect::<Vec<_>>(),
        )
    }

    fn modes(&mut self, of: &Superelement) -> hdf5::Result<()> {
        let modes = &of.modes;
        self.sink.attribute(
            "/modes",
            "first_omitted_eigenvalue",
            Value::Real(modes.first_omitted_eigenvalue),
        )?;
        self.sink.reals("/modes/eigenvalues", &modes.eigenvalues)?;
        self.sink.reals("/modes/damping", &modes.damping)?;
        self.sink.attribute(
            "/modes/damping",
            "residual",
            Value::Real(modes.residual_damping),
        )?;
        self.sink.reals(
            "/modes/interface_shapes",
            &row_major(&modes.interface_shapes),
        )
    }

    fn residual(&mut self, of: &Superelement) -> hdf5::Result<()> {
        let residual = &of.residual;
        self.sink
            .reals("/residual/flexibility", &row_major(&residual.flexibility))?;
        self.sink
            .reals("/residual/mass", &row_major(&residual.mass))?;
        self.sink
            .reals("/residual/mass_diagonal0", &residual.mass_diagonal0)?;
        self.sink
            .reals("/residual/transform", &row_major(&residual.transform))?;
        self.sink.attribute(
            "/residual/transform",
            "rank",
            Value::Integer(of.residual.sigma_squared.len() as i64),
        )?;
        self.sink.attribute(
            "/residual/transform",
            "tolerance",
            Value::Real(residual.tolerance),
        )?;
        self.sink
            .reals("/residual/sigma2", &residual.sigma_squared)?;
        match &residual.output_shapes {
            Some(shapes) => self
                .sink
                .reals("/residual/output_shapes", &row_major(shapes)),
            None => Ok(()),
        }
    }

    fn inertia(&mut self, of: &Superelement) -> hdf5::Result<()> {
        let inertia = &of.inertia;
        self.sink.reals("/inertia/mass", &[inertia.mass])?;
        self.sink.reals("/inertia/L1", &row_major(&inertia.l1))?;
        self.sink.reals("/inertia/I3", &row_major(&inertia.i3))?;
        self.sink.reals("/inertia/L3", &stacked(&inertia.l3))?;
        match of.dimension {
            Dimension::Planar => {
                self.sink
                    .reals("/inertia/tensor", &[inertia.tensor[2][2]])?;
                self.sink.reals(
                    "/inertia/I1",
                    &inertia
                        .i1
                        .iter()
                        .map(|block| block[2][2])
                        .collect::<Vec<_>>(),
                )
            }
            Dimension::Spatial => {
                self.sink
                    .reals("/inertia/tensor", inertia.tensor.as_flattened())?;
                self.sink
                    .reals("/inertia/I1", inertia.i1.as_flattened().as_flattened())?;
                self.sink
                    .reals("/inertia/I2", &second_order::to_values(&inertia.i2))
            }
        }
    }
}

fn text(text: &str) -> Value {
    Value::Text(text.to_owned())
}

fn row_major(matrix: &Mat<f64>) -> Vec<f64> {
    (0..matrix.nrows())
        .flat_map(|i| (0..matrix.ncols()).map(move |j| matrix[(i, j)]))
        .collect()
}

fn stacked(matrices: &[Mat<f64>]) -> Vec<f64> {
    matrices.iter().flat_map(row_major).collect()
}
