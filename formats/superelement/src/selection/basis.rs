//! The reduced basis S as combinations of the whole's, and the superelement and its fields in this basis.

use crate::ResidualFilter;
use dcb_dense::symmetrized;
use dcb_formats::component::Role;
use dcb_formats::superelement::{
    BoundaryRow, Enrichment, InterfaceFrame, Modes, Moments, PartLoad, RecoveryBasis, Residual,
    Stiffening, Superelement,
};
use faer::Mat;

use super::NodeSelection;
use super::congruence::{congruent, over, squeezed, worked};
use super::interface::InterfaceSelection;
use super::kept_columns::KeptColumns;
use super::loaded_forces::loaded_forces;
use super::moments::{Kept, moments};
use super::projection::projector;
use super::record::RecordedSelection;
use super::statics::Statics;
use crate::Error;

/// Choice that a basis is made of.
pub(super) struct Choice<'a> {
    pub turn: Option<Mat<f64>>,
    pub modes: Vec<usize>,
    /// By the whole's interfaces.
    pub interfaces: &'a [InterfaceSelection],
    /// Rows that stay, interface by interface.
    pub rows: Vec<usize>,
    pub further: Vec<usize>,
    pub nodes: NodeSelection,
    /// Cycles per time.
    pub up_to: Option<f64>,
}

/// S and the choice that it was made of.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Basis {
    turn: Option<Mat<f64>>,
    modes: Vec<usize>,
    left_out: Vec<usize>,
    /// Rows that stay.
    rows: Vec<usize>,
    /// Interfaces that stay, by their places in the whole, and their roles.
    interfaces: Vec<(usize, Role)>,
    further: Vec<usize>,
    nodes: NodeSelection,
    statics: Statics,
    /// P, (n_b, rows that stay).
    forces: Mat<f64>,
    /// B, (n_b, forces).
    loaded: Mat<f64>,
    /// S, (n of the whole, n).
    columns: Mat<f64>,
    is_everything: bool,
    record: RecordedSelection,
}

impl Basis {
    /// # Errors
    /// [`Error::NoEigenvalues`] if the residual matrices aren't finite.
    pub(super) fn of(whole: &Superelement, choice: Choice<'_>) -> Result<Self, Error> {
        let Choice {
            turn,
            modes,
            interfaces: wanted,
            rows,
            further,
            nodes,
            up_to,
        } = choice;
        let (n_k, n_b) = (whole.mode_count(), whole.rows.len());
        let left_out: Vec<usize> = (0..n_k).filter(|k| !modes.contains(k)).collect();
        let shapes = turned(&whole.modes.interface_shapes, turn.as_ref());
        let statics = Statics::of(whole, shapes.as_ref(), &left_out);
        let of_rows: Vec<usize> = whole.rows.iter().map(|row| row.interface).collect();
        let forces = projector(&statics, &of_rows, wanted, &rows)?;

        let kept = KeptColumns {
            turn: turn.as_ref(),
            modes: &modes,
            left_out: &left_out,
            further: &further,
        };
        let columns = kept.columns(whole, &statics, &forces);
        let role = |wanted: &InterfaceSelection| match wanted {
            InterfaceSelection::Loaded | InterfaceSelection::LoadedAlong(_) => {
                Some(Role::Attachment)
            }
            InterfaceSelection::Observed => Some(Role::Output),
            InterfaceSelection::Dropped => None,
        };
        let interfaces: Vec<(usize, Role)> = (wanted.iter().enumerate())
            .filter_map(|(index, wanted)| Some((index, role(wanted)?)))
            .collect();
        let is_everything = turn.is_none()
            && left_out.is_empty()
            && rows.iter().copied().eq(0..n_b)
            && further.len() == whole.basis_count() - n_k - n_b
            && (wanted.iter().zip(&whole.interfaces)).all(|(wanted, frame)| match wanted {
                InterfaceSelection::Loaded => frame.role == Role::Attachment,
                InterfaceSelection::Observed => frame.role == Role::Output,
                InterfaceSelection::LoadedAlong(_) | InterfaceSelection::Dropped => false,
            });
        let record = RecordedSelection::of(whole, &modes, wanted, &further, up_to);
        Ok(Self {
            turn,
            modes,
            left_out,
            rows,
            interfaces,
            further,
            nodes,
            statics,
            forces,
            loaded: loaded_forces(whole, wanted),
            columns,
            is_everything,
            record,
        })
    }

    pub(super) fn statics(&self) -> &Statics {
        &self.statics
    }

    /// Rows of the whole that stay.
    pub(super) fn rows(&self) -> &[usize] {
        &self.rows
    }

    /// P, (n_b, rows that stay).
    pub(super) fn forces(&self) -> &Mat<f64> {
        &self.forces
    }

    /// # Errors
    /// [`Error::NoEigenvalues`] if the residual matrices aren't finite.
    pub(crate) fn superelement(&self, whole: &Superelement) -> Result<Superelement, Error> {
        if self.is_everything {
            return Ok(whole.clone());
        }
        let columns = self.columns.as_ref();
        let stiffening = &whole.stiffening;
        let derivation = self.record.derivation(whole, &self.rows);
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
                Some(enrichment) if !self.further.is_empty() => Some(self.enrichment(enrichment)),
                _ => None,
            },
            moments: self.moments(whole),
            loads: (whole.loads.iter())
                .map(|load| PartLoad {
                    work: worked(&load.work, columns),
                    ..load.clone()
                })
                .collect(),
            provenance: self.record.provenance(whole, &derivation),
            derivation: Some(derivation),
            ..whole.clone()
        })
    }

    /// Nodal fields.
    pub(crate) fn recovery(&self, whole: &RecoveryBasis) -> RecoveryBasis {
        let rows: Vec<usize> = (0..whole.dofs.len())
            .filter(|row| match &self.nodes {
                NodeSelection::All => true,
                NodeSelection::Only(nodes) => nodes.contains(&whole.dofs[*row].node),
            })
            .collect();
        let picked = |fields: &Mat<f64>, columns: &[usize]| {
            Mat::from_fn(rows.len(), columns.len(), |i, j| {
                fields[(rows[i], columns[j])]
            })
        };
        let every: Vec<usize> = (0..whole.modes.ncols()).collect();
        let modes = turned(&picked(&whole.modes, &every), self.turn.as_ref());
        let columns = |of: &[usize]| Mat::from_fn(rows.len(), of.len(), |i, j| modes[(i, of[j])]);
        let every: Vec<usize> = (0..whole.residual.ncols()).collect();
        let mut attached = picked(&whole.residual, &every);
        if !self.left_out.is_empty() {
            attached += columns(&self.left_out) * &self.statics.absorbed;
        }
        RecoveryBasis {
            dofs: rows.iter().map(|row| whole.dofs[*row]).collect(),
            modes: columns(&self.modes),
            residual: combinations(&attached, &self.forces),
            enrichment: match &whole.enrichment {
                Some(fields) if !self.further.is_empty() => Some(picked(fields, &self.further)),
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

    fn is_loaded(&self, whole: &Superelement, row: usize) -> bool {
        self.interfaces[self.interface_of(whole, row)].1 == Role::Attachment
    }

    fn modes(&self, whole: &Modes) -> Modes {
        let shapes = turned(&whole.interface_shapes, self.turn.as_ref());
        let (rows, modes) = (&self.rows, &self.modes);
        let of = |values: &[f64]| modes.iter().map(|mode| values[*mode]).collect();
        let left_out = self.left_out.iter().map(|mode| whole.eigenvalues[*mode]);
        Modes {
            eigenvalues: of(&whole.eigenvalues),
            damping: of(&whole.damping),
            interface_shapes: Mat::from_fn(rows.len(), modes.len(), |i, j| {
                shapes[(rows[i], modes[j])]
            }),
            first_omitted_eigenvalue: left_out.fold(whole.first_omitted_eigenvalue, f64::min),
            residual_damping: whole.residual_damping,
        }
    }

    fn moments(&self, whole: &Superelement) -> Option<Moments> {
        let of = whole.moments.as_ref()?;
        let observed: Vec<bool> = (self.rows.iter())
            .map(|row| !self.is_loaded(whole, *row))
            .collect();
        let shapes = turned(&whole.modes.interface_shapes, self.turn.as_ref());
        let kept = Kept {
            shapes: shapes.as_ref(),
            turn: self.turn.as_ref(),
            modes: &self.modes,
            left_out: &self.left_out,
            rows: &self.rows,
            observed: &observed,
            further: &self.further,
            forces: &self.loaded,
            is_cut: !self.record.selection.loaded_along.is_empty(),
        };
        Some(moments(whole, of, &kept))
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

    fn enrichment(&self, whole: &Enrichment) -> Enrichment {
        let (rows, further) = (&self.rows, &self.further);
        let names = whole.names.iter().enumerate();
        let kept = names.filter(|(place, _)| further.contains(place));
        let columns = self.columns.as_ref();
        Enrichment {
            names: kept.map(|(_, name)| name.clone()).collect(),
            interface_shapes: Mat::from_fn(rows.len(), further.len(), |i, j| {
                whole.interface_shapes[(rows[i], further[j])]
            }),
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
fn turned(columns: &Mat<f64>, turn: Option<&Mat<f64>>) -> Mat<f64> {
    match turn {
        Some(turn) => columns * turn,
        None => columns.clone(),
    }
}
