//! A superelement with fewer modes, made of one with more: neither matrices of the component nor its nodes are needed.
//!
//! What a mode does to the interfaces statically goes into the residual flexibility when the mode is left out (`docs/theory.md` §3
//! and §6). With C = L_b Φ over the modes left out, zero in the rows of output interfaces, and W = Ω⁻² Cᵀ:
//!
//! ```text
//! X'     = X + Φ W                    G_res L_bᵀ over the modes kept
//! F_res' = F_res + C Ω⁻² Cᵀ           = L_b X'
//! M_res' = M_res + C Ω⁻⁴ Cᵀ           = X'ᵀ M X', because Φᵀ M Φ = I and Φᵀ M X = 0
//! Ψ'     = Ψ S                        S = [I 0; 0 W; 0 I], rows: modes kept, modes left out, attachments
//! ```
//! so that L1, I1, I3 become L1 S and so on, L3, J2 and the stiffening matrices Sᵀ L3 S. T_r and σ² are found anew by the filter of
//! theory §6. Further columns follow in S ([`super::truncated_columns`]). The result is what the reducer makes of the component with so many modes, to
//! rounding (`tests/reduction/selection/fewer_modes.rs`).

use crate::{ResidualFilter, extended_to_gap};
use dcb_dense::symmetrized;
use dcb_formats::component::Role;
use dcb_formats::superelement::{
    Enrichment, Inertia, InterfaceDirections, Modes, PartLoad, RecoveryBasis, Residual, Stiffening,
    Superelement,
};
use faer::{Mat, MatRef};

use super::truncated_columns::TruncatedColumns;
use crate::Error;

/// Which modes of a superelement stay, and what becomes of the others.
#[derive(Clone, Debug, PartialEq)]
pub struct ModeTruncation {
    /// Modes that stay, the lowest.
    kept: usize,
    /// W = Ω⁻² Cᵀ, (modes left out, n_b).
    absorbed: Mat<f64>,
    /// What becomes of further columns, if there are any.
    further: Option<TruncatedColumns>,
}

impl ModeTruncation {
    /// Keeps the `wanted` lowest modes: more where that would cut a multiple root or leave out a motion without stiffness,
    /// all where there are no more.
    ///
    /// # Errors
    /// [`Error::NotHandled`] if modes are to be left out of a superelement with a reduced number of interface directions, or with further columns
    /// that aren't those of `reduce --enrich`, or of which fewer modes need more: what these would become isn't in the file.
    pub fn of(superelement: &Superelement, wanted: usize) -> Result<Self, Error> {
        let eigenvalues = &superelement.modes.eigenvalues;
        let kept = extended_to_gap(eigenvalues, wanted.max(without_stiffness(eigenvalues)));
        let further = match &superelement.enrichment {
            _ if kept == eigenvalues.len() => None,
            enrichment => {
                refuse_reduced_interfaces(superelement)?;
                let further = enrichment.as_ref();
                further
                    .map(|further| TruncatedColumns::of(superelement, further, kept))
                    .transpose()?
            }
        };
        Ok(Self {
            kept,
            absorbed: absorbed_from(superelement, kept),
            further,
        })
    }

    /// How many modes stay.
    pub fn kept(&self) -> usize {
        self.kept
    }

    /// The superelement with these modes; the one that the truncation was made for.
    ///
    /// # Errors
    /// [`Error::NoEigenvalues`] if the residual matrices aren't finite.
    pub fn superelement(&self, whole: &Superelement) -> Result<Superelement, Error> {
        if self.absorbed.nrows() == 0 {
            return Ok(whole.clone());
        }
        let basis = self.basis();
        Ok(Superelement {
            modes: Modes {
                eigenvalues: whole.modes.eigenvalues[..self.kept].to_vec(),
                damping: whole.modes.damping[..self.kept].to_vec(),
                interface_shapes: whole.modes.interface_shapes.get(.., ..self.kept).to_owned(),
                first_omitted_eigenvalue: whole.modes.eigenvalues[self.kept],
                ..whole.modes.clone()
            },
            residual: self.residual(whole)?,
            moments: None,
            inertia: over(&whole.inertia, basis.as_ref()),
            stiffening: Stiffening {
                centrifugal: congruent(&whole.stiffening.centrifugal, basis.as_ref()),
                interface: congruent(&whole.stiffening.interface, basis.as_ref()),
            },
            enrichment: self.enrichment(whole, basis.as_ref()),
            loads: whole
                .loads
                .iter()
                .map(|load| PartLoad {
                    work: worked(&load.work, basis.as_ref()),
                    ..load.clone()
                })
                .collect(),
            ..whole.clone()
        })
    }

    /// Its nodal fields.
    pub fn recovery(&self, whole: &RecoveryBasis) -> RecoveryBasis {
        let left_out = whole.modes.get(.., self.kept..);
        let further = match &self.further {
            None => whole.enrichment.clone(),
            Some(further) => {
                (whole.enrichment.as_ref()).map(|fields| further.over(fields.as_ref(), left_out))
            }
        };
        RecoveryBasis {
            dofs: whole.dofs.clone(),
            modes: whole.modes.get(.., ..self.kept).to_owned(),
            residual: &whole.residual + left_out * &self.absorbed,
            enrichment: further,
        }
    }

    /// S, (n, n after it).
    fn basis(&self) -> Mat<f64> {
        let (kept, left_out, n_b) = (self.kept, self.absorbed.nrows(), self.absorbed.ncols());
        let n_k = kept + left_out;
        let (n_x, further) = (self.further.as_ref()).map_or((0, 0), TruncatedColumns::counts);
        let mut basis = Mat::zeros(n_k + n_b + n_x, kept + n_b + further);
        let mut block = |row: usize, column: usize, entries: MatRef<'_, f64>| {
            basis
                .as_mut()
                .submatrix_mut(row, column, entries.nrows(), entries.ncols())
                .copy_from(entries);
        };
        let identity = Mat::identity;
        block(0, 0, identity(kept, kept).as_ref());
        block(kept, kept, self.absorbed.as_ref());
        block(n_k, kept, identity(n_b, n_b).as_ref());
        if let Some(columns) = &self.further {
            block(kept, kept + n_b, columns.absorbed());
            let shares = Mat::from_fn(n_x, further, |place, j| columns.share(place, j));
            block(n_k + n_b, kept + n_b, shares.as_ref());
        }
        basis
    }

    fn enrichment(&self, whole: &Superelement, basis: MatRef<'_, f64>) -> Option<Enrichment> {
        let (further, enrichment) = self.further.as_ref().zip(whole.enrichment.as_ref())?;
        let reduced = |matrix: &Mat<f64>| symmetrized(basis.transpose() * matrix * basis);
        let left_out = whole.modes.interface_shapes.get(.., self.kept..);
        Some(Enrichment {
            names: further.names(&enrichment.names),
            interface_shapes: further.over(enrichment.interface_shapes.as_ref(), left_out),
            reduced_mass: reduced(&enrichment.reduced_mass),
            reduced_stiffness: reduced(&enrichment.reduced_stiffness),
        })
    }

    fn residual(&self, whole: &Superelement) -> Result<Residual, Error> {
        let residual = &whole.residual;
        let shapes = &whole.modes.interface_shapes;
        let mass =
            symmetrized((&residual.mass + self.absorbed.transpose() * &self.absorbed).as_ref());
        // C W, of which only the acting rows belong to F_res; the columns of output interfaces are zero in W.
        let added = shapes.get(.., self.kept..) * &self.absorbed;
        let acting = acting_rows(whole);
        let flexibility = Mat::from_fn(added.nrows(), added.ncols(), |i, j| {
            residual.flexibility[(i, j)] + if acting[i] { added[(i, j)] } else { 0.0 }
        });
        let flexibility = symmetrized(flexibility.as_ref());
        // With no mode kept.
        let all = absorbed_from(whole, without_stiffness(&whole.modes.eigenvalues));
        let mass0 = symmetrized((&residual.mass + all.transpose() * &all).as_ref());
        let filter = ResidualFilter::of(&residual.mass_diagonal0, &mass0)?;
        let (transform, sigma_squared) =
            filter.directions(residual.tolerance, &flexibility, &mass)?;
        Ok(Residual {
            output_shapes: residual
                .output_shapes
                .as_ref()
                .map(|shapes| shapes + &added),
            flexibility,
            mass,
            transform,
            sigma_squared,
            ..residual.clone()
        })
    }
}

/// Sᵀ f.
fn worked(work: &[f64], basis: MatRef<'_, f64>) -> Vec<f64> {
    let columns = basis.col_iter();
    columns
        .map(|column| column.iter().zip(work).map(|(s, f)| s * f).sum())
        .collect()
}

/// Ω⁻² Cᵀ over the modes from `first` on, (those, n_b).
fn absorbed_from(superelement: &Superelement, first: usize) -> Mat<f64> {
    let Modes {
        eigenvalues,
        interface_shapes,
        ..
    } = &superelement.modes;
    let acting = acting_rows(superelement);
    Mat::from_fn(
        eigenvalues.len() - first,
        acting.len(),
        |i, row| match acting[row] {
            true => interface_shapes[(row, first + i)] / eigenvalues[first + i],
            false => 0.0,
        },
    )
}

/// How many of the lowest eigenvalues are motions without stiffness: loose pieces.
pub(super) fn without_stiffness(eigenvalues: &[f64]) -> usize {
    let zero = eigenvalues.iter().take_while(|value| **value <= 0.0);
    zero.count()
}

/// Rows that have columns: those of attachments that feel any elastic motion.
pub(super) fn acting_rows(superelement: &Superelement) -> Vec<bool> {
    let rows = superelement.rows.iter();
    rows.zip(&superelement.residual.mass_diagonal0)
        .map(|(row, mass)| {
            superelement.interfaces[row.interface].role == Role::Attachment && *mass > 0.0
        })
        .collect()
}

pub(super) fn refuse_reduced_interfaces(superelement: &Superelement) -> Result<(), Error> {
    let derivation = superelement.derivation.as_ref();
    let directions = derivation.and_then(|derivation| derivation.interface_directions);
    if directions.is_some_and(InterfaceDirections::leave_out) {
        return Err(Error::NotHandled {
            body: superelement.name.clone(),
            what: "it was made with a reduced number of interface directions, which belong to its modes",
            remedy: "reduce it with fewer modes instead of leaving some out",
        });
    }
    Ok(())
}

/// Invariants over the basis Ψ S.
fn over(whole: &Inertia, basis: MatRef<'_, f64>) -> Inertia {
    Inertia {
        l1: &whole.l1 * basis,
        i1: basis
            .col_iter()
            .map(|column| combined(&whole.i1, column.iter()))
            .collect(),
        i3: &whole.i3 * basis,
        l3: congruent(&whole.l3, basis),
        i2: congruent(&whole.i2, basis),
        ..whole.clone()
    }
}

fn combined<'a>(blocks: &[[[f64; 3]; 3]], weights: impl Iterator<Item = &'a f64>) -> [[f64; 3]; 3] {
    let mut sum = [[0.0; 3]; 3];
    for (block, weight) in blocks.iter().zip(weights) {
        for (sum, row) in sum.iter_mut().zip(block) {
            for (sum, entry) in sum.iter_mut().zip(row) {
                *sum += weight * entry;
            }
        }
    }
    sum
}

/// Sᵀ A S for each A.
fn congruent(matrices: &[Mat<f64>], basis: MatRef<'_, f64>) -> Vec<Mat<f64>> {
    let of = |matrix: &Mat<f64>| basis.transpose() * (matrix * basis);
    matrices.iter().map(of).collect()
}
