//! Recomputes what can be recomputed of a superelement, from itself alone ([`check_alone`]) or, given the component, everything
//! ([`check_component`]).

mod alone;
mod component;
mod fields;
mod findings;
mod further;
mod interfaces;
mod layout;
mod moments;
mod stored_shapes;

pub use alone::check_alone;
pub use component::check as check_component;
pub use findings::Findings;
