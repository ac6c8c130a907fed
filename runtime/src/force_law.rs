//! Force laws of springs, dampers and bushings on a measure.
//!
//! ```text
//! σ(e, e')  =  -(elastic(e - free) + damping(e'))
//! V(e)      =  ∫ elastic(x) dx  from 0 to e - free                V' + σ|_{e' = 0} = 0
//! ```
//! σ is conjugate to the measure e: it does the work σ δe, and pulls back. The unit is that of energy by that of e.

use crate::error::Error;

/// A force that depends on a measure and its rate.
#[derive(Clone, Debug, PartialEq)]
pub struct Law {
    free: f64,
    elastic: Characteristic,
    damping: Characteristic,
}

/// A force as a function of one variable.
#[derive(Clone, Debug, PartialEq)]
pub enum Characteristic {
    /// `slope x`
    Linear {
        /// Stiffness or damping coefficient.
        slope: f64,
    },
    /// Through given points.
    Tabulated(Table),
}

impl Law {
    /// A law from its parts; `free` is the value of the measure at which the elastic part starts.
    ///
    /// # Errors
    /// [`Error::LawNotFinite`]; [`Error::DampingNotPassive`] unless the damping is zero at rest and, also beyond its
    /// points, nowhere along the motion. The elastic part may have any sign and shape.
    pub fn new(free: f64, elastic: Characteristic, damping: Characteristic) -> Result<Self, Error> {
        check_finite("the free value", free)?;
        elastic.check_finite("the stiffness")?;
        damping.check_finite("the damping")?;
        damping.check_passive()?;
        Ok(Self {
            free,
            elastic,
            damping,
        })
    }

    /// Whether σ depends on the rate.
    pub fn is_damped(&self) -> bool {
        !matches!(self.damping, Characteristic::Linear { slope: 0.0 })
    }

    /// σ.
    #[inline]
    pub fn force(&self, value: f64, rate: f64) -> f64 {
        -(self.elastic.at(value - self.free) + self.damping.at(rate))
    }

    /// `(∂σ/∂e, ∂σ/∂e')`; at a point of a table, that of the segment above.
    #[inline]
    pub fn derivatives(&self, value: f64, rate: f64) -> (f64, f64) {
        (
            -self.elastic.slope(value - self.free),
            -self.damping.slope(rate),
        )
    }

    /// V, zero at the free value.
    #[inline]
    pub fn potential(&self, value: f64) -> f64 {
        self.elastic.integral(value - self.free)
    }

    /// Power that the damping takes, `damping(e') e'`; never negative.
    #[inline]
    pub fn dissipation(&self, rate: f64) -> f64 {
        self.damping.at(rate) * rate
    }
}

impl Characteristic {
    fn at(&self, x: f64) -> f64 {
        match self {
            Self::Linear { slope } => slope * x,
            Self::Tabulated(table) => table.at(x),
        }
    }

    fn slope(&self, x: f64) -> f64 {
        match self {
            Self::Linear { slope } => *slope,
            Self::Tabulated(table) => table.slope(x),
        }
    }

    /// From zero to x.
    fn integral(&self, x: f64) -> f64 {
        match self {
            Self::Linear { slope } => 0.5 * slope * x * x,
            Self::Tabulated(table) => table.integral(x),
        }
    }

    fn check_finite(&self, quantity: &'static str) -> Result<(), Error> {
        match self {
            Self::Linear { slope } => check_finite(quantity, *slope),
            Self::Tabulated(_) => Ok(()), // checked when it was made
        }
    }

    fn check_passive(&self) -> Result<(), Error> {
        match self {
            Self::Linear { slope } if *slope < 0.0 => Err(Error::DampingNotPassive {
                found: format!("its coefficient is {slope}"),
            }),
            Self::Linear { .. } => Ok(()),
            Self::Tabulated(table) => table.check_passive(),
        }
    }
}

/// Straight lines through given points, and on along the first and last line beyond them. Its integral is exact.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// Increasing.
    abscissae: Vec<f64>,
    values: Vec<f64>,
    /// Of each line; one fewer than points.
    slopes: Vec<f64>,
    /// Integral from zero to each point.
    integrals: Vec<f64>,
}

impl Table {
    /// Through `(abscissa, value)` points.
    ///
    /// # Errors
    /// [`Error::TableTooShort`], [`Error::LawNotFinite`], [`Error::TableNotIncreasing`].
    pub fn through(points: &[(f64, f64)]) -> Result<Self, Error> {
        if points.len() < 2 {
            return Err(Error::TableTooShort {
                count: points.len(),
            });
        }
        for (x, y) in points {
            check_finite("an abscissa of the table", *x)?;
            check_finite("a value of the table", *y)?;
        }
        let mut slopes = Vec::with_capacity(points.len() - 1);
        let mut integrals = vec![0.0];
        for (before, pair) in points.windows(2).enumerate() {
            let ((x0, y0), (x1, y1)) = (pair[0], pair[1]);
            if x1 <= x0 {
                return Err(Error::TableNotIncreasing {
                    index: before + 1,
                    found: x1,
                    previous: x0,
                });
            }
            let slope = (y1 - y0) / (x1 - x0);
            check_finite("the slope of a line of the table", slope)?;
            slopes.push(slope);
            integrals.push(integrals[before] + 0.5 * (y0 + y1) * (x1 - x0));
        }
        let (abscissae, values) = points.iter().copied().unzip();
        let mut table = Self {
            abscissae,
            values,
            slopes,
            integrals,
        };
        let from_first_to_zero = table.integral(0.0);
        for integral in &mut table.integrals {
            *integral -= from_first_to_zero;
        }
        Ok(table)
    }

    /// The line that x is on, and how far x is beyond its start.
    fn line(&self, x: f64) -> (usize, f64) {
        let inner = &self.abscissae[1..self.slopes.len()];
        let line = inner.partition_point(|start| *start <= x);
        (line, x - self.abscissae[line])
    }

    fn at(&self, x: f64) -> f64 {
        let (line, beyond) = self.line(x);
        self.values[line] + self.slopes[line] * beyond
    }

    fn slope(&self, x: f64) -> f64 {
        self.slopes[self.line(x).0]
    }

    fn integral(&self, x: f64) -> f64 {
        let (line, beyond) = self.line(x);
        self.integrals[line] + beyond * (self.values[line] + 0.5 * self.slopes[line] * beyond)
    }

    /// A function of straight lines has the sign of its argument everywhere if it passes through the origin, has it at
    /// every point, and doesn't turn back beyond the ends. The origin is to be a point, so that none of this rounds.
    fn check_passive(&self) -> Result<(), Error> {
        let refused = |found: String| Err(Error::DampingNotPassive { found });
        let points = || self.abscissae.iter().zip(&self.values);
        if !points().any(|(x, y)| *x == 0.0 && *y == 0.0) {
            return refused("its table has no point (0, 0)".to_owned());
        }
        if let Some((x, y)) = points().find(|(x, y)| *x * *y < 0.0) {
            return refused(format!("it is {y} at the rate {x}"));
        }
        let ends = [self.slopes.first(), self.slopes.last()];
        match ends.into_iter().flatten().find(|slope| **slope < 0.0) {
            Some(slope) => refused(format!(
                "beyond the end of its table it follows the slope {slope}"
            )),
            None => Ok(()),
        }
    }
}

fn check_finite(quantity: &'static str, found: f64) -> Result<(), Error> {
    if found.is_finite() {
        Ok(())
    } else {
        Err(Error::LawNotFinite { quantity, found })
    }
}
