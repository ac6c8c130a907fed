//! Damping of a component.

use super::fault::{ComponentFault, fault};

const MODAL: &str = "component.damping.modal";

/// Damping as the component states it.
#[derive(Clone, Debug, PartialEq)]
pub enum Damping {
    /// None given.
    None,
    /// The same ratio to critical for every mode.
    Uniform(f64),
    /// One ratio per mode; the last holds for any further ones and for the attachments.
    PerMode(Vec<f64>),
    /// Rayleigh: `C = alpha M + beta K`, alpha in 1/time, beta in time.
    Rayleigh {
        /// Mass factor.
        alpha: f64,
        /// Stiffness factor.
        beta: f64,
    },
}

impl Damping {
    /// Ratios and factors are numbers of zero or more, and there is one at least.
    ///
    /// # Errors
    /// The first that isn't, by its key in the component file.
    pub(crate) fn check(&self) -> Result<(), ComponentFault> {
        match self {
            Self::None => Ok(()),
            Self::Uniform(ratio) => check_ratio(MODAL, *ratio),
            Self::PerMode(ratios) if ratios.is_empty() => Err(fault(
                MODAL,
                "is an empty list; expected at least one ratio",
            )),
            Self::PerMode(ratios) => (ratios.iter().enumerate())
                .try_for_each(|(mode, ratio)| check_ratio(&format!("{MODAL}[{mode}]"), *ratio)),
            Self::Rayleigh { alpha, beta } => {
                for (index, factor) in [alpha, beta].into_iter().enumerate() {
                    if !(*factor >= 0.0 && factor.is_finite()) {
                        return Err(fault(
                            format!("component.damping.rayleigh[{index}]"),
                            format!("is {factor}, expected a factor >= 0"),
                        ));
                    }
                }
                Ok(())
            }
        }
    }

    /// Notes on ratios that may be meant in percent.
    pub(crate) fn above_critical(&self) -> Vec<String> {
        let note = |location: String, ratio: f64| {
            let text = "more than critical damping: a ratio is meant, not percent";
            (ratio > 1.0).then(|| format!("{location} is {ratio}, {text}"))
        };
        match self {
            Self::Uniform(ratio) => note(MODAL.to_owned(), *ratio).into_iter().collect(),
            Self::PerMode(ratios) => (ratios.iter().enumerate())
                .filter_map(|(mode, ratio)| note(format!("{MODAL}[{mode}]"), *ratio))
                .collect(),
            Self::None | Self::Rayleigh { .. } => Vec::new(),
        }
    }

    /// `[alpha, beta]` of the Rayleigh damping with these ratios to critical at these frequencies, in cycles per time:
    /// `2 ζ ω = alpha + beta ω²` at both.
    ///
    /// # Errors
    /// Found and expected, for numbers that no Rayleigh damping with alpha and beta of zero or more goes through.
    pub fn rayleigh_through(frequencies: [f64; 2], ratios: [f64; 2]) -> Result<[f64; 2], String> {
        if let Some(found) = frequencies.iter().find(|f| !(**f > 0.0 && f.is_finite())) {
            return Err(format!(
                "has the frequency {found}, expected frequencies above 0 in cycles per time"
            ));
        }
        if let Some(found) = ratios.iter().find(|z| !(**z >= 0.0 && z.is_finite())) {
            return Err(format!("has the ratio {found}, expected ratios >= 0"));
        }
        let [first, second] = frequencies.map(|frequency| std::f64::consts::TAU * frequency);
        if first == second {
            return Err(format!(
                "has the frequency {} twice, expected two that differ",
                frequencies[0]
            ));
        }
        let [at_first, at_second] = ratios;
        let square = second * second - first * first;
        let factors = [
            2.0 * first * second * (at_first * second - at_second * first) / square,
            2.0 * (at_second * second - at_first * first) / square,
        ];
        // A ratio that is just proportional to the frequency, or its inverse, has a factor of zero.
        let sizes = [
            at_first * second + at_second * first,
            at_second * second + at_first * first,
        ];
        let scales = [2.0 * first * second / square, 2.0 / square];
        let mut rounded = factors;
        for ((factor, size), scale) in rounded.iter_mut().zip(sizes).zip(scales) {
            if factor.abs() <= 1e-12 * size * scale.abs() {
                *factor = 0.0;
            }
        }
        match rounded.iter().position(|factor| *factor < 0.0) {
            None => Ok(rounded),
            Some(which) => {
                let span = frequencies[1] / frequencies[0];
                let [least, most] = if span > 1.0 {
                    [1.0 / span, span]
                } else {
                    [span, 1.0 / span]
                };
                Err(format!(
                    "needs {} = {:.4e}, which would feed energy in: with these frequencies the second ratio must be {:.4e} to {:.4e} of the first, but is {:.4e} of it",
                    ["alpha", "beta"][which],
                    rounded[which],
                    least,
                    most,
                    at_second / at_first
                ))
            }
        }
    }
}

fn check_ratio(location: &str, ratio: f64) -> Result<(), ComponentFault> {
    if ratio >= 0.0 && ratio.is_finite() {
        return Ok(());
    }
    Err(fault(
        location,
        format!("is {ratio}, expected a ratio to critical damping >= 0 (0.01 is 1 %)"),
    ))
}
