//! Contents of a superelement that a scene needs, and those that it leaves out: why, and at which estimated cost.
//!
//! A [`Demand`] says what a scene asks of a part. [`Pruned::of`] leaves out of the part's superelement what the demand doesn't ask for, as long
//! as the receptance between the forces that act and all that is looked at changes by no more than a tolerance, over the demand's band of
//! frequencies. Within the superelement's coordinates that change is computed, not estimated; how the outputs of a mechanism change with it
//! depends on the mechanism. [`Pruning::of`] does it for every body of a scene.

mod attached;
mod centrifugal;
mod chosen;
mod narrowed;
mod ranges;
mod scene;

use dcb_formats::mesh::Dimension;
use dcb_formats::superelement::Superelement;

pub use narrowed::{Carrying, NarrowedScene};
pub use scene::Pruning;

use crate::demand::{Demand, Involvement};
use crate::{Error, LeftOut};
use chosen::Chooser;
use dcb_superelement::selection::{Normal, ObservedNodes, Selection};

/// The tolerance of runs where nothing else is said.
pub const DEFAULT_TOLERANCE: f64 = 1e-4;

/// Superelement after pruning.
#[derive(Clone, Debug, PartialEq)]
pub enum Carried {
    /// A smaller superelement.
    Selection(Box<Selection>),
    /// Its mass and its interfaces: it doesn't deform.
    Rigid,
}

/// One superelement as a scene needs it.
#[derive(Clone, Debug, PartialEq)]
pub struct Pruned {
    /// Remaining superelement.
    pub carried: Carried,
    /// Contents left out, in order.
    pub left_out: Vec<LeftOut>,
    /// The normal of the plane that the part moves in, if that was made use of.
    pub plane: Option<Normal>,
    /// Whether the modes can't be fewer, because other columns belong to them.
    pub has_bound_modes: bool,
    /// Largest relative change of the receptance by all of it, over the demand's band: collocated, transfer or centrifugal.
    pub error: f64,
}

impl Pruned {
    /// Leaves out what the demand doesn't ask for. `nodes` are those that the demand names.
    ///
    /// # Errors
    /// Those of [`Selection::superelement`] and [`dcb_superelement::DynamicCoordinates::of`].
    pub fn of(
        whole: &Superelement,
        demand: &Demand,
        nodes: Option<&ObservedNodes>,
        tolerance: f64,
    ) -> Result<Self, Error> {
        let is_seen = (demand.interfaces.iter()).any(|interface| !interface.observed_by.is_empty());
        let rigid = match demand.involvement {
            Involvement::Unused => Some("nothing refers to the body"),
            Involvement::Locked if !is_seen && has_frames(whole, demand) => {
                Some("the body is fixed to the ground and nothing looks at it")
            }
            Involvement::Locked | Involvement::Involved => None,
        };
        match rigid {
            Some(why) => Ok(Self {
                carried: Carried::Rigid,
                left_out: vec![LeftOut {
                    what: "all deflection".to_owned(),
                    why: why.to_owned(),
                    cost: None,
                }],
                plane: None,
                has_bound_modes: false,
                error: 0.0,
            }),
            None => Chooser::of(whole, demand, nodes, tolerance)?.choose(),
        }
    }
}

/// Whether every interface in use has all its directions: a rigid body has, and would hide that a joint needs one that isn't there.
fn has_frames(whole: &Superelement, demand: &Demand) -> bool {
    let all = match whole.dimension {
        Dimension::Planar => 3,
        Dimension::Spatial => 6,
    };
    demand.interfaces.iter().all(|used| {
        let rows = whole.rows.iter();
        let own = rows.filter(|row| whole.interfaces[row.interface].name == used.name);
        own.count() == all
    })
}
