//! Report on the purpose of a superelement for a scene.

use dcb_reducer::quality::scene_fit::SceneFit;

use super::ComponentDemand;
use super::bodies::PartInScene;
use super::search::Limits;

/// The report before anything is reduced.
pub fn scene_fit(part: &PartInScene, asked: &ComponentDemand, limits: &Limits) -> SceneFit {
    let name = part.path.file_name();
    SceneFit {
        scene: name.map_or(String::new(), |name| name.to_string_lossy().into_owned()),
        bodies: part.bodies.clone(),
        tolerance: limits.tolerance,
        asked: asked
            .demand
            .to_string()
            .lines()
            .map(str::to_owned)
            .collect(),
        notes: asked.notes.clone(),
        ..SceneFit::default()
    }
}
