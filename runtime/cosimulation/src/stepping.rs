//! Inner steps between communication points.
//!
//! Times that are whole multiples of the scene's step are its grid. From one of them to another one the unit takes the scene's steps, the same that a
//! whole run takes. Elsewhere the way is divided into the fewest equal steps that are no longer than the scene's. An adaptive scene takes steps
//! that follow the error and end at the communication point.

use dcb_runtime::Error;
use dcb_runtime::Mechanism;
use dcb_runtime::integrator::adaptive::{AdaptiveStep, StepSize};

/// Parts of a step by which an importer's sum of times may be off the grid.
const OFF_GRID: f64 = 1e-9;
/// Rounding of a sum of times, in units of its last digit.
const ROUNDINGS: f64 = 16.0;

/// How the next inner step is found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Stepping {
    /// Steps of one length, and how many of them from zero the present time is, if a whole number.
    Equal {
        /// The scene's step.
        step: f64,
        /// Steps from zero; `None` off the grid.
        made: Option<u64>,
    },
    /// Steps that follow the error.
    Adaptive(StepSize),
    /// Steps that follow an accuracy.
    Accurate,
}

/// How far a stepping has come; what it was made with is not part of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Progress {
    /// Steps from zero; `None` off the grid, and of adaptive steps.
    pub made: Option<u64>,
    /// The next adaptive step, and how many were accepted since it changed; zeros of equal steps.
    pub size: (f64, usize),
}

impl Stepping {
    pub(crate) fn progress(&self) -> Progress {
        match self {
            Self::Equal { made, .. } => Progress {
                made: *made,
                size: (0.0, 0),
            },
            Self::Adaptive(size) => Progress {
                made: None,
                size: size.reached(),
            },
            Self::Accurate => Progress {
                made: None,
                size: (0.0, 0),
            },
        }
    }

    pub(crate) fn resume(&mut self, progress: &Progress) {
        match self {
            Self::Equal { made, .. } => *made = progress.made,
            Self::Adaptive(size) => *size = StepSize::resumed(*size.settings(), progress.size),
            Self::Accurate => {}
        }
    }

    pub(crate) fn equal(step: f64) -> Self {
        Self::Equal {
            step,
            made: Some(0),
        }
    }

    pub(crate) fn adaptive(settings: AdaptiveStep) -> Self {
        Self::Adaptive(StepSize::new(settings))
    }

    /// Whether two times are the same but for rounding.
    pub(crate) fn is_same(&self, a: f64, b: f64) -> bool {
        let step = match self {
            Self::Equal { step, .. } => *step,
            Self::Adaptive(size) => size.settings().smallest,
            Self::Accurate => 0.0,
        };
        (a - b).abs() <= OFF_GRID * step + ROUNDINGS * f64::EPSILON * b.abs()
    }

    /// Moves to a later time; `may_take` is asked about the length of each step. Where a step fails the motion stays at the one before it.
    pub(crate) fn advance(
        &mut self,
        mechanism: &mut Mechanism,
        target: f64,
        mut may_take: impl FnMut(&Mechanism, f64) -> Result<(), Error>,
    ) -> Result<(), Error> {
        let then = self.on_grid(target);
        match self {
            Self::Adaptive(size) => {
                while mechanism.time() < target {
                    mechanism.step_adaptively(target, size)?;
                }
                Ok(())
            }
            Self::Accurate => {
                while mechanism.time() < target {
                    mechanism.step_towards(target)?;
                }
                Ok(())
            }
            Self::Equal { step, made } => {
                let step = *step;
                if let (Some(now), Some(then)) = (*made, then)
                    && now < then
                {
                    may_take(mechanism, step)?;
                    for reached in now + 1..=then {
                        mechanism.step(step)?;
                        *made = Some(reached);
                    }
                    return Ok(());
                }
                let left = target - mechanism.time();
                let count = (left / step - OFF_GRID).ceil().max(1.0);
                may_take(mechanism, left / count)?;
                *made = None;
                for _ in 0..count as u64 {
                    mechanism.step(left / count)?;
                }
                *made = then;
                Ok(())
            }
        }
    }

    /// Steps from zero to a time, if a whole number.
    fn on_grid(&self, time: f64) -> Option<u64> {
        match self {
            Self::Equal { step, .. } => {
                let whole = (time / step).round();
                self.is_same(time, whole * step).then_some(whole as u64)
            }
            Self::Adaptive(_) | Self::Accurate => None,
        }
    }
}
