//! `reduce export`: a superelement as other programs read it.

use std::path::PathBuf;

use clap::Args;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use dcb_export::{Axes, Export, Source, TARGETS, Target};
use dcb_formats::output::Replace;
use dcb_reducer::error::Error;

use crate::outcome::Outcome;

/// Superelement to export, and for whom.
#[derive(Debug, Args)]
pub(crate) struct ExportArguments {
    /// Superelement.
    #[arg(value_name = "FILE.dcb.h5")]
    file: PathBuf,
    /// The program or format that it is for.
    #[arg(long, value_name = "TARGET", value_parser = target())]
    to: TargetArgument,
    /// Output [default: beside the superelement, with the target's ending].
    #[arg(long, short, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Where positions are counted from.
    #[arg(long, value_name = "ORIGIN", value_parser = axes(), default_value = "body")]
    axes: AxesArgument,
    /// Form of the file, where the target has several: nastran dmig or op4; sid vector or matrix [default: the first].
    #[arg(long, value_name = "FORM")]
    dialect: Option<String>,
    /// Replace existing files.
    #[arg(long)]
    force: bool,
}

/// A target by its name.
#[derive(Clone, Copy)]
struct TargetArgument(&'static Target);

impl std::fmt::Debug for TargetArgument {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.0.name)
    }
}

/// An origin by its name.
#[derive(Clone, Copy, Debug)]
struct AxesArgument(Axes);

fn target() -> impl TypedValueParser<Value = TargetArgument> {
    let choices = TARGETS.iter();
    let choices = choices.map(|target| PossibleValue::new(target.name).help(target.about));
    PossibleValuesParser::new(choices).try_map(|name| {
        Target::named(&name)
            .map(TargetArgument)
            .ok_or("no such target")
    })
}

fn axes() -> impl TypedValueParser<Value = AxesArgument> {
    let choices = [
        ("body", "the centre of mass"),
        ("component", "the component's origin"),
    ];
    let choices = choices.map(|(name, help)| PossibleValue::new(name).help(help));
    PossibleValuesParser::new(choices).map(|name| match name.as_str() {
        "component" => AxesArgument(Axes::Component),
        _ => AxesArgument(Axes::Body),
    })
}

pub(crate) fn run(arguments: &ExportArguments) -> Result<Outcome, Error> {
    let target = arguments.to.0;
    let replace = match arguments.force {
        true => Replace::Overwrite,
        false => Replace::Refuse,
    };
    let mut export = Export::to(target)
        .about(arguments.axes.0)
        .replacing(replace);
    if let Some(dialect) = &arguments.dialect {
        export = export.in_dialect(dialect)?;
    }
    let usual = || export.usual_output(&arguments.file);
    let output = arguments.output.clone().unwrap_or_else(usual);
    if arguments.output.is_none() && !arguments.force && output.exists() {
        // The usual name may be that of the user's own matrices or mesh.
        return Err(dcb_formats::Error::File {
            path: output,
            message: "exists already; name another output with -o FILE, or replace it with --force"
                .into(),
        }
        .into());
    }
    let source = Source::open(&arguments.file)?;
    let written = export.write(&source, &output)?;
    Ok(Outcome::done(written.text))
}
