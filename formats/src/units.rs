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
    fn sizes_are_told_in_megabytes_and_gigabytes() {
        assert_eq!(readable(512 << 20), "512 MB");
        assert_eq!(readable(3 << 29), "1.5 GB");
    }
}
