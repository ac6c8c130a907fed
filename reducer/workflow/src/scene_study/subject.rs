//! Subject of a study: a scene, the modes that its superelements have, and the quantities that its runs are compared by.

use std::ops::Range;

use dcb_formats::results::Channel;
use indexmap::IndexMap;

use super::fineness::Fineness;
use super::grid::Grid;
use super::setting::{ModeCount, Setting, interval};
use dcb_formats::scene::{Analysis, BodyKind, Compatibility, Output, Scene};
use dcb_runtime::error::Error;
use dcb_runtime::model::{LoadedFile, Model, Recorder};

/// A scene and what is compared in its runs.
#[derive(Clone, Debug)]
pub struct Subject {
    /// The scene.
    pub scene: Scene,
    /// Its own options.
    pub own: Setting,
    /// Time at which runs end.
    pub end: f64,
    /// Modes in the file of each body that is a superelement.
    pub mode_counts: IndexMap<String, u32>,
    /// Superelements that were read.
    pub files: Vec<LoadedFile>,
    /// Quantities that are compared.
    pub quantities: Vec<Quantity>,
}

/// The columns of a recorded channel that have one unit: compared as a vector.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Quantity {
    /// Name for people: the channel's path, without `outputs/`; with the unit behind it where the channel has several.
    pub name: String,
    /// Unit; `1` where it has none.
    pub unit: String,
    /// The channel.
    pub path: String,
    /// Columns of the channel.
    columns: Vec<usize>,
    /// Names of these columns, empty where the channel's own name says everything.
    pub labels: Vec<String>,
}

impl Subject {
    /// A scene, compared by the outputs of these names, or by all of the scene's that any setting has alike: modal coordinates
    /// are left out, because their number changes.
    ///
    /// # Errors
    /// [`Error::Description`] for another analysis than `transient`, without outputs, with modal ones named, or without an
    /// end; [`Error::UnknownOutput`]; those of [`Setting::of`] and [`Model::load`].
    pub fn of(scene: Scene, outputs: &[String]) -> Result<Self, Error> {
        if scene.analysis != Analysis::Transient {
            return Err(Error::described(
                "analysis",
                "has to be \"transient\" for a study, which compares motions over time",
            ));
        }
        let own = Setting::of(&scene)?;
        let end = scene.integrator.map_or(0.0, |integrator| integrator.end);
        if let Fineness::Step(step) = own.fineness
            && step > end
        {
            return Err(Error::described(
                "integrator",
                format!("ends at {end} with a step of {step}: there is no motion to study"),
            ));
        }
        if end <= 0.0 {
            return Err(Error::described(
                "integrator",
                "ends at 0: there is no motion to study",
            ));
        }
        let mut subject = Self {
            own,
            end,
            mode_counts: IndexMap::new(),
            files: Vec::new(),
            quantities: Vec::new(),
            scene,
        };
        let whole = Setting {
            modes: ModeCount::All,
            compatibility: Compatibility::Strong,
            ..own
        };
        let model = Model::load(&whole.applied_to(&subject)?)?;
        let bodies = subject.scene.bodies.iter().zip(&model.system.bodies);
        for ((name, body), loaded) in bodies {
            if matches!(body.kind, BodyKind::Superelement(_)) {
                let count = u32::try_from(loaded.flexible.mode_count).unwrap_or(u32::MAX);
                subject.mode_counts.insert(name.clone(), count);
            }
        }
        subject.quantities = subject.compared(&model.recorder, outputs)?;
        subject.files = model.files;
        Ok(subject)
    }

    /// The times at which runs with these options are compared.
    pub fn grid(&self, settings: &[Setting]) -> Grid {
        let apart = |setting: &Setting| match setting.fineness {
            Fineness::Step(step) => step,
            Fineness::Accuracy(_) => interval(self.end),
        };
        Grid::of(settings.iter().map(apart), self.end)
    }

    /// Compares outputs that stand beside each other in the scene as one vector, if all of them are compared.
    pub fn join(&mut self, name: &str, outputs: &[String]) {
        let is_of = |quantity: &Quantity| {
            let output = quantity.path.strip_prefix("outputs/");
            output.is_some_and(|output| outputs.iter().any(|name| name == output))
        };
        let parts: Vec<Quantity> = (self.quantities.iter())
            .filter(|quantity| is_of(quantity))
            .cloned()
            .collect();
        let Some(mut whole) = parts.first().cloned() else {
            return;
        };
        whole.name = name.to_owned();
        (whole.columns, whole.labels) = (Vec::new(), Vec::new());
        let mut first = 0;
        for part in parts {
            let short = part.path.strip_prefix("outputs/").unwrap_or(&part.path);
            let labels = part.labels.iter().map(|label| format!("{short} {label}"));
            whole.labels.extend(labels);
            whole
                .columns
                .extend(part.columns.iter().map(|column| first + column));
            first += part.width();
        }
        self.quantities.retain(|quantity| !is_of(quantity));
        self.quantities.push(whole);
    }

    /// The most modes that a superelement has; `None` without superelements.
    pub fn most_modes(&self) -> Option<u32> {
        self.mode_counts.values().copied().max()
    }

    fn compared(&self, recorder: &Recorder, outputs: &[String]) -> Result<Vec<Quantity>, Error> {
        let is_modal = |name: &str| {
            let output = self.scene.outputs.get(name);
            matches!(output, Some(Output::Modal(_)))
        };
        let names: Vec<String> = match outputs {
            [] => {
                let own = self.scene.outputs.keys().filter(|name| !is_modal(name));
                own.map(|name| format!("outputs/{name}")).collect()
            }
            named => named.to_vec(),
        };
        if names.is_empty() {
            return Err(Error::described(
                "outputs",
                "has nothing to compare runs by; add outputs, or name recorded channels with --outputs (`simulate show` lists them)",
            ));
        }
        let mut quantities: Vec<Quantity> = Vec::new();
        for name in &names {
            let range = recorder.columns(name)?;
            let channel = at(recorder.channels(), &range).ok_or_else(|| Error::UnknownOutput {
                name: name.clone(),
                hint: String::new(),
            })?;
            let short = channel.path.strip_prefix("outputs/");
            if short.is_some_and(is_modal) {
                return Err(Error::described(
                    format!("--outputs: {name}"),
                    "has modal coordinates, whose number changes with the modes; name another output",
                ));
            }
            if quantities.iter().all(|known| known.path != channel.path) {
                quantities.extend(by_unit(channel, short.unwrap_or(&channel.path)));
            }
        }
        Ok(quantities)
    }
}

impl Quantity {
    /// Where its columns are in a recorder's rows.
    pub(super) fn places(&self, recorder: &Recorder) -> Result<Vec<usize>, Error> {
        let first = recorder.columns(&self.path)?.start;
        Ok(self.columns.iter().map(|column| first + column).collect())
    }

    /// Number of columns.
    pub fn width(&self) -> usize {
        self.columns.len()
    }
}

/// The channel whose columns are there.
fn at<'c>(channels: &'c [Channel], range: &Range<usize>) -> Option<&'c Channel> {
    let mut first = 0;
    channels.iter().find(|channel| {
        let found = first == range.start;
        first += channel.columns.len();
        found
    })
}

/// The columns of a channel, those of one unit together.
fn by_unit(channel: &Channel, name: &str) -> Vec<Quantity> {
    let mut units: IndexMap<&str, Vec<usize>> = IndexMap::new();
    for (index, column) in channel.columns.iter().enumerate() {
        units.entry(&column.unit).or_default().push(index);
    }
    let has_several = units.len() > 1;
    let quantity = |(unit, columns): (&str, Vec<usize>)| Quantity {
        name: match has_several {
            true => format!("{name} [{unit}]"),
            false => name.to_owned(),
        },
        unit: unit.to_owned(),
        path: channel.path.clone(),
        labels: (columns.iter())
            .map(|column| channel.columns[*column].name.clone())
            .collect(),
        columns,
    };
    units.into_iter().map(quantity).collect()
}
