//! The `reduce PART.mtx` command: read, reduce, write, and say what was done.

use std::io::IsTerminal;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use dcb_formats::Superelement;
use dcb_formats::component_files::{ComponentFiles, read_component, stem};
use dcb_formats::dcb::{
    Compression, Contents, Replace, WriteOptions, check_output, is_same_file, remove_unfinished,
    write_superelement,
};
use dcb_formats::report::write_text;
use dcb_formats::stop_signal;
use serde_json::json;

use crate::cache::Claim;
use crate::cli::{CommonArguments, ReduceArguments, print_to_stderr};
use crate::cli_cache::Told;
use crate::cli_cached::{claim, keep, request, serve};
use crate::cli_eigen_solver::eigen_solver;
use crate::cli_scene::Made;
use crate::error::{CommandRefusal, Error, Occupied};
use crate::inspect::hertz;
use crate::plausibility::si_factor;
use crate::scene::CachedReductions;
use crate::summary::{quality_lines, summary};
use crate::timing::{Display, StageClock, StageTime};
use crate::{
    EigenSolver, EstimateChoice, Grounding, InterfaceModes, LoosePieces, ModeSelection, Reduction,
    Work, reduce,
};

/// Modes kept where nothing is said.
pub(crate) const DEFAULT_MODES: usize = 20;
/// Modes listed unless all are asked for.
const LISTED_MODES: usize = 10;

/// Reasons named in a failure.
const NAMED_REASONS: usize = 5;

/// What a command has to say.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Outcome {
    /// For standard output.
    pub output: String,
    /// For standard error, with exit status 1: what was checked and did not hold.
    pub failure: Option<String>,
}

impl Outcome {
    /// All is well if there is no reason why not.
    pub fn unless(output: String, what: &str, reasons: &[String]) -> Self {
        let named = reasons[..reasons.len().min(NAMED_REASONS)].join("; ");
        let more = match reasons.len().saturating_sub(NAMED_REASONS) {
            0 => String::new(),
            more => format!("; and {more} more"),
        };
        Self {
            output,
            failure: (!reasons.is_empty()).then(|| format!("{what}: {named}{more}")),
        }
    }
}

/// Whether the superelement is complete, so that an interruption comes too late.
static WRITTEN: AtomicBool = AtomicBool::new(false);

/// Leaves the last word to the signal that ends the program; whatever goes wrong after it is a consequence.
pub fn wait_if_interrupted() {
    while stop_signal::received().is_some() {
        std::thread::park();
    }
}

/// `PART.dcb.h5` beside `PART.mtx`.
pub(crate) fn default_output(stiffness: &Path) -> PathBuf {
    let mut name = stem(stiffness).into_os_string();
    name.push(".dcb.h5");
    PathBuf::from(name)
}

/// What there is when the user interrupts.
fn last_words() -> String {
    match WRITTEN.load(Ordering::SeqCst) {
        true => "the superelement is complete".to_owned(),
        false => "nothing was written".to_owned(),
    }
}

/// Ends what was started, cleans up, says what there is, and ends with the signal's status (130 for Ctrl-C).
pub(crate) fn when_interrupted(clean_up: impl Fn() -> String + Send + 'static) {
    stop_signal::watch(move |signal| {
        #[cfg(feature = "slepc")]
        crate::mpi_job::end_all();
        remove_unfinished();
        print_to_stderr(signal.reason(), &clean_up());
        stop_signal::end(signal);
    });
}

/// Runs the command.
///
/// # Errors
/// Whatever made it impossible to read, reduce or write.
pub fn run(arguments: &ReduceArguments, common: &CommonArguments) -> Result<Outcome, Error> {
    let Some(stiffness) = &arguments.stiffness else {
        return Err(CommandRefusal::NoPart.into());
    };
    let eigen_solver = eigen_solver(arguments)?;
    let target = arguments
        .output
        .clone()
        .unwrap_or_else(|| default_output(stiffness));
    let replace = if arguments.force {
        Replace::Overwrite
    } else {
        Replace::Refuse
    };
    let files = ComponentFiles::beside(stiffness, &arguments.siblings.overrides())?;
    refuse_input_as_output(&files, &target)?;
    let part = arguments.scene.part(&target, &default_output(stiffness))?;
    let scene = part.as_ref().map(|part| part.path.as_path());
    refuse_scene_as_output(scene, &target)?;
    check_output(&target, replace)?;
    if let Some(timings) = &arguments.timings {
        refuse_input_as_output(&files, timings)?;
        refuse_scene_as_output(scene, timings)?;
        check_output(timings, Replace::Overwrite)?;
        if is_same_file(timings, &target) {
            return Err(would_destroy(timings, Occupied::Superelement));
        }
    }
    let told = Told::of(common);
    let cache = match arguments.cache.cache {
        Some(_) => arguments.cache.open(told)?,
        None => None,
    };
    let options = WriteOptions {
        replace_existing: replace,
        compression: if arguments.compress {
            Compression::Deflate
        } else {
            Compression::None
        },
    };
    let listed = if common.verbose {
        usize::MAX
    } else {
        LISTED_MODES
    };
    let show = !common.quiet && std::io::stderr().is_terminal();
    let mut clock = StageClock::new(if show { Display::Bars } else { Display::Silent });
    if common.verbose && !common.quiet {
        clock.announce_forecast();
    }
    let mut reservation = None;
    // What is made for a scene is made of cached reductions; it isn't one itself.
    if let Some(cache) = cache.as_ref().filter(|_| part.is_none()) {
        clock.start("cache");
        let request = request(&files, arguments)?;
        when_interrupted(last_words);
        match claim(cache, &request, told) {
            Some(Claim::Found(entry)) => {
                let outcome = serve(
                    &entry,
                    arguments,
                    &target,
                    &options,
                    &mut clock,
                    (told, listed),
                )?;
                WRITTEN.store(true, Ordering::SeqCst);
                if let Some(path) = &arguments.timings {
                    write_timings(path, clock.stages(), None)?;
                }
                return Ok(outcome);
            }
            Some(Claim::Missing(place)) => reservation = Some((place, request)),
            None => {}
        }
    } else {
        when_interrupted(last_words);
    }
    let memory = arguments.memory.limit(&target);
    clock.start("read");
    let component = read_component(&files, memory.bytes)?;
    let (n_e, sources) = (component.dofs.len(), component.sources.clone());
    let reduction = Reduction {
        modes: mode_selection(
            arguments.modes,
            arguments.max_frequency,
            &component.units.time,
        )?,
        interface_modes: arguments
            .interface_modes
            .map_or(InterfaceModes::All, InterfaceModes::Softest),
        enrichment: arguments.enrich.clone(),
        estimate: if arguments.without_estimate {
            EstimateChoice::LeftOut
        } else {
            EstimateChoice::Computed
        },
        grounding: if arguments.allow_grounded {
            Grounding::Allow
        } else {
            Grounding::Refuse
        },
        loose_pieces: if arguments.allow_loose {
            LoosePieces::Allow
        } else {
            LoosePieces::Refuse
        },
        eigen_solver,
        memory,
    };
    let naming = |error: Error| error.naming_the_file(&files);
    let cached = match (&cache, &part) {
        (Some(cache), Some(_)) => Some(CachedReductions {
            cache,
            request: request(&files, arguments)?,
        }),
        _ => None,
    };
    let mut made = match &part {
        Some(part) => (arguments.scene)
            .reduce(
                part,
                component,
                &reduction,
                arguments.modes,
                cached.as_ref(),
                &mut clock,
            )
            .map_err(naming)?,
        None => {
            let reduced = reduce(&component, &reduction, &mut clock).map_err(naming)?;
            Made {
                superelement: reduced.superelement,
                fields: Some(reduced.recovery),
                mesh: Some(component.mesh),
                quality: reduced.quality,
                work: reduced.work,
            }
        }
    };
    let broken_limits = made.quality.broken_limits();
    if !broken_limits.is_empty() {
        clock.clear();
        let what = format!(
            "{}: nothing was written, the reduction is not good enough",
            stiffness.display()
        );
        return Ok(Outcome::unless(
            quality_lines(&made.quality, &made.superelement.units.time),
            &what,
            &broken_limits,
        ));
    }
    clock.stop();
    let empty = no_mode_warning(arguments, &made.superelement);
    let provenance = &mut made.superelement.provenance;
    provenance.warnings.extend(empty);
    let selections = provenance.options["selections"].take();
    provenance.options = options_as_json(arguments, &reduction);
    if let Some(part) = &part {
        provenance.options["modes"] = json!({ "at_most": arguments.modes });
        provenance.options["scene"] = arguments.scene.as_json(part);
        if !selections.is_null() {
            provenance.options["selections"] = selections;
        }
    }
    if let Some(quality) = provenance.quality.as_object_mut() {
        quality.insert("stages".into(), json!(clock.stages()));
    }
    clock.start("write");
    let contents = Contents {
        superelement: &made.superelement,
        recovery: made.fields.as_ref().filter(|_| !arguments.without_fields),
        mesh: made.mesh.as_ref().filter(|_| !arguments.without_fields),
    };
    write_superelement(&target, &contents, &options)?;
    WRITTEN.store(true, Ordering::SeqCst);
    clock.stop();
    match reservation {
        // Files that changed since they were hashed would be kept under a key that isn't theirs.
        Some((place, request)) if request.is_of(&sources) => {
            let seconds = clock.stages().iter().map(|stage| stage.seconds).sum();
            clock.start("cache");
            keep(*place, arguments, &mut made, seconds, told);
        }
        _ => {}
    }
    clock.clear();
    if let Some(path) = &arguments.timings {
        write_timings(path, clock.stages(), Some(&made.work))?;
    }
    if !common.quiet {
        for warning in &made.superelement.provenance.warnings {
            print_to_stderr("warning", warning);
        }
    }
    Ok(Outcome {
        output: summary(
            &made.superelement,
            &made.quality,
            n_e,
            &target,
            clock.stages(),
            listed,
        ),
        failure: None,
    })
}

fn refuse_scene_as_output(scene: Option<&Path>, target: &Path) -> Result<(), Error> {
    match scene.filter(|scene| is_same_file(scene, target)) {
        None => Ok(()),
        Some(scene) => Err(would_destroy(scene, Occupied::Scene)),
    }
}

fn refuse_input_as_output(files: &ComponentFiles, target: &Path) -> Result<(), Error> {
    match files
        .all()
        .into_iter()
        .find(|input| is_same_file(input, target))
    {
        None => Ok(()),
        Some(input) => Err(would_destroy(&input, Occupied::Component)),
    }
}

fn would_destroy(path: &Path, role: Occupied) -> Error {
    let path = path.to_owned();
    CommandRefusal::WouldDestroy { path, role }.into()
}

/// A frequency limit that leaves no mode is more often a slip than a wish.
fn no_mode_warning(arguments: &ReduceArguments, element: &Superelement) -> Option<String> {
    let limit = arguments
        .max_frequency
        .filter(|_| element.mode_count() == 0)?;
    let first = Some(element.modes.first_omitted_eigenvalue)
        .filter(|value| value.is_finite())
        .map_or(String::new(), |value| {
            format!(
                " (the first is at {:.6} Hz)",
                hertz(value, &element.units.time)
            )
        });
    Some(format!(
        "no elastic mode lies below --max-frequency {limit} Hz{first}: none is kept, and the part deforms only as its attachments do; raise the limit, or use --modes"
    ))
}

/// The modes that `--modes` and `--max-frequency` ask for.
///
/// # Errors
/// [`Error::Command`] for a frequency in a time unit that is not known.
pub(crate) fn mode_selection(
    modes: Option<usize>,
    max_frequency: Option<f64>,
    time_unit: &str,
) -> Result<ModeSelection, Error> {
    let Some(hertz) = max_frequency else {
        return Ok(ModeSelection::Lowest(modes.unwrap_or(DEFAULT_MODES)));
    };
    let second = si_factor(time_unit).ok_or_else(|| CommandRefusal::UnknownTimeUnit {
        option: "--max-frequency",
        unit: time_unit.to_owned(),
        remedy: "use --modes",
    })?;
    Ok(ModeSelection::Below {
        eigenvalue: (2.0 * std::f64::consts::PI * hertz * second).powi(2),
    })
}

fn options_as_json(arguments: &ReduceArguments, options: &Reduction) -> serde_json::Value {
    let modes = match options.modes {
        ModeSelection::Lowest(count) => json!({ "lowest": count }),
        ModeSelection::Below { eigenvalue } | ModeSelection::BelowAtMost { eigenvalue, .. } => {
            json!({ "below_eigenvalue": eigenvalue })
        }
    };
    let mut json = json!({
        "modes": modes,
        "max_frequency_hz": arguments.max_frequency,
        "interface_modes": arguments.interface_modes,
        "enrich": arguments.enrich,
        "allow_grounded": arguments.allow_grounded,
        "allow_loose": arguments.allow_loose,
        "without_fields": arguments.without_fields,
        "without_estimate": arguments.without_estimate,
        "compress": arguments.compress,
    });
    if options.eigen_solver != EigenSolver::BlockLanczos {
        json["eigen_solver"] = json!({ "slepc": { "ranks": arguments.ranks } });
    }
    json
}

fn write_timings(path: &Path, stages: &[StageTime], work: Option<&Work>) -> Result<(), Error> {
    let total: f64 = stages.iter().map(|stage| stage.seconds).sum();
    let text = json!({ "stages": stages, "total_seconds": total, "work": work }).to_string() + "\n";
    write_text(path, &text).map_err(Error::Timings)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failure_is_one_message_however_many_the_reasons() {
        let reasons: Vec<String> = (1..=7).map(|number| format!("reason {number}")).collect();
        let failure = Outcome::unless(String::new(), "part.mtx: refused", &reasons).failure;
        let expected =
            "part.mtx: refused: reason 1; reason 2; reason 3; reason 4; reason 5; and 2 more";
        assert_eq!(failure.as_deref(), Some(expected));
        assert_eq!(
            Outcome::unless("well".into(), "part.mtx: refused", &[]).failure,
            None
        );
    }
}
