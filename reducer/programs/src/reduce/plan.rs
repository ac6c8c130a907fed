//! The `reduce plan PART.mtx` command: read, order, and say what a reduction will cost.

use std::fmt::Write as _;
use std::path::PathBuf;

use clap::Args;
use dcb_formats::units::{four_digits, readable};
use dcb_sparse::factor_store::{FactorStorage, Place, Precision};
use serde_json::json;

use crate::outcome::Outcome;
use crate::program::{Detail, Told};
use crate::reduce::memory::MemoryArguments;
use crate::reduce::part::default_output;
use crate::reduce::part::files::{PartArguments, PartFiles};
use crate::reduce::ranks::RanksArguments;
use dcb_reducer::error::Error;
use dcb_reducer::forecast;
use dcb_reducer::mode_selection::ModeOptions;
use dcb_reducer::resources::forecast::Forecast;
use dcb_reducer::resources::machine_speed::MachineSpeed;
use dcb_reducer::resources::memory_limit::MemoryLimit;

/// Component to plan for.
#[derive(Debug, Args)]
pub struct PlanArguments {
    /// Stiffness matrix: Matrix Market (.mtx, .mtx.gz) or another program's; FILE#NAME picks one of several.
    #[arg(value_name = "PART.mtx")]
    pub stiffness: PathBuf,
    #[command(flatten)]
    pub modes: ModeOptions,
    #[command(flatten)]
    pub part: PartArguments,
    #[command(flatten)]
    pub memory: MemoryArguments,
    #[command(flatten)]
    pub ranks: RanksArguments,
    /// As JSON; memory in bytes, time in seconds.
    #[arg(long)]
    pub json: bool,
}

pub fn run(arguments: &PlanArguments, detail: Detail) -> Result<Outcome, Error> {
    let mut limit = (arguments.memory).limit(&default_output(&arguments.stiffness));
    arguments.ranks.enter(&arguments.memory, &mut limit)?;
    let files = PartFiles::of(&arguments.stiffness, &arguments.part)?;
    let component = files.read(limit.bytes, Told::Nothing)?;
    let modes = arguments.modes.request().selection(&component.units.time)?;
    let forecast =
        forecast(&component, modes).map_err(|error| error.naming_the_file(&files.files))?;
    let forecast = limit.fitted(forecast);
    let speed = MachineSpeed::measure();
    let name = arguments.stiffness.display();
    Ok(Outcome::done(match arguments.json {
        false => {
            let verdict = format!("{name}: {}\n", verdict(&forecast, &limit, speed));
            match detail {
                Detail::Verdict => {
                    verdict + "-v lists sizes, operations and the memory of each stage\n"
                }
                Detail::Tables => verdict + &text(&forecast, &limit, speed),
            }
        }
        true => json(&forecast, &limit, speed).to_string() + "\n",
    }))
}

/// One line: what a reduction will take, or why it will be refused.
fn verdict(forecast: &Forecast, limit: &MemoryLimit, speed: MachineSpeed) -> String {
    let size = format!(
        "{} degrees of freedom, {} modes",
        forecast.dofs, forecast.modes
    );
    match limit.choose(forecast) {
        Ok(storage) => format!(
            "the reduction ({size}) takes about {} s within a factor of two, and {} of memory give or take a fifth; the factor will be kept {}",
            rounded(forecast.seconds(&storage, speed)),
            readable(forecast.peak_bytes(&storage)),
            described(&storage)
        ),
        Err(error) => format!("the reduction ({size}) will be refused: {error}"),
    }
}

/// How a factor is kept, in words.
pub fn described(storage: &FactorStorage) -> String {
    match (&storage.place, storage.precision) {
        (Place::Memory, Precision::Double) => "in memory".into(),
        (Place::Memory, Precision::Single) => "in memory in single precision".into(),
        (Place::Disk { folder }, _) => format!("on disk in {}", folder.display()),
        #[cfg(feature = "ranks")]
        (Place::Ranks(run), _) => format!("by {} MPI process(es)", run.ranks),
    }
}

/// The forecast for people.
pub fn text(forecast: &Forecast, limit: &MemoryLimit, speed: MachineSpeed) -> String {
    let chosen = limit.choose(forecast);
    let storage = match &chosen {
        Ok(storage) => storage.clone(),
        Err(_) => limit.candidates().swap_remove(0),
    };
    let mut text = String::new();
    let mut line = |what: &str, value: String| {
        let _ = writeln!(text, "  {what:<34} {value}");
    };
    for (what, value) in sizes(forecast, &storage) {
        line(what, value);
    }
    for stage in forecast.stages(&storage) {
        line(
            &format!("memory in stage {}", stage.stage.name()),
            readable(stage.bytes),
        );
    }
    line(
        "largest memory",
        format!(
            "{}, give or take a fifth",
            readable(forecast.peak_bytes(&storage))
        ),
    );
    line(
        "time after the ordering",
        format!(
            "{} s, within a factor of two ({:.0} billion operations and {:.0} GB a second here)",
            rounded(forecast.seconds(&storage, speed)),
            speed.flops / 1e9,
            speed.bandwidth / 1e9
        ),
    );
    if let Some(bytes) = limit.bytes {
        line("memory allowed", readable(bytes));
    }
    match chosen {
        Ok(storage) => line("the factor will be kept", described(&storage)),
        Err(error) => line("the reduction will be refused", error.to_string()),
    }
    text
}

/// Sizes that are known before anything is computed.
fn sizes(forecast: &Forecast, storage: &FactorStorage) -> [(&'static str, String); 11] {
    let million = |count: usize| match count {
        0..100_000 => count.to_string(),
        _ => format!("{:.3} million", count as f64 / 1e6),
    };
    let guess = match forecast.modes_are_assumed {
        true => " assumed, --max-frequency decides",
        false => "",
    };
    let stored = million(forecast.stored_entries);
    let scratch = readable(forecast.scratch_bytes());
    [
        ("degrees of freedom", forecast.dofs.to_string()),
        (
            "entries of the stiffness matrix",
            million(forecast.stiffness_entries),
        ),
        ("entries of the mass matrix", million(forecast.mass_entries)),
        ("modes", format!("{}{guess}", forecast.modes)),
        (
            "attachment columns",
            forecast.attachment_columns.to_string(),
        ),
        (
            "columns of the Krylov basis",
            forecast.basis_columns().to_string(),
        ),
        (
            "entries of the factor",
            format!("{}, {stored} stored", million(forecast.factor_entries)),
        ),
        (
            "operations of a factorization",
            format!("{} billion", four_digits(forecast.flops / 1e9)),
        ),
        ("memory of the matrices", readable(forecast.matrix_bytes())),
        (
            "memory of the factor",
            readable(forecast.factor_bytes(storage)),
        ),
        (
            "memory to compute it",
            format!("{scratch} with {} thread(s)", forecast.threads),
        ),
    ]
}

/// Two digits are more than the forecast is worth.
fn rounded(seconds: f64) -> String {
    match seconds {
        s if s < 9.95 => format!("{:.1}", s.max(0.1)),
        s => format!("{s:.0}"),
    }
}

fn json(forecast: &Forecast, limit: &MemoryLimit, speed: MachineSpeed) -> serde_json::Value {
    let costs = |storage: &FactorStorage| {
        let stages: serde_json::Map<_, _> = forecast
            .stages(storage)
            .into_iter()
            .map(|stage| (stage.stage.name().to_owned(), json!(stage.bytes)))
            .collect();
        json!({
            "factor": described(storage),
            "factor_bytes": forecast.factor_bytes(storage),
            "peak_bytes": forecast.peak_bytes(storage),
            "stage_bytes": stages,
            "seconds": forecast.seconds(storage, speed),
            "fits": limit.allows(forecast, storage),
        })
    };
    let chosen = limit.choose(forecast);
    json!({
        "sizes": forecast,
        "matrix_bytes": forecast.matrix_bytes(),
        "scratch_bytes": forecast.scratch_bytes(),
        "memory_bytes": limit.bytes,
        "choices": limit.candidates().iter().map(costs).collect::<Vec<_>>(),
        "chosen": chosen.as_ref().ok().map(described),
        "refusal": chosen.as_ref().err().map(ToString::to_string),
        "operations_per_second": speed.flops,
        "bytes_per_second": speed.bandwidth,
    })
}
