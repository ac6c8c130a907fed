//! What reaches the outputs through which connection.
//!
//! ```text
//! y = H₀ᵤ u + Σ_p H₀_p λ_p        λ_p = G_p u
//! ```
//! λ_p are the forces of the connection p in the mechanism, G_p their responses to the inputs. H₀ are responses of the mechanism without the connections, to the inputs
//! and to forces along them. H₀_p G_p is what comes through p, H₀ᵤ what comes past all of them.

use std::collections::BTreeMap;

use dcb_formats::results::{FrequencyResponses, Signal};
use dcb_formats::scene::{FrequencyResponse, ResponseDamping, Scene};
use faer::{Mat, c64};

use super::Peak;
use crate::error::Error;
use crate::linear::{Coordinates, LinearRequest, Linearized, Path, Wanted, cut, linearized, paths};
use crate::model::Recorder;
use crate::system::{State, System};

/// Where paths are asked for.
const LOCATION: &str = "analysis.frequency_response.paths";
/// Sums of all paths that are off by more, as a part of the largest response, are told.
const CLOSED: f64 = 1e-6;

/// The connections through which outputs are reached.
pub(super) struct Paths {
    list: Vec<Path>,
}

impl Paths {
    /// Those that are asked for.
    ///
    /// # Errors
    /// [`Error::Description`] for a name that there isn't, and for damping that belongs to no part.
    pub fn of(system: &System, asked: &FrequencyResponse) -> Result<Self, Error> {
        if let (Some(ResponseDamping::AssembledModal(_)), false) =
            (&asked.damping, asked.paths.is_empty())
        {
            return Err(Error::described(
                LOCATION,
                "can't be told with `assembled_modal`, which is the damping of no part; take another damping",
            ));
        }
        let list = paths(system, &asked.paths, LOCATION)?;
        Ok(Self { list })
    }

    /// Their rows, path by path.
    pub fn rows(&self) -> Vec<usize> {
        let rows = self.list.iter().flat_map(|path| path.rows.clone());
        rows.collect()
    }

    /// The mechanism without the paths, to forces along them too; `None` without paths. `linear` has the forces of the paths as its last outputs.
    pub fn without(
        &self,
        scene: &Scene,
        (system, state): (&System, &State),
        recorder: &mut Recorder,
        request: &LinearRequest,
        linear: &Linearized,
    ) -> Result<Option<Linearized>, Error> {
        let rows = self.rows();
        if rows.is_empty() {
            return Ok(None);
        }
        let without = cut(system, &rows, &linear.forces)?;
        let mut wanted = Wanted::of(Coordinates::Orthonormal);
        wanted.efforts = rows;
        linearized(scene, &without, state, recorder, request, &wanted).map(Some)
    }

    /// The outputs, then for each of them what comes through each path and past all of them, from the responses of both mechanisms, by the inputs.
    pub fn split(
        &self,
        whole: &Mat<c64>,
        without: &Mat<c64>,
        [outputs, inputs]: [usize; 2],
    ) -> Mat<c64> {
        let each = self.list.len() + 1;
        let mut all = Mat::zeros(outputs * (1 + each), inputs);
        for i in 0..outputs {
            for j in 0..inputs {
                all[(i, j)] = whole[(i, j)];
                let mut first = 0;
                for (p, path) in self.list.iter().enumerate() {
                    let own = first..first + path.rows.len();
                    let through = own
                        .clone()
                        .map(|r| without[(i, inputs + r)] * whole[(outputs + r, j)]);
                    all[(outputs + i * each + p, j)] =
                        through.fold(c64::new(0.0, 0.0), |sum, one| sum + one);
                    first = own.end;
                }
                all[(outputs + i * each + each - 1, j)] = without[(i, j)];
            }
        }
        all
    }

    /// Names of the rows that [`Paths::split`] adds.
    pub fn signals(&self, outputs: &[Signal]) -> Vec<Signal> {
        let names = || {
            let through = self.list.iter().map(|path| format!("via {}", path.name));
            through.chain(["past the paths".to_owned()])
        };
        let each = outputs.iter().flat_map(|output| {
            names().map(|name| Signal {
                name: format!("{} {name}", output.name),
                unit: output.unit.clone(),
            })
        });
        each.filter(|_| !self.list.is_empty()).collect()
    }

    /// Adds to each peak which part of the response comes through each path, and past all of them.
    pub fn share(&self, responses: &FrequencyResponses, outputs: usize, peaks: &mut [Peak]) {
        let each = self.list.len() + 1;
        for peak in peaks.iter_mut().filter(|_| each > 1) {
            let named = |of: &[Signal], name: &str| of.iter().position(|one| one.name == name);
            let place = (
                named(&responses.outputs, &peak.output),
                named(&responses.inputs, &peak.input),
            );
            let k = (responses.frequency.iter()).position(|frequency| *frequency == peak.frequency);
            let ((Some(i), Some(j)), Some(k)) = (place, k) else {
                continue;
            };
            let value = |output: usize| {
                let place = (k * responses.outputs.len() + output) * responses.inputs.len() + j;
                c64::new(responses.real[place], responses.imaginary[place])
            };
            let whole = value(i);
            let names = (self.list.iter().map(|path| path.name.clone()))
                .chain(["past the paths".to_owned()]);
            peak.paths = names
                .enumerate()
                .map(|(p, name)| {
                    let part = value(outputs + i * each + p) / whole;
                    (name, part.re)
                })
                .collect();
        }
    }

    /// What a user should know if the parts of some outputs don't add up to them.
    pub fn gap(&self, responses: &FrequencyResponses, outputs: usize) -> Option<String> {
        let each = self.list.len() + 1;
        if each == 1 {
            return None;
        }
        let columns = responses.inputs.len();
        let mut gap: f64 = 0.0;
        for k in 0..responses.frequency.len() {
            for j in 0..columns {
                let value = |output: usize| {
                    let place = (k * responses.outputs.len() + output) * columns + j;
                    c64::new(responses.real[place], responses.imaginary[place])
                };
                let parts = |i: usize| (0..each).map(move |p| outputs + i * each + p);
                // What doesn't move is rounding of what moves in the same unit.
                let mut sizes: BTreeMap<&str, f64> = BTreeMap::new();
                for (i, output) in responses.outputs[..outputs].iter().enumerate() {
                    let size = sizes.entry(&output.unit).or_default();
                    for part in parts(i) {
                        *size = size.max(value(part).norm());
                    }
                }
                for (i, output) in responses.outputs[..outputs].iter().enumerate() {
                    let sum = parts(i).fold(c64::new(0.0, 0.0), |sum, part| sum + value(part));
                    let size = sizes[output.unit.as_str()];
                    if size > 0.0 {
                        gap = gap.max((sum - value(i)).norm() / size);
                    }
                }
            }
        }
        (gap > CLOSED).then(|| {
            format!(
                "the parts by path add up to the responses with differences up to {gap:.1e} of their own size: they cancel, or the mechanism without the paths is near a resonance"
            )
        })
    }
}
