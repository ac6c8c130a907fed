//! The choice for one superelement.

use std::collections::BTreeSet;
use std::f64::consts::TAU;

use dcb_formats::superelement::Superelement;
use nalgebra::Vector3;

use super::attached::{Economy, as_used};
use super::centrifugal::Centrifugal;
use super::ranges::ranges;
use super::{Carried, Pruned};
use crate::Error;
use crate::LeftOut;
use crate::coordinate_search::{EXACTLY, fewest};
use crate::demand::{Deflection, Demand, NodeDemand, PlaneOfMotion};
use dcb_superelement::selection::{
    InPlane, NodeSelection, Normal, ObservedNodes, SYMMETRIC, Selection,
};

/// Frequencies of comparison, equally apart in their logarithm over three decades.
const FREQUENCIES: usize = 49;
/// Of the first frequency, where the band has none of its own.
const QUASISTATIC: f64 = 0.01;
/// A normal is an axis of the component within this angle.
const PARALLEL: f64 = 1e-6;

/// Chooses what stays of one superelement.
pub(super) struct Chooser<'a> {
    whole: &'a Superelement,
    demand: &'a Demand,
    /// The whole with its nodes as rows.
    observed: Option<Superelement>,
    tolerance: f64,
    /// ω² of comparison; none where the demand has no band.
    squares: Vec<f64>,
    left_out: Vec<LeftOut>,
}

impl<'a> Chooser<'a> {
    pub fn of(
        whole: &'a Superelement,
        demand: &'a Demand,
        nodes: Option<&ObservedNodes>,
        tolerance: f64,
    ) -> Result<Self, Error> {
        Ok(Self {
            observed: nodes.map(|nodes| nodes.on(whole)),
            squares: squares(whole, demand),
            whole,
            demand,
            tolerance,
            left_out: Vec::new(),
        })
    }

    pub fn choose(mut self) -> Result<Pruned, Error> {
        let (whole, demand) = (self.whole, self.demand);
        let everything = Selection::everything(whole);
        let plane = self.plane();
        let (selection, normal) = match &plane {
            Some((normal, in_plane)) => (in_plane.selection().clone(), Some(*normal)),
            None => (everything, None),
        };
        let selection = self.without_columns(selection)?;
        let before = Reference {
            chooser: &self,
            spin: self.centrifugal(&selection)?,
            selection: selection.clone(),
            error: 0.0,
        };
        let mut found = (selection.clone(), Vec::new(), 0.0);
        for economy in Economy::ALL {
            let (used, left_out) = as_used(selection.clone(), whole, demand, normal, economy)?;
            let error = before.error(&used)?;
            found = (used, left_out, error);
            if error <= self.tolerance {
                break;
            }
        }
        let (mut selection, of_interfaces, mut error) = found;
        self.left_out.extend(of_interfaces);
        if !self.keeps_every_coordinate() {
            let reference = Reference {
                chooser: &self,
                spin: self.centrifugal(&selection)?,
                selection: selection.clone(),
                error,
            };
            let (modes, left_out, found) = reference.fewest_modes()?;
            let (attachments, others, found) = reference.fewest_attachments(&modes, found)?;
            selection = attachments;
            error = found;
            self.left_out.extend(left_out);
            self.left_out.extend(others);
        }
        let nodes = match &demand.nodes {
            NodeDemand::None => NodeSelection::Only(BTreeSet::new()),
            NodeDemand::Some(nodes) => NodeSelection::Only(nodes.keys().copied().collect()),
            NodeDemand::All(_) => NodeSelection::All,
        };
        Ok(Pruned {
            has_bound_modes: !selection.allows_fewer_modes(whole),
            carried: Carried::Selection(Box::new(
                selection.with_nodes(nodes).up_to(demand.band.frequency),
            )),
            left_out: self.left_out,
            plane: normal,
            error,
        })
    }

    /// The coordinates of a plane that the part moves in, if the scene has one and the part is symmetric to it.
    fn plane(&mut self) -> Option<(Normal, InPlane)> {
        let found = self.demand.planes.planes.iter().find_map(|plane| {
            let normal = axis(plane)?;
            passes_through(plane, self.whole).then_some(())?;
            let in_plane = InPlane::of(self.whole, normal, SYMMETRIC).ok()?;
            Some((normal, in_plane))
        })?;
        let (count, kept) = (self.whole.mode_count(), found.1.selection().modes().len());
        let what = match count - kept {
            0 if self.has_attachments_in(&found.1) => return Some(found),
            0 => "attachments".to_owned(),
            out => format!("{out} of {count} modes, and attachments,"),
        };
        self.left_out.push(LeftOut {
            what: format!(
                "{what} that lead out of the plane across {}",
                found.0.name()
            ),
            why: "scene and part are symmetric to it, so that nothing excites them".to_owned(),
            cost: None,
        });
        Some(found)
    }

    /// Whether all attachments are in the plane.
    fn has_attachments_in(&self, plane: &InPlane) -> bool {
        let smaller = plane.selection().superelement(self.whole);
        let rank = |of: &Superelement| of.residual.sigma_squared.len();
        smaller.is_ok_and(|smaller| rank(&smaller) == rank(self.whole))
    }

    /// Further columns that nothing asks for.
    fn without_columns(&mut self, selection: Selection) -> Result<Selection, Error> {
        let Some(enrichment) = &self.whole.enrichment else {
            return Ok(selection);
        };
        let spins = !self.demand.spin.known || self.demand.spin.rate > 0.0;
        let (mut kept, mut idle) = (Vec::new(), Vec::new());
        for name in &enrichment.names {
            let is_needed = match name.split_once(' ') {
                _ if name == "spin" => spins,
                Some(("spin", _)) => spins,
                Some(("load", load)) => self.demand.part_loads.iter().any(|used| used == load),
                _ => true,
            };
            let list = if is_needed { &mut kept } else { &mut idle };
            list.push(name.as_str());
        }
        if idle.is_empty() {
            return Ok(selection);
        }
        self.left_out.push(LeftOut {
            what: format!("columns {}", idle.join(", ")),
            why: "nothing that they answer to acts".to_owned(),
            cost: None,
        });
        Ok(selection.with_enrichment(&kept)?)
    }

    /// Whether modes and attachments have to stay: nobody says how fast the motion is, their coordinates are shown, or what loads inside the part,
    /// further columns and geometric stiffening would lose isn't known.
    fn keeps_every_coordinate(&self) -> bool {
        self.squares.is_empty()
            || !self.demand.coordinates_shown_by.is_empty()
            || !self.demand.part_loads.is_empty()
            || matches!(self.demand.nodes, NodeDemand::All(_))
            || !self.whole.stiffening.centrifugal.is_empty()
            || !self.whole.stiffening.interface.is_empty()
    }

    /// The response of what is selected to the body's own spin.
    fn centrifugal(&self, selection: &Selection) -> Result<Centrifugal, Error> {
        Centrifugal::of(&selection.superelement(self.whole)?, &self.demand.spin)
    }

    /// Largest relative change of the receptance, from the whole to `selection`; none where there is no band.
    fn change(&self, selection: &Selection) -> Result<f64, Error> {
        if self.squares.is_empty() {
            return Ok(0.0);
        }
        let difference = match &self.observed {
            Some(observed) => selection
                .observing(observed)
                .receptance_difference(observed, &self.squares)?,
            None => selection.receptance_difference(self.whole, &self.squares)?,
        };
        let [collocated, transfer, _] = difference.largest();
        Ok(collocated.max(transfer))
    }
}

/// Selection before coordinates are left out.
struct Reference<'a, 'b> {
    chooser: &'b Chooser<'a>,
    selection: Selection,
    /// Cost of its interfaces.
    error: f64,
    /// Its response to the body's own spin.
    spin: Centrifugal,
}

impl Reference<'_, '_> {
    /// The fewest modes, by their participation; what is left out; the error.
    fn fewest_modes(&self) -> Result<(Selection, Vec<LeftOut>, f64), Error> {
        let chooser = self.chooser;
        let modes = self.selection.modes();
        if !self.selection.allows_fewer_modes(chooser.whole) {
            return Ok((self.selection.clone(), Vec::new(), self.error));
        }
        let participation = match &chooser.observed {
            Some(observed) => {
                (self.selection.observing(observed)).participation(observed, &chooser.squares)?
            }
            None => (self.selection).participation(chooser.whole, &chooser.squares)?,
        };
        let mut order: Vec<usize> = (0..modes.len()).collect();
        order.sort_by(|a, b| participation[*b].total_cmp(&participation[*a]));
        // Motions without stiffness stay.
        let fixed = participation
            .iter()
            .filter(|share| share.is_infinite())
            .count();
        let with = |count: usize| {
            let kept = order[..fixed + count].iter().map(|place| modes[*place]);
            self.selection.clone().with_modes(kept)
        };
        let tried = |count: usize| self.error(&with(count)?).map(Some);
        let found = fewest(
            modes.len() - fixed,
            self.error,
            chooser.tolerance,
            EXACTLY,
            tried,
        )?;
        let Some(best) = found.map(|found| found.best) else {
            return Ok((self.selection.clone(), Vec::new(), self.error));
        };
        let selection = with(best.kept)?;
        let gone: Vec<usize> = (modes.iter().copied())
            .filter(|mode| !selection.modes().contains(mode))
            .collect();
        let left_out = LeftOut {
            what: format!("modes {} of {}", ranges(&gone), chooser.whole.mode_count()),
            why: chooser.why(),
            cost: Some(best.error),
        };
        let left_out = if gone.is_empty() {
            Vec::new()
        } else {
            vec![left_out]
        };
        Ok((selection, left_out, best.error))
    }

    /// The fewest dynamic attachments beside these modes.
    fn fewest_attachments(
        &self,
        modes: &Selection,
        before: f64,
    ) -> Result<(Selection, Vec<LeftOut>, f64), Error> {
        let chooser = self.chooser;
        // Equilibria are found with the inertia of all that gives way.
        if chooser.demand.deflection == Deflection::Static {
            return Ok((modes.clone(), Vec::new(), before));
        }
        let all = modes
            .superelement(chooser.whole)?
            .residual
            .sigma_squared
            .len();
        let with = |count: usize| modes.clone().with_attachments(count);
        let tried = |count: usize| self.error(&with(count)).map(Some);
        let found = fewest(all, before, chooser.tolerance, EXACTLY, tried)?;
        let Some(best) = found.map(|found| found.best).filter(|best| best.kept < all) else {
            return Ok((modes.clone(), Vec::new(), before));
        };
        let left_out = LeftOut {
            what: format!("the inertia of {} of {all} attachments", all - best.kept),
            why: chooser.why(),
            cost: Some(best.error),
        };
        Ok((with(best.kept), vec![left_out], best.error))
    }

    /// Change of the receptance, or of the response to the body's own spin if that is more.
    fn error(&self, selection: &Selection) -> Result<f64, Error> {
        let change = self.chooser.change(selection)?;
        if !self.spin.counts() {
            return Ok(change);
        }
        let smaller = selection.superelement(self.chooser.whole)?;
        Ok(change.max(self.spin.lost(&smaller)?))
    }
}

impl Chooser<'_> {
    fn why(&self) -> String {
        let reasons = self.demand.band.reasons.first();
        reasons.cloned().unwrap_or_default()
    }
}

/// ω² at which receptances are compared: over three decades up to the end of the demand's band, and at the modes in it.
fn squares(whole: &Superelement, demand: &Demand) -> Vec<f64> {
    let (Some(frequency), Deflection::Static | Deflection::Dynamic) =
        (demand.band.frequency, demand.deflection)
    else {
        return Vec::new();
    };
    let first = first_elastic(whole);
    let end = (TAU * frequency).powi(2).max(QUASISTATIC.powi(2) * first);
    let spread = (0..FREQUENCIES).map(|index| {
        let decades = 6.0 * (index as f64 / (FREQUENCIES - 1) as f64 - 1.0);
        end * 10.0_f64.powf(decades)
    });
    let inside = whole.modes.eigenvalues.iter().copied();
    let inside = inside.filter(|value| *value > 0.0 && *value <= end);
    spread.chain(inside).collect()
}

/// The lowest ω² that isn't zero.
fn first_elastic(whole: &Superelement) -> f64 {
    let modes = &whole.modes;
    let lowest = modes.eigenvalues.iter().copied().find(|value| *value > 0.0);
    lowest.unwrap_or(modes.first_omitted_eigenvalue)
}

/// The axis of the component that is a plane's normal.
fn axis(plane: &PlaneOfMotion) -> Option<Normal> {
    let normal = Vector3::from(plane.normal).normalize();
    [Normal::X, Normal::Y, Normal::Z]
        .into_iter()
        .find(|axis| 1.0 - normal[axis.axes()[2]].abs() <= PARALLEL * PARALLEL)
}

/// Whether a plane goes through the centre of mass.
fn passes_through(plane: &PlaneOfMotion, whole: &Superelement) -> bool {
    let distance = Vector3::from(plane.normal).dot(&Vector3::from(whole.origin)) - plane.offset;
    distance.abs() <= PARALLEL * whole.inertia.radius_of_gyration()
}
