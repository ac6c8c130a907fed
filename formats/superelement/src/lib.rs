//! Algebra of one superelement file, for whoever reduces, estimates errors or simulates: which residual
//! directions have mass ([`ResidualFilter`]), the coordinates beyond the modes ([`ResidualCoordinates`]) and those of the dynamics
//! ([`DynamicCoordinates`]), where a list of modes may end ([`extended_to_gap`]), the smaller superelement that a scene needs ([`selection`]),
//! how far the superelement is off ([`ErrorBounds`]), and what a file was made for ([`MadeFor`]).
//!
//! ```
//! use std::path::Path;
//! use dcb_superelement::{ErrorBounds, LOSS_FACTOR, Selection};
//! use dcb_formats::scene::Compatibility;
//!
//! let rod = dcb_formats::dcb::read_superelement(Path::new("../../samples/slider-crank/rod.dcb.h5"))?;
//! // Half of its modes; the attachments take over what the others do statically.
//! let half = Selection::everything(&rod).with_modes(0..rod.mode_count() / 2)?;
//! let change = half.receptance_difference(&rod, &[0.01 * rod.modes.eigenvalues[0]])?;
//! assert!(change.together[0] < 1e-3);
//! let small = half.superelement(&rod)?;
//! assert_eq!(small.mode_count(), rod.mode_count() / 2);
//! // How far the whole is off, certified.
//! if let Some(bounds) = ErrorBounds::of(&rod, Compatibility::Strong)? {
//!     let band = bounds.usual_band(50).ok_or("no band")?;
//!     let errors = bounds.over(&bounds.attached_rows(), &band, LOSS_FACTOR)?;
//!     assert!(errors.static_response.upper < 1e-2);
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! ```
//! // Six modes are wanted of a component with double roots: the seventh belongs to the sixth.
//! let squares = [1.0, 4.0, 4.0, 9.0, 16.0, 25.0, 25.0, 36.0];
//! assert_eq!(dcb_superelement::extended_to_gap(&squares, 6), 7);
//! ```

/// Structural loss factor η of responses that are compared, λ = ω² / (1 + iη): that of `reduce study` and of error estimates.
pub const LOSS_FACTOR: f64 = 0.02;

/// Directions of M_res below this fraction of the scaled M_res with no mode kept carry no usable mass: they stay out of the
/// transform and are kept statically. The square of 1e-5, two digits above the square root of rounding.
pub const MASS_TOLERANCE: f64 = 1e-10;

pub mod error_bounds;
pub mod measured;
pub mod selection;

// No part of the door: for the other crates of this workspace and its tests.
#[doc(hidden)]
pub mod held_frequencies;

mod dynamic_coordinates;
mod error;
mod frequency_band;
mod made_for;
mod multiple_roots;
mod receptance;
mod residual_coordinates;
mod residual_filter;
mod stress_error;

pub use dynamic_coordinates::DynamicCoordinates;
pub use error::{Asymmetry, Error};
pub use error_bounds::{ErrorBounds, ErrorsBetween};
pub use frequency_band::FrequencyBand;
pub use made_for::{FrequencyLimit, LeftOutBy, LoadedDirections, MadeFor};
pub use multiple_roots::{CLUSTER_TOLERANCE, extended_to_gap};
pub use receptance::Receptance;
pub use residual_coordinates::{NoCoordinates, ResidualCoordinates};
pub use residual_filter::{NotFinite, ResidualFilter};
pub use selection::Selection;
pub use stress_error::stress_errors;
