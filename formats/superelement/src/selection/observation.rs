//! A superelement with some of its nodes as rows that are observed: what a selection costs there counts as at interfaces.

use dcb_formats::component::{InterfaceKind, Role};
use dcb_formats::superelement::{
    BoundaryRow, Enrichment, InterfaceFrame, Modes, PartLoad, RecoveryBasis, Residual, Stiffening,
    Superelement,
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
        let translations: Vec<usize> = (0..self.basis.dofs.len())
            .filter(|dof| !self.basis.dofs[*dof].direction.is_rotation())
            .collect();
        let picked = |fields: &Mat<f64>| {
            Mat::from_fn(translations.len(), fields.ncols(), |i, j| {
                fields[(translations[i], j)]
            })
        };
        let (n_k, n_b, more) = (whole.mode_count(), whole.rows.len(), translations.len());
        let n = whole.basis_count();
        // The columns of the new rows are zero.
        let spread = Mat::from_fn(n, n + more, |i, j| {
            let old = if j < n_k + n_b {
                j
            } else {
                j.wrapping_sub(more)
            };
            f64::from(u8::from(
                i == old && !(n_k + n_b..n_k + n_b + more).contains(&j),
            ))
        });
        let columns = spread.as_ref();
        let row = |dof: &usize| {
            let dof = self.basis.dofs[*dof];
            let place = self.positions.iter().find(|(node, _)| *node == dof.node);
            BoundaryRow {
                interface: whole.interfaces.len(),
                direction: dof.direction.index() as i64,
                node: dof.node.into(),
                position: place.map_or([0.0; 3], |(_, position)| *position),
            }
        };
        let residual = &whole.residual;
        let seen = residual
            .output_shapes
            .as_ref()
            .unwrap_or(&residual.flexibility);
        Superelement {
            interfaces: (whole.interfaces.iter().cloned())
                .chain([InterfaceFrame {
                    name: "nodes looked at".to_owned(),
                    kind: InterfaceKind::Nodes,
                    role: Role::Output,
                    position: [0.0; 3],
                    orientation: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
                }])
                .collect(),
            rows: (whole.rows.iter().copied())
                .chain(translations.iter().map(row))
                .collect(),
            modes: Modes {
                interface_shapes: above(
                    whole.modes.interface_shapes.as_ref(),
                    picked(&self.basis.modes).as_ref(),
                ),
                ..whole.modes.clone()
            },
            residual: Residual {
                flexibility: framed(&residual.flexibility, more),
                mass: framed(&residual.mass, more),
                mass_diagonal0: [residual.mass_diagonal0.clone(), vec![0.0; more]].concat(),
                transform: above(
                    residual.transform.as_ref(),
                    Mat::zeros(more, residual.transform.ncols()).as_ref(),
                ),
                output_shapes: Some({
                    let shapes = above(seen.as_ref(), picked(&self.basis.residual).as_ref());
                    Mat::from_fn(n_b + more, n_b + more, |i, j| {
                        if j < n_b { shapes[(i, j)] } else { 0.0 }
                    })
                }),
                ..residual.clone()
            },
            inertia: over(&whole.inertia, columns),
            stiffening: Stiffening {
                centrifugal: congruent(&whole.stiffening.centrifugal, columns),
                interface: match whole.stiffening.interface.is_empty() {
                    true => Vec::new(),
                    false => (whole.stiffening.interface.iter())
                        .map(|matrix| squeezed(matrix, columns))
                        .chain((0..more).map(|_| Mat::zeros(n + more, n + more)))
                        .collect(),
                },
            },
            enrichment: (whole.enrichment.as_ref()).map(|enrichment| {
                let fields = self.basis.enrichment.as_ref();
                let own = fields.map_or_else(
                    || Mat::zeros(more, enrichment.interface_shapes.ncols()),
                    picked,
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
            ..whole.clone()
        }
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
