//! Small oscillations in a results file: `/modes`.
//!
//! ```text
//! /modes/frequency       (n_m)            cycles per time
//! /modes/damping_ratio   (n_m)            fraction of the critical damping
//! /modes/growth          (n_m)            real part of s in exp(s t)
//! /modes/shapes/<body>   (n_m, 2, 6 + n)  δq in phase, and a quarter period behind
//! ```
//! Their axes have the scales `mode`, `phase` and `shapes/<body>_columns`. None of them has two axes, as channels have, so readers that don't know them leave them alone.

use hdf5::Location;

use super::channel::Column;
use super::scales::{Ties, make_scale, write_names};
use crate::component::Units;
use crate::hdf5_files::attributes::{self, Value};
use crate::hdf5_files::inventory::{Finding, Inventory};

/// Group of the modes.
const GROUP: &str = "modes";
/// The lists, with what they are.
const LISTS: [(&str, &str); 3] = [
    ("frequency", "frequency of each mode, by increasing |s|"),
    (
        "damping_ratio",
        "damping of each mode as a part of the critical one, -Re(s)/|s|",
    ),
    (
        "growth",
        "real part of s where the mode goes with exp(s t): negative where it decays",
    ),
];

/// Modes of small oscillations, by increasing |s|.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SystemModes {
    /// Cycles per time, (n_m).
    pub frequency: Vec<f64>,
    /// Fractions of the critical damping, (n_m).
    pub damping_ratio: Vec<f64>,
    /// Real parts of s, 1/time, (n_m).
    pub growth: Vec<f64>,
    /// The motion of each body.
    pub shapes: Vec<ModeShapes>,
}

/// The motion of one body in all modes.
#[derive(Clone, Debug, PartialEq)]
pub struct ModeShapes {
    /// Name of the body.
    pub body: String,
    /// Meaning of each number of a motion, (6 + n).
    pub columns: Vec<Column>,
    /// (n_m, 2, 6 + n), row by row: in phase, and a quarter period behind.
    pub values: Vec<f64>,
}

/// `Hz` where the time is in seconds, else `1/TIME`.
pub fn frequency_unit(units: &Units) -> String {
    match units.time.as_str() {
        "s" => "Hz".to_owned(),
        time => format!("1/{time}"),
    }
}

impl SystemModes {
    /// The lists with their names and units.
    pub fn lists(&self, units: &Units) -> [(&'static str, String, &[f64]); 3] {
        [
            ("frequency", frequency_unit(units), &self.frequency),
            ("damping_ratio", "1".to_owned(), &self.damping_ratio),
            ("growth", format!("1/{}", units.time), &self.growth),
        ]
    }

    /// Bytes of the numbers.
    pub(super) fn size(&self) -> u64 {
        let shapes = self.shapes.iter().map(|of| of.values.len());
        8 * (4 * self.frequency.len() + shapes.sum::<usize>()) as u64
    }

    /// Number of datasets.
    pub(super) fn dataset_count(&self) -> usize {
        LISTS.len() + 2 + 2 * self.shapes.len()
    }

    /// Adds the datasets to a file.
    pub(super) fn write(&self, file: &hdf5::File, units: &Units) -> hdf5::Result<()> {
        let text = |object: &Location, name: &str, text: &str| {
            attributes::write(object, name, &Value::Text(text.to_owned()))
        };
        let count = self.frequency.len();
        let mut ties = Ties::default();
        let (mode, phase) = (format!("{GROUP}/mode"), format!("{GROUP}/phase"));
        let numbers: Vec<f64> = (1..=count).map(|number| number as f64).collect();
        let scale = file.new_dataset::<f64>().shape(count);
        let scale = scale.create(mode.as_str())?;
        scale.write_raw(&numbers)?;
        make_scale(&scale, "mode")?;
        if !self.shapes.is_empty() {
            write_names(file, &phase, &["in phase", "a quarter period behind"])?;
        }
        for ((name, unit, values), (_, description)) in self.lists(units).iter().zip(LISTS) {
            let path = format!("{GROUP}/{name}");
            let dataset = file
                .new_dataset::<f64>()
                .shape(count)
                .create(path.as_str())?;
            dataset.write_raw(values)?;
            text(&dataset, "units", unit)?;
            text(&dataset, "description", description)?;
            ties.tie(file, &path, std::slice::from_ref(&mode))?;
        }
        for shapes in &self.shapes {
            let path = format!("{GROUP}/shapes/{}", shapes.body);
            let shape = (count, 2, shapes.columns.len());
            let dataset = file
                .new_dataset::<f64>()
                .shape(shape)
                .create(path.as_str())?;
            dataset.write_raw(&shapes.values)?;
            let texts = |of: fn(&Column) -> &String| {
                Value::Texts(
                    shapes
                        .columns
                        .iter()
                        .map(|column| of(column).clone())
                        .collect(),
                )
            };
            attributes::write(&dataset, "columns", &texts(|column| &column.name))?;
            attributes::write(&dataset, "column_units", &texts(|column| &column.unit))?;
            text(&dataset, "units", "mixed")?;
            text(
                &dataset,
                "description",
                "motion of the body: in phase, and a quarter period behind; translations and rotations of the frame in body axes, and its coordinates",
            )?;
            let mut columns = format!("{path}_columns");
            let is_body = |path: &str| {
                let mut bodies = self.shapes.iter();
                bodies.any(|other| path.ends_with(&format!("/{}", other.body)))
            };
            while is_body(&columns) {
                columns.push('_');
            }
            let names: Vec<&str> = (shapes.columns.iter())
                .map(|column| column.name.as_str())
                .collect();
            write_names(file, &columns, &names)?;
            ties.tie(file, &path, &[mode.clone(), phase.clone(), columns])?;
        }
        ties.finish(file)
    }

    /// The lists of a file; `None` if it has no modes. Shapes are left in the file.
    pub(super) fn read(
        inventory: &Inventory,
        mut values: impl FnMut(&str, usize) -> Result<Vec<f64>, Finding>,
    ) -> Result<Option<Self>, Finding> {
        let count = |name: &str| {
            let path = format!("/{GROUP}/{name}");
            let shape = inventory
                .entries
                .get(&path)
                .map(|entry| &entry.line.shape[..]);
            match shape {
                None => Ok(None),
                Some([count]) => Ok(Some(*count)),
                Some(shape) => Err(Finding::at(
                    &path,
                    format!("has the shape {shape:?}; it must be a list"),
                )),
            }
        };
        let Some(expected) = count("frequency")? else {
            return Ok(None);
        };
        let mut lists = Vec::new();
        for (name, _) in LISTS {
            let path = format!("/{GROUP}/{name}");
            match count(name)? {
                Some(found) if found == expected => lists.push(values(&path, expected)?),
                found => {
                    let found = found.unwrap_or(0);
                    return Err(Finding::at(
                        &path,
                        format!("has {found} values, but there are {expected} modes"),
                    ));
                }
            }
        }
        let mut lists = lists.into_iter();
        let mut next = || lists.next().unwrap_or_default();
        Ok(Some(Self {
            frequency: next(),
            damping_ratio: next(),
            growth: next(),
            shapes: Vec::new(),
        }))
    }
}
