//! A scene together with what is carried of its superelements.

use dcb_formats::scene::Scene;
use dcb_superelement::selection::NodeSelection;
use indexmap::IndexMap;

use super::Carried;

/// Contents carried of the superelements of a scene; by default everything.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Carrying {
    /// By the names of the bodies; all of the superelement where a body has no entry.
    pub bodies: IndexMap<String, Carried>,
    /// Normal of a plane that no motion leaves, world axes: what leads out of it isn't carried.
    pub plane: Option<[f64; 3]>,
}

impl Carrying {
    /// The same coordinates, with the nodal fields of all nodes: to look at a run that needed those of a few nodes only.
    pub fn with_all_nodes(self) -> Self {
        let bodies = self.bodies.into_iter().map(|(name, carried)| {
            let carried = match carried {
                Carried::Selection(selection) => {
                    Carried::Selection(Box::new(selection.with_nodes(NodeSelection::All)))
                }
                Carried::Rigid => Carried::Rigid,
            };
            (name, carried)
        });
        Self {
            bodies: bodies.collect(),
            plane: self.plane,
        }
    }
}

/// A scene and what is carried of its superelements.
#[derive(Clone, Debug, PartialEq)]
pub struct NarrowedScene {
    /// The scene.
    pub scene: Scene,
    /// Contents carried.
    pub carrying: Carrying,
}

impl From<Scene> for NarrowedScene {
    /// Everything is carried.
    fn from(scene: Scene) -> Self {
        Self {
            scene,
            carrying: Carrying::default(),
        }
    }
}
