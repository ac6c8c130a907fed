//! Frequencies at which responses are computed.

use dcb_formats::scene::{Frequencies, FrequencyRange, Spacing};

use super::transfer::Resonance;

/// Points at a resonance.
const AT_RESONANCE: usize = 21;
/// How many half-power widths they cover.
const WIDTHS: f64 = 10.0;
/// Least width of a resonance as a part of its frequency: an undamped one has none.
const LEAST: f64 = 1e-4;

/// Ratios to critical below this are rounding.
const UNDAMPED: f64 = 1e-10;

/// The frequencies that are asked for, ascending; more at resonances where that is asked for.
pub(super) fn frequencies(asked: &Frequencies, resonances: &[Resonance]) -> Vec<f64> {
    let range = match asked {
        Frequencies::List(list) => return list.clone(),
        Frequencies::Range(range) => range,
    };
    let mut all = spread(range);
    if range.spacing == Spacing::Resonances {
        for resonance in resonances {
            let width = 2.0 * resonance.ratio.abs().max(LEAST) * resonance.frequency;
            for point in 0..AT_RESONANCE {
                // Closer to the peak than at the ends.
                let place = 2.0 * point as f64 / (AT_RESONANCE - 1) as f64 - 1.0;
                // Nothing is finite at the peak of an undamped one.
                if place == 0.0 && resonance.ratio.abs() < UNDAMPED {
                    continue;
                }
                let frequency = resonance.frequency + 0.5 * WIDTHS * width * place * place.abs();
                if frequency > range.from && frequency < range.to {
                    all.push(frequency);
                }
            }
        }
        all.sort_by(f64::total_cmp);
        all.dedup_by(|a, b| (*a - *b).abs() <= 1e-12 * a.abs());
    }
    all
}

fn spread(range: &FrequencyRange) -> Vec<f64> {
    let last = (range.count - 1) as f64;
    let at = |k: u32| {
        let share = f64::from(k) / last;
        match range.spacing {
            Spacing::Logarithmic => range.from * (range.to / range.from).powf(share),
            Spacing::Linear | Spacing::Resonances => range.from + share * (range.to - range.from),
        }
    };
    (0..range.count)
        .map(|k| {
            if k + 1 == range.count {
                range.to
            } else {
                at(k)
            }
        })
        .collect()
}
