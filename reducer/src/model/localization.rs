//! Boundary localization L_b: the interfaces of a component as rows over its dofs.
//!
//! Rows run interface by interface, then node by node, then by direction (translations before rotations in a frame); rows
//! of an explicit boundary come last. Directions are those of the component's axes. A rigid interface's rows select the
//! coordinates of the frame that [`crate::model::condensation`] puts in place of its nodes, so rows here are over *model* dofs.

use std::ops::Range;

use dcb_formats::Component;
use dcb_formats::component::{EXPLICIT_BOUNDARY, Interface, InterfaceKind, Role};
use dcb_formats::mesh::Direction;
use dcb_formats::superelement::row_name;
use faer::Mat;

use crate::error::{Error, InterfaceRefusal};
use crate::model::condensation::Model;
use crate::model::frame::{
    FitDofs, FrameFit, cannot_carry, frame_directions, merge_entries, weighted_centroid,
};
use crate::model::surface::weights_of;

/// A row of L_b.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Index of its interface in [`Localization::interfaces`].
    pub interface: usize,
    /// Direction; `None` for a row of an explicit boundary.
    pub direction: Option<Direction>,
    /// Node; `None` for a frame or an explicit row.
    pub node: Option<u32>,
    /// Reference position, component coordinates.
    pub position: [f64; 3],
    /// (model dof, coefficient), ascending.
    pub coefficients: Vec<(u32, f64)>,
}

/// An interface as it ended up.
#[derive(Clone, Debug, PartialEq)]
pub struct Placed {
    /// Name.
    pub name: String,
    /// Kind.
    pub kind: InterfaceKind,
    /// Role.
    pub role: Role,
    /// Reference position, component coordinates.
    pub position: [f64; 3],
    /// The frame's axes, one a column.
    pub orientation: [[f64; 3]; 3],
}

/// All rows of L_b.
#[derive(Clone, Debug, PartialEq)]
pub struct Localization {
    /// Interfaces in row order.
    pub interfaces: Vec<Placed>,
    /// Rows, n_b of them.
    pub rows: Vec<Row>,
}

impl Localization {
    /// Turns the component's interfaces into rows over the model's dofs.
    ///
    /// # Errors
    /// [`Error::Interface`] naming the interface when a node lacks a direction, or the nodes can't carry a moment that is asked for.
    pub fn of(component: &Component, model: &Model) -> Result<Self, Error> {
        let mut localization = Self {
            interfaces: Vec::new(),
            rows: Vec::new(),
        };
        for (index, interface) in component.interfaces.iter().enumerate() {
            let position = match interface.kind {
                InterfaceKind::Nodes => localization.add_nodes(component, model, interface)?,
                InterfaceKind::Average => localization.add_average(component, model, interface)?,
                InterfaceKind::Rigid | InterfaceKind::Boundary => {
                    localization.add_rigid(model, interface, index)?
                }
            };
            localization.interfaces.push(Placed {
                name: interface.name.clone(),
                kind: interface.kind,
                role: interface.role,
                position,
                orientation: columns_of(interface.axes),
            });
        }
        localization.add_explicit(component, model);
        Ok(localization)
    }

    /// n_b.
    pub fn len(&self) -> usize {
        self.rows.len()
    }

    /// Whether there is no row.
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// Whether forces act through a row, so that it gets an attachment column.
    pub fn is_attachment(&self, row: usize) -> bool {
        self.interfaces[self.rows[row].interface].role == Role::Attachment
    }

    /// Name of a row for messages, for example `big-end/rx` or `sensor/ux at node 17`.
    pub fn row_name(&self, row: usize) -> String {
        let Row {
            interface,
            direction,
            node,
            ..
        } = &self.rows[row];
        let name = &self.interfaces[*interface].name;
        let first = self
            .rows
            .partition_point(|other| other.interface < *interface);
        row_name(name, *direction, *node, row - first)
    }

    /// Some rows' columns of `L_bᵀ` over the model's dofs, (n, count); columns of output rows are zero.
    pub fn attachment_columns(&self, model_dofs: usize, rows: Range<usize>) -> Mat<f64> {
        let mut columns = Mat::zeros(model_dofs, rows.len());
        let first = rows.start;
        for row in rows.filter(|row| self.is_attachment(*row)) {
            for (dof, value) in &self.rows[row].coefficients {
                columns[(*dof as usize, row - first)] = *value;
            }
        }
        columns
    }

    /// Work of unit forces at some rows along motions x, (n, k): `xᵀ L_bᵀ`, (k, count); zero for output rows.
    pub fn work(&self, x: faer::MatRef<'_, f64>, rows: Range<usize>) -> Mat<f64> {
        let mut work = Mat::zeros(x.ncols(), rows.len());
        let first = rows.start;
        for row in rows.filter(|row| self.is_attachment(*row)) {
            for (dof, value) in &self.rows[row].coefficients {
                for k in 0..x.ncols() {
                    work[(k, row - first)] += value * x[(*dof as usize, k)];
                }
            }
        }
        work
    }

    /// `L_b x`, (n_b, k), for a block over the model's dofs.
    pub fn apply(&self, x: faer::MatRef<'_, f64>) -> Mat<f64> {
        Mat::from_fn(self.len(), x.ncols(), |row, column| {
            self.rows[row]
                .coefficients
                .iter()
                .map(|(dof, value)| value * x[(*dof as usize, column)])
                .sum()
        })
    }

    fn add_nodes(
        &mut self,
        component: &Component,
        model: &Model,
        interface: &Interface,
    ) -> Result<[f64; 3], Error> {
        for node in &interface.nodes {
            let wanted: Vec<Direction> = match &interface.directions {
                Some(directions) => directions.clone(),
                None => Direction::ALL
                    .into_iter()
                    .filter(|d| component.dofs.row(*node, *d).is_some())
                    .collect(),
            };
            if wanted.is_empty() {
                return Err(InterfaceRefusal::NodeWithoutDof {
                    interface: interface.name.clone(),
                    node: *node,
                }
                .into());
            }
            for direction in wanted {
                let row = component.dofs.row(*node, direction).ok_or_else(|| {
                    InterfaceRefusal::NoDirection {
                        interface: interface.name.clone(),
                        node: *node,
                        direction,
                    }
                })?;
                self.rows.push(Row {
                    interface: self.interfaces.len(),
                    direction: Some(direction),
                    node: Some(*node),
                    position: component.mesh.position(*node),
                    coefficients: model.condensed_row(&[(row as u32, 1.0)]),
                });
            }
        }
        Ok(weighted_centroid(
            component,
            &interface.nodes,
            &vec![1.0; interface.nodes.len()],
        ))
    }

    fn add_average(
        &mut self,
        component: &Component,
        model: &Model,
        interface: &Interface,
    ) -> Result<[f64; 3], Error> {
        let translations = component.dimension().coordinate_count();
        for node in &interface.nodes {
            for direction in &Direction::ALL[..translations] {
                if component.dofs.row(*node, *direction).is_none() {
                    return Err(InterfaceRefusal::NoTranslation {
                        interface: interface.name.clone(),
                        node: *node,
                        direction: *direction,
                    }
                    .into());
                }
            }
        }
        let weights = weights_of(component, interface)?;
        let position = interface
            .position
            .unwrap_or_else(|| weighted_centroid(component, &interface.nodes, &weights));
        let mut fit = FrameFit::new(
            component,
            &interface.nodes,
            &weights,
            position,
            FitDofs::Translations,
        );
        if fit.is_deficient() && component.dofs.has_rotations() {
            fit = fit.with_nodal_rotations(component, &interface.nodes, &weights);
        }
        for direction in frame_directions(component, interface) {
            if fit.leaves_open(direction) {
                let possible = fit.determined();
                return Err(cannot_carry(component, interface, direction, &possible).into());
            }
            let coefficients = fit.row(direction);
            self.push_frame_row(direction, position, model.condensed_row(&coefficients));
        }
        Ok(position)
    }

    fn add_rigid(
        &mut self,
        model: &Model,
        interface: &Interface,
        index: usize,
    ) -> Result<[f64; 3], Error> {
        let frame = (model.frame_of(index)).ok_or_else(|| InterfaceRefusal::NoFrame {
            interface: interface.name.clone(),
            kind: interface.kind,
        })?;
        for direction in &frame.wanted {
            if let Some(dof) = frame.dof(*direction) {
                self.push_frame_row(*direction, frame.position, vec![(dof, 1.0)]);
            }
        }
        Ok(frame.position)
    }

    fn push_frame_row(
        &mut self,
        direction: Direction,
        position: [f64; 3],
        coefficients: Vec<(u32, f64)>,
    ) {
        let interface = self.interfaces.len();
        self.rows.push(Row {
            interface,
            direction: Some(direction),
            node: None,
            position,
            coefficients,
        });
    }

    fn add_explicit(&mut self, component: &Component, model: &Model) {
        let Some(matrix) = &component.explicit_boundary else {
            return;
        };
        let mut rows: Vec<Vec<(u32, f64)>> = vec![Vec::new(); matrix.nrows()];
        for column in 0..matrix.ncols() {
            for (row, value) in matrix
                .row_idx_of_col_raw(column)
                .iter()
                .zip(matrix.val_of_col(column))
            {
                rows[*row as usize].push((column as u32, *value));
            }
        }
        for entries in rows {
            let entries = merge_entries(entries);
            let (nodes, weights): (Vec<u32>, Vec<f64>) = entries
                .iter()
                .filter_map(|(row, value)| {
                    Some((component.dofs.dof(*row as usize)?.node, value.abs()))
                })
                .unzip();
            self.rows.push(Row {
                interface: self.interfaces.len(),
                direction: None,
                node: None,
                position: weighted_centroid(component, &nodes, &weights),
                coefficients: model.condensed_row(&entries),
            });
        }
        self.interfaces.push(Placed {
            name: EXPLICIT_BOUNDARY.into(),
            kind: InterfaceKind::Boundary,
            role: Role::Attachment,
            position: weighted_centroid(
                component,
                &all_nodes(component),
                &vec![1.0; component.mesh.node_count()],
            ),
            orientation: columns_of(None),
        });
    }
}

fn all_nodes(component: &Component) -> Vec<u32> {
    (0..component.mesh.node_count() as u32).collect()
}

fn columns_of(axes: Option<[[f64; 3]; 3]>) -> [[f64; 3]; 3] {
    let rows = axes.unwrap_or([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]);
    let mut columns = [[0.0; 3]; 3];
    for (i, row) in rows.iter().enumerate() {
        for (j, value) in row.iter().enumerate() {
            columns[j][i] = *value;
        }
    }
    columns
}
