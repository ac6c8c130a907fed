//! Units in kilograms, metres, seconds and radians.

use dcb_formats::component::Units;
use dcb_formats::units::{DerivedUnits, si_factor};

/// A unit as powers of SI units and a factor: a value times the factor is the value in kg^a m^b s^c rad^d.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SiUnit {
    /// Power of the kilogram.
    pub kilogram: i32,
    /// Power of the metre.
    pub metre: i32,
    /// Power of the second.
    pub second: i32,
    /// Power of the radian.
    pub radian: i32,
    /// Size in these.
    pub factor: f64,
}

impl SiUnit {
    /// A unit that the runtime names, by its name. `None` where a size isn't known, and where a power isn't whole
    /// (modal coordinates).
    pub fn of(unit: &str, units: &Units) -> Option<Self> {
        let (l, m, t) = (&units.length, &units.mass, &units.time);
        let derived = DerivedUnits::of(l, m, t);
        let known: [(String, [i32; 4]); 10] = [
            ("rad".into(), [0, 0, 0, 1]),
            (l.clone(), [0, 1, 0, 0]),
            (t.clone(), [0, 0, 1, 0]),
            (format!("{l}/{t}"), [0, 1, -1, 0]),
            (format!("{l}/{t}^2"), [0, 1, -2, 0]),
            (format!("rad/{t}"), [0, 0, -1, 1]),
            (derived.force, [1, 1, -2, 0]),
            (derived.moment, [1, 2, -2, 0]),
            (derived.energy, [1, 2, -2, 0]),
            (m.clone(), [1, 0, 0, 0]),
        ];
        let (_, [kilogram, metre, second, radian]) =
            known.into_iter().find(|(name, _)| name == unit)?;
        let size = |name: &str, power: i32| match power {
            0 => Some(1.0),
            _ => si_factor(name).map(|size| size.powi(power)),
        };
        Some(Self {
            kilogram,
            metre,
            second,
            radian,
            factor: size(m, kilogram)? * size(l, metre)? * size(t, second)?,
        })
    }
}

#[cfg(test)]
#[expect(clippy::unwrap_used, reason = "a test says what went wrong by failing")]
mod tests {
    use super::*;

    fn units(names: [&str; 3]) -> Units {
        let [length, mass, time] = names.map(str::to_owned);
        Units { length, mass, time }
    }

    #[test]
    fn a_force_in_tonnes_and_millimetres_is_a_newton() {
        let found = SiUnit::of("N", &units(["mm", "t", "s"])).unwrap();
        assert_eq!(
            (found.kilogram, found.metre, found.second, found.radian),
            (1, 1, -2, 0)
        );
        assert!((found.factor - 1.0).abs() < 1e-15);
        let turning = SiUnit::of("rad/ms", &units(["mm", "g", "ms"])).unwrap();
        assert_eq!((turning.second, turning.radian), (-1, 1));
        assert!((turning.factor - 1e3).abs() < 1e-12);
    }

    #[test]
    fn what_has_no_size_in_whole_powers_is_left_without() {
        let furlongs = units(["furlong", "kg", "s"]);
        assert_eq!(SiUnit::of("furlong/s", &furlongs), None);
        assert!(SiUnit::of("rad/s", &furlongs).is_some());
        assert_eq!(SiUnit::of("sqrt(kg)*m", &units(["m", "kg", "s"])), None);
    }
}
