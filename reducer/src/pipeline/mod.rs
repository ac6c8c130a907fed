//! The reduction from end to end: the dual Craig–Bampton method for co-rotated bodies.

pub(crate) mod assemble;
pub(crate) mod basis;
pub mod diagnosis;
pub(crate) mod effort;
pub(crate) mod free_body;
pub(crate) mod memory_plan;
pub(crate) mod projection;
pub mod reduction;
pub mod row_shapes;
pub(crate) mod warnings;

use dcb_formats::component::Component;
use dcb_formats::{RecoveryBasis, Superelement};

use crate::error::{Error, Shortfall};
use crate::mode_selection::ModeSelection;
use crate::model::condensation::Model;
use crate::model::localization::Localization;
use crate::observer::{Observer, Stage};
use crate::pipeline::assemble::assembled;
use crate::pipeline::basis::BasisSearch;
use crate::pipeline::effort::Work;
use crate::pipeline::free_body::FreeBody;
use crate::pipeline::memory_plan::MemoryPlan;
use crate::pipeline::projection::Projection;
use crate::pipeline::reduction::Reduction;
use crate::pipeline::row_shapes::WholeReduction;
use crate::pipeline::warnings::{Warnings, fewer_modes};
use crate::quality::Quality;
use crate::resources::forecast::Forecast;
use dcb_sparse::factorization::SymmetricFactor;

/// A reduced component.
#[derive(Clone, Debug)]
pub struct Reduced {
    /// For the dynamics.
    pub superelement: Superelement,
    /// Nodal shapes over the n_f dofs of the nodes: all n_e rows of the matrices but the internal ones.
    pub recovery: RecoveryBasis,
    /// How good it is.
    pub quality: Quality,
    /// Counts of the work.
    pub work: Work,
}

impl Reduced {
    /// The same where it is good enough.
    ///
    /// # Errors
    /// [`Error::Shortfall`] with the limits that are broken.
    pub fn accepted(self) -> Result<Self, Error> {
        match self.quality.broken_limits() {
            broken if broken.is_empty() => Ok(self),
            broken => Err(Shortfall::Limits(broken).into()),
        }
    }
}

/// Reduces a component.
///
/// # Errors
/// Refusals where the component can't be reduced as it is ([`Error::is_unusable_input`]); the others are numerical failures.
pub fn reduce(
    component: &Component,
    options: &Reduction,
    observer: &mut dyn Observer,
) -> Result<Reduced, Error> {
    Ok(reduce_whole(component, options, observer)?.reduced)
}

/// The same, with the shapes over all rows of the matrices, internal ones too: for comparisons with K and M.
///
/// # Errors
/// As [`reduce`].
pub fn reduce_whole(
    component: &Component,
    options: &Reduction,
    observer: &mut dyn Observer,
) -> Result<WholeReduction, Error> {
    let mut warnings = Warnings::default();
    // K and M without what rigid interfaces take away, L_b, and the rigid motions from geometry.
    observer.enter(Stage::Model)?;
    let mut body = FreeBody::of(component)?;

    observer.enter(Stage::Order)?;
    let (mut factor, spectrum) = body.analysed()?;
    let memory = MemoryPlan::of(options, &body, &factor);
    warnings.memory = memory.place(&mut factor, observer)?;

    // K times the rigid motions is zero, or the part is held.
    warnings.stiffness = body.settle(&spectrum, &mut factor, options)?;

    // One factor of K + σ M: Φ, G_res L_bᵀ, X, and the proof that no mode is missing.
    let search = BasisSearch::new(&body, &spectrum, &memory, options);
    let mut basis = search.certified(&mut factor, observer)?;
    let work = Work::of(&body.model, &factor, &basis.modes, &basis.residual)?;
    warnings.precision = factor.warning().map(str::to_owned);
    warnings.modes = fewer_modes(&body, options.modes, &basis.modes);
    let missing_estimate = basis.missing_moments.take();
    drop(factor);
    let basis = basis.keeping(options.interface_modes, &body)?;

    // Integrals over Ψ = [Φ, G_res L_bᵀ, X], which the motion of the frame needs.
    observer.enter(Stage::Invariants)?;
    let projection = Projection::of(&body, &basis);

    observer.enter(Stage::Quality)?;
    let mut quality = projection.quality(&body, &basis, &spectrum.defects);
    quality.missing_estimate = missing_estimate;
    let warnings = warnings.with(&body, &basis.modes, &quality);
    Ok(assembled(body, basis, projection, quality, work, warnings))
}

/// Forecasts the reduction of a component, from the pattern of its matrices alone.
///
/// # Errors
/// Refusals of the component ([`Error::Interface`], [`Error::Matrix`], [`Error::Body`]).
pub fn forecast(component: &Component, modes: ModeSelection) -> Result<Forecast, Error> {
    diagnosis::check_rows(component)?;
    let model = Model::of(component)?;
    let localization = Localization::of(component, &model)?;
    let factor = SymmetricFactor::analyse(&model.stiffness, &model.mass, &model.points())?;
    Ok(Forecast::of(&model, &localization, &factor, modes))
}
