//! `reduce study`: what a reduction costs and how far it is off, for many reductions of one part.
//!
//! The unreduced part is made exact once ([`mod@reference`]); every reduction is then really made, one after the other, timed and
//! written (`timed`), and its superelement compared with the reference by several measures (`errors`) in the forms in which
//! a simulation can use it ([`variant`]). Rows go to a ledger as they are made; the tables, pictures and the page ([`report`]) are made from
//! the ledger alone, so that a study which was interrupted goes on where it ended.

pub(crate) mod best;
mod charts;
pub(crate) mod errors;
pub(crate) mod mode_picture;
pub mod progress;
pub mod record;
pub mod reference;
pub mod report;
pub mod request;
pub(crate) mod rows;
pub mod sources;
pub(crate) mod spin;
pub mod sweep;
pub(crate) mod timed;
pub mod variant;

use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use dcb_formats::Component;
use dcb_report::Ledger;

use self::errors::{Drawn, evaluate, reference_curves};
use self::mode_picture::mode_pictures;
use self::progress::Progress;
use self::record::{ComponentEntry, ComponentRow, ReferenceRecord};
use self::reference::{BandChoice, ComponentReference};
use self::sweep::{ReductionRun, Sweep};
use self::timed::timed;
use self::variant::{ReducedPart, Variant};
use crate::shard::Shard;
use dcb_formats::units::hertz;
use dcb_reducer::InterfaceModes;
use dcb_reducer::ModeSelection;
use dcb_reducer::Reduction;
use dcb_reducer::error::Error;
use dcb_reducer::model::condensation::Model;
use dcb_reducer::model::localization::Localization;
use dcb_reducer::resources::memory_limit::MemoryLimit;

/// Key of the reference in the ledger.
const REFERENCE: &str = "reference";

/// Subject and options of a study.
#[derive(Clone, Debug, PartialEq)]
pub struct ComponentStudy {
    /// Reductions and forms.
    pub sweep: Sweep,
    /// Frequencies.
    pub band: BandChoice,
    /// Equally spaced points of the band.
    pub points: usize,
    /// Structural loss factor η of the responses compared.
    pub loss_factor: f64,
    /// Memory.
    pub memory: MemoryLimit,
    /// The share of the reductions that is made here.
    pub shard: Shard,
}

impl ComponentStudy {
    /// Rows of all shares together.
    pub fn rows(&self) -> usize {
        let runs = self.sweep.runs();
        runs.iter().map(|run| run.variants.len()).sum()
    }

    /// Those of them that the ledger has.
    pub fn made(&self, ledger: &Ledger<ComponentEntry>) -> usize {
        let runs = self.sweep.runs();
        let keys = (runs.iter()).flat_map(|run| run.variants.iter().map(|of| run.key(*of)));
        keys.filter(|key| ledger.row(key).is_some()).count()
    }
}

/// Makes what the ledger doesn't have yet of this share. `scratch` is a file that reductions are written to; `complete` follows the rows that the ledger has.
///
/// # Errors
/// Those of [`ComponentReference::compute`], `timed()` and [`Ledger::add`].
pub fn run(
    study: &ComponentStudy,
    component: &Component,
    ledger: &mut Ledger<ComponentEntry>,
    scratch: &Path,
    progress: &mut Progress,
    complete: &AtomicUsize,
) -> Result<(), Error> {
    let missing: Vec<ReductionRun> = missing(study, ledger);
    complete.store(study.made(ledger), Ordering::SeqCst);
    if missing.is_empty() && ledger.row(REFERENCE).is_some() {
        return Ok(());
    }
    let start = Instant::now();
    let most = study.sweep.most_modes();
    let reference = ComponentReference::compute(
        component,
        most,
        study.band,
        study.points,
        &study.memory,
        progress,
    )?;
    let drawn = Drawn::of(&reference);
    if ledger.row(REFERENCE).is_none() {
        let record = record(study, component, &reference, drawn, start)?;
        ledger.add(REFERENCE, ComponentEntry::Reference(Box::new(record)))?;
    }
    progress.begin_rows();
    for run in missing {
        progress.row(
            &run.variants
                .iter()
                .map(|v| run.key(*v))
                .collect::<Vec<_>>()
                .join(", "),
        );
        let modes = run.modes;
        for (key, row) in rows_of(study, component, &reference, drawn, run, scratch)? {
            ledger.add(&key, ComponentEntry::Row(Box::new(row)))?;
            complete.fetch_add(1, Ordering::SeqCst);
        }
        progress.row_done(modes);
    }
    Ok(())
}

/// Reductions of this share with rows that the ledger doesn't have.
pub fn missing(study: &ComponentStudy, ledger: &Ledger<ComponentEntry>) -> Vec<ReductionRun> {
    let mut runs: Vec<ReductionRun> = study.shard.of(study.sweep.runs()).collect();
    for run in &mut runs {
        let known = run.clone();
        run.variants
            .retain(|variant| ledger.row(&known.key(*variant)).is_none());
    }
    runs.retain(|run| !run.variants.is_empty());
    runs
}

/// The reference and the rows of a study that is complete, in the order of the sweep.
pub fn recorded<'a>(
    study: &ComponentStudy,
    ledger: &'a Ledger<ComponentEntry>,
) -> Option<(&'a ReferenceRecord, Vec<ComponentRow>)> {
    let Some(ComponentEntry::Reference(reference)) = ledger.row(REFERENCE) else {
        return None;
    };
    let mut rows = Vec::new();
    for run in study.sweep.runs() {
        for variant in &run.variants {
            match ledger.row(&run.key(*variant)) {
                Some(ComponentEntry::Row(row)) => rows.push(row.as_ref().clone()),
                _ => return None,
            }
        }
    }
    Some((reference.as_ref(), rows))
}

/// One reduction, timed, and what it is worth in each of its forms.
fn rows_of(
    study: &ComponentStudy,
    component: &Component,
    reference: &ComponentReference,
    drawn: Drawn,
    run: ReductionRun,
    scratch: &Path,
) -> Result<Vec<(String, ComponentRow)>, Error> {
    let options = Reduction {
        modes: ModeSelection::Lowest(run.modes),
        interface_modes: run.interface_modes,
        enrichment: run.enrichment.as_slice().to_vec(),
        memory: study.memory.clone(),
        ..Reduction::lowest(run.modes)
    };
    let timed = timed(component, &options, scratch)?;
    let element = timed.element();
    let parts: Option<Vec<ReducedPart>> = (run.variants.iter())
        .map(|variant| {
            let unit = reference.response.unit;
            ReducedPart::of(element, *variant, &reference.rows, unit, reference.loose)
        })
        .collect();
    let parts = parts.ok_or(Error::NotFinite {
        what: "a row of the study",
    })?;
    let spin = reference.spin.as_ref();
    let spin_error = spin.and_then(|spin| spin.beyond(element, timed.whole.shapes()));
    let modes = vec![element.mode_count(); parts.len()];
    let found = evaluate(reference, &parts, &modes, study.loss_factor, drawn);
    Ok((run.variants.iter().zip(&parts).zip(found))
        .map(|((variant, part), (errors, curves))| {
            let row = ComponentRow {
                variant: *variant,
                asked_modes: run.modes,
                asked_interface_modes: match (variant, run.interface_modes) {
                    (Variant::Free, _) | (_, InterfaceModes::All) => None,
                    (_, InterfaceModes::Softest(count)) => Some(count),
                },
                enrichment: run.enrichment.clone(),
                modes: element.mode_count(),
                attachments: element.residual.sigma_squared.len(),
                unknowns: part.unknowns,
                reduction_seconds: timed.seconds,
                repeats: timed.repeats,
                file_bytes: timed.file_bytes,
                errors,
                spin_error,
                curves,
            };
            (run.key(*variant), row)
        })
        .collect())
}

fn record(
    study: &ComponentStudy,
    component: &Component,
    reference: &ComponentReference,
    drawn: Drawn,
    start: Instant,
) -> Result<ReferenceRecord, Error> {
    let model = Model::of(component)?;
    let localization = Localization::of(component, &model)?;
    let name = |row: usize| localization.row_name(reference.rows.places[row]);
    let own = name(drawn.collocated);
    let curves = reference_curves(reference, study.loss_factor, drawn);
    let recovery = &reference.recovery;
    let shapes = recovery.modes.as_ref();
    let pictures = mode_pictures(&component.mesh, &recovery.dofs, shapes);
    let captions = (reference.free.iter().enumerate()).map(|(index, eigenvalue)| {
        let frequency = hertz(*eigenvalue, &component.units.time);
        format!("mode {}, {frequency:.4} Hz", index + 1)
    });
    Ok(ReferenceRecord {
        name: component.name.clone(),
        time_unit: component.units.time.clone(),
        dofs: component.dofs.len(),
        interfaces: reference.rows.interfaces.clone(),
        rows: [reference.rows.len(), reference.independent.ncols()],
        free_eigenvalues: reference.free.clone(),
        held_eigenvalues: reference.held.clone(),
        loose_motions: reference.loose,
        band: reference.band.squares.clone(),
        loss_factor: study.loss_factor,
        residual: reference.residual,
        terms: reference.terms,
        spin: (reference.spin.as_ref()).map_or_else(Vec::new, |spin| spin.beyond_modes.clone()),
        seconds: start.elapsed().as_secs_f64(),
        drawn: [
            Some(format!("{own} under a force there")),
            drawn
                .transfer
                .map(|row| format!("{} under a force at {own}", name(row))),
        ],
        curves,
        pictures: pictures.into_iter().zip(captions).collect(),
    })
}
