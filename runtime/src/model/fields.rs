//! Displacement fields that a scene asks for, written as files for ParaView while it runs.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use dcb_formats::mesh::Mesh;
use dcb_formats::output::Replace;
use dcb_formats::superelement::RecoveryBasis;
use dcb_formats::vtk::Numbers;

use super::Names;
use super::library::Library;
use crate::error::Error;
use crate::export::nodal_field::NodalField;
use crate::export::nodal_stress::nodal_stresses;
use crate::export::vtu::{FieldSeries, FieldSnapshot};
use crate::model::timetable::{Due, Timetable};
use crate::system::builder::SystemBuilder;
use crate::system::evaluation::Evaluation;
use crate::system::{State, System};
use dcb_formats::scene::{FieldRequest, Scene};

/// A field of one body, and when it is written.
pub struct FieldPlan {
    body: usize,
    name: String,
    field: NodalField,
    source: Arc<(RecoveryBasis, Mesh)>,
    directory: PathBuf,
    timetable: Timetable,
}

impl FieldPlan {
    pub(super) fn of(
        scene: &Scene,
        builder: &SystemBuilder,
        names: &Names,
        library: &mut Library,
        index: usize,
        request: &FieldRequest,
    ) -> Result<Self, Error> {
        let source = library.fields(scene, &request.body, &format!("fields[{index}].body"))?;
        let body = names.bodies.get(&request.body).copied().unwrap_or_default();
        let flexible = &builder.system().bodies[body].flexible;
        let timetable = match (&request.times, request.every) {
            (Some(times), _) => Timetable::listed(times.clone()),
            (None, Some(every)) => Timetable::every(every),
            (None, None) => Timetable::listed(Vec::new()),
        };
        Ok(Self {
            body,
            name: request.body.clone(),
            field: NodalField::new(flexible, &source.0, &source.1)?,
            source,
            directory: scene.resolve(&request.directory),
            timetable,
        })
    }

    /// Where the scene wants the files.
    pub fn directory(&self) -> &Path {
        &self.directory
    }

    /// The field, over the coordinates of the body.
    pub fn field(&self) -> &NodalField {
        &self.field
    }

    /// The mesh of the body's superelement.
    pub fn mesh(&self) -> &Mesh {
        &self.source.1
    }

    /// Name of the body.
    pub fn body_name(&self) -> &str {
        &self.name
    }

    /// Nodes whose displacement the field has, ascending.
    pub fn nodes(&self) -> Vec<u32> {
        let recovered = (0..).zip(self.field.recovered());
        recovered
            .filter(|(_, is_recovered)| **is_recovered == 1)
            .map(|(node, _)| node)
            .collect()
    }
}

/// A field being written.
pub struct FieldWriter {
    plan: FieldPlan,
    series: FieldSeries,
    /// Largest von Mises' stress of each node in the files so far, by the name of its numbers.
    largest: BTreeMap<String, Vec<f64>>,
}

impl FieldWriter {
    /// Starts the list of files in a folder that is there.
    ///
    /// # Errors
    /// [`Error::File`]; [`Error::Field`] for cells that VTK has no type for.
    pub fn start(plan: FieldPlan, folder: &Path, replace: Replace) -> Result<Self, Error> {
        let series = FieldSeries::create(folder, &plan.name, &plan.source.1, replace)?;
        Ok(Self {
            plan,
            series,
            largest: BTreeMap::new(),
        })
    }

    /// Takes off the next of its times that has come.
    pub fn take(&mut self, now: f64) -> Option<Due> {
        self.plan.timetable.take(now)
    }

    /// Writes the field at a state, evaluated there.
    ///
    /// # Errors
    /// [`Error::File`], also on a full disk.
    pub fn write(
        &mut self,
        system: &System,
        state: &State,
        evaluation: &Evaluation,
    ) -> Result<(), Error> {
        let body = &system.bodies[self.plan.body];
        let pose = state.pose(self.plan.body);
        let y = &state.coordinates[body.coordinates.clone()];
        let mut displacement = self.plan.field.displacement(y);
        let mut forces = vec![0.0; body.flexible.rows.len()];
        evaluation.write_interface_forces(system, self.plan.body, &mut forces);
        self.plan.field.add_residual(&forces, &mut displacement);
        for vector in &mut displacement {
            *vector = pose.axes * *vector;
        }
        let positions = self.plan.field.rigid_positions(&pose.origin, &pose.axes);
        let stresses = nodal_stresses(&body.flexible, self.plan.field.node_count(), y, &forces);
        for (name, _, values) in stresses.iter().filter(|(_, count, _)| *count == 1) {
            let largest = self.largest.entry(format!("{name}, largest so far"));
            let largest = largest.or_insert_with(|| values.clone());
            for (largest, value) in largest.iter_mut().zip(values) {
                *largest = largest.max(*value);
            }
        }
        let so_far = self.largest.iter().map(|(name, values)| Numbers {
            name,
            count: 1,
            values,
        });
        let numbers: Vec<Numbers<'_>> = (stresses.iter())
            .map(|(name, count, values)| Numbers {
                name,
                count: *count,
                values,
            })
            .chain(so_far)
            .collect();
        self.series.write(&FieldSnapshot {
            time: state.time,
            positions_world: &positions,
            vectors: &[("displacement", &displacement)],
            numbers: &numbers,
            marks: &[("recovered", self.plan.field.recovered())],
        })?;
        Ok(())
    }
}
