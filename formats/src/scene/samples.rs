//! Times at which servos and controllers are computed, against the steps of a run and the analysis.

use super::{Actuator, Analysis, Integrator, Scene};
use crate::Error;

/// Difference of a ratio from a whole number that is rounding of written numbers.
const ROUNDING: f64 = 1e-9;

impl Scene {
    /// Samples fall on the ends of equal steps, and an analysis without time has neither samples nor integrals.
    pub(super) fn check_samples(&self) -> Result<(), Error> {
        let of_actuators = self.actuators.iter().filter_map(|(name, actuator)| {
            let key = format!("actuators.{name}.{}.sample", actuator.kind());
            Some((key, actuator.sample()?))
        });
        let of_controllers = self.controllers.iter();
        let of_controllers = of_controllers.filter_map(|(name, controller)| {
            Some((format!("controllers.{name}.period"), controller.period?))
        });
        for (key, period) in of_actuators.chain(of_controllers) {
            self.check_sample(&key, period)?;
        }
        let moves = matches!(self.analysis, Analysis::Transient | Analysis::Kinematic);
        for (name, actuator) in &self.actuators {
            if let Actuator::Servo(servo) = actuator
                && servo.integral > 0.0
                && !moves
            {
                return Err(Error::described(
                    format!("actuators.{name}.servo.integral"),
                    "has no meaning without a motion over time; leave it out of this analysis",
                ));
            }
        }
        Ok(())
    }

    fn check_sample(&self, key: &str, period: f64) -> Result<(), Error> {
        if self.analysis != Analysis::Transient {
            return Err(Error::described(
                key,
                "has a meaning in a transient analysis only; leave it out: what is continuous has a linearization",
            ));
        }
        let Some(integrator) = self.integrator.filter(Integrator::has_equal_steps) else {
            return Ok(());
        };
        let whole = |ratio: f64| ratio > 0.5 && (ratio - ratio.round()).abs() <= ROUNDING * ratio;
        let (step, end) = (integrator.step, integrator.end);
        if !whole(period / step) {
            let steps = (period / step).ceil().max(1.0);
            return Err(Error::described(
                key,
                format!(
                    "is {period}, no multiple of the step of {step}; take for example a step of {:?}, adaptive steps, or radau",
                    period / steps
                ),
            ));
        }
        if !whole(end / step) {
            return Err(Error::described(
                "integrator.end",
                format!(
                    "is {end}, no multiple of the step of {step}, on which the samples of {key} fall"
                ),
            ));
        }
        Ok(())
    }
}
