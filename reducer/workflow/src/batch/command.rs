//! The command lines of a part's processes.

use std::ffi::OsString;
use std::path::Path;
use std::process::Command;

use serde::Serialize;
use serde_json::{Value, json};

use super::Batch;
use super::manifest::Part;

/// Bytes of a kilobyte.
const KILOBYTE: u64 = 1024;

/// Makes a part's superelement, and says in a file what that took.
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
        command.arg(crate::cache::folder::option(cache.folder()));
        command.arg("--cache-limit").arg(kilobytes(cache.limit()));
    }
    let entry = &part.entry;
    command
        .args(files_and_modes(part))
        .args(as_options(&entry.reduction))
        .args(as_options(&entry.form))
        .arg("--")
        .arg(&entry.part);
    Ok(command)
}

/// Forecasts what making a part takes.
pub fn plan(batch: &Batch, part: &Part) -> std::io::Result<Command> {
    let mut command = Command::new(std::env::current_exe()?);
    command
        .args(["plan", "--json"])
        .args(resources(batch))
        .args(files_and_modes(part))
        .arg("--")
        .arg(&part.entry.part);
    Ok(command)
}

fn files_and_modes(part: &Part) -> Vec<OsString> {
    let entry = &part.entry;
    let mut options = Vec::new();
    for (option, path) in [
        ("--mass", &entry.siblings.mass),
        ("--mesh", &entry.siblings.mesh),
        ("--boundary", &entry.siblings.boundary),
    ] {
        if let Some(path) = path {
            options.extend([OsString::from(option), path.into()]);
        }
    }
    if let Some(factor) = entry.factor {
        options.extend(as_options(&json!({ "factor": factor })));
    }
    options.extend(as_options(&entry.modes));
    options
}

/// Options of the command line, which have the names of keys of the manifest.
fn as_options(keys: &impl Serialize) -> Vec<OsString> {
    let value = serde_json::to_value(keys).unwrap_or_default();
    let mut options = Vec::new();
    for (key, value) in value.as_object().into_iter().flatten() {
        let text = match value {
            Value::Bool(true) => None,
            Value::Number(number) => Some(number.to_string()),
            Value::String(text) => Some(text.clone()),
            Value::Array(list) if !list.is_empty() => {
                let words: Vec<&str> = list.iter().filter_map(Value::as_str).collect();
                Some(words.join(","))
            }
            _ => continue,
        };
        options.push(format!("--{}", key.replace('_', "-")).into());
        options.extend(text.map(OsString::from));
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
