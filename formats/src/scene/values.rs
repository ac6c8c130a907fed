//! Quantities that planar and spatial scenes write differently, or that may be a number or a table.

use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::check::{Checker, finite, vector};
use crate::Error;

/// Largest deviation of a given quaternion's length from one: the rounding of seven written digits.
const QUATERNION_TOLERANCE: f64 = 1e-6;

/// Rounding allowed to an inertia matrix, relative to its trace.
const INERTIA_ROUNDING: f64 = 1e-9;

/// Two or three components as three; components that are missing are zero.
pub fn in_space(components: &[f64]) -> Vector3<f64> {
    Vector3::from_fn(|axis, _| components.get(axis).copied().unwrap_or(0.0))
}

/// From the axes of a component to world axes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(
    untagged,
    expecting = "expected an angle in rad (planar) or a quaternion [w, x, y, z] (spatial)"
)]
pub enum Orientation {
    /// Planar: angle about z, rad.
    Angle(f64),
    /// Spatial: unit quaternion w, x, y, z.
    Quaternion([f64; 4]),
}

/// Rate of rotation in world axes, rad/time.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(
    untagged,
    expecting = "expected a number (planar) or three components (spatial)"
)]
pub enum AngularVelocity {
    /// Planar: about z.
    Planar(f64),
    /// Spatial: components in world axes.
    Spatial([f64; 3]),
}

/// Rotary inertia of a rigid body about its centre of mass, in the axes of its component, mass·length².
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(
    untagged,
    expecting = "expected a number (planar), three principal moments or a symmetric 3 x 3 matrix (spatial)"
)]
pub enum RotaryInertia {
    /// Planar: about z.
    Planar(f64),
    /// Spatial: moments about x, y, z, which are principal axes.
    Principal([f64; 3]),
    /// Spatial: symmetric matrix, row by row.
    Tensor([[f64; 3]; 3]),
}

/// A force over an elongation, an angle or a rate.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(
    untagged,
    expecting = "expected a number or a table [[elongation, force], [elongation, force], ...]"
)]
pub enum Characteristic {
    /// Proportional, with this factor.
    Linear(f64),
    /// Points `[argument, force]` joined by straight lines; the first and the last line are continued beyond the ends.
    Table(Vec<[f64; 2]>),
}

impl Default for Characteristic {
    fn default() -> Self {
        Self::Linear(0.0)
    }
}

impl Orientation {
    /// The rotation, a turn about z where planar; a quaternion is normalised.
    pub fn rotation(&self) -> UnitQuaternion<f64> {
        match *self {
            Self::Angle(angle) => UnitQuaternion::from_axis_angle(&Vector3::z_axis(), angle),
            Self::Quaternion([w, x, y, z]) => {
                UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z))
            }
        }
    }

    pub(super) fn check(&self, location: &str, checker: &Checker) -> Result<(), Error> {
        match (self, checker.dimension_count()) {
            (Self::Angle(angle), 2) => finite(location, *angle),
            (Self::Quaternion(components), 3) => {
                vector(location, components, 4)?;
                let length = components.iter().map(|c| c * c).sum::<f64>().sqrt();
                if (length - 1.0).abs() <= QUATERNION_TOLERANCE {
                    Ok(())
                } else {
                    Err(Error::described(
                        location,
                        format!(
                            "has length {length}, expected a unit quaternion [w, x, y, z] (within {QUATERNION_TOLERANCE:e})"
                        ),
                    ))
                }
            }
            (Self::Angle(_), _) => Err(Error::described(
                location,
                "is an angle, but the scene is spatial; expected a quaternion [w, x, y, z]",
            )),
            (Self::Quaternion(_), _) => Err(Error::described(
                location,
                "is a quaternion, but the scene is planar; expected an angle in rad",
            )),
        }
    }
}

impl AngularVelocity {
    /// Components in world axes; only z where planar.
    pub fn components(&self) -> Vector3<f64> {
        match *self {
            Self::Planar(rate) => Vector3::new(0.0, 0.0, rate),
            Self::Spatial(components) => Vector3::from(components),
        }
    }

    pub(super) fn check(&self, location: &str, checker: &Checker) -> Result<(), Error> {
        match (self, checker.dimension_count()) {
            (Self::Planar(rate), 2) => finite(location, *rate),
            (Self::Spatial(components), 3) => vector(location, components, 3),
            (Self::Planar(_), _) => Err(Error::described(
                location,
                "is a number, but the scene is spatial; expected three components in world axes",
            )),
            (Self::Spatial(_), _) => Err(Error::described(
                location,
                "has three components, but the scene is planar; expected a number (about z)",
            )),
        }
    }
}

impl RotaryInertia {
    /// The matrix; only (z, z) where planar.
    pub fn matrix(&self) -> Matrix3<f64> {
        match *self {
            Self::Planar(moment) => Matrix3::from_diagonal(&Vector3::new(0.0, 0.0, moment)),
            Self::Principal(moments) => Matrix3::from_diagonal(&Vector3::from(moments)),
            Self::Tensor(rows) => Matrix3::from_fn(|row, column| rows[row][column]),
        }
    }

    /// Positive, symmetric, and such that matter can have it: no principal moment exceeds the sum of the others.
    pub(super) fn check(&self, location: &str, checker: &Checker) -> Result<(), Error> {
        let matrix = self.matrix();
        if let Some(bad) = matrix.iter().find(|entry| !entry.is_finite()) {
            return Err(Error::described(
                location,
                format!("has {bad}, expected finite numbers"),
            ));
        }
        match (self, checker.dimension_count()) {
            (Self::Planar(moment), 2) => {
                return if *moment >= 0.0 {
                    Ok(())
                } else {
                    Err(Error::described(
                        location,
                        format!("is {moment}, expected a positive number, or 0 for a point mass"),
                    ))
                };
            }
            (Self::Principal(_) | Self::Tensor(_), 3) => {}
            (Self::Planar(_), _) => {
                return Err(Error::described(
                    location,
                    "is a number, but the scene is spatial; expected three principal moments or a 3 x 3 matrix",
                ));
            }
            _ => {
                return Err(Error::described(
                    location,
                    "has rows, but the scene is planar; expected a number (about z)",
                ));
            }
        }
        let rounding = INERTIA_ROUNDING * matrix.diagonal().abs().sum();
        if (matrix - matrix.transpose()).amax() > rounding {
            return Err(Error::described(
                location,
                "is not symmetric; the off-diagonal entries are minus the products of inertia on both sides",
            ));
        }
        if matrix == Matrix3::zeros() {
            return Ok(());
        }
        let mut principal = matrix.symmetric_eigenvalues();
        principal.as_mut_slice().sort_by(f64::total_cmp);
        let [small, middle, large] = [principal[0], principal[1], principal[2]];
        if small <= 0.0 {
            return Err(Error::described(
                location,
                format!(
                    "has the principal moment {small}, expected three positive ones, or [0, 0, 0] for a point mass; of a thin rod write \
                     a small moment about its axis"
                ),
            ));
        }
        if large > small + middle + rounding {
            return Err(Error::described(
                location,
                format!(
                    "has the principal moments {small}, {middle}, {large}, which no matter has: \
                     the largest exceeds the sum of the others"
                ),
            ));
        }
        Ok(())
    }
}

impl Characteristic {
    pub(super) fn check(&self, location: &str) -> Result<(), Error> {
        let points = match self {
            Self::Linear(factor) => return not_negative(location, *factor),
            Self::Table(points) => points,
        };
        if points.len() < 2 {
            return Err(Error::described(
                location,
                format!("has {} points, expected at least 2", points.len()),
            ));
        }
        for (index, point) in points.iter().enumerate() {
            vector(&format!("{location}[{index}]"), point, 2)?;
        }
        match points.windows(2).position(|pair| pair[1][0] <= pair[0][0]) {
            Some(index) => Err(Error::described(
                format!("{location}[{}]", index + 1),
                format!(
                    "starts with {}, not after {}; the first numbers must strictly increase",
                    points[index + 1][0],
                    points[index][0]
                ),
            )),
            None => Ok(()),
        }
    }
}

pub(super) fn not_negative(location: &str, number: f64) -> Result<(), Error> {
    if number.is_finite() && number >= 0.0 {
        Ok(())
    } else {
        Err(Error::described(
            location,
            format!("is {number}, expected a number >= 0"),
        ))
    }
}

pub(super) fn positive(location: &str, number: f64) -> Result<(), Error> {
    if number.is_finite() && number > 0.0 {
        Ok(())
    } else {
        Err(Error::described(
            location,
            format!("is {number}, expected a positive number"),
        ))
    }
}
