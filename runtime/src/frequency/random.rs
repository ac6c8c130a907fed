//! Random responses: densities of outputs under inputs that are random, stationary and independent of each other.
//!
//! ```text
//! S_y(f) = Σ_j |H_yj(f)|² S_j(f)        rms² = ∫ S_y df        zero crossings upwards = (∫ f² S_y df / ∫ S_y df)^½
//! ```

use dcb_formats::results::FrequencyResponses;

use dcb_formats::scene::FrequencyResponse;

use crate::error::Error;

/// Differences of an integral to that over every other frequency above this are told.
const COARSE: f64 = 0.01;

/// One output under random inputs.
#[derive(Clone, Debug, PartialEq)]
pub struct RandomOutput {
    /// Its name.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// Root of the mean square over the frequencies of the analysis.
    pub rms: f64,
    /// Upward crossings of the mean, by time.
    pub zero_crossings: f64,
    /// Relative difference of the rms to that with every other frequency.
    pub coarseness: f64,
}

impl RandomOutput {
    /// Whether the frequencies are too far apart for the integral.
    pub fn is_coarse(&self) -> bool {
        self.coarseness > COARSE
    }
}

/// Densities of all outputs, which `responses` gets, and what they amount to.
///
/// # Errors
/// [`Error::Description`] for an input that isn't one of the analysis.
pub(super) fn random(
    responses: &mut FrequencyResponses,
    asked: &FrequencyResponse,
) -> Result<Vec<RandomOutput>, Error> {
    if asked.random.is_empty() {
        return Ok(Vec::new());
    }
    // An input may have been asked for by another name: NAME/INDEX of a load with one component.
    let is_one_to_one = asked.inputs.len() == responses.inputs.len();
    let count = responses.frequency.len();
    let mut total = vec![0.0; count * responses.outputs.len()];
    for (name, table) in &asked.random {
        let by_own_name = responses
            .inputs
            .iter()
            .position(|input| input.name == *name);
        let by_request = || {
            asked
                .inputs
                .iter()
                .position(|input| input == name)
                .filter(|_| is_one_to_one)
        };
        let Some(input) = by_own_name.or_else(by_request) else {
            let known: Vec<&str> = responses
                .inputs
                .iter()
                .map(|input| input.name.as_str())
                .collect();
            return Err(Error::described(
                format!("analysis.frequency_response.random.{name}"),
                format!(
                    "is no input of the analysis (there are: {}); a load with several components has one input for each",
                    known.join(", ")
                ),
            ));
        };
        for output in 0..responses.outputs.len() {
            for (k, [real, imaginary]) in responses.of(output, input).into_iter().enumerate() {
                let square = real * real + imaginary * imaginary;
                total[k * responses.outputs.len() + output] +=
                    square * density(table, responses.frequency[k]);
            }
        }
    }
    responses.density = total;
    let outputs = responses.outputs.iter().enumerate();
    Ok(outputs
        .map(|(output, signal)| {
            let values = responses.density_of(output).unwrap_or_default();
            let square = integral(&responses.frequency, &values, 1);
            let coarse = integral(&responses.frequency, &values, 2);
            let moments: Vec<f64> = values
                .iter()
                .zip(&responses.frequency)
                .map(|(value, f)| value * f * f)
                .collect();
            let second = integral(&responses.frequency, &moments, 1);
            RandomOutput {
                name: signal.name.clone(),
                unit: signal.unit.clone(),
                rms: square.sqrt(),
                zero_crossings: if square > 0.0 {
                    (second / square).sqrt()
                } else {
                    0.0
                },
                coarseness: if square > 0.0 {
                    (coarse.sqrt() / square.sqrt() - 1.0).abs()
                } else {
                    0.0
                },
            }
        })
        .collect())
}

/// Between the points of a table, zero beyond its ends.
fn density(table: &[[f64; 2]], frequency: f64) -> f64 {
    let next = table.partition_point(|[at, _]| *at <= frequency);
    match (
        next.checked_sub(1).and_then(|last| table.get(last)),
        table.get(next),
    ) {
        (Some([from, low]), Some([to, high])) => {
            low + (high - low) * (frequency - from) / (to - from)
        }
        (Some([from, low]), None) if *from == frequency => *low,
        _ => 0.0,
    }
}

/// By trapezoids over every `stride`th point, and the last.
fn integral(places: &[f64], values: &[f64], stride: usize) -> f64 {
    let mut picked: Vec<usize> = (0..places.len()).step_by(stride).collect();
    if picked.last() != Some(&(places.len() - 1)) {
        picked.push(places.len() - 1);
    }
    picked
        .windows(2)
        .map(|pair| 0.5 * (values[pair[0]] + values[pair[1]]) * (places[pair[1]] - places[pair[0]]))
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_is_joined_by_lines_and_zero_beyond() {
        let table = [[1.0, 2.0], [3.0, 4.0]];
        let found = [0.5, 1.0, 2.0, 3.0, 3.5].map(|f| density(&table, f));
        assert_eq!(found, [0.0, 2.0, 3.0, 4.0, 0.0]);
        assert!((integral(&[1.0, 2.0, 4.0], &[1.0, 1.0, 3.0], 1) - 5.0).abs() < 1e-15);
    }
}
