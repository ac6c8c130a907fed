//! Manifest of a batch, as the user writes it.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use dcb_formats::component_files::stem;
use dcb_formats::description::without_comments;
use dcb_formats::snapshot::read_small;
use dcb_formats::terminal::{abridged, shortened};
use schemars::JsonSchema;
use serde::Deserialize;
use serde_json::{Map, Value};

use crate::file_form::FileForm;
use crate::siblings::SiblingArguments;
use dcb_reducer::mode_selection::ModeOptions;
use dcb_reducer::pipeline::reduction::Reduction;
use dcb_reducer::resources::memory_limit::FactorChoice;

/// Parts and what they have in common.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
struct ManifestFile {
    /// Options of every part that doesn't say otherwise.
    #[serde(default)]
    defaults: Map<String, Value>,
    /// Parts, each with its options.
    parts: Vec<Map<String, Value>>,
}

/// A part and how it is reduced; the options are those of `reduce PART.mtx`.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PartEntry {
    /// Stiffness matrix, Matrix Market (.mtx or .mtx.gz). Paths are taken from the manifest's folder.
    pub part: PathBuf,
    /// Name of the superelement, NAME.dcb.h5; without it the part's.
    pub name: Option<String>,
    /// Modes.
    #[serde(flatten)]
    pub modes: ModeOptions,
    /// Further options that decide the result.
    #[serde(flatten)]
    pub reduction: Reduction,
    /// Files beside the stiffness matrix.
    #[serde(flatten)]
    pub siblings: SiblingArguments,
    /// How the file is written.
    #[serde(flatten)]
    pub form: FileForm,
    /// Where the factor is kept.
    pub factor: Option<FactorChoice>,
}

/// A part that was checked: its name is unique, and its paths lead somewhere from here.
#[derive(Clone, Debug, PartialEq)]
pub struct Part {
    /// Name of the superelement.
    pub name: String,
    /// Options that are asked for.
    pub entry: PartEntry,
}

/// Bytes of a manifest: some hundred thousand parts.
const LONGEST_MANIFEST: u64 = 1 << 28;

/// Reads a manifest.
///
/// # Errors
/// Defect of a manifest, with its line or JSON path.
pub fn read_manifest(path: &Path) -> Result<Vec<Part>, dcb_formats::Error> {
    let (bytes, _) = read_small(path, LONGEST_MANIFEST)?;
    let syntax = |error: serde_json::Error| dcb_formats::Error::Line {
        path: path.to_owned(),
        line: error.line() as u64,
        message: told(&error),
    };
    let text = without_comments(&bytes, path)?;
    let file: ManifestFile = serde_json::from_slice(&text).map_err(syntax)?;
    let folder = path.parent().unwrap_or(Path::new(""));
    parts(file, folder).map_err(|(location, message)| dcb_formats::Error::Location {
        path: path.to_owned(),
        location,
        message,
    })
}

/// Message of the parser, which may quote the file.
fn told(error: &serde_json::Error) -> String {
    abridged(&error.to_string(), 400).into_owned()
}

/// A JSON path and what is wrong there.
type Fault = (String, String);

fn parts(file: ManifestFile, folder: &Path) -> Result<Vec<Part>, Fault> {
    let known = known_keys();
    check_keys("defaults", &file.defaults, &known)?;
    for key in ["part", "name"] {
        if file.defaults.contains_key(key) {
            let message = "belongs to one of the parts, not to all of them".to_owned();
            return Err((format!("defaults.{key}"), message));
        }
    }
    if file.parts.is_empty() {
        let message = r#"is empty; expected parts such as {"part": "rod.mtx", "modes": 20}"#;
        return Err(("parts".into(), message.into()));
    }
    let mut names = BTreeSet::new();
    let mut parts = Vec::with_capacity(file.parts.len());
    for (index, own) in file.parts.into_iter().enumerate() {
        let place = format!("parts[{index}]");
        check_keys(&place, &own, &known)?;
        let entry: PartEntry = serde_json::from_value(merged(&file.defaults, own).into())
            .map_err(|error| (place.clone(), told(&error)))?;
        let part =
            checked(entry, folder).map_err(|(key, message)| (place.clone() + key, message))?;
        if !names.insert(part.name.clone()) {
            let message = format!(
                "is named {:?}, as an earlier part is; give each its own \"name\"",
                part.name
            );
            return Err((place, message));
        }
        parts.push(part);
    }
    Ok(parts)
}

/// The keys of a part.
fn known_keys() -> Vec<String> {
    let schema = schemars::schema_for!(PartEntry);
    let properties = schema.get("properties").and_then(Value::as_object);
    properties
        .into_iter()
        .flatten()
        .map(|(key, _)| key.clone())
        .collect()
}

/// Each key by itself, so that the message can say which.
fn check_keys(place: &str, options: &Map<String, Value>, known: &[String]) -> Result<(), Fault> {
    for (key, value) in options {
        if !known.contains(key) {
            let (key, known) = (shortened(key), known.join("`, `"));
            let message = format!("unknown field `{key}`, expected one of `{known}`");
            return Err((format!("{place}.{key}"), message));
        }
        let mut alone = Map::from_iter([("part".to_owned(), Value::from("part.mtx"))]);
        alone.insert(key.clone(), value.clone());
        serde_json::from_value::<PartEntry>(alone.into())
            .map_err(|error| (format!("{place}.{}", shortened(key)), told(&error)))?;
    }
    Ok(())
}

/// A part's own options over those of all; a limit of the modes is replaced by either kind of limit.
fn merged(defaults: &Map<String, Value>, own: Map<String, Value>) -> Map<String, Value> {
    let mut all = defaults.clone();
    let is_given = |key: &str| own.get(key).is_some_and(|value| !value.is_null());
    if is_given("modes") || is_given("max_frequency") {
        all.remove("modes");
        all.remove("max_frequency");
    }
    all.extend(own);
    all
}

fn checked(mut entry: PartEntry, folder: &Path) -> Result<Part, (&'static str, String)> {
    if entry.part.file_name().is_none() {
        return Err((".part", "names no file; expected PART.mtx".into()));
    }
    if entry.modes.modes.is_some() && entry.modes.max_frequency.is_some() {
        let message = "stands beside modes; give one of them".to_owned();
        return Err((".max_frequency", message));
    }
    if let Some(hertz) = (entry.modes.max_frequency).filter(|hertz| *hertz <= 0.0) {
        return Err((".max_frequency", format!("is {hertz}, expected Hz above 0")));
    }
    let name = match &entry.name {
        Some(name) => name.clone(),
        None => {
            let stem = stem(&entry.part);
            stem.file_name()
                .map_or(String::new(), |name| name.to_string_lossy().into_owned())
        }
    };
    let is_unusable = |c: char| c.is_control() || matches!(c, '/' | '\\');
    if name.is_empty() || name.starts_with('.') || name.contains(is_unusable) {
        let message = format!(
            "is {name:?}, which can't be the name of a file; it must not be empty, begin with a dot or contain slashes"
        );
        return Err((".name", message));
    }
    let mut paths = [
        Some(&mut entry.part),
        entry.siblings.mass.as_mut(),
        entry.siblings.mesh.as_mut(),
        entry.siblings.boundary.as_mut(),
    ];
    for path in paths.iter_mut().flatten() {
        **path = folder.join(&**path);
    }
    entry.reduction.memory.factor = entry.factor.unwrap_or_default();
    Ok(Part { name, entry })
}

/// JSON schema of a manifest.
pub fn batch_schema() -> Value {
    let mut generator = schemars::generate::SchemaSettings::draft2020_12().into_generator();
    let entry = generator.subschema_for::<PartEntry>();
    let mut schema = generator.into_root_schema_for::<ManifestFile>().to_value();
    schema["title"] = "Manifest of `reduce batch`".into();
    schema["properties"]["parts"]["items"] = entry.to_value();
    schema["properties"]["parts"]["minItems"] = 1.into();
    // The options of a part, without what each part has by itself.
    let mut options = schema["$defs"]["PartEntry"].clone();
    if let Some(properties) = options["properties"].as_object_mut() {
        properties.remove("part");
        properties.remove("name");
    }
    if let Some(options) = options.as_object_mut() {
        options.remove("required");
        options.remove("description");
    }
    let description = schema["properties"]["defaults"]["description"].take();
    options["description"] = description;
    schema["properties"]["defaults"] = options;
    schema
}
