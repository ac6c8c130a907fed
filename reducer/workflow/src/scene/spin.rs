//! Whether a scene needs columns for the centrifugal forces of the part.
//!
//! Interfaces with attachments feel loads on the inside statically without an error, whichever column the basis lacks. What is lost is the displacement
//! of places that only move: nodes and output interfaces. With L their rows, f(n) = ½ nᵀ J1 n the centrifugal forces of a unit spin about n and K the
//! reduced stiffness,
//!
//! ```text
//! lost displacement = Ω² L (K⁺ - K₀⁺) f(n)       K₀ without the columns (planar: f = I1)
//! ```
//! which is compared with the tolerance of deflections that are a hundredth of the part's size.

use dcb_demand::demand::{DEFLECTION_OF_INTEREST, NodeDemand};
use dcb_formats::component::Role;
use dcb_formats::further_column::Answer;
use dcb_formats::mesh::Dimension;
use dcb_formats::superelement::{Enrichment, RecoveryBasis, Superelement};
use dcb_formats::units::four_digits;
use dcb_superelement::selection::Selection;
use faer::Mat;
use nalgebra::Matrix3;

use super::component_demand::ComponentDemand;
use super::selected::selected;
use crate::inverse_root::inverse_root;
use dcb_reducer::Reduced;
use dcb_reducer::error::Error;
use dcb_reducer::quality::EnrichmentQuality;

/// What is said of a part that has none.
const NONE: &str = "no columns for centrifugal forces";
/// Scaled directions of the reduced stiffness below this are combinations of others.
const DEPENDENT: f64 = 1e-10;

/// Effect of columns for centrifugal forces.
#[derive(Clone, Debug, PartialEq)]
pub struct SpinColumns {
    /// How many there are.
    count: usize,
    /// In words, with its unit.
    rate: String,
    /// Displacement lost without them, of deflections of interest.
    lost: f64,
    tolerance: f64,
}

/// The rate of a demand: `150.0 rad/s`.
fn in_words(asked: &ComponentDemand) -> String {
    let demand = &asked.demand;
    format!("{} rad/{}", four_digits(demand.spin.rate), demand.time)
}

impl SpinColumns {
    /// Why nothing can be lost, if that is clear before the part is reduced.
    pub fn unneeded(asked: &ComponentDemand) -> Option<String> {
        let spin = &asked.demand.spin;
        let mut interfaces = asked.component.interfaces.iter();
        let outputs = interfaces.any(|one| one.role == Role::Output);
        let none = |why: &str| Some(format!("{NONE}: {why}"));
        if asked.demand.nodes == NodeDemand::None && !outputs {
            return none("nothing but interfaces with attachments is looked at");
        }
        if asked.is_rigid() {
            return none("the part doesn't deform");
        }
        match spin.rate <= 0.0 {
            true => none(&spin.reason),
            false => None,
        }
    }

    /// Of a reduction that has them, or was asked for them and found none.
    ///
    /// # Errors
    /// [`Error::NotFinite`] if the reduced stiffness isn't finite.
    pub fn of(asked: &ComponentDemand, reduced: &Reduced, tolerance: f64) -> Result<Self, Error> {
        let element = &reduced.superelement;
        let rate = asked.demand.spin.rate;
        let (count, lost) = match &element.enrichment {
            Some(enrichment) => {
                let count = enrichment.names.iter().filter(|name| is_spin(name)).count();
                let rows = watched_rows(asked, element, enrichment, &reduced.recovery);
                let most = largest_loss(element, enrichment, count, &rows)?;
                (
                    count,
                    rate * rate * most
                        / (DEFLECTION_OF_INTEREST * element.inertia.radius_of_gyration()),
                )
            }
            None => (0, 0.0),
        };
        Ok(Self {
            count,
            rate: in_words(asked),
            lost,
            tolerance,
        })
    }

    /// Whether they are to be kept.
    pub fn are_needed(&self) -> bool {
        self.lost > self.tolerance
    }

    /// The reduction as it is, or without them.
    ///
    /// # Errors
    /// Those of [`Selection::superelement`].
    pub fn kept_if_needed(&self, reduced: Reduced) -> Result<Reduced, Error> {
        match self.are_needed() {
            true => Ok(reduced),
            false => without_spin(reduced),
        }
    }

    /// Why they are kept, or not.
    pub fn why(&self) -> String {
        let Self {
            count, rate, lost, ..
        } = self;
        let begin = match self.are_needed() {
            true => format!("{count} columns for centrifugal forces"),
            false => NONE.to_owned(),
        };
        format!(
            "{begin}: without them, at {rate}, displacements inside lose {lost:.1e} of deflections that are {DEFLECTION_OF_INTEREST} of the part's size"
        )
    }
}

/// Whether a further column of this name answers to centrifugal forces.
fn is_spin(name: &str) -> bool {
    let is_of = |dimension| matches!(Answer::named(name, dimension), Some(Answer::Spin(..)));
    is_of(Dimension::Planar) || is_of(Dimension::Spatial)
}

/// What the reduction would have been without columns for centrifugal forces.
fn without_spin(reduced: Reduced) -> Result<Reduced, Error> {
    let element = &reduced.superelement;
    let all = element.enrichment.iter().flat_map(|of| &of.names);
    let others: Vec<&str> = (all.map(String::as_str))
        .filter(|name| !is_spin(name))
        .collect();
    let selection = Selection::everything(element).with_enrichment(&others)?;
    let mut smaller = selected(reduced, &selection)?;
    if let Some(derivation) = &mut smaller.superelement.derivation {
        derivation.left_out_columns.retain(|name| !is_spin(name));
    }
    if let Some(quality) = &mut smaller.quality.enrichment {
        let left_out = (quality.left_out.iter()).filter(|name| is_spin(name));
        let unasked: Vec<String> = left_out
            .map(|name| EnrichmentQuality::warning(name))
            .collect();
        let warnings = &mut smaller.superelement.provenance.warnings;
        warnings.retain(|warning| !unasked.contains(warning));
        quality.names.retain(|name| !is_spin(name));
        quality.left_out.retain(|name| !is_spin(name));
    }
    smaller.quality.enrichment =
        (smaller.quality.enrichment).filter(|of| !of.names.is_empty() || !of.left_out.is_empty());
    Ok(smaller)
}

/// Translations that are looked at and have no attachment over the whole basis, (rows, n): nodes, then output interfaces.
fn watched_rows(
    asked: &ComponentDemand,
    element: &Superelement,
    enrichment: &Enrichment,
    fields: &RecoveryBasis,
) -> Mat<f64> {
    let is_wanted = |node: u32| match &asked.demand.nodes {
        NodeDemand::None => false,
        NodeDemand::Some(nodes) => nodes.contains_key(&node),
        NodeDemand::All(_) => true,
    };
    let nodes: Vec<usize> = (0..fields.dofs.len())
        .filter(|row| {
            let dof = fields.dofs[*row];
            !dof.direction.is_rotation() && is_wanted(dof.node)
        })
        .collect();
    let outputs: Vec<usize> = (0..element.rows.len())
        .filter(|row| {
            let row = &element.rows[*row];
            let is_translation = (0..3).contains(&row.direction);
            element.interfaces[row.interface].role == Role::Output && is_translation
        })
        .collect();
    let further = fields.enrichment.as_ref();
    let (n_k, n_b) = (element.mode_count(), element.boundary_row_count());
    let residual = &element.residual;
    let seen = residual
        .output_shapes
        .as_ref()
        .unwrap_or(&residual.flexibility);
    Mat::from_fn(
        nodes.len() + outputs.len(),
        element.basis_count(),
        |i, k| {
            let (modes, attached, columns, row) = match i.checked_sub(nodes.len()) {
                None => (&fields.modes, &fields.residual, further, nodes[i]),
                Some(i) => {
                    let columns = Some(&enrichment.interface_shapes);
                    (&element.modes.interface_shapes, seen, columns, outputs[i])
                }
            };
            match k.checked_sub(n_k) {
                None => modes[(row, k)],
                Some(k) if k < n_b => attached[(row, k)],
                Some(k) => columns.map_or(0.0, |columns| columns[(row, k - n_b)]),
            }
        },
    )
}

/// Largest displacement of a row under a unit spin that is lost without the columns for centrifugal forces.
fn largest_loss(
    element: &Superelement,
    enrichment: &Enrichment,
    spin_columns: usize,
    rows: &Mat<f64>,
) -> Result<f64, Error> {
    let stiffness = &enrichment.reduced_stiffness;
    let n = stiffness.nrows();
    let further = element.mode_count() + element.boundary_row_count();
    let is_of_spin = |k: usize| {
        let name = k
            .checked_sub(further)
            .and_then(|at| enrichment.names.get(at));
        name.is_some_and(|name| is_spin(name))
    };
    let others: Vec<usize> = (0..n).filter(|k| !is_of_spin(*k)).collect();
    let every: Vec<usize> = (0..n).collect();
    let lost = match spin_columns {
        0 => return Ok(0.0),
        _ => responses(stiffness, rows, &every)? - responses(stiffness, rows, &others)?,
    };
    let most = (0..rows.nrows()).map(|row| {
        let mut sum = Matrix3::<f64>::zeros();
        for (k, block) in element.inertia.i1.iter().enumerate() {
            sum += lost[(row, k)] * Matrix3::from_fn(|a, b| block[a][b]);
        }
        match element.dimension {
            Dimension::Planar => sum[(2, 2)].abs(),
            Dimension::Spatial => {
                0.5 * (0.5 * (sum + sum.transpose()))
                    .symmetric_eigenvalues()
                    .amax()
            }
        }
    });
    Ok(most.fold(0.0, f64::max))
}

/// `L K⁺` over some of the basis' columns, zero in the others, (rows, n).
fn responses(stiffness: &Mat<f64>, rows: &Mat<f64>, columns: &[usize]) -> Result<Mat<f64>, Error> {
    let chosen = Mat::from_fn(columns.len(), columns.len(), |i, j| {
        stiffness[(columns[i], columns[j])]
    });
    let unit = inverse_root(chosen.as_ref(), DEPENDENT).ok_or(Error::NotFinite {
        what: "the reduced stiffness",
    })?;
    let own = Mat::from_fn(rows.nrows(), columns.len(), |i, j| rows[(i, columns[j])]);
    let found = (own * &unit) * unit.transpose();
    let mut all = Mat::zeros(rows.nrows(), rows.ncols());
    for (j, k) in columns.iter().enumerate() {
        all.col_mut(*k).copy_from(found.col(j));
    }
    Ok(all)
}
