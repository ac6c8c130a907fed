//! A part on its way from the files of another program to a component.

mod node_order;

use dcb_formats::component::Source;
use dcb_formats::matrix::symmetrized;
use dcb_formats::mesh::{Dof, MatrixRow};
use dcb_formats::{Error, SparseMatrix};

use crate::interfaces::counted;
use crate::mesh::FoundMesh;
use crate::operators::{of_file, operator, restricted};
use crate::request::{Import, RowSource};
use crate::rows::displacement_axes::{rotated, transform};
use crate::rows::labels::{pattern, row_labels, rows_in_mesh_order, same_size};
use crate::rows::lost_positions::mesh_of_rows;
use crate::rows::order::{CommonRows, Owners};
use crate::source::matrices::{SourceMatrices, Sourced, file_name};
use crate::source::part_mesh::PartMesh;
use crate::stored::Rows;

/// A part on its way from files to a component.
pub(crate) struct Part {
    pub mesh: FoundMesh,
    pub mesh_format: String,
    pub description: Option<dcb_formats::Description>,
    /// Owner of each row.
    pub rows: Vec<MatrixRow>,
    pub stiffness: SparseMatrix,
    pub mass: SparseMatrix,
    /// Labels of rows that the mesh doesn't have, and how many rows they have.
    pub unknown: (Vec<u32>, usize),
    /// How the rows were tied to the nodes, in words.
    pub order: String,
    /// Whether rows follow the mesh because nothing says which is which.
    pub is_positional: bool,
    pub digits: Option<u32>,
    pub mass_digits: Option<u32>,
    /// Whether the mass was taken in the order of the stiffness's labelled rows, without labels of its own.
    pub mass_follows_stiffness: bool,
    pub formats: [&'static str; 2],
    pub sources: Vec<Source>,
    pub notes: Vec<String>,
    /// What a user may have to act on; these stay with the component.
    pub warnings: Vec<String>,
}

/// Nodes of labelled rows, with positions that follow from the stiffness.
fn mesh_without_file(
    stiffness: &SparseMatrix,
    rows: Option<&CommonRows>,
) -> Result<PartMesh, String> {
    let rows =
        rows.ok_or("a matrix says nothing of where its nodes are; name the mesh with --mesh FILE")?;
    Ok(PartMesh::without_file(mesh_of_rows(
        stiffness,
        &rows.labels,
    )?))
}

/// Owners of the rows by their labels or in the order of the mesh, and that order in words.
fn owners(
    request: &Import,
    labels: Option<(CommonRows, String)>,
    mesh: &PartMesh,
    size: usize,
) -> Result<(Owners, String), String> {
    let Some((common, order)) = labels else {
        let pattern = pattern(request, mesh.description.as_ref());
        let (rows, order) = rows_in_mesh_order(request, &mesh.found, &pattern, size)?;
        let owners = Owners {
            rows,
            ..Owners::default()
        };
        return Ok((owners, order));
    };
    Ok((Owners::of(&common.labels, &mesh.found), order))
}

impl Part {
    /// Puts both matrices into one order of rows, and ties these to the nodes. Without a mesh, positions follow from the stiffness where they can.
    pub fn of(
        request: &Import,
        matrices: SourceMatrices,
        mesh: Option<PartMesh>,
    ) -> Result<Self, Error> {
        let SourceMatrices {
            stiffness,
            mass,
            mut sources,
            mut notes,
        } = matrices;
        let digits = [stiffness.matrix.digits, mass.matrix.digits];
        let digits = digits.into_iter().flatten().min();
        let mass_digits = mass.matrix.digits;
        let is_labelled = |rows: &Rows| !matches!(rows, Rows::Unlabelled);
        let mass_follows_stiffness =
            is_labelled(&stiffness.matrix.rows) && !is_labelled(&mass.matrix.rows);
        let formats = [stiffness.format, mass.format];
        if let Some(mesh) = &mesh {
            sources.extend(mesh.sources.iter().cloned());
            notes.extend(mesh.found.notes.iter().cloned());
        }
        let found = mesh.as_ref().map(|mesh| &mesh.found);
        let labels = row_labels(
            request,
            &stiffness,
            &mass,
            found,
            (&mut sources, &mut notes),
        )?;
        let size = match &labels {
            Some((common, _)) => common.labels.len(),
            None => same_size(&stiffness, &mass)?,
        };
        let mut warnings = Vec::new();
        let mut made = |sourced: Sourced, new_rows: Option<&[u32]>| {
            let name = file_name(&sourced.path);
            let operator = operator(sourced.matrix, new_rows, size)
                .map_err(|message| of_file(&sourced.path, message))?;
            warnings.extend(operator.notes.iter().map(|note| format!("{name}: {note}")));
            Ok::<_, Error>(operator.matrix)
        };
        let common = labels.as_ref().map(|(common, _)| common);
        let stiffness = made(stiffness, common.and_then(|rows| rows.stiffness.as_deref()))?;
        let mass = made(mass, common.and_then(|rows| rows.mass.as_deref()))?;
        let of_stiffness = |message| of_file(&request.stiffness.path, message);
        let mesh = match mesh {
            Some(mesh) => mesh,
            None => {
                let mesh = mesh_without_file(&stiffness, common).map_err(of_stiffness)?;
                notes.extend(mesh.found.notes.iter().cloned());
                mesh
            }
        };
        let is_positional = labels.is_none();
        if !is_positional && matches!(request.dofs, Some(RowSource::Pattern(_))) {
            notes.push("--dofs isn't used: the rows have labels that say their directions".into());
        }
        let (owners, order) = owners(request, labels, &mesh, size).map_err(of_stiffness)?;
        notes.extend(owners.notes);
        Ok(Self {
            mesh: mesh.found,
            mesh_format: match &request.mesh {
                Some(path) => format!("{}, {}", file_name(path), mesh.format),
                None => mesh.format,
            },
            description: mesh.description,
            rows: owners.rows,
            stiffness,
            mass,
            unknown: (owners.unknown, owners.unknown_rows),
            order,
            is_positional,
            digits,
            mass_digits,
            mass_follows_stiffness,
            formats,
            sources,
            notes,
            warnings,
        })
    }

    /// Leaves out rows that are zero in stiffness and mass alike: rotations of solids in a g-set.
    pub fn drop_empty_rows(&mut self) {
        let is_empty = |matrix: &SparseMatrix, row: usize| {
            matrix.val_of_col(row).iter().all(|value| *value == 0.0)
        };
        let kept: Vec<usize> = (0..self.rows.len())
            .filter(|&row| !is_empty(&self.stiffness, row) || !is_empty(&self.mass, row))
            .collect();
        let dropped = self.rows.len() - kept.len();
        if dropped == 0 || kept.is_empty() {
            return;
        }
        let rotations = |owner: &MatrixRow| matches!(owner, MatrixRow::Nodal(Dof { direction, .. }) if direction.is_rotation());
        let of_rotations = self.rows.iter().filter(|owner| rotations(owner)).count();
        let left = kept
            .iter()
            .filter(|&&row| rotations(&self.rows[row]))
            .count();
        let which = match of_rotations - left == dropped {
            true => ", all of rotations,",
            false => "",
        };
        self.notes.push(format!(
            "{} that are zero in stiffness and mass{which} were left out",
            counted(dropped, "row")
        ));
        self.stiffness = restricted(&self.stiffness, &kept);
        self.mass = restricted(&self.mass, &kept);
        self.rows = kept.iter().map(|&row| self.rows[row]).collect();
    }

    /// Rotates rows along a node's own axes into those of the component.
    pub fn leave_displacement_axes(&mut self) -> Result<(), Error> {
        let transform = transform(&self.rows, &self.mesh.displacement_axes).map_err(|node| {
            Error::File {
                path: self.mesh_path(),
                message: format!(
                    "node {} has displacement axes of its own, but not all three translations (or rotations) have rows; such a node can't be rotated \
                     into the component's axes: let it move along the basic axes",
                    self.label(node)
                ),
            }
        })?;
        let Some(transform) = transform else {
            return Ok(());
        };
        for matrix in [&mut self.stiffness, &mut self.mass] {
            if let Some(turned) = rotated(matrix, &transform)
                && let Ok((turned, _)) = symmetrized(turned)
            {
                *matrix = turned;
            }
        }
        let count = self.mesh.displacement_axes.len();
        self.notes.push(format!(
            "{} with displacement axes of {} own: rotated into the component's axes",
            counted(count, "node"),
            if count == 1 { "its" } else { "their" }
        ));
        Ok(())
    }

    /// Whether each node of the mesh has rows.
    pub fn has_rows(&self) -> Vec<bool> {
        let mut has_rows = vec![false; self.mesh.points.len()];
        for owner in &self.rows {
            if let MatrixRow::Nodal(Dof { node, .. }) = owner {
                has_rows[*node as usize] = true;
            }
        }
        has_rows
    }

    /// Label of a node for people; its 1-based place where it has none.
    pub fn label(&self, node: u32) -> u32 {
        let labels = self.mesh.labels.as_ref();
        labels.map_or(node + 1, |labels| labels[node as usize])
    }

    pub fn mesh_path(&self) -> std::path::PathBuf {
        let name = self.sources.iter().find(|source| source.role == "mesh");
        name.map_or_else(Default::default, |source| source.file_name.clone().into())
    }

    /// The first ten labels of nodes.
    pub fn first_labels(&self, nodes: &[u32]) -> String {
        let labels: Vec<u32> = nodes.iter().map(|&node| self.label(node)).collect();
        first_ten(&labels)
    }
}

/// The first ten of some labels.
pub(crate) fn first_ten(labels: &[u32]) -> String {
    let named: Vec<String> = labels.iter().take(10).map(u32::to_string).collect();
    match labels.len() {
        0..=10 => named.join(", "),
        more => format!("{} and {} more", named.join(", "), more - 10),
    }
}
