//! The command lines of a part's processes.

use std::ffi::OsString;
use std::path::Path;
use std::process::{Command, Stdio};

use super::Batch;
use super::manifest::{Enrichment, Factor, Part};

/// Bytes of a kilobyte.
const KILOBYTE: u64 = 1024;

/// `reduce` without what depends on the batch: everything that decides the superelement.
pub fn options(part: &Part) -> Vec<OsString> {
    let entry = &part.entry;
    let mut options = files_and_modes(part);
    let mut say = |option: &str, value: String| {
        options.extend([OsString::from(option), OsString::from(value)]);
    };
    if let Some(count) = entry.interface_modes {
        say("--interface-modes", count.to_string());
    }
    if !entry.enrich.is_empty() {
        let names = entry.enrich.iter().map(|name| match name {
            Enrichment::Spin => "spin",
            Enrichment::Loads => "loads",
            Enrichment::Krylov => "krylov",
        });
        say("--enrich", names.collect::<Vec<_>>().join(","));
    }
    let flags = [
        ("--without-fields", entry.without_fields),
        ("--compress", entry.compress),
        ("--allow-grounded", entry.allow_grounded),
        ("--allow-loose", entry.allow_loose),
    ];
    options.extend(
        flags
            .iter()
            .filter(|flag| flag.1)
            .map(|flag| OsString::from(flag.0)),
    );
    options.extend([OsString::from("--"), entry.part.clone().into()]);
    options
}

/// Makes a part's superelement, and says in a file what that took.
///
/// # Errors
/// This program's own file isn't known.
pub fn reduce(
    batch: &Batch,
    part: &Part,
    target: &Path,
    timings: &Path,
) -> std::io::Result<Command> {
    let mut command = Command::new(std::env::current_exe()?);
    command
        .args(["--force", "--output"])
        .arg(target)
        .arg("--timings")
        .arg(timings)
        .args(resources(batch));
    if let Some(cache) = &batch.cache {
        command.arg(crate::cli_cache::option(cache.folder()));
        command.arg("--cache-limit").arg(kilobytes(cache.limit()));
    }
    command.args(options(part));
    Ok(command)
}

/// Forecasts what making a part takes.
///
/// # Errors
/// This program's own file isn't known.
pub fn plan(batch: &Batch, part: &Part) -> std::io::Result<Command> {
    let mut command = Command::new(std::env::current_exe()?);
    command
        .args(["plan", "--json"])
        .args(resources(batch))
        .args(files_and_modes(part))
        .arg("--")
        .arg(&part.entry.part)
        .stdin(Stdio::null());
    Ok(command)
}

fn files_and_modes(part: &Part) -> Vec<OsString> {
    let entry = &part.entry;
    let mut options = Vec::new();
    let mut say = |option: &str, value: OsString| options.extend([OsString::from(option), value]);
    for (option, path) in [
        ("--mass", &entry.mass),
        ("--mesh", &entry.mesh),
        ("--boundary", &entry.boundary),
    ] {
        if let Some(path) = path {
            say(option, path.into());
        }
    }
    if let Some(count) = entry.modes {
        say("--modes", count.to_string().into());
    }
    if let Some(hertz) = entry.max_frequency {
        say("--max-frequency", hertz.to_string().into());
    }
    if let Some(factor) = entry.factor {
        let name = match factor {
            Factor::Auto => "auto",
            Factor::Memory => "memory",
            Factor::Single => "single",
            Factor::Disk => "disk",
        };
        say("--factor", name.into());
    }
    options
}

fn resources(batch: &Batch) -> Vec<OsString> {
    let mut options = vec![
        OsString::from("--threads"),
        batch.threads.to_string().into(),
        OsString::from("--scratch"),
        batch.scratch.as_ref().unwrap_or(&batch.folder).into(),
    ];
    if let Some(bytes) = batch.memory {
        options.extend([OsString::from("--memory"), kilobytes(bytes).into()]);
    }
    options
}

/// A size as the options take it.
fn kilobytes(bytes: u64) -> String {
    format!("{}K", (bytes / KILOBYTE).max(1))
}
