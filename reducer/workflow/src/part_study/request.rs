//! What is asked of a study, before the part is known.

use dcb_formats::Component;
use dcb_formats::component::{Interface, Role};
use dcb_formats::units::si_factor;
use dcb_reducer::EnrichmentSource;
use dcb_reducer::error::{CommandRefusal, Error, Lacking};
use dcb_reducer::model::condensation::Model;
use dcb_reducer::resources::memory_limit::MemoryLimit;
use serde::Deserialize;

use crate::shard::Shard;

use super::ComponentStudy;
use super::reference::BandChoice;
use super::sources::Sources;
use super::sweep::Sweep;
use super::variant::Variant;

/// Reductions to compare, and where.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct StudyRequest {
    /// Numbers of modes; 5, 10, 20 and 40 where nothing is said.
    pub modes: Option<Vec<usize>>,
    /// Forms of use.
    pub variants: Vec<Variant>,
    /// Numbers of interface modes, beside all of them.
    pub interface_modes: Vec<usize>,
    /// Further columns of strong rows, beside none; the second Krylov block where nothing is said.
    pub enrich: Option<Vec<Sources>>,
    /// Band of frequencies, Hz; up to half the highest mode where nothing is said.
    pub band: Option<[f64; 2]>,
    /// Points of the band; resonances are added.
    pub points: usize,
    /// Structural loss factor η of the responses compared.
    pub loss_factor: f64,
}

impl Default for StudyRequest {
    fn default() -> Self {
        Self {
            modes: None,
            variants: Variant::ALL.to_vec(),
            interface_modes: Vec::new(),
            enrich: None,
            band: None,
            points: 400,
            loss_factor: 0.02,
        }
    }
}

impl StudyRequest {
    /// The study of a part.
    ///
    /// # Errors
    /// [`Error::Lacking`] for a part without interfaces or the loads asked for, [`Error::Command`] for further columns without the strong form
    /// and for a band in Hz of a part whose unit of time isn't known.
    pub fn study(
        &self,
        component: &Component,
        memory: MemoryLimit,
    ) -> Result<ComponentStudy, Error> {
        let acts = |interface: &Interface| interface.role == Role::Attachment;
        if component.explicit_boundary.is_none() && !component.interfaces.iter().any(acts) {
            return Err(Lacking::Interfaces.into());
        }
        let modes = match &self.modes {
            Some(modes) => modes.clone(),
            None => {
                let elastic = Model::of(component)?
                    .len()
                    .saturating_sub(component.dimension().rigid_mode_count());
                Sweep::default_modes(elastic)
            }
        };
        Ok(ComponentStudy {
            sweep: Sweep {
                modes,
                variants: self.variants.clone(),
                interface_modes: self.interface_modes.clone(),
                enrichments: self.enrichments(component)?,
            },
            band: self.band_choice(component)?,
            points: self.points,
            shard: Shard::WHOLE,
            loss_factor: self.loss_factor,
            memory,
        })
    }

    fn band_choice(&self, component: &Component) -> Result<BandChoice, Error> {
        let Some([from, to]) = self.band else {
            return Ok(BandChoice::HalfOfHighest);
        };
        let unit = &component.units.time;
        let second = si_factor(unit).ok_or_else(|| CommandRefusal::UnknownTimeUnit {
            option: "--band",
            unit: unit.clone(),
            remedy: "leave --band out",
        })?;
        let square = |hertz: f64| (2.0 * std::f64::consts::PI * hertz * second).powi(2);
        Ok(BandChoice::Between {
            from: square(from),
            to: square(to),
        })
    }

    fn enrichments(&self, component: &Component) -> Result<Vec<Sources>, Error> {
        let Some(asked) = &self.enrich else {
            return Ok(vec![Sources::of(&[EnrichmentSource::Krylov])]);
        };
        for source in asked.iter().flat_map(Sources::as_slice) {
            source.check(component)?;
        }
        let further = asked.iter().any(|sources| !sources.is_empty());
        if further && !self.variants.contains(&Variant::Strong) {
            return Err(CommandRefusal::EnrichWithoutStrong.into());
        }
        Ok(asked.clone())
    }
}
