//! Range, ticks and tick labels of an axis.

use std::ops::Range;

use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};

use crate::chart::Scale;

/// Fraction of the range that is left free at each end of a linear axis of values.
const MARGIN: f64 = 0.05;
/// And at an end of a logarithmic one, where a value is nearer to it than that.
const LOGARITHMIC_MARGIN: f64 = 0.03;
/// Values within which ticks are written without a power of ten.
const PLAIN: Range<f64> = 1e-3..1e5;

/// Beyond these, differences and ratios of the ends would overflow: such values aren't drawn, like infinite ones.
const LARGEST: f64 = 1e300;
const SMALLEST: f64 = 1e-300;

/// An axis as it is drawn.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Ruler {
    scale: Scale,
    range: Range<f64>,
    ticks: Vec<f64>,
    step: f64,
}

/// Whether the ends of an axis are those of the data.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Ends {
    /// They are: nothing is left free beside a history.
    Tight,
    /// Something is left free.
    Loose,
}

impl Ruler {
    /// An axis for all values that can be drawn on it; from 0 to 1 (or 1 to 10) if there is none.
    pub(super) fn around(
        values: impl Iterator<Item = f64>,
        scale: Scale,
        ends: Ends,
        tick_count: usize,
    ) -> Self {
        let (least, most) = values.filter(|value| is_drawable(*value, scale)).fold(
            (f64::INFINITY, f64::NEG_INFINITY),
            |(least, most), value| (least.min(value), most.max(value)),
        );
        match scale {
            Scale::Linear => Self::linear(least, most, ends, tick_count),
            Scale::Logarithmic => Self::logarithmic(least, most, ends, tick_count),
        }
    }

    fn linear(least: f64, most: f64, ends: Ends, tick_count: usize) -> Self {
        let (mut least, mut most) = if least <= most {
            (least, most)
        } else {
            (0.0, 1.0)
        };
        // Halves, because the difference of the largest numbers overflows.
        let half = 0.5 * most - 0.5 * least;
        let size = least.abs().max(most.abs());
        if half <= 1e-12 * size || half == 0.0 {
            let room = if size > 0.0 { 0.05 * size } else { 1.0 };
            (least, most) = (least - room, most + room);
        } else if ends == Ends::Loose {
            (least, most) = (least - 2.0 * MARGIN * half, most + 2.0 * MARGIN * half);
        }
        let step = round_step((most - least) / tick_count.max(1) as f64);
        let first = (least / step).ceil();
        let count = ((most / step).floor() - first) as usize;
        Self {
            scale: Scale::Linear,
            range: least..most,
            ticks: (0..=count)
                .map(|index| (first + index as f64) * step)
                .collect(),
            step,
        }
    }

    /// Ends at 1, 2 or 5 times a power of ten; ticks at the powers, and within one or two decades at 2 and 5 times them.
    fn logarithmic(least: f64, most: f64, ends: Ends, tick_count: usize) -> Self {
        let (least, most) = if least <= most {
            (least, most)
        } else {
            (1.0, 10.0)
        };
        let (first, last) = (least.log10().floor() as i32, most.log10().ceil() as i32);
        let rounds = |exponent: i32| [1.0, 2.0, 5.0].map(|factor| factor * power(exponent));
        let all = || (first - 1..=last).flat_map(rounds);
        let start = all().filter(|end| *end <= least).fold(0.0, f64::max);
        let end = all().filter(|end| *end >= most && *end > start);
        let end = end.fold(f64::INFINITY, f64::min);
        let decades = (last - first).unsigned_abs() as usize;
        let ticks: Vec<f64> = match decades <= 2 {
            true => all().collect(),
            false => {
                let stride = decades.div_ceil(tick_count.max(1));
                (first..=last).step_by(stride).map(power).collect()
            }
        };
        let ticks = (ticks.into_iter())
            .filter(|tick| (start..=end).contains(tick))
            .collect();
        let mut range = start..end;
        if ends == Ends::Loose {
            let room = (end / start).powf(LOGARITHMIC_MARGIN);
            if least < start * room {
                range.start /= room;
            }
            if most > end / room {
                range.end *= room;
            }
        }
        Self {
            scale: Scale::Logarithmic,
            ticks,
            range,
            step: 0.0,
        }
    }

    /// Whether a value has a place on an axis of this kind.
    pub(super) fn shows(&self, value: f64) -> bool {
        is_drawable(value, self.scale)
    }

    /// Whether a value lies between the ends.
    pub(super) fn contains(&self, value: f64) -> bool {
        self.shows(value) && value >= self.range.start && value <= self.range.end
    }

    /// Linear or logarithmic.
    pub(super) fn scale(&self) -> Scale {
        self.scale
    }

    /// First and last value.
    pub(super) fn ends(&self) -> [f64; 2] {
        [self.range.start, self.range.end]
    }

    /// Place of a value between the ends, 0 to 1.
    pub(super) fn fraction(&self, value: f64) -> f64 {
        let Range { start, end } = self.range;
        match self.scale {
            Scale::Linear => (value - start) / (end - start),
            Scale::Logarithmic => (value / start).ln() / (end / start).ln(),
        }
    }

    /// Number of characters of the longest tick label.
    pub(super) fn label_length(&self) -> usize {
        let lengths = self
            .ticks
            .iter()
            .map(|tick| self.label(*tick).chars().count());
        lengths.max().unwrap_or(0)
    }

    /// Whether ticks stand within the decades too, and none of them needs a power of ten.
    fn has_plain_steps(&self) -> bool {
        let is_power = |tick: &f64| (tick.log10() - tick.log10().round()).abs() < 1e-9;
        !self.ticks.iter().all(is_power) && self.ticks.iter().all(|tick| PLAIN.contains(tick))
    }

    fn label(&self, value: f64) -> String {
        match self.scale {
            Scale::Logarithmic if self.has_plain_steps() => {
                let decimals = (-(value * (1.0 + 1e-9)).log10().floor()).max(0.0) as usize;
                format!("{value:.decimals$}")
            }
            Scale::Logarithmic => scientific(value, 0),
            Scale::Linear => {
                let size = self
                    .ticks
                    .iter()
                    .fold(0.0, |most: f64, tick| most.max(tick.abs()));
                if value.abs() < 1e-6 * self.step {
                    return "0".to_owned();
                }
                if PLAIN.contains(&size) {
                    let decimals = (-self.step.log10().floor()).clamp(0.0, 12.0) as usize;
                    return format!("{value:.decimals$}").replace('-', "\u{2212}");
                }
                // As many digits as tell neighbouring ticks apart.
                let digits = value.abs().log10().floor() - self.step.log10().floor();
                scientific(value, digits.clamp(0.0, 12.0) as usize)
            }
        }
    }
}

impl Ranged for Ruler {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        let (from, to) = (f64::from(limit.0), f64::from(limit.1));
        (from + self.fraction(*value) * (to - from)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        // The grid's light lines would only repeat the bold ones.
        match hint.weight().allow_light_points() {
            true => Vec::new(),
            false => self.ticks.clone(),
        }
    }

    fn range(&self) -> Range<f64> {
        self.range.clone()
    }
}

impl ValueFormatter<f64> for Ruler {
    fn format_ext(&self, value: &f64) -> String {
        self.label(*value)
    }
}

fn is_drawable(value: f64, scale: Scale) -> bool {
    match scale {
        Scale::Linear => value.abs() < LARGEST,
        Scale::Logarithmic => value > SMALLEST && value < LARGEST,
    }
}

fn power(exponent: i32) -> f64 {
    10f64.powi(exponent)
}

/// 1, 2 or 5 times a power of ten, not less than `least`.
fn round_step(least: f64) -> f64 {
    let decade = 10f64.powf(least.log10().floor()).max(f64::MIN_POSITIVE);
    let factors = [1.0, 2.0, 5.0, 10.0];
    let factor = factors
        .into_iter()
        .find(|factor| factor * decade >= least * (1.0 - 1e-9));
    factor.unwrap_or(10.0) * decade
}

/// `−2.5×10⁻³`, `10⁴`.
fn scientific(value: f64, digits: usize) -> String {
    let text = format!("{value:.digits$e}");
    let (mantissa, exponent) = text.split_once('e').unwrap_or((&text, "0"));
    let raised: String = exponent
        .chars()
        .map(|character| match character {
            '-' => '⁻',
            '1' => '¹',
            '2' => '²',
            '3' => '³',
            digit => char::from_u32(0x2070 + digit.to_digit(10).unwrap_or(0)).unwrap_or(digit),
        })
        .collect();
    let sign = if mantissa.starts_with('-') {
        "\u{2212}"
    } else {
        ""
    };
    match (mantissa.trim_start_matches('-'), exponent) {
        ("1", "0") => format!("{sign}1"),
        ("1", _) => format!("{sign}10{raised}"),
        (mantissa, "0") => format!("{sign}{mantissa}"),
        (mantissa, _) => format!("{sign}{mantissa}×10{raised}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(ruler: &Ruler) -> Vec<String> {
        ruler.ticks.iter().map(|tick| ruler.label(*tick)).collect()
    }

    #[test]
    fn ticks_are_round_and_told_apart() {
        let around = |least: f64, most: f64| {
            Ruler::around([least, most].into_iter(), Scale::Linear, Ends::Tight, 5)
        };
        assert_eq!(
            labels(&around(0.0, 0.0838)),
            ["0.00", "0.02", "0.04", "0.06", "0.08"].map(|text| text.replace("0.00", "0"))
        );
        assert_eq!(
            labels(&around(-1.0, 1.0)),
            ["\u{2212}1.0", "\u{2212}0.5", "0", "0.5", "1.0"]
        );
        assert_eq!(
            labels(&around(0.0, 4e-6)),
            ["0", "1×10⁻⁶", "2×10⁻⁶", "3×10⁻⁶", "4×10⁻⁶"].map(|text| text.replace("1×", ""))
        );
        for (least, most) in [
            (3.0, 3.0),
            (0.0, 0.0),
            (9e299, -9e299),
            (f64::MAX, f64::MIN),
            (1.0, 1.0 + 1e-9),
        ] {
            let ruler = around(least.min(most), least.max(most));
            let distinct: std::collections::BTreeSet<_> = labels(&ruler).into_iter().collect();
            assert!(
                ruler.ticks.len() >= 2 && ruler.ticks.len() < 20,
                "{ruler:?}"
            );
            assert_eq!(distinct.len(), ruler.ticks.len(), "{distinct:?}");
        }
    }

    #[test]
    fn logarithmic_ticks_are_powers_of_ten() {
        let values = [f64::NAN, -1.0, 0.0, 3e-5, 0.2];
        let ruler = Ruler::around(values.into_iter(), Scale::Logarithmic, Ends::Tight, 6);
        assert_eq!(labels(&ruler), ["10⁻⁴", "10⁻³", "10⁻²", "10⁻¹"]);
        assert!((ruler.fraction(2e-3) - 0.5).abs() < 1e-12);
    }

    #[test]
    fn within_a_decade_ticks_are_plain_numbers() {
        let around = |values: [f64; 2]| {
            Ruler::around(values.into_iter(), Scale::Logarithmic, Ends::Loose, 6)
        };
        assert_eq!(labels(&around([0.3, 4.0])), ["0.2", "0.5", "1", "2", "5"]);
        assert_eq!(labels(&around([3e-6, 6e-6])), ["2×10⁻⁶", "5×10⁻⁶", "10⁻⁵"]);
    }

    #[test]
    fn a_mark_at_a_tick_stands_off_the_end_of_a_loose_axis() {
        let values = || [5.0, 52.0, 100.0].into_iter();
        let loose = Ruler::around(values(), Scale::Logarithmic, Ends::Loose, 6);
        assert!(loose.fraction(5.0) > 0.02 && loose.fraction(100.0) < 0.98);
        assert_eq!(labels(&loose), ["5", "10", "20", "50", "100"]);
        let tight = Ruler::around(values(), Scale::Logarithmic, Ends::Tight, 6);
        assert_eq!(tight.ends(), [5.0, 100.0]);
    }
}
