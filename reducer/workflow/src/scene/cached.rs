//! Reductions of a search, taken from the cache where they, or such with more modes, were made before.

use std::f64::consts::TAU;
use std::time::Instant;

use dcb_formats::dcb::Contents;
use serde_json::{Value, json};

use super::component_demand::ComponentDemand;
use crate::cache::{Cache, Claim, Entry, ModeRequest, Request};
use dcb_formats::units::si_factor;
use dcb_reducer::ModeSelection;
use dcb_reducer::Reduced;
use dcb_reducer::Reduction;
use dcb_reducer::Work;
use dcb_reducer::error::Error;
use dcb_reducer::observer::Observer;
use dcb_reducer::reduce;

/// A cache for the reductions of one part.
#[derive(Debug)]
pub struct CachedReductions<'c> {
    /// Where they are.
    pub cache: &'c Cache,
    /// The part's files and options; modes and further columns are those of each reduction.
    pub request: Request,
}

impl CachedReductions<'_> {
    /// The reduction, or one with more modes. Where the cache can't be used the reduction is made without it.
    ///
    /// # Errors
    /// Those of [`reduce`].
    pub fn reduced(
        &self,
        asked: &ComponentDemand,
        options: &Reduction,
        observer: &mut dyn Observer,
    ) -> Result<Reduced, Error> {
        let component = &asked.component;
        let Some(request) = self.request(asked, options) else {
            return reduce(component, options, observer);
        };
        let larger = self.cache.find_at_least(&request);
        let wanted = larger.map_or_else(|| request.clone(), |listed| listed.record.request);
        let reservation = match self.cache.claim(&wanted, || {}) {
            Ok(Claim::Found(entry)) => match taken(&entry) {
                Some(reduced) => return Ok(reduced),
                None => None,
            },
            Ok(Claim::Missing(reservation)) if wanted == request => Some(reservation),
            Ok(Claim::Missing(_)) | Err(_) => None,
        };
        let clock = Instant::now();
        let mut reduced = reduce(component, options, observer)?;
        if let Some(reservation) = reservation
            && request.is_of(&component.sources)
            && reduced.quality.broken_limits().is_empty()
        {
            let quality = serde_json::to_value(&reduced.quality).unwrap_or_default();
            reduced.superelement.provenance.quality = quality;
            let contents = Contents {
                superelement: &reduced.superelement,
                recovery: Some(&reduced.recovery),
                mesh: Some(&component.mesh),
            };
            // A full disk costs the next scene time, and this one nothing.
            let _ = reservation.store(&contents, clock.elapsed().as_secs_f64());
        }
        Ok(reduced)
    }

    /// `None` for modes that no request can name.
    fn request(&self, asked: &ComponentDemand, options: &Reduction) -> Option<Request> {
        let modes = match options.modes {
            ModeSelection::Lowest(count) => ModeRequest::Lowest(count),
            ModeSelection::Below { eigenvalue } => {
                let second = si_factor(&asked.component.units.time)?;
                ModeRequest::BelowHertz(eigenvalue.sqrt() / TAU / second)
            }
            ModeSelection::BelowAtMost { .. } => return None,
        };
        let mut request = Request {
            modes,
            options: options.decisive(),
            ..self.request.clone()
        };
        let mut say = |name: &str, value: Value| request.options.insert(name.to_owned(), value);
        say("watched_nodes", json!(asked.watched_nodes()));
        let loads = asked.component.loads.iter().map(|load| &load.name);
        say("loads", loads.map(|name| json!(name)).collect());
        Some(request)
    }
}

/// Contents of an entry; `None` if it has no report of its quality or no fields.
fn taken(entry: &Entry) -> Option<Reduced> {
    let superelement = entry.file.superelement().ok()?;
    let quality = serde_json::from_value(superelement.provenance.quality.clone()).ok()?;
    let recovery = entry.file.recovery().ok()??;
    Some(Reduced {
        superelement,
        recovery,
        quality,
        work: Work::default(),
    })
}
