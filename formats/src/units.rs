//! Units by their names, and frequencies in them.

/// A unit's size in metres, kilograms or seconds, if its name is known.
pub fn si_factor(unit: &str) -> Option<f64> {
    Some(match unit {
        "m" | "kg" | "s" => 1.0,
        "mm" | "g" | "ms" => 1e-3,
        "cm" => 1e-2,
        "um" | "µm" | "us" | "µs" | "mg" => 1e-6,
        "km" | "t" | "tonne" | "Mg" => 1e3,
        "in" => 0.0254,
        "ft" => 0.3048,
        "lb" | "lbm" => 0.453_592_37,
        "slug" => 14.593_902_937_206_364,
        "slinch" | "blob" | "lbf*s^2/in" => 175.126_835_246_476_37,
        _ => return None,
    })
}

/// Cycles per second of an eigenvalue, or per time unit where the unit's length is not known.
pub fn hertz(eigenvalue: f64, time_unit: &str) -> f64 {
    eigenvalue.max(0.0).sqrt() / (2.0 * std::f64::consts::PI * si_factor(time_unit).unwrap_or(1.0))
}

/// `Hz`, or the inverse of a unit whose length is not known.
pub fn hertz_unit(time_unit: &str) -> String {
    if si_factor(time_unit).is_some() {
        "Hz".into()
    } else {
        format!("1/{time_unit}")
    }
}

/// A frequency with its unit as people write it: `314.1 Hz`, `0.02500 1/year`. `cycles` is in cycles per unit of time.
pub fn written_frequency(cycles: f64, time_unit: &str) -> String {
    let value = cycles / si_factor(time_unit).unwrap_or(1.0);
    format!("{} {}", four_digits(value), hertz_unit(time_unit))
}

/// A number with four digits or a few more, without an exponent where that is readable.
pub fn four_digits(value: f64) -> String {
    let size = value.abs();
    match size {
        0.0 => "0".into(),
        _ if !(1e-3..1e7).contains(&size) => format!("{value:.3e}"),
        _ => {
            let decimals = 3 - size.log10().floor() as i32;
            format!("{value:.*}", usize::try_from(decimals).unwrap_or(0))
        }
    }
}

/// Names of units that are made of those of length, mass and time.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DerivedUnits {
    /// Mass times acceleration: `N` where it is a newton, or a thousand of them or the like.
    pub force: String,
    /// Force times length: `N*m`, never the name of an energy where a force has one.
    pub moment: String,
    /// Force along a way: `J`, `mJ`.
    pub energy: String,
    /// Force over area: `Pa`, `MPa`.
    pub stress: String,
}

impl DerivedUnits {
    /// In `N` and `J` with a prefix where the sizes of length, mass and time are known and there is one, else as products of their names.
    pub fn of(length: &str, mass: &str, time: &str) -> Self {
        let sizes = [length, mass, time].map(si_factor);
        let [force, energy, stress] = match sizes {
            [Some(l), Some(m), Some(t)] => {
                [m * l / (t * t), m * l * l / (t * t), m / (l * t * t)].map(Some)
            }
            _ => [None, None, None],
        };
        let named = |size: Option<f64>, name: &str| {
            size.and_then(prefix)
                .map(|prefix| format!("{prefix}{name}"))
        };
        let product = format!("{mass}*{length}^2/{time}^2");
        let force = named(force, "N");
        Self {
            moment: match &force {
                Some(force) => format!("{force}*{length}"),
                None => product.clone(),
            },
            force: force.unwrap_or_else(|| format!("{mass}*{length}/{time}^2")),
            energy: named(energy, "J").unwrap_or(product),
            stress: named(stress, "Pa").unwrap_or_else(|| format!("{mass}/({length}*{time}^2)")),
        }
    }
}

/// The prefix of a unit so many times as large.
fn prefix(size: f64) -> Option<&'static str> {
    let known = [
        (1e-9, "n"),
        (1e-6, "u"),
        (1e-3, "m"),
        (1.0, ""),
        (1e3, "k"),
        (1e6, "M"),
        (1e9, "G"),
    ];
    let found = known
        .iter()
        .find(|(factor, _)| (size / factor - 1.0).abs() < 1e-9);
    found.map(|(_, prefix)| *prefix)
}

/// A number of bytes for people.
pub fn readable(bytes: u64) -> String {
    let megabytes = bytes as f64 / 1024_f64.powi(2);
    if megabytes < 1000.0 {
        format!("{megabytes:.0} MB")
    } else {
        format!("{:.1} GB", megabytes / 1024.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn forces_moments_and_energies_have_their_own_names() {
        let of = |length, mass, time| {
            let DerivedUnits {
                force,
                moment,
                energy,
                stress,
            } = DerivedUnits::of(length, mass, time);
            [force, moment, energy, stress]
        };
        assert_eq!(of("m", "kg", "s"), ["N", "N*m", "J", "Pa"]);
        assert_eq!(of("mm", "t", "s"), ["N", "N*mm", "mJ", "MPa"]);
        assert_eq!(of("mm", "kg", "ms"), ["kN", "kN*mm", "J", "GPa"]);
        assert_eq!(
            of("in", "slinch", "s"),
            [
                "slinch*in/s^2",
                "slinch*in^2/s^2",
                "slinch*in^2/s^2",
                "slinch/(in*s^2)"
            ]
        );
        assert_eq!(of("furlong", "kg", "s")[0], "kg*furlong/s^2");
    }

    #[test]
    fn numbers_for_people_have_four_digits() {
        let shown = [314.08, 4611.94, 0.025, 5.0, 1e9, 0.0, 123_456.0].map(four_digits);
        assert_eq!(
            shown,
            [
                "314.1", "4612", "0.02500", "5.000", "1.000e9", "0", "123456"
            ]
        );
        assert_eq!(written_frequency(2.0, "ms"), "2000 Hz");
    }

    #[test]
    fn sizes_are_told_in_megabytes_and_gigabytes() {
        assert_eq!(readable(512 << 20), "512 MB");
        assert_eq!(readable(3 << 29), "1.5 GB");
    }
}
