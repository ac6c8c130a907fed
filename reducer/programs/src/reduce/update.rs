//! `reduce update`: a superelement beside measured modes, and one that takes over what was measured.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use dcb_formats::Superelement;
use dcb_formats::component_files::{stem, with_ending};
use dcb_formats::dcb::{Contents, SuperelementFile, WriteOptions, write_superelement};
use dcb_formats::measured::{MeasuredModes, read_measured};
use dcb_formats::output::{Replace, check_output, is_same_file};
use dcb_formats::units::{hertz, hertz_unit, si_factor};
use dcb_reducer::error::{CommandRefusal, Error, Occupied};
use dcb_superelement::measured::{Correlation, Measured, SAME_FREQUENCY, SAME_SHAPE};
use dcb_workflow::file_form::FileForm;
use serde_json::json;

use crate::outcome::Outcome;
use crate::program::{CommonArguments, Detail};
use crate::reduce::when_interrupted;

/// Columns of the MAC table, at most, where -v doesn't ask for all.
const LISTED: usize = 12;

/// Measured modes, and what to do with them.
#[derive(Debug, Args)]
pub(crate) struct UpdateArguments {
    /// Superelement of the part that was measured.
    #[arg(value_name = "PART.dcb.h5")]
    file: PathBuf,
    /// Modes of the free part: a CSV table of frequencies, damping and shapes (docs/measured.md).
    #[arg(long, value_name = "MODES.csv")]
    measured: PathBuf,
    /// Take over damping, frequencies or both; without it nothing is written.
    #[arg(long, value_name = "WHAT", value_enum, value_delimiter = ',')]
    replace: Vec<What>,
    /// Output [default: PART.updated.dcb.h5].
    #[arg(long, short, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Replace an existing output.
    #[arg(long)]
    force: bool,
    #[command(flatten)]
    form: FileForm,
}

/// What is taken over.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum What {
    /// Modal damping.
    Damping,
    /// Modal frequencies; bounds of errors, which are those of the computed ones, go.
    Frequencies,
}

impl What {
    fn measured(self) -> Measured {
        match self {
            Self::Damping => Measured::Damping,
            Self::Frequencies => Measured::Frequencies,
        }
    }

    fn name(self) -> &'static str {
        match self {
            Self::Damping => "damping",
            Self::Frequencies => "frequencies",
        }
    }
}

pub(crate) fn run(arguments: &UpdateArguments, common: &CommonArguments) -> Result<Outcome, Error> {
    let path = &arguments.file;
    let usual = || {
        with_ending(
            &stem(path).with_extension("").with_extension(""),
            ".updated.dcb.h5",
        )
    };
    let target = arguments.output.clone().unwrap_or_else(usual);
    let replace_existing = match arguments.force {
        true => Replace::Overwrite,
        false => Replace::Refuse,
    };
    if !arguments.replace.is_empty() {
        if is_same_file(path, &target) {
            return Err(CommandRefusal::WouldDestroy {
                path: target,
                role: Occupied::Superelement,
            }
            .into());
        }
        check_output(&target, replace_existing)?;
    }
    when_interrupted(|| "nothing was written".to_owned());
    let file = SuperelementFile::open(path)?;
    let element = file.superelement()?;
    let measured = read_measured(&arguments.measured, &element.units.time)?;
    let (fields, mesh) = (file.recovery()?, file.mesh()?);
    let told = |error| in_measured(&arguments.measured, error);
    let correlation = Correlation::of(&element, fields.as_ref(), &measured).map_err(told)?;
    let mut text = table(&element, &measured, &correlation);
    if let Some(mac) = &correlation.mac {
        let columns = match common.detail() {
            Detail::Tables => mac.ncols(),
            _ => mac.ncols().min(LISTED),
        };
        text += &mac_table(mac, columns);
    }
    if arguments.replace.is_empty() {
        text += "nothing was written; --replace damping, frequencies or both makes a superelement with what was measured\n";
        return Ok(Outcome::done(text));
    }
    let what: Vec<Measured> = arguments.replace.iter().map(|one| one.measured()).collect();
    let mut updated = correlation
        .applied(&element, &measured, &what)
        .map_err(told)?;
    record(&mut updated, &measured, &correlation, arguments);
    let is_kept = !arguments.form.without_fields;
    let contents = Contents {
        superelement: &updated,
        recovery: fields.as_ref().filter(|_| is_kept),
        mesh: mesh.as_ref().filter(|_| is_kept),
    };
    let options = WriteOptions {
        replace_existing,
        compression: arguments.form.compression(),
    };
    write_superelement(&target, &contents, &options)?;
    let names: Vec<&str> = arguments.replace.iter().map(|one| one.name()).collect();
    let _ = writeln!(
        text,
        "written  {} with measured {}",
        target.display(),
        names.join(" and ")
    );
    Ok(Outcome::done(text))
}

/// A refusal of what was measured names its file.
fn in_measured(path: &Path, error: dcb_superelement::Error) -> Error {
    match error {
        dcb_superelement::Error::Selection { message, .. } => {
            Error::File(dcb_formats::Error::File {
                path: path.to_owned(),
                message,
            })
        }
        other => other.into(),
    }
}

/// Says in the file where its modes come from.
fn record(
    updated: &mut Superelement,
    measured: &MeasuredModes,
    correlation: &Correlation,
    arguments: &UpdateArguments,
) {
    let names: Vec<&str> = arguments.replace.iter().map(|one| one.name()).collect();
    let modes: Vec<_> = (measured.modes.iter().zip(&correlation.pairs))
        .map(|(mode, pair)| {
            json!({ "frequency": mode.frequency, "damping": mode.damping, "mode": pair.map(|k| k + 1) })
        })
        .collect();
    let provenance = &mut updated.provenance;
    if !provenance.options.is_object() {
        provenance.options = json!({});
    }
    provenance.options["measured"] = json!({
        "file": measured.source.file_name, "replaced": names, "modes": modes,
    });
    provenance.inputs.push(measured.source.clone());
    if arguments.replace.contains(&What::Frequencies) {
        provenance.warnings.push(format!(
            "modal frequencies are those measured in {}: shapes, static flexibility and inertia are computed, and there are no bounds of errors",
            measured.source.file_name
        ));
    }
}

fn table(element: &Superelement, measured: &MeasuredModes, correlation: &Correlation) -> String {
    let time = &element.units.time;
    let seconds = si_factor(time).unwrap_or(1.0);
    let mut text = format!(
        "{}: {} measured modes beside {} computed ones of the free part\n{:>9}{:>17}{:>10}{:>17}{:>11}{:>8}{:>14}{:>14}\n",
        element.name,
        measured.modes.len(),
        element.mode_count(),
        "measured",
        format!("[{}]", hertz_unit(time)),
        "computed",
        format!("[{}]", hertz_unit(time)),
        "error",
        "MAC",
        "damping",
        "in the file",
    );
    for (m, (mode, pair)) in measured.modes.iter().zip(&correlation.pairs).enumerate() {
        let frequency = mode.frequency / seconds;
        let damping = mode
            .damping
            .map_or("-".to_owned(), |damping| format!("{damping:.5}"));
        let _ = write!(text, "{:>9}{frequency:>17.6}", m + 1);
        let _ = match pair {
            Some(k) => {
                let computed = hertz(element.modes.eigenvalues[*k], time);
                let mac = (correlation.mac.as_ref())
                    .map_or("-".to_owned(), |mac| format!("{:.4}", mac[(m, *k)]));
                writeln!(
                    text,
                    "{:>10}{computed:>17.6}{:>10.2}%{mac:>8}{damping:>14}{:>14.5}",
                    k + 1,
                    100.0 * (computed / frequency - 1.0),
                    element.modes.damping[*k],
                )
            }
            None => writeln!(
                text,
                "{:>10}{:>17}{:>11}{:>8}{damping:>14}",
                "none", "", "", ""
            ),
        };
    }
    let lonely = correlation
        .pairs
        .iter()
        .filter(|pair| pair.is_none())
        .count();
    if lonely > 0 {
        let limit = match correlation.mac {
            Some(_) => format!("a MAC of {SAME_SHAPE} or more"),
            None => format!("a frequency within {:.0} %", 100.0 * SAME_FREQUENCY),
        };
        let _ = writeln!(
            text,
            "{lonely} measured modes have no computed one with {limit}"
        );
    }
    text
}

fn mac_table(mac: &faer::Mat<f64>, columns: usize) -> String {
    let mut text = format!("{:>9}", "MAC");
    for k in 0..columns {
        let _ = write!(text, "{:>8}", k + 1);
    }
    text.push('\n');
    for m in 0..mac.nrows() {
        let _ = write!(text, "{:>9}", m + 1);
        for k in 0..columns {
            let _ = write!(text, "{:>8.3}", mac[(m, k)]);
        }
        text.push('\n');
    }
    if columns < mac.ncols() {
        let _ = writeln!(
            text,
            "{} more computed modes: -v shows them",
            mac.ncols() - columns
        );
    }
    text
}
