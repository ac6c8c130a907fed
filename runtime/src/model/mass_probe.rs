//! Mass in motion as recorded: of a body, or of all.

use nalgebra::Vector3;

use super::moment::Moment;
use crate::momentum::Momentum;

/// A recorded quantity of masses.
pub(super) struct MassProbe {
    /// A body; `None` is all of them.
    pub body: Option<usize>,
    pub quantity: MassQuantity,
}

/// Quantities of masses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum MassQuantity {
    Center,
    Linear,
    /// About a fixed point, world coordinates.
    AngularAbout(Vector3<f64>),
    AngularAboutCenter,
}

impl MassProbe {
    /// Its components, world axes.
    pub fn value(&self, at: &Moment) -> Vector3<f64> {
        let found = match self.body {
            Some(body) => Momentum::of_body(at.system, at.state, at.evaluation, body),
            None => Momentum::of_all(at.system, at.state, at.evaluation),
        };
        match self.quantity {
            MassQuantity::Center => found.center(),
            MassQuantity::Linear => found.linear,
            MassQuantity::AngularAbout(point) => found.angular_about(&point),
            MassQuantity::AngularAboutCenter => found.angular_about(&found.center()),
        }
    }

    /// Whether only its component across the plane isn't zero in planar scenes.
    pub fn is_angular(&self) -> bool {
        match self.quantity {
            MassQuantity::AngularAbout(_) | MassQuantity::AngularAboutCenter => true,
            MassQuantity::Center | MassQuantity::Linear => false,
        }
    }
}
