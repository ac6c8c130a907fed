//! Distance joint: the origins stay a given distance apart, as with a massless rod between two ball joints.

use super::rows::JointRows;
use crate::error::Error;
use crate::measure::{Distance, Elongation, Measure};

pub(super) const NAME: &str = "distance";

/// Leaves everything free but the distance between the origins.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DistanceJoint {
    /// Above zero.
    pub length: f64,
}

impl DistanceJoint {
    pub(super) fn rows(&self) -> Result<JointRows, Error> {
        let length = self.length;
        if !(length.is_finite() && length > 0.0) {
            return Err(Error::LengthNotPositive {
                joint: NAME,
                quantity: "length",
                found: length,
            });
        }
        Ok(JointRows {
            translation: Some(Measure::Elongation(Elongation { length })),
            ..JointRows::holding(vec![Measure::Distance(Distance { length })])
        })
    }
}
