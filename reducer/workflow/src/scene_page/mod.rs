//! The page of a run: its mechanism in motion, its histories, and what the run says of itself.
//!
//! A results file has where every body was and how it deflected (`/motion`). The scene is in it too; what the bodies look like is in the
//! superelements, which must be those of the run.

mod bodies;
mod box_of_all;
mod couplings;
mod histories;
mod meshes;
mod moments;
mod solids;
mod text;

use std::path::{Path, PathBuf};

use dcb_demand::SuperelementFiles;
use dcb_demand::pruning::{NarrowedScene, Pruning};
use dcb_formats::mesh::Dimension;
use dcb_formats::results::Results;
use dcb_formats::scene::{FieldRequest, Scene};
use dcb_report::Page;
use dcb_runtime::error::Error;
use dcb_runtime::model::Model;
use dcb_view::{Arrays, Description, Kind, MovingPage};

use moments::Moments;

/// What a page has beside the view.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Contents {
    /// The view and the histories.
    Motion,
    /// The tables of the run besides.
    Report,
}

/// Frames of a page, at most.
const MOST_FRAMES: usize = 900;
/// Numbers of all frames of a page, about: a number takes 4 bytes before it is compressed.
const FRAME_NUMBERS: usize = 300_000;
/// Frames that a page has, however many numbers they are.
const FEWEST_FRAMES: usize = 100;

/// A run, and the mechanism that it was of.
struct Run<'a> {
    path: &'a Path,
    results: Results,
    scene: Scene,
    model: Model,
}

/// The page of a results file. `scene` is the scene's file where it isn't where the run found it: paths of superelements start there.
///
/// # Errors
/// [`Error`] for results without motion, and for superelements that aren't there or have changed since the run.
pub fn scene_page(
    path: &Path,
    scene: Option<&Path>,
    contents: Contents,
) -> Result<MovingPage, Error> {
    let run = Run::open(path, scene)?;
    let time = run.results.time()?;
    if time.is_empty() {
        return Err(run.refused("has no rows: the run ended before its first step"));
    }
    let columns = run.motion_columns();
    if columns == 0 {
        return Err(run.refused(
            "has no motion of bodies (/motion): it was written by an earlier version; run the scene again",
        ));
    }
    let most = (FRAME_NUMBERS / columns).clamp(FEWEST_FRAMES, MOST_FRAMES);
    let moments = Moments::of(&run, &time, most)?;
    let mut arrays = Arrays::default();
    let mut units = units(&run.scene);
    let (histories, joints, loads);
    match moments.rows() {
        Some(rows) => {
            histories = histories::of(&run.results, &time, &mut arrays)?;
            joints = couplings::joints(&run);
            loads = couplings::loads(&run, rows, &time, &mut arrays);
        }
        // A mode is a motion without loads and without a time of its own.
        None => {
            units["time"] = "modes".into();
            histories = Vec::new();
            joints = couplings::joints(&run);
            loads = Vec::new();
        }
    }
    let drawn = bodies::drawn(&run, &moments, &mut arrays)?;
    let title = title(path);
    let mut report = Page::new(&title);
    text::write(&mut report, &run, &time, &moments, &drawn, contents)?;
    let description = Description {
        kind: Kind::Scene,
        title,
        units,
        dimension: run.scene.dimension.coordinate_count(),
        up: up(&run.scene),
        size: drawn.size,
        shapes: drawn.shapes,
        bodies: drawn.bodies,
        times: arrays.reals(moments.times().iter().copied()),
        joints,
        loads,
        histories,
        modes: Vec::new(),
        charts: Vec::new(),
    };
    Ok(MovingPage {
        report,
        description,
        arrays,
    })
}

impl<'a> Run<'a> {
    fn open(path: &'a Path, scene: Option<&Path>) -> Result<Self, Error> {
        let results = Results::open(path)?;
        let written = results.provenance("scene")?;
        let options = results.provenance("options")?;
        let scene_path = match scene {
            Some(given) => given.to_owned(),
            None => scene_file(path, &options),
        };
        let scene = Scene::parse(&written.to_string(), &scene_path)
            .map_err(|error| Error::from(error).in_file(path))?;
        find_superelements(&scene, &scene_path)?;
        let open = SuperelementFiles::default();
        let tolerance = options["tolerance"].as_f64();
        let pruned = tolerance.filter(|_| !options["left_out"].is_null());
        let mut narrowed = match pruned {
            Some(tolerance) => Pruning::of(&scene, &open, tolerance)
                .map_err(Error::from)?
                .applied_to(&scene),
            None => NarrowedScene::from(scene.clone()),
        };
        narrowed.scene.fields = Vec::new();
        narrowed.carrying = narrowed.carrying.with_all_nodes();
        let read_by_run = digests_of_inputs(&results)?;
        for (name, body) in scene.superelements() {
            let file = open.at(&scene.resolve(&body.file)).map_err(Error::from)?;
            if !read_by_run
                .iter()
                .any(|digest| digest == file.file.digest())
            {
                return Err(refused(
                    &scene.resolve(&body.file),
                    &format!(
                        "is not the file that the run of {} read; run the scene again",
                        path.display()
                    ),
                ));
            }
            let is_in_plane = file.superelement.dimension == scene.dimension;
            if is_in_plane && file.file.has_fields() {
                narrowed.scene.fields.push(FieldRequest {
                    body: name.to_owned(),
                    times: Some(Vec::new()),
                    every: None,
                    directory: PathBuf::new(),
                });
            }
        }
        let model = Model::load_narrowed(&narrowed, &open)?;
        Ok(Self {
            path,
            results,
            scene,
            model,
        })
    }

    /// Numbers of the motion of all bodies at one time.
    fn motion_columns(&self) -> usize {
        let channels = self.results.channels().iter();
        let moving = channels.filter(|channel| channel.path.starts_with("motion/"));
        moving.map(|channel| channel.columns.len()).sum()
    }

    fn refused(&self, message: &str) -> Error {
        refused(self.path, message)
    }
}

/// The SHA-256 of the files that the run read.
fn digests_of_inputs(results: &Results) -> Result<Vec<String>, Error> {
    let inputs = results.provenance("inputs")?;
    let digests = inputs.as_array().into_iter().flatten();
    Ok(digests
        .filter_map(|input| input["sha256"].as_str())
        .map(str::to_owned)
        .collect())
}

fn refused(path: &Path, message: &str) -> Error {
    Error::from(dcb_formats::Error::File {
        path: path.to_owned(),
        message: message.to_owned(),
    })
}

/// All superelements are where they are looked for; else says how to tell.
fn find_superelements(scene: &Scene, path: &Path) -> Result<(), Error> {
    let files = scene.superelements();
    let mut files = files.map(|(_, body)| scene.resolve(&body.file));
    match files.find(|file| !file.exists()) {
        None => Ok(()),
        Some(file) => Err(refused(
            &file,
            &format!(
                "is not there: it is looked for from {}; name the scene's file with --scene",
                path.display()
            ),
        )),
    }
}

/// Where the run found its scene, from the folder of the results; else beside them.
fn scene_file(results: &Path, options: &serde_json::Value) -> PathBuf {
    let relative = options["scene_file"].as_str();
    relative.map_or_else(
        || results.with_extension("json"),
        |relative| results.with_file_name("").join(relative),
    )
}

/// At most so many of the rows, evenly spread, with the first and the last.
fn spread(count: usize, most: usize) -> Vec<usize> {
    if count <= most {
        return (0..count).collect();
    }
    (0..most).map(|k| k * (count - 1) / (most - 1)).collect()
}

fn title(path: &Path) -> String {
    let stem = path.file_stem().unwrap_or_default();
    stem.to_string_lossy().into_owned()
}

fn units(scene: &Scene) -> serde_json::Value {
    let units = &scene.units;
    serde_json::json!({"length": units.length, "mass": units.mass, "time": units.time})
}

/// Against gravity; without any, z in space and y in the plane.
fn up(scene: &Scene) -> [f64; 3] {
    let gravity = scene.gravity_in_space();
    match scene.dimension {
        Dimension::Planar => [0.0, 1.0, 0.0],
        Dimension::Spatial if gravity.norm() > 0.0 => (-gravity / gravity.norm()).into(),
        Dimension::Spatial => [0.0, 0.0, 1.0],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_spread_from_the_first_to_the_last() {
        assert_eq!(spread(3, 10), [0, 1, 2]);
        assert_eq!(spread(101, 5), [0, 25, 50, 75, 100]);
        let many = spread(7201, 900);
        assert_eq!((many.len(), many[0], many[899]), (900, 0, 7200));
    }
}
