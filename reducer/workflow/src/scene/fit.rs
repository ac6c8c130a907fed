//! Pruning of a superelement that is good enough to the contents that the scene asks for.

use std::collections::BTreeSet;

use dcb_demand::demand::NodeDemand;
use dcb_demand::{Carried, LeftOut, Pruned};
use dcb_formats::component::Component;
use dcb_formats::mesh::Mesh;
use dcb_formats::superelement::{RecoveryBasis, Superelement};
use dcb_superelement::selection::{InterfaceSelection, NodeSelection, ObservedNodes, Selection};

use super::bodies::PartInScene;
use super::component_demand::{ComponentDemand, WATCHED};
use super::report::scene_fit;
use super::search::{Extent, Limits, UnprunedReduction};
use super::selected::selected;
use dcb_reducer::Reduced;
use dcb_reducer::Work;
use dcb_reducer::error::{Error, Shortfall};
use dcb_reducer::model::frame::offset;
use dcb_reducer::quality::Quality;
use dcb_reducer::quality::scene_fit::{Amounts, Kept, Omission, SceneFit};

/// Prunings tried, each with a smaller share of the tolerance than the one before.
const ATTEMPTS: usize = 8;

/// The superelement for a scene.
#[derive(Clone, Debug)]
pub struct Fitted {
    /// The superelement.
    pub superelement: Superelement,
    /// Nodal fields of the nodes that are looked at, and their mesh: without cells unless the whole field is wanted.
    pub fields: Option<(RecoveryBasis, Mesh)>,
    /// Quality of the reduction; what was left out and why.
    pub quality: Quality,
    /// Effort of the reductions.
    pub work: Work,
}

impl Fitted {
    /// Leaves out of a superelement what isn't asked for. Its provenance has the quality, and a warning where a rigid body would do.
    ///
    /// # Errors
    /// Those of [`Pruned::of`] and of selections; [`Error::Shortfall`] if the whole leaves nothing of the tolerance.
    pub fn of(
        whole: UnprunedReduction,
        part: &PartInScene,
        asked: &ComponentDemand,
        limits: &Limits,
    ) -> Result<Self, Error> {
        let mut fit = scene_fit(part, asked, limits);
        let certified = whole.certified();
        let squares = whole.squares.clone();
        let (rounds, spin) = (whole.rounds.clone(), whole.spin.clone());
        let out_of_plane = whole.out_of_plane.clone();
        let Reduced {
            quality,
            work,
            superelement: element,
            recovery,
        } = without_watched(whole.reduced, asked)?;
        let bound = certified.unwrap_or(0.0);
        // ‖H'' - H‖ ≤ ‖H'' - H'‖ + ‖H' - H‖, and ‖H'‖ ≤ (1 + bound) ‖H‖.
        let share = (limits.tolerance - bound) / (1.0 + bound);
        let leaving_out = LeavingOut {
            element: &element,
            asked,
            squares: &squares,
            nodes: observed(&element, &recovery, asked),
        };
        let (selection, mut left_out, error) = match limits.extent {
            Extent::Needed => leaving_out.within(share)?,
            Extent::Everything => (Selection::everything(&element), Vec::new(), 0.0),
        };
        let mut superelement = selection.superelement(&element)?;
        let recovery = selection.recovery(&element, &recovery)?;
        let unused_loads = left_out_loads(asked);
        left_out.extend(unused_loads);
        fit.rounds = rounds;
        fit.spin = spin;
        let left_out = out_of_plane.into_iter().chain(left_out);
        fit.left_out = left_out.map(Omission::from).collect();
        fit.kept = Kept {
            modes: Amounts::of(&superelement, &element, Superelement::mode_count),
            attachments: Amounts::of(&superelement, &element, |of| {
                of.residual.sigma_squared.len()
            }),
            rows: Amounts::of(&superelement, &element, Superelement::boundary_row_count),
            nodes: match asked.demand.nodes {
                NodeDemand::None => Amounts {
                    kept: 0,
                    of: asked.component.mesh.node_count(),
                },
                _ => nodes_of(&recovery, &asked.component),
            },
        };
        fit.certified = certified;
        fit.left_out_error = error;
        fit.total = match squares.is_empty() {
            true => None,
            false => Some(bound + error * (1.0 + bound)),
        };
        let fields = match &asked.demand.nodes {
            NodeDemand::None => None,
            NodeDemand::Some(_) => Some((recovery, asked.mesh().points_alone())),
            NodeDemand::All(_) => Some((recovery, asked.mesh())),
        };
        let quality = fitted_quality(quality, &selection, &superelement, fit);
        if asked.is_rigid() {
            let bodies = part.bodies.join(", ");
            superelement.provenance.warnings.insert(0, format!(
                "{}: nothing shows a deflection of {bodies}: a rigid body would do in place of the superelement",
                part.path.display()
            ));
        }
        superelement.provenance.quality = serde_json::to_value(&quality).unwrap_or_default();
        Ok(Self {
            superelement,
            fields,
            quality,
            work,
        })
    }
}

/// Contents asked for, taken out of a superelement.
struct LeavingOut<'a> {
    element: &'a Superelement,
    asked: &'a ComponentDemand,
    squares: &'a [f64],
    nodes: Option<ObservedNodes>,
}

impl LeavingOut<'_> {
    /// Contents kept, contents left out, and the effect.
    fn within(&self, share: f64) -> Result<(Selection, Vec<LeftOut>, f64), Error> {
        let (mut tolerance, mut found) = (share, f64::INFINITY);
        for _ in 0..ATTEMPTS {
            let demand = &self.asked.demand;
            let pruned = Pruned::of(self.element, demand, self.nodes.as_ref(), tolerance)?;
            let Carried::Selection(selection) = pruned.carried else {
                return Ok((self.rigid()?, pruned.left_out, 0.0));
            };
            found = pruned.error.max(self.change(&selection)?);
            if found <= share {
                return Ok((*selection, pruned.left_out, found));
            }
            // Between the frequencies that were looked at it changes more.
            tolerance *= 0.5 * share / found;
        }
        let change = found;
        Err(Shortfall::LeftOut { change, share }.into())
    }

    /// Largest relative change of the receptance over the scene's frequencies.
    fn change(&self, selection: &Selection) -> Result<f64, Error> {
        if self.squares.is_empty() {
            return Ok(0.0);
        }
        let difference = selection.receptance_difference(self.element, self.squares)?;
        let [collocated, transfer, _] = difference.largest();
        Ok(collocated.max(transfer))
    }

    /// Neither modes nor dynamic attachments; the interfaces that are used.
    fn rigid(&self) -> Result<Selection, Error> {
        let eigenvalues = self.element.modes.eigenvalues.iter();
        let zero = eigenvalues.take_while(|value| **value <= 0.0).count();
        let mut selection = Selection::everything(self.element)
            .with_modes(0..zero)?
            .with_attachments(0);
        for interface in &self.element.interfaces {
            let mut used = self.asked.demand.interfaces.iter();
            if !used.any(|used| used.name == interface.name) {
                selection =
                    selection.with_interface(&interface.name, InterfaceSelection::Dropped)?;
            }
        }
        Ok(selection)
    }
}

/// Without the interface of the nodes that are looked at, and without the fields of the others.
fn without_watched(reduced: Reduced, asked: &ComponentDemand) -> Result<Reduced, Error> {
    let element = &reduced.superelement;
    let nodes = match asked.demand.nodes {
        NodeDemand::All(_) => return Ok(reduced),
        NodeDemand::None => BTreeSet::new(),
        NodeDemand::Some(_) => asked.named_nodes().into_keys().collect(),
    };
    let mut selection = Selection::everything(element).with_nodes(NodeSelection::Only(nodes));
    if element
        .interfaces
        .iter()
        .any(|interface| interface.name == WATCHED)
    {
        selection = selection.with_interface(WATCHED, InterfaceSelection::Dropped)?;
    }
    selected(reduced, &selection)
}

fn observed(
    element: &Superelement,
    recovery: &RecoveryBasis,
    asked: &ComponentDemand,
) -> Option<ObservedNodes> {
    let nodes = asked.named_nodes();
    let position = |node: &u32| (*node, offset(asked.position(*node), element.origin));
    (!nodes.is_empty()).then(|| ObservedNodes {
        basis: recovery.clone(),
        positions: nodes.keys().map(position).collect(),
    })
}

fn nodes_of(recovery: &RecoveryBasis, component: &Component) -> Amounts {
    let nodes: BTreeSet<u32> = recovery.dofs.iter().map(|dof| dof.node).collect();
    Amounts {
        kept: nodes.len(),
        of: component.mesh.node_count(),
    }
}

/// Loads on the inside that don't act.
fn left_out_loads(asked: &ComponentDemand) -> Option<LeftOut> {
    let names: Vec<String> = asked
        .idle_loads
        .iter()
        .map(|name| format!("{name:?}"))
        .collect();
    (!names.is_empty()).then(|| LeftOut {
        what: format!("loads {}", names.join(", ")),
        why: "the scene doesn't apply them".to_owned(),
        cost: None,
    })
}

/// The report of the whole, for what is left of it.
fn fitted_quality(
    whole: Quality,
    selection: &Selection,
    superelement: &Superelement,
    fit: SceneFit,
) -> Quality {
    let whole = whole.of_modes(selection.modes());
    let cycles = |square: f64| square.max(0.0).sqrt() / std::f64::consts::TAU;
    let modes = &superelement.modes;
    let stays = |row: &str| {
        let interface = row.split('/').next();
        let mut interfaces = superelement.interfaces.iter();
        interfaces.any(|known| Some(known.name.as_str()) == interface)
    };
    Quality {
        residual_rank: superelement.residual.sigma_squared.len(),
        highest_kept: modes.eigenvalues.last().map(|square| cycles(*square)),
        lowest_omitted: Some(modes.first_omitted_eigenvalue)
            .filter(|square| square.is_finite())
            .map(cycles),
        dependent_rows: (whole.dependent_rows.into_iter())
            .filter(|row| stays(&row.row))
            .collect(),
        enrichment: whole
            .enrichment
            .filter(|_| superelement.enrichment.is_some()),
        scene: Some(fit),
        ..whole
    }
}
