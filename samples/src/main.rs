//! Writes samples as the files `reduce` reads.

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{Parser, Subcommand, ValueEnum};
use dcb_samples::catalogue::{CATALOGUE, find};
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
    match Cli::parse().command {
        Command::List => {
            for sample in CATALOGUE {
                let refinement = sample
                    .refinement
                    .map_or(String::new(), |(meaning, default)| {
                        format!(" [--refinement: {meaning}; default {default}]")
                    });
                println!("{:<22} {}{refinement}", sample.name, sample.description);
            }
            ExitCode::SUCCESS
        }
        Command::Write {
            name,
            out,
            stem,
            refinement,
            units,
        } => {
            let Some(sample) = find(&name) else {
                eprintln!("no sample is called {name}; `samples list` names them all");
                return ExitCode::from(2);
            };
            if refinement.is_some() && sample.refinement.is_none() {
                eprintln!("{name} has no refinement; leave --refinement out");
                return ExitCode::from(2);
            }
            let component = sample.make(refinement);
            let component = match units {
                UnitSystem::MKgS => component,
                UnitSystem::MmTS => in_units(&component, &UnitScale::mm_t_s()),
            };
            match write(&component, &out, stem.as_deref().unwrap_or(&name)) {
                Ok(paths) => {
                    println!(
                        "{} nodes, {} dofs",
                        component.mesh.node_count(),
                        component.dofs.len()
                    );
                    for path in paths {
                        println!("{}", path.display());
                    }
                    ExitCode::SUCCESS
                }
                Err(error) => {
                    eprintln!("{error}");
                    ExitCode::from(2)
                }
            }
        }
    }
}
