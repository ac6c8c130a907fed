//! Measures between two frames: the scalar functions that joints, drives, springs and bushings are made of.
//!
//! A measure e depends on the poses of two frames a and b, and on nothing else. A joint or a drive holds some measures
//! at given values, a spring or bushing has a force law on one. Either way a generalised force σ, conjugate to e, acts
//! on the frames through the gradient; with the variations of [`crate::kinematics::frame_motion`]:
//!
//! ```text
//! δe          =  g_a · (δp_a, δψ_a) + g_b · (δp_b, δψ_b)
//! wrench on a =  σ g_a,   wrench on b  =  σ g_b
//! e'          =  g_a · V_a + g_b · V_b                             V = (velocity, spin)
//! e''         =  g_a · V'_a + g_b · V'_b + g'_a · V_a + g'_b · V_b
//! ```
//!
//! Every measure but [`WorldDisplacement`] is unchanged when both frames move together as one rigid body; its two
//! wrenches are then in equilibrium. Everything here is exact and allocates nothing. A new measure is one file with a
//! type that is a `FrameFunction`, and its lines in this one.

mod alignment;
mod angle;
mod carried;
mod displacement;
mod distance;
mod elongation;
mod gradient;
mod rotation_component;
mod world_displacement;

use std::f64::consts::TAU;

pub use alignment::Alignment;
pub use angle::Angle;
pub use displacement::Displacement;
pub use distance::Distance;
pub use elongation::Elongation;
pub use gradient::{Gradient, GradientDerivative};
pub use rotation_component::Rotation;
pub use world_displacement::WorldDisplacement;

use crate::kinematics::frame_motion::FrameMotion;

/// A scalar function of the poses of two frames.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Measure {
    /// How far b is from a, along a direction of a.
    Displacement(Displacement),
    /// How far b is from a, along a direction of the world.
    WorldDisplacement(WorldDisplacement),
    /// Cosine of the angle between a direction of a and one of b.
    Alignment(Alignment),
    /// How much the distance exceeds a given one; smooth everywhere.
    Distance(Distance),
    /// Distance itself.
    Elongation(Elongation),
    /// Angle from a to b about an axis of a.
    Angle(Angle),
    /// Component of the rotation vector from a to b.
    Rotation(Rotation),
}

impl Measure {
    /// e: length, angle in rad, or cosine.
    #[inline]
    pub fn value(&self, a: &FrameMotion, b: &FrameMotion) -> f64 {
        self.function().value(a, b)
    }

    /// How e changes with the poses.
    #[inline]
    pub fn gradient(&self, a: &FrameMotion, b: &FrameMotion) -> Gradient {
        self.function().gradient(a, b)
    }

    /// Whether e is a length; else an angle or a cosine.
    pub fn is_length(&self) -> bool {
        matches!(
            self,
            Self::Displacement(_)
                | Self::WorldDisplacement(_)
                | Self::Distance(_)
                | Self::Elongation(_)
        )
    }

    /// de/dt, from velocities and spins.
    #[inline]
    pub fn rate(&self, a: &FrameMotion, b: &FrameMotion) -> f64 {
        self.gradient(a, b).rate(a, b)
    }

    /// d²e/dt², from velocities, spins and their rates.
    #[inline]
    pub fn second_rate(&self, a: &FrameMotion, b: &FrameMotion) -> f64 {
        self.function().second_rate(a, b)
    }

    /// How the gradient, in world components, changes with the poses.
    #[inline]
    pub fn gradient_derivative(&self, a: &FrameMotion, b: &FrameMotion) -> GradientDerivative {
        self.function().gradient_derivative(a, b)
    }

    /// How far a value of this measure is from a target. Angles are compared to the nearest turn, so that a target may go
    /// round any number of times; the result is then within half a turn.
    #[inline]
    pub fn deviation(&self, value: f64, target: f64) -> f64 {
        let difference = value - target;
        match self {
            Self::Angle(_) => difference - TAU * (difference / TAU).round(),
            _ => difference,
        }
    }

    #[inline]
    fn function(&self) -> &dyn FrameFunction {
        match self {
            Self::Displacement(measure) => measure,
            Self::WorldDisplacement(measure) => measure,
            Self::Alignment(measure) => measure,
            Self::Distance(measure) => measure,
            Self::Elongation(measure) => measure,
            Self::Angle(measure) => measure,
            Self::Rotation(measure) => measure,
        }
    }
}

/// Functions of each kind of measure; the meanings are those of [`Measure`]'s functions.
trait FrameFunction {
    fn value(&self, a: &FrameMotion, b: &FrameMotion) -> f64;
    fn gradient(&self, a: &FrameMotion, b: &FrameMotion) -> Gradient;
    fn second_rate(&self, a: &FrameMotion, b: &FrameMotion) -> f64;
    fn gradient_derivative(&self, a: &FrameMotion, b: &FrameMotion) -> GradientDerivative;
}
