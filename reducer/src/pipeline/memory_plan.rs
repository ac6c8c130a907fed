//! How one reduction gets by with the memory that it may take: where the factor goes, how large the Krylov basis is, whether there is room for
//! the columns of an error estimate.

use dcb_sparse::factor_store::{FactorStorage, Place};
use dcb_sparse::factorization::SymmetricFactor;

use crate::error::Error;
use crate::observer::Observer;
use crate::pipeline::free_body::FreeBody;
use crate::pipeline::reduction::Reduction;
use crate::resources::forecast::{EstimateChoice, Forecast};
use crate::resources::memory_limit::MemoryLimit;
use dcb_formats::units::readable;

/// A limit, and what a reduction needs of it.
pub(crate) struct MemoryPlan<'a> {
    limit: &'a MemoryLimit,
    estimate: EstimateChoice,
    /// Need with as much as fits.
    forecast: Forecast,
}

impl<'a> MemoryPlan<'a> {
    /// Of a body whose factor has been analysed.
    pub fn of(options: &'a Reduction, body: &FreeBody<'_>, factor: &SymmetricFactor) -> Self {
        let (limit, estimate) = (&options.memory, options.estimate);
        let forecast = Forecast::of(&body.model, &body.localization, factor, options.modes);
        Self {
            limit,
            estimate,
            forecast: limit.fitted(Forecast {
                estimate,
                ..forecast
            }),
        }
    }

    /// Tells the forecast and puts the factor where it fits; returns what to say where that is on disk unasked.
    ///
    /// # Errors
    /// [`Error::NotEnoughMemory`]; ranks that can't be started.
    pub fn place(
        &self,
        factor: &mut SymmetricFactor,
        observer: &mut dyn Observer,
    ) -> Result<Option<String>, Error> {
        observer.forecast(&self.forecast, self.limit);
        let storage = self.limit.choose(&self.forecast)?;
        let warning = self.short_of_memory(&storage);
        factor.keep_in(storage, self.limit.fallback(&self.forecast))?;
        Ok(warning)
    }

    /// The forecast with as much as fits, now that the number of modes is known.
    pub fn for_modes(&self, modes: usize) -> Forecast {
        self.limit.fitted(Forecast {
            modes,
            estimate: self.estimate,
            ..self.forecast
        })
    }

    fn short_of_memory(&self, storage: &FactorStorage) -> Option<String> {
        let (forecast, in_memory) = (&self.forecast, FactorStorage::default());
        match (&storage.place, self.limit.bytes) {
            (Place::Disk { folder }, Some(bytes)) if !self.limit.allows(forecast, &in_memory) => {
                Some(format!(
                    "the factor ({}) was kept on disk in {}: with it in memory about {} would be needed, and {} may be taken; results are the same",
                    readable(forecast.factor_bytes(storage)),
                    folder.display(),
                    readable(forecast.peak_bytes(&in_memory)),
                    readable(bytes)
                ))
            }
            _ => None,
        }
    }
}
