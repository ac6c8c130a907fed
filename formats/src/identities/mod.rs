//! Identities and bounds between the numbers of a superelement: they hold whoever made it.
//!
//! `docs/format.md` has the table of all of them, with the reasons. [`at_load`] has those that cost next to nothing; whoever is about
//! to use a superelement's numbers asks for them ([`SuperelementFile::for_dynamics`](crate::dcb::SuperelementFile::for_dynamics)).
//! [`in_full`] has all, for `reduce verify`. Every defect is measured on the scale of its own rows and columns: no unit enters,
//! and no row is too small to be seen beside another.

mod gram;
mod inertia;
mod layout;
mod loads;
mod moments;
mod reduced;
mod residual;
mod rigid;
mod scaled;

use crate::superelement::Superelement;

pub use residual::{flexibilities, row_scales};

/// Largest defect of an identity that a load accepts: far above rounding, far below what changes a motion.
const LOAD_LIMIT: f64 = 1e-3;
/// Stored matrices that say the same differ by no more than this of their scale.
const AGREEMENT: f64 = 1e-8;

/// An identity or bound, and how far a superelement is from it.
#[derive(Clone, Debug, PartialEq)]
pub struct Identity {
    /// The dataset that it is about, or the first of those that contradict each other.
    pub path: &'static str,
    /// Statement that must hold.
    pub what: &'static str,
    /// How far it is from holding, without unit.
    pub defect: f64,
    /// Largest defect allowed.
    pub limit: f64,
}

impl Identity {
    /// Whether it holds; a defect that is no number doesn't.
    pub fn holds(&self) -> bool {
        self.defect <= self.limit
    }
}

/// The identities that every load for dynamics checks: their cost is a small fraction of reading the numbers.
pub fn at_load(of: &Superelement) -> Vec<Identity> {
    [
        residual::at_load(of),
        reduced::at_load(of),
        inertia::at_load(of),
    ]
    .concat()
}

/// All identities.
pub fn in_full(of: &Superelement) -> Vec<Identity> {
    [
        residual::in_full(of),
        reduced::in_full(of),
        inertia::in_full(of),
        gram::in_full(of),
        rigid::in_full(of),
        moments::in_full(of),
        layout::in_full(of),
        loads::in_full(of),
    ]
    .concat()
}
