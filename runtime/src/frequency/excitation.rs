//! Inputs by the names that a scene gives them, and tables over frequency.

use std::collections::BTreeMap;

use dcb_formats::results::{FrequencyResponses, Signal};
use dcb_formats::scene::FrequencyResponse;
use faer::c64;

use crate::error::Error;

/// The place of an input among those of the responses.
///
/// # Errors
/// [`Error::Description`] at `location` for a name that is none of theirs.
pub(super) fn input_place(
    responses: &FrequencyResponses,
    asked: &FrequencyResponse,
    name: &str,
    location: impl FnOnce() -> String,
) -> Result<usize, Error> {
    let names = responses.inputs.iter().map(|input| input.name.as_str());
    let by_own_name = names.clone().position(|own| own == name);
    // An input may have been asked for by another name: NAME/INDEX of a load with one component.
    let is_one_to_one = asked.inputs.len() == responses.inputs.len();
    let by_request = || {
        let mut requested = asked.inputs.iter();
        requested
            .position(|input| input == name)
            .filter(|_| is_one_to_one)
    };
    by_own_name.or_else(by_request).ok_or_else(|| {
        let known: Vec<&str> = names.collect();
        Error::described(
            location(),
            format!(
                "is no input of the analysis (there are: {}); a load with several components has one input for each",
                known.join(", ")
            ),
        )
    })
}

/// Complex amplitudes over frequency of the input at a place.
type Amplitudes<'a> = (usize, &'a [[f64; 3]]);

/// Appends the load cases to the inputs: `Y_c(f) = Σ_j H_j(f) a_cj(f)`, one input of the unit 1 for each.
///
/// # Errors
/// [`Error::Description`] for a name that is no input, or for a case that has the name of one.
pub(super) fn append_cases(
    responses: &mut FrequencyResponses,
    asked: &FrequencyResponse,
) -> Result<(), Error> {
    if asked.cases.is_empty() {
        return Ok(());
    }
    let at = |case: &str| format!("analysis.frequency_response.cases.{case}");
    let mut amplitudes: Vec<Vec<Amplitudes>> = Vec::with_capacity(asked.cases.len());
    for (case, tables) in &asked.cases {
        if responses.inputs.iter().any(|input| input.name == *case) {
            return Err(Error::described(
                at(case),
                "has the name of an input; give it another",
            ));
        }
        amplitudes.push(of_case(responses, asked, tables, &at(case))?);
    }
    let (rows, columns) = (responses.outputs.len(), responses.inputs.len());
    let all = columns + amplitudes.len();
    let wider = || Vec::with_capacity(responses.frequency.len() * rows * all);
    let (mut real, mut imaginary, mut error) = (wider(), wider(), Vec::new());
    for (k, frequency) in responses.frequency.iter().enumerate() {
        for i in 0..rows {
            let first = (k * rows + i) * columns;
            let own = first..first + columns;
            real.extend_from_slice(&responses.real[own.clone()]);
            imaginary.extend_from_slice(&responses.imaginary[own.clone()]);
            let errors = responses.error.get(own).unwrap_or(&[]);
            error.extend_from_slice(errors);
            for case in &amplitudes {
                let terms = case.iter().map(|(j, table)| {
                    let place = first + j;
                    c64::new(responses.real[place], responses.imaginary[place])
                        * amplitude(table, *frequency)
                });
                let sum = terms.fold(c64::new(0.0, 0.0), |sum, term| sum + term);
                real.push(sum.re);
                imaginary.push(sum.im);
                if !errors.is_empty() {
                    let terms = case
                        .iter()
                        .map(|(j, table)| errors[*j] * amplitude(table, *frequency).norm());
                    error.push(terms.sum::<f64>());
                }
            }
        }
    }
    (responses.real, responses.imaginary, responses.error) = (real, imaginary, error);
    let signals = asked.cases.keys().map(|name| Signal {
        name: name.clone(),
        unit: "1".into(),
    });
    responses.inputs.extend(signals);
    Ok(())
}

fn of_case<'a>(
    responses: &FrequencyResponses,
    asked: &FrequencyResponse,
    tables: &'a BTreeMap<String, Vec<[f64; 3]>>,
    at: &str,
) -> Result<Vec<Amplitudes<'a>>, Error> {
    let tables = tables.iter();
    tables
        .map(|(name, table)| {
            let place = input_place(responses, asked, name, || format!("{at}.{name}"))?;
            Ok((place, table.as_slice()))
        })
        .collect()
}

/// Between the points of a table, zero beyond its ends.
pub(super) fn density(table: &[[f64; 2]], frequency: f64) -> f64 {
    between(table, frequency, |[at, _]| *at).map_or(0.0, |([_, low], [_, high], share)| {
        low + (high - low) * share
    })
}

/// Real and imaginary parts between the points of a table, zero beyond its ends.
pub(super) fn amplitude(table: &[[f64; 3]], frequency: f64) -> c64 {
    let zero = c64::new(0.0, 0.0);
    between(table, frequency, |[at, ..]| *at).map_or(zero, |(low, high, share)| {
        let part = |k: usize| low[k] + (high[k] - low[k]) * share;
        c64::new(part(1), part(2))
    })
}

/// The rows about a frequency, and its place between them.
fn between<T>(table: &[T], frequency: f64, at: impl Fn(&T) -> f64) -> Option<(&T, &T, f64)> {
    let next = table.partition_point(|row| at(row) <= frequency);
    let low = table.get(next.checked_sub(1)?)?;
    match table.get(next) {
        Some(high) => Some((low, high, (frequency - at(low)) / (at(high) - at(low)))),
        None => (at(low) == frequency).then_some((low, low, 0.0)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_is_joined_by_lines_and_zero_beyond() {
        let table = [[1.0, 2.0], [3.0, 4.0]];
        let found = [0.5, 1.0, 2.0, 3.0, 3.5].map(|f| density(&table, f));
        assert_eq!(found, [0.0, 2.0, 3.0, 4.0, 0.0]);
        let table = [[1.0, 2.0, 0.0], [3.0, 4.0, -2.0]];
        assert_eq!(amplitude(&table, 2.0), c64::new(3.0, -1.0));
        assert_eq!(amplitude(&table, 4.0), c64::new(0.0, 0.0));
    }
}
