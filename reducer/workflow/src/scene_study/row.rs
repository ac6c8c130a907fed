//! One row of a study: options, what they cost, and how far the motion is off.

use dcb_report::Candidate;
use serde::Serialize;

use super::comparison::{Distance, places};
use super::grid::Trace;
use super::motion::{Course, Timing};
use super::reference::SceneReference;
use super::setting::Setting;
use super::subject::Subject;

/// One row.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SceneRow {
    /// Its options.
    pub setting: Setting,
    /// How the run went.
    pub course: Course,
    /// Effort; `None` for a run that didn't come to its end.
    pub timing: Option<Timing>,
    /// Quantity by quantity; empty for a run that didn't come to its end.
    pub deviations: Vec<OutputDeviation>,
}

/// How far one quantity of a row is from the reference.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct OutputDeviation {
    /// In the quantity's unit.
    pub distance: Distance,
    /// Relative to the quantity's range in the reference; `None` where that is zero.
    pub relative: Option<Distance>,
    /// Whether it is no larger than what the reference itself may be off.
    pub is_below_reference: bool,
}

impl SceneRow {
    /// Compares a run with the reference.
    pub fn of(
        subject: &Subject,
        setting: Setting,
        (course, trace): (Course, &Trace),
        timing: Option<Timing>,
        (reference, reference_trace): (&SceneReference, &Trace),
    ) -> Self {
        let columns = places(&subject.quantities);
        let deviation = |(index, columns): (usize, &std::ops::Range<usize>)| {
            let known = &reference.convergence[index];
            let distance = Distance::between(trace, reference_trace, columns.clone());
            OutputDeviation {
                distance,
                relative: known.scale.map(|scale| distance.scaled(1.0 / scale)),
                is_below_reference: distance.maximum <= known.uncertainty.maximum,
            }
        };
        let deviations = match course.stopped {
            None => columns.iter().enumerate().map(deviation).collect(),
            Some(_) => Vec::new(),
        };
        Self {
            setting,
            course,
            timing,
            deviations,
        }
    }

    /// Whether the run came to its end. Its values are finite then: steps that aren't are refused.
    pub fn is_stable(&self) -> bool {
        self.course.stopped.is_none()
    }

    /// Wall time for a unit of simulated time, s.
    pub fn cost(&self, end: f64) -> Option<f64> {
        self.timing.map(|timing| timing.seconds / end)
    }

    /// Steps in a second.
    pub fn speed(&self) -> Option<f64> {
        self.timing
            .map(|timing| timing.steps as f64 / timing.seconds)
    }

    /// The largest relative error of all quantities, as it was measured; infinite for a run that didn't come to its end.
    pub fn error(&self) -> f64 {
        if !self.is_stable() {
            return f64::INFINITY;
        }
        let relative = self
            .deviations
            .iter()
            .filter_map(|deviation| deviation.relative);
        relative.fold(0.0, |most, relative| most.max(relative.maximum))
    }

    /// The same, but no smaller than what the reference itself may be off: what can be claimed.
    pub fn claim(&self, reference: &SceneReference) -> ErrorStatement {
        let (error, limit) = (self.error(), reference.uncertainty());
        match error > limit {
            true => ErrorStatement::Measured(error),
            false => ErrorStatement::AtMost(limit),
        }
    }

    /// The step or accuracy as a multiple of the scene's: `4 h`, `h/2`, `e/10`.
    pub fn multiple(&self, subject: &Subject) -> String {
        self.setting.fineness.multiple_of(subject.own.fineness)
    }

    /// As a candidate of the Pareto front under a label.
    pub fn candidate(
        &self,
        label: String,
        subject: &Subject,
        reference: &SceneReference,
    ) -> Candidate {
        Candidate {
            label,
            cost: self.cost(subject.end).unwrap_or(f64::INFINITY),
            error: self.claim(reference).value(),
        }
    }
}

/// An error that can be claimed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ErrorStatement {
    /// This.
    Measured(f64),
    /// No more than this: the reference isn't known better.
    AtMost(f64),
}

impl ErrorStatement {
    /// The number.
    pub fn value(self) -> f64 {
        match self {
            Self::Measured(error) | Self::AtMost(error) => error,
        }
    }
}

impl std::fmt::Display for ErrorStatement {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        match self {
            Self::Measured(error) => write!(f, "{error:.1e}"),
            Self::AtMost(limit) => write!(f, "≤ {limit:.1e}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_are_told_as_such() {
        assert_eq!(ErrorStatement::AtMost(3.14e-6).to_string(), "≤ 3.1e-6");
    }
}
