//! The part as the reduction sees it: matrices without the dofs of rigid interfaces, boundary rows, rigid motions, loose pieces, the scale of
//! its spectrum.

pub(crate) mod cell_coupling;
pub mod condensation;
pub(crate) mod couplings;
pub mod frame;
pub mod localization;
pub(crate) mod mass_sign;
pub mod piece_motions;
pub mod plausibility;
pub mod regularization;
pub mod rigid_body;
pub mod rigid_frame;
pub mod shift;
pub(crate) mod stresses;
pub mod surface;
