//! Component → superelement: the offline half of the dual Craig–Bampton method for co-rotated bodies.
//!
//! [`reduce`] is the whole pipeline: rigid motions from geometry, one factorization of K + σ M that serves the free-free
//! modes and the residual flexibility, inertia invariants, an eigenvalue count as certificate, and a quality report. Everything
//! works on sparse matrices; nothing here reads clocks, prints or opens files ([`cli`] does), but for a factor that is kept on disk.

pub mod assemble;
pub mod attachment;
pub mod basis_size;
pub mod batch;
pub mod cache;
pub mod cell_coupling;
pub mod cli;
pub mod cli_batch;
pub mod cli_cache;
pub mod cli_cached;
pub mod cli_eigen_solver;
pub mod cli_memory;
pub mod cli_plan;
pub mod cli_reduce;
pub mod cli_scene;
pub mod cli_study;
pub mod compare;
pub mod condensation;
pub mod couplings;
pub mod dependency;
pub mod diagnosis;
pub mod eigen_solver;
pub mod enrichment;
pub mod error;
pub mod error_estimate;
pub mod forecast;
pub mod frame;
pub mod free_modes;
pub mod huge_pages;
pub mod inspect;
pub mod interface_reduction;
pub mod invariants;
pub mod lanczos;
pub mod localization;
pub mod machine_speed;
pub mod memory_limit;
#[cfg(feature = "slepc")]
pub mod mpi_job;
pub mod multiplet;
pub mod observer;
pub mod part_loads;
#[cfg(feature = "slepc")]
pub mod petsc_binary;
mod piece_motions;
pub mod plan;
pub mod plausibility;
pub mod quality;
pub mod residual;
pub mod residual_filter;
pub mod rigid_body;
pub mod scene;
pub mod scientific;
pub mod shift;
#[cfg(feature = "slepc")]
pub mod slepc;
pub mod spin_forces;
pub mod stiffening;
pub mod study;
pub mod summary;
pub mod surface;
pub mod timing;
pub mod verify;
pub mod verify_component;
pub mod verify_further;
pub mod verify_interfaces;
pub mod verify_layout;
pub mod verify_moments;
pub mod work;

use dcb_formats::component::Component;
use dcb_formats::{RecoveryBasis, Superelement};
use dcb_sparse::factor_store::{FactorStorage, Place};
use dcb_sparse::factorization::SymmetricFactor;
use faer::Mat;

use crate::condensation::{CowMat, Model};
use crate::diagnosis::Support;
pub use crate::diagnosis::{Grounding, LoosePieces};
pub use crate::eigen_solver::EigenSolver;
pub use crate::enrichment::EnrichmentSource;
use crate::enrichment::{FurtherColumns, Reducing};
use crate::error::BodyRefusal;
pub use crate::error::Error;
use crate::error_estimate::PowerMoments;
pub use crate::forecast::EstimateChoice;
use crate::forecast::Forecast;
use crate::free_modes::{FreeModes, KnownMotions, Search};
pub use crate::interface_reduction::InterfaceModes;
use crate::invariants::inertia_invariants;
use crate::localization::Localization;
use crate::memory_limit::{MemoryLimit, readable};
use crate::observer::{Observer, Stage};
use crate::part_loads::part_loads;
use crate::piece_motions::PieceMotions;
use crate::quality::{Quality, Sturm};
use crate::residual::ResidualFlexibility;
use crate::rigid_body::{MassProperties, RigidBodyModes};
use crate::shift::SpectrumScale;
use crate::stiffening::stiffening;
pub use crate::work::Work;

/// Searches made, each wider than the one before, until the eigenvalue count agrees.
const ATTEMPTS: usize = 3;

/// Which modes to keep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ModeSelection {
    /// This many lowest elastic modes (a multiple root is never cut, so it may be more).
    Lowest(usize),
    /// Every elastic mode below this ω², (rad/time)².
    Below {
        /// The limit.
        eigenvalue: f64,
    },
    /// The same, but no more than so many, the lowest (or more where that would cut a multiple root).
    BelowAtMost {
        /// The limit.
        eigenvalue: f64,
        /// How many.
        count: usize,
    },
}

/// What to do.
#[derive(Clone, Debug, PartialEq)]
pub struct Reduction {
    /// Modes to keep.
    pub modes: ModeSelection,
    /// Directions of residual flexibility to keep.
    pub interface_modes: InterfaceModes,
    /// Further columns of the basis.
    pub enrichment: Vec<EnrichmentSource>,
    /// Whether the superelement says how far it is off; where memory is short it doesn't, with a warning.
    pub estimate: EstimateChoice,
    /// What to do with a part that is held.
    pub grounding: Grounding,
    /// What to do with loose pieces and mechanisms.
    pub loose_pieces: LoosePieces,
    /// What finds the modes.
    pub eigen_solver: EigenSolver,
    /// How much memory may be taken, and where the factor is kept.
    pub memory: MemoryLimit,
}

impl Reduction {
    /// The `count` lowest modes of a free part in one piece.
    pub fn lowest(count: usize) -> Self {
        Self {
            modes: ModeSelection::Lowest(count),
            interface_modes: InterfaceModes::All,
            enrichment: Vec::new(),
            estimate: EstimateChoice::Computed,
            grounding: Grounding::Refuse,
            loose_pieces: LoosePieces::Refuse,
            eigen_solver: EigenSolver::BlockLanczos,
            memory: MemoryLimit::default(),
        }
    }
}

/// A reduced component.
#[derive(Clone, Debug)]
pub struct Reduced {
    /// What the dynamics needs.
    pub superelement: Superelement,
    /// Nodal shapes over all n_e dofs.
    pub recovery: RecoveryBasis,
    /// How good it is.
    pub quality: Quality,
    /// What it took.
    pub work: Work,
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
    observer.begin(Stage::Model);
    diagnosis::check_rows(component)?;
    let properties = MassProperties::of(component)?;
    let model = Model::of(component)?;
    let localization = Localization::of(component, &model)?;
    let geometric = RigidBodyModes::of(component, &model, &properties)?;
    if model.len() <= geometric.count() {
        return Err(BodyRefusal::NothingElastic {
            dofs: model.len(),
            motions: geometric.count(),
        }
        .into());
    }

    observer.begin(Stage::Order);
    // The order is found by one thread; what the matrices say of the spectrum comes from the others meanwhile.
    let (factor, (defects, scale)) = rayon::join(
        || SymmetricFactor::analyse(&model.stiffness, &model.mass, &model.points()),
        || {
            let defects = geometric.stiffness_defects(&model);
            let (dimension, centre) = (component.dimension(), properties.centre);
            (
                defects,
                SpectrumScale::of(&model, &geometric, dimension, centre),
            )
        },
    );
    let mut factor = factor?;
    let forecast = Forecast {
        estimate: options.estimate,
        ..Forecast::of(&model, &localization, &factor, options.modes)
    };
    let forecast = options.memory.fitted(forecast);
    observer.forecast(&forecast, &options.memory);
    let storage = options.memory.choose(&forecast)?;
    let memory_warning = short_of_memory(&forecast, &storage, &options.memory);
    factor.keep_in(storage, options.memory.fallback(&forecast));
    let (support, few_digits) = diagnosis::support(
        &model,
        &geometric,
        &defects,
        &scale,
        &mut factor,
        options.grounding,
    )?;
    let rigid = match support {
        Support::Free => geometric,
        Support::Grounded => geometric.none(),
    };
    if options.loose_pieces == LoosePieces::Refuse && diagnosis::pieces(&model).len() > 1 {
        return Err(diagnosis::loose(&model, 0, None));
    }
    let shared = Shared {
        component,
        properties: &properties,
        model: &model,
        localization: &localization,
        rigid: &rigid,
        scale: &scale,
    };
    let Found {
        modes,
        residual,
        further,
        moments,
        sturm,
    } = modes_and_residual(&shared, &mut factor, &forecast, options, observer)?;
    let work = Work::of(&model, &factor, &modes, &residual);
    let precision_warning = factor.warning().map(str::to_owned);
    drop(factor);
    let (moments, estimate_warning) = match moments {
        Ok(moments) => (
            moments.map(|moments| moments.certified(&modes, sturm)),
            None,
        ),
        Err(why) => (None, Some(format!("no error estimate: {why}"))),
    };
    let residual = match options.interface_modes {
        InterfaceModes::All => residual,
        InterfaceModes::Softest(wanted) => {
            residual.keeping(wanted, &model, &localization, &modes)?
        }
    };

    observer.begin(Stage::Invariants);
    // Ψ = [Φ, G_res L_bᵀ] over all dofs of the component.
    let (phi, x) = (
        model.expand(modes.shapes.as_ref()),
        model.expand(residual.shapes.as_ref()),
    );
    let further_shapes = further
        .as_ref()
        .map(|further| model.expand(further.shapes.as_ref()));
    let mut basis = vec![phi.as_ref(), x.as_ref()];
    basis.extend(further_shapes.iter().map(CowMat::as_ref));
    let (inertia, couplings) = inertia_invariants(component, &properties, &basis);
    let stiffening = stiffening(component, &localization, &basis);
    let loads = part_loads(component, properties.centre, &basis);
    let enrichment = further
        .as_ref()
        .map(|further| further.stored(&model, &localization, &modes, &residual));
    let expanded = (phi.computed(), x.computed());
    let further_fields = match (further_shapes.map(CowMat::computed), &further) {
        (Some(None), Some(further)) => Some(further.shapes.clone()),
        (Some(computed), _) => computed,
        (None, _) => None,
    };

    observer.begin(Stage::Quality);
    let defects = &defects.per_column;
    let quality = Quality {
        couplings: Some(couplings),
        ..Quality::of(
            &model,
            &properties,
            &rigid,
            defects,
            &modes,
            &residual,
            further.as_ref(),
            &inertia,
            sturm,
        )
    };
    let mut warnings: Vec<String> = [
        few_digits,
        memory_warning,
        precision_warning,
        estimate_warning,
    ]
    .into_iter()
    .flatten()
    .collect();
    warnings.extend(assemble::warnings(
        component,
        &properties,
        support,
        &modes,
        &quality,
    ));
    warnings.extend(stiffening::unused_rows(component, &localization));
    let parts = assemble::Parts {
        component,
        properties,
        localization,
        modes,
        residual,
        further_fields,
        inertia,
        stiffening,
        enrichment,
        moments,
        loads,
        support,
    };
    Ok(parts.into_reduced(expanded, quality, work, warnings))
}

/// What to say where the factor went to disk unasked.
fn short_of_memory(
    forecast: &Forecast,
    storage: &FactorStorage,
    limit: &MemoryLimit,
) -> Option<String> {
    let in_memory = FactorStorage::default();
    match (&storage.place, limit.bytes) {
        (Place::Disk { folder }, Some(bytes)) if !limit.allows(forecast, &in_memory) => {
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

/// What the steps that share the factorization start from.
struct Shared<'a> {
    component: &'a Component,
    properties: &'a MassProperties,
    model: &'a Model<'a>,
    localization: &'a Localization,
    rigid: &'a RigidBodyModes,
    scale: &'a SpectrumScale,
}

/// What they find.
struct Found {
    modes: FreeModes,
    residual: ResidualFlexibility,
    further: Option<FurtherColumns>,
    /// None where they aren't wanted, or why there are none.
    moments: Result<Option<PowerMoments>, String>,
    sturm: Sturm,
}

/// Steps that share the factorization, repeated more widely if the eigenvalue count finds modes missing.
fn modes_and_residual(
    shared: &Shared<'_>,
    factor: &mut SymmetricFactor,
    forecast: &Forecast,
    options: &Reduction,
    observer: &mut dyn Observer,
) -> Result<Found, Error> {
    let Shared {
        model,
        localization,
        rigid,
        scale,
        ..
    } = *shared;
    let mut below = |eigenvalue: f64| {
        observer.begin(Stage::Certificate);
        factor
            .inertia(&model.stiffness, &model.mass, eigenvalue)
            .negative
            .saturating_sub(rigid.count())
    };
    let wanted = match options.modes {
        ModeSelection::Lowest(count) => count,
        ModeSelection::Below { eigenvalue } => below(eigenvalue),
        ModeSelection::BelowAtMost { eigenvalue, count } => below(eigenvalue).min(count),
    };
    let known = Forecast {
        modes: wanted,
        estimate: options.estimate,
        ..*forecast
    };
    let Forecast {
        basis, estimate, ..
    } = options.memory.fitted(known);
    let shift = scale.shift();
    let pieces = match options.loose_pieces {
        LoosePieces::Allow => PieceMotions::of(model, rigid),
        LoosePieces::Refuse => None,
    };
    let loose = match pieces {
        Some(pieces) => pieces.beyond(rigid)?,
        None => Mat::zeros(model.len(), 0),
    };
    let mut last_count: Option<Sturm> = None;
    let mut missed = 0;
    for attempt in 0..ATTEMPTS {
        observer.begin(Stage::Factor);
        let positive = match factor.factorize(&model.stiffness, &model.mass, shift) {
            Ok(positive) => positive,
            Err(why) => return Err(diagnosis::unfactorized(model, scale, factor, why)),
        };
        observer.begin(Stage::Modes);
        missed += last_count.map_or(0, |sturm| sturm.counted.saturating_sub(sturm.found));
        let found = options.eigen_solver.free_modes(
            model,
            KnownMotions {
                rigid,
                loose: &loose,
            },
            &positive,
            shift,
            Search {
                wanted,
                attempt,
                missed,
                basis,
            },
            observer,
        );
        let modes = match found {
            Err(_) if !positive.least_accurate().is_accurate() => {
                let refined = positive.least_accurate();
                factor.keep_in_double(refined);
                continue;
            }
            found => found?,
        };
        if modes.zero_count > 0 && options.loose_pieces == LoosePieces::Refuse {
            let shapes = modes
                .shapes
                .as_ref()
                .subcols(0, modes.zero_count)
                .to_owned();
            return Err(diagnosis::loose(model, modes.zero_count, Some(&shapes)));
        }
        if wanted > 0 && modes.count() == 0 && scale.first_elastic > 0.0 {
            return Err(Error::NotFinite { what: "the modes" });
        }
        observer.begin(Stage::Attachments);
        let residual =
            ResidualFlexibility::compute(model, localization, rigid, &modes, &positive, observer);
        let found = residual.and_then(|residual| {
            let of = Reducing {
                component: shared.component,
                properties: shared.properties,
                model,
                localization,
                rigid,
                modes: &modes,
                residual: &residual,
            };
            let further = FurtherColumns::compute(&options.enrichment, &of, &positive, observer)?;
            let columns = further.as_ref().map(|further| further.shapes.as_ref());
            let moments = match estimate {
                EstimateChoice::LeftOut if options.estimate == EstimateChoice::LeftOut => Ok(None),
                EstimateChoice::LeftOut => Err(format!(
                    "memory has no room for {} more columns; allow more with --memory",
                    2 * localization.len()
                )),
                EstimateChoice::Computed => {
                    observer.begin(Stage::Estimate);
                    PowerMoments::compute(&of, columns, &positive, shift, observer)
                        .map(Some)
                        .map_err(|why| why.to_string())
                }
            };
            Ok((residual, further, moments))
        });
        let refined = positive.least_accurate();
        if !refined.is_accurate() {
            factor.keep_in_double(refined);
            continue;
        }
        let (residual, further, moments) = found?;
        observer.begin(Stage::Certificate);
        factor.release();
        let sturm = certificate(model, rigid, &modes, factor);
        if sturm.counted == sturm.found {
            return Ok(Found {
                modes,
                residual,
                further,
                moments,
                sturm,
            });
        }
        last_count = Some(sturm);
    }
    let sturm = last_count.unwrap_or(Sturm {
        limit: None,
        counted: 0,
        found: 0,
    });
    Err(Error::ModesMissed {
        found: sturm.found,
        counted: sturm.counted,
        limit: sturm.limit.unwrap_or(0.0),
    })
}

/// Counts the eigenvalues below the first omitted one and compares with those found.
fn certificate(
    model: &Model,
    rigid: &RigidBodyModes,
    modes: &FreeModes,
    factor: &mut SymmetricFactor,
) -> Sturm {
    let found = rigid.count() + modes.count();
    let Some((limit, room)) = modes.certificate_shift() else {
        return Sturm {
            limit: None,
            counted: found,
            found,
        };
    };
    // A zero pivot means that μ met an eigenvalue of some leading block; a slightly different μ in the same gap does not.
    let mut inertia = factor.inertia(&model.stiffness, &model.mass, limit);
    let mut used = limit;
    for fraction in [0.1, -0.1, 0.37] {
        if inertia.zero == 0 {
            break;
        }
        used = limit + fraction * room;
        inertia = factor.inertia(&model.stiffness, &model.mass, used);
    }
    Sturm {
        limit: Some(used),
        counted: inertia.negative,
        found,
    }
}
