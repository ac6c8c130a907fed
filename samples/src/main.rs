//! Writes samples as the files `reduce` reads.

use std::io::{self, Write};
use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Parser, Subcommand, ValueEnum};
use dcb_samples::catalogue::{CATALOGUE, Sample, find};
use dcb_samples::{UnitScale, in_units, write};

/// Small flexible components to try the reducer with.
#[derive(Parser)]
#[command(name = "samples", version)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

#[derive(Subcommand)]
enum Command {
    /// Name and describe every sample.
    List,
    /// Write one sample: stiffness, mass, component masses if it has them, and the mesh JSON.
    Write {
        /// Name, as `list` shows it.
        name: String,
        /// Folder, made if needed.
        #[arg(long)]
        out: PathBuf,
        /// Stem of the file names; the sample's name by default.
        #[arg(long)]
        stem: Option<String>,
        /// Refinement, as `list` explains it.
        #[arg(long)]
        refinement: Option<u32>,
        /// Unit system.
        #[arg(long, value_enum, default_value = "m-kg-s")]
        units: UnitSystem,
    },
}

#[derive(Clone, Copy, ValueEnum)]
enum UnitSystem {
    /// SI.
    #[value(name = "m-kg-s")]
    MKgS,
    /// Millimetre, tonne, second.
    #[value(name = "mm-t-s")]
    MmTS,
}

fn main() -> ExitCode {
    match run(Cli::parse().command) {
        Ok(text) => {
            // A reader that closed the pipe early has what it wanted.
            let _ = io::stdout().write_all(text.as_bytes());
            ExitCode::SUCCESS
        }
        Err(message) => {
            eprintln!("{message}");
            ExitCode::from(2)
        }
    }
}

/// Text to print, or why there is none.
fn run(command: Command) -> Result<String, String> {
    match command {
        Command::List => Ok(CATALOGUE.iter().map(describe).collect()),
        Command::Write {
            name,
            out,
            stem,
            refinement,
            units,
        } => {
            let sample = find(&name).ok_or_else(|| {
                format!("no sample is called {name}; `samples list` names them all")
            })?;
            if refinement.is_some() && sample.refinement.is_none() {
                return Err(format!("{name} has no refinement; leave --refinement out"));
            }
            let component = sample.make(refinement);
            let component = match units {
                UnitSystem::MKgS => component,
                UnitSystem::MmTS => in_units(&component, &UnitScale::mm_t_s()),
            };
            let stem = stem.as_deref().unwrap_or(&name);
            let paths = write(&component, &out, stem).map_err(|error| error.to_string())?;
            let files: String = paths
                .iter()
                .map(|path| format!("{}\n", path.display()))
                .collect();
            Ok(format!(
                "{} nodes, {} dofs\n{files}",
                component.mesh.node_count(),
                component.dofs.len()
            ))
        }
    }
}

fn describe(sample: &Sample) -> String {
    let refinement = sample
        .refinement
        .map_or(String::new(), |(meaning, default)| {
            format!(" [--refinement: {meaning}; default {default}]")
        });
    format!("{:<22} {}{refinement}\n", sample.name, sample.description)
}
