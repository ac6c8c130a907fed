//! The `reduce PART.mtx` command: read, reduce, write, and say what was done.

pub(crate) mod files;
pub(crate) mod report;
pub(crate) mod timing;

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use crate::program::Told;
use dcb_formats::Superelement;
use dcb_formats::component::Component;
use dcb_formats::component_files::{stem, with_ending};
use dcb_formats::dcb::{Contents, WriteOptions, write_superelement};
use dcb_formats::output::{Replace, check_output, is_same_file, write_text};
use dcb_import::NamedFile;
use serde_json::{Value, json};

use crate::outcome::Outcome;
use crate::program::{CommonArguments, Detail};
use crate::reduce::cache::{claim, keep, serve};
use crate::reduce::part::files::PartFiles;
use crate::reduce::part::report::summary;
use crate::reduce::part::timing::{StageClock, StageTime};
use crate::reduce::scene::Made;
use crate::reduce::{ReduceArguments, when_interrupted};
use dcb_formats::units::hertz;
use dcb_reducer::ModeSelection;
use dcb_reducer::Reduction;
use dcb_reducer::Work;
use dcb_reducer::error::{CommandRefusal, Error, Occupied};
use dcb_reducer::quality::lines::quality_lines;
use dcb_reducer::reduce;
use dcb_workflow::cache::{Cache, Claim, Request, Reservation};
use dcb_workflow::scene::{CachedReductions, PartInScene};

/// Whether the superelement is complete, so that an interruption comes too late.
static WRITTEN: AtomicBool = AtomicBool::new(false);

/// `PART.dcb.h5` beside `PART.mtx`.
pub(crate) fn default_output(stiffness: &Path) -> PathBuf {
    with_ending(&part_stem(stiffness), ".dcb.h5")
}

/// `PATH/part` of `PATH/part.mtx`, `PATH/part.mtx.gz` and of another program's `PATH/part.op4#KGG`.
pub(crate) fn part_stem(stiffness: &Path) -> PathBuf {
    let path = NamedFile::of(stiffness).path;
    let own = stem(&path);
    match own == path {
        true => path.with_extension(""),
        false => own,
    }
}

/// State when the user interrupts.
fn last_words() -> String {
    match WRITTEN.load(Ordering::SeqCst) {
        true => "the superelement is complete".to_owned(),
        false => "nothing was written".to_owned(),
    }
}

/// A reduction as it is asked for, with all that can be checked before anything is read.
struct Job<'a> {
    arguments: &'a ReduceArguments,
    target: PathBuf,
    files: PartFiles,
    /// The part in its scene, where it is reduced for one.
    part: Option<PartInScene>,
    reduction: Reduction,
    write_options: WriteOptions,
    told: Told,
    detail: Detail,
}

/// Entry of the cache for a job.
enum Claimed<'c> {
    /// All that was asked for.
    Served(Outcome),
    /// A place to keep what is made.
    Place(Box<Reservation<'c>>, Request),
    /// Nothing.
    Nothing,
}

/// Reduces a part, on one of the worker threads: none of its many small products then waits for another thread to be woken.
pub fn run(arguments: &ReduceArguments, common: &CommonArguments) -> Result<Outcome, Error> {
    rayon::scope(|_| run_on_worker(arguments, common))
}

fn run_on_worker(arguments: &ReduceArguments, common: &CommonArguments) -> Result<Outcome, Error> {
    let mut job = Job::of(arguments, common)?;
    let cache = match arguments.cache.cache {
        Some(_) => arguments.cache.open(job.told)?,
        None => None,
    };
    let mut clock = clock(common);
    let claimed = job.claimed(cache.as_ref(), &mut clock)?;
    if let Claimed::Served(outcome) = claimed {
        return Ok(outcome);
    }
    // Others may have taken some in the meantime.
    job.reduction.memory.bytes = arguments.memory.bytes();
    clock.start("read");
    let component = job.files.read(job.reduction.memory.bytes, job.told)?;
    let (n_e, sources) = (component.dofs.len(), component.sources.clone());
    let request = arguments.modes.request();
    job.reduction.modes = request.selection(&component.units.time)?;
    let mut made = job
        .made(component, cache.as_ref(), &mut clock)
        .map_err(|error| error.naming_the_file(&job.files.files))?;
    let broken_limits = made.quality.broken_limits().into_iter();
    let broken_limits: Vec<String> = broken_limits.map(|limit| limit.to_string()).collect();
    if !broken_limits.is_empty() {
        clock.clear();
        let what = format!(
            "{}: nothing was written, the reduction is not good enough",
            job.files.files.stiffness.display()
        );
        return Ok(Outcome::unless(
            quality_lines(&made.quality, &made.superelement.units.time),
            &what,
            &broken_limits,
        ));
    }
    clock.stop();
    job.describe(&mut made, clock.stages());
    clock.start("write");
    job.write(&made)?;
    clock.stop();
    match claimed {
        // Files that changed since they were hashed would be kept under a key that isn't theirs.
        Claimed::Place(place, request) if request.is_of(&sources) => {
            let seconds = clock.stages().iter().map(|stage| stage.seconds).sum();
            clock.start("cache");
            keep(*place, arguments.form, &mut made, seconds, job.told);
        }
        _ => {}
    }
    clock.clear();
    if let Some(path) = &arguments.timings {
        write_timings(path, clock.stages(), Some(&made.work))?;
    }
    for warning in &made.superelement.provenance.warnings {
        job.told.say("warning", warning);
    }
    let (element, stages) = (&made.superelement, clock.stages());
    Ok(Outcome::done(summary(
        element,
        &made.quality,
        n_e,
        &job.target,
        stages,
        job.detail,
    )))
}

fn clock(common: &CommonArguments) -> StageClock {
    let mut clock = StageClock::new(common.told().display());
    if common.verbose && !common.quiet {
        clock.announce_forecast();
    }
    clock
}

impl<'a> Job<'a> {
    fn of(arguments: &'a ReduceArguments, common: &CommonArguments) -> Result<Self, Error> {
        let stiffness = (arguments.stiffness.as_ref()).ok_or(CommandRefusal::NoPart)?;
        let mut reduction = arguments.reduction.clone();
        let usual = default_output(stiffness);
        let target = arguments.output.clone().unwrap_or_else(|| usual.clone());
        reduction.memory = arguments.memory.limit(&target);
        (arguments.ranks).enter(&arguments.memory, &mut reduction.memory)?;
        let replace_existing = match arguments.force {
            true => Replace::Overwrite,
            false => Replace::Refuse,
        };
        let files = PartFiles::of(stiffness, &arguments.part)?;
        let inputs = files.files.all();
        refuse_input_as_output(&inputs, &target, Occupied::Component)?;
        let part = arguments.scene.part(&target, &usual)?;
        let scene = part.as_ref().map(|part| part.path.as_path());
        refuse_scene_as_output(scene, &target)?;
        check_output(&target, replace_existing)?;
        if let Some(timings) = &arguments.timings {
            refuse_input_as_output(&inputs, timings, Occupied::Component)?;
            refuse_scene_as_output(scene, timings)?;
            check_output(timings, Replace::Overwrite)?;
            if is_same_file(timings, &target) {
                return Err(would_destroy(timings, Occupied::Superelement));
            }
        }
        Ok(Self {
            arguments,
            target,
            files,
            part,
            reduction,
            write_options: WriteOptions {
                replace_existing,
                compression: arguments.form.compression(),
            },
            told: common.told(),
            detail: common.detail(),
        })
    }

    /// Everything that decides the result; hashes the files.
    fn request(&self) -> Result<Request, Error> {
        let modes = self.arguments.modes.request();
        Ok(Request::new(&self.files.sources()?, modes, &self.reduction))
    }

    /// Entry of the cache. For a scene it has no result, but reductions to make one of.
    fn claimed<'c>(
        &self,
        cache: Option<&'c Cache>,
        clock: &mut StageClock,
    ) -> Result<Claimed<'c>, Error> {
        let Some(cache) = cache.filter(|_| self.part.is_none()) else {
            when_interrupted(last_words);
            return Ok(Claimed::Nothing);
        };
        clock.start("cache");
        let request = self.request()?;
        when_interrupted(last_words);
        let entry = match claim(cache, &request, self.told) {
            Some(Claim::Found(entry)) => entry,
            Some(Claim::Missing(place)) => return Ok(Claimed::Place(place, request)),
            None => return Ok(Claimed::Nothing),
        };
        let (form, target) = (self.arguments.form, &self.target);
        let said = (self.told, self.detail);
        let outcome = serve(&entry, form, target, &self.write_options, clock, said)?;
        WRITTEN.store(true, Ordering::SeqCst);
        if let Some(path) = &self.arguments.timings {
            write_timings(path, clock.stages(), None)?;
        }
        Ok(Claimed::Served(outcome))
    }

    fn made(
        &self,
        component: Component,
        cache: Option<&Cache>,
        clock: &mut StageClock,
    ) -> Result<Made, Error> {
        let Some(part) = &self.part else {
            let reduced = reduce(&component, &self.reduction, clock)?;
            return Ok(Made {
                superelement: reduced.superelement,
                fields: Some(reduced.recovery),
                mesh: Some(component.into_draft().mesh),
                quality: reduced.quality,
                work: reduced.work,
            });
        };
        let cached = match cache {
            Some(cache) => Some(CachedReductions {
                cache,
                request: self.request()?,
            }),
            None => None,
        };
        let (scene, most_modes) = (&self.arguments.scene, self.arguments.modes.modes);
        let reduction = &self.reduction;
        scene.reduce(
            part,
            component,
            reduction,
            most_modes,
            cached.as_ref(),
            clock,
        )
    }

    /// Writes into the superelement what was asked for and what it took.
    fn describe(&self, made: &mut Made, stages: &[StageTime]) {
        let empty = self.no_mode_warning(&made.superelement);
        let provenance = &mut made.superelement.provenance;
        provenance.warnings.extend(empty);
        let mut options = self.options();
        if let Some(part) = &self.part {
            options["modes"] = json!({ "at_most": self.arguments.modes.modes });
            options["scene"] = self.arguments.scene.as_json(part);
        }
        match (&mut provenance.options, options) {
            // Selections are listed there.
            (Value::Object(keys), Value::Object(more)) => keys.extend(more),
            (all, options) => *all = options,
        }
        if let Some(quality) = provenance.quality.as_object_mut() {
            quality.insert("stages".into(), json!(stages));
        }
    }

    /// The options of the provenance.
    fn options(&self) -> Value {
        let mut options = serde_json::to_value(&self.reduction).unwrap_or_default();
        options["modes"] = match self.reduction.modes {
            ModeSelection::Lowest(count) => json!({ "lowest": count }),
            ModeSelection::Below { eigenvalue } | ModeSelection::BelowAtMost { eigenvalue, .. } => {
                json!({ "below_eigenvalue": eigenvalue })
            }
        };
        if let Some(ranks) = self.arguments.ranks.count() {
            options["ranks"] = ranks.into();
        }
        options["max_frequency_hz"] = self.arguments.modes.max_frequency.into();
        self.arguments.form.say(&mut options);
        options
    }

    /// A frequency limit that leaves no mode is more often a slip than a wish.
    fn no_mode_warning(&self, element: &Superelement) -> Option<String> {
        let limit = (self.arguments.modes.max_frequency).filter(|_| element.mode_count() == 0)?;
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

    fn write(&self, made: &Made) -> Result<(), Error> {
        let with_fields = !self.arguments.form.without_fields;
        let contents = Contents {
            superelement: &made.superelement,
            recovery: made.fields.as_ref().filter(|_| with_fields),
            mesh: made.mesh.as_ref().filter(|_| with_fields),
        };
        write_superelement(&self.target, &contents, &self.write_options)?;
        WRITTEN.store(true, Ordering::SeqCst);
        Ok(())
    }
}

fn refuse_scene_as_output(scene: Option<&Path>, target: &Path) -> Result<(), Error> {
    match scene.filter(|scene| is_same_file(scene, target)) {
        None => Ok(()),
        Some(scene) => Err(would_destroy(scene, Occupied::Scene)),
    }
}

/// Refuses an output that is one of the inputs.
pub(crate) fn refuse_input_as_output(
    inputs: &[PathBuf],
    target: &Path,
    role: Occupied,
) -> Result<(), Error> {
    let is_output = |input: &&PathBuf| target.exists() && is_same_file(input, target);
    match inputs.iter().find(is_output) {
        None => Ok(()),
        Some(input) => Err(would_destroy(input, role)),
    }
}

fn would_destroy(path: &Path, role: Occupied) -> Error {
    let path = path.to_owned();
    CommandRefusal::WouldDestroy { path, role }.into()
}

fn write_timings(path: &Path, stages: &[StageTime], work: Option<&Work>) -> Result<(), Error> {
    let total: f64 = stages.iter().map(|stage| stage.seconds).sum();
    let text = json!({ "stages": stages, "total_seconds": total, "work": work }).to_string() + "\n";
    write_text(path, &text).map_err(Error::Timings)
}
