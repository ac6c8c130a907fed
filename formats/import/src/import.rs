//! A component from other programs' files, step by step.

use std::path::Path;

use dcb_formats::Error;
use dcb_formats::component::{Component, ComponentDraft, ComponentFault, Units};
use dcb_formats::mesh::{DofMap, MatrixRow, Mesh};

use crate::interfaces::{counted, interfaces};
use crate::operators::of_file;
use crate::part::Part;
use crate::report::{ImportReport, MassCentre};
use crate::request::Import;
use crate::rigid_motions::Resistance;
use crate::rows::order::row_places;
use crate::source::matrices::{SourceMatrices, file_name};
use crate::source::named_file::NamedFile;
use crate::source::part_mesh::{PartMesh, is_json};

/// A component, and what was done to make it.
#[derive(Debug)]
pub struct Imported {
    /// Checked component. Its nodes are in the order of the rows.
    pub component: Component,
    /// For the user.
    pub report: ImportReport,
}

/// Reads matrices and mesh, and ties them together.
///
/// # Errors
/// What is wrong with the files, or doubtful: nothing is guessed without the proof that K resists no rigid motion.
pub fn import(request: &Import) -> Result<Imported, Error> {
    if let (None, Some(mesh)) = (&request.units, &request.mesh)
        && mesh.is_file()
        && !is_json(mesh)?
    {
        return Err(no_units(&request.stiffness));
    }
    let matrices = SourceMatrices::read(&request.stiffness, request.mass.as_ref())?;
    let mesh = request.mesh.as_deref().map(PartMesh::read).transpose()?;
    let mut part = Part::of(request, matrices, mesh)?;
    part.drop_empty_rows();
    part.leave_displacement_axes()?;
    let resistance = part.proven(request)?;
    part.check_mass(request)?;
    part.order_nodes();
    part.component(request, resistance)
}

impl Part {
    fn component(mut self, request: &Import, resistance: Resistance) -> Result<Imported, Error> {
        let usage = |message: String| Error::File {
            path: request
                .mesh
                .clone()
                .unwrap_or_else(|| request.stiffness.path.clone()),
            message,
        };
        let described = self.description.take();
        let from_sets = request.interfaces.is_some() || described.is_none();
        let made = match from_sets {
            true => {
                let has_rows = self.has_rows();
                let made = interfaces(
                    (&self.mesh.sets, &self.mesh.cell_sets),
                    request.interfaces.as_deref(),
                    |nodes| can_be_interface(nodes, &has_rows),
                )
                .map_err(usage)?;
                self.notes.extend(made.notes);
                for interface in &made.interfaces {
                    self.refuse_nodes_without_rows(&interface.name, &interface.nodes, &has_rows)
                        .map_err(usage)?;
                }
                made.interfaces
            }
            false => Vec::new(),
        };
        if let (Some(asked), Some(described)) = (&request.units, &described)
            && asked != &described.units
        {
            let words = |units: &Units| format!("{},{},{}", units.length, units.mass, units.time);
            return Err(usage(format!(
                "says the units {}, but --units {} is asked for; leave --units out, or take the units out of the file's `component`",
                words(&described.units),
                words(asked)
            )));
        }
        let units = request
            .units
            .clone()
            .or_else(|| described.as_ref().map(|described| described.units.clone()))
            .ok_or_else(|| no_units(&request.stiffness))?;
        let name = request
            .name
            .clone()
            .or_else(|| described.as_ref().map(|described| described.name.clone()))
            .unwrap_or_else(|| stem(&request.stiffness.path));
        let (mesh, dofs) = self
            .mesh_and_dofs()
            .map_err(|message| of_file(&request.stiffness.path, message))?;
        let report = self.report(&mesh, resistance, &units);
        let mut draft = ComponentDraft {
            interfaces: made,
            sources: [self.sources, vec![request.options()]].concat(),
            notes: self.warnings,
            ..ComponentDraft::new(&name, units, (mesh, dofs), self.stiffness, self.mass)
        };
        if let Some(described) = described {
            draft.damping = described.damping;
            if !from_sets {
                draft.interfaces = described.interfaces;
            }
        }
        let component =
            Component::checked(draft).map_err(|ComponentFault { place, message }| {
                of_file(&request.stiffness.path, format!("{place}: {message}"))
            })?;
        Ok(Imported { component, report })
    }

    /// An interface follows its nodes, which need rows for that.
    fn refuse_nodes_without_rows(
        &self,
        set: &str,
        nodes: &[u32],
        has_rows: &[bool],
    ) -> Result<(), String> {
        let without: Vec<u32> = (nodes.iter().copied())
            .filter(|node| !has_rows[*node as usize])
            .collect();
        match without.is_empty() {
            true => Ok(()),
            false => Err(format!(
                "the node set \"{set}\" has {} without rows (labels {}): they depend on others or are held; name the node that leads them, or another set",
                counted(without.len(), "node"),
                self.first_labels(&without)
            )),
        }
    }

    fn report(&self, mesh: &Mesh, resistance: Resistance, units: &Units) -> ImportReport {
        let internal = self
            .rows
            .iter()
            .filter(|owner| **owner == MatrixRow::Internal)
            .count();
        let places = row_places(&self.mesh, &self.rows);
        let sets = mesh.point_sets.iter();
        ImportReport {
            formats: [
                self.formats[0].to_owned(),
                self.formats[1].to_owned(),
                self.mesh_format.clone(),
            ],
            rows: self.rows.len(),
            internal_rows: internal,
            nodes: self.mesh.points.len(),
            digits: self.digits,
            order: self.order.clone(),
            resistance: resistance.worst(),
            mass_centre: MassCentre::of(&self.mass, &places),
            units: units.clone(),
            sets: sets
                .map(|(name, nodes)| (name.clone(), nodes.len()))
                .collect(),
            notes: self.notes.clone(),
        }
    }

    /// The mesh of the component and the owner of each row.
    fn mesh_and_dofs(&self) -> Result<(Mesh, DofMap), String> {
        let directions = self
            .rows
            .iter()
            .filter_map(|owner| owner.dof())
            .map(|dof| dof.direction);
        let mesh = self.mesh.of_component(directions);
        let dofs = DofMap::new(self.rows.clone(), self.mesh.points.len())
            .map_err(|error| error.to_string())?;
        Ok((mesh, dofs))
    }
}

/// A set that may become an interface by itself: nodes with rows, not all of them.
fn can_be_interface(nodes: &[u32], has_rows: &[bool]) -> bool {
    let all = has_rows.iter().filter(|has_rows| **has_rows).count();
    !nodes.is_empty() && nodes.len() < all && nodes.iter().all(|&node| has_rows[node as usize])
}

fn no_units(stiffness: &NamedFile) -> Error {
    of_file(
        &stiffness.path,
        "no file says the units of these numbers; name length, mass and time, for example --units m,kg,s or --units mm,t,s".into(),
    )
}

/// Name of a file without folder and endings.
pub(crate) fn stem(path: &Path) -> String {
    let name = file_name(path);
    let stem = name.split('.').next().unwrap_or_default();
    match stem.is_empty() {
        true => "part".into(),
        false => stem.to_owned(),
    }
}
