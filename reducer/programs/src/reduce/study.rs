//! The `reduce study PART.mtx` command: many reductions of one part, what each costs, and how far it is off.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

use clap::Args;
use dcb_formats::Component;
use dcb_formats::component_files::with_ending;
use dcb_formats::output::remove_leftovers;
use dcb_report::{Ledger, Start};
use serde_json::{Value, json};

use crate::outcome::Outcome;
use crate::program::CommonArguments;
use crate::reduce::memory::MemoryArguments;
use crate::reduce::part::files::{PartArguments, PartFiles};
use crate::reduce::part::part_stem;
use crate::reduce::when_interrupted;
use dcb_reducer::error::Error;
use dcb_workflow::part_study::progress::Progress;
use dcb_workflow::part_study::report::Report;
use dcb_workflow::part_study::request::StudyRequest;
use dcb_workflow::part_study::sources::Sources;
use dcb_workflow::part_study::variant::Variant;
use dcb_workflow::part_study::{ComponentStudy, missing, recorded, run as make};
use dcb_workflow::shard::{Shard, waiting_for_others};

/// Name of the ledger in a study's folder.
const LEDGER: &str = "rows.jsonl";

/// Subject of the study.
#[derive(Debug, Args)]
pub struct ComponentStudyArguments {
    /// Stiffness matrix: Matrix Market (.mtx, .mtx.gz) or another program's; FILE#NAME picks one of several.
    #[arg(value_name = "PART.mtx")]
    pub stiffness: PathBuf,
    /// Folder of the study [default: PART.study].
    #[arg(long, short, value_name = "FOLDER")]
    pub output: Option<PathBuf>,
    /// Numbers of modes [default: 5,10,20,40].
    #[arg(long, value_name = "N,…", value_delimiter = ',', allow_negative_numbers = true, value_parser = positive)]
    pub modes: Option<Vec<usize>>,
    /// Forms in which the superelement is used.
    #[arg(long, value_name = "NAME,…", value_delimiter = ',', value_enum, default_values_t = Variant::ALL)]
    pub variants: Vec<Variant>,
    /// Numbers of interface modes, beside all of them.
    #[arg(long, value_name = "N,…", value_delimiter = ',', allow_negative_numbers = true, value_parser = positive)]
    pub interface_modes: Vec<usize>,
    /// Further columns of strong rows, beside none [default: krylov].
    ///
    /// Those of `reduce --enrich`: krylov, spin, loads; several at once as spin+krylov; none for no such rows.
    #[arg(long, value_name = "WHAT,…", value_delimiter = ',')]
    pub enrich: Option<Vec<Sources>>,
    /// Band of frequencies, Hz [default: up to half the highest mode].
    #[arg(long, value_name = "FMIN:FMAX", allow_hyphen_values = true, value_parser = band)]
    pub band: Option<[f64; 2]>,
    /// Points of the band; resonances are added.
    #[arg(long, value_name = "N", default_value_t = 400, value_parser = clap::value_parser!(u32).range(2..=100_000))]
    pub points: u32,
    /// Structural loss factor of the responses compared.
    #[arg(long, value_name = "ETA", default_value_t = 0.02, allow_hyphen_values = true, value_parser = loss)]
    pub loss_factor: f64,
    /// Error for which the best row is named.
    #[arg(long, value_name = "E", default_value_t = 1e-3, allow_hyphen_values = true, value_parser = tolerance)]
    pub tolerance: f64,
    #[command(flatten)]
    pub part: PartArguments,
    /// Only every Nth reduction, beginning with the Ith: array task I of N. All tasks have one folder.
    #[arg(
        long,
        value_name = "I/N",
        allow_hyphen_values = true,
        conflicts_with = "force"
    )]
    pub shard: Option<Shard>,
    /// Start anew where the folder has rows already.
    #[arg(long)]
    pub force: bool,
    #[command(flatten)]
    pub memory: MemoryArguments,
}

fn positive(text: &str) -> Result<usize, String> {
    match text.trim().parse() {
        Ok(count) if count > 0 => Ok(count),
        _ => Err("numbers above 0 are wanted, for example 5,10,20".into()),
    }
}

fn number(text: &str, limit: f64, wanted: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value > 0.0 && value <= limit => Ok(value),
        _ => Err(wanted.into()),
    }
}

fn loss(text: &str) -> Result<f64, String> {
    number(text, 1.0, "a number above 0 and up to 1 is wanted")
}

fn tolerance(text: &str) -> Result<f64, String> {
    number(text, f64::MAX, "a relative error above 0 is wanted")
}

/// Two frequencies, Hz.
pub(crate) fn band(text: &str) -> Result<[f64; 2], String> {
    let wanted = || "two frequencies in Hz are wanted, for example 10:2000".to_owned();
    let (from, to) = text.split_once(':').ok_or_else(wanted)?;
    let parsed = [from, to].map(|end| end.trim().parse::<f64>());
    match parsed {
        [Ok(from), Ok(to)] if from > 0.0 && to > from && to.is_finite() => Ok([from, to]),
        _ => Err(wanted()),
    }
}

/// Rows that are complete, for the last words of an interrupted run.
static ROWS: AtomicUsize = AtomicUsize::new(0);

pub fn run(
    arguments: &ComponentStudyArguments,
    common: &CommonArguments,
) -> Result<Outcome, Error> {
    let folder = (arguments.output.clone()).unwrap_or_else(|| default_folder(&arguments.stiffness));
    let files = PartFiles::of(&arguments.stiffness, &arguments.part)?;
    let component = files.read(arguments.memory.limit(&folder).bytes, common.told())?;
    let named = |error: Error| error.naming_the_file(&files.files);
    let shard = arguments.shard.unwrap_or(Shard::WHOLE);
    let scratch = folder.join(scratch_name(shard));
    let request = arguments.request();
    let study = (request.study(&component, arguments.memory.limit(&scratch))).map_err(named)?;
    let study = ComponentStudy { shard, ..study };
    let start = if arguments.force {
        Start::Anew
    } else {
        Start::Continue
    };
    prepare(&folder, start)?;
    let settings = settings(&study, arguments.band, &component);
    let mut ledger = Ledger::open(&folder.join(LEDGER), "reduction", &settings, start)?;
    last_words(&scratch);
    let planned = missing(&study, &ledger).into_iter().map(|run| run.modes);
    let mut progress = Progress::new(common.told().display(), planned);
    let made = make(
        &study,
        &component,
        &mut ledger,
        &scratch,
        &mut progress,
        &ROWS,
    );
    progress.clear();
    if let Err(error) = made {
        // Nothing is left of a study without a row, unless others are at theirs.
        if ledger.is_empty() && shard.is_whole() {
            drop(ledger);
            let _ = std::fs::remove_file(folder.join(LEDGER));
            let _ = std::fs::remove_dir(&folder);
        }
        return Err(named(error));
    }
    ledger.refresh()?;
    let Some((reference, rows)) = recorded(&study, &ledger) else {
        let (made, all) = (study.made(&ledger), study.rows());
        return Ok(Outcome::done(waiting_for_others(made, all, &folder)));
    };
    let report = Report::new(reference, &rows, arguments.tolerance);
    report.write(&folder)?;
    let output = format!(
        "{}wrote {}\n",
        report.text(),
        folder.join("report.html").display()
    );
    Ok(Outcome::done(output))
}

/// Name of the file that the reductions of a shard are written to.
fn scratch_name(shard: Shard) -> String {
    match shard.is_whole() {
        true => "timing.dcb.h5".to_owned(),
        false => format!("timing-{}.dcb.h5", shard.index()),
    }
}

impl ComponentStudyArguments {
    fn request(&self) -> StudyRequest {
        StudyRequest {
            modes: self.modes.clone(),
            variants: self.variants.clone(),
            interface_modes: self.interface_modes.clone(),
            enrich: self.enrich.clone(),
            band: self.band,
            points: self.points as usize,
            loss_factor: self.loss_factor,
        }
    }
}

/// `PART.study` beside `PART.mtx`.
fn default_folder(stiffness: &Path) -> PathBuf {
    with_ending(&part_stem(stiffness), ".study")
}

/// Properties that all rows share. More modes or forms may be added later, as far as the band doesn't depend on them.
fn settings(study: &ComponentStudy, band: Option<[f64; 2]>, component: &Component) -> Value {
    let inputs: serde_json::Map<String, Value> = (component.sources.iter())
        .map(|source| (source.role.clone(), json!(source.sha256)))
        .collect();
    let band = match band {
        None => format!("up to half of mode {}", study.sweep.most_modes()),
        Some([from, to]) => format!("{from}:{to} Hz"),
    };
    json!({
        "program": concat!("reduce ", env!("CARGO_PKG_VERSION")),
        "inputs": inputs,
        "band": band,
        "points": study.points,
        "loss_factor": study.loss_factor,
    })
}

/// Makes the folder, or sees that it is a study's.
fn prepare(folder: &Path, start: Start) -> Result<(), Error> {
    let refused = |message: &str| {
        Error::File(dcb_formats::Error::File {
            path: folder.to_owned(),
            message: message.to_owned(),
        })
    };
    let told =
        |source| dcb_formats::Error::io(folder, "cannot make the folder of the study", source);
    if folder.exists() && !folder.is_dir() {
        return Err(refused("is no folder; name a folder for the study with -o"));
    }
    std::fs::create_dir_all(folder).map_err(told)?;
    remove_leftovers(&folder.join(LEDGER));
    let is_empty = std::fs::read_dir(folder).map_err(told)?.next().is_none();
    if !is_empty && !folder.join(LEDGER).exists() && start == Start::Continue {
        return Err(refused(
            "has files in it and holds no study; name another folder with -o, or put the study there with --force",
        ));
    }
    Ok(())
}

/// Files and message of an interrupted study.
fn last_words(scratch: &Path) {
    let scratch = scratch.to_owned();
    when_interrupted(move || {
        let _ = std::fs::remove_file(&scratch);
        let rows = match ROWS.load(Ordering::SeqCst) {
            1 => "1 row is complete".to_owned(),
            count => format!("{count} rows are complete"),
        };
        format!("{rows}; the same command goes on from there")
    });
}
