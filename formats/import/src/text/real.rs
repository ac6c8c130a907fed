//! Real numbers as other programs spell them: Fortran's exponents, decimal commas; and how many digits they print.

use dcb_formats::matrix::blocks::NotANumber;

/// Longest number in another spelling that is understood: sign, 17 digits and more than enough zeros, exponent.
const LONGEST: usize = 64;
/// Longest exponent, `D+0308`.
const EXPONENT: usize = 6;

/// The finite number that a field holds, blanks around it left out. The exponent may have `e`, `d` or no letter (`1.5-10`); one comma
/// where there is no point is a decimal comma.
///
/// # Errors
/// [`NotANumber::Unreadable`] for anything else, [`NotANumber::NotFinite`].
#[inline]
pub fn whole_real(field: &[u8]) -> Result<f64, NotANumber> {
    let field = field.trim_ascii();
    let mut length = field.len();
    let has_d = length > 4 && matches!(field[length - 4], b'd' | b'D');
    if !has_d
        && let Ok((value, used)) = fast_float2::parse_partial::<f64, _>(field)
        && used == length
        && value.is_finite()
    {
        return Ok(value);
    }
    // Room for the letter that Fortran leaves out.
    let mut spelling = [0; LONGEST + 1];
    if length > LONGEST {
        return Err(NotANumber::Unreadable);
    }
    spelling[..length].copy_from_slice(field);
    let tail = length.saturating_sub(EXPONENT).max(1).min(length);
    let is_exponent = |byte: &u8| matches!(byte, b'd' | b'D' | b'e' | b'E' | b'+' | b'-');
    if let Some(place) = spelling[tail..length].iter().position(is_exponent) {
        let place = tail + place;
        if matches!(spelling[place], b'+' | b'-') {
            spelling.copy_within(place..length, place + 1);
            length += 1;
        }
        spelling[place] = b'e';
    }
    let value = match fast_float2::parse(&spelling[..length]) {
        Ok(value) => value,
        Err(_) => with_decimal_comma(&mut spelling[..length])?,
    };
    match f64::is_finite(value) {
        true => Ok(value),
        false => Err(NotANumber::NotFinite),
    }
}

#[cold]
fn with_decimal_comma(spelling: &mut [u8]) -> Result<f64, NotANumber> {
    let mut commas = spelling.iter_mut().filter(|byte| **byte == b',');
    match (commas.next(), commas.next()) {
        (Some(comma), None) => *comma = b'.',
        _ => return Err(NotANumber::Unreadable),
    }
    fast_float2::parse(spelling).map_err(|_| NotANumber::Unreadable)
}

/// Significant digits that numbers are printed with.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Digits {
    most: u32,
}

impl Digits {
    /// Looks at a number, without blanks around it. That with the most digits counts: where others have fewer, zeros were left out.
    #[inline(always)]
    pub fn see(&mut self, number: &[u8]) {
        let length = number.len();
        let sign = usize::from(matches!(number.first(), Some(b'-' | b'+')));
        let zero = usize::from(number.get(sign) == Some(&b'0'));
        let point = usize::from(matches!(
            (number.get(sign), number.get(sign + 1)),
            (Some(b'.'), _) | (_, Some(b'.'))
        ));
        let has_exponent = length > 4 && matches!(number[length - 4], b'e' | b'E' | b'd' | b'D');
        let no_digits = sign + zero + point + if has_exponent { 4 } else { 0 };
        if length > self.most as usize + no_digits {
            self.most = self.most.max(significant(number));
        }
    }

    /// Takes those of other numbers in.
    pub fn join(&mut self, other: Self) {
        self.most = self.most.max(other.most);
    }

    /// Their number; `None` where no number but zero was seen.
    pub fn count(self) -> Option<u32> {
        (self.most > 0).then_some(self.most)
    }
}

/// Digits from the first that isn't zero to the exponent.
pub fn significant(number: &[u8]) -> u32 {
    let is_exponent = |(place, byte): (usize, &u8)| {
        matches!(byte, b'e' | b'E' | b'd' | b'D') || (place > 0 && matches!(byte, b'+' | b'-'))
    };
    let end = number.iter().enumerate().position(is_exponent);
    let mantissa = &number[..end.unwrap_or(number.len())];
    let digits = mantissa.iter().filter(|byte| byte.is_ascii_digit());
    digits.skip_while(|byte| **byte == b'0').count() as u32
}

#[cfg(test)]
mod tests {
    #![allow(clippy::float_cmp)]
    use super::*;

    #[test]
    fn fortran_and_german_spellings_are_the_numbers_that_they_stand_for() {
        for (field, value) in [
            ("  1.5D+03 ", 1500.0),
            ("1.5d3", 1500.0),
            ("1.5-10", 1.5e-10),
            ("-.1777E-09", -0.1777e-9),
            ("-1.5+103", -1.5e103),
            ("0.13D-0300", 0.13e-300),
            ("-5", -5.0),
            ("+7.", 7.0),
            ("3,25", 3.25),
            ("-3,25D+01", -32.5),
            ("4.500416961279500D+06", 4_500_416.961_279_5),
            ("  291719.31783334    ", 291_719.317_833_34),
        ] {
            assert_eq!(whole_real(field.as_bytes()), Ok(value), "{field}");
        }
    }

    #[test]
    fn what_is_no_number_is_refused() {
        for field in [
            "",
            " ",
            "-",
            ".",
            "1.5D",
            "1.5-",
            "1.5D+",
            "1.5E+1D",
            "1.000,5",
            "1,5,5",
            "1.5 2",
            "x",
            "1.5-10-3",
            "--1",
            "1e+-3",
            "0000000000000000000000000000000000000000000000000000000000000000001D0",
        ] {
            assert_eq!(
                whole_real(field.as_bytes()),
                Err(NotANumber::Unreadable),
                "{field}"
            );
        }
        for field in ["nan", "inf", "-Infinity", "1.5+999", "1D999"] {
            assert_eq!(
                whole_real(field.as_bytes()),
                Err(NotANumber::NotFinite),
                "{field}"
            );
        }
    }

    #[test]
    fn digits_are_those_that_a_format_prints() {
        let digits = |numbers: &[&str]| {
            let mut digits = Digits::default();
            numbers
                .iter()
                .for_each(|number| digits.see(number.as_bytes()));
            digits.count()
        };
        for (number, count) in [
            ("1.3181755644047e+06", 14),
            ("-1.000000000000000e+36", 16),
            ("1.3182D+06", 5),
            ("1.5-10", 2),
            ("291719.31783334", 14),
            ("-.59826575466965E-11", 14),
            ("0.45588706855779E-13", 14),
            ("-0.00123", 3),
            ("17", 2),
            ("1234567890123456", 16),
            ("1.e+100", 1),
        ] {
            assert_eq!(digits(&[number]), Some(count), "{number}");
            let fewer = ["1.5", number, "2", "0"];
            assert_eq!(digits(&fewer), Some(count.max(2)), "{number}");
        }
        assert_eq!(digits(&["0.000000000000000D+00", "0"]), None);
    }
}
