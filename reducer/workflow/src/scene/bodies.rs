//! Which bodies of a scene are made of the part.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use dcb_formats::Scene;
use dcb_formats::output::is_same_file;
use dcb_formats::scene::{BodyKind, SuperelementBody};

use dcb_reducer::error::Error;

/// A scene, and its bodies that are made of one part.
#[derive(Clone, Debug)]
pub struct PartInScene {
    /// The scene's file.
    pub path: PathBuf,
    /// The scene.
    pub scene: Scene,
    /// Names of the bodies, at least one.
    pub bodies: Vec<String>,
}

impl PartInScene {
    /// Reads a scene. The bodies are those of the given names; if there are none, those whose superelement is `output`; if there are none of
    /// these either, those whose superelement's file has its name or that of `usual_output`.
    ///
    /// # Errors
    /// Those of [`Scene::read`]; [`Error::InScene`] if no body is meant, or one that isn't a superelement.
    pub fn find(
        path: &Path,
        names: &[String],
        output: &Path,
        usual_output: &Path,
    ) -> Result<Self, Error> {
        Self::of(Scene::read(path)?, path, names, [output, usual_output])
    }

    /// The same in a scene that is in memory; `path` names it in messages, and the outputs are the usual one last.
    ///
    /// # Errors
    /// [`Error::InScene`] if no body is meant, or one that isn't a superelement.
    pub fn of(
        scene: Scene,
        path: &Path,
        names: &[String],
        [output, usual_output]: [&Path; 2],
    ) -> Result<Self, Error> {
        let made_of = |meant: &dyn Fn(&Path) -> bool| -> Vec<String> {
            let bodies = scene.superelements();
            let meant = bodies.filter(|(_, of)| meant(&scene.resolve(&of.file)));
            meant.map(|(name, _)| name.to_owned()).collect()
        };
        let bodies = match names {
            [] => {
                let is_output = |file: &Path| is_same_file(file, output);
                let names = [output.file_name(), usual_output.file_name()];
                let has_its_name = |file: &Path| {
                    file.file_name()
                        .is_some_and(|name| names.contains(&Some(name)))
                };
                match made_of(&is_output) {
                    none if none.is_empty() => made_of(&has_its_name),
                    bodies => bodies,
                }
            }
            named => named.to_vec(),
        };
        let found = Self {
            path: path.to_owned(),
            scene,
            bodies,
        };
        if found.bodies.is_empty() {
            return Err(found.refused(&format!(
                "no body is made of {}; {}; name those that are meant with --body",
                name_of(output),
                found.inventory()
            )));
        }
        match found
            .bodies
            .iter()
            .find(|name| found.superelement(name).is_none())
        {
            Some(other) => Err(found.refused(&format!(
                "no superelement is called {other:?}; {}",
                found.inventory()
            ))),
            None => Ok(found),
        }
    }

    /// Superelement bodies that are made of other parts.
    pub(super) fn others(&self) -> impl Iterator<Item = (&str, &SuperelementBody)> {
        self.scene
            .superelements()
            .filter(|(name, _)| !self.bodies.iter().any(|own| own == name))
    }

    /// The body of this name, if it is a superelement.
    pub(super) fn superelement(&self, name: &str) -> Option<&SuperelementBody> {
        let mut all = self.scene.superelements();
        all.find(|(known, _)| *known == name).map(|(_, of)| of)
    }

    /// The scene's file and what is wrong with it.
    pub(super) fn refused(&self, message: &str) -> Error {
        Error::InScene {
            path: self.path.clone(),
            message: message.to_owned(),
        }
    }

    /// Contents of the scene.
    fn inventory(&self) -> String {
        let bodies = self
            .scene
            .bodies
            .iter()
            .map(|(name, body)| match &body.kind {
                BodyKind::Superelement(of) => format!("{name:?} ({})", of.file.display()),
                BodyKind::Rigid(_) => format!("{name:?} (rigid)"),
            });
        let bodies: Vec<String> = bodies.collect();
        match bodies.is_empty() {
            true => "it has no bodies".to_owned(),
            false => format!("it has {}", bodies.join(", ")),
        }
    }
}

fn name_of(path: &Path) -> String {
    let name = path.file_name().unwrap_or(OsStr::new(""));
    name.to_string_lossy().into_owned()
}
