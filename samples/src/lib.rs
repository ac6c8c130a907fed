//! Small flexible components made from a few numbers, for the README, the tests and the benches: beams, solid blocks,
//! a connecting rod, and the awkward cases a reducer has to recognise.
//!
//! Every function returns a complete [`dcb_formats::Component`]: stiffness and mass (exactly symmetric, full storage,
//! columns sorted), mesh, dof table and interfaces. Units are SI; [`in_units`] gives the same component in other units and
//! [`write()`] puts it on disk as the files `reduce` reads. Nothing here solves anything.

pub mod catalogue;
pub mod hard;
mod material;
pub mod solid;
pub mod units;
pub mod write;

// No part of the door: for the other crates of this workspace and its tests.
#[doc(hidden)]
pub mod axial_prestress;
#[doc(hidden)]
pub mod connecting_rod;
#[doc(hidden)]
pub mod planar_rod;
#[doc(hidden)]
pub mod pseudo_random;
#[doc(hidden)]
pub mod spatial_beam;

mod bracket;
mod component;
mod gallery;
mod planform;
mod shaft;
mod sparse;

pub use axial_prestress::axial_prestress;
pub use bracket::bracket;
pub use connecting_rod::connecting_rod;
pub use material::Material;
pub use planar_rod::{RodSection, planar_rod};
pub use pseudo_random::PseudoRandom;
pub use shaft::shaft;
pub use solid::{
    SolidElement, assemble_solid, box_block, reference_hexahedra, reference_tetrahedra,
};
pub use spatial_beam::{SpatialBeam, spatial_beam};
pub use units::{UnitScale, in_units};
pub use write::write;
