//! Loads that further columns of the basis respond to, as options, manifests and files name it.

use clap::ValueEnum;
use dcb_formats::component::Component;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::error::{Error, Lacking};

/// Loads that further columns respond to.
#[derive(
    Clone,
    Copy,
    Debug,
    PartialEq,
    Eq,
    PartialOrd,
    Ord,
    Serialize,
    Deserialize,
    ValueEnum,
    JsonSchema,
)]
#[serde(rename_all = "lowercase")]
#[schemars(rename = "Enrichment")]
pub enum EnrichmentSource {
    /// Centrifugal forces: six patterns in space, one in the plane.
    Spin,
    /// The component's named loads.
    Loads,
    /// The second Krylov block of the interfaces.
    Krylov,
}

impl EnrichmentSource {
    /// All, in the order of columns.
    pub const ALL: [Self; 3] = [Self::Spin, Self::Loads, Self::Krylov];

    /// Name in options and files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Spin => "spin",
            Self::Loads => "loads",
            Self::Krylov => "krylov",
        }
    }

    /// Refuses what the component has nothing for.
    ///
    /// # Errors
    /// [`Error::Lacking`] if loads are asked for and there are none.
    pub fn check(self, component: &Component) -> Result<(), Error> {
        if self == Self::Loads && component.loads.is_empty() {
            return Err(Lacking::Loads.into());
        }
        Ok(())
    }
}
