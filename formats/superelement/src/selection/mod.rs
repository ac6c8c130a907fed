//! From a large superelement the smaller one that a scene needs, without the component's matrices.
//!
//! A [`Selection`] says which modes stay, what happens at each interface, which further columns and whose nodal fields are kept. The
//! result is the superelement that `reduce` would have made of the component with these options, to rounding
//! (`tests/reduction/selection/mod.rs`). Modes that are left out are absorbed in the attachments: with C = L_b Φ over them and W = Ω⁻² Cᵀ,
//!
//! ```text
//! X'     = (X + Φ W) P                 G_res L_bᵀ over the modes kept, under the forces that are left
//! F_res' = L_b X',  M_res' = Pᵀ (M_res + Wᵀ W) P
//! Ψ'     = Ψ S                         L1, I1, I3 become L1 S and so on; L3, J2 and the stiffening matrices Sᵀ L3 S
//! ```
//! P has a column for each row that stays: the row's own unit force, nothing for a row that is only observed, and for interfaces that are
//! loaded along some forces B only the nearest of these in energy (`projection.rs`). T_r and σ² are found anew by the filter of
//! `docs/theory.md` §6.
//!
//! [`Selection::lowest_modes`] leaves out nothing but the highest modes: F_res' = F_res + C W and M_res' = M_res + Wᵀ W with all interfaces, and further columns
//! take what these modes did of their responses (`further_columns.rs`).
//!
//! The price of leaving out: [`Selection::receptance_difference`] and [`Selection::participation`] say it.
//! [`InPlane`] selects what a motion in a plane needs.

mod basis;
mod congruence;
mod further_columns;
mod interface;
mod moments;
mod observation;
mod participation;
mod plane;
mod ports;
mod projection;
mod receptance;
mod record;
mod rigid_motions;
mod statics;

use std::collections::BTreeSet;

use dcb_formats::component::Role;
use dcb_formats::superelement::{InterfaceDirections, RecoveryBasis, Superelement};
use faer::Mat;

use crate::{Error, ResidualFilter, extended_to_gap};
use basis::Basis;
use further_columns::FurtherColumns;
pub use interface::InterfaceSelection;
use interface::Place;
pub use observation::ObservedNodes;
pub use plane::{InPlane, Normal, SYMMETRIC};
pub use receptance::ReceptanceDifference;
use statics::Statics;

/// Remedy where a file doesn't tell what fewer modes would be like.
const FEWER_MODES: &str = "reduce it with fewer modes instead of leaving some out";

/// Whose displacements a file's nodal fields hold.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum NodeSelection {
    /// Every node that has them.
    #[default]
    All,
    /// These nodes.
    Only(BTreeSet<u32>),
}

/// Demand of a scene on a superelement.
#[derive(Clone, Debug, PartialEq)]
pub struct Selection {
    body: String,
    places: Vec<Place>,
    further: Vec<String>,
    eigenvalues: Vec<f64>,
    /// Orthogonal combinations of modes of one multiple root, (n_k, n_k), to be made first; `None` where modes stay as they are.
    turn: Option<Mat<f64>>,
    modes: Vec<usize>,
    interfaces: Vec<InterfaceSelection>,
    enrichment: Vec<usize>,
    /// Treatment of further columns where the highest modes are all that is left out.
    truncation: Option<FurtherColumns>,
    /// Dynamic attachments at most; all where `None`.
    attachments: Option<usize>,
    nodes: NodeSelection,
    /// Cycles per time; `None` where nobody said.
    up_to: Option<f64>,
}

impl Selection {
    /// All that there is.
    pub fn everything(whole: &Superelement) -> Self {
        let (modes, further) = (whole.mode_count(), further_names(whole));
        Self {
            body: whole.name.clone(),
            places: Place::all(whole),
            eigenvalues: whole.modes.eigenvalues.clone(),
            turn: None,
            modes: (0..modes).collect(),
            interfaces: (whole.interfaces.iter())
                .map(|interface| match interface.role {
                    Role::Attachment => InterfaceSelection::Loaded,
                    Role::Output => InterfaceSelection::Observed,
                })
                .collect(),
            enrichment: (0..further.len()).collect(),
            further,
            truncation: None,
            attachments: None,
            nodes: NodeSelection::All,
            up_to: None,
        }
    }

    /// The `wanted` lowest modes, which give the superelement that `reduce` makes with so many, to rounding. More where that would cut a multiple root or
    /// leave out a motion without stiffness; everything where there are no more.
    ///
    /// Interfaces and further columns stay; the power moments go. It isn't put on record as a selection, and it may follow one that cut directions of force.
    /// With another choice of modes, interfaces or further columns ([`Self::with_modes`] and so on) it becomes a selection like any other.
    ///
    /// # Errors
    /// [`Error::NotHandled`] if modes are to be left out of a superelement with a reduced number of interface directions, or with further columns
    /// that aren't those of `reduce --enrich`, or of which fewer modes need more: what these would become isn't in the file.
    pub fn lowest_modes(whole: &Superelement, wanted: usize) -> Result<Self, Error> {
        let eigenvalues = &whole.modes.eigenvalues;
        let kept = extended_to_gap(eigenvalues, wanted.max(without_stiffness(eigenvalues)));
        let everything = Self::everything(whole);
        if kept == eigenvalues.len() {
            return Ok(everything);
        }
        refuse_reduced_interfaces(whole)?;
        let further = FurtherColumns::with_fewer_modes(whole, kept)?;
        Ok(Self {
            modes: (0..kept).collect(),
            enrichment: further.places.clone(),
            truncation: Some(further),
            ..everything
        })
    }

    /// The same with these modes only, by their places among all; in any order.
    ///
    /// # Errors
    /// [`Error::Selection`] for a mode that isn't there, or if a motion without stiffness were left out, which no attachment can stand for.
    pub fn with_modes(self, modes: impl IntoIterator<Item = usize>) -> Result<Self, Error> {
        let kept: BTreeSet<usize> = modes.into_iter().collect();
        let count = self.eigenvalues.len();
        if let Some(last) = kept.last().filter(|last| **last >= count) {
            return self.refused(format!(
                "there is no mode {last} of {count}, counted from 0"
            ));
        }
        let zero = |mode: &usize| self.eigenvalues[*mode] <= 0.0 && !kept.contains(mode);
        if let Some(mode) = (0..count).find(zero) {
            return self.refused(format!(
                "mode {mode} is a motion without stiffness, which no attachment can stand for; keep it"
            ));
        }
        Ok(Self {
            modes: kept.into_iter().collect(),
            truncation: None,
            ..self
        })
    }

    /// The same with another use of an interface.
    ///
    /// # Errors
    /// [`Error::Selection`] for an unknown name, forces on an interface that is only observed in the whole, or forces that don't fit its rows.
    pub fn with_interface(mut self, name: &str, wanted: InterfaceSelection) -> Result<Self, Error> {
        let Some(at) = self.places.iter().position(|place| place.name == name) else {
            return self.refused(format!("it has no interface {name:?}"));
        };
        if let Err(message) = self.places[at].refuse_misfit(&wanted) {
            return self.refused(message);
        }
        self.interfaces[at] = wanted;
        self.truncation = None;
        Ok(self)
    }

    /// The same with only these of the further columns.
    ///
    /// # Errors
    /// [`Error::Selection`] for an unknown name.
    pub fn with_enrichment(self, names: &[&str]) -> Result<Self, Error> {
        if let Some(name) = names
            .iter()
            .find(|name| !self.further.iter().any(|of| of == *name))
        {
            return self.refused(format!("it has no further column {name:?}"));
        }
        let places = 0..self.further.len();
        let kept = places.filter(|at| names.contains(&self.further[*at].as_str()));
        Ok(Self {
            enrichment: kept.collect(),
            truncation: None,
            ..self
        })
    }

    /// The same of a superelement that has further columns beside those of the one that the selection was made for; none of these stays.
    #[must_use]
    pub fn of_richer(self, richer: &Superelement) -> Self {
        let further = further_names(richer);
        let place = |at: &usize| further.iter().position(|name| *name == self.further[*at]);
        Self {
            enrichment: self.enrichment.iter().filter_map(place).collect(),
            further,
            ..self
        }
    }

    /// The same with no more than this many dynamic attachments, the softest. The flexibility of the others acts without inertia.
    pub fn with_attachments(self, count: usize) -> Self {
        Self {
            attachments: Some(count),
            ..self
        }
    }

    /// The same with nodal fields of these nodes only.
    pub fn with_nodes(self, nodes: NodeSelection) -> Self {
        Self { nodes, ..self }
    }

    /// The same for responses up to a frequency, cycles per time, which the superelement's provenance then says.
    pub fn up_to(self, frequency: Option<f64>) -> Self {
        Self {
            up_to: frequency,
            ..self
        }
    }

    /// Whether modes can be left out of a superelement together with the rest of this selection.
    pub fn allows_fewer_modes(&self, whole: &Superelement) -> bool {
        self.refuse_bound_to_modes(whole).is_ok()
    }

    /// Whose nodal fields stay.
    pub fn nodes(&self) -> &NodeSelection {
        &self.nodes
    }

    /// Whether further columns stay.
    pub fn has_enrichment(&self) -> bool {
        !self.enrichment.is_empty()
    }

    /// Places of the modes that stay, ascending.
    pub fn modes(&self) -> &[usize] {
        &self.modes
    }

    /// Selection at each interface of the whole, in its order.
    pub fn interfaces(&self) -> &[InterfaceSelection] {
        &self.interfaces
    }

    /// The superelement that is left of the one that the selection was made for.
    ///
    /// `first_omitted_eigenvalue` is the lowest ω² left out, be it below the highest kept.
    ///
    /// # Errors
    /// [`Error::Selection`] if `whole` is another one; [`Error::NotHandled`] if modes are to be left out of a superelement with further
    /// columns or a reduced number of interface directions; [`Error::NoEigenvalues`] if its matrices aren't finite.
    pub fn superelement(&self, whole: &Superelement) -> Result<Superelement, Error> {
        let mut superelement = self.basis(whole)?.superelement(whole)?;
        let residual = &mut superelement.residual;
        let mut count = self.attachments.unwrap_or(usize::MAX);
        if self.truncation.is_none() {
            count = count.min(most_attachments(whole)?);
        }
        if count < residual.sigma_squared.len() {
            residual.transform = residual.transform.get(.., ..count).to_owned();
            residual.sigma_squared.truncate(count);
        }
        Ok(superelement)
    }

    /// Its nodal fields. A mesh may go with them or not: where it does, nodes without fields move with the frame.
    ///
    /// # Errors
    /// Those of [`Selection::superelement`].
    pub fn recovery(
        &self,
        whole: &Superelement,
        fields: &RecoveryBasis,
    ) -> Result<RecoveryBasis, Error> {
        Ok(self.basis(whole)?.recovery(fields))
    }

    /// S and the choice that it was made of.
    fn basis(&self, whole: &Superelement) -> Result<Basis, Error> {
        self.basis_over(whole, self.rows(whole))
    }

    /// The same over some of the selected rows, in any order within an interface.
    fn basis_over(&self, whole: &Superelement, rows: Vec<usize>) -> Result<Basis, Error> {
        self.refuse_other(whole)?;
        if self.truncation.is_none() && self.modes.len() < whole.mode_count() {
            self.refuse_bound_to_modes(whole)?;
        }
        Basis::of(whole, self, rows)
    }

    /// Rows of the interfaces that aren't dropped.
    fn rows(&self, whole: &Superelement) -> Vec<usize> {
        let stays = |row: &usize| {
            let interface = self.interfaces.get(whole.rows[*row].interface);
            interface.is_some_and(|interface| *interface != InterfaceSelection::Dropped)
        };
        (0..whole.rows.len()).filter(stays).collect()
    }

    fn refuse_other(&self, whole: &Superelement) -> Result<(), Error> {
        let is_same = self.eigenvalues == whole.modes.eigenvalues
            && self.places == Place::all(whole)
            && self.further == further_names(whole);
        if is_same {
            return Ok(());
        }
        self.refused("the selection was made for another superelement".to_owned())
    }

    /// Facts of the modes that a superelement was made with, which aren't known for fewer.
    fn refuse_bound_to_modes(&self, whole: &Superelement) -> Result<(), Error> {
        if record::has_cut_directions(whole) {
            return Err(Error::NotHandled {
                body: self.body.clone(),
                what: "its interfaces are loaded along some forces only, which belongs to its modes",
                remedy: "leave modes out of the superelement that this one was made of",
            });
        }
        if !self.enrichment.is_empty() {
            return Err(Error::NotHandled {
                body: self.body.clone(),
                what: "it has enrichment columns, which belong to the modes that it was made with",
                remedy: "leave out these columns too, or keep all of its modes",
            });
        }
        refuse_reduced_interfaces(whole)
    }

    fn refused<T>(&self, message: String) -> Result<T, Error> {
        Err(Error::Selection {
            body: self.body.clone(),
            message,
        })
    }
}

/// Names of the further columns; their places where the file doesn't name them.
fn further_names(whole: &Superelement) -> Vec<String> {
    let Some(enrichment) = &whole.enrichment else {
        return Vec::new();
    };
    match enrichment.names.is_empty() {
        true => (0..enrichment.interface_shapes.ncols())
            .map(|place| place.to_string())
            .collect(),
        false => enrichment.names.clone(),
    }
}

/// As many dynamic attachments as a superelement has, if an earlier selection left out the inertia of some; else there is no limit.
///
/// # Errors
/// [`Error::NoEigenvalues`] if its matrices aren't finite.
fn most_attachments(whole: &Superelement) -> Result<usize, Error> {
    let residual = &whole.residual;
    let count = residual.sigma_squared.len();
    if whole.selections().is_empty() {
        return Ok(usize::MAX);
    }
    let statics = Statics::with_all_modes(whole);
    let filter = ResidualFilter::of(&residual.mass_diagonal0, &statics.mass0)?;
    let (_, all) = filter.directions(residual.tolerance, &residual.flexibility, &residual.mass)?;
    Ok(if all.len() > count { count } else { usize::MAX })
}

/// How many of the lowest eigenvalues are motions without stiffness: loose pieces.
fn without_stiffness(eigenvalues: &[f64]) -> usize {
    let zero = eigenvalues.iter().take_while(|value| **value <= 0.0);
    zero.count()
}

fn refuse_reduced_interfaces(whole: &Superelement) -> Result<(), Error> {
    let derivation = whole.derivation.as_ref();
    let directions = derivation.and_then(|derivation| derivation.interface_directions);
    match directions.is_some_and(InterfaceDirections::leave_out) {
        false => Ok(()),
        true => Err(Error::NotHandled {
            body: whole.name.clone(),
            what: "it was made with a reduced number of interface directions, which belong to its modes",
            remedy: FEWER_MODES,
        }),
    }
}
