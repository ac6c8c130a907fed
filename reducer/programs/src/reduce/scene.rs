//! The options `--scene`, `--tolerance` and `--body` of a reduction.

use std::path::{Path, PathBuf};

use clap::Args;
use dcb_formats::Superelement;
use dcb_formats::component::Component;
use dcb_formats::mesh::Mesh;
use dcb_formats::superelement::RecoveryBasis;
use serde_json::{Value, json};

use crate::reduce::part::timing::StageClock;
use dcb_reducer::Reduction;
use dcb_reducer::Work;
use dcb_reducer::error::Error;
use dcb_reducer::mode_selection::DEFAULT_MODES;
use dcb_reducer::quality::Quality;
use dcb_workflow::scene::{
    CachedReductions, ComponentDemand, Extent, Fitted, Limits, PartInScene, Search,
};

/// Error of the part's responses where nothing is said.
const DEFAULT_TOLERANCE: f64 = 1e-3;

/// Options of a reduction for a scene.
#[derive(Debug, Args)]
pub struct SceneReductionArguments {
    /// Keep what this scene asks of the part, and leave out the rest (docs/scene-driven.md).
    #[arg(long = "scene", value_name = "SCENE.json", conflicts_with_all = ["max_frequency", "interface_modes", "without_fields", "without_estimate"])]
    pub file: Option<PathBuf>,
    /// Relative error that the part's responses may have [default: 1e-3].
    #[arg(long, value_name = "E", requires = "file", allow_hyphen_values = true, value_parser = tolerance)]
    pub tolerance: Option<f64>,
    /// Keep enough modes for the scene, and leave nothing out.
    #[arg(long, requires = "file")]
    pub keep_all: bool,
    /// Bodies made of the part [default: those whose file has the output's name].
    #[arg(long, value_name = "NAME", requires = "file", value_delimiter = ',')]
    pub body: Vec<String>,
}

fn tolerance(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value < 1.0 => Ok(value),
        _ => Err("a number above 0 and below 1 is wanted".into()),
    }
}

/// Result of a reduction, ready to be written.
pub(crate) struct Made {
    pub superelement: Superelement,
    pub fields: Option<RecoveryBasis>,
    pub mesh: Option<Mesh>,
    pub quality: Quality,
    pub work: Work,
}

impl SceneReductionArguments {
    /// The scene, if there is one, and the bodies that are meant.
    pub(crate) fn part(
        &self,
        output: &Path,
        usual_output: &Path,
    ) -> Result<Option<PartInScene>, Error> {
        let find = |path: &PathBuf| PartInScene::find(path, &self.body, output, usual_output);
        self.file.as_ref().map(find).transpose()
    }

    /// Reduces for the scene; `modes` is the most that may be kept, if that is said.
    pub(crate) fn reduce(
        &self,
        part: &PartInScene,
        component: Component,
        options: &Reduction,
        most_modes: Option<usize>,
        cached: Option<&CachedReductions<'_>>,
        clock: &mut StageClock,
    ) -> Result<Made, Error> {
        let limits = Limits {
            tolerance: self.tolerance.unwrap_or(DEFAULT_TOLERANCE),
            most_modes,
            default_modes: DEFAULT_MODES,
            extent: match self.keep_all {
                true => Extent::Everything,
                false => Extent::Needed,
            },
        };
        let asked = ComponentDemand::of(part, component)?;
        let search = Search {
            asked: &asked,
            options,
            limits: &limits,
            cached,
        };
        let whole = search.whole(clock)?;
        clock.start("leave out");
        let Fitted {
            superelement,
            fields,
            quality,
            work,
        } = Fitted::of(whole, part, &asked, &limits)?;
        clock.stop();
        let (fields, mesh) = fields.unzip();
        Ok(Made {
            superelement,
            fields,
            mesh,
            quality,
            work,
        })
    }

    /// For the file.
    pub(crate) fn as_json(&self, part: &PartInScene) -> Value {
        json!({
            "file": part.path.file_name().map(|name| name.to_string_lossy()),
            "bodies": part.bodies,
            "tolerance": self.tolerance.unwrap_or(DEFAULT_TOLERANCE),
        })
    }
}
