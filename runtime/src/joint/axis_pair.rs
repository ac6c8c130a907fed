//! An axis of a and the axis of b that stays parallel to it.

use nalgebra::{Unit, Vector3};

use super::direction::{direction, perpendiculars};
use super::rest::RestPlacement;
use super::rows::FreeRotation;
use crate::error::Error;
use crate::measure::{Alignment, Angle, Measure};

/// Smallest cosine, as drawn, between an axis of a and b's axis given for it.
const LEAST_COSINE: f64 = 0.5;

/// Two axes that a joint keeps parallel.
pub(super) struct AxisPair {
    /// In a's axes.
    pub(super) a: Unit<Vector3<f64>>,
    /// In b's axes.
    pub(super) b: Unit<Vector3<f64>>,
}

impl AxisPair {
    /// a's axis, with b's as given or else as drawn.
    ///
    /// # Errors
    /// [`Error::NoDirection`]; [`Error::AxesApart`] if b's axis is drawn more than 60° off.
    pub(super) fn new(
        joint: &'static str,
        [quantity_a, quantity_b]: [&'static str; 2],
        axis_a: &Vector3<f64>,
        axis_b: Option<&Vector3<f64>>,
        rest: &RestPlacement,
    ) -> Result<Self, Error> {
        let a = direction(joint, quantity_a, axis_a)?;
        let drawn = rest.seen_from_b(&a);
        let b = axis_b.map_or(Ok(drawn), |given| direction(joint, quantity_b, given))?;
        let cosine = drawn.dot(&b);
        // Negated, so that an orientation that isn't a number is refused as well.
        if cosine.is_nan() || cosine < LEAST_COSINE {
            return Err(Error::AxesApart {
                joint,
                quantity: quantity_b,
                degrees: cosine.clamp(-1.0, 1.0).acos().to_degrees(),
            });
        }
        Ok(Self { a, b })
    }

    /// The two rows that keep the axes parallel.
    pub(super) fn parallel(&self) -> impl Iterator<Item = Measure> {
        let direction_b = self.b;
        perpendiculars(&self.a).into_iter().map(move |direction_a| {
            Measure::Alignment(Alignment {
                direction_a,
                direction_b,
            })
        })
    }

    /// Angle about the axis, zero as drawn.
    pub(super) fn angle(&self, rest: &RestPlacement) -> FreeRotation {
        let [first_a, second_a] = perpendiculars(&self.a);
        // Perpendicular to b's own axis, so that the angle is undisturbed where the joint holds.
        let drawn = rest.seen_from_b(&first_a);
        let first_b = Unit::new_normalize(drawn.as_ref() - self.b.as_ref() * self.b.dot(&drawn));
        FreeRotation {
            angle: Measure::Angle(Angle {
                first_a,
                second_a,
                first_b,
            }),
            axis_a: self.a,
            axis_b: self.b,
        }
    }

    /// The rotations that keeping the axes parallel loads, in a's axes and in b's.
    pub(super) fn turned(&self) -> [Vec<Unit<Vector3<f64>>>; 2] {
        [&self.a, &self.b].map(|axis| perpendiculars(axis).into())
    }
}
