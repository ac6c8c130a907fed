//! Reducing a part for a scene: the smallest superelement with which the part's responses are right within a tolerance, as far as the scene asks.
//!
//! [`PartInScene`] finds the bodies that are made of the part, [`ComponentDemand`] what the scene does with them ([`dcb_demand::demand`]). [`Search`]
//! reduces with more and more modes until the bounds of [`dcb_superelement::ErrorBounds`], over the scene's frequencies and between the rows and nodes that
//! it uses, leave half of the tolerance. [`Fitted`] spends the other half on leaving out of the result what nobody asks for
//! ([`dcb_demand::pruning`]): interfaces, directions, modes, the inertia of attachments, nodes. [`SceneFit`](dcb_reducer::quality::scene_fit::SceneFit) says all of it.
//!
//! A spatial part is reduced for a planar scene in space, and goes on as the planar superelement of its plane of symmetry.
//!
//! Errors are those of the part: receptances ‖H − H_ref‖ / ‖H_ref‖ as in studies, not errors of the scene's outputs.

mod bodies;
mod cached;
mod component_demand;
mod fit;
mod in_plane;
mod interfaces;
mod report;
mod search;
mod selected;
mod spin;

pub use bodies::PartInScene;
pub use cached::CachedReductions;
pub use component_demand::ComponentDemand;
pub use fit::Fitted;
pub use interfaces::part_interfaces;
pub use report::scene_fit;
pub use search::{Extent, Limits, Search, UnprunedReduction};
pub use spin::SpinColumns;
