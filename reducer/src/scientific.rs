//! Numbers for tables: exponents always with a sign and two digits, so that columns align.

/// `7.5e-03`, as other languages print it, where `{:e}` gives `7.5e-3`.
pub fn scientific(value: f64, digits: usize) -> String {
    let text = format!("{value:.digits$e}");
    match text.split_once('e') {
        Some((mantissa, exponent)) => {
            let exponent: i32 = exponent.parse().unwrap_or(0);
            format!("{mantissa}e{exponent:+03}")
        }
        None => text, // infinite, or not a number
    }
}

/// A row of numbers with ten digits, each as wide as the widest there is.
pub fn row(values: &[f64]) -> String {
    let entries: Vec<String> = values
        .iter()
        .map(|value| format!("{:>17}", scientific(*value, 9)))
        .collect();
    entries.concat()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exponents_have_a_sign_and_two_digits() {
        assert_eq!(scientific(77.966, 3), "7.797e+01");
        assert_eq!(scientific(-1.5e-7, 1), "-1.5e-07");
        assert_eq!(scientific(0.0, 1), "0.0e+00");
        assert_eq!(scientific(1e-308, 0), "1e-308");
        assert_eq!(scientific(f64::INFINITY, 2), "inf");
    }

    #[test]
    fn a_row_has_columns() {
        let (a, b) = (row(&[1.0, -2e-100, 0.0]), row(&[-1e10, 3.0, 4.0]));
        assert_eq!(a.len(), b.len());
    }
}
