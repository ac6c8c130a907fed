//! Parts that not every superelement has to a file.

use super::{Writer, row_major, stacked};
use crate::hdf5_files::attributes::Value;
use crate::mesh::Dimension;
use crate::superelement::{Moments, Superelement};

impl Writer<'_> {
    /// Geometric stiffness, loads, stresses and further columns.
    pub(super) fn optional(&mut self, of: &Superelement) -> hdf5::Result<()> {
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
        if !of.stresses.is_empty() {
            self.stresses(of)?;
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

    /// Power moments of the response that the modes leave out.
    pub(super) fn error(&mut self, moments: &Moments) -> hdf5::Result<()> {
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
}
