//! What follows from one superelement file by algebra alone, for whoever reduces, estimates errors or simulates: which residual
//! directions have mass ([`ResidualFilter`]), and the dynamic coordinates beyond the modes ([`ResidualCoordinates`]).

mod residual_coordinates;
mod residual_filter;

pub use residual_coordinates::{NoCoordinates, ResidualCoordinates};
pub use residual_filter::{NotFinite, ResidualFilter};
