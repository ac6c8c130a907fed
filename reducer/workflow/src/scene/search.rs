//! Enough modes for a scene: more and more, until certified bounds of what is left out of the component are small beside the tolerance.

use dcb_formats::scene::Compatibility;
use dcb_formats::units::written_frequency;
use std::f64::consts::TAU;

use dcb_demand::LeftOut;
use dcb_formats::superelement::Superelement;
use dcb_superelement::LOSS_FACTOR;

use super::cached::CachedReductions;
use super::component_demand::{ComponentDemand, WATCHED};
use super::in_plane::in_plane;
use super::spin::SpinColumns;
use dcb_reducer::EnrichmentSource;
use dcb_reducer::ModeSelection;
use dcb_reducer::Reduced;
use dcb_reducer::Reduction;
use dcb_reducer::error::{Error, ErrorFound, LimitedBy, Shortfall};
use dcb_reducer::observer::Observer;
use dcb_reducer::quality::scene_fit::Round;
use dcb_reducer::reduce;
use dcb_superelement::FrequencyBand;
use dcb_superelement::error_bounds::ErrorBounds;
use dcb_superelement::error_bounds::POINTS;

/// The first search takes the modes up to this factor of the scene's highest frequency.
const BEYOND: f64 = 1.5;
/// Error of a part with Krylov columns and modes up to [`BEYOND`]: 1.3e-3 and 2.6e-3 were seen for a connecting rod in two scenes.
const KRYLOV_ERROR: f64 = 2e-3;
/// The power of the first ω² left out with which it falls: 2.4 to 3.5 were seen. A guess that is a little too low costs a whole reduction more.
const KRYLOV_ORDER: f64 = 2.4;
/// Each further one takes this many times as many.
const GROWTH: f64 = 1.5;
/// And at least this many more.
const LEAST_GROWTH: usize = 4;
/// Part of the tolerance that a bound may use: the rest is for what is left out of the superelement.
const SHARE: f64 = 0.5;
/// More modes that don't bring the bound below this part of what it was show that rounding makes it.
const PROGRESS: f64 = 0.95;
/// Of the first elastic frequency: where a scene has no frequencies, or slower ones, this counts as none.
const QUASISTATIC: f64 = 0.01;

/// Whether what a scene doesn't ask for is left out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Extent {
    /// It is.
    #[default]
    Needed,
    /// It stays: the superelement has enough for the scene, and more. The second Krylov block of the interfaces makes it exact with few modes.
    Everything,
}

/// Limits of a search.
#[derive(Clone, Debug)]
pub struct Limits {
    /// Largest relative error of the part's responses.
    pub tolerance: f64,
    /// Modes at most, if that is said.
    pub most_modes: Option<usize>,
    /// Modes where the scene doesn't say how fast it is.
    pub default_modes: usize,
    /// Whether anything is left out in the end.
    pub extent: Extent,
}

/// The superelement that is good enough before anything is left out of it.
#[derive(Clone, Debug)]
pub struct UnprunedReduction {
    /// The reduction.
    pub reduced: Reduced,
    /// Every reduction with its error; empty where there is nothing to certify.
    pub rounds: Vec<Round>,
    /// ω² of comparison; empty where the scene has no band.
    pub squares: Vec<f64>,
    /// Why there are columns for centrifugal forces, or none.
    pub spin: String,
    /// Motions of a spatial component out of the plane of a planar scene.
    pub out_of_plane: Option<LeftOut>,
}

impl UnprunedReduction {
    /// Upper bound of its error; `None` where there is none.
    pub fn certified(&self) -> Option<f64> {
        self.rounds.last().and_then(|round| round.upper)
    }
}

/// Columns for centrifugal forces, before a reduction.
enum SpinQuestion {
    /// Whether there are any is known, and why.
    Answered(String),
    /// The reduction has them, so that what is lost without them can be told; where that is little, they go.
    Open,
}

/// One reduction in the scene's dimension.
struct Computed {
    reduced: Reduced,
    /// Modes of the component, those that lead out of the plane too.
    modes: usize,
    out_of_plane: Option<LeftOut>,
}

/// Reduces a component for what is asked of it.
pub struct Search<'a> {
    /// Demand, with the component.
    pub asked: &'a ComponentDemand,
    /// Options but for the modes; enrichment is what the user wants besides.
    pub options: &'a Reduction,
    /// Limits.
    pub limits: &'a Limits,
    /// Where reductions are kept, if anywhere.
    pub cached: Option<&'a CachedReductions<'a>>,
}

impl Search<'_> {
    /// Finds the modes, and decides on centrifugal columns.
    ///
    /// # Errors
    /// Those of [`reduce`]; [`Error::Shortfall`] if the tolerance isn't reached, or the reduction isn't good by itself.
    pub fn whole(&self, observer: &mut dyn Observer) -> Result<UnprunedReduction, Error> {
        let mut sources = self.options.enrichment.clone();
        let loads = EnrichmentSource::Loads;
        let are_loads_asked = !self.asked.demand.part_loads.is_empty();
        if are_loads_asked && !self.asked.is_seen_in_plane() && !sources.contains(&loads) {
            sources.push(loads);
        }
        let krylov = EnrichmentSource::Krylov;
        if self.makes_a_reference() && !sources.contains(&krylov) {
            sources.push(krylov);
        }
        let spin = self.spin();
        if matches!(spin, SpinQuestion::Open) {
            sources.push(EnrichmentSource::Spin);
        }
        self.enough_modes(&sources, &spin, observer)
    }

    /// Whether the scene needs columns for centrifugal forces, as far as that is known without them.
    fn spin(&self) -> SpinQuestion {
        if self.asked.is_seen_in_plane() {
            return SpinQuestion::Answered(
                "no columns for centrifugal forces or loads: the part is taken through its plane of symmetry".to_owned(),
            );
        }
        if self.options.enrichment.contains(&EnrichmentSource::Spin) {
            return SpinQuestion::Answered(
                "columns for centrifugal forces were asked for".to_owned(),
            );
        }
        SpinColumns::unneeded(self.asked).map_or(SpinQuestion::Open, SpinQuestion::Answered)
    }

    /// Whether the superelement shall be exact rather than small, and its form has further columns as coordinates.
    fn makes_a_reference(&self) -> bool {
        self.limits.extent == Extent::Everything
            && self.asked.compatibility == Compatibility::Strong
            && self.asked.demand.band.frequency.is_some()
            && !self.asked.is_seen_in_plane()
            && !self.asked.is_rigid()
    }

    fn enough_modes(
        &self,
        sources: &[EnrichmentSource],
        spin: &SpinQuestion,
        observer: &mut dyn Observer,
    ) -> Result<UnprunedReduction, Error> {
        let mut selection = self.first_modes();
        let mut rounds: Vec<Round> = Vec::new();
        loop {
            let Computed {
                reduced,
                modes,
                out_of_plane,
            } = self.reduced(selection, sources, observer)?;
            let (reduced, spin) = match spin {
                SpinQuestion::Answered(why) => (reduced, why.clone()),
                SpinQuestion::Open => {
                    let columns = SpinColumns::of(self.asked, &reduced, self.limits.tolerance)?;
                    (columns.kept_if_needed(reduced)?, columns.why())
                }
            };
            let element = &reduced.superelement;
            let squares = self.squares(element);
            let found = self.round(&reduced, &squares)?;
            let good_enough = found.is_none_or(|round| {
                round
                    .upper
                    .is_some_and(|upper| upper <= SHARE * self.limits.tolerance)
            });
            let before = rounds.last().and_then(|round: &Round| round.upper);
            rounds.extend(found);
            if good_enough {
                return Ok(UnprunedReduction {
                    reduced,
                    rounds,
                    squares,
                    spin,
                    out_of_plane,
                });
            }
            let stands_still = (before.zip(found.and_then(|round| round.upper)))
                .is_some_and(|(before, upper)| upper > PROGRESS * before);
            let next = ((GROWTH * modes as f64).ceil() as usize).max(modes + LEAST_GROWTH);
            let next = self.limits.most_modes.map_or(next, |most| next.min(most));
            let has_more = element.modes.first_omitted_eigenvalue.is_finite() && next > modes;
            if stands_still || !has_more {
                return Err(self.not_reached(&rounds, stands_still));
            }
            selection = ModeSelection::Lowest(next);
        }
    }

    fn first_modes(&self) -> ModeSelection {
        let Limits {
            most_modes,
            default_modes,
            ..
        } = *self.limits;
        if self.asked.is_rigid() {
            return ModeSelection::Lowest(0);
        }
        match (self.asked.demand.band.frequency, most_modes) {
            (None, most) => ModeSelection::Lowest(most.unwrap_or(default_modes)),
            (Some(frequency), most) => {
                let beyond = match self.makes_a_reference() {
                    true => self.beyond_with_krylov_columns(),
                    false => BEYOND,
                };
                let eigenvalue = (TAU * beyond * frequency).powi(2);
                match most {
                    _ if frequency <= 0.0 => ModeSelection::Lowest(0),
                    Some(count) => ModeSelection::BelowAtMost { eigenvalue, count },
                    None => ModeSelection::Below { eigenvalue },
                }
            }
        }
    }

    /// How far beyond the scene's highest frequency the modes go so that Krylov columns make the error small enough: it falls at least with this
    /// power of the first ω² left out.
    fn beyond_with_krylov_columns(&self) -> f64 {
        let smaller = KRYLOV_ERROR / (SHARE * self.limits.tolerance);
        BEYOND * smaller.powf(0.5 / KRYLOV_ORDER).max(1.0)
    }

    fn reduced(
        &self,
        modes: ModeSelection,
        sources: &[EnrichmentSource],
        observer: &mut dyn Observer,
    ) -> Result<Computed, Error> {
        let options = Reduction {
            modes,
            enrichment: sources.to_vec(),
            ..self.options.clone()
        };
        let reduced = match self.cached {
            Some(cached) => cached.reduced(self.asked, &options, observer)?,
            None => reduce(&self.asked.component, &options, observer)?,
        };
        let reduced = reduced.accepted()?;
        let modes = reduced.superelement.mode_count();
        let (reduced, out_of_plane) = match self.asked.is_seen_in_plane() {
            true => {
                let (planar, left_out) = in_plane(self.asked, reduced)?;
                (planar, Some(left_out))
            }
            false => (reduced, None),
        };
        Ok(Computed {
            reduced,
            modes,
            out_of_plane,
        })
    }

    /// The scene's frequencies: equally spaced, with the resonances.
    fn squares(&self, element: &Superelement) -> Vec<f64> {
        let Some(frequency) = self
            .asked
            .demand
            .band
            .frequency
            .filter(|_| !self.asked.is_rigid())
        else {
            return Vec::new();
        };
        let modes = &element.modes;
        let elastic = modes.eigenvalues.iter().copied().find(|value| *value > 0.0);
        let first = elastic.unwrap_or(modes.first_omitted_eigenvalue);
        let slow = match first.is_finite() {
            true => QUASISTATIC.powi(2) * first,
            false => 0.0,
        };
        let end = (TAU * frequency).powi(2).max(slow);
        match end > 0.0 {
            true => FrequencyBand::new(None, end, POINTS, &modes.eigenvalues).squares,
            false => Vec::new(),
        }
    }

    /// Bounds of the error; `None` without a band, or where no force acts on the part.
    fn round(&self, reduced: &Reduced, squares: &[f64]) -> Result<Option<Round>, Error> {
        let element = &reduced.superelement;
        let asks_for = |name: &str| {
            let mut used = self.asked.demand.interfaces.iter();
            name == WATCHED || used.any(|used| used.name == name)
        };
        let rows: Vec<usize> = (0..element.rows.len())
            .filter(|row| asks_for(&element.interfaces[element.rows[*row].interface].name))
            .collect();
        let estimate = ErrorBounds::of(element, Compatibility::Strong)?
            .ok_or_else(|| Shortfall::NoEstimate(reduced.quality.missing_estimate.clone()))?;
        let attached = estimate.attached_rows();
        let Some(end) = squares
            .last()
            .filter(|_| rows.iter().any(|row| attached.contains(row)))
        else {
            return Ok(None);
        };
        let modes = element.mode_count();
        if *end >= estimate.eigenvalue_bound() {
            return Ok(Some(Round {
                modes,
                lower: 0.0,
                upper: None,
            }));
        }
        let band = FrequencyBand {
            squares: squares.to_vec(),
        };
        let errors = estimate.responses(&rows, &band, LOSS_FACTOR)?;
        let brackets = errors.map(|error| error.largest);
        let (mut lower, mut upper) = (0.0_f64, 0.0_f64);
        for bracket in brackets
            .into_iter()
            .chain([estimate.static_response(&rows)?])
        {
            lower = lower.max(bracket.lower);
            upper = upper.max(bracket.upper);
        }
        Ok(Some(Round {
            modes,
            lower,
            upper: upper.is_finite().then_some(upper),
        }))
    }

    fn not_reached(&self, rounds: &[Round], stands_still: bool) -> Error {
        let Limits {
            tolerance,
            most_modes,
            ..
        } = *self.limits;
        let demand = &self.asked.demand;
        let frequency = demand.band.frequency.unwrap_or(0.0);
        let frequency = written_frequency(frequency, &demand.time);
        let found = match rounds.last() {
            Some(Round {
                lower,
                upper: Some(upper),
                ..
            }) => ErrorFound::Between(*lower, *upper),
            Some(_) => ErrorFound::BeyondModes,
            None => ErrorFound::Unknown,
        };
        let limited_by = match (stands_still, most_modes) {
            (true, _) => LimitedBy::Rounding,
            (false, Some(most)) => LimitedBy::MostModes(most),
            (false, None) => LimitedBy::AllModes,
        };
        Shortfall::Tolerance {
            modes: rounds.last().map_or(0, |round| round.modes),
            frequency,
            found,
            wanted: SHARE * tolerance,
            limited_by,
        }
        .into()
    }
}
