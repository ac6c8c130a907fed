//! Random responses: densities of outputs under inputs that are random and stationary.
//!
//! ```text
//! S_y(f) = Σ_j Σ_k H_yj S_jk H_yk*        rms² = ∫ S_y df        zero crossings upwards = (∫ f² S_y df / ∫ S_y df)^½
//! ```
//! S_jk is the cross density of input j and the complex conjugate of input k: S_j for j = k, zero for inputs that are independent of each other, and
//! (γ² S_j S_k)^½ exp(2πi f τ) for the coherence γ² with k later than j by τ. With errors e_yj of the responses the rms is off by (∫ (Σ_j e_yj S_j^½)² df)^½ at most, however the
//! inputs belong together. No motion has a negative density if the Hermitian S has no negative eigenvalue.

use dcb_formats::results::FrequencyResponses;
use dcb_formats::scene::{Correlation, FrequencyResponse};
use faer::{Mat, Side, c64};

use super::excitation::{amplitude, density, input_place};
use crate::error::Error;

/// Differences of an integral to that over every other frequency above this are told.
const COARSE: f64 = 0.01;
/// Negative eigenvalues of densities above this part of their sum are rounding.
const ROUNDING: f64 = 1e-9;

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
    /// Estimate of the relative error of the rms by what the superelements' files leave out; `None` where they don't tell.
    pub error: Option<f64>,
}

impl RandomOutput {
    /// Whether the frequencies are too far apart for the integral.
    pub fn is_coarse(&self) -> bool {
        self.coarseness > COARSE
    }
}

/// The random inputs, and pairs of them that belong together.
struct RandomInputs<'a> {
    /// Places among the inputs of the responses, with their densities.
    inputs: Vec<(usize, &'a [[f64; 2]])>,
    /// Places among the random inputs.
    pairs: Vec<([usize; 2], &'a Correlation)>,
}

impl<'a> RandomInputs<'a> {
    fn of(responses: &FrequencyResponses, asked: &'a FrequencyResponse) -> Result<Self, Error> {
        let mut inputs = Vec::with_capacity(asked.random.len());
        for (name, table) in &asked.random {
            let at = || format!("analysis.frequency_response.random.{name}");
            let place = input_place(responses, asked, name, at)?;
            inputs.push((place, table.as_slice()));
        }
        let mut pairs: Vec<([usize; 2], &Correlation)> = Vec::new();
        for (index, correlation) in asked.correlated.iter().enumerate() {
            let at = || format!("analysis.frequency_response.correlated[{index}].inputs");
            let place = |name: &String| -> Result<usize, Error> {
                let of_input = input_place(responses, asked, name, at)?;
                let mut own = inputs.iter();
                own.position(|(input, _)| *input == of_input)
                    .ok_or_else(|| {
                        Error::described(at(), format!("{name:?} has no density in `random`"))
                    })
            };
            let [a, b] = &correlation.inputs;
            let pair = [place(a)?, place(b)?];
            let same = |known: &[usize; 2]| *known == pair || *known == [pair[1], pair[0]];
            if pairs.iter().any(|(known, _)| same(known)) {
                return Err(Error::described(
                    at(),
                    format!("the pair {a:?} and {b:?} stands twice"),
                ));
            }
            pairs.push((pair, correlation));
        }
        Ok(Self { inputs, pairs })
    }

    /// S at a frequency.
    fn densities(&self, frequency: f64) -> Result<Mat<c64>, Error> {
        let own = |place: usize| density(self.inputs[place].1, frequency);
        let mut all = Mat::from_fn(self.inputs.len(), self.inputs.len(), |i, j| {
            c64::new(if i == j { own(i) } else { 0.0 }, 0.0)
        });
        for ([a, b], correlation) in &self.pairs {
            let both = match (&correlation.density, correlation.coherence) {
                (Some(table), _) => amplitude(table, frequency),
                (None, coherence) => {
                    let size = (coherence.unwrap_or(0.0) * own(*a) * own(*b)).sqrt();
                    let later = correlation.delay.unwrap_or(0.0);
                    c64::from_polar(size, std::f64::consts::TAU * frequency * later)
                }
            };
            all[(*a, *b)] = both;
            all[(*b, *a)] = both.conj();
        }
        if self.pairs.is_empty() {
            return Ok(all);
        }
        let sum: f64 = (0..all.nrows()).map(own).sum();
        let values = all
            .self_adjoint_eigenvalues(Side::Lower)
            .map_err(|_| Error::NoEigenvalues)?;
        let least = values.iter().copied().fold(f64::INFINITY, f64::min);
        if least < -ROUNDING * sum {
            return Err(Error::described(
                "analysis.frequency_response.correlated",
                format!(
                    "isn't possible at the frequency {frequency}: some combination of the inputs has the negative density {least:.3e}; the size of a cross density is at most the root of the product of both densities, and further pairs bind it more"
                ),
            ));
        }
        Ok(all)
    }
}

/// Densities of all outputs, which `responses` gets, and what they amount to.
///
/// # Errors
/// [`Error::Description`] for an input that isn't one of the analysis, and for correlations that no random inputs have.
pub(super) fn random(
    responses: &mut FrequencyResponses,
    asked: &FrequencyResponse,
) -> Result<Vec<RandomOutput>, Error> {
    let inputs = RandomInputs::of(responses, asked)?;
    if inputs.inputs.is_empty() {
        return Ok(Vec::new());
    }
    let (rows, columns) = (responses.outputs.len(), responses.inputs.len());
    let mut total = Vec::with_capacity(responses.frequency.len() * rows);
    let mut errors = Vec::with_capacity(responses.error.len() / columns.max(1));
    for (k, frequency) in responses.frequency.iter().enumerate() {
        let densities = inputs.densities(*frequency)?;
        for output in 0..rows {
            let by = |input: usize| {
                let place = (k * rows + output) * columns + inputs.inputs[input].0;
                c64::new(responses.real[place], responses.imaginary[place])
            };
            let count = inputs.inputs.len();
            let terms = (0..count).flat_map(|i| (0..count).map(move |j| (i, j)));
            let sum: f64 = terms
                .map(|(i, j)| (by(i) * densities[(i, j)] * by(j).conj()).re)
                .sum();
            // Inputs that cancel leave rounding.
            total.push(sum.max(0.0));
            let first = (k * rows + output) * columns;
            if let Some(own) = responses.error.get(first..first + columns) {
                let present = (0..count).filter(|i| densities[(*i, *i)].re > 0.0);
                let terms = present.map(|i| own[inputs.inputs[i].0] * densities[(i, i)].re.sqrt());
                errors.push(terms.sum::<f64>().powi(2));
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
            let own = errors.iter().skip(output).step_by(rows.max(1));
            let own: Vec<f64> = own.copied().collect();
            let off = (!own.is_empty())
                .then(|| (integral(&responses.frequency, &own, 1) / square).sqrt());
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
                error: off.filter(|off| off.is_finite()),
            }
        })
        .collect())
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
    fn trapezoids_take_unequal_steps() {
        assert!((integral(&[1.0, 2.0, 4.0], &[1.0, 1.0, 3.0], 1) - 5.0).abs() < 1e-15);
    }
}
