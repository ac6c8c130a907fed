//! How a superelement was made to a file: datasets for programs, the provenance for people.

use faer::Mat;

use super::{Writer, row_major, text};
use crate::dcb::names;
use crate::superelement::{Derivation, SelectionRecord, Superelement};

/// Forces along which a selection left an interface loaded.
struct LoadedAlong<'d> {
    selection: usize,
    interface: usize,
    /// Over the rows of the interface.
    force: &'d [f64],
}

/// How many of them there are.
pub(super) fn loaded_along_count(of: &Superelement) -> usize {
    loaded_along(of).count()
}

fn loaded_along(of: &Superelement) -> impl Iterator<Item = LoadedAlong<'_>> {
    let place = |name: &String| {
        let mut interfaces = of.interfaces.iter();
        interfaces.position(|interface| interface.name == *name)
    };
    let records = of.selections().iter().enumerate();
    records.flat_map(move |(selection, record)| {
        let placed = record.loaded_along.iter();
        let placed = placed.filter_map(move |(name, forces)| Some((place(name)?, forces)));
        placed.flat_map(move |(interface, forces)| {
            forces.iter().map(move |force| LoadedAlong {
                selection,
                interface,
                force,
            })
        })
    })
}

impl Writer<'_> {
    /// For programs.
    pub(super) fn derivation(
        &mut self,
        of: &Superelement,
        derivation: &Derivation,
    ) -> hdf5::Result<()> {
        self.sink.group("derivation")?;
        let word = names::coupling_source(derivation.coupling_source);
        self.sink
            .texts("/derivation/coupling_source", &[word.to_owned()])?;
        if let Some(directions) = derivation.interface_directions {
            let counts = [directions.kept, directions.available].map(|count| count as i64);
            self.sink
                .integers("/derivation/interface_directions", &counts)?;
        }
        if !derivation.left_out_columns.is_empty() {
            self.sink
                .texts("/derivation/left_out_columns", &derivation.left_out_columns)?;
        }
        if derivation.internal_rows > 0 {
            let count = derivation.internal_rows as i64;
            self.sink.integers("/derivation/internal_rows", &[count])?;
        }
        match derivation.selections.is_empty() {
            true => Ok(()),
            false => self.selections(of),
        }
    }

    fn selections(&mut self, of: &Superelement) -> hdf5::Result<()> {
        let records = of.selections();
        let mut modes = Vec::new();
        for (selection, record) in records.iter().enumerate() {
            let first = modes.len();
            modes.extend((0..record.of_modes).map(|_| [selection as i64, 0]));
            for mode in &record.modes {
                modes[first + mode][1] = 1;
            }
        }
        let reals = |value: fn(&SelectionRecord) -> Option<f64>| -> Vec<f64> {
            let values = records.iter().map(value);
            values.map(|value| value.unwrap_or(f64::INFINITY)).collect()
        };
        self.sink
            .integers("/derivation/selection_modes", modes.as_flattened())?;
        self.sink.reals(
            "/derivation/selection_first_omitted_eigenvalues",
            &reals(|record| record.first_omitted_eigenvalue),
        )?;
        self.sink.reals(
            "/derivation/selection_frequency_limits",
            &reals(|record| record.up_to),
        )?;
        let loaded: Vec<LoadedAlong> = loaded_along(of).collect();
        let mut forces = Mat::zeros(of.rows.len(), loaded.len());
        for (column, along) in loaded.iter().enumerate() {
            let rows = (0..of.rows.len()).filter(|row| of.rows[*row].interface == along.interface);
            for (row, force) in rows.zip(along.force) {
                forces[(row, column)] = *force;
            }
        }
        let places = loaded.iter();
        let places = places.flat_map(|along| [along.selection as i64, along.interface as i64]);
        self.sink
            .reals("/derivation/selection_forces", &row_major(&forces))?;
        self.sink.integers(
            "/derivation/selection_force_interfaces",
            &places.collect::<Vec<_>>(),
        )
    }

    /// For people.
    pub(super) fn provenance(&mut self, of: &Superelement) -> hdf5::Result<()> {
        self.sink.group("provenance")?;
        let provenance = &of.provenance;
        let inputs: Vec<_> = provenance
            .inputs
            .iter()
            .map(|source| serde_json::json!({ "role": source.role, "file_name": source.file_name, "sha256": source.sha256 }))
            .collect();
        self.sink
            .attribute("/provenance", "tool_version", text(&provenance.generator))?;
        self.sink.attribute(
            "/provenance",
            "inputs",
            text(&serde_json::Value::from(inputs).to_string()),
        )?;
        self.sink.attribute(
            "/provenance",
            "options",
            text(&provenance.options.to_string()),
        )?;
        self.sink.attribute(
            "/provenance",
            "quality",
            text(&provenance.quality.to_string()),
        )?;
        let warnings = serde_json::Value::from(provenance.warnings.as_slice());
        self.sink
            .attribute("/provenance", "warnings", text(&warnings.to_string()))
    }
}
