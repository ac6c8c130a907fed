//! Purpose of a superelement, as far as its file says.

use std::f64::consts::TAU;

use dcb_formats::superelement::{SelectionRecord, Superelement};
use faer::Mat;

/// Who left something out of a superelement.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LeftOutBy {
    /// Its reduction.
    Reduction,
    /// A selection, before it was written.
    Selection,
    /// The run that uses it.
    Run,
}

/// A frequency up to which a superelement's responses are good.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrequencyLimit {
    /// Cycles per time.
    pub frequency: f64,
    /// Who left out what is beyond.
    pub by: LeftOutBy,
}

/// An interface with attachments for some directions of force only.
#[derive(Clone, Debug, PartialEq)]
pub struct LoadedDirections {
    /// Index of the interface.
    pub interface: usize,
    /// Forces on its rows whose static responses the superelement has, (rows of the interface, forces).
    pub forces: Mat<f64>,
    /// Who left out the others.
    pub by: LeftOutBy,
}

/// Purpose of a superelement: everything that isn't limited here.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MadeFor {
    /// How fast motions may be; `None` if no mode was left out, or nobody says.
    pub frequency: Option<FrequencyLimit>,
    /// Interfaces that answer to some forces only. One may be listed several times: it then answers to what all of these say.
    pub directions: Vec<LoadedDirections>,
}

impl MadeFor {
    /// The purpose by the selections that it went through and by the modes that the reduction left out.
    pub fn of(superelement: &Superelement) -> Self {
        Self::of_run(superelement, usize::MAX)
    }

    /// The same where the run made all selections but the first `before`.
    pub fn of_run(superelement: &Superelement, before: usize) -> Self {
        let records = superelement.selections();
        let by = |place: usize| match place < before {
            true => LeftOutBy::Selection,
            false => LeftOutBy::Run,
        };
        let directions = records.iter().enumerate().flat_map(|(place, record)| {
            let along = record.loaded_along.iter();
            along.filter_map(move |(name, forces)| {
                Some(LoadedDirections {
                    by: by(place),
                    ..directions(superelement, name, forces)?
                })
            })
        });
        Self {
            directions: directions.collect(),
            frequency: frequency(superelement, records, by),
        }
    }
}

fn directions(of: &Superelement, name: &str, forces: &[Vec<f64>]) -> Option<LoadedDirections> {
    let mut interfaces = of.interfaces.iter();
    let interface = interfaces.position(|known| known.name == name)?;
    let own = of.rows.iter().filter(|row| row.interface == interface);
    let count = own.count();
    (!forces.is_empty()).then(|| LoadedDirections {
        interface,
        forces: Mat::from_fn(count, forces.len(), |row, force| forces[force][row]),
        by: LeftOutBy::Selection,
    })
}

/// Selections that say up to which frequency they are good may leave out slower modes that no force moves.
fn frequency(
    of: &Superelement,
    records: &[SelectionRecord],
    by: impl Fn(usize) -> LeftOutBy,
) -> Option<FrequencyLimit> {
    let all_say = records.iter().all(|record| record.up_to.is_some());
    let square = match records.first() {
        Some(first) if all_say => first.first_omitted_eigenvalue.unwrap_or(f64::INFINITY),
        _ => of.modes.first_omitted_eigenvalue,
    };
    let reduction = FrequencyLimit {
        frequency: square.max(0.0).sqrt() / TAU,
        by: LeftOutBy::Reduction,
    };
    let selections = records.iter().enumerate().filter_map(|(place, record)| {
        Some(FrequencyLimit {
            frequency: record.up_to?,
            by: by(place),
        })
    });
    let limits = [reduction].into_iter().chain(selections);
    limits
        .filter(|limit| limit.frequency.is_finite())
        .min_by(|a, b| a.frequency.total_cmp(&b.frequency))
}
