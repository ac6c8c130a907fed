//! What a selection leaves of a reduction.

use dcb_reducer::Reduced;
use dcb_reducer::error::Error;
use dcb_superelement::selection::Selection;

/// The reduction as if no more had been asked for: its provenance and derivation say nothing of the selection.
///
/// # Errors
/// Those of [`Selection::superelement`].
pub(super) fn selected(reduced: Reduced, selection: &Selection) -> Result<Reduced, Error> {
    let element = &reduced.superelement;
    let mut superelement = selection.superelement(element)?;
    superelement.provenance = element.provenance.clone();
    superelement.derivation = element.derivation.clone();
    Ok(Reduced {
        recovery: selection.recovery(element, &reduced.recovery)?,
        superelement,
        ..reduced
    })
}
