//! The further columns that one reduction of a study has.

use std::fmt;
use std::str::FromStr;

use clap::ValueEnum as _;
use serde::{Deserialize, Serialize};

use dcb_reducer::EnrichmentSource;

/// Sources of further columns, each once, in the order of columns; there may be none.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Sources(Vec<EnrichmentSource>);

impl Sources {
    /// These.
    pub fn of(sources: &[EnrichmentSource]) -> Self {
        let mut sources = sources.to_vec();
        sources.sort_unstable();
        sources.dedup();
        Self(sources)
    }

    /// Each of them.
    pub fn as_slice(&self) -> &[EnrichmentSource] {
        &self.0
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

/// `spin+krylov`, or `none`.
impl fmt::Display for Sources {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names: Vec<&str> = self.0.iter().map(|source| source.name()).collect();
        match names.as_slice() {
            [] => formatter.write_str("none"),
            names => formatter.write_str(&names.join("+")),
        }
    }
}

impl FromStr for Sources {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text == "none" {
            return Ok(Self::default());
        }
        let source = |name| {
            EnrichmentSource::from_str(name, false).map_err(|_| {
                "spin, loads, krylov, several of them joined as in spin+krylov, or none are wanted"
                    .to_owned()
            })
        };
        let sources: Vec<EnrichmentSource> =
            text.split('+').map(source).collect::<Result<_, _>>()?;
        Ok(Self::of(&sources))
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn names_are_read_back_in_one_order() {
        for (text, name) in [
            ("krylov", "krylov"),
            ("krylov+spin", "spin+krylov"),
            ("spin+loads+spin", "spin+loads"),
            ("none", "none"),
        ] {
            assert_eq!(text.parse::<Sources>().unwrap().to_string(), name);
        }
        for text in ["", "spins", "spin+", "none+spin", "Spin"] {
            assert!(text.parse::<Sources>().is_err(), "{text}");
        }
    }
}
