//! A superelement with some of its nodes as observed rows: errors of a selection at these nodes count as those at interfaces.

use dcb_formats::component::{InterfaceKind, Role};
use dcb_formats::superelement::{
    BoundaryRow, Enrichment, InterfaceFrame, Modes, PartLoad, RecoveryBasis, Residual, Stiffening,
    StressField, Superelement,
};
use faer::{Mat, MatRef};

use super::congruence::{congruent, over, squeezed, worked};
use super::{InterfaceSelection, Selection};

/// Displacements of single nodes.
#[derive(Clone, Debug, PartialEq)]
pub struct ObservedNodes {
    /// Nodal fields of these nodes.
    pub basis: RecoveryBasis,
    /// Where each node is at rest, body frame.
    pub positions: Vec<(u32, [f64; 3])>,
}

impl ObservedNodes {
    /// The superelement with an output interface more, whose rows are these nodes' translations.
    pub fn on(&self, whole: &Superelement) -> Superelement {
        let translations = self.translations();
        let more = translations.len();
        let columns = zero_columns_inserted(whole, more);
        let columns = columns.as_ref();
        let observed = InterfaceFrame {
            name: "nodes looked at".to_owned(),
            kind: InterfaceKind::Nodes,
            role: Role::Output,
            position: [0.0; 3],
            orientation: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        };
        let interfaces = whole.interfaces.iter().cloned();
        let new_rows = (translations.iter()).map(|dof| self.row(*dof, whole.interfaces.len()));
        Superelement {
            interfaces: interfaces.chain([observed]).collect(),
            rows: whole.rows.iter().copied().chain(new_rows).collect(),
            modes: Modes {
                interface_shapes: above(
                    whole.modes.interface_shapes.as_ref(),
                    picked(&self.basis.modes, &translations).as_ref(),
                ),
                ..whole.modes.clone()
            },
            residual: self.residual(&whole.residual, &translations),
            inertia: over(&whole.inertia, columns),
            stiffening: stiffening(&whole.stiffening, columns, more),
            enrichment: (whole.enrichment.as_ref()).map(|enrichment| {
                let fields = self.basis.enrichment.as_ref();
                let own = fields.map_or_else(
                    || Mat::zeros(more, enrichment.interface_shapes.ncols()),
                    |fields| picked(fields, &translations),
                );
                Enrichment {
                    interface_shapes: above(enrichment.interface_shapes.as_ref(), own.as_ref()),
                    reduced_mass: squeezed(&enrichment.reduced_mass, columns),
                    reduced_stiffness: squeezed(&enrichment.reduced_stiffness, columns),
                    ..enrichment.clone()
                }
            }),
            moments: None,
            loads: (whole.loads.iter())
                .map(|load| PartLoad {
                    work: worked(&load.work, columns),
                    ..load.clone()
                })
                .collect(),
            stresses: (whole.stresses.iter())
                .map(|field| StressField {
                    omitted: field.omitted.clone(),
                    ..field.over(columns)
                })
                .collect(),
            ..whole.clone()
        }
    }

    /// Translational dofs of the nodes, by their places in the fields.
    fn translations(&self) -> Vec<usize> {
        (0..self.basis.dofs.len())
            .filter(|dof| !self.basis.dofs[*dof].direction.is_rotation())
            .collect()
    }

    /// The row of a dof, at an interface.
    fn row(&self, dof: usize, interface: usize) -> BoundaryRow {
        let dof = self.basis.dofs[dof];
        let place = self.positions.iter().find(|(node, _)| *node == dof.node);
        BoundaryRow {
            interface,
            direction: dof.direction.index() as i64,
            node: dof.node.into(),
            position: place.map_or([0.0; 3], |(_, position)| *position),
        }
    }

    /// The residual attachments with the new rows: no force acts on these.
    fn residual(&self, residual: &Residual, translations: &[usize]) -> Residual {
        let (n_b, more) = (residual.flexibility.nrows(), translations.len());
        let seen = (residual.output_shapes.as_ref()).unwrap_or(&residual.flexibility);
        let own = picked(&self.basis.residual, translations);
        let shapes = above(seen.as_ref(), own.as_ref());
        Residual {
            flexibility: framed(&residual.flexibility, more),
            mass: framed(&residual.mass, more),
            mass_diagonal0: [residual.mass_diagonal0.clone(), vec![0.0; more]].concat(),
            transform: above(
                residual.transform.as_ref(),
                Mat::zeros(more, residual.transform.ncols()).as_ref(),
            ),
            output_shapes: Some(Mat::from_fn(n_b + more, n_b + more, |i, j| {
                if j < n_b { shapes[(i, j)] } else { 0.0 }
            })),
            ..residual.clone()
        }
    }
}

/// Rows of fields.
fn picked(fields: &Mat<f64>, rows: &[usize]) -> Mat<f64> {
    Mat::from_fn(rows.len(), fields.ncols(), |i, j| fields[(rows[i], j)])
}

/// The basis with so many columns of zeros more, those of the new rows; (n, n + more).
fn zero_columns_inserted(whole: &Superelement, more: usize) -> Mat<f64> {
    let (n, before) = (whole.basis_count(), whole.mode_count() + whole.rows.len());
    Mat::from_fn(n, n + more, |i, j| {
        let old = if j < before { j } else { j.wrapping_sub(more) };
        f64::from(u8::from(i == old && !(before..before + more).contains(&j)))
    })
}

fn stiffening(of: &Stiffening, columns: MatRef<'_, f64>, more: usize) -> Stiffening {
    let n = columns.ncols();
    Stiffening {
        centrifugal: congruent(&of.centrifugal, columns),
        interface: match of.interface.is_empty() {
            true => Vec::new(),
            false => (of.interface.iter())
                .map(|matrix| squeezed(matrix, columns))
                .chain((0..more).map(|_| Mat::zeros(n, n)))
                .collect(),
        },
    }
}

impl Selection {
    /// The same selection of a superelement that [`ObservedNodes::on`] has made, with its nodes observed.
    pub fn observing(&self, observed: &Superelement) -> Self {
        let mut interfaces = self.interfaces.clone();
        interfaces.push(InterfaceSelection::Observed);
        Self {
            interfaces,
            places: super::Place::all(observed),
            ..self.clone()
        }
    }
}

/// Rows above rows.
fn above(upper: MatRef<'_, f64>, lower: MatRef<'_, f64>) -> Mat<f64> {
    Mat::from_fn(upper.nrows() + lower.nrows(), upper.ncols(), |i, j| match i
        .checked_sub(upper.nrows())
    {
        None => upper[(i, j)],
        Some(i) => lower[(i, j)],
    })
}

/// With so many rows and columns of zeros more.
fn framed(matrix: &Mat<f64>, more: usize) -> Mat<f64> {
    let n = matrix.nrows();
    Mat::from_fn(n + more, n + more, |i, j| {
        if i < n && j < n { matrix[(i, j)] } else { 0.0 }
    })
}
