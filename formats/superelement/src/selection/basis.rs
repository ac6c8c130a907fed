//! The reduced basis S as combinations of the whole's, and the superelement and its fields in this basis.

use crate::ResidualFilter;
use dcb_dense::symmetrized;
use dcb_formats::component::Role;
use dcb_formats::superelement::{
    BoundaryRow, Enrichment, InterfaceFrame, Modes, PartLoad, RecoveryBasis, Residual, Stiffening,
    StressField, Superelement,
};
use faer::{Mat, MatRef, concat};

use super::congruence::{congruent, over, squeezed, worked};
use super::further_columns::FurtherColumns;
use super::interface::InterfaceSelection;
use super::projection::projector;
use super::statics::{Statics, acting, attached};
use super::{NodeSelection, Selection};
use crate::Error;

/// S and the selection that it was made of.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Basis {
    pub(super) selection: Selection,
    pub(super) left_out: Vec<usize>,
    /// Rows of the whole that stay, interface by interface.
    pub(super) rows: Vec<usize>,
    /// Interfaces that stay, by their places in the whole, and their roles.
    interfaces: Vec<(usize, Role)>,
    further: FurtherColumns,
    /// L_b Φ after the turn, (n_b, n_k).
    pub(super) shapes: Mat<f64>,
    pub(super) statics: Statics,
    /// P, (n_b, rows that stay).
    pub(super) forces: Mat<f64>,
}

impl Basis {
    /// Over these rows, interface by interface.
    ///
    /// # Errors
    /// [`Error::NoEigenvalues`] if the residual matrices aren't finite.
    pub(super) fn of(
        whole: &Superelement,
        of: &Selection,
        rows: Vec<usize>,
    ) -> Result<Self, Error> {
        let left_out: Vec<usize> = (0..whole.mode_count())
            .filter(|k| !of.modes.contains(k))
            .collect();
        let shapes = turned(whole.modes.interface_shapes.clone(), of.turn.as_ref());
        let acting = match of.truncation {
            Some(_) => attached(whole),
            None => acting(whole, shapes.as_ref()),
        };
        let statics = Statics::of(whole, shapes.as_ref(), &left_out, acting);
        let of_rows: Vec<usize> = whole.rows.iter().map(|row| row.interface).collect();
        let forces = projector(&statics, &of_rows, &of.interfaces, &rows)?;
        let role = |wanted: &InterfaceSelection| match wanted {
            InterfaceSelection::Loaded | InterfaceSelection::LoadedAlong(_) => {
                Some(Role::Attachment)
            }
            InterfaceSelection::Observed => Some(Role::Output),
            InterfaceSelection::Dropped => None,
        };
        let interfaces = of.interfaces.iter().enumerate();
        let unchanged = || FurtherColumns::unchanged(&of.enrichment, left_out.len());
        Ok(Self {
            interfaces: interfaces
                .filter_map(|(index, wanted)| Some((index, role(wanted)?)))
                .collect(),
            further: of.truncation.clone().unwrap_or_else(unchanged),
            selection: of.clone(),
            left_out,
            rows,
            shapes,
            statics,
            forces,
        })
    }

    fn is_everything(&self, whole: &Superelement) -> bool {
        let wanted = self.selection.interfaces.iter().zip(&whole.interfaces);
        self.selection.turn.is_none()
            && self.left_out.is_empty()
            && self.rows.iter().copied().eq(0..whole.rows.len())
            && self.further.places.len() == self.selection.further.len()
            && wanted.into_iter().all(|(wanted, frame)| match wanted {
                InterfaceSelection::Loaded => frame.role == Role::Attachment,
                InterfaceSelection::Observed => frame.role == Role::Output,
                InterfaceSelection::LoadedAlong(_) | InterfaceSelection::Dropped => false,
            })
    }

    fn has_further(&self) -> bool {
        self.selection.truncation.is_some() || !self.further.places.is_empty()
    }

    /// S, (n of the whole, n).
    fn columns(&self, whole: &Superelement) -> Mat<f64> {
        let (n_k, n_b) = (whole.mode_count(), whole.rows.len());
        let (forces, further, left_out) = (&self.forces, &self.further, &self.left_out);
        let (kept, attached) = (self.selection.modes.len(), forces.ncols());
        let turn = |k: usize, mode: usize| match &self.selection.turn {
            Some(turn) => turn[(k, mode)],
            None => f64::from(u8::from(k == mode)),
        };
        // Shares of the modes left out in attachments and further columns.
        let absorbed = &self.statics.absorbed * forces;
        let absorbed = concat![[absorbed, further.absorbed]];
        let absorbed = match self.selection.turn {
            Some(_) => Mat::from_fn(n_k, left_out.len(), |k, j| turn(k, left_out[j])) * absorbed,
            None => {
                let mut spread = Mat::zeros(n_k, absorbed.ncols());
                for (i, mode) in left_out.iter().enumerate() {
                    spread.row_mut(*mode).copy_from(absorbed.row(i));
                }
                spread
            }
        };
        let count = kept + absorbed.ncols();
        Mat::from_fn(whole.basis_count(), count, |i, j| {
            match (i.checked_sub(n_k), j.checked_sub(kept)) {
                (None, None) => turn(i, self.selection.modes[j]),
                (None, Some(j)) => absorbed[(i, j)],
                (Some(row), Some(j)) if row < n_b && j < attached => forces[(row, j)],
                (Some(i), Some(j)) if j >= attached && i == n_b + further.places[j - attached] => {
                    further.scale[j - attached]
                }
                _ => 0.0,
            }
        })
    }

    /// # Errors
    /// [`Error::NoEigenvalues`] if the residual matrices aren't finite.
    pub(super) fn superelement(&self, whole: &Superelement) -> Result<Superelement, Error> {
        if self.is_everything(whole) {
            return Ok(whole.clone());
        }
        let columns = self.columns(whole);
        let columns = columns.as_ref();
        let stiffening = &whole.stiffening;
        // Leaving out the highest modes alone isn't on record as a selection.
        let (derivation, provenance) = match self.selection.truncation {
            Some(_) => (whole.derivation.clone(), whole.provenance.clone()),
            None => self.selection.recorded(whole, &self.rows),
        };
        Ok(Superelement {
            interfaces: (self.interfaces.iter())
                .map(|(index, role)| InterfaceFrame {
                    role: *role,
                    ..whole.interfaces[*index].clone()
                })
                .collect(),
            rows: (self.rows.iter())
                .map(|row| BoundaryRow {
                    interface: self.interface_of(whole, *row),
                    ..whole.rows[*row]
                })
                .collect(),
            modes: self.modes(&whole.modes),
            residual: self.residual(whole)?,
            inertia: over(&whole.inertia, columns),
            stiffening: Stiffening {
                centrifugal: congruent(&stiffening.centrifugal, columns),
                interface: match stiffening.interface.is_empty() {
                    true => Vec::new(),
                    false => (self.rows.iter())
                        .map(|row| squeezed(&stiffening.interface[*row], columns))
                        .collect(),
                },
            },
            enrichment: match &whole.enrichment {
                Some(whole) if self.has_further() => Some(self.enrichment(whole, columns)),
                _ => None,
            },
            moments: match self.selection.truncation {
                Some(_) => None,
                None => self.moments(whole),
            },
            loads: (whole.loads.iter())
                .map(|load| PartLoad {
                    work: worked(&load.work, columns),
                    ..load.clone()
                })
                .collect(),
            stresses: (whole.stresses.iter())
                .map(|field| self.stress(whole, field, columns))
                .collect(),
            provenance,
            derivation,
            ..whole.clone()
        })
    }

    /// A stress field, and what the modes that go add to what is left out: (s φ)²/ω² each.
    fn stress(
        &self,
        whole: &Superelement,
        field: &StressField,
        columns: MatRef<'_, f64>,
    ) -> StressField {
        let over = field.over(columns);
        let of_modes = field.shapes.get(.., ..whole.mode_count()).to_owned();
        let of_modes = turned(of_modes, self.selection.turn.as_ref());
        let omitted = field.omitted.as_ref().map(|before| {
            let sum = |row: usize| {
                let gone = self
                    .left_out
                    .iter()
                    .map(|mode| of_modes[(row, *mode)].powi(2) / whole.modes.eigenvalues[*mode]);
                (before[row].powi(2) + gone.sum::<f64>()).sqrt()
            };
            (0..before.len()).map(sum).collect()
        });
        StressField { omitted, ..over }
    }

    /// Nodal fields.
    pub(super) fn recovery(&self, whole: &RecoveryBasis) -> RecoveryBasis {
        let rows: Vec<usize> = (0..whole.dofs.len())
            .filter(|row| match &self.selection.nodes {
                NodeSelection::All => true,
                NodeSelection::Only(nodes) => nodes.contains(&whole.dofs[*row].node),
            })
            .collect();
        let picked = |fields: &Mat<f64>| {
            Mat::from_fn(rows.len(), fields.ncols(), |i, j| fields[(rows[i], j)])
        };
        let modes = turned(picked(&whole.modes), self.selection.turn.as_ref());
        let columns = |of: &[usize]| Mat::from_fn(rows.len(), of.len(), |i, j| modes[(i, of[j])]);
        let left_out = columns(&self.left_out);
        let mut attached = picked(&whole.residual);
        if !self.left_out.is_empty() {
            attached += &left_out * &self.statics.absorbed;
        }
        RecoveryBasis {
            dofs: rows.iter().map(|row| whole.dofs[*row]).collect(),
            modes: columns(&self.selection.modes),
            residual: combinations(&attached, &self.forces),
            enrichment: match &whole.enrichment {
                Some(fields) if self.has_further() => {
                    let further = picked(fields);
                    Some(self.further.over(further.as_ref(), left_out.as_ref()))
                }
                _ => None,
            },
        }
    }

    /// Index of a row's interface among those that stay.
    fn interface_of(&self, whole: &Superelement, row: usize) -> usize {
        let interface = whole.rows[row].interface;
        self.interfaces
            .partition_point(|(index, _)| *index < interface)
    }

    pub(super) fn is_loaded(&self, whole: &Superelement, row: usize) -> bool {
        self.interfaces[self.interface_of(whole, row)].1 == Role::Attachment
    }

    fn modes(&self, whole: &Modes) -> Modes {
        let (rows, modes) = (&self.rows, &self.selection.modes);
        let of = |values: &[f64]| modes.iter().map(|mode| values[*mode]).collect();
        let left_out = self.left_out.iter().map(|mode| whole.eigenvalues[*mode]);
        Modes {
            eigenvalues: of(&whole.eigenvalues),
            damping: of(&whole.damping),
            interface_shapes: Mat::from_fn(rows.len(), modes.len(), |i, j| {
                self.shapes[(rows[i], modes[j])]
            }),
            first_omitted_eigenvalue: left_out.fold(whole.first_omitted_eigenvalue, f64::min),
            residual_damping: whole.residual_damping,
        }
    }

    fn residual(&self, whole: &Superelement) -> Result<Residual, Error> {
        let (rows, statics) = (&self.rows, &self.statics);
        let loaded: Vec<bool> = (rows.iter())
            .map(|row| self.is_loaded(whole, *row))
            .collect();
        let answers = &statics.flexibility * &self.forces;
        let flexibility = symmetrized(Mat::from_fn(rows.len(), rows.len(), |i, j| {
            match loaded[i] {
                true => answers[(rows[i], j)],
                false => 0.0,
            }
        }));
        let mass = symmetrized(self.forces.transpose() * &statics.mass * &self.forces);
        let mass0 = self.mass0(whole, &mass);
        let mass_diagonal0: Vec<f64> = (rows.iter().enumerate())
            .map(|(place, row)| match whole.residual.mass_diagonal0[*row] {
                felt if self.selection.truncation.is_some() => felt,
                felt if felt > 0.0 && loaded[place] => mass0[(place, place)].max(0.0),
                _ => 0.0,
            })
            .collect();
        let tolerance = whole.residual.tolerance;
        let filter = ResidualFilter::of(&mass_diagonal0, &mass0)?;
        let (transform, sigma_squared) = filter.directions(tolerance, &flexibility, &mass)?;
        let observes = self
            .interfaces
            .iter()
            .any(|(_, role)| *role == Role::Output);
        Ok(Residual {
            output_shapes: observes.then(|| {
                let seen = &statics.seen * &self.forces;
                Mat::from_fn(rows.len(), rows.len(), |i, j| seen[(rows[i], j)])
            }),
            flexibility,
            mass,
            mass_diagonal0,
            transform,
            sigma_squared,
            tolerance,
        })
    }

    /// M_res with no mode kept, of which `mass` is M_res with those that stay; zero where no force acts.
    pub(super) fn mass0(&self, whole: &Superelement, mass: &Mat<f64>) -> Mat<f64> {
        let Statics {
            mass: absorbed,
            mass0,
            ..
        } = &self.statics;
        Mat::from_fn(self.rows.len(), self.rows.len(), |i, j| {
            let (row, column) = (self.rows[i], self.rows[j]);
            match self.is_loaded(whole, row) && self.is_loaded(whole, column) {
                true => mass[(i, j)] + (mass0[(row, column)] - absorbed[(row, column)]),
                false => 0.0,
            }
        })
    }

    fn enrichment(&self, whole: &Enrichment, columns: MatRef<'_, f64>) -> Enrichment {
        let (rows, places) = (&self.rows, &self.further.places);
        let names = places.iter().filter_map(|place| whole.names.get(*place));
        let picked = |shapes: &Mat<f64>| {
            Mat::from_fn(rows.len(), shapes.ncols(), |i, j| shapes[(rows[i], j)])
        };
        let left_out = Mat::from_fn(rows.len(), self.left_out.len(), |i, j| {
            self.shapes[(rows[i], self.left_out[j])]
        });
        let further = picked(&whole.interface_shapes);
        Enrichment {
            names: names.cloned().collect(),
            interface_shapes: self.further.over(further.as_ref(), left_out.as_ref()),
            reduced_mass: symmetrized(squeezed(&whole.reduced_mass, columns)),
            reduced_stiffness: symmetrized(squeezed(&whole.reduced_stiffness, columns)),
        }
    }
}

/// A P for columns A; columns of P that are unit forces or nothing are copied.
fn combinations(columns: &Mat<f64>, forces: &Mat<f64>) -> Mat<f64> {
    let mut all = Mat::zeros(columns.nrows(), forces.ncols());
    for (mut column, force) in all.col_iter_mut().zip(forces.col_iter()) {
        let mut entries = (0..force.nrows()).filter(|row| force[*row] != 0.0);
        match (entries.next(), entries.next()) {
            (None, _) => {}
            (Some(row), None) if force[row] == 1.0 => column.copy_from(columns.col(row)),
            _ => column.copy_from(columns * force),
        }
    }
    all
}

/// Columns after the turn.
fn turned(columns: Mat<f64>, turn: Option<&Mat<f64>>) -> Mat<f64> {
    match turn {
        Some(turn) => columns * turn,
        None => columns,
    }
}
