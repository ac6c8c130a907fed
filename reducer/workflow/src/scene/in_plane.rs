//! The reduction of a spatial part as a planar scene has it.

use dcb_demand::LeftOut;
use dcb_demand::PlanarPart;

use super::component_demand::ComponentDemand;
use dcb_reducer::Reduced;
use dcb_reducer::error::Error;
use dcb_reducer::quality::Quality;

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
        quality: quality(spatial.quality, part.modes()),
        work: spatial.work,
    };
    Ok((reduced, part.left_out().clone()))
}

/// The report, of these modes.
fn quality(of: Quality, modes: &[usize]) -> Quality {
    let picked = |values: &[f64]| -> Vec<f64> {
        let places = modes.iter();
        places
            .filter_map(|mode| values.get(*mode).copied())
            .collect()
    };
    Quality {
        mode_residuals: picked(&of.mode_residuals),
        mode_residual_roundings: picked(&of.mode_residual_roundings),
        eigenvalue_roundings: picked(&of.eigenvalue_roundings),
        ..of
    }
}
