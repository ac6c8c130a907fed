//! The run that the others are compared with, and how well converged it is.
//!
//! All modes of the files, strong compatibility, all of the inertia, the scene's own method, and a step that is halved, or an accuracy that is quartered, until
//! two successive runs agree. With d the distance of the last two runs and d' that of the two before, the order that is seen is
//! log₂ (d'/d); where it is the method's, two, the last run errs by d/3 (Richardson), and where it isn't, d is what is known.

use serde::{Deserialize, Serialize};

use super::comparison::{Distance, places, scale};
use super::fineness::Fineness;
use super::grid::{Grid, Trace};
use super::monitor::Monitor;
use super::motion::{Course, follow_to_the_end, steps_of};
use super::setting::{ModeCount, Setting};
use super::subject::Subject;
use dcb_formats::scene::{Compatibility, InertiaChange};
use dcb_runtime::error::Error;

/// Two runs agree if the last errs by less than this part of each quantity's range.
pub const AGREEMENT: f64 = 1e-5;
/// Runs, at most: steps of 1/2, 1/4 and 1/8 of the finest row's. At second order the last errs by 1/64 of what that row does, and three
/// runs show the order.
const MOST_RUNS: usize = 3;
/// The order from which on the method's is believed.
const BELIEVED_ORDER: f64 = 1.5;
/// One in `2² − 1`: the error of the finer of two runs of second order, by their distance.
const RICHARDSON: f64 = 1.0 / 3.0;

/// The run that the others are compared with.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SceneReference {
    /// Its options.
    pub setting: Setting,
    /// Steps, or accuracies, of the runs that were made, the last of which is the reference.
    pub steps: Vec<f64>,
    /// How it went.
    pub course: Course,
    /// Quantity by quantity, in the order of the subject's.
    pub convergence: Vec<Convergence>,
}

/// How well converged a quantity of the reference is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Convergence {
    /// Reference size of errors; `None` for a quantity that is zero throughout.
    pub scale: Option<f64>,
    /// Estimated error.
    pub uncertainty: Distance,
    /// The order that is seen; `None` if there were two runs only, or no difference.
    pub order: Option<f64>,
}

impl Convergence {
    /// The largest estimated error, relative; zero for a quantity that is zero.
    pub fn relative(&self) -> f64 {
        self.scale
            .map_or(0.0, |scale| self.uncertainty.maximum / scale)
    }
}

impl SceneReference {
    /// The largest estimated error of a quantity, relative to its range.
    pub fn uncertainty(&self) -> f64 {
        let each = self.convergence.iter().map(Convergence::relative);
        each.fold(0.0, f64::max)
    }

    /// Whether the last two runs agree.
    pub fn is_converged(&self) -> bool {
        self.uncertainty() <= AGREEMENT
    }

    /// The options of the first run, for rows of which this is the shortest step or the finest accuracy.
    pub fn first_setting(subject: &Subject, finest: Fineness) -> Setting {
        let own = subject.own;
        Setting {
            modes: match subject.most_modes() {
                None => own.modes,
                Some(_) => ModeCount::All,
            },
            compatibility: Compatibility::Strong,
            fineness: finest.finer(),
            rho_infinity: own.rho_infinity,
            inertia_change: subject.most_modes().map(|_| InertiaChange::SecondOrder),
        }
    }

    /// Makes it, starting with `first`; `None` if the user stopped it. Later runs that can't be made, or are further from the run before than that is from
    /// its own, end the halving.
    ///
    /// # Errors
    /// The error that stopped one of the first two runs; [`Error::Description`] if there is nothing but zeros to compare.
    pub fn find(
        subject: &Subject,
        first: Setting,
        grid: Grid,
        monitor: &Monitor,
    ) -> Result<Option<(Self, Trace)>, Error> {
        let columns = places(&subject.quantities);
        let mut found: Option<(Self, Trace)> = None;
        let mut setting = first;
        for run in 0..MOST_RUNS {
            let scene = match setting.applied_to(subject) {
                Ok(scene) => scene,
                // An accuracy below all that can be asked for.
                Err(_) if run > 1 => break,
                Err(error) => return Err(error),
            };
            monitor.expect(steps_of(&scene)?);
            let (course, trace) =
                match follow_to_the_end(subject, &scene.into(), grid, monitor, &mut |_| {}) {
                    Ok(Some(followed)) => followed,
                    Ok(None) => return Ok(None),
                    Err(_) if run > 1 => break,
                    Err(error) => return Err(error),
                };
            let mut steps = Vec::new();
            let mut convergence = Vec::new();
            if let Some((coarser, coarser_trace)) = &found {
                steps.clone_from(&coarser.steps);
                for (index, columns) in columns.iter().enumerate() {
                    let distance = Distance::between(&trace, coarser_trace, columns.clone());
                    let before = coarser.convergence.get(index);
                    let scale = scale(&trace, columns.clone());
                    convergence.push(Convergence::estimated(scale, distance, before));
                }
                if convergence.iter().all(|quantity| quantity.scale.is_none()) {
                    return Err(Error::described(
                        "outputs",
                        "are zero throughout the reference; name others with --outputs",
                    ));
                }
            }
            steps.push(setting.fineness.value());
            let finer = Self {
                setting,
                steps,
                course,
                convergence,
            };
            // Of very short steps the forces are rounding, and the run before is the better one.
            let before = found.as_ref().map(|(coarser, _)| coarser.uncertainty());
            if run > 1 && before.is_some_and(|before| finer.uncertainty() > before) {
                break;
            }
            let is_enough = run > 0 && finer.is_converged();
            found = Some((finer, trace));
            if is_enough {
                break;
            }
            setting.fineness = setting.fineness.finer();
        }
        Ok(found)
    }
}

impl Convergence {
    /// From the distance of the last two runs, and what was known before them.
    fn estimated(scale: Option<f64>, distance: Distance, before: Option<&Self>) -> Self {
        // What was known before is the distance itself, times a third where its order was believed.
        let earlier = before.map(|before| match before.is_believed() {
            true => before.uncertainty.maximum / RICHARDSON,
            false => before.uncertainty.maximum,
        });
        let order = earlier
            .filter(|earlier| *earlier > 0.0 && distance.maximum > 0.0)
            .map(|earlier| (earlier / distance.maximum).log2());
        let estimate = Self {
            scale,
            uncertainty: distance,
            order,
        };
        match estimate.is_believed() {
            true => Self {
                uncertainty: distance.scaled(RICHARDSON),
                ..estimate
            },
            false => estimate,
        }
    }

    fn is_believed(&self) -> bool {
        self.order.is_some_and(|order| order >= BELIEVED_ORDER)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn distance(maximum: f64) -> Distance {
        Distance {
            maximum,
            rms: 0.5 * maximum,
        }
    }

    /// Errors c hᵖ at h, h/2, h/4, h/8: the estimate is that of the last run where p = 2, and above it where p = 1.
    #[test]
    fn an_estimate_is_the_error_at_second_order_and_more_below() {
        for order in [1, 2] {
            let error = |level: i32| 0.5_f64.powi(order * level);
            let mut known: Option<Convergence> = None;
            for level in 1..=3 {
                let apart = distance(error(level - 1) - error(level));
                let estimate = Convergence::estimated(Some(2.0), apart, known.as_ref());
                let ratio = estimate.uncertainty.maximum / error(level);
                let expected = match (order, level) {
                    (1, _) => 1.0,
                    (_, 1) => 3.0,
                    _ => 1.0,
                };
                assert!((ratio - expected).abs() < 1e-12, "{order} {level}: {ratio}");
                match estimate.order {
                    None => assert_eq!(level, 1),
                    Some(seen) => assert!((seen - f64::from(order)).abs() < 1e-12),
                }
                assert_eq!(estimate.relative(), 0.5 * estimate.uncertainty.maximum);
                known = Some(estimate);
            }
        }
    }
}
