//! The reduction of a spatial part as a planar scene has it.

use dcb_demand::LeftOut;
use dcb_demand::PlanarPart;

use super::component_demand::ComponentDemand;
use dcb_reducer::Reduced;
use dcb_reducer::error::Error;

/// The planar one, and what leads out of the plane.
///
/// # Errors
/// [`Error::InScene`] with how far the part is from symmetric, if it isn't; those of [`PlanarPart::of`].
pub(super) fn in_plane(
    asked: &ComponentDemand,
    spatial: Reduced,
) -> Result<(Reduced, LeftOut), Error> {
    let part = match PlanarPart::of(&spatial.superelement) {
        Err(dcb_demand::Error::Superelement(dcb_superelement::Error::Asymmetric(found))) => {
            return Err(Error::InScene {
                path: asked.scene.clone(),
                message: format!("the scene is planar, but the component is spatial: {found}"),
            });
        }
        other => other?,
    };
    let reduced = Reduced {
        superelement: part.superelement().clone(),
        recovery: part.recovery(&spatial.recovery),
        quality: spatial.quality.of_modes(part.modes()),
        work: spatial.work,
    };
    Ok((reduced, part.left_out().clone()))
}
