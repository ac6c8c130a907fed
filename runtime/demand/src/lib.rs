//! Needs of a scene for its superelements, found without integrating it.
//!
//! A [`Demand`] is what a scene asks of one part; the superelement needn't be there yet. [`Pruning`] leaves out of superelements what their
//! demands don't ask for, and a [`NarrowedScene`] is a scene with what is carried of them. [`PartFile`] is a superelement's file as a scene
//! of its dimension reads it.

pub mod demand;
pub mod pruning;

// No part of the door: for the other crates of this workspace and its tests.
#[doc(hidden)]
pub mod coordinate_search;

mod error;
mod left_out;
mod part_file;
mod planar_part;
mod superelement_files;

pub use demand::Demand;
pub use error::Error;
pub use left_out::LeftOut;
pub use part_file::{AskedPart, PartFile};
pub use planar_part::PlanarPart;
pub use pruning::{Carried, Carrying, NarrowedScene, Pruned, Pruning};
pub use superelement_files::{OpenSuperelement, SuperelementFiles};
