//! A superelement with fewer modes, made of one with more: the lowest of them, as the reducer chooses.
//!
//! [`crate::selection`] does the algebra; the result is what the reducer makes of the component with so many modes, to rounding
//! (`tests/reduction/fewer_modes.rs`).

use dcb_formats::superelement::{RecoveryBasis, Superelement};

use crate::error::Error;
use crate::selection::{Basis, Selection};

/// Eigenvalues closer than this, relatively, are one multiple root, which isn't cut: the reducer's rule.
const CLUSTER_TOLERANCE: f64 = 1e-5;

/// Which modes of a superelement stay, and what becomes of the others.
#[derive(Clone, Debug, PartialEq)]
pub struct ModeTruncation {
    /// Modes that stay, the lowest.
    kept: usize,
    basis: Basis,
}

impl ModeTruncation {
    /// Keeps the `wanted` lowest modes: more where that would cut a multiple root or leave out a motion without stiffness,
    /// all where there are no more.
    ///
    /// # Errors
    /// [`Error::NotHandled`] if modes are to be left out of a superelement with enrichment columns, or of one with a reduced
    /// number of interface directions: what these would become isn't in the file. [`Error::NoEigenvalues`] if the residual matrices
    /// aren't finite.
    pub fn of(superelement: &Superelement, wanted: usize) -> Result<Self, Error> {
        let eigenvalues = &superelement.modes.eigenvalues;
        let kept = up_to_gap(eigenvalues, wanted.max(without_stiffness(eigenvalues)));
        let selection = Selection::everything(superelement).with_modes(0..kept)?;
        let basis = selection.basis(superelement)?;
        Ok(Self { kept, basis })
    }

    /// How many modes stay.
    pub fn kept(&self) -> usize {
        self.kept
    }

    /// The superelement with these modes; the one that the truncation was made for.
    ///
    /// # Errors
    /// [`Error::NoEigenvalues`] if the residual matrices aren't finite.
    pub fn superelement(&self, whole: &Superelement) -> Result<Superelement, Error> {
        self.basis.superelement(whole)
    }

    /// Its nodal fields.
    pub fn recovery(&self, whole: &RecoveryBasis) -> RecoveryBasis {
        self.basis.recovery(whole)
    }
}

/// How many of the lowest eigenvalues are motions without stiffness: loose pieces.
fn without_stiffness(eigenvalues: &[f64]) -> usize {
    let zero = eigenvalues.iter().take_while(|value| **value <= 0.0);
    zero.count()
}

/// `wanted`, raised until the next eigenvalue is apart.
fn up_to_gap(eigenvalues: &[f64], wanted: usize) -> usize {
    let mut kept = wanted.min(eigenvalues.len());
    while kept > 0
        && kept < eigenvalues.len()
        && eigenvalues[kept] - eigenvalues[kept - 1] <= CLUSTER_TOLERANCE * eigenvalues[kept]
    {
        kept += 1;
    }
    kept
}

pub(crate) fn refuse_unhandled(superelement: &Superelement) -> Result<(), Error> {
    let refused = |what, remedy| {
        Err(Error::NotHandled {
            body: superelement.name.clone(),
            what,
            remedy,
        })
    };
    if superelement.enrichment.is_some() {
        return refused(
            "it has enrichment columns, which belong to the modes that it was made with",
            "reduce it with fewer modes instead of leaving some out",
        );
    }
    let reduction = &superelement.provenance.quality["interface_reduction"];
    if reduction["kept"].as_u64() < reduction["available"].as_u64() {
        return refused(
            "it was made with a reduced number of interface directions, which belong to its modes",
            "reduce it with fewer modes instead of leaving some out",
        );
    }
    Ok(())
}
