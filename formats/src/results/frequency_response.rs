//! Frequency responses in a results file: `/frequency_response`.
//!
//! ```text
//! /frequency_response/frequency   (n_f)               cycles per time
//! /frequency_response/real        (n_f, n_y, n_u)     each output by each input of unit amplitude
//! /frequency_response/imaginary   (n_f, n_y, n_u)
//! /frequency_response/error       (n_f, n_y, n_u)     size of what the modes that files leave out do to it, an estimate; NaN where nothing is known
//! /frequency_response/density     (n_f, n_y, 1)       one-sided power spectral density of each output under the random inputs
//! ```
//! `real` has the attributes `outputs`, `output_units`, `inputs` and `input_units`. The oscillation of an output is Re(H exp(iωt)) under an input cos(ωt).

use crate::component::Units;
use crate::hdf5_files::attributes::{self, Value};
use crate::hdf5_files::inventory::{Finding, Inventory};

use super::modes::frequency_unit;
use super::scales::{Ties, make_scale, write_names};

const GROUP: &str = "frequency_response";

/// A name with its unit.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Signal {
    /// Name, for example `tip.x`.
    pub name: String,
    /// Unit.
    pub unit: String,
}

/// Steady oscillations of outputs by inputs of unit amplitude.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FrequencyResponses {
    /// Cycles per time, ascending, (n_f).
    pub frequency: Vec<f64>,
    /// n_u of them.
    pub inputs: Vec<Signal>,
    /// n_y of them.
    pub outputs: Vec<Signal>,
    /// (n_f, n_y, n_u), the last index fastest.
    pub real: Vec<f64>,
    /// The same.
    pub imaginary: Vec<f64>,
    /// Size of the error by the modes that files leave out, an estimate, in the unit of the response, (n_f, n_y, n_u); NaN where nothing is known, empty where that is
    /// everywhere.
    pub error: Vec<f64>,
    /// One-sided power spectral densities, (n_f, n_y); empty without random inputs.
    pub density: Vec<f64>,
}

impl FrequencyResponses {
    /// An output by an input over the frequencies: real and imaginary parts.
    pub fn of(&self, output: usize, input: usize) -> Vec<[f64; 2]> {
        let (rows, columns) = (self.outputs.len(), self.inputs.len());
        let place = |k: usize| (k * rows + output) * columns + input;
        (0..self.frequency.len())
            .map(|k| [self.real[place(k)], self.imaginary[place(k)]])
            .collect()
    }

    /// Sizes of errors of an output by an input over the frequencies; `None` where nothing is known of any.
    pub fn error_of(&self, output: usize, input: usize) -> Option<Vec<f64>> {
        let (rows, columns) = (self.outputs.len(), self.inputs.len());
        let own = self.error.iter().skip(output * columns + input);
        let own: Vec<f64> = own.step_by((rows * columns).max(1)).copied().collect();
        own.iter().any(|error| error.is_finite()).then_some(own)
    }

    /// Unit of an output by an input; that of the output by an input without unit.
    pub fn unit(&self, output: usize, input: usize) -> String {
        let output = &self.outputs[output].unit;
        match self.inputs[input].unit.as_str() {
            "1" => output.clone(),
            unit => format!("({output})/({unit})"),
        }
    }

    /// Density of an output over the frequencies; `None` without random inputs.
    pub fn density_of(&self, output: usize) -> Option<Vec<f64>> {
        let rows = self.outputs.len();
        (!self.density.is_empty()).then(|| {
            (0..self.frequency.len())
                .map(|k| self.density[k * rows + output])
                .collect()
        })
    }

    /// Bytes of the numbers.
    pub(super) fn size(&self) -> u64 {
        let numbers = 2 * self.frequency.len() + 2 * self.real.len();
        8 * (numbers + self.error.len() + self.density.len()) as u64
    }

    /// Number of datasets.
    pub(super) fn dataset_count(&self) -> usize {
        8
    }

    /// Adds the datasets to a file.
    pub(super) fn write(&self, file: &hdf5::File, units: &Units) -> hdf5::Result<()> {
        let count = self.frequency.len();
        let path = |name: &str| format!("{GROUP}/{name}");
        let mut ties = Ties::default();
        let frequency = file.new_dataset::<f64>().shape(count);
        let frequency = frequency.create(path("frequency").as_str())?;
        frequency.write_raw(&self.frequency)?;
        make_scale(&frequency, "frequency")?;
        let text = |text: &str| Value::Text(text.to_owned());
        attributes::write(&frequency, "units", &text(&frequency_unit(units)))?;
        let names = |of: &[Signal]| of.iter().map(|one| one.name.clone()).collect::<Vec<_>>();
        let units_of = |of: &[Signal]| of.iter().map(|one| one.unit.clone()).collect::<Vec<_>>();
        for (scale, of) in [("output", &self.outputs), ("input", &self.inputs)] {
            let names = names(of);
            write_names(
                file,
                &path(scale),
                &names.iter().map(String::as_str).collect::<Vec<_>>(),
            )?;
        }
        let scales = [path("frequency"), path("output"), path("input")];
        for (name, values, description) in [
            (
                "real",
                &self.real,
                "real part of each output by each input of unit amplitude",
            ),
            (
                "imaginary",
                &self.imaginary,
                "imaginary part of each output by each input of unit amplitude",
            ),
            (
                "error",
                &self.error,
                "size of the error by the modes that files leave out, an estimate",
            ),
        ] {
            if values.is_empty() && name == "error" {
                continue;
            }
            let dataset = file.new_dataset::<f64>();
            let dataset = dataset.shape((count, self.outputs.len(), self.inputs.len()));
            let dataset = dataset.create(path(name).as_str())?;
            dataset.write_raw(values)?;
            attributes::write(&dataset, "units", &text("mixed"))?;
            attributes::write(&dataset, "description", &text(description))?;
            for (key, list) in [
                ("outputs", names(&self.outputs)),
                ("output_units", units_of(&self.outputs)),
                ("inputs", names(&self.inputs)),
                ("input_units", units_of(&self.inputs)),
            ] {
                attributes::write(&dataset, key, &Value::Texts(list))?;
            }
            ties.tie(file, &path(name), &scales)?;
        }
        if !self.density.is_empty() {
            let single = path("total");
            write_names(file, &single, &["all random inputs"])?;
            let dataset = file
                .new_dataset::<f64>()
                .shape((count, self.outputs.len(), 1));
            let dataset = dataset.create(path("density").as_str())?;
            dataset.write_raw(&self.density)?;
            attributes::write(&dataset, "units", &text("mixed"))?;
            let description = "one-sided power spectral density of each output under the random inputs, unit squared by cycles per time";
            attributes::write(&dataset, "description", &text(description))?;
            ties.tie(
                file,
                &path("density"),
                &[path("frequency"), path("output"), single],
            )?;
        }
        ties.finish(file)
    }

    /// Those of a file; `None` if it has none.
    pub(super) fn read(
        inventory: &Inventory,
        mut values: impl FnMut(&str, [usize; 2]) -> Result<Vec<f64>, Finding>,
    ) -> Result<Option<Self>, Finding> {
        let at = |name: &str| format!("/{GROUP}/{name}");
        let shape = |name: &str| {
            inventory
                .entries
                .get(&at(name))
                .map(|entry| entry.line.shape.clone())
        };
        let Some(shape_of_frequency) = shape("frequency") else {
            return Ok(None);
        };
        let [count] = shape_of_frequency[..] else {
            return Err(Finding::at(&at("frequency"), "isn't a list".to_owned()));
        };
        let list = |name: &str| match inventory.attribute(&at("real"), name) {
            Some(Value::Texts(list)) => Ok(list.clone()),
            Some(Value::Text(one)) => Ok(vec![one.clone()]),
            _ => Err(Finding::at(
                &at("real"),
                format!("has no attribute {name:?} of texts"),
            )),
        };
        let signals = |names: &str, units: &str| -> Result<Vec<Signal>, Finding> {
            let (names, units) = (list(names)?, list(units)?);
            if names.len() != units.len() {
                return Err(Finding::at(
                    &at("real"),
                    "has other numbers of names and units".to_owned(),
                ));
            }
            Ok(names
                .into_iter()
                .zip(units)
                .map(|(name, unit)| Signal { name, unit })
                .collect())
        };
        let outputs = signals("outputs", "output_units")?;
        let inputs = signals("inputs", "input_units")?;
        let expected = vec![count, outputs.len(), inputs.len()];
        let has_error = shape("error").is_some();
        let checked = ["real", "imaginary"].into_iter();
        for name in checked.chain(has_error.then_some("error")) {
            if shape(name).as_ref() != Some(&expected) {
                return Err(Finding::at(
                    &at(name),
                    format!(
                        "has the shape {:?}; expected {expected:?}",
                        shape(name).unwrap_or_default()
                    ),
                ));
            }
        }
        let density = match shape("density") {
            None => Vec::new(),
            Some(found) if found == [count, outputs.len(), 1] => {
                values(&at("density"), [count, outputs.len()])?
            }
            Some(found) => {
                return Err(Finding::at(
                    &at("density"),
                    format!("has the shape {found:?}"),
                ));
            }
        };
        let columns = outputs.len() * inputs.len();
        Ok(Some(Self {
            frequency: values(&at("frequency"), [count, 1])?,
            real: values(&at("real"), [count, columns])?,
            imaginary: values(&at("imaginary"), [count, columns])?,
            error: match has_error {
                true => values(&at("error"), [count, columns])?,
                false => Vec::new(),
            },
            inputs,
            outputs,
            density,
        }))
    }
}
