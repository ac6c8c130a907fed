//! `reduce assemble`: superelements, rigid bodies, joints and springs to one superelement.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use clap::Args;
use dcb_assembly::{
    Assembled, AssemblyReport, InsideChoice, KeptModes, LooseMotions, ModeBound, Options,
};
use dcb_formats::assembly::Assembly;
use dcb_formats::component_files::{stem, with_ending};
use dcb_formats::dcb::{Contents, WriteOptions, write_superelement};
use dcb_formats::output::{Replace, check_output, is_same_file};
use dcb_formats::scene::BodyKind;
use dcb_formats::units::{hertz, hertz_unit};
use dcb_reducer::ModeSelection;
use dcb_reducer::error::{CommandRefusal, Error, Occupied};
use dcb_reducer::mode_selection::ModeOptions;
use dcb_superelement::LOSS_FACTOR;
use dcb_workflow::file_form::FileForm;
use serde_json::json;

use crate::outcome::Outcome;
use crate::program::{CommonArguments, Detail};
use crate::reduce::superelement::inspect::{interface_table, mass_lines};
use crate::reduce::when_interrupted;

/// Modes listed in a report.
const LISTED: usize = 10;

/// Assembly to make.
#[derive(Debug, Args)]
pub(crate) struct AssembleArguments {
    /// Assembly: bodies, joints, springs, and the interfaces of the whole (docs/assemblies.md).
    #[arg(value_name = "ASSEMBLY.json")]
    file: PathBuf,
    /// Output [default: ASSEMBLY.dcb.h5].
    #[arg(long, short, value_name = "FILE")]
    output: Option<PathBuf>,
    #[command(flatten)]
    modes: ModeOptions,
    /// Accept motions without stiffness beside the rigid ones; they become modes of frequency zero.
    #[arg(long)]
    allow_loose: bool,
    /// Replace an existing output.
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    form: FileForm,
}

pub(crate) fn run(
    arguments: &AssembleArguments,
    common: &CommonArguments,
) -> Result<Outcome, Error> {
    let path = &arguments.file;
    let usual = || with_ending(&stem(path).with_extension(""), ".dcb.h5");
    let target = arguments.output.clone().unwrap_or_else(usual);
    let replace_existing = match arguments.force {
        true => Replace::Overwrite,
        false => Replace::Refuse,
    };
    let assembly = Assembly::read(path)?;
    refuse_input_as_output(&assembly, path, &target)?;
    check_output(&target, replace_existing)?;
    when_interrupted(|| "nothing was written".to_owned());
    let request = arguments.modes.request();
    let modes = match request.selection(&assembly.scene.units.time)? {
        ModeSelection::Lowest(count) => KeptModes::Lowest(count),
        ModeSelection::Below { eigenvalue } | ModeSelection::BelowAtMost { eigenvalue, .. } => {
            KeptModes::Below(eigenvalue)
        }
    };
    let inside = match arguments.form.without_fields {
        true => InsideChoice::LeftOut,
        false => InsideChoice::Kept,
    };
    let options = Options {
        modes,
        loose: match arguments.allow_loose {
            true => LooseMotions::Allow,
            false => LooseMotions::Refuse,
        },
    };
    let told = |error| in_file(path, error);
    let loaded = dcb_assembly::load(&assembly, inside).map_err(told)?;
    let mut assembled = dcb_assembly::assemble(&assembly, loaded, &options).map_err(told)?;
    describe(&mut assembled, arguments, path);
    let contents = Contents {
        superelement: &assembled.superelement,
        recovery: assembled.recovery.as_ref(),
        mesh: assembled.mesh.as_ref(),
    };
    let write_options = WriteOptions {
        replace_existing,
        compression: arguments.form.compression(),
    };
    write_superelement(&target, &contents, &write_options)?;
    for warning in assembled.report.warnings() {
        common.told().say("warning", &warning);
    }
    Ok(Outcome::done(summary(&assembled, &target, common.detail())))
}

/// The assembly's file and its superelements stay.
fn refuse_input_as_output(assembly: &Assembly, path: &Path, target: &Path) -> Result<(), Error> {
    let files = assembly
        .scene
        .bodies
        .values()
        .filter_map(|body| match &body.kind {
            BodyKind::Superelement(of) => Some(assembly.scene.resolve(&of.file)),
            BodyKind::Rigid(_) => None,
        });
    let mut inputs = files.chain([path.to_owned()]);
    match inputs.any(|input| is_same_file(&input, target)) {
        false => Ok(()),
        true => Err(CommandRefusal::WouldDestroy {
            path: target.to_owned(),
            role: Occupied::Component,
        }
        .into()),
    }
}

fn in_file(path: &Path, error: dcb_assembly::Error) -> Error {
    match error {
        dcb_assembly::Error::File(error) => error.into(),
        dcb_assembly::Error::Superelement(error) => error.into(),
        dcb_assembly::Error::NotFinite { what } => Error::NotFinite { what },
        other => Error::InScene {
            path: path.to_owned(),
            message: other.to_string(),
        },
    }
}

/// Options of the command for the file's provenance.
fn describe(assembled: &mut Assembled, arguments: &AssembleArguments, path: &Path) {
    let mut options = json!({
        "assembly": path.file_name().map(|name| name.to_string_lossy()),
        "modes": arguments.modes.modes,
        "max_frequency": arguments.modes.max_frequency,
        "allow_loose": arguments.allow_loose,
    });
    arguments.form.say(&mut options);
    assembled.superelement.provenance.options = options;
}

fn summary(assembled: &Assembled, target: &Path, detail: Detail) -> String {
    let element = &assembled.superelement;
    let report = &assembled.report;
    let mut text = verdict(element, report);
    text += &mass_lines(element);
    text += &interface_table(element);
    if detail != Detail::Verdict {
        text += &bounds_table(element, report);
    }
    let _ = writeln!(text, "written  {}", target.display());
    text
}

/// What the assembly is, and how far its frequencies may be off.
fn verdict(element: &dcb_formats::Superelement, report: &AssemblyReport) -> String {
    let time = &element.units.time;
    let mut text = String::new();
    let support = if report.is_free { "free" } else { "held" };
    let _ = write!(
        text,
        "{}: {} bodies as one, {support}; {} modes",
        element.name,
        report.parts.len(),
        element.mode_count()
    );
    let elastic: Vec<f64> = element
        .modes
        .eigenvalues
        .iter()
        .copied()
        .filter(|square| *square > 0.0)
        .collect();
    if let (Some(first), Some(last)) = (elastic.first(), elastic.last()) {
        let unit = hertz_unit(time);
        let _ = write!(
            text,
            " from {:.4} to {:.4} {unit}",
            hertz(*first, time),
            hertz(*last, time)
        );
    }
    text.push('\n');
    text += &accuracy(report, time);
    text
}

/// Which part limits the accuracy, and how many modes it would need.
pub(crate) fn accuracy(report: &AssemblyReport, time: &str) -> String {
    let Some(error) = report.frequency_error() else {
        return String::new();
    };
    let mut text = String::new();
    let _ = writeln!(
        text,
        "accuracy the parts' own truncation makes no frequency more than {} too high (bound over all modes of the assembly)",
        percent(error)
    );
    if let Some(responses) = &report.responses {
        let _ = writeln!(
            text,
            "         it changes responses at the interfaces by up to {:.1e} of their size up to {:.4} {} (estimate, loss factor {LOSS_FACTOR})",
            responses.error,
            hertz(responses.end, time),
            hertz_unit(time)
        );
    }
    let largest = report
        .parts
        .iter()
        .filter(|part| part.largest_share.is_some_and(|share| share > 0.0));
    let largest = largest.max_by(|a, b| {
        a.largest_share
            .partial_cmp(&b.largest_share)
            .unwrap_or(std::cmp::Ordering::Equal)
    });
    if let Some(part) = largest {
        let share = part.largest_share.unwrap_or(0.0);
        let _ = write!(
            text,
            "limit    {:?} with {} modes: up to {} of a frequency",
            part.name,
            part.modes,
            percent(share)
        );
        match part.modes_for_1e_4 {
            Some(modes) => {
                let _ = writeln!(
                    text,
                    "; about {modes} modes would make that 0.01 % (estimate)"
                );
            }
            None => text.push('\n'),
        }
    }
    text
}

fn percent(value: f64) -> String {
    match value {
        infinite if !infinite.is_finite() => "an unknown amount".to_owned(),
        small if small < 1e-6 => format!("{:.1e} %", 100.0 * small),
        _ => format!("{:.2} %", 100.0 * value).replace("0.00 %", "0.01 %"),
    }
}

/// Frequencies with their bounds and the part that limits each.
pub(crate) fn bounds_table(element: &dcb_formats::Superelement, report: &AssemblyReport) -> String {
    let Some(modes) = &report.modes else {
        return String::new();
    };
    let time = &element.units.time;
    let mut text = String::new();
    let heading = format!("frequency [{}]", hertz_unit(time));
    let _ = writeln!(
        text,
        "mode   {heading:>20}   {:>20}   limited by",
        "not below"
    );
    let loose = element.mode_count().saturating_sub(modes.len());
    for (k, mode) in modes.iter().enumerate().take(LISTED) {
        let _ = writeln!(
            text,
            "{:4}   {:20.9}   {:20.9}   {}",
            loose + k + 1,
            hertz(mode.reduced, time),
            hertz(mode.lower, time),
            limiting(mode, report)
        );
    }
    let hidden = modes.len().saturating_sub(LISTED);
    if hidden > 0 {
        let _ = writeln!(text, "   …   {hidden} more");
    }
    text
}

fn limiting(mode: &ModeBound, report: &AssemblyReport) -> String {
    let whole: f64 = mode.shares.iter().sum();
    let largest = (0..mode.shares.len()).max_by(|a, b| mode.shares[*a].total_cmp(&mode.shares[*b]));
    match largest {
        Some(at) if whole > 0.0 && whole.is_finite() => {
            let name = report.parts.get(at).map_or("?", |part| part.name.as_str());
            format!("{name} ({:.0} %)", 100.0 * mode.shares[at] / whole)
        }
        _ => "-".to_owned(),
    }
}
