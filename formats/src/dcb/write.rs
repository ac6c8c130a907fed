//! A superelement to a file.

use std::path::Path;

use faer::Mat;

use super::contract::Counts;
use super::sink::Sink;
use super::units::UnitSystem;
use super::{
    Compression, Contents, FORMAT, FORMAT_VERSION, WriteOptions, check, check_fields, names,
    second_order,
};
use crate::Error;
use crate::hdf5_files::attributes::Value;
use crate::hdf5_files::create::{abandon, create, told};
use crate::hdf5_files::inventory::Finding;
use crate::mesh::{Dimension, Mesh};
use crate::output;
use crate::superelement::{Moments, Superelement};

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
    if let Some(mesh) = contents.mesh {
        check_fields::mesh(mesh, of.dimension).map_err(broken)?;
    }
    if let Some(recovery) = contents.recovery {
        check_fields::recovery(
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
    output::write_whole(target, options.replace_existing, |partial, _| {
        fill(partial, contents, options.compression)
            .map_err(|error| told(target, rough_size(contents), &error))
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
    fields + mesh + per_pair * matrix(of.basis_count(), of.basis_count())
}

fn fill(partial: &Path, contents: &Contents, compression: Compression) -> hdf5::Result<()> {
    let file = create(partial)?;
    let written = Writer::new(&file, contents, compression)
        .write()
        .and_then(|()| file.flush());
    if written.is_err() {
        abandon(partial);
    }
    let closed = file.close();
    written.and(closed)
}

/// Puts each part of the contents where the contract has it.
pub(super) struct Writer<'a> {
    contents: &'a Contents<'a>,
    pub(super) sink: Sink<'a>,
}

impl<'a> Writer<'a> {
    fn new(file: &'a hdf5::File, contents: &'a Contents<'a>, compression: Compression) -> Self {
        let of = contents.superelement;
        let fields = contents
            .recovery
            .map(|recovery| recovery.dofs.as_slice())
            .unwrap_or_default();
        let enrichment = of
            .enrichment
            .as_ref()
            .map_or(0, |enrichment| enrichment.interface_shapes.ncols());
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
        };
        let units = UnitSystem {
            units: &of.units,
            rows: &of.rows,
            mode_count: of.mode_count(),
            enrichment_count: enrichment,
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
        self.sink.texts(
            "/interfaces/names",
            &all.iter().map(|one| one.name.clone()).collect::<Vec<_>>(),
        )?;
        self.sink.texts(
            "/interfaces/kinds",
            &all.iter()
                .map(|one| one.kind.name().to_owned())
                .collect::<Vec<_>>(),
        )?;
        self.sink.texts(
            "/interfaces/roles",
            &all.iter()
                .map(|one| names::role(one.role).to_owned())
                .collect::<Vec<_>>(),
        )?;
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

    fn optional(&mut self, of: &Superelement) -> hdf5::Result<()> {
        let stiffening = [
            ("centrifugal", &of.stiffening.centrifugal),
            ("interface", &of.stiffening.interface),
        ];
        if stiffening.iter().any(|(_, matrices)| !matrices.is_empty()) {
            self.sink.group("stiffening")?;
        }
        for (name, matrices) in stiffening {
            if !matrices.is_empty() {
                self.sink
                    .reals(&format!("/stiffening/{name}"), &stacked(matrices))?;
            }
        }
        if !of.loads.is_empty() {
            self.loads(of)?;
        }
        if let Some(enrichment) = &of.enrichment {
            self.sink.group("enrichment")?;
            self.sink.group("reduced")?;
            self.sink.reals(
                "/enrichment/interface_shapes",
                &row_major(&enrichment.interface_shapes),
            )?;
            if !enrichment.names.is_empty() {
                self.sink.texts("/enrichment/names", &enrichment.names)?;
            }
            self.sink
                .reals("/reduced/mass", &row_major(&enrichment.reduced_mass))?;
            self.sink.reals(
                "/reduced/stiffness",
                &row_major(&enrichment.reduced_stiffness),
            )?;
        }
        Ok(())
    }

    fn error(&mut self, moments: &Moments) -> hdf5::Result<()> {
        self.sink.group("error")?;
        self.sink.attribute(
            "/error",
            "eigenvalue_bound",
            Value::Real(moments.eigenvalue_bound),
        )?;
        self.sink
            .attribute("/error", "shift", Value::Real(moments.shift))?;
        self.sink
            .reals("/error/eigenvalue_errors", &moments.eigenvalue_errors)?;
        self.sink
            .reals("/error/rigid_shapes", &row_major(&moments.rigid_shapes))?;
        for (path, moment) in [
            ("/error/moment_1", &moments.first),
            ("/error/moment_2", &moments.second),
            ("/error/moment_3", &moments.third),
            ("/error/moment_4", &moments.fourth),
        ] {
            self.sink.reals(path, &row_major(moment))?;
        }
        self.sink.reals("/error/rounding", &moments.rounding)?;
        if let Some(loaded) = &moments.loaded {
            self.sink
                .reals("/error/forces", &row_major(&loaded.forces))?;
            self.sink.attribute(
                "/error",
                "forces_eigenvalue_bound",
                Value::Real(loaded.eigenvalue_bound),
            )?;
        }
        Ok(())
    }

    fn loads(&mut self, of: &Superelement) -> hdf5::Result<()> {
        self.sink.group("loads")?;
        let d = of.dimension.coordinate_count();
        let turns = if of.dimension == Dimension::Planar {
            2..3
        } else {
            0..3
        };
        let names: Vec<String> = of.loads.iter().map(|load| load.name.clone()).collect();
        let forces = of.loads.iter().flat_map(|load| load.force[..d].to_vec());
        let moments = of
            .loads
            .iter()
            .flat_map(|load| load.moment[turns.clone()].to_vec());
        let work = of.loads.iter().flat_map(|load| load.work.clone());
        self.sink.texts("/loads/names", &names)?;
        self.sink
            .reals("/loads/forces", &forces.collect::<Vec<_>>())?;
        self.sink
            .reals("/loads/moments", &moments.collect::<Vec<_>>())?;
        self.sink.reals("/loads/work", &work.collect::<Vec<_>>())
    }

    fn provenance(&mut self, of: &Superelement) -> hdf5::Result<()> {
        self.sink.group("provenance")?;
        let provenance = &of.provenance;
        let inputs: Vec<_> = provenance
            .inputs
            .iter()
            .map(|source| serde_json::json!({ "role": source.role, "file_name": source.file_name, "sha256": source.sha256 }))
            .collect();
        self.sink
            .attribute("/provenance", "tool_version", text(&provenance.generator))?;
        self.sink.attribute(
            "/provenance",
            "inputs",
            text(&serde_json::Value::from(inputs).to_string()),
        )?;
        self.sink.attribute(
            "/provenance",
            "options",
            text(&provenance.options.to_string()),
        )?;
        self.sink.attribute(
            "/provenance",
            "quality",
            text(&provenance.quality.to_string()),
        )?;
        let warnings = serde_json::Value::from(provenance.warnings.as_slice());
        self.sink
            .attribute("/provenance", "warnings", text(&warnings.to_string()))
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
