//! The basis of a reduction from one factorization: free-free modes Φ, attachments G_res L_bᵀ, further columns X, and the moments of
//! what they leave out. It is searched for again, more widely or with a more accurate factor, until no mode is missing.

use dcb_formats::superelement::Moments;
use dcb_sparse::factorization::{PositiveFactor, SymmetricFactor, Unfactorized};
use faer::Mat;

use crate::attachments::enrichment::FurtherColumns;
use crate::attachments::interface_reduction::InterfaceModes;
use crate::attachments::omitted_stress::omitted_stress;
use crate::attachments::residual::ResidualFlexibility;
use crate::error::Error;
use crate::mode_selection::ModeSelection;
use crate::model::regularization::Regularization;
use crate::modes::certificate::ModeCount;
use crate::modes::free_modes::{FreeModes, KnownMotions, Search};
use crate::moments::PowerMoments;
use crate::observer::{Observer, Stage};
use crate::pipeline::diagnosis::{LoosePieces, Support, loose, unfactorized};
use crate::pipeline::free_body::{FreeBody, Spectrum};
use crate::pipeline::memory_plan::MemoryPlan;
use crate::pipeline::reduction::Reduction;
use crate::resources::forecast::EstimateChoice;

/// Searches made, each wider than the one before, until none is missing.
const ATTEMPTS: usize = 3;

/// The columns Ψ = [Φ, G_res L_bᵀ, X].
pub(crate) struct Basis {
    pub modes: FreeModes,
    pub residual: ResidualFlexibility,
    pub further: Option<FurtherColumns>,
    pub moments: Option<Moments>,
    /// Why there are none, where they are wanted.
    pub missing_moments: Option<String>,
    /// What the modes leave out of each field's stress rows.
    pub omitted_stress: Option<Vec<Vec<f64>>>,
    pub mode_count: ModeCount,
}

impl Basis {
    /// With as many directions of residual flexibility as are to be kept.
    ///
    /// # Errors
    /// [`Error::NotFinite`] if an eigenproblem fails.
    pub fn keeping(self, which: InterfaceModes, body: &FreeBody<'_>) -> Result<Self, Error> {
        let residual = match which {
            InterfaceModes::All => self.residual,
            InterfaceModes::Softest(wanted) => {
                let (model, localization) = (&body.model, &body.localization);
                (self.residual).keeping(wanted, model, localization, &self.modes)?
            }
        };
        Ok(Self { residual, ..self })
    }
}

/// A search for a basis.
pub(crate) struct BasisSearch<'a> {
    body: &'a FreeBody<'a>,
    spectrum: &'a Spectrum,
    memory: &'a MemoryPlan<'a>,
    options: &'a Reduction,
}

/// Results of one factorization beside the modes; moments that are wanted and can't be had, with the reason.
struct Columns {
    residual: ResidualFlexibility,
    further: Option<FurtherColumns>,
    moments: Result<Option<PowerMoments>, String>,
    omitted_stress: Option<Vec<Vec<f64>>>,
}

impl<'a> BasisSearch<'a> {
    /// Of a body that has settled.
    pub fn new(
        body: &'a FreeBody<'a>,
        spectrum: &'a Spectrum,
        memory: &'a MemoryPlan<'a>,
        options: &'a Reduction,
    ) -> Self {
        Self {
            body,
            spectrum,
            memory,
            options,
        }
    }

    /// A basis with no mode missing.
    ///
    /// # Errors
    /// Loose pieces where they are refused, and numerical failures.
    pub fn certified(
        &self,
        factor: &mut SymmetricFactor,
        observer: &mut dyn Observer,
    ) -> Result<Basis, Error> {
        let FreeBody { model, rigid, .. } = self.body;
        let scale = &self.spectrum.scale;
        let wanted = self.wanted(factor, observer)?;
        let room = self.memory.for_modes(wanted);
        let loose = self.loose_motions()?;
        let (mut copies, mut last_count) = (0, None);
        let mut regularization = self.regularization();
        let mut attempt = 0;
        while attempt < ATTEMPTS {
            observer.enter(Stage::Factor)?;
            let positive = match regularization.factorize(model, factor) {
                Ok(positive) => positive,
                Err(Unfactorized::NotPositive) if regularization.is_exact() => {
                    regularization = Regularization::by_shift(scale);
                    continue;
                }
                Err(why) => return Err(unfactorized(model, scale, factor, why)),
            };
            let search = Search {
                wanted,
                attempt,
                copies,
                basis: room.basis,
                mass_part: self.body.mass_part,
            };
            let shift = regularization.shift();
            let modes = self.modes(&positive, shift, &loose, search, observer);
            if regularization.is_exact() && self.has_soft_motion(&modes) {
                regularization = Regularization::by_shift(scale);
                continue;
            }
            if let Ok(modes) = &modes {
                self.refuse(modes, wanted)?;
            }
            let found = modes.and_then(|modes| {
                let columns = self.columns(&modes, &positive, shift, room.estimate, observer)?;
                Ok((modes, columns))
            });
            let refined = positive.least_accurate();
            if !refined.is_accurate() {
                factor.keep_in_double(refined);
                attempt += 1;
                continue;
            }
            let (modes, columns) = found?;
            observer.enter(Stage::Certificate)?;
            factor.release();
            let mode_count = ModeCount::of(model, rigid, &modes, factor, self.options.proof)?;
            if mode_count.counted == mode_count.found {
                return Ok(columns.certified(modes, mode_count));
            }
            let missed = mode_count.counted.saturating_sub(mode_count.found);
            copies = copies.max(modes.largest_multiplicity() + missed);
            last_count = Some(mode_count);
            attempt += 1;
        }
        Err(Error::ModesMissed {
            found: last_count.map_or(0, |last| last.found),
            counted: last_count.map_or(0, |last| last.counted),
            limit: last_count.and_then(|last| last.limit).unwrap_or(0.0),
        })
    }

    /// How many elastic modes are asked for.
    fn wanted(
        &self,
        factor: &mut SymmetricFactor,
        observer: &mut dyn Observer,
    ) -> Result<usize, Error> {
        let FreeBody { model, rigid, .. } = self.body;
        let mut below = |eigenvalue: f64| -> Result<usize, Error> {
            observer.enter(Stage::Certificate)?;
            let inertia = factor.inertia(&model.stiffness, &model.mass, eigenvalue)?;
            Ok(inertia.negative.saturating_sub(rigid.count()))
        };
        match self.options.modes {
            ModeSelection::Lowest(count) => Ok(count),
            ModeSelection::Below { eigenvalue } => below(eigenvalue),
            ModeSelection::BelowAtMost { eigenvalue, count } => Ok(below(eigenvalue)?.min(count)),
        }
    }

    /// Rigid motions of single pieces, (n_c, l), where they may be: the first modes.
    fn loose_motions(&self) -> Result<Mat<f64>, Error> {
        let FreeBody { model, rigid, .. } = self.body;
        match (
            self.options.loose_pieces,
            self.body.support,
            &self.spectrum.pieces.motions,
        ) {
            (LoosePieces::Allow, Support::Free, Some(motions)) => motions.beyond(rigid),
            _ => Ok(Mat::zeros(model.len(), 0)),
        }
    }

    /// Springs that hold the rigid motions; a shift where pieces are loose.
    fn regularization(&self) -> Regularization {
        let FreeBody { model, rigid, .. } = self.body;
        let scale = &self.spectrum.scale;
        match self.spectrum.pieces.motions {
            Some(_) => Regularization::by_shift(scale),
            None => Regularization::by_supports(model, rigid, scale),
        }
    }

    /// Whether a motion was found that may have no stiffness, or none can be relied on.
    fn has_soft_motion(&self, modes: &Result<FreeModes, Error>) -> bool {
        match modes {
            Ok(modes) => {
                let lowest = modes.eigenvalues.first().copied();
                lowest.unwrap_or(modes.first_omitted) < self.spectrum.scale.shift()
            }
            Err(Error::Interrupted | Error::Ranks(_) | Error::OutOfMemory { .. }) => false,
            Err(_) => true,
        }
    }

    fn modes(
        &self,
        positive: &PositiveFactor,
        shift: f64,
        loose: &Mat<f64>,
        search: Search,
        observer: &mut dyn Observer,
    ) -> Result<FreeModes, Error> {
        observer.enter(Stage::Modes)?;
        let FreeBody { model, rigid, .. } = self.body;
        let known = KnownMotions { rigid, loose };
        FreeModes::compute(model, known, positive, shift, search, observer)
    }

    /// Motions without stiffness where they are refused, and no mode at all.
    fn refuse(&self, modes: &FreeModes, wanted: usize) -> Result<(), Error> {
        if modes.zero_count > 0 && self.options.loose_pieces == LoosePieces::Refuse {
            let shapes = modes.shapes.as_ref().subcols(0, modes.zero_count);
            let pieces = &self.spectrum.pieces;
            return Err(loose(
                &self.body.model,
                pieces,
                modes.zero_count,
                Some(shapes),
            ));
        }
        if wanted > 0 && modes.count() == 0 && self.spectrum.scale.first_elastic > 0.0 {
            return Err(Error::NotFinite { what: "the modes" });
        }
        Ok(())
    }

    fn columns(
        &self,
        modes: &FreeModes,
        positive: &PositiveFactor,
        shift: f64,
        estimate: EstimateChoice,
        observer: &mut dyn Observer,
    ) -> Result<Columns, Error> {
        observer.enter(Stage::Attachments)?;
        let FreeBody {
            model,
            localization,
            rigid,
            ..
        } = self.body;
        let residual =
            ResidualFlexibility::compute(model, localization, rigid, modes, positive, observer)?;
        let of = self.body.with(modes, &residual);
        let further = FurtherColumns::compute(&self.options.enrichment, &of, positive, observer)?;
        let moments = match (self.options.estimate, estimate) {
            (EstimateChoice::LeftOut, _) => Ok(None),
            (EstimateChoice::Computed, EstimateChoice::LeftOut) => Err(format!(
                "memory has no room for {} more columns; allow more with --memory",
                2 * localization.len()
            )),
            (EstimateChoice::Computed, EstimateChoice::Computed) => {
                observer.enter(Stage::Estimate)?;
                let columns = further.as_ref().map(|further| further.shapes.as_ref());
                match PowerMoments::compute(&of, columns, positive, shift, observer) {
                    Err(error @ (Error::Interrupted | Error::Ranks(_))) => return Err(error),
                    found => found.map(Some).map_err(|why| why.to_string()),
                }
            }
        };
        let omitted_stress = match self.options.estimate {
            EstimateChoice::LeftOut => None,
            EstimateChoice::Computed => omitted_stress(&of, positive, observer)?,
        };
        Ok(Columns {
            residual,
            further,
            moments,
            omitted_stress,
        })
    }
}

impl Columns {
    fn certified(self, modes: FreeModes, mode_count: ModeCount) -> Basis {
        let (moments, missing_moments) = match self.moments {
            Ok(moments) => (
                moments.map(|moments| moments.certified(&modes, mode_count)),
                None,
            ),
            Err(why) => (None, Some(why)),
        };
        Basis {
            modes,
            residual: self.residual,
            further: self.further,
            moments,
            missing_moments,
            omitted_stress: self.omitted_stress,
            mode_count,
        }
    }
}
